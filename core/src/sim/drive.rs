//! From commands to what the tracks do.
//!
//! In: a [`Command`]. Out: the distance that each track runs in one time step.
//!
//! 1. Speeds asked for are cut to the model's limits, forward speed and turn rate by the same factor where the outer
//!    track could not follow, so that the curve stays the curve.
//! 2. Speeds change by no more than the model's accelerations.
//! 3. `Forward` and `Turn` run a trapezoid: the speed from which the rest of the way is just enough to stop. They
//!    count the way on their own encoders, so they end within one count of what was asked (and only slip, which no
//!    encoder sees, keeps the robot from being where it believes to be).
//!
//! Source: TDK 2016 §1.2 for the commands; the trapezoid is the time-optimal profile under a limit of acceleration.

use crate::robot::{Command, RobotModel, Tracks};

/// What the robot is busy with.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Task {
    /// Hold these speeds.
    Speeds { forward: f64, turn: f64 },
    /// So much of the way is left, m.
    Forward { left: f64 },
    /// So much of the turn is left, rad.
    Turn { left: f64 },
}

const STAND: Task = Task::Speeds {
    forward: 0.0,
    turn: 0.0,
};

/// Speeds of the robot's body, as its motors hold them.
#[derive(Clone, Debug)]
pub(super) struct Drive {
    model: RobotModel,
    task: Task,
    forward: f64,
    turn: f64,
}

impl Drive {
    pub(super) fn new(model: &RobotModel) -> Self {
        Self {
            model: *model,
            task: STAND,
            forward: 0.0,
            turn: 0.0,
        }
    }

    /// Takes a command; figures that are not finite stop the robot.
    pub(super) fn command(&mut self, command: Command) {
        self.task = match command {
            Command::Velocity { forward, turn } if forward.is_finite() && turn.is_finite() => {
                self.within_limits(forward, turn)
            }
            Command::Forward(left) if left.is_finite() => Task::Forward { left },
            Command::Turn(left) if left.is_finite() => Task::Turn { left },
            _ => STAND,
        };
    }

    /// Whether a `Forward` or `Turn` is under way.
    pub(super) fn is_busy(&self) -> bool {
        !matches!(self.task, Task::Speeds { .. })
    }

    /// Whether the tracks stand still and are to stand still.
    pub(super) fn stands(&self) -> bool {
        self.task == STAND && self.forward == 0.0 && self.turn == 0.0
    }

    /// Forward speed, m/s, and turn rate, rad/s, that the tracks run at.
    pub(super) fn speeds(&self) -> (f64, f64) {
        (self.forward, self.turn)
    }

    /// Runs the tracks for `dt` seconds.
    pub(super) fn step(&mut self, dt: f64) -> Tracks {
        let (a, b) = (
            self.model.max_acceleration,
            self.model.max_turn_acceleration,
        );
        let (forward, turn) = match self.task {
            Task::Speeds { forward, turn } => (forward, turn),
            Task::Forward { left } => (
                stopping_speed(left, a, dt).clamp(-self.model.max_speed, self.model.max_speed),
                0.0,
            ),
            Task::Turn { left } => {
                let most = self
                    .model
                    .max_turn_rate
                    .min(2.0 * self.model.max_speed / self.model.track_width);
                (0.0, stopping_speed(left, b, dt).clamp(-most, most))
            }
        };
        self.forward = towards(self.forward, forward, a * dt);
        self.turn = towards(self.turn, turn, b * dt);
        let (ahead, angle) = (self.forward * dt, self.turn * dt);
        self.count_down(ahead, angle, dt);
        let half = 0.5 * angle * self.model.track_width;
        Tracks {
            left: ahead - half,
            right: ahead + half,
        }
    }

