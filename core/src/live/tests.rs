//! The loop closed in a simulated room, with the messages of a bridge between robot and estimate.

mod connection;
mod driving;
mod fence;
mod homing;
mod settings;

use nalgebra::Point2;

use super::*;
use crate::geom::Pose2;
use crate::pilot::{Finish, Status};
use crate::replay::{Log, Replay};
use crate::robot::Command;
use crate::sim::{SensorModel, Simulation, worlds};
use crate::wire::message::{
    BridgeHello, CHALLENGE_BYTES, DisarmReason, Format, Header, Lease, ManoeuvreBody, OdometryBody,
    Role, SCHEMA, SafetyBody, ScanBody, ToBridge, Watching, Welcome, decode, encode,
};
use crate::wire::recording::{Recording, fixture};

/// A minimal bridge: it grants what is asked for, passes commands on, and stops a robot without a
/// driver.
struct Bridge {
    robot: Simulation,
    sequence: u32,
    armed: bool,
    /// Whether the right to drive was withdrawn.
    refuses: bool,
    driven: f64,
    /// Sequence number of the errand in progress.
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
            refuses: false,
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
            role: Role::Driver,
            name: String::new(),
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
                ToBridge::Take { .. } if self.refuses => {
                    self.tell(live, &FromBridge::Refused(RefusalReason::NoRight));
                }
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

/// The bridge's reports, recorded and mapped again.
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
