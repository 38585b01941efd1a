//! The loop closed in a simulated room, with the messages of a bridge between robot and estimate.

use nalgebra::Point2;

use super::*;
use crate::geom::Pose2;
use crate::pilot::{Finish, Status};
use crate::replay::{Log, Replay};
use crate::robot::Command;
use crate::sim::{SensorModel, Simulation, worlds};
use crate::wire::message::{
    BridgeHello, CHALLENGE_BYTES, DisarmReason, Format, Header, Lease, ManoeuvreBody, OdometryBody,
    SCHEMA, SafetyBody, ScanBody, ToBridge, Watching, Welcome, decode, encode,
};
use crate::wire::recording::{Recording, fixture};

/// A bridge of a few lines: grants what is asked for, passes commands on, stops a robot that nobody
/// keeps going.
struct Bridge {
    robot: Simulation,
    sequence: u32,
    armed: bool,
    driven: f64,
    /// Sequence of the errand under way.
    errand: Option<u32>,
    said: Vec<ToBridge>,
    /// What it reported, and when.
    reported: Vec<(u64, FromBridge)>,
}

impl Bridge {
    fn new(sensor: SensorModel) -> Self {
        let world = worlds::builtin("arena").unwrap();
        let robot = world.robot.model();
        Self {
            robot: Simulation::new(world, robot, sensor, 3).unwrap(),
            sequence: 0,
            armed: false,
            driven: f64::NEG_INFINITY,
            errand: None,
            said: vec![],
            reported: vec![],
        }
    }

    fn micros(&self) -> u64 {
        // Its clock began 5 s before the robot's.
        self.robot.stamp().0 + 5_000_000
    }

    fn tell(&mut self, live: &mut Live, message: &FromBridge) {
        self.sequence += 1;
        let header = Header {
            sequence: self.sequence,
            micros: self.micros(),
        };
        let bytes = encode(header, message, Format::Binary).unwrap();
        live.receive(self.micros(), &bytes).unwrap();
        self.reported.push((self.micros(), message.clone()));
    }

    fn greet(&mut self, live: &mut Live) {
        let on_command = self.robot.scans_on_command();
        let robot = RobotFigures::new(self.robot.robot(), on_command);
        self.tell(
            live,
            &FromBridge::Hello(BridgeHello {
                version: "test".to_owned(),
                schema: SCHEMA,
                challenge: [1; CHALLENGE_BYTES],
                watching: Watching::Anyone,
                robot: Some(robot),
                watchdog_millis: 200,
                lease_millis: 2000,
            }),
        );
        let welcome = Welcome {
            client: 1,
            may_drive: true,
        };
        self.tell(live, &FromBridge::Welcome(welcome));
    }

    fn safety(&mut self, live: &mut Live) {
        let safety = SafetyBody {
            driver: Some(1),
            driver_name: "test".to_owned(),
            armed: self.armed,
            emergency: false,
            reason: DisarmReason::Start,
        };
        self.tell(live, &FromBridge::Safety(safety));
    }

    fn hear(&mut self, live: &mut Live) {
        for bytes in live.take_outgoing() {
            let (header, message) = decode::<ToBridge>(&bytes, Format::Binary).unwrap();
            match &message {
                ToBridge::Take { .. } => {
                    let lease = Lease {
                        epoch: 1,
                        millis: 2000,
                    };
                    self.tell(live, &FromBridge::Granted(lease));
                    self.safety(live);
                }
                ToBridge::Arm { .. } => {
                    self.armed = true;
                    self.safety(live);
                }
                ToBridge::Stop => {
                    self.armed = false;
                    self.robot.command(Command::Stop);
                    self.safety(live);
                }
                ToBridge::Drive(body) if self.armed => {
                    self.driven = self.robot.stamp().seconds();
                    self.robot.command(body.motion);
                    self.errand = body.motion.is_manoeuvre().then_some(header.sequence);
                }
                ToBridge::Hold { .. } => self.driven = self.robot.stamp().seconds(),
                _ => (),
            }
            self.said.push(message);
        }
    }

