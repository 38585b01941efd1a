//! The client's side of a conversation with a bridge ([`super::message`]); page, scripts and tests
//! share it.
//!
//! In: messages of the bridge, what the user wants, and the time. Out: messages to the bridge, and
//! the state of the conversation.
//!
//! 1. The bridge's hello is answered with a proof of the token, if there is one.
//! 2. [`Client::tick`], at least ten times a second, sends heartbeats and probes, renews the lease,
//!    and notices silence.
//! 3. [`Client::drive`] and [`Client::hold`] add what the bridge requires of a driving message: the
//!    lease's epoch, and the newest bridge time seen. Nothing is sent unless this client has armed
//!    the robot.
//! 4. A manoeuvre (a leg, a turn, a sweep) is under way from the message that gives it until the
//!    bridge says that it is over, or until the robot is disarmed or another client has the lease.
//!
//! Time is µs of the client's own clock; its zero is arbitrary.

#[cfg(test)]
mod tests;

use super::message::{
    BridgeHello, ClientHello, DriveBody, Format, FromBridge, Header, Lease, MessageError,
    ProbeAnswer, SCHEMA, SafetyBody, ToBridge, Welcome, ZoneBody, decode, encode, proof,
};
use crate::robot::Command;

/// Interval of heartbeats, probes and renewals, µs.
const HEARTBEAT: u64 = 1_000_000;
/// A bridge that is silent for longer is gone, µs.
const LONGEST_SILENCE: u64 = 5_000_000;
/// How old the bridge time seen may be when a driving message arrives: about two missed heartbeats
/// of the driver, ms.
const TTL_MILLIS: u16 = 400;

/// Why the conversation cannot go on.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ClientError {
    /// What arrived is not a message.
    #[error("the bridge sent something that is no message: {0}")]
    Message(#[from] MessageError),
    /// The two schemas differ.
    #[error(
        "the bridge is of version {version} and speaks another schema ({theirs:016x}, here {SCHEMA:016x}): reload the page from the bridge"
    )]
    Schema {
        /// The bridge's version.
        version: String,
        /// The bridge's schema.
        theirs: u64,
    },
    /// The bridge did not say hello or welcome when it had to.
    #[error("the bridge sent {what} before its {expected}")]
    Order {
        /// What arrived.
        what: &'static str,
        /// What should have arrived.
        expected: &'static str,
    },
    /// Nothing was heard for too long.
    #[error("the bridge has been silent for {seconds:.0} s: look at the network and at the bridge")]
    Silent {
        /// Duration of the silence.
        seconds: u64,
    },
}

/// How far the conversation is.
#[derive(Clone, Debug, Default, PartialEq)]
enum Phase {
    /// Nothing has been said.
    #[default]
    Begun,
    /// Our hello was sent.
    Answered(BridgeHello),
    /// We are let in.
    In(BridgeHello, Welcome),
}

/// Delays measured by a probe.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Delays {
    /// From here to the bridge and back, s.
    pub round_trip: f64,
    /// Age of the robot's newest reading when the bridge answered, s.
    pub reading_age: f64,
}

/// One connection to a bridge.
#[derive(Clone, Debug, Default)]
pub struct Client {
    name: String,
    token: Option<String>,
    phase: Phase,
    sequence: u32,
    outgoing: Vec<Vec<u8>>,
    /// Newest time of the bridge in any header, µs.
    seen: u64,
    heard: Option<u64>,
    next_heartbeat: u64,
    lease: Option<Lease>,
    safety: Option<SafetyBody>,
    /// Sequence of the message that gave the manoeuvre under way.
    manoeuvre: Option<u32>,
    delays: Option<Delays>,
}

impl Client {
    /// A client that has not heard anything yet. `name` is shown to others; without a token, the
    /// client only watches.
    #[must_use]
    pub fn new(name: &str, token: Option<&str>) -> Self {
        Self {
            name: name.chars().take(16).collect(),
            token: token.map(str::to_owned),
            ..Self::default()
        }
    }

