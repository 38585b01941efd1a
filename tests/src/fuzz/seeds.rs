//! Real data of devices and clients, with which fuzzing begins.

use slamlab_core::robot::{self, Odometry, Scan, Stamp};
use slamlab_core::sim::{SensorModel, Simulation, worlds};
use slamlab_core::wire::message::{
    ClientHello, DriveBody, Format, FromBridge, Header, OdometryBody, SCHEMA, ScanBody, ToBridge,
    encode,
};
use slamlab_core::wire::rp6::{self, Command};
use slamlab_core::wire::rplidar::request::Request;

use crate::devices::{self, Device, View};

fn said(device: &mut impl Device, seconds: f64) -> Vec<u8> {
    device.advance(seconds)
}

pub(super) fn rp6_reports() -> Vec<Vec<u8>> {
    let Some(mut robot) = worlds::builtin("arena").and_then(|world| devices::Rp6::new(world).ok())
    else {
        return vec![];
    };
    robot.power_on();
    let mut seeds = vec![said(&mut robot, 0.01)];
    for (sequence, command) in (1..).zip(commands()) {
        robot.receive(&rp6::encode(sequence, &command));
        seeds.push(said(&mut robot, 0.06));
    }
    seeds.push(b"[RP6BOOT]\n[READY]\n### EMERGENCY SHUTDOWN! ###\n".to_vec());
    seeds
}

fn commands() -> Vec<Command> {
    vec![
        Command::Greet { nonce: 1 },
        Command::Velocity {
            forward_mm_s: 100,
            turn_mrad_s: -300,
        },
        Command::Forward { way_um: 100_000 },
        Command::Turn {
            angle_urad: -1_570_796,
        },
        Command::Sweep {
            from_mrad: -785,
            to_mrad: 751,
            step_mrad: 35,
        },
        Command::Servo { angle_mrad: 200 },
        Command::SetRate { period_ms: 20 },
        Command::Stop,
        Command::EStop,
        Command::Reset,
        Command::Alive,
    ]
}

pub(super) fn rp6_commands() -> Vec<Vec<u8>> {
    (1..)
        .zip(commands())
        .map(|(sequence, command)| rp6::encode(sequence, &command))
        .collect()
}

fn rplidar_seeds(request: Request) -> Vec<Vec<u8>> {
    let Some(world) = worlds::builtin("arena") else {
        return vec![];
    };
    let mut lidar = devices::Rplidar::new(View::from_start(&world));
    lidar.power_on();
    let mut seeds = vec![said(&mut lidar, 0.0)];
    for request in [Request::Info, Request::Health, Request::Rate, request] {
        lidar.receive(&request.encode());
        seeds.push(said(&mut lidar, 0.05));
    }
    seeds.push(said(&mut lidar, 0.05));
    seeds
}

pub(super) fn rplidar_standard() -> Vec<Vec<u8>> {
    rplidar_seeds(Request::Scan)
}

pub(super) fn rplidar_express() -> Vec<Vec<u8>> {
    rplidar_seeds(Request::ExpressScan)
}

pub(super) fn rplidar_requests() -> Vec<Vec<u8>> {
    [
        Request::Stop,
        Request::Reset,
        Request::Scan,
        Request::Info,
        Request::Health,
        Request::Rate,
        Request::ExpressScan,
    ]
    .map(Request::encode)
    .into()
}

pub(super) fn ld06_seeds() -> Vec<Vec<u8>> {
    let Some(world) = worlds::builtin("arena") else {
        return vec![];
    };
    let mut lidar = devices::Ld06::new(View::from_start(&world));
    lidar.power_on();
    vec![
        said(&mut lidar, 0.01),
        said(&mut lidar, 0.1),
        said(&mut lidar, 0.02),
    ]
}

pub(super) fn pilch_seeds() -> Vec<Vec<u8>> {
    let mut path = vec![1, 0, 0, 0xC2, 1, 0, 12];
    path.extend(b"/dev/ttyUSB0");
    vec![
        b"\xFF\x00HELLO".to_vec(),
        b"\xFF\x011:LIDAR##2:x".to_vec(),
        vec![0xFF, 2],
        path,
        vec![1, 4, 3],
        vec![1, 1],
        vec![1, 2],
        vec![1, 3, 4, 0, 0, 0, 50, 0, 0, 0],
        vec![1, 3, 2, 0, 0, 0, 60, 1, 2, 3, 4, 60, 5, 6, 7, 8],
    ]
}

pub(super) fn messages(format: Format) -> Vec<Vec<u8>> {
    let header = Header {
        sequence: 7,
        micros: 1_000_000,
    };
    let body = DriveBody {
        epoch: 3,
        seen: 5,
        ttl_millis: 300,
        motion: robot::Command::Velocity {
            forward: 0.1,
            turn: -0.2,
        },
    };
    let to: Vec<ToBridge> = vec![
        ToBridge::Hello(ClientHello {
            schema: SCHEMA,
            name: "somebody".into(),
            proof: None,
        }),
        ToBridge::Heartbeat,
        ToBridge::Probe { token: 9 },
        ToBridge::Take { force: true },
        ToBridge::Arm { epoch: 3 },
        ToBridge::Drive(body),
        ToBridge::Hold {
            epoch: 3,
            seen: 5,
            ttl_millis: 300,
        },
        ToBridge::Stop,
    ];
    let mut from = vec![FromBridge::Odometry(OdometryBody::new(
        0,
        &Odometry::standing(Stamp(5)),
    ))];
    from.extend(scan().map(|scan| FromBridge::Scan(ScanBody::new(1, &scan))));
    let to = to
        .iter()
        .filter_map(|message| encode(header, message, format).ok());
    let from = from
        .iter()
        .filter_map(|message| encode(header, message, format).ok());
    to.chain(from).collect()
}

fn scan() -> Option<Scan> {
    let world = worlds::builtin("arena")?;
    let robot = world.robot.model();
    let mut simulation = Simulation::new(world, robot, SensorModel::lidar(), 1).ok()?;
    simulation.advance(0.5);
    let _ = simulation.odometry();
    simulation.take_scan()
}
