//! In: for each line of a scan, its candidate landmarks. Out: the largest set of pairings that
//! agree with each other.
//!
//! Each pairing by itself may be within its gate and yet contradict the others: a robot that stands
//! 20 cm from where it believes it is sees all walls shifted by 20 cm the same way. The errors of
//! the expected lines are correlated, because all are expected from one pose, and the joint
//! distance of a set of pairings accounts for this.
//!
//! 1. Depth first over the sightings: each is one of its candidates, or none.
//! 2. A set of m pairings is kept while its joint distance vᵀ C⁻¹ v is within the gate of χ² with
//!    2m degrees of freedom. C's Cholesky factor grows by two rows for each pairing, so a step
//!    costs O(m²).
//! 3. A branch that cannot have more pairings than the best one so far is cut; of two sets of equal
//!    size, the nearer one wins.
//! 4. Beyond the source: the gate for ten pairings has room for a wrong one among nine that fit
//!    well. So each pairing must also agree with what all others predict for it; the worst one is
//!    removed until all agree.
//! 5. Beyond the source: the largest set may be one of two that are equally likely. A sighting that
//!    another landmark would explain nearly as well, given all other pairings, is ambiguous, and
//!    paired with neither.
//!
//! Source: Neira & Tardós (2001), "Data association in stochastic mapping using the joint
//! compatibility test", algorithm JCBB.

mod members;

use nalgebra::{Matrix2, Vector2};

use self::members::Members;
use super::AssociationConfig;

/// A candidate landmark for a sighting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pairing {
    /// Number of the sighting.
    pub sighting: usize,
    /// Which landmark: any number, unique among the landmarks.
    pub landmark: usize,
    /// (α, r) seen minus expected; of a point, (x, y).
    pub v: Vector2<f64>,
    /// Covariance of `v`.
    pub cov: Matrix2<f64>,
}

/// What a sighting is, once all sightings of its scan are matched together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Paired {
    /// The landmark of this number.
    Landmark(usize),
    /// One of several that cannot be distinguished.
    Ambiguous,
    /// No landmark that agrees with the other pairings.
    #[default]
    Nothing,
}

/// The search, with buffers that it keeps from scan to scan.
#[derive(Clone, Debug, Default)]
pub struct JointSearch {
    pairings: Vec<Pairing>,
    /// For each sighting, the end of its pairings in the list.
    ends: Vec<usize>,
    set: Members,
    /// The pairing of each sighting, in the set being tried and in the best one.
    chosen: Vec<Option<usize>>,
    best: Vec<Option<usize>>,
    best_size: usize,
    n_sets: usize,
    /// What each sighting is, in the order of the sightings.
    paired: Vec<Paired>,
    /// Joint distance of the best set, χ² with twice as many degrees of freedom as it has pairings.
    d2: f64,
}

impl JointSearch {
    /// Forgets all sightings.
    pub fn clear(&mut self) {
        self.pairings.clear();
        self.ends.clear();
    }

    /// Adds a sighting with its candidate landmarks, the likeliest first.
    pub fn sight(&mut self, pairings: impl IntoIterator<Item = Pairing>) {
        self.pairings.extend(pairings);
        self.ends.push(self.pairings.len());
    }

    /// Finds the largest set of pairings that are jointly compatible; of several, the one with the
    /// least distance (steps 1 to 5).
    ///
    /// `cross` is the covariance of the innovations of two pairings of different sightings (first
    /// by second), or `None` if the two exclude each other.
    pub fn run(
        &mut self,
        cross: impl Fn(&Pairing, &Pairing) -> Option<Matrix2<f64>>,
        config: &AssociationConfig,
    ) -> &[Paired] {
        let n = self.ends.len();
        for chosen in [&mut self.chosen, &mut self.best] {
            chosen.clear();
            chosen.resize(n, None);
        }
        (self.best_size, self.n_sets) = (0, 0);
        self.paired.clear();
        self.paired.resize(n, Paired::Nothing);
        self.d2 = 0.0;
        self.set.clear();
        self.descend(0, 0.0, &cross, config);
        self.drop_outliers(&cross, config);
        self.conclude(&cross, config);
        &self.paired
    }

    fn pairings_of(&self, sighting: usize) -> std::ops::Range<usize> {
        let first = sighting
            .checked_sub(1)
            .map_or(0, |before| self.ends[before]);
        first..self.ends[sighting]
    }

