//! The log: lines on stderr.
//!
//! A thread of its own writes them. A full disk, a pipe that nobody reads and a terminal that was
//! stopped by Ctrl+S keep that thread waiting, and never the hub, which has the robot: what finds
//! no room in the queue is left out, and counted.

use std::io::{IsTerminal, stderr};

use tracing_appender::non_blocking::{ErrorCounter, NonBlockingBuilder, WorkerGuard};
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

/// Lines that may wait to be written.
const QUEUE: usize = 1000;

/// Dropped, it writes what still waits, for a second at most.
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
        // A log that goes into a file or a journal has no colours.
        .with_ansi(stderr().is_terminal())
        .with_target(false)
        // It would tell them on stderr, and panic where that cannot be written.
        .log_internal_errors(false)
        .finish();
    // What Zenoh has to say of itself, and the store's client of each try, the bridge says in its
    // own words.
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
