//! Counters for Prometheus.

use std::fmt::Write;
use std::sync::atomic::{AtomicU64, Ordering};

/// A metric that any task may change.
#[derive(Debug, Default)]
pub(crate) struct Metric(AtomicU64);

impl Metric {
    pub(crate) fn add(&self, more: u64) {
        self.0.fetch_add(more, Ordering::Relaxed);
    }

    pub(crate) fn set(&self, value: u64) {
        self.0.store(value, Ordering::Relaxed);
    }
}

/// One row per metric: field, name for Prometheus, kind, help.
macro_rules! metrics {
    ($($field:ident, $name:literal, $kind:ident, $help:literal;)+) => {
        /// The metrics since the start.
        #[derive(Debug, Default)]
        pub(crate) struct Metrics {
            $(#[doc = $help] pub(crate) $field: Metric,)+
        }

        impl Metrics {
            /// Name, kind, help and value of each.
            fn rows(&self) -> Vec<([&'static str; 3], &Metric)> {
                vec![$(([$name, stringify!($kind), $help], &self.$field)),+]
            }
        }
    };
}

metrics! {
    clients, "clients", gauge, "Clients that are connected.";
    sockets, "sockets", gauge, "Sockets that are open.";
    turned_away, "sockets_turned_away_total", counter, "Sockets beyond the limit.";
    events, "source_events_total", counter, "Events of sources.";
    missed, "source_events_missed_total", counter, "Events that found no room.";
    sent, "messages_sent_total", counter, "Messages to clients.";
    sent_bytes, "bytes_sent_total", counter, "Bytes of messages to clients.";
    received, "messages_received_total", counter, "Messages from clients.";
    malformed, "messages_malformed_total", counter, "Messages that could not be read.";
    refused, "requests_refused_total", counter, "Requests against the rules.";
    shown_out, "shown_out_total", counter, "Connections that the bridge ended.";
    intruders, "intruders_total", counter, "Clients without a right to come in.";
    orders, "orders_total", counter, "Orders to the robot.";
}

impl Metrics {
    /// All metrics in Prometheus' text format.
    ///
    /// Source: Prometheus, "Exposition formats", text format 0.0.4.
    #[must_use]
    pub(crate) fn text(&self) -> String {
        let mut text = String::new();
        for ([name, kind, help], metric) in self.rows() {
            let value = metric.0.load(Ordering::Relaxed);
            // Writing to a string cannot fail.
            let _ = write!(
                text,
                "# HELP slamlab_{name} {help}\n# TYPE slamlab_{name} {kind}\nslamlab_{name} {value}\n"
            );
        }
        text
    }
}
