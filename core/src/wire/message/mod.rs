//! The messages between the bridge and whoever watches or drives through it: bytes or text in,
//! typed values out, and back.
//!
//! In: one WebSocket message (binary, or text behind `?fmt=json`). Out: a [`Header`] and a
//! [`FromBridge`] or [`ToBridge`].
//!
//! # Bytes
//!
//! | offset | bytes | what |
//! |---|---|---|
//! | 0 | 2 | [`MAGIC`], little-endian: `SL` |
//! | 2 | 1 | [`PROTOCOL`] |
//! | 3 | 1 | kind: number of the variant, from 0 in the order in which it stands here; plus 128 towards the bridge |
//! | 4 | 4 | sequence, little-endian: counts the messages of this connection and direction, from 1 |
//! | 8 | 8 | time of the sender, little-endian: µs since it started, never the wall clock |
//! | 16 | | body of the variant, by [postcard](https://postcard.jamesmunns.com/wire-format) |
//!
//! Enums and structs only grow at their ends; [`SCHEMA`] changes with any of them, and a test holds
//! it to that. The same as text:
//! `{"protocol":2,"sequence":7,"micros":123,"message":{"Drive":{…}}}`, where a range that is no
//! number stands as `"inf"` (nothing came back) or `"nan"` (invalid), and the schema of a hello as
//! sixteen hexadecimal figures, for JavaScript's numbers hold 53 bits; a number is read there, too.
//!
//! # A conversation
//!
//! 1. `GET /bridge.json` on the page's own server says whether a robot is behind it ([`About`]),
//!    and where the WebSocket is: `/ws`. A page that is served by nothing else than files gets 404
//!    there.
//! 2. The bridge speaks first: [`FromBridge::Hello`], with its version, [`SCHEMA`], the robot's
//!    figures, and a challenge.
//! 3. Within 2 s the client answers [`ToBridge::Hello`], with [`proof`] made of challenge and token
//!    if it has one (the page has it from the fragment of its address, `#token=…`), else without.
//!    [`FromBridge::Welcome`] says as whom it is taken, and what it may do ([`Role`]): who has no
//!    token watches, and never drives. A wrong proof, or nothing in time, ends the connection
//!    ([`close::ACCESS`]); so does another schema than the bridge's ([`close::OTHER_SCHEMA`]), and
//!    at any time that the right is taken away ([`close::REVOKED`]).
//! 4. Streams follow, newest first: a slow client gets fewer scans and readings, and learns how
//!    many it missed ([`FromBridge::Heartbeat`]). Odometry is never dropped but joined: a later
//!    message then covers a longer time. If its `from` is not the `to` before, the robot's clock
//!    restarted.
//! 5. Each side sends a heartbeat every second. After 5 s without any message the bridge ends the
//!    connection ([`close::HEARTBEAT`]); a client should do likewise.
//! 6. To drive: [`ToBridge::Take`], answered by [`FromBridge::Granted`] with an epoch; then
//!    [`ToBridge::Arm`]; then, as long as a key is held, [`ToBridge::Drive`] at 20 Hz. A leg or a
//!    turn that takes longer is kept alive by [`ToBridge::Hold`] until [`FromBridge::Manoeuvre`]
//!    says that it is over. 200 ms without either stops the robot; 2 s without either, or
//!    [`ToBridge::Renew`], end the lease. A lease taken from another stops the robot first, and
//!    ends the other's connection ([`close::TAKEN_OVER`]).
//! 7. Every driving message says the newest bridge time (`micros` of any header) that its sender
//!    had seen, and how old that may be: both ends of the network's delay count, and neither clock
//!    is compared with the other.
//! 8. A bridge that maps sends pose, map and how it does to every client ([`FromBridge::Pose`],
//!    [`FromBridge::Map`], [`FromBridge::Mapping`]), at once when that comes in. An owner may say
//!    where in that map the robot may be ([`ToBridge::SetGeofence`]); all are told
//!    ([`FromBridge::Geofence`]), and nobody drives it out of that.
//! 9. [`ToBridge::Stop`] is for everyone, with or without a token. It disarms, and so do bumpers,
//!    faults and reconnects ([`FromBridge::Safety`] says why); whoever holds the lease arms again.

mod access;
mod body;
mod drive;
mod geofence;
mod mapping;
mod names;
mod number;
mod packet;
mod role;
mod schema;
#[cfg(test)]
mod tests;

