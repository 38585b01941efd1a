//! Starts a run over, on the way back to an earlier moment.

use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::WebError;
use crate::run::{RunError, Simulated, Source, WebRun};

#[wasm_bindgen]
impl WebRun {
    /// The same run from its beginning. A simulation repeats the actions that were done to it, each
    /// at its time, until a new action is done; a recording is mapped with the present settings.
    ///
    /// # Errors
    /// If the run is a real robot's, or some action cannot be repeated.
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
