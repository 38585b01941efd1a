//! Messages to the router, on two lanes.
//!
//! Zenoh puts a message into the queue of its priority, and blocks if that is full. So each lane is
//! a thread: when readings block, urgent messages and the runtime do not wait.
//!
//! 1. Urgent: states, alerts, answers; in order, none left out. A router that takes none of them
//!    until the queue is full counts as lost.
//! 2. Readings: an [`Outbox`], so that only the newest of each stream waits while one is being
//!    sent.

use std::io;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use ::zenoh::Wait;
use ::zenoh::pubsub::Publisher;
use tokio::sync::mpsc;

use crate::ending::GOING_AWAY;
use crate::hub::outbox::{Next, Outbox};

/// Most urgent messages that may wait.
const MOST_URGENT: usize = 256;
/// Interval between checks whether the lane must end.
const LOOK: Duration = Duration::from_millis(500);

/// A message to be published.
pub(super) struct Put {
    pub(super) publisher: Arc<Publisher<'static>>,
    pub(super) payload: Vec<u8>,
}

/// The urgent lane; it ends when its last sender is dropped.
#[derive(Clone)]
pub(super) struct Urgent(mpsc::Sender<Put>);

/// The router accepts nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stalled;

impl Urgent {
    pub(super) fn start() -> io::Result<Self> {
        let (sender, mut waiting) = mpsc::channel::<Put>(MOST_URGENT);
        let run = move || {
            while let Some(Put { publisher, payload }) = waiting.blocking_recv() {
                say_failed(publisher.put(payload).wait());
            }
        };
        thread::Builder::new()
            .name("zenoh-urgent".into())
            .spawn(run)?;
        Ok(Self(sender))
    }

    pub(super) fn put(&self, put: Put) -> Result<(), Stalled> {
        self.0.try_send(put).map_err(|_| Stalled)
    }
}

/// The lane of readings; it ends when this is dropped.
pub(super) struct Readings(Arc<Outbox>);

impl Readings {
    /// Starts the lane. `publish` publishes one message, and may block as long as the link does.
    pub(super) fn start(
        mut publish: impl FnMut(&slamlab_core::wire::message::FromBridge) + Send + 'static,
    ) -> io::Result<Self> {
        let outbox = Arc::new(Outbox::default());
        let waiting = Arc::clone(&outbox);
        let run = move || {
            loop {
                match waiting.next_within(LOOK) {
                    Some(Next::Message(message)) => publish(&message),
                    Some(Next::Close(_)) => return,
                    None => (),
                }
            }
        };
        thread::Builder::new()
            .name("zenoh-readings".into())
            .spawn(run)?;
        Ok(Self(outbox))
    }

    pub(super) fn put(&self, message: &Arc<slamlab_core::wire::message::FromBridge>) {
        self.0.put(message);
    }
}

impl Drop for Readings {
    fn drop(&mut self) {
        self.0.close(GOING_AWAY);
    }
}

/// Logs a failure for debugging only: that a session has ended is reported elsewhere, once.
pub(super) fn say_failed(done: ::zenoh::Result<()>) {
    if let Err(error) = done {
        tracing::debug!("zenoh: {error}");
    }
}
