//! What a source of data is: a robot, a sensor, a recording, a simulation.
//!
//! In: a [`Source`]. Out: its [`Event`]s, in order; and a way to give it [`Order`]s.
//!
//! 1. [`start`] gives the source a thread of its own, for serial ports block. Several sources run side by side, each with a
//!    number; the hub joins what they say.
//! 2. The thread sends events through its [`Port`]. The queue is bounded and never waited for: a source must go on
//!    serving its robot when the hub is late. What found no room is counted.
//! 3. Orders are not queued: the newest waits until the source takes it, and an emergency stop waits until it is taken,
//!    whatever comes after. So nothing stale runs after a delay.
//! 4. [`Waited::Closed`] tells the source that the bridge ends: it stops its robot, and returns. It does the same after a
//!    fault that it cannot mend; faults that it can (a pulled cable) it mends by itself, and says so by
//!    [`Event::Link`]. Whoever drives has to arm again after any link that was not up.

mod named;
mod orders;
pub mod replay;
pub mod sim;

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use slamlab_core::robot::{Command, Odometry, RobotModel, Scan, Stamp};
use slamlab_core::wire::message::{DeviceState, LinkState, RangerReading};
use tokio::sync::mpsc;

pub use named::{SourceError, SourceName};
use orders::Orders;

/// Events that wait for the hub, of all sources together.
pub const MOST_WAITING: usize = 4096;

/// What a source says. Stamps of one program's serial devices are all on one clock; a simulated robot and a recording have
/// their own.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// The motion since the last one.
    Odometry(Odometry),
    /// A whole sweep; it passed [`Scan::validate`].
    Scan(Scan),
    /// Single readings of rangers.
    Rangers {
        /// When.
        stamp: Stamp,
        /// What.
        readings: Vec<RangerReading>,
    },
    /// What the bumpers feel: at each change, and now and then.
    Bumpers {
        /// When.
        stamp: Stamp,
        /// Pressed at the left.
        left: bool,
        /// Pressed at the right.
        right: bool,
    },
    /// Volts of the battery.
    Battery {
        /// When.
        stamp: Stamp,
        /// V.
        volts: f32,
    },
    /// Currents of the motors.
    Currents {
        /// When.
        stamp: Stamp,
        /// Left, A.
        left: f32,
        /// Right, A.
        right: f32,
    },
    /// How the wire does: at each change, and each second.
    Link(Link),
    /// Whether the robot is doing an errand ([`Command::Forward`], [`Command::Turn`], [`Command::Scan`]): after each order, at each
    /// change, and each second; after the readings that belong to it.
    Busy {
        /// Whether it is.
        busy: bool,
        /// Number of the newest order before which this was not said. The [`Port`] fills it in.
        after: u64,
    },
    /// How the device does: at each change.
    Device {
        /// Its state.
        state: DeviceState,
        /// What it is, as it said itself; empty until then.
        model: String,
        /// For a fault: cause and cure, in a sentence.
        detail: String,
    },
}

/// How the wire to a device does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// Whether data can flow.
    pub state: LinkState,
    /// From a command to its acknowledgement; none where nothing is acknowledged.
    pub round_trip: Option<Duration>,
    /// Frames that came damaged.
    pub damaged: u64,
    /// Bytes that belonged to no frame.
    pub skipped: u64,
}

/// What a source is to do.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Order {
    /// A command to the robot. The bridge stops a robot that nobody drives any more; a source need not watch for that, but
    /// may repeat the last command where the robot's own watchdog wants it.
    Command(Command),
    /// Cut the motors off, and keep them off.
    EmergencyStop,
    /// Undo the emergency stop; nothing may move by that.
    ResetEmergencyStop,
}

/// What came of waiting for an order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Waited {
    /// An order.
    Order(Order),
    /// None came in time.
    Nothing,
    /// None will come any more: stop the robot and return.
    Closed,
}

/// What is known of a source before it starts.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// As it was named on the command line: `sim:arena`.
    pub name: String,
    /// The robot of which it speaks; none for a sensor.
    pub robot: Option<RobotModel>,
    /// Whether that robot takes commands; that of a recording does not.
    pub takes_orders: bool,
    /// Whether it scans only on [`Command::Scan`], standing.
    pub scans_on_command: bool,
}

/// Whether what these sources see comes on [`Command::Scan`] only: a robot that scans on command may carry a lidar that turns all the
/// time, and then nobody need wait for it.
pub(crate) fn scans_on_command<'a>(sources: impl Iterator<Item = &'a Profile> + Clone) -> bool {
    let has_lidar = sources.clone().any(|profile| profile.robot.is_none());
    !has_lidar && robot(sources).is_some_and(|robot| robot.scans_on_command)
}

/// The source with the robot: the first that takes orders, else the first that has one.
pub(crate) fn robot<'a>(sources: impl Iterator<Item = &'a Profile> + Clone) -> Option<&'a Profile> {
    let mut robots = sources.filter(|profile| profile.robot.is_some());
    let mut driven = robots.clone().filter(|profile| profile.takes_orders);
    driven.next().or_else(|| robots.next())
}

/// A source of data.
pub trait Source: Send + 'static {
    /// What it is.
    fn profile(&self) -> Profile;

    /// Its life, on a thread of its own.
    fn run(self: Box<Self>, port: Port);
}

/// A running source, as the hub holds it. Dropping it closes the source and waits until it has stopped its robot.
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
    events: mpsc::Sender<(u8, Event)>,
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
    /// Gives an order; one that was not taken yet is forgotten, but for an emergency stop.
    /// Returns its number: what the source says from then on says after which number.
    pub fn order(&self, order: Order) -> u64 {
        self.orders.put(order)
    }

    /// Events that found no room since the start.
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
    events: mpsc::Sender<(u8, Event)>,
    orders: Arc<Orders>,
    missed: Arc<AtomicU64>,
}

impl Port {
    /// Sends an event, or counts it as missed where the queue is full.
    pub fn send(&self, mut event: Event) {
        if let Event::Busy { after, .. } = &mut event {
            *after = self.orders.taken();
        }
        if self.events.try_send((self.number, event)).is_err() {
            self.missed.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Waits for an order, up to `timeout`; zero only looks.
    #[must_use]
    pub fn wait(&self, timeout: Duration) -> Waited {
        self.orders.take(timeout)
    }
}

/// A source that ended, in whatever way, has no link any more; whoever drives learns it at once.
impl Drop for Port {
    fn drop(&mut self) {
        self.send(Event::Link(Link {
            state: LinkState::Down,
            round_trip: None,
            damaged: 0,
            skipped: 0,
        }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lidar_beside_a_robot_that_scans_on_command_scans_all_the_time() {
        let of = |robot, scans_on_command| Profile {
            name: String::new(),
            robot,
            takes_orders: robot.is_some(),
            scans_on_command,
        };
        let robot = of(Some(RobotModel::rp6()), true);
        let lidar = of(None, false);
        assert!(scans_on_command([&robot].into_iter()));
        for sources in [[&robot, &lidar], [&lidar, &robot]] {
            assert!(!scans_on_command(sources.into_iter()));
        }
        assert!(!scans_on_command([&lidar].into_iter()));
    }
}
