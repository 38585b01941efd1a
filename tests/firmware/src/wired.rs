//! The real firmware as a device on a line, in real time.
//!
//! In: bytes at the line's speed, time. Out: what the firmware sends; when its motors went off after the cable was pulled, by the
//! registers and the chip's own clock.
//!
//! Where the machine is too slow, the chip's clock runs behind the real one and never makes up for it ([`Wired::behind`]):
//! everything about the robot stays true in its own time.

use std::collections::VecDeque;

use slamlab_tests::devices::Device;

use crate::Rig;

/// Seconds of a byte on the line, 10 bits at 38400 baud.
const BYTE: f64 = 10.0 / 38_400.0;
/// Most that is made up for at a time, s.
const MOST_BEHIND: f64 = 0.05;

/// A robot on a line. It has a battery of its own: a pulled cable does not switch it off.
pub struct Wired {
    /// The robot.
    pub rig: Rig,
    /// Bytes on their way to it, and when the next one is there.
    line: VecDeque<u8>,
    next_byte: f64,
    due: f64,
    behind: f64,
    pulled: Option<f64>,
    stopped_after: Option<f64>,
    fault: Option<String>,
}

impl Wired {
    /// This robot, just switched on.
    #[must_use]
    pub fn new(rig: Rig) -> Self {
        Self {
            due: rig.seconds(),
            rig,
            line: VecDeque::new(),
            next_byte: 0.0,
            behind: 0.0,
            pulled: None,
            stopped_after: None,
            fault: None,
        }
    }

    /// Whether a motor gets voltage, by the compare registers.
    #[must_use]
    pub fn is_driven(&self) -> bool {
        self.rig.chip.duties() != [0, 0]
    }

    /// Seconds of the robot's time from the last pull of the cable until both registers were 0; `None` until they are, or
    /// where they were before.
    #[must_use]
    pub fn stopped_after(&self) -> Option<f64> {
        self.stopped_after
    }

    /// Real seconds that the chip's clock has lost because the machine was too slow.
    #[must_use]
    pub fn behind(&self) -> f64 {
        self.behind
    }

    /// Why the chip does not run any more.
    #[must_use]
    pub fn fault(&self) -> Option<&str> {
        self.fault.as_deref()
    }

    fn run(&mut self, seconds: f64) {
        self.behind += (seconds - MOST_BEHIND).max(0.0);
        self.due += seconds.min(MOST_BEHIND);
        while self.fault.is_none() && self.rig.seconds() < self.due {
            let now = self.rig.seconds();
            if now >= self.next_byte
                && let Some(byte) = self.line.pop_front()
            {
                self.rig.chip.receive(byte);
                self.next_byte = now + BYTE;
            }
            if let Err(error) = self.rig.step() {
                self.fault = Some(format!("{error:#}"));
            }
            self.watch();
        }
    }

    fn watch(&mut self) {
        if let Some(pulled) = self.pulled
            && !self.is_driven()
        {
            self.stopped_after = Some(self.rig.seconds() - pulled);
            self.pulled = None;
        }
    }
}

impl Device for Wired {
    fn baud_rate(&self) -> u32 {
        38_400
    }

    fn power_on(&mut self) {}

    fn unplugged(&mut self, seconds: f64) {
        self.run(seconds);
        let _ = self.rig.chip.take_sent();
    }

    fn pulled(&mut self) {
        self.line.clear();
        self.stopped_after = None;
        self.pulled = self.is_driven().then(|| self.rig.seconds());
    }

    fn receive(&mut self, bytes: &[u8]) {
        self.line.extend(bytes);
    }

    fn advance(&mut self, seconds: f64) -> Vec<u8> {
        self.run(seconds);
        self.rig.chip.take_sent()
    }
}