pub use access::{About, CHALLENGE_BYTES, MessageKey, PROOF_BYTES, Verifier, Watching, proof};
pub use body::{
    BatteryBody, BumpersBody, CurrentsBody, Device, DeviceState, LinkBody, LinkState, OdometryBody,
    RangerReading, RangersBody, RobotFigures, ScanBody,
};
pub use drive::{DisarmReason, DriveBody, Lease, ManoeuvreBody, RefusalReason, SafetyBody};
pub use geofence::{FenceState, GeofenceBody, ZoneBody, ZoneUse, fence_of, zones_of};
pub use mapping::{MapBody, MapBodyError, MappingBody, PoseBody, PoseState};
pub use packet::{Format, Header, MAGIC, MessageError, Packet, decode, encode};
pub use role::{Right, Role};

use names::named;
use serde::{Deserialize, Serialize};

/// Version of the layout; a reader refuses any other.
pub const PROTOCOL: u8 = 2;

/// XXH64 over one sample of each kind of message, in both formats: it changes whenever a name, a
/// type or an order does.
pub const SCHEMA: u64 = 0x5d22_c932_c454_3793;

/// Codes with which the bridge closes a connection, beside those of RFC 6455 (1001 bridge ends,
/// 1007 malformed, 1008 too many messages, 1009 too large, 1013 answers and notices, which must not
/// be dropped, were not taken).
pub mod close {
    /// No first message in time, a wrong proof, or none where watching needs one.
    pub const ACCESS: u16 = 4001;
    /// A driving message from somebody who may not drive.
    pub const NO_RIGHT: u16 = 4003;
    /// Nothing was heard for too long.
    pub const HEARTBEAT: u16 = 4008;
    /// Somebody else took the lease.
    pub const TAKEN_OVER: u16 = 4009;
    /// As many watch without the token as the bridge lets in.
    pub const FULL: u16 = 4011;
    /// The client speaks another [`SCHEMA`](super::SCHEMA) or [`PROTOCOL`](super::PROTOCOL): it
    /// would misread what it gets.
    pub const OTHER_SCHEMA: u16 = 4010;
    /// The right of the client was taken away, or changed.
    pub const REVOKED: u16 = 4012;
}

/// What the bridge says. The number of a variant is its kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum FromBridge {
    /// First of all.
    Hello(BridgeHello),
    /// The client's hello was taken.
    Welcome(Welcome),
    /// Each second, and ten times a second to whoever drives.
    Heartbeat(BridgeHeartbeat),
    /// Motion between two stamps.
    Odometry(OdometryBody),
    /// A sweep.
    Scan(ScanBody),
    /// Single range readings, as the converter gave them.
    Rangers(RangersBody),
    /// What the bumpers feel.
    Bumpers(BumpersBody),
    /// Volts.
    Battery(BatteryBody),
    /// Currents of the motors.
    Currents(CurrentsBody),
    /// How the wire to a device does.
    Link(LinkBody),
    /// All devices, whenever one changes.
    Devices(Vec<Device>),
    /// Something happened that a person should read.
    Notice(Notice),
    /// Who drives and whether the robot may move, whenever it changes.
    Safety(SafetyBody),
    /// The lease is the receiver's.
    Granted(Lease),
    /// What the receiver asked for was not done.
    Refused(RefusalReason),
    /// Answer to a probe.
    Probe(ProbeAnswer),
    /// How the recording goes, whenever that changes and each second.
    Recording(RecordingBody),
    /// A manoeuvre began, or is over.
    Manoeuvre(ManoeuvreBody),
    /// A few readings on the move, of a robot that scans only standing: they show who came, and are
    /// not for the map.
    PartialScan(ScanBody),
    /// Where the robot is in the bridge's own map, with each scan; only of a bridge that maps.
    Pose(PoseBody),
    /// That map, once at first and whenever it changed, every second at most.
    Map(MapBody),
    /// How its mapping does, whenever that changes and each second.
    Mapping(MappingBody),
    /// Where the robot may be in that map, and how it stands to that; whenever it changes.
    Geofence(GeofenceBody),
}

