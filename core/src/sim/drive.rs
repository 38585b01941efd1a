//! From commands to the motion of the tracks.
//!
//! In: a [`Command`], then only time. Out: the distance that each track runs in each period of 1
//! ms, and encoder counts.
//!
//! 1. Commanded speeds are limited as in the model. If the outer track could not follow, forward
//!    speed and turn rate are lowered by the same factor, so the curve stays the same. They change
//!    by no more than the model's accelerations.
//! 2. `Forward` and `Turn` follow a trapezoid: the speed is at most the one from which the
//!    remaining distance is just enough to stop. That distance is measured on the controller's
//!    desired motion, which the robot follows to within a few counts.
//! 3. The controller turns desired speeds and counts into voltages, and the motors turn voltages
//!    into rotation. The controller knows the model's motors, not this robot's, and sees counts,
//!    not angles.
//! 4. When the desired speeds are zero and the counts stand still, the motors are released. If the
//!    counts do not change for a second although the robot is commanded to move, the command is
//!    given up.
//!
//! Source: TDK 2016 §1.1 for motors and controller, §1.2 for the commands; the trapezoid is the
//! time-optimal profile under a limit of acceleration.

use rand::{Rng, RngExt};

use super::motor::Motor;
use super::response::{DRIVE_PERIOD, shaft_pair};
use crate::robot::controller::{Angles, DesignError, DriveController, Wish};
use crate::robot::{Command, MotorModel, RobotModel, Tracks};

/// Periods without a count after which a robot counts as standing: 30 ms.
const STILL: u32 = 30;
/// Periods after which a robot that is not yet within a count of its target stops trying: 0.6 s.
const LONGEST_SETTLING: u32 = 600;
/// Periods without a count after which a moving command is given up: 1 s.
const STALLED: u32 = 1_000;

/// What the robot is doing.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Task {
    /// Hold these speeds.
    Speeds { forward: f64, turn: f64 },
    /// Remaining distance, m.
    Forward { left: f64 },
    /// Remaining turn, rad.
    Turn { left: f64 },
    /// The distance is run; it waits for the last count.
    Settle,
}

const STAND: Task = Task::Speeds {
    forward: 0.0,
    turn: 0.0,
};

/// Motors, their controller, and what they are doing.
#[derive(Clone, Debug)]
pub(super) struct Drive {
    model: RobotModel,
    task: Task,
    /// Desired speeds of the body.
    forward: f64,
    turn: f64,
    controller: DriveController,
    motors: [Motor; 2],
    /// Encoder counts since the start: left, right.
    pub(super) counts: [i64; 2],
    /// Periods since a count changed, and since the desired speed is zero.
    still_for: u32,
    settling_for: u32,
    is_let_go: bool,
}

impl Drive {
    /// Motors of a standing robot. Their deviation from the model's is drawn here.
    pub(super) fn new(model: &RobotModel, rng: &mut impl Rng) -> Result<Self, DesignError> {
        let spread = model.drive.spread;
        let mut own = |motor: &MotorModel| {
            let part = spread * rng.random_range(-1.0..1.0);
            Motor::new(&motor.with_stronger_magnet(part), DRIVE_PERIOD)
        };
        Ok(Self {
            model: *model,
            task: STAND,
            forward: 0.0,
            turn: 0.0,
            controller: DriveController::new(
                &model.drive,
                DRIVE_PERIOD,
                model.radians_per_count(),
            )?,
            motors: [own(&model.drive.left), own(&model.drive.right)],
            counts: [0; 2],
            still_for: STILL,
            settling_for: 0,
            is_let_go: true,
        })
    }

    /// Begins a command; figures that are not finite stop the robot.
    pub(super) fn command(&mut self, command: Command) {
        self.task = match command {
            Command::Velocity { forward, turn } if forward.is_finite() && turn.is_finite() => {
                self.within_limits(forward, turn)
            }
            Command::Forward(left) if left.is_finite() => Task::Forward { left },
            Command::Turn(left) if left.is_finite() => Task::Turn { left },
            _ => STAND,
        };
        if self.task != STAND {
            self.is_let_go = false;
            self.settling_for = 0;
            self.still_for = self.still_for.min(STILL);
        }
    }