    /// Takes the way of one step off what is left, and ends the task when nothing is.
    fn count_down(&mut self, ahead: f64, angle: f64, dt: f64) {
        let tick = self.model.metres_per_tick;
        let done = match &mut self.task {
            Task::Speeds { .. } => false,
            Task::Forward { left } => {
                *left -= ahead;
                left.abs() < 1e-3 * tick && self.forward.abs() <= self.model.max_acceleration * dt
            }
            Task::Turn { left } => {
                *left -= angle;
                left.abs() < 1e-3 * tick / self.model.track_width
                    && self.turn.abs() <= self.model.max_turn_acceleration * dt
            }
        };
        if done {
            self.task = STAND;
        }
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

/// The highest speed v at which, after one more step, the rest of the way is enough to stop: v dt + v²/(2a) = left.
fn stopping_speed(left: f64, acceleration: f64, dt: f64) -> f64 {
    let way = left.abs();
    // The last step: as fast as the rest of the way asks, slower than one step of braking.
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
mod tests {
    use proptest::prelude::*;

    use super::*;

    const DT: f64 = 0.005;

    /// Runs until idle; gives both tracks' way, the seconds, and the greatest change of speed in a step.
    fn run(drive: &mut Drive) -> (Tracks, f64, f64) {
        let (mut sum, mut seconds, mut jerk) = (Tracks::default(), 0.0, 0.0_f64);
        while drive.is_busy() || !drive.stands() {
            let before = drive.forward;
            let step = drive.step(DT);
            jerk = jerk.max((drive.forward - before).abs());
            sum.left += step.left;
            sum.right += step.right;
            seconds += DT;
            assert!(seconds < 1e3, "never ends: {drive:?}");
        }
        (sum, seconds, jerk)
    }

    proptest! {
        #[test]
        fn forward_ends_within_a_tick(metres in -5.0..5.0_f64) {
            let model = RobotModel::rp6();
            let mut drive = Drive::new(&model);
            drive.command(Command::Forward(metres));
            let (way, seconds, jerk) = run(&mut drive);
            prop_assert!((way.left - metres).abs() < model.metres_per_tick && way.left == way.right, "{way:?}");
            prop_assert!(jerk <= model.max_acceleration * DT * (1.0 + 1e-9));
            // The time of the ideal trapezoid: s/v + v/a, or 2 √(s/a) where the top speed is never reached.
            let (v, a, s) = (model.max_speed, model.max_acceleration, metres.abs());
            let ideal = if s > v * v / a { s / v + v / a } else { 2.0 * (s / a).sqrt() };
            prop_assert!(seconds >= ideal - 2.0 * DT && seconds < ideal + 0.15, "{seconds} against {ideal}");
        }

        #[test]
        fn turn_ends_within_a_tick(angle in -7.0..7.0_f64) {
            let model = RobotModel::rp6();
            let mut drive = Drive::new(&model);
            drive.command(Command::Turn(angle));
            let (way, _, _) = run(&mut drive);
            let turned = (way.right - way.left) / model.track_width;
            prop_assert!((turned - angle).abs() < model.metres_per_tick / model.track_width);
            prop_assert!((way.right + way.left).abs() < 1e-9);
        }

        #[test]
        fn commands_given_on_the_run_still_end(metres in -1.0..1.0_f64, speed in -0.3..0.3_f64, turn in -2.0..2.0_f64) {
            let model = RobotModel::rp6();
            let mut drive = Drive::new(&model);
            drive.command(Command::Velocity { forward: speed, turn });
            for _ in 0..300 {
                drive.step(DT);
            }
            drive.command(Command::Forward(metres));
            let (way, _, _) = run(&mut drive);
            prop_assert!((0.5 * (way.left + way.right) - metres).abs() < model.metres_per_tick);
        }

        #[test]
        fn no_track_runs_faster_than_it_can(forward in -2.0..2.0_f64, turn in -9.0..9.0_f64) {
            let model = RobotModel::rp6();
            let mut drive = Drive::new(&model);
            drive.command(Command::Velocity { forward, turn });
            for _ in 0..500 {
                let tracks = drive.step(DT);
                prop_assert!(tracks.left.abs().max(tracks.right.abs()) <= model.max_speed * DT * (1.0 + 1e-9));
            }
        }
    }

    #[test]
    fn figures_that_are_not_finite_stop() {
        let mut drive = Drive::new(&RobotModel::rp6());
        for command in [
            Command::Forward(f64::NAN),
            Command::Turn(f64::INFINITY),
            Command::Velocity {
                forward: f64::NAN,
                turn: 0.0,
            },
        ] {
            drive.command(Command::Velocity {
                forward: 0.3,
                turn: 0.0,
            });
            drive.step(1.0);
            drive.command(command);
            drive.step(1.0);
            assert!(drive.stands(), "{command:?}");
        }
    }
}
