//! The log: lines on stderr.
//!
//! A separate thread writes them. A full disk, a pipe that nobody reads or a terminal stopped by
//! Ctrl+S blocks only that thread, never the hub, which controls the robot: lines that find no room
//! in the queue are dropped and counted.

use std::io::{IsTerminal, stderr};

use tracing_appender::non_blocking::{ErrorCounter, NonBlockingBuilder, WorkerGuard};
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

/// Lines that may wait to be written.
const QUEUE: usize = 1000;

/// When dropped, it writes what still waits, for a second at most.
#[must_use]
pub(crate) struct Log {
    lost: ErrorCounter,
    _thread: WorkerGuard,
}

pub(crate) fn begin() -> Log {
    let (lines, thread) = NonBlockingBuilder::default()
        .buffered_lines_limit(QUEUE)
        .lossy(true)
        .thread_name("log")
        .finish(stderr());
    let lost = lines.error_counter();
    let log = tracing_subscriber::fmt()
        .with_writer(lines)
        // No colours in a file or a journal.
        .with_ansi(stderr().is_terminal())
        .with_target(false)
        // They would be printed on stderr, with a panic if that fails.
        .log_internal_errors(false)
        .finish();
    // The bridge itself reports Zenoh's state and the store's retries, so their own log lines are
    // left out.
    let log = log.with(
        Targets::new()
            .with_default(LevelFilter::INFO)
            .with_target("zenoh", LevelFilter::OFF)
            .with_target("object_store", LevelFilter::OFF),
    );
    log.init();
    Log {
        lost,
        _thread: thread,
    }
}

impl Drop for Log {
    fn drop(&mut self) {
        let lost = self.lost.dropped_lines();
        if lost > 0 {
            tracing::warn!("{lost} lines of this log were left out: they were not read in time");
        }
    }
}