    /// Takes one binary message; returns its header, with the bridge's time, and its content.
    ///
    /// # Errors    [`ClientError`]: the connection is no longer usable.
    pub fn receive(&mut self, now: u64, bytes: &[u8]) -> Result<(Header, FromBridge), ClientError> {
        let (header, message): (_, FromBridge) = decode(bytes, Format::Binary)?;
        self.heard = Some(now);
        self.seen = self.seen.max(header.micros);
        match (&self.phase, &message) {
            (Phase::Begun, FromBridge::Hello(hello)) => self.answer(hello)?,
            (Phase::Begun, _) => return Err(out_of_turn("something", "hello")),
            (_, FromBridge::Hello(_)) => return Err(out_of_turn("a second hello", "end")),
            (Phase::Answered(hello), FromBridge::Welcome(welcome)) => {
                self.phase = Phase::In(hello.clone(), welcome.clone());
                self.next_heartbeat = now;
            }
            (Phase::Answered(_), _) => return Err(out_of_turn("something", "welcome")),
            (Phase::In(..), _) => self.note(now, &message),
        }
        Ok((header, message))
    }

    fn answer(&mut self, hello: &BridgeHello) -> Result<(), ClientError> {
        if hello.schema != SCHEMA {
            return Err(ClientError::Schema {
                version: hello.version.clone(),
                theirs: hello.schema,
            });
        }
        let token = self.token.as_deref();
        let answer = ClientHello {
            schema: SCHEMA,
            name: self.name.clone(),
            proof: token.map(|token| proof(token, &hello.challenge)),
        };
        self.phase = Phase::Answered(hello.clone());
        self.say(0, &ToBridge::Hello(answer));
        Ok(())
    }

    fn note(&mut self, now: u64, message: &FromBridge) {
        match message {
            FromBridge::Granted(lease) => self.lease = Some(*lease),
            FromBridge::Safety(safety) => {
                if safety.driver != self.number() {
                    self.lease = None;
                }
                if self.lease.is_none() || !safety.armed {
                    self.manoeuvre = None;
                }
                self.safety = Some(safety.clone());
            }
            FromBridge::Manoeuvre(ended)
                if !ended.busy
                    && self.number() == Some(ended.client)
                    && self.manoeuvre == Some(ended.sequence) =>
            {
                self.manoeuvre = None;
            }
            FromBridge::Probe(answer) => self.delays = Some(self.measure(now, answer)),
            _ => (),
        }
    }

    fn measure(&self, now: u64, answer: &ProbeAnswer) -> Delays {
        let micros = |n: u64| n as f64 * 1e-6;
        // The time that the bridge itself took does not count as network delay.
        let inside = self.seen.saturating_sub(answer.came_micros);
        let outside = now.saturating_sub(answer.token).saturating_sub(inside);
        Delays {
            round_trip: micros(outside),
            reading_age: micros(answer.came_micros.saturating_sub(answer.robot_came_micros)),
        }
    }

    /// Time passes: sends what is due.
    ///
    /// # Errors    [`ClientError::Silent`]: the bridge is gone.
    pub fn tick(&mut self, now: u64) -> Result<(), ClientError> {
        let silence = now.saturating_sub(*self.heard.get_or_insert(now));
        if silence > LONGEST_SILENCE {
            let seconds = silence / 1_000_000;
            return Err(ClientError::Silent { seconds });
        }
        if !matches!(self.phase, Phase::In(..)) || now < self.next_heartbeat {
            return Ok(());
        }
        self.next_heartbeat = now + HEARTBEAT;
        self.say(now, &ToBridge::Heartbeat);
        self.say(now, &ToBridge::Probe { token: now });
        if let Some(Lease { epoch, .. }) = self.lease {
            self.say(now, &ToBridge::Renew { epoch });
        }
        Ok(())
    }

    /// Asks for the lease; with `force`, takes it from another client too, whose robot then stops.
    pub fn take(&mut self, now: u64, force: bool) {
        self.say(now, &ToBridge::Take { force });
    }

    /// Gives the lease back; the robot stops.
    pub fn release(&mut self, now: u64) {
        if let Some(Lease { epoch, .. }) = self.lease.take() {
            self.say(now, &ToBridge::Release { epoch });
        }
    }

    /// Lets the robot move on command. Does nothing without the lease.
    pub fn arm(&mut self, now: u64) {
        if let Some(Lease { epoch, .. }) = self.lease {
            self.say(now, &ToBridge::Arm { epoch });
        }
    }

    /// A driving command; returns whether it went out: nothing does unless this client has the
    /// lease and the robot is armed.
    pub fn drive(&mut self, now: u64, motion: Command) -> bool {
        let Some(epoch) = self.armed_epoch() else {
            return false;
        };
        let body = DriveBody {
            epoch,
            seen: self.seen,
            ttl_millis: TTL_MILLIS,
            motion,
        };
        self.say(now, &ToBridge::Drive(body));
        self.manoeuvre = motion.is_manoeuvre().then_some(self.sequence);
        true
    }

