//! Sources of data: a robot, a sensor, a recording, a simulation.
//!
//! In: a [`Source`]. Out: its [`SourceEvent`]s, in order; and a way to give it [`Order`]s.
//!
//! 1. [`start`] gives the source a thread of its own, because serial ports block. Several sources
//!    run in parallel, each with a number; the hub combines their events.
//! 2. The thread sends events through its [`Port`]. The queue is bounded, and the thread never
//!    waits for it: a source must go on serving its robot when the hub is late. Events that find no
//!    room are counted.
//! 3. Orders are not queued: only the newest command waits for the source, and an emergency stop
//!    waits until it is taken, whatever comes after it. So nothing stale runs after a delay.
//! 4. [`Waited::Closed`] tells the source that the bridge ends: it stops its robot, and returns. It
//!    does the same after a fault that it cannot repair. It recovers by itself from others (a
//!    pulled cable), and reports them by [`SourceEvent::Link`]. After any link failure the driver
//!    must arm again.

mod named;
mod orders;
pub mod replay;
pub mod sim;

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use slamlab_core::wire::message::{LinkBody, LinkState};
use tokio::sync::mpsc;

pub use slamlab_core::device::source::{
    Order, Profile, SourceEvent, robot_figures, scans_on_command,
};

pub use named::{SourceError, SourceName, forms};
use orders::Orders;

/// Most events that may wait for the hub, of all sources together.
pub const MOST_WAITING: usize = 4096;

/// The result of waiting for an order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Waited {
    /// An order.
    Order(Order),
    /// No order came in time.
    Nothing,
    /// No more orders will come: stop the robot and return.
    Closed,
}

/// A source of data.
pub trait Source: Send + 'static {
    /// What it is.
    fn profile(&self) -> Profile;

    /// Its main loop, on a thread of its own.
    fn run(self: Box<Self>, port: Port);
}

/// A running source, as the hub holds it. Dropping it closes the source and waits until it has
/// stopped its robot.
#[derive(Debug)]
pub struct Running {
    /// What it is.
    pub profile: Profile,
    orders: Arc<Orders>,
    missed: Arc<AtomicU64>,
    thread: Option<JoinHandle<()>>,
}

/// Gives `source` a thread. Its events come out of `events` with `number`.
///
/// # Errors    If the system has no thread left.
pub fn start(
    number: u8,
    source: Box<dyn Source>,
    events: mpsc::Sender<(u8, SourceEvent)>,
) -> io::Result<Running> {
    let profile = source.profile();
    let orders = Arc::new(Orders::default());
    let missed = Arc::new(AtomicU64::new(0));
    let port = Port {
        number,
        events,
        orders: Arc::clone(&orders),
        missed: Arc::clone(&missed),
    };
    let thread = thread::Builder::new()
        .name(profile.name.chars().take(15).collect())
        .spawn(move || source.run(port))?;
    Ok(Running {
        profile,
        orders,
        missed,
        thread: Some(thread),
    })
}

impl Running {
    /// Gives an order with this number; it replaces one that was not taken yet, except an emergency
    /// stop. [`SourceEvent::Busy`] refers to the number.
    pub fn order(&self, number: u64, order: Order) {
        self.orders.put(number, order);
    }

    /// Number of events that found no room since the start.
    #[must_use]
    pub fn missed(&self) -> u64 {
        self.missed.load(Ordering::Relaxed)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.orders.close();
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("source {} panicked", self.profile.name);
        }
    }
}

/// The source's side of its queues.
#[derive(Debug)]
pub struct Port {
    number: u8,
    events: mpsc::Sender<(u8, SourceEvent)>,
    orders: Arc<Orders>,
    missed: Arc<AtomicU64>,
}

impl Port {
    /// Sends an event, or counts it as missed if the queue is full.
    pub fn send(&self, mut event: SourceEvent) {
        if let SourceEvent::Busy { after, .. } = &mut event {
            *after = self.orders.taken();
        }
        if self.events.try_send((self.number, event)).is_err() {
            self.missed.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Waits for an order, up to `timeout`; zero does not wait.
    #[must_use]
    pub fn wait(&self, timeout: Duration) -> Waited {
        self.orders.take(timeout)
    }
}

/// A source that has ended, in whatever way, has no link any more; the driver learns of it at once.
impl Drop for Port {
    fn drop(&mut self) {
        self.send(SourceEvent::Link(LinkBody::new(LinkState::Down)));
    }
}
