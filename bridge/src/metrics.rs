//! Counters for Prometheus.

use std::fmt::Write;
use std::sync::atomic::{AtomicU64, Ordering};

/// What is counted since the start.
#[derive(Debug, Default)]
pub(crate) struct Metrics {
    /// Clients that are connected now.
    pub(crate) clients: AtomicU64,
    /// Sockets that are open now.
    pub(crate) sockets: AtomicU64,
    /// Sockets that were turned away because there were too many.
    pub(crate) turned_away: AtomicU64,
    /// Events of sources.
    pub(crate) events: AtomicU64,
    /// Events of sources that found no room.
    pub(crate) missed: AtomicU64,
    /// Messages to clients.
    pub(crate) sent: AtomicU64,
    /// Bytes of those messages.
    pub(crate) sent_bytes: AtomicU64,
    /// Messages from clients.
    pub(crate) received: AtomicU64,
    /// Messages from clients that could not be read.
    pub(crate) malformed: AtomicU64,
    /// Requests of clients that the rules refused.
    pub(crate) refused: AtomicU64,
    /// Clients that failed to show who they are.
    pub(crate) intruders: AtomicU64,
    /// Orders to the robot.
    pub(crate) orders: AtomicU64,
}

impl Metrics {
    /// All counters in Prometheus' text format.
    ///
    /// Source: Prometheus, "Exposition formats", text format 0.0.4.
    #[must_use]
    pub(crate) fn text(&self) -> String {
        let rows = [
            (
                "clients",
                "gauge",
                "Clients that are connected.",
                &self.clients,
            ),
            ("sockets", "gauge", "Sockets that are open.", &self.sockets),
            (
                "sockets_turned_away_total",
                "counter",
                "Sockets beyond the limit.",
                &self.turned_away,
            ),
            (
                "source_events_total",
                "counter",
                "Events of sources.",
                &self.events,
            ),
            (
                "source_events_missed_total",
                "counter",
                "Events that found no room.",
                &self.missed,
            ),
            (
                "messages_sent_total",
                "counter",
                "Messages to clients.",
                &self.sent,
            ),
            (
                "bytes_sent_total",
                "counter",
                "Bytes of messages to clients.",
                &self.sent_bytes,
            ),
            (
                "messages_received_total",
                "counter",
                "Messages from clients.",
                &self.received,
            ),
            (
                "messages_malformed_total",
                "counter",
                "Messages that could not be read.",
                &self.malformed,
            ),
            (
                "requests_refused_total",
                "counter",
                "Requests against the rules.",
                &self.refused,
            ),
            (
                "intruders_total",
                "counter",
                "Clients without a right to come in.",
                &self.intruders,
            ),
            (
                "orders_total",
                "counter",
                "Orders to the robot.",
                &self.orders,
            ),
        ];
        let mut text = String::new();
        for (name, kind, help, value) in rows {
            let value = value.load(Ordering::Relaxed);
            // Writing to a string cannot fail.
            let _ = write!(
                text,
                "# HELP slamlab_{name} {help}\n# TYPE slamlab_{name} {kind}\nslamlab_{name} {value}\n"
            );
        }
        text
    }
}
