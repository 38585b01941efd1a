//! The loop gives the same result whatever feeds it.

use super::*;
use crate::experiment::{CONTROL_PERIOD, Experiment, ExperimentConfig};
use crate::hash::StateHash;
use crate::live::{Live, LiveConfig};
use crate::replay::{Log, Replay};
use crate::sim::{SensorModel, Simulation, worlds};
use crate::slam::Method;
use crate::wire::message::{
    BridgeHello, CHALLENGE_BYTES, Format, FromBridge, Header, OdometryBody, RobotFigures, Role,
    SCHEMA, ScanBody, Watching, Welcome, encode,
};
use crate::wire::recording::{Recording, fixture};

fn hash_of(session: &Session) -> u64 {
    let mut hash = StateHash::new();
    session.slam().add_to(&mut hash);
    hash.pose(&session.dead_reckoning());
    hash.finish()
}

/// The loop of an experiment by hand: returns the session at its end, and what was fed to it, in
/// the messages of a bridge.
fn driven(config: ExperimentConfig, steps: usize) -> (Session, Vec<(u64, FromBridge)>) {
    let mut sim = Simulation::new(config.world, config.robot, config.sensor, config.seed).unwrap();
    let mut session = Session::new(SessionConfig {
        robot: config.robot,
        scans_on_command: sim.scans_on_command(),
        is_driven: true,
        method: config.method,
        seed: config.seed ^ 0x9E37_79B9_7F4A_7C15,
        slam: config.slam,
        pilot: config.pilot,
        calibration: config.calibration,
    })
    .unwrap();
    session.set_mode(Mode::Explore);
    let mut said = vec![];
    for _ in 0..steps {
        if let Some(command) = session.decide(sim.bumpers(), sim.is_busy()) {
            sim.command(command);
        }
        for _ in 0..5 {
            sim.advance(CONTROL_PERIOD / 5.0);
            let odometry = sim.odometry();
            session.odometry(&odometry).unwrap();
            let micros = sim.stamp().0;
            let body = OdometryBody::new(0, &odometry);
            said.push((micros, FromBridge::Odometry(body)));
            while let Some(scan) = sim.take_partial_scan() {
                session.partial_scan(&scan).unwrap();
            }
            if let Some(scan) = sim.take_scan() {
                session.scan(&scan).unwrap();
                said.push((micros, FromBridge::Scan(ScanBody::new(0, &scan))));
            }
        }
    }
    (session, said)
}

/// A session that is fed only with the messages of a bridge.
fn fed(config: SessionConfig, said: &[(u64, FromBridge)]) -> Session {
    let mut session = Session::new(config).unwrap();
    for (_, message) in said {
        match message {
            FromBridge::Odometry(body) => session.odometry(&body.odometry().unwrap()).unwrap(),
            FromBridge::Scan(body) => session.scan(&body.clone().scan().unwrap()).unwrap(),
            _ => {}
        }
    }
    session
}

fn heard_live(said: &[(u64, FromBridge)]) -> Live {
    let mut live = Live::new(LiveConfig {
        name: "test".to_owned(),
        token: None,
        method: Method::LineEkf,
        prior_map: None,
        cycle: false,
        settings: vec![],
        seed: 1,
    })
    .unwrap();
    for (at, (micros, message)) in said.iter().enumerate() {
        let header = Header {
            sequence: at as u32 + 1,
            micros: *micros,
        };
        let bytes = encode(header, message, Format::Binary).unwrap();
        live.receive(*micros, &bytes).unwrap();
    }
    live
}

#[test]
fn the_same_readings_give_the_same_bits_whatever_the_source() {
    for sensor in [SensorModel::lidar(), SensorModel::rangers()] {
        let world = worlds::builtin("arena").unwrap();
        let robot = world.robot.model();
        let on_command = sensor.scans_on_command();
        let figures = RobotFigures::new(&robot, on_command);
        let config = ExperimentConfig::new(world, robot, sensor, 5);
        let steps = 300;
        let (session, readings) = driven(config.clone(), steps);
        assert!(session.scans() > 1);

        let mut experiment = Experiment::new(config).unwrap();
        for _ in 0..steps {
            experiment.step().unwrap();
        }
        let simulated = hash_of(experiment.session());
        assert_eq!(simulated, hash_of(&session), "simulated");

        let mut said = vec![
            (
                0,
                FromBridge::Hello(BridgeHello {
                    version: "test".to_owned(),
                    schema: SCHEMA,
                    challenge: [1; CHALLENGE_BYTES],
                    watching: Watching::Anyone,
                    robot: Some(figures),
                    watchdog_millis: 200,
                    lease_millis: 2000,
                }),
            ),
            (
                0,
                FromBridge::Welcome(Welcome {
                    client: 1,
                    may_drive: false,
                    role: Role::Watcher,
                    name: String::new(),
                }),
            ),
        ];
        said.extend(readings);
        let settings = Settings::of_robot(&robot, on_command);
        let session = fed(SessionConfig::of(&settings, robot, on_command), &said);
        let live = heard_live(&said);
        assert_eq!(live.session().scans(), session.scans());
        assert_eq!(hash_of(live.session()), hash_of(&session), "live");

        let log = Log::from(Recording::parse(&fixture::write(&said)).unwrap());
        let settings = log.settings();
        let mut replay = Replay::new(log, Method::LineEkf, &settings).unwrap();
        while replay.step().unwrap() {}
        // A recording ends with its last scan, so the drive after it is missing.
        assert_eq!(replay.session().scans(), session.scans());
        let [recorded, fed] = [replay.session(), &session].map(|s| s.slam().trajectory());
        assert_eq!(recorded, fed, "recorded");
    }
}
