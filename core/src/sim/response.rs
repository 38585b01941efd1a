//! How motors respond, with and without the controller: step and disturbance responses as time
//! series.
//!
//! In: the robot's figures, its true motors, desired speeds, loads. Out: speeds, heading, voltages
//! and currents, one sample per period.
//!
//! 1. Closed: the controller assumes the robot's figures and sees the counts of its encoders.
//! 2. Open: the voltages that would hold the desired speeds if the figures were right and there
//!    were no load.
//!
//! There is no ground here and no slip: encoders count what the tracks run. Source: TDK 2016 §1.1.

use super::motor::Motor;
use crate::robot::controller::{DesignError, DriveController, Wish};
use crate::robot::{DriveTrain, RobotModel};

/// Period of the drive controller, s: it runs at 1 kHz.
pub const DRIVE_PERIOD: f64 = 1e-3;

/// What the motors should do, and which loads act on them.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// The robot, as the controller knows it.
    pub robot: RobotModel,
    /// The motors that it really has.
    pub motors: DriveTrain,
    /// Desired forward speed, m/s, from the beginning on.
    pub forward: f64,
    /// Desired turn rate, rad/s.
    pub turn: f64,
    /// How fast desired speeds change, as a part of the robot's own limits; infinite for a step.
    pub ramp: f64,
    /// Torques that begin to act, in order of time.
    pub loads: Vec<LoadStep>,
    /// Duration, s.
    pub seconds: f64,
}

/// Torques on both shafts, from a time on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadStep {
    /// When, s.
    pub at: f64,
    /// Torque against positive rotation, N m.
    pub left: f64,
    /// The same on the right.
    pub right: f64,
}

/// Whether the voltages follow the encoders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loop {
    /// They do.
    Closed,
    /// They follow from the desired speeds alone.
    Open,
}

/// One moment; pairs are left and right.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ResponseSample {
    /// Time, s.
    pub seconds: f64,
    /// Desired speeds of the tracks, m/s.
    pub wished: [f64; 2],
    /// Speeds of the tracks, m/s.
    pub speeds: [f64; 2],
    /// Distances of the tracks since the beginning, m.
    pub ways: [f64; 2],
    /// Resulting heading minus the desired one, rad; not wrapped.
    pub heading_error: f64,
    /// Voltages, V.
    pub voltages: [f64; 2],
    /// Currents, A.
    pub currents: [f64; 2],
}

impl Trial {
    /// A step to full speed, with motors exactly as in the model.
    #[must_use]
    pub fn straight(robot: &RobotModel, forward: f64, seconds: f64) -> Self {
        Self {
            robot: *robot,
            motors: robot.drive,
            forward,
            turn: 0.0,
            ramp: 1.0,
            loads: vec![],
            seconds,
        }
    }

    /// The response, one sample per period.
    ///
    /// # Errors    [`DesignError`]: there is no controller for the robot's figures, or `motors` is
    /// invalid.
    pub fn run(&self, control: Loop) -> Result<Vec<ResponseSample>, DesignError> {
        self.motors.validate()?;
        let mut rig = Rig::new(self)?;
        let periods = (self.seconds.clamp(0.0, 1e4) / DRIVE_PERIOD).round() as usize;
        Ok((0..periods).map(|_| rig.step(self, control)).collect())
    }

    fn loads_at(&self, seconds: f64) -> [f64; 2] {
        let begun = self.loads.iter().rev().find(|load| load.at <= seconds);
        begun.map_or([0.0; 2], |load| [load.left, load.right])
    }
}

/// Motors and controller on a test bench.
struct Rig {
    motors: [Motor; 2],
    controller: DriveController,
    forward: f64,
    turn: f64,
    wished_heading: f64,
    period: usize,
}

impl Rig {
    fn new(trial: &Trial) -> Result<Self, DesignError> {
        let robot = &trial.robot;
        Ok(Self {
            motors: [&trial.motors.left, &trial.motors.right].map(|m| Motor::new(m, DRIVE_PERIOD)),
            controller: DriveController::new(
                &robot.drive,
                DRIVE_PERIOD,
                robot.radians_per_count(),
            )?,
            forward: 0.0,
            turn: 0.0,
            wished_heading: 0.0,
            period: 0,
        })
    }

    fn step(&mut self, trial: &Trial, control: Loop) -> ResponseSample {
        let robot = &trial.robot;
        let wishes = self.next_wishes(trial);
        let count = robot.radians_per_count();
        let counts = [0, 1].map(|i: usize| (self.motors[i].angle() / count).round() as i64);
        let voltages = match control {
            Loop::Closed => self.controller.step(counts, wishes),
            Loop::Open => open_loop(robot, wishes),
        };
        let loads = trial.loads_at(self.period as f64 * DRIVE_PERIOD);
        for side in 0..2 {
            self.motors[side].step(voltages[side], loads[side], 0.0);
        }
        self.period += 1;
        self.wished_heading += self.turn * DRIVE_PERIOD;
        self.sample(robot, wishes, voltages)
    }

    fn next_wishes(&mut self, trial: &Trial) -> [Wish; 2] {
        let robot = &trial.robot;
        let towards = |from: f64, to: f64, limit: f64| {
            let most = trial.ramp * limit * DRIVE_PERIOD;
            from + (to - from).clamp(-most, most)
        };
        let before = (self.forward, self.turn);
        self.forward = towards(self.forward, trial.forward, robot.max_acceleration);
        self.turn = towards(self.turn, trial.turn, robot.max_turn_acceleration);
        // A step has no acceleration: there, only its final speed is desired.
        let per_second = if trial.ramp.is_finite() {
            1.0 / DRIVE_PERIOD
        } else {
            0.0
        };
        let changes = (
            (self.forward - before.0) * per_second,
            (self.turn - before.1) * per_second,
        );
        let speeds = shaft_pair(robot, self.forward, self.turn);
        let accelerations = shaft_pair(robot, changes.0, changes.1);
        [0, 1].map(|side: usize| Wish {
            speed: speeds[side],
            acceleration: accelerations[side],
        })
    }

    fn sample(&self, robot: &RobotModel, wishes: [Wish; 2], voltages: [f64; 2]) -> ResponseSample {
        let metres = robot.drive.metres_per_radian;
        let ways = self.motors.map(|motor| motor.angle() * metres);
        ResponseSample {
            seconds: self.period as f64 * DRIVE_PERIOD,
            wished: wishes.map(|wish| wish.speed * metres),
            speeds: self.motors.map(|motor| motor.speed() * metres),
            ways,
            heading_error: (ways[1] - ways[0]) / robot.track_width - self.wished_heading,
            voltages,
            currents: self.motors.map(|motor| motor.current()),
        }
    }
}

/// Speeds (or accelerations) of the shafts, left and right, from those of the body.
pub(super) fn shaft_pair(robot: &RobotModel, forward: f64, turn: f64) -> [f64; 2] {
    let half = 0.5 * robot.track_width * turn;
    [forward - half, forward + half].map(|metres| metres / robot.drive.metres_per_radian)
}

fn open_loop(robot: &RobotModel, wishes: [Wish; 2]) -> [f64; 2] {
    let motors = [&robot.drive.left, &robot.drive.right];
    let battery = robot.drive.battery;
    [0, 1].map(|side: usize| {
        let Wish {
            speed,
            acceleration,
        } = wishes[side];
        let dry = match speed {
            0.0 => 0.0,
            _ => motors[side].dry_friction.copysign(speed),
        };
        let (_, voltage) = motors[side].to_hold(speed, acceleration, dry);
        voltage.clamp(-battery, battery)
    })
}

#[cfg(test)]
mod tests;
