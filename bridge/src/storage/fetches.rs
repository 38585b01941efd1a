//! Limits downloads from the store for clients: outgoing data costs money, and takes bandwidth of
//! the robot's link from the driver.
//!
//! In: the address that wants a recording. Out: a permit to fetch it, or why not now.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use crate::access_log::Peer;
use crate::places::network;
use crate::rate::Bucket;

/// Most fetches at the same time, of all addresses together.
const AT_ONCE: usize = 4;
/// Most fetches that one address may begin per minute. A plain request shows no token, so all of
/// them count.
const A_MINUTE: u32 = 20;
/// Most addresses for which this is counted.
const MOST_ADDRESSES: usize = 1024;

/// The running fetches, and how many each address began.
#[derive(Debug)]
pub(super) struct Fetches {
    running: Arc<Semaphore>,
    begun: Mutex<BTreeMap<IpAddr, Bucket>>,
}

/// Why a recording is not fetched now.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum TooMany {
    /// Too many fetches are running.
    #[error("{AT_ONCE} recordings are being fetched from the store: try again when one is done.")]
    AtOnce,
    /// This address has used up its share.
    #[error("Of recordings in the store an address gets {A_MINUTE} a minute: try again later.")]
    AMinute,
}

impl Default for Fetches {
    fn default() -> Self {
        Self {
            running: Arc::new(Semaphore::new(AT_ONCE)),
            begun: Mutex::default(),
        }
    }
}

impl Fetches {
    /// A permit to fetch one; the fetch counts as running until it is dropped.
    pub(super) fn begin(&self, peer: Peer, now: Duration) -> Result<OwnedSemaphorePermit, TooMany> {
        let permit = Arc::clone(&self.running).try_acquire_owned();
        let permit = permit.map_err(|_| TooMany::AtOnce)?;
        match self.take(address(peer), now) {
            true => Ok(permit),
            false => Err(TooMany::AMinute),
        }
    }

    fn take(&self, address: IpAddr, now: Duration) -> bool {
        let mut begun = self.begun.lock().unwrap_or_else(PoisonError::into_inner);
        if begun.len() >= MOST_ADDRESSES && !begun.contains_key(&address) {
            // An address that has its whole share again need not be remembered.
            begun.retain(|_, bucket| !bucket.is_full(now));
            if begun.len() >= MOST_ADDRESSES {
                return false;
            }
        }
        let bucket = begun.entry(address);
        bucket
            .or_insert_with(|| Bucket::a_minute(A_MINUTE, now))
            .take(now)
    }
}

fn address(peer: Peer) -> IpAddr {
    match peer {
        Peer::At(address) => network(address.ip()),
        // No HTTP request comes from the router.
        #[cfg(feature = "zenoh")]
        Peer::Router(_) => std::net::Ipv4Addr::UNSPECIFIED.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn from(last: u8) -> Peer {
        Peer::At(([10, 0, 0, last], 5000).into())
    }

    #[test]
    fn few_run_at_once_and_who_ends_makes_room() {
        let fetches = Fetches::default();
        let begin = |last| fetches.begin(from(last), Duration::ZERO);
        let mut running: Vec<_> = (0..AT_ONCE as u8)
            .map(|last| begin(last).unwrap())
            .collect();
        assert_eq!(begin(99).unwrap_err(), TooMany::AtOnce);
        running.pop();
        assert!(begin(99).is_ok());
    }

    #[test]
    fn one_address_begins_so_many_a_minute_and_takes_nothing_from_another() {
        let fetches = Fetches::default();
        let begun = |last, seconds| {
            let now = Duration::from_secs(seconds);
            let all = (0..1000).map(|_| fetches.begin(from(last), now));
            all.filter(Result::is_ok).count()
        };
        assert_eq!(begun(1, 0), A_MINUTE as usize);
        assert_eq!(begun(2, 0), A_MINUTE as usize);
        assert_eq!(begun(1, 30), A_MINUTE as usize / 2);
        assert_eq!(begun(1, 3000), A_MINUTE as usize);
    }

    #[test]
    fn what_is_remembered_of_addresses_is_bounded() {
        let fetches = Fetches::default();
        let address = |at: usize| IpAddr::from((at as u32).to_be_bytes());
        let all = |now| {
            (0..MOST_ADDRESSES)
                .filter(|at| fetches.take(address(*at), now))
                .count()
        };
        assert_eq!(all(Duration::ZERO), MOST_ADDRESSES);
        assert!(!fetches.take(address(MOST_ADDRESSES), Duration::ZERO));
        assert!(fetches.take(address(MOST_ADDRESSES), Duration::from_secs(60)));
    }
}
