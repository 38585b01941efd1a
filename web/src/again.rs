//! A run from its beginning, on the way to an earlier moment.

use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::WebError;
use crate::run::{RunError, Simulated, Source, WebRun};

#[wasm_bindgen]
impl WebRun {
    /// The same run from its beginning. A simulation does again, each at its time, what was done to
    /// it, until something else is done; a recording is mapped with the settings that hold now.
    ///
    /// # Errors
    /// If the run is a real robot's, or something was done to it that cannot be done again.
    pub fn again(&self) -> Result<Self, WebError> {
        let source = match &self.source {
            Source::Simulation(sim) => Source::Simulation(Box::new(Simulated {
                expected: sim.expected,
                lesson: sim.lesson,
                ..Simulated::new(sim.experiment.again()?, sim.defaults.clone())
            })),
            Source::Recording(replay) => Source::Recording(Box::new(replay.again()?)),
            Source::Live(_) => return Err(RunError::Past.into()),
        };
        let mut again = Self::of(source);
        again.set_twin(self.session().twin().is_some());
        Ok(again)
    }
}
