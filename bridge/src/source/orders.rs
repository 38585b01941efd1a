//! The mailbox between hub and source: the newest command, and emergency orders, which must not be
//! replaced.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use slamlab_core::robot::Command;

use super::{Order, Waited};

#[derive(Debug, Default)]
pub(super) struct Orders {
    waiting: Mutex<Waiting>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct Waiting {
    /// Taken before any command.
    emergency: [Option<Order>; 2],
    command: Option<Command>,
    is_closed: bool,
    /// Number of the newest order; in `taken`, the newest at the moment when the source had taken
    /// all.
    put: u64,
    taken: u64,
}

impl Orders {
    pub(super) fn put(&self, number: u64, order: Order) {
        let mut waiting = self.lock();
        waiting.put = number;
        match order {
            Order::Command(command) => waiting.command = Some(command),
            Order::EmergencyStop => {
                waiting.emergency = [Some(order), None];
                waiting.command = None;
            }
            Order::ResetEmergencyStop => waiting.emergency[1] = Some(order),
        }
        self.changed.notify_all();
    }

    /// Number of the newest order when the source last had taken all: its reports now come after
    /// that order.
    pub(super) fn taken(&self) -> u64 {
        self.lock().taken
    }

    pub(super) fn close(&self) {
        self.lock().is_closed = true;
        self.changed.notify_all();
    }

    pub(super) fn take(&self, timeout: Duration) -> Waited {
        let until = Instant::now() + timeout;
        let mut waiting = self.lock();
        loop {
            if let Some(order) = waiting.next() {
                if waiting.is_empty() {
                    waiting.taken = waiting.put;
                }
                return Waited::Order(order);
            }
            if waiting.is_closed {
                return Waited::Closed;
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Waited::Nothing;
            }
            let woken = self.changed.wait_timeout(waiting, left);
            waiting = woken.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// A thread that panicked while it held the lock leaves nothing half done: each change is one
    /// assignment.
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Waiting {
    fn is_empty(&self) -> bool {
        self.command.is_none() && self.emergency == [None, None]
    }

    fn next(&mut self) -> Option<Order> {
        let [first, second] = &mut self.emergency;
        let command = &mut self.command;
        first
            .take()
            .or_else(|| second.take())
            .or_else(|| command.take().map(Order::Command))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: Duration = Duration::ZERO;

    fn drive(forward: f64) -> Order {
        Order::Command(Command::Velocity { forward, turn: 0.0 })
    }

    #[test]
    fn the_newest_command_is_taken_once() {
        let orders = Orders::default();
        orders.put(1, drive(0.1));
        orders.put(1, drive(0.2));
        assert_eq!(orders.take(NOW), Waited::Order(drive(0.2)));
        assert_eq!(orders.take(NOW), Waited::Nothing);
    }

    #[test]
    fn an_emergency_stop_is_taken_first_and_forgets_what_waited() {
        let orders = Orders::default();
        orders.put(1, drive(0.1));
        orders.put(1, Order::EmergencyStop);
        orders.put(1, Order::ResetEmergencyStop);
        orders.put(1, drive(0.3));
        let all: Vec<_> = (0..4).map(|_| orders.take(NOW)).collect();
        let expect = [
            Waited::Order(Order::EmergencyStop),
            Waited::Order(Order::ResetEmergencyStop),
            Waited::Order(drive(0.3)),
            Waited::Nothing,
        ];
        assert_eq!(all, expect);
    }

    #[test]
    fn what_a_source_says_counts_after_the_orders_that_it_took() {
        let orders = Orders::default();
        orders.put(1, drive(0.1));
        orders.put(2, drive(0.2));
        assert_eq!(orders.taken(), 0);
        let _ = orders.take(NOW);
        assert_eq!(orders.taken(), 2);
        orders.put(3, Order::EmergencyStop);
        orders.put(4, drive(0.3));
        let _ = orders.take(NOW);
        assert_eq!(orders.taken(), 2, "one still waits");
        let _ = orders.take(NOW);
        assert_eq!(orders.taken(), 4);
    }

    #[test]
    fn what_waits_is_still_taken_after_closing() {
        let orders = Orders::default();
        orders.put(1, Order::Command(Command::Stop));
        orders.close();
        assert_eq!(
            orders.take(NOW),
            Waited::Order(Order::Command(Command::Stop))
        );
        assert_eq!(orders.take(Duration::from_secs(60)), Waited::Closed);
    }

    #[test]
    fn waiting_ends_with_an_order_from_another_thread() {
        let orders = std::sync::Arc::new(Orders::default());
        let giver = std::sync::Arc::clone(&orders);
        let thread = std::thread::spawn(move || giver.put(1, drive(0.1)));
        assert_eq!(
            orders.take(Duration::from_secs(60)),
            Waited::Order(drive(0.1))
        );
        thread.join().unwrap();
    }
}
