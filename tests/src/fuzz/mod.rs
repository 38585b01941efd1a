//! Every decoder against malformed bytes, on a stable toolchain.
//!
//! In: a [`Target`], a number to begin with. Out: a [`Crash`] if there is one: bytes that made it
//! panic, take longer than [`TOO_LONG`], or break one of its laws.
//!
//! 1. Seeds are real data of devices and writers; each input is a known one, mutated (`mutate`).
//! 2. A target summarises what became of an input in one number. An input with a new number is kept
//!    and mutated further: feedback by outcome, because feedback by coverage needs a nightly
//!    compiler.
//! 3. Inputs follow from their number and those kept before, so a run continues where the last one
//!    ended. A crash saves its bytes, and from then on it is a test (`tests/crashes`).

mod file_seeds;
mod files;
mod mutate;
mod seeds;
mod targets;

use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use mutate::Mutator;
pub use targets::{Target, outcome};

/// Inputs of at most 64 KiB take less than this, on a slow machine too.
pub const TOO_LONG: Duration = Duration::from_secs(10);
/// Maximum number of inputs that are kept.
const MOST_KEPT: usize = 4096;

/// All decoders of the core.
pub fn targets() -> impl Iterator<Item = &'static Target> {
    targets::WIRES.iter().chain(files::FILES)
}

/// An input that is kept for ever, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Crash {
    /// What happened.
    pub what: String,
    /// The input.
    pub input: Vec<u8>,
}

/// The statistics of a run.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    /// Inputs tried.
    pub inputs: u64,
    /// Different outcomes.
    pub outcomes: usize,
    /// Longest time for one input.
    pub slowest: Duration,
}

/// A run against one target.
pub struct Run {
    target: &'static Target,
    kept: Vec<Vec<u8>>,
    outcomes: BTreeSet<u64>,
    next: u64,
    seen: Seen,
}

impl Run {
    /// Begins with input number `next`.
    #[must_use]
    pub fn new(target: &'static Target, next: u64) -> Self {
        Self {
            target,
            kept: (target.seeds)(),
            outcomes: BTreeSet::new(),
            next,
            seen: Seen::default(),
        }
    }

    /// Number of the next input.
    #[must_use]
    pub fn next(&self) -> u64 {
        self.next
    }

    /// The statistics so far.
    #[must_use]
    pub fn seen(&self) -> &Seen {
        &self.seen
    }

    /// Tries one input.
    ///
    /// # Errors    The [`Crash`].
    pub fn step(&mut self) -> Result<(), Crash> {
        let input = Mutator::new(self.next).change(&self.kept);
        self.next += 1;
        let begun = Instant::now();
        let outcome = try_one(self.target, &input)?;
        self.seen.inputs += 1;
        self.seen.slowest = self.seen.slowest.max(begun.elapsed());
        if self.kept.len() < MOST_KEPT && self.outcomes.insert(outcome) {
            self.kept.push(input);
        }
        self.seen.outcomes = self.outcomes.len();
        Ok(())
    }
}

/// Gives one input to a target.
///
/// # Errors    The [`Crash`].
pub fn try_one(target: &Target, input: &[u8]) -> Result<u64, Crash> {
    let crash = |what: String| Crash {
        what: format!("{}: {what}", target.name),
        input: input.to_vec(),
    };
    let begun = Instant::now();
    let outcome = catch_unwind(AssertUnwindSafe(|| (target.run)(input)));
    let outcome = outcome.map_err(|_| crash("it panicked".into()))?;
    let outcome = outcome.map_err(crash)?;
    if begun.elapsed() > TOO_LONG {
        return Err(crash(format!("it took {:?}", begun.elapsed())));
    }
    Ok(outcome)
}
