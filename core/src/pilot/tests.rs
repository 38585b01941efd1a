//! Closed loops in a simple world of segments, with exact sensing and motion.

mod explore;
mod fence;
mod lost;

use proptest::prelude::*;

use super::*;
use crate::geom::{Length, sin_cos};
use crate::map::{CellIndex, CellState, GridConfig};
use crate::points::fixture::look;
use nalgebra::{Matrix3, Point2};

const TICK: f64 = 0.05;

/// Walls, a robot that obeys its model, and a lidar without noise.
struct Toy {
    walls: Vec<Segment>,
    pose: Pose2,
    speeds: (f64, f64),
    model: RobotModel,
    grid: Grid,
    points: Points,
    scanned_at: Pose2,
    nearest: f64,
    driven: f64,
    tick: u64,
    graph: Option<PoseGraph>,
}

impl Toy {
    fn new(walls: Vec<Segment>, pose: Pose2, model: RobotModel) -> Self {
        let mut toy = Self {
            points: look(&walls, &pose, 8.0),
            walls,
            scanned_at: pose,
            pose,
            speeds: (0.0, 0.0),
            model,
            grid: Grid::new(GridConfig::default()).unwrap(),
            nearest: f64::INFINITY,
            driven: 0.0,
            tick: 0,
            graph: None,
        };
        toy.scan();
        toy
    }

    fn stamp(&self) -> Stamp {
        Stamp(self.tick * 50_000)
    }

    fn scan(&mut self) {
        self.points = Points {
            stamp: self.stamp(),
            ..look(&self.walls, &self.pose, 8.0)
        };
        self.scanned_at = self.pose;
        self.grid.insert(&self.points, &self.pose);
    }

    /// One tick: the speeds follow the request as fast as the model allows.
    fn step(&mut self, command: Option<Command>) {
        let wish = match command {
            Some(Command::Velocity { forward, turn }) => (forward, turn),
            Some(Command::Stop) => (0.0, 0.0),
            _ => self.speeds,
        };
        let towards = |now: f64, wish: f64, most: f64| now + (wish - now).clamp(-most, most);
        let (v, w) = self.speeds;
        let v = towards(v, wish.0, self.model.max_acceleration * TICK);
        let w = towards(w, wish.1, self.model.max_turn_acceleration * TICK);
        self.speeds = (v, w);
        let (sin, cos) = sin_cos(0.5 * w * TICK);
        self.pose = self.pose * Pose2::new(v * TICK * cos, v * TICK * sin, w * TICK);
        self.driven += v.abs() * TICK;
        let here = self.pose.position();
        let near = self.walls.iter().map(|s| s.distance(here));
        self.nearest = near.fold(self.nearest, f64::min);
        self.tick += 1;
        if self.tick.is_multiple_of(4) {
            self.scan();
        }
    }

    fn run(&mut self, pilot: &mut Pilot, seconds: f64) {
        while self.stamp().seconds() < seconds && !pilot.status().is_over() {
            let estimate = PoseEstimate {
                pose: self.pose,
                cov: Matrix3::identity() * 1e-6,
            };
            let command = pilot.steer(&self.situation(&estimate));
            self.step(command);
        }
    }

    /// What a pilot sees from here.
    fn situation<'a>(&'a self, estimate: &'a PoseEstimate) -> Situation<'a> {
        Situation {
            stamp: self.stamp(),
            estimate,
            known_in_map: estimate.cov,
            grid: &self.grid,
            graph: self.graph.as_ref(),
            points: Some(&self.points),
            walkers: &[],
            motion_since_scan: self.scanned_at.delta_to(&self.pose),
            drives_unsure: false,
            heading_drift: 0.0,
            speeds: self.speeds,
            bumpers: Bumpers::default(),
            robot_is_busy: false,
            scans_on_command: false,
        }
    }

    /// Fraction of the cells on which the robot could stand, by a flood over exact distances, that
    /// are known to be free.
    fn explored(&self, start: Point2<f64>) -> f64 {
        let keep = self.model.radius() + 0.03;
        let first = self.grid.cell_at(start);
        let mut seen = std::collections::BTreeSet::from([first]);
        let mut todo = vec![first];
        let mut known = 0;
        while let Some(cell) = todo.pop() {
            known += usize::from(self.grid.state(cell) == CellState::Free);
            for (dc, dr) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                let next = CellIndex::new(cell.col + dc, cell.row + dr);
                let centre = self.grid.centre_of(next);
                let free = self.walls.iter().all(|s| s.distance(centre) > keep);
                if free && seen.insert(next) {
                    todo.push(next);
                }
            }
        }
        known as f64 / seen.len() as f64
    }
}

pub(super) fn wall(ax: f64, ay: f64, bx: f64, by: f64) -> Segment {
    Segment::new(Point2::new(ax, ay), Point2::new(bx, by))
}

fn room(x: f64, y: f64, width: f64, height: f64) -> Vec<Segment> {
    vec![
        wall(x, y, x + width, y),
        wall(x + width, y, x + width, y + height),
        wall(x + width, y + height, x, y + height),
        wall(x, y + height, x, y),
    ]
}