    /// 50 ms.
    fn step(&mut self, live: &mut Live) {
        live.tick(self.micros()).unwrap();
        self.hear(live);
        if self.robot.stamp().seconds() - self.driven > 0.2 {
            self.robot.command(Command::Stop);
        }
        for _ in 0..5 {
            self.robot.advance(0.01);
            let odometry = OdometryBody::new(0, &self.robot.odometry());
            self.tell(live, &FromBridge::Odometry(odometry));
            while let Some(scan) = self.robot.take_scan() {
                self.tell(live, &FromBridge::Scan(ScanBody::new(0, &scan)));
            }
            if let (false, Some(sequence)) = (self.robot.is_busy(), self.errand) {
                self.errand = None;
                let (client, busy) = (1, false);
                let body = ManoeuvreBody {
                    client,
                    sequence,
                    busy,
                };
                self.tell(live, &FromBridge::Manoeuvre(body));
            }
        }
        self.hear(live);
    }
}

fn live() -> Live {
    Live::new(LiveConfig {
        name: "test".to_owned(),
        token: Some("secret".to_owned()),
        method: Method::LineEkf,
        prior_map: None,
        cycle: false,
        settings: vec![],
        seed: 1,
    })
    .unwrap()
}

/// Where the robot is in the map's frame.
fn truth(bridge: &Bridge) -> Pose2 {
    bridge.robot.world().start.inverse() * bridge.robot.truth()
}

/// What the bridge reported, recorded and mapped again.
fn replayed(reported: &[(u64, FromBridge)]) -> Replay {
    let recording = Recording::parse(&fixture::write(reported)).unwrap();
    let log = Log::from(recording);
    let settings = log.settings();
    let mut replay = Replay::new(log, Method::LineEkf, &settings).unwrap();
    while replay.step().unwrap() {}
    replay
}

/// Drives to a goal; where the robot stood at the end, and what it did until then.
fn drive_to(goal: Point2<f64>, sensor: SensorModel) -> (Bridge, Live) {
    drive(Bridge::new(sensor), live(), goal)
}

fn drive(mut bridge: Bridge, mut live: Live, goal: Point2<f64>) -> (Bridge, Live) {
    bridge.greet(&mut live);
    bridge.hear(&mut live);
    live.take_lease(bridge.micros(), false);
    for _ in 0..20 {
        bridge.step(&mut live);
    }
    assert!(live.client().is_armed());
    live.set_mode(Mode::GoTo(goal));
    for _ in 0..4000 {
        bridge.step(&mut live);
        if live.session().pilot().status().is_over() {
            break;
        }
    }
    let status = live.session().pilot().status();
    assert!(
        matches!(status, Status::Finished(Finish::GoalReached { .. })),
        "{status:?}"
    );
    (bridge, live)
}

#[test]
fn a_robot_behind_a_bridge_is_driven_to_a_goal_and_mapped() {
    let goal = Point2::new(0.7, 0.0);
    let (bridge, live) = drive_to(goal, SensorModel::lidar());
    let truth = truth(&bridge);
    let off = (truth.position() - goal).norm();
    assert!(
        off < 0.15,
        "stands {off} m from the goal: {}",
        live.session().pilot().status()
    );
    let error = (live.session().slam().estimate().pose.position() - truth.position()).norm();
    assert!(error < 0.02, "estimate is {error} m off");
    assert!(live.session().scans() > 20 && live.session().slam().view().landmarks.len() >= 4);
    assert_eq!(live.dropped, 0);

    let mut replay = replayed(&bridge.reported);
    assert_eq!(replay.take_notes(), [""; 0]);
    assert_eq!(
        (replay.progress(), replay.session().robot().name),
        (1.0, "rp6")
    );
    assert_eq!(replay.session().scans(), live.session().scans());
    assert_eq!(
        replay.session().slam().trajectory(),
        live.session().slam().trajectory()
    );
    assert!(
        replay.time() > 2.0 && replay.odometry_trajectory().count() == replay.session().scans()
    );
}

