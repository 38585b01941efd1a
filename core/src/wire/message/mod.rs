//! The messages between the bridge and the clients that watch or drive through it: bytes or text
//! in, typed values out, and back.
//!
//! In: one WebSocket message (binary, or text after `?fmt=json`). Out: a [`Header`] and a
//! [`FromBridge`] or [`ToBridge`].
//!
//! # Bytes
//!
//! | offset | bytes | what |
//! |---|---|---|
//! | 0 | 2 | [`MAGIC`], little-endian: `SL` |
//! | 2 | 1 | [`PROTOCOL`] |
//! | 3 | 1 | kind: number of the variant, from 0 in the order below; plus 128 towards the bridge |
//! | 4 | 4 | sequence, little-endian: counts the messages of this connection and direction, from 1 |
//! | 8 | 8 | time of the sender, little-endian: µs since it started, never the wall clock |
//! | 16 | | body of the variant, by [postcard](https://postcard.jamesmunns.com/wire-format) |
//!
//! Enums and structs only grow at their ends. Any change to them changes [`SCHEMA`], which a test
//! enforces. The same message as text:
//! `{"protocol":2,"sequence":7,"micros":123,"message":{"Drive":{…}}}`. There, a range that is not a
//! number is `"inf"` (nothing came back) or `"nan"` (invalid). The schema of a hello is written as
//! sixteen hexadecimal digits, because JavaScript's numbers hold only 53 bits; a number is accepted
//! there, too.
//!
//! # A conversation
//!
//! 1. `GET /bridge.json` on the page's own server says whether a robot is behind it ([`About`]),
//!    and where the WebSocket is: `/ws`. A server that only serves files answers 404.
//! 2. The bridge speaks first: [`FromBridge::Hello`], with its version, [`SCHEMA`], the robot's
//!    figures, and a challenge.
//! 3. Within 2 s the client answers [`ToBridge::Hello`]. If it has a token (the page has it from
//!    the fragment of its address, `#token=…`), the answer holds a [`proof`] made of challenge and
//!    token. [`FromBridge::Welcome`] names the client's right and what it may do ([`Role`]):
//!    without a token it watches and never drives. The bridge ends the connection after a wrong
//!    proof or no answer in time ([`close::ACCESS`]), if the schemas differ
//!    ([`close::OTHER_SCHEMA`]), and at any time if the right is taken away ([`close::REVOKED`]).
//! 4. Streams follow, newest first: a slow client gets fewer scans and readings, and learns how
//!    many it missed ([`FromBridge::Heartbeat`]). Odometry is never dropped but joined, so a later
//!    message then covers a longer time. If its `from` is not the `to` before, the robot's clock
//!    restarted.
//! 5. Each side sends a heartbeat every second. After 5 s without any message the bridge ends the
//!    connection ([`close::HEARTBEAT`]); a client should do the same.
//! 6. To drive: [`ToBridge::Take`], answered by [`FromBridge::Granted`] with an epoch; then
//!    [`ToBridge::Arm`]; then, as long as a key is held, [`ToBridge::Drive`] at 20 Hz. A leg or a
//!    turn that takes longer is kept alive by [`ToBridge::Hold`] until [`FromBridge::Manoeuvre`]
//!    says that it is over. 200 ms without Drive or Hold stop the robot; 2 s without Drive, Hold or
//!    [`ToBridge::Renew`] end the lease. Taking a lease from another client stops the robot first
//!    and ends that client's connection ([`close::TAKEN_OVER`]).
//! 7. Every driving message names the newest bridge time (`micros` of any header) that its sender
//!    had seen, and how old that may be. So the network's delay counts in both directions, and the
//!    two clocks are never compared.
//! 8. A bridge that maps sends pose, map and mapping state to every client ([`FromBridge::Pose`],
//!    [`FromBridge::Map`], [`FromBridge::Mapping`]), as soon as the client is let in. An owner may
//!    set where in that map the robot may be ([`ToBridge::SetGeofence`]). All clients get the fence
//!    ([`FromBridge::Geofence`]), and nobody can drive the robot out of it.
//! 9. Everyone may send [`ToBridge::Stop`], with or without a token. It disarms, and so do bumpers,
//!    faults and reconnects ([`FromBridge::Safety`] gives the reason); the client with the lease
//!    arms again.

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

/// Version of the layout; a reader rejects any other.
pub const PROTOCOL: u8 = 2;

/// XXH64 over one sample of each kind of message, in both formats: it changes whenever a name, a
/// type or an order changes.
pub const SCHEMA: u64 = 0x5d22_c932_c454_3793;

/// Codes with which the bridge closes a connection, in addition to those of RFC 6455 (1001 bridge
/// shuts down, 1007 malformed, 1008 too many messages, 1009 too large, 1013 the client did not read
/// answers and notices, which must not be dropped).
pub mod close {
    /// No first message in time, a wrong proof, or no proof although watching needs one.
    pub const ACCESS: u16 = 4001;
    /// A driving message from a client that may not drive.
    pub const NO_RIGHT: u16 = 4003;
    /// Nothing was heard for too long.
    pub const HEARTBEAT: u16 = 4008;
    /// Another client took the lease.
    pub const TAKEN_OVER: u16 = 4009;
    /// The bridge already has as many watchers without a token as it allows.
    pub const FULL: u16 = 4011;
    /// The client uses another [`SCHEMA`](super::SCHEMA) or [`PROTOCOL`](super::PROTOCOL): it would
    /// misread the messages.
    pub const OTHER_SCHEMA: u16 = 4010;
    /// The client's right was taken away, or changed.
    pub const REVOKED: u16 = 4012;
}

