//! The drive controller on a test bench, for the page: a step and a load, with the controller and
//! without.

use serde::{Deserialize, Serialize};
use slamlab_core::robot::RobotModel;
use slamlab_core::sim::response::{LoadStep, Loop, ResponseSample, Trial};
use tsify::Tsify;

use crate::border::{Float64Array, WebError};

/// One in this many samples of the controller is drawn by the page.
const EVERY: usize = 10;

/// A trial on the bench.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct BenchTrial {
    /// Commanded speed as a fraction of the robot's highest.
    pub forward: f64,
    /// By what fraction the right motor's magnet is stronger than the controller believes.
    pub mismatch: f64,
    /// Pull back on the left track, N.
    pub pull: f64,
    /// When the pull begins, s.
    pub pull_at: f64,
    /// Duration of the trial, s.
    pub seconds: f64,
}

/// Time series of one trial, closed loop beside open loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct BenchResponse {
    /// Time, s.
    pub seconds: Float64Array,
    /// Commanded speed of the tracks, m/s.
    pub wished: Float64Array,
    /// Speeds of left and right track with the controller, then without, m/s: four consecutive
    /// series.
    pub speeds: Float64Array,
    /// Heading minus the commanded one with the controller, then without, rad.
    pub headings: Float64Array,
}

impl BenchResponse {
    /// # Errors    No controller can be designed for the robot, or its motors are invalid.
    pub(crate) fn of(robot: &RobotModel, ask: BenchTrial) -> Result<Self, WebError> {
        let mut trial = Trial::straight(robot, ask.forward * robot.max_speed, ask.seconds);
        trial.motors.right = trial.motors.right.with_stronger_magnet(ask.mismatch);
        trial.loads.push(LoadStep {
            at: ask.pull_at,
            left: ask.pull * robot.drive.metres_per_radian,
            right: 0.0,
        });
        let (closed, open) = (trial.run(Loop::Closed)?, trial.run(Loop::Open)?);
        let thin = |samples: &[ResponseSample], of: fn(&ResponseSample) -> f64| -> Vec<f64> {
            samples.iter().step_by(EVERY).map(of).collect()
        };
        let both = |of: fn(&ResponseSample) -> f64| [thin(&closed, of), thin(&open, of)];
        let ([left, open_left], [right, open_right]) =
            (both(|s| s.speeds[0]), both(|s| s.speeds[1]));
        Ok(Self {
            seconds: thin(&closed, |s| s.seconds).into(),
            wished: thin(&closed, |s| s.wished[0]).into(),
            speeds: [left, right, open_left, open_right].concat().into(),
            headings: both(|s| s.heading_error).concat().into(),
        })
    }
}