#[test]
fn a_robot_behind_a_bridge_finds_itself_in_a_prior_map_and_fits_another_building_worse() {
    let goal = Point2::new(0.7, 0.0);
    let known_to = |name: &str| {
        let world = worlds::builtin(name).unwrap();
        let walls = world.walls();
        let walls = walls.iter().map(|wall| wall.segment);
        let mut live = live();
        live.config.method = Method::PriorMap;
        live.config.prior_map = Some(PriorMap::of_walls(walls, &world.start));
        live
    };
    let (mut bridge, mut live) = drive(Bridge::new(SensorModel::lidar()), known_to("arena"), goal);
    // Whether it fits is said after thirty scans.
    while live.session().scans() < 40 {
        bridge.step(&mut live);
    }
    assert_eq!(live.session().slam().method(), Method::PriorMap);
    let fit = live.session().slam().view().prior_map_fit.unwrap();
    assert!(!fit.is_misfit() && fit.part() > Some(0.9), "{fit:?}");
    let error =
        (live.session().slam().estimate().pose.position() - truth(&bridge).position()).norm();
    assert!(error < 0.02, "estimate is {error} m off");
    // The maze is another building.
    let (mut bridge, mut live) = (Bridge::new(SensorModel::lidar()), known_to("maze"));
    bridge.greet(&mut live);
    for _ in 0..200 {
        bridge.step(&mut live);
    }
    let part = live.session().slam().view().prior_map_fit.unwrap().part();
    assert!(part.is_some_and(|part| part < 0.9), "{part:?}");
}

#[test]
fn a_lidar_behind_a_bridge_drives_by_the_cycle_when_asked_to() {
    let goal = Point2::new(0.7, 0.0);
    let mut live = live();
    live.set_cycle(true);
    let (bridge, mut live) = drive(Bridge::new(SensorModel::lidar()), live, goal);
    let off = (truth(&bridge).position() - goal).norm();
    assert!(off < 0.15, "stands {off} m from the goal");
    let driven: Vec<&Command> = bridge
        .said
        .iter()
        .filter_map(|message| match message {
            ToBridge::Drive(body) => Some(&body.motion),
            _ => None,
        })
        .collect();
    // Turns and legs, as for a sensor that scans on command; its own is not commanded to scan.
    assert!(
        driven
            .iter()
            .any(|motion| matches!(motion, Command::Forward(_)))
    );
    let is_continuous =
        |motion: &&&Command| matches!(motion, Command::Velocity { .. } | Command::Scan);
    assert_eq!(driven.iter().find(is_continuous), None);
    let stages = live.session().stages();
    for (name, stage) in crate::pilot::Stage::ALL {
        assert!(stages.report(stage).is_some(), "{name}: {stages:?}");
    }
    // By hand it drives while it scans: the cycle goes on with the next task.
    live.drive(0.5, 0.0);
    assert!(!live.session().scans_on_command());
    live.set_mode(Mode::Explore);
    assert!(live.session().scans_on_command());
}

#[test]
fn without_a_map_the_line_filter_draws_its_own() {
    let mut live = live();
    live.config.method = Method::PriorMap;
    Bridge::new(SensorModel::lidar()).greet(&mut live);
    assert_eq!(live.session().slam().method(), Method::LineEkf);
    let notes = live.take_notes();
    assert!(notes[0].text.contains("No map was given"), "{notes:?}");
}

/// How far before the wall a robot stands that is driven at it by hand; from the start with
/// `settings`, or with `later` ones after a second.
fn room_ahead(settings: &[(&str, f64)], later: &[(&str, f64)]) -> f64 {
    let owned = |changes: &[(&str, f64)]| {
        let changes = changes.iter();
        changes
            .map(|(key, value)| ((*key).to_owned(), *value))
            .collect::<Vec<_>>()
    };
    let (mut bridge, mut live) = (Bridge::new(SensorModel::lidar()), live());
    live.config.settings = owned(settings);
    bridge.greet(&mut live);
    bridge.hear(&mut live);
    live.take_lease(bridge.micros(), false);
    for _ in 0..20 {
        bridge.step(&mut live);
    }
    live.drive(1.0, 0.0);
    // Ten seconds: it has come to stand, and nobody has walked up to it.
    for step in 0..200 {
        if step == 20 && !later.is_empty() {
            live.reconfigure(owned(later)).unwrap();
        }
        bridge.step(&mut live);
    }
    let (forward, _) = bridge.robot.speeds();
    assert!(forward.abs() < 0.05, "still drives: {forward}");
    let (truth, world) = (bridge.robot.truth(), bridge.robot.world());
    let ahead = truth.rotate(nalgebra::Vector2::x());
    let caster = crate::sim::Caster::new(world.walls());
    let hit = caster.cast(truth.position(), ahead, 100.0);
    hit.unwrap().distance
}

