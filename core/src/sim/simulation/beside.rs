//! A ring of sonars in addition to the sensor that gives the pose.
//!
//! Its noise comes from a random stream of its own, so the other sensor and the motion are the same
//! to the bit with and without it.

use rand_chacha::ChaCha8Rng;

use super::{Sensor, SensorModel, SimError, Simulation, Span, View};
use crate::robot::Scan;
use crate::sim::noise::stream;
use crate::sim::sensors::SonarModel;

/// Sonars in operation.
#[derive(Clone, Debug)]
pub(super) struct Beside {
    sonars: Sensor,
    rng: ChaCha8Rng,
    scan: Option<Scan>,
}

impl Beside {
    pub(super) fn step(&mut self, span: &Span, view: &View) {
        if let Some(scan) = self.sonars.step(span, view, &mut self.rng) {
            self.scan = Some(scan);
        }
    }
}

impl Simulation {
    /// Adds sonars to the robot, beside its sensor; `seed` is that of the simulation.
    ///
    /// # Errors    [`SimError`]: a figure is out of its range.
    pub fn put_sonars_beside(&mut self, model: &SonarModel, seed: u64) -> Result<(), SimError> {
        let mut sonars = Sensor::new(&SensorModel::Sonar(model.clone()))?;
        sonars.begin(self.seconds());
        self.beside = Some(Beside {
            sonars,
            rng: stream(seed, 3),
            scan: None,
        });
        Ok(())
    }

    /// The newest round of the sonars beside, returned once.
    pub fn take_scan_beside(&mut self) -> Option<Scan> {
        self.beside.as_mut()?.scan.take()
    }
}
