//! Devices on lines, and the rules that keep a robot safe, without I/O, thread or clock.
//!
//! In: the bytes of a line, what a driver asks for, and the time. Out: bytes for the line, and what
//! robot and sensors report.
//!
//! | module | what it holds |
//! |---|---|
//! | [`source`] | what robots and sensors report, and the orders they take |
//! | [`KINDS`] | the table of device kinds, one row each |
//! | [`Device`] | what is at the other end of a line: [`Rp6`], and each [`Lidar`] |
//! | [`safety`] | whether the robot may move, and by whom |
//! | [`hub`] | all rules and state of a bridge, between sources and clients |
//! | [`LocalBridge`] | a hub with its devices and one client: a page that opened the ports itself |
//!
//! In the bridge, each line has two threads and each client a queue. A page with Web Serial owns
//! the lines and is the only client. Both run the same hub.

pub mod hub;
mod kind;
pub mod ld06;
pub mod lidar;
mod line;
mod local_bridge;
mod report;
pub mod rp6;
pub mod rplidar;
pub mod safety;
pub mod source;
pub mod udp;

pub use kind::{Kind, Probe, Role, UsbAdapter};
pub use lidar::Lidar;
pub use line::{Device, Want, Weight};
pub use local_bridge::LocalBridge;
pub use rp6::Rp6;

use kind::{CP2102, FT232R};
use ld06::Ld06;
use lidar::LidarProtocol as _;
use rplidar::{Rplidar, ScanMode};

/// All kinds of device. Everything that opens, lists, finds or explains devices goes through this
/// table, so a new row makes a device known everywhere.
pub const KINDS: [Kind; 4] = [
    Kind {
        name: "rp6",
        title: "RP6",
        about: "The robot, with the firmware of this project: it drives, counts and sees with its rangers.",
        role: Role::Robot,
        baud_rate: Rp6::BAUD_RATE,
        probe: Probe::Ask,
        adapters: &[FT232R],
        open: |name, _| Box::new(Rp6::new(name)),
    },
    Kind {
        name: "rplidar",
        title: "RPLIDAR",
        about: "A lidar of SLAMTEC, type A1. With an RP6 it is the robot's eye; alone it is carried by hand.",
        role: Role::Lidar,
        baud_rate: Rplidar::BAUD_RATE,
        probe: Probe::Ask,
        adapters: &[CP2102],
        open: |name, mount| Box::new(Lidar::new(name, Rplidar::new(ScanMode::Standard), mount)),
    },
    Kind {
        name: "rplidar-express",
        title: "RPLIDAR, express scans",
        about: "The same lidar with twice as many readings, but without their quality.",
        role: Role::Lidar,
        baud_rate: Rplidar::BAUD_RATE,
        probe: Probe::ByName,
        adapters: &[CP2102],
        open: |name, mount| Box::new(Lidar::new(name, Rplidar::new(ScanMode::Express), mount)),
    },
    Kind {
        name: "ld06",
        title: "LD06",
        about: "A lidar of LDROBOT, LD06 or LD19.",
        role: Role::Lidar,
        baud_rate: Ld06::BAUD_RATE,
        probe: Probe::Listen,
        adapters: &[CP2102],
        open: |name, mount| Box::new(Lidar::new(name, Ld06::default(), mount)),
    },
];