/// What a client says. The number of a variant plus 128 is its kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum ToBridge {
    /// First of all.
    Hello(ClientHello),
    /// Each second.
    Heartbeat,
    /// Asks for a [`ProbeAnswer`], to measure delays.
    Probe {
        /// Comes back as it is.
        token: u64,
    },
    /// Asks for the lease.
    Take {
        /// Take it from its current holder too.
        force: bool,
    },
    /// Keeps the lease while not driving.
    Renew {
        /// Of the lease.
        epoch: u32,
    },
    /// Gives the lease back; the robot stops.
    Release {
        /// Of the lease.
        epoch: u32,
    },
    /// Lets the robot move on command.
    Arm {
        /// Of the lease.
        epoch: u32,
    },
    /// A driving command.
    Drive(DriveBody),
    /// The sender is still there: whatever is under way may go on.
    Hold {
        /// Of the lease.
        epoch: u32,
        /// Newest time of the bridge that the sender had seen, µs.
        seen: u64,
        /// How old `seen` may be, ms.
        ttl_millis: u16,
    },
    /// Stand still, and disarm. For everyone.
    Stop,
    /// Cut the motors off, latched in the robot. For everyone.
    EmergencyStop,
    /// Unlatch the emergency stop; the robot stays disarmed.
    ResetEmergencyStop {
        /// Of the lease.
        epoch: u32,
    },
    /// Throw the bridge's own map away, and begin another where the robot stands. A file that it is
    /// kept in keeps the old one, under another name.
    ResetMap,
    /// Where the robot may be in the bridge's own map, from here on; without zones, everywhere.
    SetGeofence {
        /// Polygons in the frame of the map.
        zones: Vec<ZoneBody>,
    },
}

/// The bridge introduces itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BridgeHello {
    /// Version of the program.
    pub version: String,
    /// Its [`SCHEMA`]; in text, hexadecimal.
    #[serde(with = "schema")]
    pub schema: u64,
    /// Drawn again for each connection; a proof for one is of no use on another.
    pub challenge: [u8; CHALLENGE_BYTES],
    /// Whether watching needs a token.
    pub watching: Watching,
    /// The robot behind the bridge; none where only sensors are.
    pub robot: Option<RobotFigures>,
    /// After so many ms without a driving message the robot is stopped.
    pub watchdog_millis: u16,
    /// After so many ms without being used a lease ends.
    pub lease_millis: u16,
}

/// A client introduces itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClientHello {
    /// Its [`SCHEMA`]; in text, hexadecimal.
    #[serde(with = "schema")]
    pub schema: u64,
    /// How others see it: `phone`, `desk`. A bridge cuts off what is beyond 64 bytes.
    pub name: String,
    /// [`proof`] of the token; none to watch.
    pub proof: Option<[u8; PROOF_BYTES]>,
}

/// What the receiver may do.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Welcome {
    /// Number of the client, as it stands in [`SafetyBody::driver`].
    pub client: u32,
    /// Whether it may take the lease.
    pub may_drive: bool,
    /// What its right is good for.
    pub role: Role,
    /// Name of its right; empty without one, and for the bridge's own first token.
    pub name: String,
}

/// The bridge is alive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BridgeHeartbeat {
    /// Readings that this client missed since it connected, because newer ones came before it took
    /// them.
    pub dropped: u64,
    /// Clients that are connected.
    pub clients: u16,
    /// Newest stamp of the robot, µs since it started.
    pub robot_micros: u64,
}

/// When a probe passed where.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProbeAnswer {
    /// As it was asked.
    pub token: u64,
    /// The bridge's time when the probe came, µs; the header has that of the answer.
    pub came_micros: u64,
    /// Newest stamp of the robot, µs since it started.
    pub robot_micros: u64,
    /// The bridge's time when that stamp came, µs.
    pub robot_came_micros: u64,
}

/// Something that a person should read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Notice {
    /// Its severity.
    pub severity: Severity,
    /// One sentence: what, and what to do.
    pub text: String,
}

named! {
    /// The severity of a notice.
    pub enum Severity {
        /// Good to know.
        Info = "info",
        /// Something does not go as it should.
        Warning = "warning",
        /// The robot was stopped, or data is being lost.
        Error = "error",
    }
}

/// How a recording goes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RecordingBody {
    /// Name of the file, without its folder.
    pub file: String,
    /// Messages that stand in the file and survive the end of the program.
    pub acknowledged: u64,
    /// Messages that could not be written.
    pub lost: u64,
    /// Why nothing more is written; none while all is well.
    pub fault: Option<String>,
}
