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
//!    something fits somewhere.
//! 4. While rivals put the same submaps elsewhere and are nearly as well proved, none is believed:
//!    the building looks alike there, and what comes next decides.
//!
//! Source of step 2: Mangelson et al. (2018), "Pairwise consistent measurement set maximization for
//! robust multi-robot map merging".

use std::collections::BTreeMap;

use super::super::submap::{Closure, Doubt};
use crate::geom::Pose2;

/// A placement of one submap in another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) old: usize,
    pub(super) new: usize,
    pub(super) closure: Closure,
    /// What was known of the relative pose before.
    pub(super) doubt: Doubt,
}

/// Placements that wait.
#[derive(Clone, Debug, Default)]
pub(super) struct Waiting {
    list: Vec<Candidate>,
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
}

impl Waiting {
    pub(super) fn push(&mut self, candidate: Candidate) {
        self.list.push(candidate);
        if self.list.len() > MOST_WAITING {
            self.list.remove(0);
        }
    }

    /// Takes out the placements that are proved together with one of submap `new`, if they are:
    /// `proof` times what is asked for.
    pub(super) fn take_proved(
        &mut self,
        new: usize,
        ways: &impl Ways,
        proof: f64,
    ) -> Vec<Candidate> {
        let seeds: Vec<usize> = (0..self.list.len())
            .filter(|&i| self.list[i].new == new)
            .collect();
        let mut best: Option<(f64, Vec<usize>)> = None;
        for &seed in &seeds {
            let (members, rivals) = self.sides(seed, ways);
            let evidence = self.evidence(&members);
            let rival = rivals
                .iter()
                .map(|&r| self.evidence(&self.sides(r, ways).0))
                .fold(0.0, f64::max);
            let proves = |&i: &usize| evidence >= proof * places_proof(&self.list[i].doubt);
            let leads = evidence >= LEAD_OVER_RIVALS * rival;
            let is_better = best.as_ref().is_none_or(|(e, _)| evidence > *e);
            if leads && is_better && proves(&seed) {
                // Each for its own doubt: those that are known better do not vouch for the others.
                let members = members.into_iter().filter(proves).collect();
                best = Some((evidence, members));
            }
        }
        let Some((_, members)) = best else {
            return vec![];
        };
        let taken: Vec<Candidate> = members.iter().map(|&i| self.list[i]).collect();
        // What the same submaps were elsewhere is refused, and what agrees is taken.
        self.list.retain(|c| !taken.iter().any(|t| t.new == c.new));
        taken
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
        let lever = new_from_other.position().coords.norm();
        let shift = (variance
            + 2.0 * PLACED_SHIFT * PLACED_SHIFT
            + lever * lever * (PLACED_TURN * PLACED_TURN))
            .sqrt();
        let by_a = a.closure.motion * new_from_other;
        let by_b = old_from_other * b.closure.motion;
        let off = by_a.delta_to(&by_b);
        let (far, about) = (off.position().coords.norm(), off.heading().abs());
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

/// The evidence that is asked for with this doubt.
fn places_proof(doubt: &Doubt) -> f64 {
    let along = (doubt.shift / PLACE_SHIFT).max(1.0);
    let about = (doubt.turn / PLACE_TURN).max(1.0);
    let places = along * about;
    LEAST_PROOF + PROOF_FOR_PLACES * libm::log(places)
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;

    /// Submaps every 5 m along a straight way; it is known to 1 % and 0.001 rad a submap.
    struct Straight;

    impl Ways for Straight {
        fn way(&self, from: usize, to: usize) -> (Pose2, Doubt) {
            let apart = to as f64 - from as f64;
            let doubt = Doubt {
                shift: 0.05 * apart.abs(),
                turn: 0.001 * apart.abs(),
            };
            (Pose2::new(5.0 * apart, 0.0, 0.0), doubt)
        }
    }

    /// Submap `new` beside `old`, so far off to the side.
    fn beside(old: usize, new: usize, y: f64) -> Candidate {
        Candidate {
            old,
            new,
            closure: Closure {
                motion: Pose2::new(0.0, y, 0.0),
                information: Matrix3::identity(),
                is_searched: true,
                overlap: 0.7,
                part: 0.95,
            },
            doubt: Doubt {
                shift: 30.0,
                turn: 0.3,
            },
        }
    }

    fn taken(candidates: &[Candidate]) -> Vec<(usize, usize)> {
        let mut waiting = Waiting::default();
        let mut taken = vec![];
        for of_one in candidates.chunk_by(|a, b| a.new == b.new) {
            of_one.iter().for_each(|candidate| waiting.push(*candidate));
            let proved = waiting.take_proved(of_one[0].new, &Straight, 1.0);
            taken.extend(proved.iter().map(|c| (c.old, c.new)));
        }
        taken.sort_unstable();
        taken
    }

    #[test]
    fn one_placement_in_a_wide_window_waits_and_three_that_agree_are_believed() {
        assert_eq!(taken(&[beside(2, 40, 1.0)]), []);
        let agreeing = [beside(2, 40, 1.0), beside(3, 41, 1.05), beside(4, 42, 1.0)];
        assert_eq!(taken(&agreeing), [(2, 40), (3, 41), (4, 42)]);
    }

    #[test]
    fn one_placement_where_little_was_searched_is_believed_alone() {
        let mut near = beside(2, 40, 0.2);
        near.doubt = Doubt {
            shift: 0.15,
            turn: 0.03,
        };
        assert_eq!(taken(&[near]), [(2, 40)]);
    }

    #[test]
    fn rivals_that_are_as_well_proved_keep_each_other_waiting() {
        // The same corridor again 20 m on: each new submap fits in either.
        let twice = |new: usize| [beside(new - 38, new, 1.0), beside(new - 34, new, 1.0)];
        let alike: Vec<Candidate> = (40..46).flat_map(twice).collect();
        assert_eq!(taken(&alike), []);
        // What comes after fits in one of them alone.
        let mut decided = alike.clone();
        decided.extend((46..52).map(|new| beside(new - 38, new, 1.0)));
        let found = taken(&decided);
        assert!(found.len() >= 6, "{found:?}");
        assert!(found.iter().all(|(old, new)| new - old == 38), "{found:?}");
    }

    #[test]
    fn what_is_known_well_does_not_vouch_for_what_is_known_badly() {
        let known_to = |shift: f64, candidate: Candidate| Candidate {
            doubt: Doubt { shift, turn: 0.03 },
            ..candidate
        };
        let near = known_to(0.1, beside(38, 40, 0.1));
        let mut far = known_to(30.0, beside(2, 40, 0.1));
        far.closure.motion = Pose2::new(36.0 * 5.0 + 0.3, 0.1, 0.0);
        assert_eq!(taken(&[near, far]), [(38, 40)]);
    }

    #[test]
    fn those_that_contradict_each_other_prove_nothing_together() {
        let scattered = [beside(2, 40, 1.0), beside(3, 41, 9.0), beside(4, 42, -7.0)];
        assert_eq!(taken(&scattered), []);
    }
}
