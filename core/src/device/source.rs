//! Sources: what robots and sensors report, the orders they take, and what is known of them in
//! advance.

use crate::robot::{Command, Odometry, RobotModel, Scan};
use crate::wire::message::{
    BatteryBody, BumpersBody, CurrentsBody, DeviceState, LinkBody, RangersBody, RobotFigures,
};

/// What a source reports. The stamps of all serial devices of one program are on one clock; a
/// simulated robot and a recording have their own. If an event is the body of a message, the hub
/// fills in the number of its source.
#[derive(Clone, Debug, PartialEq)]
pub enum SourceEvent {
    /// The motion since the last one.
    Odometry(Odometry),
    /// A whole sweep; it passed [`Scan::validate`].
    Scan(Scan),
    /// A few readings on the move, of a robot that scans only while standing. They show walkers,
    /// and are not for the map. It passed [`Scan::validate`].
    PartialScan(Scan),
    /// Single readings of rangers.
    Rangers(RangersBody),
    /// The state of the bumpers: at each change, and now and then.
    Bumpers(BumpersBody),
    /// Battery voltage.
    Battery(BatteryBody),
    /// Motor currents.
    Currents(CurrentsBody),
    /// The state of the link: at each change, and each second.
    Link(LinkBody),
    /// Whether the robot is in a manoeuvre ([`Command::Forward`], [`Command::Turn`],
    /// [`Command::Scan`]): after each order, at each change, and each second; reported after the
    /// readings that belong to it.
    Busy {
        /// Whether it is.
        busy: bool,
        /// Number of the newest order that the source had taken; filled in by the code that passes
        /// orders on.
        after: u64,
    },
    /// The state of the device: at each change.
    Device {
        /// Its state.
        state: DeviceState,
        /// The device's description of itself; empty until it has sent one.
        model: String,
        /// For a fault: cause and cure, in a sentence.
        detail: String,
    },
}

/// An order to a source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    /// A command to the robot. The bridge stops a robot that is no longer driven. A source need not
    /// watch for that, but may repeat the last command if the robot's own watchdog needs it.
    Command(Command),
    /// Cut the motors off, and keep them off.
    EmergencyStop,
    /// Undo the emergency stop; this must not make anything move.
    ResetEmergencyStop,
}

impl Order {
    /// Whether it takes some time and then ends by itself.
    #[must_use]
    pub fn is_manoeuvre(&self) -> bool {
        matches!(self, Self::Command(command) if command.is_manoeuvre())
    }
}

/// What is known of a source before it starts.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// As it was named on the command line: `sim:arena`.
    pub name: String,
    /// The model of its robot; none for a sensor.
    pub robot: Option<RobotModel>,
    /// Whether that robot takes commands; that of a recording does not.
    pub takes_orders: bool,
    /// Whether it scans only on [`Command::Scan`], while standing.
    pub scans_on_command: bool,
}

impl Profile {
    /// Of a sensor that scans all the time: no robot, and it takes no orders.
    #[must_use]
    pub fn of_sensor(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            robot: None,
            takes_orders: false,
            scans_on_command: false,
        }
    }
}

/// Whether these sources scan only on [`Command::Scan`]. A robot that scans on command may carry a
/// lidar that turns all the time, and then nobody needs to wait for a scan.
pub fn scans_on_command(sources: &[&Profile]) -> bool {
    let has_lidar = sources.iter().any(|profile| profile.robot.is_none());
    !has_lidar && robot(sources).is_some_and(|robot| robot.scans_on_command)
}

/// The source with the robot: the first that takes orders, else the first that has one.
fn robot<'a>(sources: &[&'a Profile]) -> Option<&'a Profile> {
    let robots = || (sources.iter().copied()).filter(|profile| profile.robot.is_some());
    let driven = robots().find(|profile| profile.takes_orders);
    driven.or_else(|| robots().next())
}

/// The figures of that robot, for the program that steers it.
#[must_use]
pub fn robot_figures(sources: &[&Profile]) -> Option<RobotFigures> {
    let robot = robot(sources)?.robot?;
    Some(RobotFigures::new(&robot, scans_on_command(sources)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lidar_beside_a_robot_that_scans_on_command_scans_all_the_time() {
        let of = |robot, scans_on_command| Profile {
            name: String::new(),
            robot,
            takes_orders: robot.is_some(),
            scans_on_command,
        };
        let robot = of(Some(RobotModel::rp6()), true);
        let lidar = of(None, false);
        assert!(scans_on_command(&[&robot]));
        for sources in [[&robot, &lidar], [&lidar, &robot]] {
            assert!(!scans_on_command(&sources));
        }
        assert!(!scans_on_command(&[&lidar]));
    }
}
