//! Tests the guard with robots that are driven at the fence in every way.

use nalgebra::Matrix3;
use proptest::prelude::*;

use super::*;
use crate::control::within_model;
use crate::geom::geofence::tests::fence;
use crate::geom::{Pose2, PoseEstimate};
use crate::robot::{Command, RobotModel};

/// A robot that takes time for everything: commands arrive late, and wheels change their speed as
/// the model allows.
struct Robot {
    model: RobotModel,
    pose: Pose2,
    runs: (f64, f64),
    /// Commands that have not arrived yet, the oldest first.
    on_its_way: std::collections::VecDeque<(f64, f64)>,
}

const TICK: f64 = 0.02;
/// A command takes 100 ms to have an effect.
const DELAY: usize = 5;

impl Robot {
    fn new(pose: Pose2) -> Self {
        Self {
            model: RobotModel::rp6(),
            pose,
            runs: (0.0, 0.0),
            on_its_way: vec![(0.0, 0.0); DELAY].into(),
        }
    }

    /// Runs for a tick; returns the distance.
    fn run(&mut self, speeds: (f64, f64)) -> f64 {
        self.on_its_way.push_back(speeds);
        let wanted = self.on_its_way.pop_front().unwrap();
        let toward = |runs: f64, wanted: f64, most: f64| {
            runs + (wanted - runs).clamp(-most * TICK, most * TICK)
        };
        // It brakes only as the model says, and takes a second to change its turn rate.
        let (most, turns) = (self.model.max_acceleration, 2.0);
        self.runs = (
            toward(self.runs.0, wanted.0, 0.7 * most),
            toward(self.runs.1, wanted.1, turns),
        );
        let (way, turn) = (self.runs.0 * TICK, self.runs.1 * TICK);
        let half = Pose2::new(0.0, 0.0, 0.5 * turn);
        self.pose = self.pose * half * Pose2::new(way, 0.0, 0.0) * half;
        way
    }
}

fn sure(pose: Pose2) -> Option<PoseEstimate> {
    let cov = Matrix3::identity() * 1e-4;
    Some(PoseEstimate { pose, cov })
}

fn guard(fence: Geofence) -> FenceGuard {
    FenceGuard::new(RobotModel::rp6(), fence, FenceConfig::default())
}

/// Drives with `wishes`, half a second each; returns the least clearance of the robot's disc on the
/// way.
fn least(start: Pose2, wishes: &[(f64, f64)]) -> f64 {
    let (fence, mut robot) = (fence(), Robot::new(start));
    let mut guard = guard(fence.clone());
    let mut commanded = (0.0, 0.0);
    let take = |command: Command| match command {
        Command::Velocity { forward, turn } => (forward, turn),
        _ => (0.0, 0.0),
    };
    let (mut way, mut least) = (0.0, f64::INFINITY);
    for &(forward, turn) in wishes {
        for tick in 0..25 {
            if let Some(now) = guard.moved(sure(robot.pose), robot.runs, way) {
                commanded = take(now);
            }
            // A page sends 20 times a second.
            if tick % 3 == 0 {
                commanded = take(guard.limit(Command::Velocity { forward, turn }));
            }
            way = robot.run(commanded);
            let clearance = fence.clearance(robot.pose.position());
            least = least.min(clearance - robot.model.radius());
        }
    }
    least
}

#[test]
fn a_robot_at_full_speed_stops_before_the_border_and_not_long_before() {
    let model = RobotModel::rp6();
    for (forward, heading) in [(1.0, 0.0), (-1.0, std::f64::consts::PI)] {
        let start = Pose2::new(1.0, 0.4, heading);
        let mut guard = guard(fence());
        let mut robot = Robot::new(start);
        let mut way = 0.0;
        for _ in 0..3000 {
            guard.moved(sure(robot.pose), robot.runs, way);
            let wish = Command::Velocity { forward, turn: 0.0 };
            let Command::Velocity { forward, turn } = guard.limit(wish) else {
                panic!()
            };
            way = robot.run((forward, turn));
        }
        let short = 6.0 - model.radius() - robot.pose.x();
        // The margin, twice σ = 1 cm, and at most a hand's breadth for its slow end.
        assert!((0.05..0.15).contains(&short), "{short}");
        assert!(guard.holds_back() && !guard.is_outside());
        // Backwards and on the spot it may still move.
        let (back, turn) = (-forward, 0.0);
        let wish = Command::Velocity {
            forward: back,
            turn,
        };
        assert!(
            matches!(guard.limit(wish), Command::Velocity { forward, .. } if forward.abs() > 0.1)
        );
        assert!(!guard.holds_back());
        let wish = Command::Velocity {
            forward: 0.0,
            turn: 1.0,
        };
        assert_eq!(guard.limit(wish), wish);
    }
}

