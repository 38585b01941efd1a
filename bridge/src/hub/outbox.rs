//! What waits to be sent to one client: the newest message of each stream, and a queue of what must
//! not be lost.
//!
//! In: messages from the hub, at the speed of the robot. Out: messages to the socket, at the speed
//! of the client.
//!
//! 1. Readings and scans have one slot for each stream and source; a newer one replaces the older,
//!    which is counted as dropped. The list of devices, the geofence and the safety state are sent
//!    whole, so they have slots too: nothing that other clients do can fill a client's queue.
//! 2. Odometry is not replaced but joined: the motion not sent yet, followed by the new one.
//! 3. Everything else is queued in order. A client that lets the queue grow full is too slow, and
//!    is disconnected.
//! 4. The queue goes first, then the safety state; then the other slots take turns, so that a fast
//!    stream does not starve the others. Waiting odometry is sent just before a scan, so a scan
//!    never arrives before the motion that led to it.

use std::collections::{BTreeMap, VecDeque};
use std::ops::Bound;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use slamlab_core::wire::message::{FromBridge, OdometryBody};
use tokio::sync::Notify;

use crate::ending::TOO_SLOW;

/// Most queued messages for one client.
const MOST_QUEUED: usize = 64;

/// Shared by the hub, which puts, and the connection, which takes.
#[derive(Debug, Default)]
pub(crate) struct Outbox {
    waiting: Mutex<Waiting>,
    filled: Notify,
    /// The same for a thread outside the runtime.
    filled_for_thread: Condvar,
}

#[derive(Debug, Default)]
struct Waiting {
    queue: VecDeque<Arc<FromBridge>>,
    slots: BTreeMap<Slot, Arc<FromBridge>>,
    /// The slot whose turn it was last.
    last: Option<Slot>,
    dropped: u64,
    /// The close code, if the connection must end.
    close: Option<u16>,
}

/// A stream of a source.
type Slot = (Stream, u8);

/// The safety state has two slots: a client that arms again at the same moment must still learn
/// that the robot was disarmed, because that ended what was running.
const DISARMED: Slot = (Stream::Safety, 0);
const ARMED: Slot = (Stream::Safety, 1);

/// The streams that have slots, in the order in which they are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Stream {
    Safety,
    Geofence,
    Devices,
    Odometry,
    Scan,
    PartialScan,
    Manoeuvre,
    Rangers,
    Bumpers,
    Battery,
    Currents,
    Link,
    Heartbeat,
    Recording,
    Mapping,
    Map,
    Pose,
}

/// What comes next for a client.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Next {
    Message(Arc<FromBridge>),
    /// End the connection with this code.
    Close(u16),
}

impl Outbox {
    /// Puts a message into its slot or the queue.
    pub(crate) fn put(&self, message: &Arc<FromBridge>) {
        let mut waiting = self.lock();
        match slot(message) {
            Some(DISARMED) => {
                waiting.slots.remove(&ARMED);
                waiting.slots.insert(DISARMED, message.clone());
            }
            Some(slot) => waiting.fill(slot, message),
            None if waiting.queue.len() < MOST_QUEUED => waiting.queue.push_back(message.clone()),
            // RFC 6455: try again later.
            None => waiting.close = waiting.close.or(Some(TOO_SLOW)),
        }
        drop(waiting);
        self.notify();
    }

    /// Ends the connection, once the queue is sent.
    pub(crate) fn close(&self, code: u16) {
        let mut waiting = self.lock();
        waiting.close = waiting.close.or(Some(code));
        drop(waiting);
        self.notify();
    }

    fn notify(&self) {
        self.filled.notify_one();
        self.filled_for_thread.notify_one();
    }

    /// Readings that were replaced before they were sent.
    pub(crate) fn dropped(&self) -> u64 {
        self.lock().dropped
    }

    /// Waits for what comes next. A connection that ends still sends the queue, but no more
    /// readings.
    pub(crate) async fn next(&self) -> Next {
        loop {
            let filled = self.filled.notified();
            if let Some(next) = self.lock().next() {
                return next;
            }
            filled.await;
        }
    }

    /// The same for a thread outside the runtime; none if nothing comes within `longest`.
    pub(crate) fn next_within(&self, longest: Duration) -> Option<Next> {
        let mut waiting = self.lock();
        if let Some(next) = waiting.next() {
            return Some(next);
        }
        let waited = self.filled_for_thread.wait_timeout(waiting, longest);
        waiting = waited.unwrap_or_else(PoisonError::into_inner).0;
        waiting.next()
    }

