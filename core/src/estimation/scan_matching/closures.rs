//! Loop closures that wait for proof, and when it is enough.
//!
//! In: placements of new submaps in old ones, each found in a window as wide as the doubt. Out:
//! those that are believed.
//!
//! 1. A placement that needed no search is believed at once: it says what was known already, only
//!    better.
//! 2. One that was searched for waits. It is believed together with others that agree with it: they
//!    place other submaps, and the ways between the submaps, old and new, lead to the same relative
//!    pose.
//! 3. The proof that is asked for grows with the number of places that were searched: by chance
//!    something fits somewhere. It grows with its distance from where the way leads, too: where the
//!    true place was never seen, no rival tells it from one that looks alike. Beyond all that was
//!    feared of the way nothing is proof.
//! 4. While rivals put the same submaps elsewhere and are nearly as well proved, none is believed:
//!    the building looks alike there, and what comes next decides.
//! 5. What is believed and then not followed by the graph, since the way and other closures hold
//!    the map elsewhere, waits again.
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
    /// What was known of the relative pose before.
    pub(super) doubt: Doubt,
    pub(super) record: RecordId,
}

/// Placements that wait.
#[derive(Clone, Debug, Default)]
pub(super) struct Waiting {
    list: Vec<Candidate>,
}

/// What a placement has for itself, in submaps that lie wholly on one another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proof {
    /// Of itself and of those that agree with it.
    pub evidence: f64,
    /// What is asked for with its doubt.
    pub asked: f64,
    /// Of the best that contradicts it.
    pub rival: f64,
}

impl Proof {
    /// Why it is not to be believed; `None` if it is.
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

/// How two placements stand to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Relation {
    Agree,
    Contradict,
    /// The ways between them are known too badly to say.
    Unknown,
}

/// The error that placements may have themselves, m and rad.
const PLACED_SHIFT: f64 = 0.08;
const PLACED_TURN: f64 = 0.015;
/// Placements that lead apart by more than this, m and rad, do not prove each other, however badly
/// the ways are known: buildings repeat themselves every few metres.
const AGREES_SHIFT: f64 = 0.75;
const AGREES_TURN: f64 = 0.15;
/// Ways that are known worse than this say nothing, m.
const MOST_DOUBT: f64 = 3.0;
/// The evidence that is asked for where hardly anything was searched, in submaps that lie wholly on
/// one another, ...
const LEAST_PROOF: f64 = 0.5;
/// ... and for each e-fold of places.
const PROOF_FOR_PLACES: f64 = 0.25;
/// A placement is as far from where it was expected as this, on the mean: degrees of freedom.
pub(super) const FREEDOM: f64 = 3.0;
/// One true placement in a thousand is farther from where it was expected than this, χ², even where
/// all that is feared has come true. What fits so far away is another place that looks alike:
/// in a building that repeats itself more and more of it fits, so no evidence is enough.
const BEYOND_BELIEF: f64 = 16.27;
/// What is asked for then: more than any map can have, and finite, so that it can be saved.
const NONE_IS_ENOUGH: f64 = 1e6;
/// A window of so small a doubt is one place, m and rad.
const PLACE_SHIFT: f64 = 0.17;
const PLACE_TURN: f64 = 0.033;
/// Rivals must be proved so much less.
const LEAD_OVER_RIVALS: f64 = 1.4;
/// Most placements that wait; the oldest go first.
const MOST_WAITING: usize = 400;

/// What is known of the way between two submaps: the pose of the second in the first, and its
/// doubt.
pub(super) trait Ways {
    fn way(&self, from: usize, to: usize) -> (Pose2, Doubt);

    /// How far a placement is from where the way leads.
    fn surprise(&self, placed: &Candidate) -> Surprise;
}

/// How far a placement is from where the way leads: χ², [`FREEDOM`] degrees of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Surprise {
    /// By what is feared of the way.
    pub(super) by_fear: f64,
    /// By what loops have shown of it, which is at least as much.
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

    /// Takes over those of another map, of which the submaps and records are numbered from
    /// `submaps` and `records` on.
    pub(super) fn append(&mut self, other: Self, submaps: usize, records: usize) {
        self.list.extend(other.list.into_iter().map(|c| Candidate {
            old: c.old + submaps,
            new: c.new + submaps,
            record: c.record.shifted(records),
            ..c
        }));
    }

    /// Keeps those of which both submaps are left, under new `numbers`.
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

    /// Takes out the placements that are proved together with one of submap `new`, if they are:
    /// `proof` times what is asked for.
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
            // Each for its own doubt: those that are known better do not vouch for the others.
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

    /// Refuses what waits of submaps that were placed elsewhere, and that was believed.
    pub(super) fn refuse_others(&mut self, placed: &[usize], records: &mut Records) {
        self.list.retain(|c| {
            let is_placed = placed.contains(&c.new);
            if is_placed {
                records.decide(c.record, refused(Refusal::PlacedElsewhere));
            }
            !is_placed
        });
    }

    /// Those that agree with the placement `seed`, itself among them, and those that contradict it.
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

    /// What placements prove together: of each new submap the best.
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

/// The evidence that is asked for with this doubt.
pub(super) fn places_proof(doubt: &Doubt) -> f64 {
    let along = (doubt.shift / PLACE_SHIFT).max(1.0);
    let about = (doubt.turn / PLACE_TURN).max(1.0);
    let places = along * about;
    LEAST_PROOF + PROOF_FOR_PLACES * libm::log(places)
}

/// The evidence that is asked for beyond that for a placement so far from where the way leads: it
/// is less probable by `exp(-χ² / 2)` beforehand.
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
