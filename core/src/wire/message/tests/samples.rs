//! One message of each kind, in their order, with distinct figures: [`super::super::SCHEMA`] is
//! computed from them.

use super::super::*;
use crate::robot::{Command, RobotModel};

pub(super) fn from_bridge() -> Vec<FromBridge> {
    let (source, stamp) = (1, 2_000_000);
    vec![
        FromBridge::Hello(BridgeHello {
            version: "0.1.0".into(),
            schema: 3,
            challenge: [4; CHALLENGE_BYTES],
            watching: Watching::Token,
            robot: Some(RobotFigures::new(&RobotModel::rp6(), false)),
            watchdog_millis: 200,
            lease_millis: 2000,
        }),
        FromBridge::Welcome(Welcome {
            client: 7,
            may_drive: true,
            role: Role::Driver,
            name: "anna".into(),
        }),
        FromBridge::Heartbeat(BridgeHeartbeat {
            dropped: 8,
            clients: 2,
            robot_micros: 9,
        }),
        FromBridge::Odometry(OdometryBody {
            source,
            from: 1_990_000,
            to: stamp,
            motion: [0.1, 0.2, 0.3],
            cov: [1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
        }),
        FromBridge::Scan(ScanBody {
            source,
            stamp,
            mount: [0.1, 0.2, 0.3],
            bearings: vec![0.0, 0.5, 1.0],
            ranges: vec![1.5, f32::INFINITY, f32::NAN],
            sigmas: vec![0.01, 0.02, 0.03],
            bearing_sigma: 0.001,
            max_range: 6.0,
            sweep: 0.1,
            qualities: vec![47, 0, 0],
        }),
        FromBridge::Rangers(RangersBody {
            source,
            stamp,
            readings: vec![RangerReading {
                index: 3,
                servo: 0.5,
                raw: 512,
            }],
        }),
        FromBridge::Bumpers(BumpersBody {
            source,
            stamp,
            left: true,
            right: false,
        }),
        FromBridge::Battery(BatteryBody {
            source,
            stamp,
            volts: 7.25,
        }),
        FromBridge::Currents(CurrentsBody {
            source,
            stamp,
            left: 0.25,
            right: 0.5,
        }),
        FromBridge::Link(LinkBody {
            source,
            state: LinkState::ResetNeeded,
            round_trip: Some(0.015),
            damaged: 10,
            skipped: 11,
        }),
        FromBridge::Devices(vec![Device {
            source,
            name: "rplidar:/dev/ttyUSB0".into(),
            model: "RPLIDAR A1".into(),
            state: DeviceState::Fault,
            detail: "unplugged".into(),
        }]),
        FromBridge::Notice(Notice {
            severity: Severity::Warning,
            text: "the battery is low".into(),
        }),
        FromBridge::Safety(SafetyBody {
            driver: Some(7),
            driver_name: "phone".into(),
            armed: false,
            emergency: true,
            reason: DisarmReason::Shutdown,
        }),
        FromBridge::Granted(Lease {
            epoch: 12,
            millis: 2000,
        }),
        FromBridge::Refused(RefusalReason::NotFinite),
        FromBridge::Probe(ProbeAnswer {
            token: 13,
            came_micros: 14,
            robot_micros: 15,
            robot_came_micros: 16,
        }),
        FromBridge::Recording(RecordingBody {
            file: "flat.mcap".into(),
            acknowledged: 17,
            lost: 18,
            fault: Some("the disk is full".into()),
        }),
        FromBridge::Manoeuvre(ManoeuvreBody {
            client: 7,
            sequence: 300,
            busy: true,
        }),
        FromBridge::PartialScan(ScanBody {
            source: 18,
            stamp: 19,
            mount: [0.0; 3],
            bearings: vec![0.5],
            ranges: vec![1.5],
            sigmas: vec![0.1],
            bearing_sigma: 0.1,
            max_range: 1.5,
            sweep: 0.05,
            qualities: vec![],
        }),
        FromBridge::Pose(PoseBody {
            stamp: 20,
            pose: [1.0, -2.0, 0.5],
            cov: [0.5, 0.25, 0.0, 0.5, 0.0, 0.125],
            state: PoseState::Localised,
        }),
        FromBridge::Map(MapBody {
            revision: 21,
            cell: 0.05,
            corner: [-1.0, 2.0],
            width: 3,
            height: 100,
            runs: vec![400, 401, 402],
        }),
        FromBridge::Mapping(MappingBody {
            method: "scan-matching".into(),
            scans: 22,
            file: "flat.slamlab".into(),
            saved: 23,
            fault: Some("the disk is full".into()),
        }),
        FromBridge::Geofence(GeofenceBody {
            zones: zones(),
            state: FenceState::Held,
        }),
    ]
}

fn zones() -> Vec<ZoneBody> {
    vec![ZoneBody {
        kind: ZoneUse::KeepOut,
        corners: vec![[0.0, 0.5], [1.5, 0.0], [1.0, -2.0]],
    }]
}

pub(super) fn to_bridge() -> Vec<ToBridge> {
    let epoch = 12;
    vec![
        ToBridge::Hello(ClientHello {
            schema: 3,
            name: "phone".into(),
            proof: Some([5; PROOF_BYTES]),
        }),
        ToBridge::Heartbeat,
        ToBridge::Probe { token: 13 },
        ToBridge::Take { force: true },
        ToBridge::Renew { epoch },
        ToBridge::Release { epoch },
        ToBridge::Arm { epoch },
        ToBridge::Drive(DriveBody {
            epoch,
            seen: 14,
            ttl_millis: 300,
            motion: Command::Scan,
        }),
        ToBridge::Hold {
            epoch,
            seen: 15,
            ttl_millis: 300,
        },
        ToBridge::Stop,
        ToBridge::EmergencyStop,
        ToBridge::ResetEmergencyStop { epoch },
        ToBridge::ResetMap,
        ToBridge::SetGeofence { zones: zones() },
    ]
}
