//! Bytes that have arrived and are not a frame yet, and counts of what became of all of them.

use std::collections::VecDeque;

/// What became of the bytes that a decoder took. Invariant: `bytes` is the sum of those of frames,
/// `discarded`, and those that wait.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Bytes taken in.
    pub bytes: u64,
    /// Frames handed on.
    pub frames: u64,
    /// Pieces that began like a frame and failed the check.
    pub rejected: u64,
    /// Bytes thrown away, including those of rejected frames.
    pub discarded: u64,
}

/// A queue of bytes that keeps the [`Tally`].
#[derive(Clone, Debug, Default)]
pub(super) struct Inbox {
    waiting: VecDeque<u8>,
    tally: Tally,
}

impl Inbox {
    pub(super) fn extend(&mut self, bytes: &[u8]) {
        self.waiting.extend(bytes);
        self.tally.bytes += bytes.len() as u64;
    }

    pub(super) fn len(&self) -> usize {
        self.waiting.len()
    }

    /// The `N` bytes from `start` on, once they have arrived.
    pub(super) fn peek<const N: usize>(&self, start: usize) -> Option<[u8; N]> {
        let mut bytes = [0; N];
        for (byte, waiting) in bytes
            .iter_mut()
            .zip(self.waiting.range(start.min(self.len())..))
        {
            *byte = *waiting;
        }
        (self.len() >= start + N).then_some(bytes)
    }

    /// Whether the waiting bytes are the beginning of `bytes`, or begin with all of them.
    pub(super) fn may_begin(&self, bytes: &[u8]) -> bool {
        self.waiting.iter().zip(bytes).all(|(a, b)| a == b)
    }

    /// Takes the bytes of a good frame.
    pub(super) fn accept(&mut self, count: usize) {
        self.waiting.drain(..count.min(self.len()));
        self.tally.frames += 1;
    }

    /// Throws bytes away.
    pub(super) fn discard(&mut self, count: usize) {
        drop(self.drain(count));
    }

    /// Throws bytes away and returns them: what is not a frame can still be text. Those that the
    /// caller does not read are gone too.
    pub(super) fn drain(&mut self, count: usize) -> impl Iterator<Item = u8> + '_ {
        let count = count.min(self.len());
        self.tally.discarded += count as u64;
        self.waiting.drain(..count)
    }

    /// Notes that a frame failed its check.
    pub(super) fn reject(&mut self) {
        self.tally.rejected += 1;
    }

    pub(super) fn tally(&self) -> Tally {
        self.tally
    }
}
