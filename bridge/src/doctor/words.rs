//! What the doctor itself says, beside what ports and devices say of themselves: each with its cure. All of it stands in
//! `bridge/GUIDE.md`, and the test below holds that.

use super::finding::Measured;

/// Of a device that said what it is, and nothing else.
pub(super) const SENDS_NOTHING: &str = "it answers, but sends no data";
/// Of a port on which nothing came.
pub(super) const NOTHING_ANSWERS: &str = "nothing answers at 38400, 230400 or 115200 baud: the device has no power, or TX and RX are swapped or \
     loose; of an LD06 only its TX goes to this port";

/// Of a port on which something came that nobody understands.
pub(super) fn unknown(bytes: u64) -> String {
    format!(
        "{bytes} bytes came, but nothing that slamlab knows: another device, or another baud rate than 38400 (RP6), \
         230400 (LD06) and 115200 (RPLIDAR A1)"
    )
}

/// Of a line that damages more than a good one does.
pub(super) fn noisy(measured: &Measured) -> String {
    format!(
        "the line is noisy ({} damaged frames in {:.1} s): use a shorter cable, connect the grounds, keep it away from \
         the motors",
        measured.damaged, measured.seconds
    )
}

#[cfg(test)]
mod tests;
