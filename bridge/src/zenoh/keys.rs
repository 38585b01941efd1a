//! The keys of a robot, and what is published under them.

use slamlab_core::wire::message::FromBridge;

use crate::rights::Name;

/// Keys of the robot with this name.
#[derive(Clone, Debug)]
pub(super) struct Keys {
    base: String,
}

/// What is published under one key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stream {
    /// The last part of the key.
    pub(super) name: &'static str,
    /// Whether it must not be lost, and is sent before readings.
    pub(super) is_urgent: bool,
    /// Whether it is sent only on change: later clients query the last value.
    pub(super) is_state: bool,
}

impl Keys {
    pub(super) fn of(robot: &Name) -> Self {
        let base = format!("slamlab/{robot}");
        Self { base }
    }

    pub(super) fn stream(&self, name: &str) -> String {
        format!("{}/{name}", self.base)
    }

    pub(super) fn all_streams(&self) -> String {
        format!("{}/*", self.base)
    }

    pub(super) fn stop(&self) -> String {
        format!("{}/stop", self.base)
    }

    pub(super) fn alive(&self, session: &str) -> String {
        format!("{}/alive/{session}", self.base)
    }

    /// Key of a client's messages, and of its liveliness token.
    pub(super) fn to(&self, client: &str) -> String {
        format!("{}/to/{client}", self.base)
    }

    pub(super) fn from(&self, client: u64) -> String {
        format!("{}/from/{client:016x}", self.base)
    }

    /// The number of the client to which the key belongs: 16 hexadecimal digits, as [`Self::from`]
    /// writes them.
    pub(super) fn client(&self, key: &str) -> Option<u64> {
        let digits = key.strip_prefix(&self.base)?.strip_prefix("/to/")?;
        let is_hexadecimal = |c: char| c.is_ascii_digit() || ('a'..='f').contains(&c);
        let is_number = digits.len() == 16 && digits.chars().all(is_hexadecimal);
        u64::from_str_radix(digits, 16).ok().filter(|_| is_number)
    }
}

/// The stream of a message for everybody; none for a message to one client.
pub(super) fn stream(message: &FromBridge) -> Option<Stream> {
    let (name, is_urgent, is_state) = match message {
        FromBridge::Safety(_) => ("safety", true, true),
        FromBridge::Notice(_) => ("alerts", true, false),
        FromBridge::Devices(_) => ("devices", true, true),
        FromBridge::Recording(_) => ("recording", true, true),
        FromBridge::Mapping(_) => ("mapping", true, true),
        FromBridge::Manoeuvre(_) => ("manoeuvre", true, false),
        FromBridge::Heartbeat(_) => ("heartbeat", true, false),
        FromBridge::Battery(_) => ("battery", false, true),
        FromBridge::Map(_) => ("map", false, true),
        FromBridge::Pose(_) => ("pose", false, true),
        FromBridge::Odometry(_) => ("odometry", false, false),
        FromBridge::Scan(_) => ("scan", false, false),
        FromBridge::PartialScan(_) => ("partial-scan", false, false),
        FromBridge::Rangers(_) => ("rangers", false, false),
        FromBridge::Bumpers(_) => ("bumpers", false, false),
        FromBridge::Currents(_) => ("currents", false, false),
        FromBridge::Link(_) => ("link", false, true),
        _ => return None,
    };
    Some(Stream {
        name,
        is_urgent,
        is_state,
    })
}

/// Whether a message is sent to each client separately: messages for one client, and those that it
/// must not miss. Clients take everything else from the streams, which cost the bridge the same
/// however many listen.
pub(super) fn is_personal(message: &FromBridge) -> bool {
    stream(message).is_none_or(|stream| stream.is_urgent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_client_is_known_by_sixteen_digits_and_nothing_else() {
        let keys = Keys::of(&"rp6".parse().unwrap());
        let check = |key: &str, expect| assert_eq!(keys.client(key), expect, "{key}");
        check("slamlab/rp6/to/00000000000000ff", Some(255));
        check("slamlab/rp6/to/ff", None);
        check("slamlab/rp6/to/+0000000000000ff", None);
        check("slamlab/rp6/to/00000000000000FF", None);
        check("slamlab/rp6/to/00000000000000ff/x", None);
        check("slamlab/rp6/from/00000000000000ff", None);
        check("slamlab/rp60/to/00000000000000ff", None);
        assert_eq!(keys.from(255), "slamlab/rp6/from/00000000000000ff");
    }
}
