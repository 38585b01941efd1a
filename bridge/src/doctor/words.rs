//! What the doctor itself says, in addition to what ports and devices report: each with its cure.
//! All of it is in `bridge/GUIDE.md`; the test below checks that.

use slamlab_core::device::{Kind, Probe};

use super::finding::Measured;

/// For a device that identified itself and sent nothing else.
pub(super) const SENDS_NOTHING: &str = "it answers, but sends no data";

/// For a port on which nothing came at these rates; `listeners` need one wire only.
pub(super) fn nothing_answers(rates: &str, listeners: &str) -> String {
    format!(
        "nothing answers at {rates} baud: the device has no power, or TX and RX are swapped or loose; of an \
         {listeners} only its TX goes to this port"
    )
}

/// For a port on which no known device was recognised in what came.
pub(super) fn unknown(bytes: u64, rates_of_kinds: &str) -> String {
    format!(
        "{bytes} bytes came, but nothing that slamlab knows: another device, or another baud rate than {rates_of_kinds}"
    )
}

/// For a port on which text came.
pub(super) fn speaks_text(rate: u32, text: &str) -> String {
    format!(
        "text comes at {rate} baud (\"{text}\"), but nothing that slamlab knows: a console, or a robot with another \
         program; an RP6 needs slamlab's firmware"
    )
}

/// The rates at which a port is tried.
pub(super) fn rates() -> String {
    list(
        Kind::in_order_of_trial()
            .iter()
            .map(|kind| kind.baud_rate.to_string()),
        "or",
    )
}

/// The same, each with the devices that use it.
pub(super) fn rates_of_kinds() -> String {
    let of_kind = |kind: &&Kind| format!("{} ({})", kind.baud_rate, kind.title);
    list(Kind::in_order_of_trial().iter().map(of_kind), "and")
}

/// Titles of the kinds that are never sent any bytes.
pub(super) fn listeners() -> String {
    let kinds = Kind::distinct().filter(|kind| kind.probe == Probe::Listen);
    list(kinds.map(|kind| kind.title.to_owned()), "or")
}

/// "a, b or c".
fn list(items: impl Iterator<Item = String>, last: &str) -> String {
    let items: Vec<_> = items.collect();
    match items.split_last() {
        Some((end, [])) => end.clone(),
        Some((end, others)) => format!("{} {last} {end}", others.join(", ")),
        None => String::new(),
    }
}

/// For a line that damages more than a good one does.
pub(super) fn noisy(measured: &Measured) -> String {
    format!(
        "the line is noisy ({} damaged frames in {:.1} s): use a shorter cable, connect the grounds, keep it away from \
         the motors",
        measured.damaged, measured.seconds
    )
}

#[cfg(test)]
mod tests;