#[test]
fn a_leg_ends_before_the_border_and_one_that_would_cross_it_since_is_stopped() {
    let radius = RobotModel::rp6().radius();
    let mut guard = guard(fence());
    guard.moved(sure(Pose2::new(4.0, 0.4, 0.0)), (0.0, 0.0), 0.0);
    let Command::Forward(by) = guard.limit(Command::Forward(9.0)) else {
        panic!()
    };
    let room = 2.0 - radius - 0.07;
    assert!((by - room).abs() < 0.02, "{by} of {room}");
    assert_eq!(guard.limit(Command::Forward(-1.0)), Command::Forward(-1.0));
    assert_eq!(guard.limit(Command::Turn(3.0)), Command::Turn(3.0));
    // The map was corrected: the border is nearer than it was when the leg began.
    guard.limit(Command::Forward(1.0));
    assert_eq!(
        guard.moved(sure(Pose2::new(4.1, 0.4, 0.0)), (0.3, 0.0), 0.1),
        None
    );
    let stop = guard.moved(sure(Pose2::new(5.7, 0.4, 0.0)), (0.3, 0.0), 0.02);
    assert_eq!(stop, Some(Command::Stop));
    assert!(guard.holds_back());
}

#[test]
fn a_robot_outside_is_driven_back_and_no_further_out() {
    let mut guard = guard(fence());
    let limit = |guard: &mut FenceGuard, heading: f64, forward: f64| {
        guard.moved(sure(Pose2::new(6.5, 1.0, heading)), (0.0, 0.0), 0.0);
        match guard.limit(Command::Velocity { forward, turn: 0.0 }) {
            Command::Velocity { forward, .. } => forward,
            _ => 0.0,
        }
    };
    let pi = std::f64::consts::PI;
    assert!(limit(&mut guard, pi, 0.2) > 0.15);
    assert!(guard.is_outside());
    assert!(limit(&mut guard, 0.0, -0.2) < -0.15);
    assert_eq!(limit(&mut guard, 0.0, 0.2), 0.0);
    assert_eq!(limit(&mut guard, 1.0, 0.2), 0.0);
    assert!(limit(&mut guard, 2.0, 0.2) > 0.05);
}

#[test]
fn without_a_pose_or_with_one_that_is_not_sure_it_stands() {
    let drive = Command::Velocity {
        forward: 0.2,
        turn: 0.3,
    };
    let here = Pose2::new(1.0, 1.0, 0.0);
    for pose in [
        None,
        Some(PoseEstimate {
            pose: here,
            cov: Matrix3::identity(),
        }),
        Some(PoseEstimate {
            pose: here,
            cov: Matrix3::identity() * f64::NAN,
        }),
    ] {
        let mut guard = guard(fence());
        guard.moved(sure(here), (0.0, 0.0), 0.0);
        assert_eq!(guard.limit(drive), drive);
        assert_eq!(guard.moved(pose, (0.2, 0.3), 0.0), Some(Command::Stop));
        assert!(guard.holds_back() && !guard.is_placed());
        for wish in [drive, Command::Forward(0.1), Command::Turn(0.1)] {
            assert_eq!(guard.limit(wish), Command::Stop);
        }
        assert_eq!(guard.limit(Command::Scan), Command::Scan);
        // The pose is known again: the request goes on, as with safe mode.
        guard.limit(drive);
        assert_eq!(guard.moved(sure(here), (0.0, 0.0), 0.0), Some(drive));
    }
    let mut free = guard(Geofence::default());
    assert_eq!(free.limit(drive), drive);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// However it is driven, its disc stays inside: in an L with a table in it, from any place
    /// where it began inside.
    #[test]
    fn nobody_drives_it_out(
        x in 0.0..6.0_f64,
        y in 0.0..5.0_f64,
        heading in -3.1..3.1_f64,
        wishes in prop::collection::vec((-0.6..0.6_f64, -2.0..2.0_f64), 1..40),
    ) {
        let model = RobotModel::rp6();
        let room = fence().clearance(Point2::new(x, y)) - model.radius();
        prop_assume!(room > 0.1);
        let wishes: Vec<_> = wishes.into_iter().map(|wish| within_model(wish, &model)).collect();
        let least = least(Pose2::new(x, y, heading), &wishes);
        prop_assert!(least > 0.0, "{} m outside", -least);
    }
}
