//! Which method to use for two scans, from measurements on similar scans.
//!
//! In: how two clouds lie on each other ([`Likeness`]), and how far off the start is. Out: the
//! condition of the measured table that they are most like, and the method that did best there.
//!
//! 1. For each condition, the table holds what its pairs are like in the median, and for each
//!    method how often it found the motion and how long it took.
//! 2. The nearest condition is the one whose figures differ least, each by its own scale.
//! 3. Of the methods that found the motion nearly as often as the best one, the fastest is taken.
//!
//! The table is measured by `report -- registration`, which fails if the table no longer holds.

use super::CloudMethod;
use super::judge::Likeness;
use super::measured::MEASURED;

/// What was measured for one method under one condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredMethod {
    /// Its name, as in [`CloudMethod::all`].
    pub name: &'static str,
    /// Part of all pairs for which it found the motion, and of those whose start is near.
    pub found: [f64; 2],
    /// Median time, µs, on the machine of the table.
    pub micros: f64,
    /// Part of the results it calls converged that are off by more than three of its σ.
    pub wrong: f64,
}

/// What was measured under one condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredCondition {
    /// As the report names it.
    pub name: &'static str,
    /// As people read it: "scans like ...".
    pub title: &'static str,
    /// What its pairs are like, in the median.
    pub likeness: Likeness,
    /// All methods, in the order of [`CloudMethod::all`].
    pub methods: [MeasuredMethod; CloudMethod::COUNT],
}

/// Starts up to here count as near: a shift, m, ...
pub const NEAR_SHIFT: f64 = 0.5;
/// ... and a turn, rad.
pub const NEAR_TURN: f64 = 0.2618;

/// Differences that have equal weight.
const SCALE: Likeness = Likeness {
    overlap: 0.25,
    sigma: 0.01,
    scatter: 0.2,
};
/// A method is as good as the best one if its success rate is lower by at most this part.
const AS_GOOD: f64 = 0.03;

/// Which method to use, and why.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Advice {
    /// The condition that the scans are most like.
    pub condition: &'static MeasuredCondition,
    /// Whether the start is near.
    pub is_near: bool,
    /// The method to take.
    pub method: &'static MeasuredMethod,
    /// The method that found the motion most often; often the same.
    pub surest: &'static MeasuredMethod,
    /// The method that takes the least time.
    pub fastest: &'static MeasuredMethod,
}

/// Which method to use for scans like these, from a start that is off by `shift`, m, and `turn`,
/// rad.
#[must_use]
pub fn advise(likeness: &Likeness, shift: f64, turn: f64) -> Option<Advice> {
    let is_near = shift <= NEAR_SHIFT && turn.abs() <= NEAR_TURN;
    let found = |method: &MeasuredMethod| method.found[usize::from(is_near)];
    let condition = MEASURED.iter().min_by(|a, b| {
        let [a, b] = [a, b].map(|condition| distance(likeness, &condition.likeness));
        a.total_cmp(&b)
    })?;
    let methods = condition.methods.iter();
    let surest = methods.max_by(|a, b| found(a).total_cmp(&found(b)))?;
    let by_time = |a: &&MeasuredMethod, b: &&MeasuredMethod| a.micros.total_cmp(&b.micros);
    let good = |method: &&MeasuredMethod| found(method) >= found(surest) - AS_GOOD;
    Some(Advice {
        condition,
        is_near,
        method: condition.methods.iter().filter(good).min_by(by_time)?,
        surest,
        fastest: condition.methods.iter().min_by(by_time)?,
    })
}

fn distance(a: &Likeness, b: &Likeness) -> f64 {
    let parts = [
        (a.overlap - b.overlap) / SCALE.overlap,
        (a.sigma - b.sigma) / SCALE.sigma,
        (a.scatter - b.scatter) / SCALE.scatter,
    ];
    parts.iter().map(|part| part * part).sum()
}