/// Two rooms and a corridor, joined by doors 0.8 m wide, with a table in one. Inner walls are 10 cm
/// thick: one without thickness, seen end-on, hides between two beams.
fn flat() -> Vec<Segment> {
    let mut walls = room(-1.0, -1.0, 9.0, 6.0);
    walls.extend(room(2.95, -1.0, 0.1, 1.5));
    walls.extend(room(2.95, 1.3, 0.1, 1.7));
    walls.extend(room(-1.0, 2.95, 6.5, 0.1));
    walls.extend(room(6.3, 2.95, 1.7, 0.1));
    walls.extend(room(5.0, 0.5, 1.0, 0.6));
    walls
}

fn pilot(model: RobotModel, mode: Mode, seed: u64) -> Pilot {
    let mut pilot = Pilot::new(model, PilotConfig::default(), seed);
    pilot.set_mode(mode);
    pilot
}

#[test]
fn a_goal_behind_doors_that_were_never_seen_is_reached() {
    let goal = Point2::new(0.0, 4.0);
    for seed in 0..4 {
        let mut toy = Toy::new(flat(), Pose2::identity(), RobotModel::rp6());
        let mut pilot = pilot(toy.model, Mode::GoTo(goal), seed);
        toy.run(&mut pilot, 300.0);
        assert!(
            matches!(pilot.status(), Status::Finished(Finish::GoalReached { off }) if *off < 0.05),
            "seed {seed}: {}",
            pilot.status()
        );
        assert!((toy.pose.position() - goal).length() < 0.05);
        assert!(toy.nearest > toy.model.radius());
    }
}