    /// A thread that panicked while it held the lock leaves nothing half done that matters to
    /// another client.
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Waiting {
    fn fill(&mut self, slot: Slot, message: &Arc<FromBridge>) {
        let Some(old) = self.slots.get_mut(&slot) else {
            self.slots.insert(slot, message.clone());
            return;
        };
        match joined(old, message) {
            Some(both) => *old = Arc::new(both),
            None => {
                *old = message.clone();
                // A replaced state is no dropped reading: only the newest state counts.
                self.dropped += u64::from(slot.0 > Stream::Devices);
            }
        }
    }

    fn next(&mut self) -> Option<Next> {
        if let Some(message) = self.queue.pop_front() {
            return Some(Next::Message(message));
        }
        // Sent before a close, too: it tells the client why the robot was stopped.
        let state = (self.slots.remove(&DISARMED)).or_else(|| self.slots.remove(&ARMED));
        if let Some(state) = state {
            return Some(Next::Message(state));
        }
        if let Some(code) = self.close {
            return Some(Next::Close(code));
        }
        let slot = self.after_its_scan(self.turn()?);
        self.last = Some(slot);
        if slot.0 == Stream::Scan {
            let waiting = self
                .slots
                .extract_if(.., |slot, _| slot.0 == Stream::Odometry);
            self.queue.extend(waiting.map(|(_, message)| message));
        }
        self.queue.extend(self.slots.remove(&slot));
        self.queue.pop_front().map(Next::Message)
    }

    /// The end of a manoeuvre waits for the scan that belongs to it, but only for one: otherwise a
    /// slow client would never learn of the end.
    fn after_its_scan(&self, slot: Slot) -> Slot {
        let was_scan = self.last.is_some_and(|last| last.0 == Stream::Scan);
        let mut scans = self.slots.keys().filter(|slot| slot.0 == Stream::Scan);
        match scans.next() {
            Some(scan) if slot.0 == Stream::Manoeuvre && !was_scan => *scan,
            _ => slot,
        }
    }

    /// The next full slot after the last one, wrapping around.
    fn turn(&self) -> Option<Slot> {
        let after = self.last.map_or(Bound::Unbounded, Bound::Excluded);
        let mut rest = self.slots.range((after, Bound::Unbounded));
        rest.next()
            .or_else(|| self.slots.iter().next())
            .map(|(slot, _)| *slot)
    }
}

/// The slot of a message; none for what is queued.
fn slot(message: &FromBridge) -> Option<Slot> {
    Some(match message {
        FromBridge::Safety(state) if state.armed => ARMED,
        FromBridge::Safety(_) => DISARMED,
        FromBridge::Geofence(_) => (Stream::Geofence, 0),
        FromBridge::Devices(_) => (Stream::Devices, 0),
        FromBridge::Odometry(body) => (Stream::Odometry, body.source),
        FromBridge::Scan(body) => (Stream::Scan, body.source),
        FromBridge::PartialScan(body) => (Stream::PartialScan, body.source),
        FromBridge::Rangers(body) => (Stream::Rangers, body.source),
        FromBridge::Bumpers(body) => (Stream::Bumpers, body.source),
        FromBridge::Battery(body) => (Stream::Battery, body.source),
        FromBridge::Currents(body) => (Stream::Currents, body.source),
        FromBridge::Link(body) => (Stream::Link, body.source),
        FromBridge::Manoeuvre(_) => (Stream::Manoeuvre, 0),
        FromBridge::Heartbeat(_) => (Stream::Heartbeat, 0),
        FromBridge::Recording(_) => (Stream::Recording, 0),
        FromBridge::Mapping(_) => (Stream::Mapping, 0),
        FromBridge::Map(_) => (Stream::Map, 0),
        FromBridge::Pose(_) => (Stream::Pose, 0),
        _ => return None,
    })
}

/// The motion of both, if the second goes on where the first ends.
fn joined(first: &FromBridge, second: &FromBridge) -> Option<FromBridge> {
    let (FromBridge::Odometry(first), FromBridge::Odometry(second)) = (first, second) else {
        return None;
    };
    if first.to != second.from {
        return None;
    }
    let both = first.odometry().ok()?.then(&second.odometry().ok()?);
    Some(FromBridge::Odometry(OdometryBody::new(first.source, &both)))
}

#[cfg(test)]
mod tests {
    use slamlab_core::geom::Pose2;
    use slamlab_core::robot::{Scan, Stamp};
    use slamlab_core::wire::message::{BatteryBody, Notice, SafetyBody, ScanBody, Severity};

    use super::*;

    fn battery(volts: f32) -> Arc<FromBridge> {
        let (source, stamp) = (0, 0);
        Arc::new(FromBridge::Battery(BatteryBody {
            source,
            stamp,
            volts,
        }))
    }

    fn odometry(from: u64, to: u64, motion: [f64; 3]) -> Arc<FromBridge> {
        Arc::new(FromBridge::Odometry(OdometryBody {
            source: 0,
            from,
            to,
            motion,
            cov: [0.0; 6],
        }))
    }

    fn notice(text: &str) -> Arc<FromBridge> {
        Arc::new(FromBridge::Notice(Notice {
            severity: Severity::Info,
            text: text.into(),
        }))
    }