#[test]
fn a_robot_behind_a_bridge_obeys_settings_and_their_changes() {
    let usual = room_ahead(&[], &[]);
    let wide = [("pilot.gap", 0.4)];
    let (from_the_start, on_the_way) = (room_ahead(&wide, &[]), room_ahead(&[], &wide));
    assert!(from_the_start > usual + 0.2, "{from_the_start} {usual}");
    assert!((on_the_way - from_the_start).abs() < 0.05, "{on_the_way}");
}

#[test]
fn settings_stay_with_another_robot_and_wrong_ones_change_nothing() {
    let (mut bridge, mut live) = (Bridge::new(SensorModel::lidar()), live());
    let changes = vec![
        ("points.max_range".to_owned(), 7.0),
        ("odometry.left".to_owned(), 0.01),
    ];
    live.reconfigure(changes).unwrap();
    for wrong in [("pilot.gap", -1.0), ("pilot.no_such", 0.0)] {
        let wrong = vec![(wrong.0.to_owned(), wrong.1)];
        assert!(live.reconfigure(wrong).is_err());
    }
    bridge.greet(&mut live);
    assert_eq!(live.begun, 1);
    assert_eq!(live.session().slam().config().points.max_range, 7.0);
    assert_eq!(live.session().calibration().wear.left, 0.01);
}

#[test]
fn a_robot_that_drives_by_the_cycle_behind_a_bridge_shows_it_as_a_simulated_one() {
    let (_, live) = drive_to(Point2::new(0.8, 0.3), SensorModel::rangers());
    let stages = live.session().stages();
    assert!(live.session().scans_on_command() && stages.round() > 1);
    for (name, stage) in crate::pilot::Stage::ALL {
        assert!(stages.report(stage).is_some(), "{name}");
    }
}

/// Sweeps of a robot that stands take seconds; the recording names the robot, and so it is mapped
/// as one.
#[test]
fn a_recording_of_sweeps_is_mapped_as_it_was_live() {
    let (bridge, live) = drive_to(Point2::new(0.8, 0.3), SensorModel::rangers());
    let replay = replayed(&bridge.reported);
    assert!(replay.log().scans_on_command());
    assert_eq!(
        replay.session().slam().trajectory(),
        live.session().slam().trajectory()
    );
}

#[test]
fn a_recording_without_the_robots_name_has_its_odometry_all_the_same() {
    let (mut bridge, _) = drive_to(Point2::new(0.5, 0.0), SensorModel::lidar());
    bridge
        .reported
        .retain(|(_, message)| !matches!(message, FromBridge::Hello(_)));
    let replay = replayed(&bridge.reported);
    assert_eq!(
        (replay.session().robot().name, replay.log().robot().name),
        ("pioneer", "pioneer")
    );
    let off =
        (replay.session().slam().estimate().pose.position() - truth(&bridge).position()).norm();
    assert!(off < 0.03, "{off} m");
}

#[test]
fn legs_turns_and_sweeps_of_the_cycle_are_waited_for() {
    let goal = Point2::new(0.8, 0.3);
    let (bridge, live) = drive_to(goal, SensorModel::rangers());
    let error =
        (live.session().slam().estimate().pose.position() - truth(&bridge).position()).norm();
    assert!(error < 0.10, "estimate is {error} m off");
    let drives: Vec<Command> = bridge
        .said
        .iter()
        .filter_map(|message| match message {
            ToBridge::Drive(body) => Some(body.motion),
            _ => None,
        })
        .collect();
    let sweeps = drives
        .iter()
        .filter(|motion| **motion == Command::Scan)
        .count();
    // The first sweep, begun by hand, was given up for the errand.
    assert!(
        sweeps >= 3 && live.session().scans() == sweeps - 1,
        "{drives:?}"
    );
    assert!(
        drives
            .iter()
            .any(|motion| matches!(motion, Command::Forward(_)))
    );
    assert!(
        bridge
            .said
            .iter()
            .any(|message| matches!(message, ToBridge::Hold { .. }))
    );
}