#[test]
fn a_goal_in_a_closed_room_is_proved_to_be_unreachable() {
    for (seed, (x, y)) in [(1, (2.0, 0.0)), (3, (1.5, 0.3)), (4, (2.0, 0.5))] {
        let mut walls = room(-1.0, -1.0, 5.0, 4.0);
        walls.extend(room(x, y, 1.0, 1.0));
        let start = Pose2::new(0.0, 0.0, seed as f64);
        let mut toy = Toy::new(walls, start, RobotModel::rp6());
        let goal = Point2::new(x + 0.5, y + 0.5);
        let mut pilot = pilot(toy.model, Mode::GoTo(goal), seed);
        toy.run(&mut pilot, 300.0);
        let said = pilot.status().to_string();
        assert!(said.contains("closed off"), "seed {seed}: {said}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn driving_by_hand_like_mad_touches_nothing(
        wishes in proptest::collection::vec((-1.0..1.0_f64, -3.0..3.0_f64, 5..40_u32), 10..30), heading in -3.0..3.0_f64,
    ) {
        for model in [RobotModel::rp6(), RobotModel::pioneer()] {
            let mut toy = Toy::new(flat(), Pose2::new(0.5, 0.5, heading), model);
            let mut pilot = Pilot::new(model, PilotConfig::default(), 0);
            for &(forward, turn, ticks) in &wishes {
                pilot.drive(forward, turn);
                toy.run(&mut pilot, toy.stamp().seconds() + f64::from(ticks) * TICK);
            }
            // The toy's lidar sees walls every degree: corners may hide between beams by a
            // millimetre or two.
            prop_assert!(toy.nearest > model.radius() - 0.002, "{} {}", model.name, toy.nearest);
        }
    }
}

#[test]
fn speeds_by_hand_are_the_models_before_the_first_scan_too() {
    let toy = Toy::new(flat(), Pose2::identity(), RobotModel::rp6());
    let mut pilot = Pilot::new(toy.model, PilotConfig::default(), 0);
    let estimate = PoseEstimate::exact(toy.pose);
    let mut told = |forward, turn| {
        pilot.drive(forward, turn);
        pilot.steer(&Situation {
            points: None,
            scans_on_command: true,
            ..toy.situation(&estimate)
        })
    };
    let velocity = |forward, turn| Some(Command::Velocity { forward, turn });
    assert_eq!(told(9.0, -9.0), velocity(0.30, -2.0));
    assert_eq!(told(f64::NAN, f64::INFINITY), velocity(0.0, 0.0));
}

#[test]
fn a_silent_lidar_holds_the_robot() {
    let mut toy = Toy::new(flat(), Pose2::identity(), RobotModel::rp6());
    let mut pilot = Pilot::new(toy.model, PilotConfig::default(), 0);
    pilot.drive(0.3, 0.0);
    let estimate = PoseEstimate::exact(toy.pose);
    toy.points.stamp = Stamp(1_000_000);
    for (age, holds) in [(0.1, false), (0.45, false), (0.55, true), (9.0, true)] {
        let command = pilot.steer(&Situation {
            stamp: toy.points.stamp.plus(age),
            ..toy.situation(&estimate)
        });
        assert_eq!(command == Some(Command::Stop), holds, "{age}: {command:?}");
    }
}

#[test]
fn a_leg_ends_where_the_heading_is_no_longer_known_and_a_scan_follows() {
    // (legs by the estimate, drift, stopped)
    for (by_estimate, drift, stopped) in [
        (true, 0.04, false),
        (true, 0.06, true),
        (false, 0.06, false),
    ] {
        let toy = Toy::new(flat(), Pose2::identity(), RobotModel::rp6());
        let config = PilotConfig {
            legs_by_estimate: by_estimate,
            ..PilotConfig::default()
        };
        let mut pilot = Pilot::new(toy.model, config, 0);
        pilot.set_mode(Mode::GoTo(Point2::new(2.0, 0.0)));
        let estimate = PoseEstimate::exact(toy.pose);
        let mut points = toy.points.clone();
        let mut steer = |seconds: f64, drift: f64, busy: bool| {
            points.stamp = Stamp::from_seconds(seconds);
            pilot.steer(&Situation {
                stamp: points.stamp,
                estimate: &estimate,
                known_in_map: estimate.cov,
                graph: None,
                grid: &toy.grid,
                points: Some(&points),
                walkers: &[],
                motion_since_scan: Pose2::identity(),
                drives_unsure: false,
                heading_drift: drift,
                speeds: (0.3, 0.0),
                bumpers: Bumpers::default(),
                robot_is_busy: busy,
                scans_on_command: true,
            })
        };
        assert_eq!(steer(1.0, 0.0, false), Some(Command::Scan));
        let mut told = steer(2.0, 0.0, false);
        if matches!(told, Some(Command::Turn(_))) {
            told = steer(2.1, 0.0, false);
        }
        assert!(
            matches!(told, Some(Command::Turn(_) | Command::Forward(_))),
            "{told:?}"
        );
        while !matches!(told, Some(Command::Forward(_))) {
            told = steer(2.2, 0.0, false);
        }
        assert_eq!(steer(2.5, drift, true), stopped.then_some(Command::Stop));
        if stopped {
            assert_eq!(steer(3.0, drift, false), Some(Command::Scan));
        }
    }
}

#[test]
fn an_errand_waits_for_a_silent_lidar_says_so_and_goes_on() {
    let mut toy = Toy::new(flat(), Pose2::identity(), RobotModel::rp6());
    let mut pilot = pilot(toy.model, Mode::Explore, 3);
    toy.run(&mut pilot, 5.0);
    assert_eq!(*pilot.status(), Status::Driving);
    // Ten seconds of silence: it brakes within half a second and stands.
    let (points, estimate) = (toy.points.clone(), PoseEstimate::exact(toy.pose));
    for tick in 1..200_u32 {
        let command = pilot.steer(&Situation {
            stamp: points.stamp.plus(f64::from(tick) * TICK),
            points: Some(&points),
            motion_since_scan: Pose2::identity(),
            heading_drift: 0.0,
            speeds: (0.0, 0.0),
            ..toy.situation(&estimate)
        });
        if tick > 10 {
            assert_eq!(command, Some(Command::Stop), "{tick}");
            assert_eq!(pilot.status().to_string(), "no scan for 0.5 s");
            assert!(!pilot.status().is_over());
        }
    }
    let before = toy.driven;
    toy.run(&mut pilot, toy.stamp().seconds() + 5.0);
    assert!(toy.driven > before + 0.3, "{} {}", toy.driven, before);
}

#[test]
fn a_pressed_bumper_sends_the_robot_back_and_in_the_end_makes_it_give_the_goal_up() {
    let mut toy = Toy::new(flat(), Pose2::identity(), RobotModel::rp6());
    let mut pilot = pilot(toy.model, Mode::GoTo(Point2::new(2.0, 0.0)), 3);
    // A pane of glass that no scan shows, 0.5 m ahead of the start.
    let pane = toy.pose.x() + 0.5;
    while toy.stamp().seconds() < 120.0 && !pilot.status().is_over() {
        let touches = toy.pose.x() + toy.model.radius() >= pane;
        let estimate = PoseEstimate::exact(toy.pose);
        let bumpers = Bumpers {
            left: touches,
            right: touches,
        };
        let command = pilot.steer(&Situation {
            bumpers,
            ..toy.situation(&estimate)
        });
        if touches && let Some(Command::Velocity { forward, .. }) = command {
            assert!(forward <= 0.0, "drives on into the pane");
        }
        toy.step(command);
    }
    let failed = matches!(pilot.status(), Status::Failed(Failure::Stuck { .. }));
    assert!(failed, "{}", pilot.status());
}

#[test]
fn same_seed_drives_the_same_way_to_the_bit() {
    let end = |seed| {
        let mut toy = Toy::new(flat(), Pose2::identity(), RobotModel::rp6());
        let mut pilot = pilot(toy.model, Mode::Explore, seed);
        toy.run(&mut pilot, 60.0);
        (toy.pose.x().to_bits(), toy.pose.y().to_bits(), toy.tick)
    };
    assert_eq!(end(5), end(5));
}
