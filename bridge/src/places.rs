//! The places for sockets, and who has them.
//!
//! In: where a connection comes from, and how far it has come. Out: a [`Place`], or none.
//!
//! 1. A connection stands at the door until it is let in: as a watcher, or as one who has shown the
//!    token. Nobody knows before whether it is the owner's.
//! 2. There are so many places for each address and in all. Where none is left, the connection that
//!    has stood at the door longest goes, of the address that has most of them there: so whoever
//!    opens many only pushes out its own, and the owner gets to say who it is.
//! 3. Watchers have a part of the places, of each address and of all; the others are kept for who
//!    shows the token. Who was let in is never pushed out.

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
    /// By number: a lower one has come earlier.
    guests: BTreeMap<u64, Guest>,
}

#[derive(Debug)]
struct Guest {
    address: IpAddr,
    standing: Standing,
    /// Tells it to go.
    go: Arc<Notify>,
}

/// How far a connection has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Standing {
    Door,
    Watcher,
    Trusted,
}

/// A place; it is free again when this is dropped.
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

    /// A place at the door; none where everybody who has one was let in.
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

    /// How many are taken.
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

    /// Sends away who has stood at the door longest: of this address, or of the one that has most
    /// there. None where nobody stands there.
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
        // Whether it waits at this moment or only later, it will learn of it.
        self.guests.remove(&number)?.go.notify_one();
        Some(())
    }
}

impl Place {
    /// Lets it in as a watcher; false where there are as many as may be.
    pub(crate) fn watch(&self) -> bool {
        let limits = &self.places.limits;
        let mut taken = self.places.lock();
        let Some(guest) = taken.guests.get(&self.number) else {
            return false;
        };
        // Who shows a right later has its place already.
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

    /// Lets it in as one who has shown the token; false where it was pushed out a moment ago.
    pub(crate) fn trust(&self) -> bool {
        let mut taken = self.places.lock();
        taken.let_in(self.number, Standing::Trusted)
    }

    /// Ends when it must go.
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

/// One household has 2^64 addresses of IPv6: the first half counts. An IPv4 address that is written
/// as IPv6 counts as what it is.
pub(crate) fn network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(ip) => IpAddr::from((ip.to_bits() >> 64 << 64).to_be_bytes()),
        ipv4 => ipv4,
    }
}

#[cfg(test)]
mod tests;