    /// Whether a `Forward` or `Turn` is in progress.
    pub(super) fn is_busy(&self) -> bool {
        !matches!(self.task, Task::Speeds { .. })
    }

    /// Whether the tracks stand still and should, as far as the encoders show.
    pub(super) fn stands(&self) -> bool {
        self.task == STAND && self.is_let_go && self.still_for >= STILL
    }

    /// Forward speed, m/s, and turn rate, rad/s, at which the tracks run.
    pub(super) fn speeds(&self) -> (f64, f64) {
        let metres = self.model.drive.metres_per_radian;
        let [left, right] = self.motors.map(|motor| motor.speed() * metres);
        (
            0.5 * (left + right),
            (right - left) / self.model.track_width,
        )
    }

    /// Currents of the motors, A: left, right.
    pub(super) fn currents(&self) -> [f64; 2] {
        self.motors.map(|motor| motor.current())
    }

    /// Sets the battery's voltage, V, as its converter reads it.
    pub(super) fn set_supply(&mut self, volts: f64) {
        self.controller.set_supply(volts);
    }

    /// Power that the motors take from the battery, W: voltage times current, zero for a braking
    /// motor.
    pub(super) fn watts(&self) -> f64 {
        let [left, right] = self.controller.voltages();
        let [of_left, of_right] = self.currents();
        (left * of_left).max(0.0) + (right * of_right).max(0.0)
    }

    /// Runs the tracks for one period. `scrub` is the force, N, with which the ground brakes each
    /// track because the body does not follow it; its sign is that of the tracks' motion.
    pub(super) fn step(&mut self, scrub: f64) -> Tracks {
        if self.is_let_go && self.motors.iter().all(Motor::is_at_rest) {
            self.still_for = self.still_for.saturating_add(1).min(STALLED);
            return Tracks::default();
        }
        let voltages = self.voltages();
        let metres = self.model.drive.metres_per_radian;
        let mut ran = [0.0; 2];
        for side in 0..2 {
            let motor = &mut self.motors[side];
            let before = motor.angle();
            let is_braked = scrub * motor.speed() > 0.0;
            let brake = if is_braked { scrub.abs() * metres } else { 0.0 };
            motor.step(voltages[side], 0.0, brake);
            ran[side] = (motor.angle() - before) * metres;
        }
        self.count();
        Tracks {
            left: ran[0],
            right: ran[1],
        }
    }

    fn count(&mut self) {
        let per_count = self.model.radians_per_count();
        let count = |motor: Motor| (motor.angle() / per_count).round() as i64;
        let counts = self.motors.map(count);
        let longer = self.still_for.saturating_add(1).min(STALLED);
        self.still_for = if counts == self.counts { longer } else { 0 };
        self.counts = counts;
    }

    fn voltages(&mut self) -> [f64; 2] {
        if self.is_let_go {
            return self.controller.rest(self.counts);
        }
        let before = self.controller.wished();
        let wishes = self.next_wishes();
        let voltages = self.controller.step(self.counts, wishes);
        self.count_down(before, self.controller.wished());
        self.settle();
        voltages
    }

    /// Desired speeds and accelerations of the shafts.
    fn next_wishes(&mut self) -> [Wish; 2] {
        let a = self.model.max_acceleration;
        let b = self.model.max_turn_acceleration;
        let (forward, turn) = self.task_speeds(a, b);
        let before = (self.forward, self.turn);
        self.forward = towards(self.forward, forward, a * DRIVE_PERIOD);
        self.turn = towards(self.turn, turn, b * DRIVE_PERIOD);
        let speeds = shaft_pair(&self.model, self.forward, self.turn);
        let changes = shaft_pair(&self.model, self.forward - before.0, self.turn - before.1);
        [0, 1].map(|side: usize| Wish {
            speed: speeds[side],
            acceleration: changes[side] / DRIVE_PERIOD,
        })
    }