    #[tokio::test]
    async fn the_newest_reading_replaces_the_older_which_is_counted() {
        let outbox = Outbox::default();
        for volts in [7.0, 7.1, 7.2] {
            outbox.put(&battery(volts));
        }
        assert_eq!(outbox.next().await, Next::Message(battery(7.2)));
        assert_eq!(outbox.dropped(), 2);
    }

    #[tokio::test]
    async fn odometry_is_joined_and_comes_before_readings_but_after_notices() {
        let outbox = Outbox::default();
        outbox.put(&battery(7.0));
        outbox.put(&odometry(0, 10, [1.0, 0.0, std::f64::consts::FRAC_PI_2]));
        outbox.put(&odometry(10, 30, [0.5, 0.0, 0.0]));
        outbox.put(&notice("first"));
        assert_eq!(outbox.next().await, Next::Message(notice("first")));
        let Next::Message(message) = outbox.next().await else {
            panic!("closed")
        };
        let FromBridge::Odometry(body) = *message else {
            panic!("{message:?}")
        };
        // A quarter turn to the left at (1, 0), then half a metre: (1, 0.5).
        assert_eq!((body.from, body.to), (0, 30));
        let [x, y, _] = body.motion;
        assert!((x - 1.0).abs() < 1e-12 && (y - 0.5).abs() < 1e-12);
        assert_eq!(outbox.dropped(), 0);
        // A robot that restarted cannot be joined.
        outbox.put(&odometry(30, 40, [0.0; 3]));
        outbox.put(&odometry(0, 5, [0.0; 3]));
        assert_eq!(outbox.dropped(), 1);
    }

    /// A fast stream that always has a new message must not hold the scans back, nor be overtaken
    /// by them.
    #[tokio::test]
    async fn a_scan_gets_its_turn_behind_the_odometry_that_led_to_it() {
        let scan = |stamp| {
            let mut body = ScanBody::new(0, &a_scan());
            body.stamp = stamp;
            Arc::new(FromBridge::Scan(body))
        };
        let outbox = Outbox::default();
        let step = |from: u64| odometry(from, from + 10, [0.1, 0.0, 0.0]);
        outbox.put(&step(0));
        assert_eq!(outbox.next().await, Next::Message(step(0)));
        outbox.put(&step(10));
        outbox.put(&scan(20));
        assert_eq!(outbox.next().await, Next::Message(step(10)));
        outbox.put(&step(20));
        assert_eq!(outbox.next().await, Next::Message(scan(20)));
        assert_eq!(outbox.next().await, Next::Message(step(20)));
    }

    fn a_scan() -> Scan {
        Scan {
            stamp: Stamp(0),
            robot_from_sensor: Pose2::identity(),
            bearings: vec![0.0],
            ranges: vec![1.0],
            sigmas: vec![0.01],
            bearing_sigma: 0.0,
            max_range: 6.0,
            sweep: 0.0,
            qualities: vec![],
        }
    }

    /// Regression: each change took a place in the queue, so a client that changed the state often
    /// enough got all others disconnected.
    #[tokio::test]
    async fn of_the_state_of_safety_the_newest_waits_and_goes_first() {
        let state = |armed| {
            Arc::new(FromBridge::Safety(SafetyBody {
                armed,
                ..SafetyBody::default()
            }))
        };
        let outbox = Outbox::default();
        outbox.put(&battery(7.0));
        for times in 0..10 * MOST_QUEUED {
            outbox.put(&state(times % 2 == 0));
            outbox.put(&Arc::new(FromBridge::Devices(vec![])));
        }
        outbox.put(&state(true));
        outbox.close(4009);
        assert_eq!(outbox.dropped(), 0, "nobody missed a reading");
        // The robot was disarmed meanwhile.
        assert_eq!(outbox.next().await, Next::Message(state(false)));
        assert_eq!(outbox.next().await, Next::Message(state(true)));
        assert_eq!(outbox.next().await, Next::Close(4009));
        for armed in [false, true, false] {
            outbox.put(&state(armed));
        }
        assert_eq!(outbox.next().await, Next::Message(state(false)));
        assert_eq!(outbox.next().await, Next::Close(4009));
    }

    #[tokio::test]
    async fn a_full_queue_ends_the_connection_after_what_is_queued() {
        let outbox = Outbox::default();
        for _ in 0..=MOST_QUEUED {
            outbox.put(&notice("too many"));
        }
        for _ in 0..MOST_QUEUED {
            assert_eq!(outbox.next().await, Next::Message(notice("too many")));
        }
        assert_eq!(outbox.next().await, Next::Close(TOO_SLOW));
        outbox.close(4009);
        assert_eq!(
            outbox.next().await,
            Next::Close(TOO_SLOW),
            "the first reason holds"
        );
    }
}
