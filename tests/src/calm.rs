//! Tests that run in real time, on machines that may have other things to do.
//!
//! What such a test assumes ("the key is held down all the while") only holds if the test's own
//! threads run in time. So:
//!
//! 1. A watch beside the test measures how late a thread wakes.
//! 2. If a test fails although the watch woke in time, it has failed.
//! 3. If it fails and the watch did not wake in time, that proves nothing; it runs again, at most
//!    [`ATTEMPTS`] times.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Maximum number of attempts on a loaded machine.
pub const ATTEMPTS: u32 = 6;

/// Lateness that a test must tolerate: less than half of the shortest timeout, the 250 ms of the
/// bridge's watchdog.
const BEARABLE: Duration = Duration::from_millis(100);

/// Interval between two looks at the clock.
const BEAT: Duration = Duration::from_millis(5);

/// Runs a test in real time; if it fails and the machine delayed its threads meanwhile, runs it
/// once more.
///
/// # Panics    As `test`, if the machine was calm, or was loaded in all [`ATTEMPTS`] attempts.
pub fn on_a_calm_machine(test: impl Fn()) {
    for attempt in 1..=ATTEMPTS {
        let watch = Watch::start();
        let result = catch_unwind(AssertUnwindSafe(&test));
        let late = watch.end();
        match result {
            Ok(()) => return,
            Err(why) if late <= BEARABLE || attempt == ATTEMPTS => resume_unwind(why),
            Err(_) => eprintln!(
                "attempt {attempt} proves nothing: a thread waited {late:?} for the processor"
            ),
        }
    }
}

/// [`on_a_calm_machine`] for a test that waits for sockets.
///
/// # Panics    As [`on_a_calm_machine`].
pub fn async_on_a_calm_machine(test: impl AsyncFn()) {
    on_a_calm_machine(|| {
        tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .expect("the system has threads left")
            .block_on(test());
    });
}

/// Measures how late a thread wakes.
struct Watch {
    has_ended: Arc<AtomicBool>,
    thread: JoinHandle<Duration>,
}

impl Watch {
    fn start() -> Self {
        let has_ended = Arc::new(AtomicBool::new(false));
        let ended = Arc::clone(&has_ended);
        let thread = thread::spawn(move || {
            let mut latest = Duration::ZERO;
            while !ended.load(Ordering::Relaxed) {
                let slept = Instant::now();
                thread::sleep(BEAT);
                latest = latest.max(slept.elapsed().saturating_sub(BEAT));
            }
            latest
        });
        Self { has_ended, thread }
    }

    /// The greatest lateness since the start.
    fn end(self) -> Duration {
        self.has_ended.store(true, Ordering::Relaxed);
        // It cannot panic.
        self.thread.join().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn a_failure_on_a_calm_machine_is_one() {
        // Holds unless the machine is loaded; then a second run is right.
        let watch = Watch::start();
        let runs = Cell::new(0);
        let failed = catch_unwind(AssertUnwindSafe(|| {
            on_a_calm_machine(|| {
                runs.set(runs.get() + 1);
                panic!("on purpose");
            });
        }));
        assert!(failed.is_err());
        assert!(runs.get() == 1 || watch.end() > BEARABLE);
    }

    #[test]
    fn success_runs_once() {
        let runs = Cell::new(0);
        on_a_calm_machine(|| runs.set(runs.get() + 1));
        assert_eq!(runs.get(), 1);
    }
}