/// Messages of the bridge. The number of a variant is its kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum FromBridge {
    /// The first message.
    Hello(BridgeHello),
    /// The client's hello was accepted.
    Welcome(Welcome),
    /// Each second, and ten times a second to the driver.
    Heartbeat(BridgeHeartbeat),
    /// Motion between two stamps.
    Odometry(OdometryBody),
    /// A sweep.
    Scan(ScanBody),
    /// Single range readings, as the converter gave them.
    Rangers(RangersBody),
    /// State of the bumpers.
    Bumpers(BumpersBody),
    /// Battery voltage.
    Battery(BatteryBody),
    /// Motor currents.
    Currents(CurrentsBody),
    /// State of the wire to a device.
    Link(LinkBody),
    /// All devices, whenever one changes.
    Devices(Vec<Device>),
    /// Something happened that a person should read.
    Notice(Notice),
    /// Who drives and whether the robot may move, whenever it changes.
    Safety(SafetyBody),
    /// The receiver has the lease.
    Granted(Lease),
    /// The receiver's request was refused.
    Refused(RefusalReason),
    /// Answer to a probe.
    Probe(ProbeAnswer),
    /// State of the recording, whenever it changes and each second.
    Recording(RecordingBody),
    /// A manoeuvre began, or is over.
    Manoeuvre(ManoeuvreBody),
    /// A few readings on the move, of a robot that scans only while standing: they show walkers,
    /// and are not for the map.
    PartialScan(ScanBody),
    /// Where the robot is in the bridge's own map, with each scan; only of a bridge that maps.
    Pose(PoseBody),
    /// That map, once at the start and whenever it has changed, at most every second.
    Map(MapBody),
    /// State of the mapping, whenever it changes and each second.
    Mapping(MappingBody),
    /// Where the robot may be in that map, and whether it is there; whenever either changes.
    Geofence(GeofenceBody),
}

/// Messages of a client. The number of a variant plus 128 is its kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum ToBridge {
    /// The first message.
    Hello(ClientHello),
    /// Each second.
    Heartbeat,
    /// Asks for a [`ProbeAnswer`], to measure delays.
    Probe {
        /// Returned unchanged.
        token: u64,
    },
    /// Asks for the lease.
    Take {
        /// Take it even if another client holds it.
        force: bool,
    },
    /// Keeps the lease while not driving.
    Renew {
        /// Epoch of the lease.
        epoch: u32,
    },
    /// Gives the lease back; the robot stops.
    Release {
        /// Epoch of the lease.
        epoch: u32,
    },
    /// Lets the robot move on command.
    Arm {
        /// Epoch of the lease.
        epoch: u32,
    },
    /// A driving command.
    Drive(DriveBody),
    /// The sender is still there: the motion under way may go on.
    Hold {
        /// Epoch of the lease.
        epoch: u32,
        /// Newest time of the bridge that the sender had seen, µs.
        seen: u64,
        /// How old `seen` may be, ms.
        ttl_millis: u16,
    },
    /// Stop and disarm the robot. Everyone may.
    Stop,
    /// Cut the motors off, latched in the robot. Everyone may.
    EmergencyStop,
    /// Unlatch the emergency stop; the robot stays disarmed.
    ResetEmergencyStop {
        /// Epoch of the lease.
        epoch: u32,
    },
    /// Discard the bridge's own map, and begin another where the robot stands. If the map has a
    /// file, the old one is kept under another name.
    ResetMap,
    /// Set where the robot may be in the bridge's own map from now on; without zones, everywhere.
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
    /// Drawn anew for each connection; a proof for one is of no use on another.
    pub challenge: [u8; CHALLENGE_BYTES],
    /// Whether watching needs a token.
    pub watching: Watching,
    /// The robot behind the bridge; none if there are only sensors.
    pub robot: Option<RobotFigures>,
    /// The robot is stopped after this many ms without a driving message.
    pub watchdog_millis: u16,
    /// A lease ends after this many ms without being used.
    pub lease_millis: u16,
}

/// A client introduces itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClientHello {
    /// Its [`SCHEMA`]; in text, hexadecimal.
    #[serde(with = "schema")]
    pub schema: u64,
    /// Its name for others: `phone`, `desk`. The bridge cuts it off after 64 bytes.
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
    /// Role of its right.
    pub role: Role,
    /// Name of its right; empty if it has none, and for the bridge's own first token.
    pub name: String,
}

/// The bridge is alive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BridgeHeartbeat {
    /// Readings that this client missed since it connected, because newer ones replaced them before
    /// it read them.
    pub dropped: u64,
    /// Clients that are connected.
    pub clients: u16,
    /// Newest stamp of the robot, µs since it started.
    pub robot_micros: u64,
}

/// Times at which a probe passed the bridge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProbeAnswer {
    /// The token of the probe.
    pub token: u64,
    /// The bridge's time when the probe arrived, µs; the header has that of the answer.
    pub came_micros: u64,
    /// Newest stamp of the robot, µs since it started.
    pub robot_micros: u64,
    /// The bridge's time when that stamp arrived, µs.
    pub robot_came_micros: u64,
}

/// Something that a person should read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Notice {
    /// Its severity.
    pub severity: Severity,
    /// One sentence: what happened, and what to do.
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

/// State of a recording.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RecordingBody {
    /// Name of the file, without its folder.
    pub file: String,
    /// Messages that are in the file and survive the end of the program.
    pub acknowledged: u64,
    /// Messages that could not be written.
    pub lost: u64,
    /// Why nothing more is written; none if all is well.
    pub fault: Option<String>,
}