    /// Whether a manoeuvre of this client is under way.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        self.manoeuvre.is_some()
    }

    /// Stops waiting for the manoeuvre under way: the next command takes its place.
    pub fn give_up_manoeuvre(&mut self) {
        self.manoeuvre = None;
    }

    /// What is under way may go on.
    pub fn hold(&mut self, now: u64) {
        if let Some(epoch) = self.armed_epoch() {
            let hold = ToBridge::Hold {
                epoch,
                seen: self.seen,
                ttl_millis: TTL_MILLIS,
            };
            self.say(now, &hold);
        }
    }

    /// Stops the robot and disarms it, no matter who drives.
    pub fn stop(&mut self, now: u64) {
        self.say(now, &ToBridge::Stop);
    }

    /// Cuts the motors off, no matter who drives.
    pub fn emergency_stop(&mut self, now: u64) {
        self.say(now, &ToBridge::EmergencyStop);
    }

    /// Unlatches the emergency stop. Does nothing without the lease.
    pub fn reset_emergency_stop(&mut self, now: u64) {
        if let Some(Lease { epoch, .. }) = self.lease {
            self.say(now, &ToBridge::ResetEmergencyStop { epoch });
        }
    }

    /// Asks the bridge to begin its own map anew.
    pub fn reset_map(&mut self, now: u64) {
        self.say(now, &ToBridge::ResetMap);
    }

    /// Says where in the bridge's own map the robot may be; without zones, everywhere.
    pub fn set_geofence(&mut self, now: u64, zones: Vec<ZoneBody>) {
        self.say(now, &ToBridge::SetGeofence { zones });
    }

    /// Messages to send, in order; they are taken out of the client.
    pub fn take_outgoing(&mut self) -> Vec<Vec<u8>> {
        std::mem::take(&mut self.outgoing)
    }

    /// The bridge's description of itself and of its robot.
    #[must_use]
    pub fn bridge(&self) -> Option<&BridgeHello> {
        match &self.phase {
            Phase::Begun => None,
            Phase::Answered(hello) | Phase::In(hello, _) => Some(hello),
        }
    }

    /// Whether the bridge let this client in.
    #[must_use]
    pub fn is_in(&self) -> bool {
        matches!(self.phase, Phase::In(..))
    }

    /// Whether it may take the lease.
    #[must_use]
    pub fn may_drive(&self) -> bool {
        self.welcome().is_some_and(|welcome| welcome.may_drive)
    }

    /// Name and role under which the bridge let it in, and what it may do.
    #[must_use]
    pub fn welcome(&self) -> Option<&Welcome> {
        match &self.phase {
            Phase::In(_, welcome) => Some(welcome),
            _ => None,
        }
    }

    /// Its number, as it stands in [`SafetyBody::driver`].
    #[must_use]
    pub fn number(&self) -> Option<u32> {
        self.welcome().map(|welcome| welcome.client)
    }

    /// Whether this client has the lease.
    #[must_use]
    pub fn has_lease(&self) -> bool {
        self.lease.is_some()
    }

    /// Whether the robot moves at this client's commands.
    #[must_use]
    pub fn is_armed(&self) -> bool {
        self.armed_epoch().is_some()
    }

    /// Who drives and whether the robot may move, as last reported.
    #[must_use]
    pub fn safety(&self) -> Option<&SafetyBody> {
        self.safety.as_ref()
    }

    /// Delays on the network; none before the first probe came back.
    #[must_use]
    pub fn delays(&self) -> Option<Delays> {
        self.delays
    }

    fn armed_epoch(&self) -> Option<u32> {
        let is_armed = self.safety.as_ref().is_some_and(|safety| safety.armed);
        self.lease.filter(|_| is_armed).map(|lease| lease.epoch)
    }

    fn say(&mut self, now: u64, message: &ToBridge) {
        self.sequence = self.sequence.wrapping_add(1);
        let header = Header {
            sequence: self.sequence,
            micros: now,
        };
        // All our values can be written; the error is for other writers.
        if let Ok(bytes) = encode(header, message, Format::Binary) {
            self.outgoing.push(bytes);
        }
    }
}

fn out_of_turn(what: &'static str, expected: &'static str) -> ClientError {
    ClientError::Order { what, expected }
}
