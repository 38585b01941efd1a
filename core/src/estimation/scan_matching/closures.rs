//! Loop closures that wait for proof, and the test of whether the proof suffices.
//!
//! In: placements of new submaps in old ones, each found in a window as wide as the doubt. Out: the
//! accepted ones.
//!
//! 1. A placement that needed no search is accepted at once: it only refines what was known
//!    already.
//! 2. A placement that was searched for waits. It is accepted together with others that agree with
//!    it: they place other submaps, and the paths between the submaps, old and new, lead to the
//!    same relative pose.
//! 3. The required proof grows with the number of places searched: by chance something fits
//!    somewhere. It also grows with the distance from where the path predicts the placement: where
//!    the true place was never seen, no rival distinguishes it from one that looks alike. Beyond
//!    all uncertainty of the path, no proof is enough.
//! 4. While rivals place the same submaps elsewhere with nearly as much proof, none is accepted:
//!    the building looks alike there, and later evidence decides.
//! 5. A closure that is accepted but not followed by the graph, because the path and other closures
//!    hold the map elsewhere, waits again.
//!
//! Source of step 2: Mangelson et al. (2018), "Pairwise consistent measurement set maximization for
//! robust multi-robot map merging".

use std::collections::BTreeMap;

use super::super::submap::{Closure, Doubt};
use super::records::{ClosureFate, Delay, RecordId, Records, Refusal};
use crate::geom::{Length, Pose2};
use crate::snapshot::snapshot;

/// A placement of one submap in another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) old: usize,
    pub(super) new: usize,
    pub(super) closure: Closure,
    /// The prior uncertainty of the relative pose.
    pub(super) doubt: Doubt,
    pub(super) record: RecordId,
}

/// Placements that wait for proof.
#[derive(Clone, Debug, Default)]
pub(super) struct Waiting {
    list: Vec<Candidate>,
}

/// The evidence for a placement, in submaps that lie wholly on one another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proof {
    /// Of itself and of the placements that agree with it.
    pub evidence: f64,
    /// The evidence required at its doubt.
    pub asked: f64,
    /// Of the best placement that contradicts it.
    pub rival: f64,
}

impl Proof {
    /// What it lacks to be accepted; `None` if nothing.
    pub(super) fn lacks(&self) -> Option<Delay> {
        if self.asked >= NONE_IS_ENOUGH {
            Some(Delay::BeyondBelief)
        } else if !self.is_enough() {
            Some(Delay::TooLittleProof)
        } else if self.evidence < LEAD_OVER_RIVALS * self.rival {
            Some(Delay::Rivals)
        } else {
            None
        }
    }

    fn is_enough(&self) -> bool {
        self.evidence >= self.asked
    }
}

/// How two placements relate to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Relation {
    Agree,
    Contradict,
    /// The paths between them are too uncertain to tell.
    Unknown,
}

/// The error that placements may have themselves, m and rad.
const PLACED_SHIFT: f64 = 0.08;
const PLACED_TURN: f64 = 0.015;
/// Placements that differ by more than this, m and rad, do not prove each other, however uncertain
/// the paths: buildings repeat themselves every few metres.
const AGREES_SHIFT: f64 = 0.75;
const AGREES_TURN: f64 = 0.15;
/// Paths with more uncertainty than this, m, say nothing.
const MOST_DOUBT: f64 = 3.0;
/// The evidence required where hardly anything was searched, in submaps that lie wholly on one
/// another, ...
const LEAST_PROOF: f64 = 0.5;
/// ... and for each e-fold of places.
const PROOF_FOR_PLACES: f64 = 0.25;
/// The mean χ² distance of a placement from where it was expected: its degrees of freedom.
pub(super) const FREEDOM: f64 = 3.0;
/// One true placement in a thousand is farther from where it was expected than this, χ², even with
/// the worst drift assumed. What fits so far away is another place that looks alike: in a building
/// that repeats itself, more and more of it fits, so no evidence is enough.
const BEYOND_BELIEF: f64 = 16.27;
/// The evidence required then: more than any map can have, yet finite, so that it can be saved.
const NONE_IS_ENOUGH: f64 = 1e6;
/// A search window of this doubt, m and rad, counts as one place.
const PLACE_SHIFT: f64 = 0.17;
const PLACE_TURN: f64 = 0.033;
/// The evidence of rivals must be smaller by this factor.
const LEAD_OVER_RIVALS: f64 = 1.4;
/// The most placements that may wait; the oldest are dropped first.
const MOST_WAITING: usize = 400;