#[test]
fn whatever_disarms_ends_the_errand_and_nothing_goes_on_by_itself() {
    let (mut bridge, mut live) = (Bridge::new(SensorModel::lidar()), live());
    bridge.greet(&mut live);
    bridge.hear(&mut live);
    live.take_lease(bridge.micros(), false);
    live.set_mode(Mode::Explore);
    for _ in 0..100 {
        bridge.step(&mut live);
    }
    assert!(live.session().distance() > 0.05, "it has begun");
    // Somebody else presses Stop.
    bridge.armed = false;
    bridge.safety(&mut live);
    let before = bridge.said.len();
    for _ in 0..20 {
        bridge.step(&mut live);
    }
    live.take_lease(bridge.micros(), false);
    for _ in 0..20 {
        bridge.step(&mut live);
    }
    assert!(live.client().is_armed());
    let moves = |message: &ToBridge| matches!(message, ToBridge::Drive(body) if body.motion != Command::Stop);
    assert!(!bridge.said[before..].iter().any(moves));
    assert_eq!(live.session().pilot().mode(), Mode::Manual);
}

#[test]
fn what_was_asked_for_while_disarmed_does_not_begin_by_itself_when_armed() {
    let (mut bridge, mut live) = (Bridge::new(SensorModel::lidar()), live());
    bridge.greet(&mut live);
    bridge.hear(&mut live);
    live.set_mode(Mode::Explore);
    live.take_lease(bridge.micros(), false);
    for _ in 0..40 {
        bridge.step(&mut live);
    }
    assert!(live.client().is_armed());
    let moves = |message: &ToBridge| matches!(message, ToBridge::Drive(body) if body.motion != Command::Stop);
    assert!(!bridge.said.iter().any(moves));
    assert_eq!(live.session().pilot().mode(), Mode::Manual);
}

#[test]
fn a_new_connection_goes_on_in_the_old_map_without_the_right_to_drive() {
    let (mut bridge, mut live) = (Bridge::new(SensorModel::lidar()), live());
    bridge.greet(&mut live);
    for _ in 0..60 {
        bridge.step(&mut live);
    }
    let walls = live.session().slam().view().landmarks.len();
    assert!(walls > 0);
    live.reconnect();
    for _ in 0..100 {
        bridge.robot.advance(0.01);
    }
    // What the robot did meanwhile is lost.
    bridge.robot.odometry();
    while bridge.robot.take_scan().is_some() {}
    bridge.greet(&mut live);
    for _ in 0..40 {
        bridge.step(&mut live);
    }
    assert!(!live.client().is_armed());
    assert!(live.session().slam().view().landmarks.len() >= walls);
    let notes = live.take_notes();
    assert!(
        notes.iter().any(|note| note.text.contains("1.0 s")),
        "{notes:?}"
    );
    let error = live.session().slam().estimate().pose.position() - truth(&bridge).position();
    assert!(error.norm() < 0.05, "{} m off", error.norm());
}

#[test]
fn a_reading_that_cannot_be_is_told_and_left_out() {
    let (mut bridge, mut live) = (Bridge::new(SensorModel::lidar()), live());
    bridge.greet(&mut live);
    bridge.step(&mut live);
    let mut body = OdometryBody::new(0, &bridge.robot.odometry());
    body.motion[0] = f64::NAN;
    let before = live.session().dead_reckoning();
    bridge.tell(&mut live, &FromBridge::Odometry(body));
    assert_eq!(live.session().dead_reckoning(), before);
    let notes = live.take_notes();
    assert!(
        notes.iter().any(|note| note.text.contains("not finite")),
        "{notes:?}"
    );
}