    /// Steps 1 to 3.
    fn descend(
        &mut self,
        sighting: usize,
        d2: f64,
        cross: &impl Cross,
        config: &AssociationConfig,
    ) {
        self.keep_best(d2);
        if sighting >= self.ends.len() {
            return;
        }
        for place in self.pairings_of(sighting) {
            if self.is_hopeless(sighting + 1, self.set.len() + 1, d2, config) {
                break;
            }
            let Some(added) = self.set.join(place, &self.pairings, cross) else {
                continue;
            };
            let joint = d2 + added;
            if chi2_survival(joint, self.set.len()) >= libm::exp(-0.5 * config.gate) {
                self.chosen[sighting] = Some(place);
                self.descend(sighting + 1, joint, cross, config);
                self.chosen[sighting] = None;
            }
            self.set.leave();
        }
        if !self.is_hopeless(sighting + 1, self.set.len(), d2, config) {
            self.descend(sighting + 1, d2, cross, config);
        }
    }

    /// Whether no set that begins like this can be better than the best one so far.
    fn is_hopeless(
        &mut self,
        next: usize,
        size: usize,
        d2: f64,
        config: &AssociationConfig,
    ) -> bool {
        if self.n_sets >= config.most_sets {
            return true;
        }
        let most = size + self.ends.len().saturating_sub(next);
        most < self.best_size || (most == self.best_size && self.best_size > 0 && d2 >= self.d2)
    }

    fn keep_best(&mut self, d2: f64) {
        self.n_sets += 1;
        let size = self.set.len();
        if size > self.best_size || (size == self.best_size && d2 < self.d2) {
            self.best_size = size;
            self.d2 = d2;
            self.best.clone_from(&self.chosen);
        }
    }

    /// Step 4.
    fn drop_outliers(&mut self, cross: &impl Cross, config: &AssociationConfig) {
        // No part of a distance is greater than the whole.
        while self.d2 > config.outlier_gate {
            self.d2 = self.rebuild(None, cross);
            let (worst, d2) = self.set.worst();
            if d2 <= config.outlier_gate {
                return;
            }
            let gone = self.best.iter().filter(|place| place.is_some()).count();
            if let Some(place) = self.best.iter_mut().filter(|p| p.is_some()).nth(worst) {
                *place = None;
            }
            self.d2 = if gone > 1 {
                self.rebuild(None, cross)
            } else {
                0.0
            };
        }
    }

    /// Step 5, and what each sighting is.
    fn conclude(&mut self, cross: &impl Cross, config: &AssociationConfig) {
        for sighting in 0..self.ends.len() {
            let Some(place) = self.best[sighting] else {
                continue;
            };
            let is_ambiguous = self.pairings_of(sighting).len() > 1
                && self.has_rival(sighting, place, cross, config);
            self.paired[sighting] = match is_ambiguous {
                true => Paired::Ambiguous,
                false => Paired::Landmark(self.pairings[place].landmark),
            };
        }
    }

    fn has_rival(
        &mut self,
        sighting: usize,
        place: usize,
        cross: &impl Cross,
        config: &AssociationConfig,
    ) -> bool {
        self.rebuild(Some(sighting), cross);
        let Some(own) = self.distance_to_set(place, cross) else {
            return false;
        };
        let best = self.pairings[place].v;
        self.pairings_of(sighting).any(|other| {
            other != place
                && (self.pairings[other].v - best).amax() > config.same_place
                && self
                    .distance_to_set(other, cross)
                    .is_some_and(|d2| d2 - own < config.ambiguity)
        })
    }

    /// What a pairing would add to the joint distance of the set.
    fn distance_to_set(&mut self, place: usize, cross: &impl Cross) -> Option<f64> {
        let d2 = self.set.join(place, &self.pairings, cross)?;
        self.set.leave();
        Some(d2)
    }

    /// Makes the best set, without the pairing of one sighting, the current one; returns its
    /// distance.
    fn rebuild(&mut self, without: Option<usize>, cross: &impl Cross) -> f64 {
        self.set.clear();
        let mut d2 = 0.0;
        for (sighting, place) in self.best.iter().enumerate() {
            if let Some(place) = *place
                && without != Some(sighting)
            {
                d2 += self.set.join(place, &self.pairings, cross).unwrap_or(0.0);
            }
        }
        d2
    }
}

/// The covariance of two innovations, or that they exclude each other.
trait Cross: Fn(&Pairing, &Pairing) -> Option<Matrix2<f64>> {}

impl<F: Fn(&Pairing, &Pairing) -> Option<Matrix2<f64>>> Cross for F {}

/// The probability that χ² with `2 * pairs` degrees of freedom is greater than `d2`: e^(-x/2) Σ
/// (x/2)^i / i! for i < pairs.
#[must_use]
pub fn chi2_survival(d2: f64, pairs: usize) -> f64 {
    let half = 0.5 * d2;
    let (mut term, mut sum) = (1.0, 0.0);
    for i in 0..pairs {
        sum += term;
        term *= half / (i + 1) as f64;
    }
    sum * libm::exp(-half)
}

#[cfg(test)]
mod tests;