    fn task_speeds(&self, a: f64, b: f64) -> (f64, f64) {
        match self.task {
            Task::Speeds { forward, turn } => (forward, turn),
            Task::Settle => (0.0, 0.0),
            Task::Forward { left } => {
                let most = self.model.max_speed;
                let speed = stopping_speed(left, a, DRIVE_PERIOD);
                (speed.clamp(-most, most), 0.0)
            }
            Task::Turn { left } => {
                let by_track = 2.0 * self.model.max_speed / self.model.track_width;
                let most = self.model.max_turn_rate.min(by_track);
                let rate = stopping_speed(left, b, DRIVE_PERIOD);
                (0.0, rate.clamp(-most, most))
            }
        }
    }

    /// Subtracts the advance of the desired motion from the remaining distance, and ends the
    /// command when nothing remains.
    fn count_down(&mut self, before: Angles, after: Angles) {
        let metres = self.model.drive.metres_per_radian;
        let (tick, width) = (self.model.metres_per_tick, self.model.track_width);
        let most = |acceleration: f64| acceleration * DRIVE_PERIOD;
        let is_run = match &mut self.task {
            Task::Speeds { .. } | Task::Settle => false,
            Task::Forward { left } => {
                *left -= (after.middle() - before.middle()) * metres;
                left.abs() < 1e-2 * tick && self.forward.abs() <= most(self.model.max_acceleration)
            }
            Task::Turn { left } => {
                *left += (after.difference - before.difference) * metres / width;
                left.abs() < 1e-2 * tick / width
                    && self.turn.abs() <= most(self.model.max_turn_acceleration)
            }
        };
        if is_run {
            self.task = Task::Settle;
        }
    }

    /// Releases the motors when they have reached their target, and gives up what is stalled.
    fn settle(&mut self) {
        let is_moving = self.forward != 0.0 || self.turn != 0.0;
        if is_moving {
            self.settling_for = 0;
            if self.is_busy() && self.still_for >= STALLED {
                self.task = STAND;
            }
            return;
        }
        let is_to_stand = self.task == STAND || self.task == Task::Settle;
        if !is_to_stand {
            return;
        }
        self.settling_for += 1;
        let has_stopped = self.still_for >= STILL && (self.task == STAND || self.is_at_aim());
        if has_stopped || self.settling_for >= LONGEST_SETTLING {
            self.task = STAND;
            self.settling_for = 0;
            self.is_let_go = true;
        }
    }

    /// Whether both tracks are within a count of the desired angle.
    fn is_at_aim(&self) -> bool {
        let per_count = self.model.radians_per_count();
        let [left, right] = self.counts.map(|count| count as f64 * per_count);
        let wished = self.controller.wished();
        let wished_right = wished.left - wished.difference;
        let errors = [left - wished.left, right - wished_right];
        errors.iter().all(|error| error.abs() <= per_count)
    }

    fn within_limits(&self, forward: f64, turn: f64) -> Task {
        let forward = forward.clamp(-self.model.max_speed, self.model.max_speed);
        let turn = turn.clamp(-self.model.max_turn_rate, self.model.max_turn_rate);
        let outer = forward.abs() + 0.5 * self.model.track_width * turn.abs();
        let scale = if outer > self.model.max_speed {
            self.model.max_speed / outer
        } else {
            1.0
        };
        Task::Speeds {
            forward: forward * scale,
            turn: turn * scale,
        }
    }
}

/// The highest speed v at which, after one more step, the remaining distance is enough to stop: v
/// dt + v²/(2a) = left.
fn stopping_speed(left: f64, acceleration: f64, dt: f64) -> f64 {
    let way = left.abs();
    // The last step: as fast as the remaining distance asks, slower than one step of braking.
    let speed = if way <= acceleration * dt * dt {
        way / dt
    } else {
        acceleration * ((dt * dt + 2.0 * way / acceleration).sqrt() - dt)
    };
    speed.copysign(left)
}

fn towards(from: f64, to: f64, most: f64) -> f64 {
    from + (to - from).clamp(-most, most)
}

#[cfg(test)]
mod tests;
