//! The access log: who connects, drives and is refused. Entries hold the address, never a token,
//! and are limited in rate to what a person can read.

use std::fmt;
use std::net::SocketAddr;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use crate::rate::Bucket;

/// Entries of one kind per second, on average; a burst may be twice as large.
const RATE: u32 = 2;

/// Where a connection comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Peer {
    /// A socket.
    At(SocketAddr),
    /// The Zenoh router, or a client behind it, by the number that the client gave itself.
    #[cfg(feature = "zenoh")]
    Router(Option<u64>),
}

impl fmt::Display for Peer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::At(address) => address.fmt(f),
            #[cfg(feature = "zenoh")]
            Self::Router(None) => f.write_str("the router"),
            #[cfg(feature = "zenoh")]
            Self::Router(Some(number)) => write!(f, "the router, as {number:016x}"),
        }
    }
}

/// Kinds of entries; each has its own budget, so a flood of one cannot hide another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A client got the lease.
    Lease,
    /// Somebody stopped the robot.
    Stop,
    /// A proof was wrong.
    Proof,
    /// A page of another origin, or a foreign host name.
    Origin,
    /// A connection that the bridge ended.
    ShownOut,
    /// No place was left.
    Full,
    /// Somebody changed the bridge's map.
    Map,
}

const KINDS: usize = Kind::Map as usize + 1;

/// The budgets.
#[derive(Debug)]
pub(crate) struct AccessLog(Mutex<[Budget; KINDS]>);

#[derive(Clone, Copy, Debug)]
struct Budget {
    bucket: Bucket,
    left_out: u64,
}

impl AccessLog {
    pub(crate) fn new() -> Self {
        let budget = Budget {
            bucket: Bucket::new(RATE, Duration::ZERO),
            left_out: 0,
        };
        Self(Mutex::new([budget; KINDS]))
    }

    /// Logs what happened, with the number of entries of its kind left out since the last one. Over
    /// the budget, only counts it and returns false.
    pub(crate) fn note(&self, now: Duration, kind: Kind, what: fmt::Arguments<'_>) -> bool {
        let Some(left_out) = self.admits(now, kind) else {
            return false;
        };
        let more = match left_out {
            0 => String::new(),
            _ => format!(" ({left_out} more of this kind were not logged)"),
        };
        match kind {
            Kind::Lease | Kind::Stop | Kind::Map => tracing::info!("{what}{more}"),
            _ => tracing::warn!("{what}{more}"),
        }
        true
    }

    /// The number of entries left out before this one, or none if this one must be left out too.
    fn admits(&self, now: Duration, kind: Kind) -> Option<u64> {
        let mut budgets = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let budget = budgets.get_mut(kind as usize)?;
        if budget.bucket.take(now) {
            return Some(std::mem::take(&mut budget.left_out));
        }
        budget.left_out += 1;
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_of_one_kind_hides_no_other_and_is_counted() {
        let log = AccessLog::new();
        let now = Duration::from_secs(5);
        let admitted = (0..1000)
            .filter(|_| log.admits(now, Kind::Proof).is_some())
            .count();
        assert_eq!(admitted, 4);
        assert_eq!(log.admits(now, Kind::Lease), Some(0));
        let later = now + Duration::from_secs(1);
        assert_eq!(log.admits(later, Kind::Proof), Some(996));
        assert_eq!(log.admits(later, Kind::Proof), Some(0));
    }
}
