//! Limits the number of open sockets: each needs a place.
//!
//! In: a connection's address, and how far it has got. Out: a [`Place`], or none.
//!
//! 1. A connection stands at the door until it is let in, as a watcher or as a client that has
//!    shown a driver's token. Until then nobody knows whether it is the owner's.
//! 2. Places are limited for each address and in total. If none is left, the connection that has
//!    stood at the door longest must go: of the same address if that is full, else of the address
//!    with most connections there. So whoever opens many pushes out only its own, and the owner can
//!    still identify itself.
//! 3. Watchers may take only a part of the places, both per address and in total; the others are
//!    kept for clients that show a driver's token. A client that was let in is never pushed out.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::Notify;

use crate::shared::Limits;

/// All places.
#[derive(Debug)]
pub(crate) struct Places {
    limits: Limits,
    taken: Mutex<Taken>,
}

#[derive(Debug, Default)]
struct Taken {
    last: u64,
    /// By number: a lower number came earlier.
    guests: BTreeMap<u64, Guest>,
}

#[derive(Debug)]
struct Guest {
    address: IpAddr,
    standing: Standing,
    /// Tells the connection to go.
    go: Arc<Notify>,
}

/// How far a connection has got.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Standing {
    Door,
    Watcher,
    Trusted,
}

/// A place; dropping it frees it.
#[derive(Debug)]
pub(crate) struct Place {
    places: Arc<Places>,
    number: u64,
    go: Arc<Notify>,
}

impl Places {
    pub(crate) fn new(limits: Limits) -> Arc<Self> {
        let taken = Mutex::default();
        Arc::new(Self { limits, taken })
    }

    /// A place at the door; none if everybody who holds a place has been let in.
    pub(crate) fn enter(self: &Arc<Self>, from: IpAddr) -> Option<Place> {
        let address = network(from);
        let mut taken = self.lock();
        if taken.count(|guest| guest.address == address) >= self.limits.per_address {
            taken.push_out(Some(address))?;
        }
        if taken.guests.len() >= self.limits.sockets {
            taken.push_out(None)?;
        }
        taken.last += 1;
        let (number, go) = (taken.last, Arc::new(Notify::new()));
        let guest = Guest {
            address,
            standing: Standing::Door,
            go: Arc::clone(&go),
        };
        taken.guests.insert(number, guest);
        Some(Place {
            places: Arc::clone(self),
            number,
            go,
        })
    }

    /// Number of places taken.
    pub(crate) fn taken(&self) -> usize {
        self.lock().guests.len()
    }

    fn lock(&self) -> MutexGuard<'_, Taken> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Taken {
    fn count(&self, which: impl Fn(&Guest) -> bool) -> usize {
        self.guests.values().filter(|guest| which(guest)).count()
    }

    /// Pushes out the connection that has stood at the door longest: of this address, or of the
    /// address that has most there. None if nobody stands there.
    fn push_out(&mut self, address: Option<IpAddr>) -> Option<()> {
        let at_door = |guest: &&Guest| guest.standing == Standing::Door;
        let mut crowds: BTreeMap<IpAddr, usize> = BTreeMap::new();
        for guest in self.guests.values().filter(at_door) {
            *crowds.entry(guest.address).or_default() += 1;
        }
        let largest = || crowds.iter().max_by_key(|(_, count)| **count);
        let address = address.or_else(|| largest().map(|(address, _)| *address))?;
        let number = (self.guests.iter())
            .find(|(_, guest)| guest.address == address && at_door(guest))
            .map(|(number, _)| *number)?;
        // `notify_one` is remembered, so the connection learns of it even if it waits only later.
        self.guests.remove(&number)?.go.notify_one();
        Some(())
    }
}

impl Place {
    /// Lets it in as a watcher; false if there are too many.
    pub(crate) fn watch(&self) -> bool {
        let limits = &self.places.limits;
        let mut taken = self.places.lock();
        let Some(guest) = taken.guests.get(&self.number) else {
            return false;
        };
        // A client that shows a right later already has its place.
        if guest.standing == Standing::Watcher {
            return true;
        }
        let address = guest.address;
        let watches = |guest: &Guest| guest.standing == Standing::Watcher;
        let of_address = taken.count(|guest| watches(guest) && guest.address == address);
        let is_room =
            of_address < limits.watchers_per_address && taken.count(watches) < limits.watchers;
        is_room && taken.let_in(self.number, Standing::Watcher)
    }

    /// Lets it in as a client that has shown a driver's token; false if it was pushed out a moment
    /// ago.
    pub(crate) fn trust(&self) -> bool {
        let mut taken = self.places.lock();
        taken.let_in(self.number, Standing::Trusted)
    }

    /// Ends when the connection must go.
    pub(crate) async fn pushed_out(&self) {
        self.go.notified().await;
    }
}

impl Taken {
    fn let_in(&mut self, number: u64, standing: Standing) -> bool {
        let guest = self.guests.get_mut(&number);
        guest.map(|guest| guest.standing = standing).is_some()
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.places.lock().guests.remove(&self.number);
    }
}

/// The part of an address that counts. One household has 2^64 IPv6 addresses, so of IPv6 it is the
/// first 64 bits. An IPv4 address written as IPv6 counts as IPv4.
pub(crate) fn network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(ip) => IpAddr::from((ip.to_bits() >> 64 << 64).to_be_bytes()),
        ipv4 => ipv4,
    }
}

#[cfg(test)]
mod tests;
