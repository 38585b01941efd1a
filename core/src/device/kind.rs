//! What the rest of the program needs to know about a kind of device: a row of
//! [`KINDS`](super::KINDS).
//!
//! Command line, `bridge.toml`, doctor, Web Serial and page iterate over the rows and know no
//! device by name.

use super::line::Device;
use crate::geom::Pose2;

/// A kind of device at a serial port.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// As it is typed: `rplidar` in `--source rplidar:/dev/ttyUSB0`.
    pub name: &'static str,
    /// As people call it.
    pub title: &'static str,
    /// What it does, in a sentence or two.
    pub about: &'static str,
    /// Whether it drives or only sees.
    pub role: Role,
    /// Baud rate of its line: 8 bits, no parity, one stop bit.
    pub baud_rate: u32,
    /// How it is recognised at a port.
    pub probe: Probe,
    /// USB adapters that usually come with it. It works with any other as well.
    pub adapters: &'static [UsbAdapter],
    /// Makes the device, from its name in logs and messages and the pose of a lidar on the robot.
    pub open: fn(String, Pose2) -> Box<dyn Device>,
}

/// What a device does for a robot that maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// It drives and has odometry; it may see as well. It knows where its own sensors sit.
    Robot,
    /// It sees, wherever it was mounted.
    Lidar,
}

/// How a device is recognised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Probe {
    /// It sends data unasked: listening is enough.
    Listen,
    /// It answers when it is asked.
    Ask,
    /// It is the device of another row in another mode of measurement. It cannot be told apart from
    /// that one, and is only opened by name.
    ByName,
}

/// A USB-to-serial chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UsbAdapter {
    /// USB vendor number.
    pub vendor: u16,
    /// USB product number.
    pub product: u16,
    /// What is printed on it.
    pub chip: &'static str,
}

/// Silicon Labs CP2102.
pub(super) const CP2102: UsbAdapter = UsbAdapter {
    vendor: 0x10C4,
    product: 0xEA60,
    chip: "CP2102",
};

/// FTDI FT232R.
pub(super) const FT232R: UsbAdapter = UsbAdapter {
    vendor: 0x0403,
    product: 0x6001,
    chip: "FT232R",
};

impl Kind {
    /// The kind with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        super::KINDS.iter().find(|kind| kind.name == name)
    }

    /// Kinds that can be told apart, in the order in which to try them at a port. Robots come
    /// first, because opening the port may have reset one, and its boot loader must hear nothing
    /// foreign; then those that need not be asked.
    #[must_use]
    pub fn in_order_of_trial() -> Vec<&'static Self> {
        let mut kinds: Vec<_> = Self::distinct().collect();
        kinds.sort_by_key(|kind| (kind.role, kind.probe));
        kinds
    }

    /// One kind for each different device.
    pub fn distinct() -> impl Iterator<Item = &'static Self> {
        let all = super::KINDS.iter();
        all.filter(|kind| kind.probe != Probe::ByName)
    }
}

/// Two kinds are equal if their names are.
impl PartialEq for Kind {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::KINDS;

    #[test]
    fn each_row_has_a_name_of_its_own_and_opens_what_it_says() {
        for (at, kind) in KINDS.iter().enumerate() {
            assert_eq!(Kind::named(kind.name), Some(&KINDS[at]));
            let device = (kind.open)("name".into(), Pose2::identity());
            assert_eq!(device.baud_rate(), kind.baud_rate, "{}", kind.name);
            let is_robot = device.profile().robot.is_some();
            assert_eq!(is_robot, kind.role == Role::Robot, "{}", kind.name);
            assert_eq!(device.profile().name, "name");
        }
        assert_eq!(Kind::named("lidar"), None);
    }

    #[test]
    fn robots_are_tried_first_and_then_those_that_speak_unasked() {
        let names: Vec<_> = Kind::in_order_of_trial().iter().map(|k| k.name).collect();
        assert_eq!(names, ["rp6", "ld06", "rplidar"]);
    }
}