/// What is known of the path between two submaps: the pose of the second in the first, and its
/// doubt.
pub(super) trait Ways {
    fn way(&self, from: usize, to: usize) -> (Pose2, Doubt);

    /// How far a placement is from where the path predicts it.
    fn surprise(&self, placed: &Candidate) -> Surprise;
}

/// How far a placement is from where the path predicts it: χ², [`FREEDOM`] degrees of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Surprise {
    /// By the drift assumed for the path.
    pub(super) by_fear: f64,
    /// By the drift that loops have shown; at least as large.
    pub(super) by_loops: f64,
}

impl Surprise {
    fn is_beyond_belief(self) -> bool {
        self.by_fear > BEYOND_BELIEF
    }
}

impl Waiting {
    /// All of them.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Candidate> {
        self.list.iter()
    }

    /// Takes over the placements of another map whose submaps and records are numbered from
    /// `submaps` and `records` on.
    pub(super) fn append(&mut self, other: Self, submaps: usize, records: usize) {
        self.list.extend(other.list.into_iter().map(|c| Candidate {
            old: c.old + submaps,
            new: c.new + submaps,
            record: c.record.shifted(records),
            ..c
        }));
    }

    /// Keeps placements whose two submaps both remain, under new `numbers`.
    pub(super) fn keep(&mut self, numbers: impl Fn((usize, usize)) -> Option<(usize, usize)>) {
        self.list.retain_mut(|candidate| {
            let kept = numbers((candidate.old, candidate.new));
            (candidate.old, candidate.new) = kept.unwrap_or_default();
            kept.is_some()
        });
    }

    pub(super) fn push(&mut self, candidate: Candidate, records: &mut Records) {
        self.list.push(candidate);
        if self.list.len() > MOST_WAITING {
            let oldest = self.list.remove(0);
            records.decide(oldest.record, refused(Refusal::NeverProved));
        }
    }

    /// Takes out the placements that are proved together with one of submap `new`, if any: those
    /// with `proof` times the required evidence.
    pub(super) fn take_proved(
        &mut self,
        new: usize,
        ways: &impl Ways,
        proof: f64,
        records: &mut Records,
    ) -> Vec<Candidate> {
        let seeds: Vec<usize> = (0..self.list.len())
            .filter(|&i| self.list[i].new == new)
            .collect();
        let asked = |candidate: &Candidate| {
            let surprise = ways.surprise(candidate);
            if surprise.is_beyond_belief() {
                return NONE_IS_ENOUGH;
            }
            proof * (places_proof(&candidate.doubt) + surprise_proof(surprise.by_loops))
        };
        let mut best: Option<(Proof, Vec<usize>)> = None;
        for &seed in &seeds {
            let (members, rivals) = self.sides(seed, ways);
            let evidence = self.evidence(&members);
            let rival = rivals
                .iter()
                .filter(|&&r| !ways.surprise(&self.list[r]).is_beyond_belief())
                .map(|&r| self.evidence(&self.sides(r, ways).0))
                .fold(0.0, f64::max);
            // Each by its own doubt: placements with less doubt do not vouch for the others.
            let proof_of = |member: usize| Proof {
                evidence,
                asked: asked(&self.list[member]),
                rival,
            };
            let of_seed = proof_of(seed);
            records.judge(self.list[seed].record, of_seed);
            let is_better = best.as_ref().is_none_or(|(b, _)| evidence > b.evidence);
            if of_seed.lacks().is_none() && is_better {
                let is_proved = |&member: &usize| proof_of(member).is_enough();
                best = Some((of_seed, members.into_iter().filter(is_proved).collect()));
            }
        }
        let Some((best, members)) = best else {
            return vec![];
        };
        let taken: Vec<Candidate> = members.iter().map(|&i| self.list[i]).collect();
        for candidate in &taken {
            let asked = asked(candidate);
            records.judge(candidate.record, Proof { asked, ..best });
        }
        self.list
            .retain(|c| !taken.iter().any(|t| t.record == c.record));
        taken
    }

    /// Refuses waiting placements of submaps that were accepted at another place.
    pub(super) fn refuse_others(&mut self, placed: &[usize], records: &mut Records) {
        self.list.retain(|c| {
            let is_placed = placed.contains(&c.new);
            if is_placed {
                records.decide(c.record, refused(Refusal::PlacedElsewhere));
            }
            !is_placed
        });
    }

    /// The placements that agree with `seed`, itself included, and those that contradict it.
    fn sides(&self, seed: usize, ways: &impl Ways) -> (Vec<usize>, Vec<usize>) {
        let (mut agree, mut contradict) = (vec![seed], vec![]);
        for other in (0..self.list.len()).filter(|&i| i != seed) {
            match self.relation(seed, other, ways) {
                Relation::Agree => agree.push(other),
                Relation::Contradict => contradict.push(other),
                Relation::Unknown => {}
            }
        }
        (agree, contradict)
    }

    fn relation(&self, a: usize, b: usize, ways: &impl Ways) -> Relation {
        let (a, b) = (&self.list[a], &self.list[b]);
        let (old_from_other, old_doubt) = ways.way(a.old, b.old);
        let (new_from_other, new_doubt) = ways.way(a.new, b.new);
        let variance = old_doubt.shift * old_doubt.shift + new_doubt.shift * new_doubt.shift;
        if variance > MOST_DOUBT * MOST_DOUBT {
            return Relation::Unknown;
        }
        let turn = (old_doubt.turn * old_doubt.turn
            + new_doubt.turn * new_doubt.turn
            + 2.0 * PLACED_TURN * PLACED_TURN)
            .sqrt();
        let lever = new_from_other.position().coords.length();
        let shift = (variance
            + 2.0 * PLACED_SHIFT * PLACED_SHIFT
            + lever * lever * (PLACED_TURN * PLACED_TURN))
            .sqrt();
        let by_a = a.closure.motion * new_from_other;
        let by_b = old_from_other * b.closure.motion;
        let off = by_a.delta_to(&by_b);
        let (far, about) = (off.position().coords.length(), off.heading().abs());
        if far > 3.0 * shift || about > 3.0 * turn {
            Relation::Contradict
        } else if far < AGREES_SHIFT && about < AGREES_TURN {
            Relation::Agree
        } else {
            Relation::Unknown
        }
    }

    /// What placements prove together: the best one of each new submap counts.
    fn evidence(&self, members: &[usize]) -> f64 {
        let mut best = BTreeMap::new();
        for &member in members {
            let candidate = &self.list[member];
            let entry = best.entry(candidate.new).or_insert(0.0_f64);
            *entry = entry.max(candidate.closure.proof());
        }
        best.values().sum()
    }
}

fn refused(why: Refusal) -> ClosureFate {
    ClosureFate::Refused { why }
}

/// The evidence required at this doubt.
pub(super) fn places_proof(doubt: &Doubt) -> f64 {
    let along = (doubt.shift / PLACE_SHIFT).max(1.0);
    let about = (doubt.turn / PLACE_TURN).max(1.0);
    let places = along * about;
    LEAST_PROOF + PROOF_FOR_PLACES * libm::log(places)
}

/// The additional evidence required for a placement this far from where the path predicts it: its
/// prior probability is lower by `exp(-χ² / 2)`.
fn surprise_proof(chi2: f64) -> f64 {
    PROOF_FOR_PLACES * 0.5 * (chi2 - FREEDOM).max(0.0)
}

snapshot!(Candidate {
    old,
    new,
    closure,
    doubt,
    record,
});
snapshot!(Waiting { list });
snapshot!(Proof {
    evidence,
    asked,
    rival,
});

#[cfg(test)]
pub(super) mod tests;
