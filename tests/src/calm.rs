//! Tests that run in real time, on machines that may have other things to do.
//!
//! What such a test asks ("the key is held down all the while") is only put to the bridge where the
//! test's own threads run in time. So:
//!
//! 1. A watch beside the test measures how late a thread wakes.
//! 2. A test that fails while the watch woke in time has failed.
//! 3. One that fails while it did not proves nothing; it runs again, at most [`ATTEMPTS`] times.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// How often a test may run until the machine lets it.
pub const ATTEMPTS: u32 = 6;

/// Lateness that a test must bear: less than half of the shortest time out, the 250 ms of the
/// bridge's watchdog.
const BEARABLE: Duration = Duration::from_millis(100);

/// From one look at the clock to the next.
const BEAT: Duration = Duration::from_millis(5);

/// Runs a test in real time; where it fails, and the machine let its threads wait meanwhile, once
/// more.
///
/// # Panics    As `test`, where the machine was calm, or has been loaded [`ATTEMPTS`] times.
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
/// # Panics    As there.
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
        // As long as nobody else loads this one; else a second run is right.
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
