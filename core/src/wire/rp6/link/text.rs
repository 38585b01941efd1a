//! The plain text of the boot loader and the vendor's firmware.
//!
//! In: bytes. Out: which of three phrases has just ended. They are searched for in the raw stream,
//! because a boot loader sends no markers. In a frame, nine or more matching bytes in a row do not
//! occur by chance.

const PHRASES: [(&[u8], Heard); 3] = [
    (b"[RP6BOOT]", Heard::BootLoader),
    (b"[READY]", Heard::Ready),
    (b"EMERGENCY SHUTDOWN", Heard::EmergencyShutdown),
];
/// Length of the longest phrase.
const LONGEST: usize = 18;

/// A phrase that means something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Heard {
    /// The boot loader has started.
    BootLoader,
    /// It waits for `s`.
    Ready,
    /// The vendor's firmware has given up.
    EmergencyShutdown,
}

/// The last bytes of the stream.
#[derive(Clone, Debug, Default)]
pub(super) struct TextWatch {
    last: [u8; LONGEST],
}

impl TextWatch {
    pub(super) fn push(&mut self, byte: u8) -> Option<Heard> {
        self.last.rotate_left(1);
        if let Some(newest) = self.last.last_mut() {
            *newest = byte;
        }
        let said = PHRASES
            .iter()
            .find(|(phrase, _)| self.last.ends_with(phrase));
        said.map(|(_, heard)| *heard)
    }
}
