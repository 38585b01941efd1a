//! The real firmware as a device on a line, in real time.
//!
//! In: bytes at the line's speed, time. Out: what the firmware sends; when its motors went off
//! after the cable was pulled, by the registers and the chip's own clock.
//!
//! Where the machine is too slow, the chip's clock runs behind the real one and never makes up for
//! it ([`Wired::behind`]): everything about the robot stays true in its own time.

use std::collections::VecDeque;
use std::time::Instant;

use slamlab_core::geom::Pose2;
use slamlab_tests::devices::{Carrier, Device};

use crate::Rig;
use crate::edge::EdgeWatch;

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
    /// When what should stop it happened, by its clock and by the real one.
    marked: Option<(f64, Instant)>,
    /// Since when both registers are 0.
    off: Option<(f64, Instant)>,
    stopped_after: Option<[f64; 2]>,
    edge: EdgeWatch,
    fault: Option<String>,
    boot: Boot,
    said: Vec<u8>,
}

/// What the vendor's boot loader does after a reset; the simulated chip has none of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Boot {
    Done,
    /// Seconds until it is ready.
    Begins(f64),
    /// Waits for `s`.
    Waits,
}

/// Registers that are 0 for so long are off, and do not only pass through 0 while the robot brakes,
/// s.
const STAYS_OFF: f64 = 0.2;
/// From reset to `[READY]`, s.
const BOOT: f64 = 0.1;

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
            marked: None,
            off: None,
            stopped_after: None,
            edge: EdgeWatch::default(),
            fault: None,
            boot: Boot::Done,
            said: vec![],
        }
    }

    /// Whether a motor gets voltage, by the compare registers.
    #[must_use]
    pub fn is_driven(&self) -> bool {
        self.rig.chip.duties() != [0, 0]
    }

    /// Seconds from the last [`Wired::mark`] or pulled cable until both registers were 0 and stayed
    /// so, by the robot's clock and by the real one; `None` until they are, or where they were
    /// before.
    #[must_use]
    pub fn stopped_after(&self) -> Option<[f64; 2]> {
        self.stopped_after
    }

    /// Something happens that should stop it.
    pub fn mark(&mut self) {
        self.stopped_after = None;
        self.marked = self
            .is_driven()
            .then(|| (self.rig.seconds(), Instant::now()));
    }

    /// The next count of an encoder is looked for.
    pub fn watch_edge(&mut self) {
        self.edge.set(self.rig.counts());
    }

    /// When that was, and when the robot had reported it: [`EdgeWatch::instants`].
    #[must_use]
    pub fn edge(&self) -> [Option<f64>; 2] {
        self.edge.instants()
    }

    /// Somebody presses the reset button: the boot loader speaks, and waits for `s`.
    pub fn reset(&mut self) {
        self.mark();
        self.line.clear();
        self.rig.chip.reset();
        self.boot = Boot::Begins(BOOT);
        self.said = b"[RP6BOOT]\n".to_vec();
        self.watch();
    }

    /// What the robot says while the boot loader has the chip.
    fn boot(&mut self, seconds: f64) {
        match self.boot {
            Boot::Begins(left) if left > seconds => self.boot = Boot::Begins(left - seconds),
            Boot::Begins(_) => {
                self.boot = Boot::Waits;
                self.line.clear();
                self.said.extend(b"[READY]\n");
            }
            Boot::Waits if self.line.contains(&b's') => {
                self.boot = Boot::Done;
                self.line.clear();
            }
            Boot::Waits | Boot::Done => (),
        }
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
        if self.boot != Boot::Done {
            self.boot(seconds);
            return;
        }
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
            self.edge.saw(self.rig.counts());
            self.watch();
        }
    }

    fn watch(&mut self) {
        if self.is_driven() {
            self.off = None;
            return;
        }
        let (chip, real) = *self
            .off
            .get_or_insert_with(|| (self.rig.seconds(), Instant::now()));
        if let Some((marked, marked_real)) = self.marked
            && self.rig.seconds() - chip > STAYS_OFF
        {
            let real = real.saturating_duration_since(marked_real).as_secs_f64();
            self.stopped_after = Some([(chip - marked).max(0.0), real]);
            self.marked = None;
        }
    }
}

impl Carrier for Wired {
    fn pose(&self) -> Pose2 {
        self.rig.pose()
    }

    fn seconds(&self) -> f64 {
        self.rig.seconds()
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
        // Now, whoever marked it before: a cable that is cut in the middle of a frame waits for
        // one.
        if self.is_driven() {
            self.mark();
        }
    }

    fn receive(&mut self, bytes: &[u8]) {
        self.line.extend(bytes);
    }

    fn advance(&mut self, seconds: f64) -> Vec<u8> {
        self.run(seconds);
        let mut said = std::mem::take(&mut self.said);
        let sent = self.rig.chip.take_sent();
        self.edge.sent(&sent);
        said.extend(sent);
        said
    }
}
