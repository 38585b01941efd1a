//! Driving: commands with their lease, what the bridge does with them, and why it may refuse.

use serde::{Deserialize, Serialize};

use super::names::named;

use crate::robot::Command;

/// A driving command.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DriveBody {
    /// Epoch of the sender's lease.
    pub epoch: u32,
    /// Newest time of the bridge that the sender had seen, µs.
    pub seen: u64,
    /// How old `seen` may be, ms.
    pub ttl_millis: u16,
    /// What the robot is to do.
    #[serde(with = "Motion")]
    pub motion: Command,
}

/// A [`Command`] as it crosses the wire.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Command")]
enum Motion {
    #[serde(rename = "Halt")]
    Stop,
    Velocity {
        forward: f64,
        turn: f64,
    },
    Forward(f64),
    Turn(f64),
    Scan,
}

/// Whether a manoeuvre is under way: a leg, a turn or a sweep.
///
/// Sent when it begins and when it is over, however it ends: done, replaced by another command,
/// stopped. If it never began, only its sender learns that it is over. The message that ends it
/// comes after the readings that belong to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ManoeuvreBody {
    /// Number of the client that gave it.
    pub client: u32,
    /// Sequence of the message that gave it.
    pub sequence: u32,
    /// Whether it is under way.
    pub busy: bool,
}

/// The right to drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Lease {
    /// Part of each driving message; each lease has a higher one than all before.
    pub epoch: u32,
    /// The lease ends after this many ms without being used.
    pub millis: u16,
}

/// Who drives, and whether the robot may move.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SafetyBody {
    /// Number of the client that has the lease.
    pub driver: Option<u32>,
    /// Name of that client.
    pub driver_name: String,
    /// Whether driving commands are passed on.
    pub armed: bool,
    /// Whether the emergency stop is latched.
    pub emergency: bool,
    /// Why the robot was last disarmed.
    pub reason: DisarmReason,
}

named! {
    /// Why the robot is disarmed.
    #[derive(Default)]
    pub enum DisarmReason {
        /// Nobody armed it since the bridge started.
        #[default]
        Start = "start",
        /// Somebody pressed Stop.
        Stop = "stop",
        /// Somebody pressed the emergency stop.
        EmergencyStop = "emergency-stop",
        /// The lease was given back.
        Released = "released",
        /// The lease ran out.
        LeaseExpired = "lease-expired",
        /// The lease was taken over.
        TakenOver = "taken-over",
        /// The driver's connection ended.
        DriverGone = "driver-gone",
        /// The link to the robot was lost, or restarted.
        Link = "link",
        /// The robot says nothing any more.
        Silence = "silence",
        /// A bumper was pressed.
        Bumper = "bumper",
        /// The battery is nearly empty.
        Battery = "battery",
        /// The motors work and the robot does not move.
        Stall = "stall",
        /// The robot moves without an order.
        Runaway = "runaway",
        /// The bridge ends.
        Shutdown = "shutdown",
        /// The driver's right was taken away.
        Revoked = "revoked",
        /// The robot has left the geofence.
        Geofence = "geofence",
    }
}

named! {
    /// Why something was not done.
    pub enum RefusalReason {
        /// The sender has no token, or one that is not good for this.
        NoRight = "no-right",
        /// Another client has the lease; it can be taken over.
        Held = "held",
        /// The sender has no lease, or its epoch is an old one.
        StaleEpoch = "stale-epoch",
        /// The sequence is not higher than the one before.
        StaleSequence = "stale-sequence",
        /// What the sender had seen is older than it allows itself, or than the bridge allows.
        TooOld = "too-old",
        /// `seen` is later than now.
        FromTheFuture = "from-the-future",
        /// The robot is not armed.
        Disarmed = "disarmed",
        /// The emergency stop is latched.
        Emergency = "emergency",
        /// The robot cannot be armed, nor its emergency stop reset: its link is down.
        NoRobot = "no-robot",
        /// A figure is not a finite number.
        NotFinite = "not-finite",
        /// The bridge does not map.
        NoMap = "no-map",
        /// A part of the bridge may not arm a robot that was stopped by somebody, or by a fault.
        Stopped = "stopped",
        /// The robot cannot be armed: its battery is nearly empty.
        BatteryLow = "battery-low",
        /// The robot cannot be armed: its sensor has fallen silent.
        NoScan = "no-scan",
        /// The robot cannot be armed: there is a geofence, and it is not known where the robot is.
        NoPose = "no-pose",
        /// What was to be the geofence is none.
        BadFence = "bad-fence",
        /// Only an owner begins a map anew that has a geofence: it goes with the map.
        Fenced = "fenced",
    }
}
