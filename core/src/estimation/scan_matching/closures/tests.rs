//! Placements made by hand: which are accepted, and what becomes of the others.

use nalgebra::Matrix3;

use super::*;

/// Submaps every 5 m along a straight path, known to 1 % and 0.001 rad per submap. All placements
/// are as surprising as given.
#[derive(Default)]
struct Straight {
    /// By the assumed drift, and by what loops have shown.
    surprise: [f64; 2],
}

impl Ways for Straight {
    fn way(&self, from: usize, to: usize) -> (Pose2, Doubt) {
        let apart = to as f64 - from as f64;
        let doubt = Doubt {
            shift: 0.05 * apart.abs(),
            turn: 0.001 * apart.abs(),
        };
        (Pose2::new(5.0 * apart, 0.0, 0.0), doubt)
    }

    fn surprise(&self, _: &Candidate) -> Surprise {
        Surprise {
            by_fear: self.surprise[0],
            by_loops: self.surprise[1],
        }
    }
}

/// Submap `new` placed in `old` by a search that found a large overlap.
pub(in super::super) fn found(old: usize, new: usize, motion: Pose2, doubt: Doubt) -> Candidate {
    let closure = Closure {
        motion,
        information: Matrix3::identity(),
        is_searched: true,
        overlap: 0.7,
        part: 0.95,
    };
    Candidate {
        old,
        new,
        closure,
        doubt,
        record: Records::default().begin((old, new), &closure, doubt),
    }
}

/// Submap `new` beside `old`, at this distance to the side.
fn beside(old: usize, new: usize, y: f64) -> Candidate {
    let doubt = Doubt {
        shift: 30.0,
        turn: 0.3,
    };
    found(old, new, Pose2::new(0.0, y, 0.0), doubt)
}

/// What waits after candidates have arrived, one new submap after the other.
#[derive(Default)]
struct Judged {
    waiting: Waiting,
    records: Records,
    taken: Vec<(usize, usize)>,
    ways: Straight,
}

impl Judged {
    fn of(candidates: &[Candidate]) -> Self {
        Self::surprised(candidates, [0.0; 2])
    }

    fn surprised(candidates: &[Candidate], surprise: [f64; 2]) -> Self {
        let mut judged = Self {
            ways: Straight { surprise },
            ..Self::default()
        };
        for of_one in candidates.chunk_by(|a, b| a.new == b.new) {
            of_one.iter().for_each(|candidate| judged.push(candidate));
            judged.take(of_one[0].new);
        }
        judged.taken.sort_unstable();
        judged
    }

    fn push(&mut self, candidate: &Candidate) {
        let Candidate {
            old,
            new,
            closure,
            doubt,
            ..
        } = *candidate;
        let record = self.records.begin((old, new), &closure, doubt);
        let candidate = Candidate {
            record,
            ..*candidate
        };
        self.waiting.push(candidate, &mut self.records);
    }

    fn take(&mut self, new: usize) {
        let proved = (self.waiting).take_proved(new, &self.ways, 1.0, &mut self.records);
        self.taken.extend(proved.iter().map(|c| (c.old, c.new)));
        let placed: Vec<usize> = proved.iter().map(|c| c.new).collect();
        self.waiting.refuse_others(&placed, &mut self.records);
    }

    /// What became of the placement of `new` in `old`, if it was not accepted.
    fn fate(&self, old: usize, new: usize) -> ClosureFate {
        let mut records = self.records.iter();
        let record = records.find(|r| (r.old, r.new) == (old, new)).unwrap();
        record.fate
    }
}

fn taken(candidates: &[Candidate]) -> Vec<(usize, usize)> {
    Judged::of(candidates).taken
}

#[test]
fn one_placement_in_a_wide_window_waits_and_three_that_agree_are_believed() {
    assert_eq!(taken(&[beside(2, 40, 1.0)]), []);
    let agreeing = [beside(2, 40, 1.0), beside(3, 41, 1.05), beside(4, 42, 1.0)];
    assert_eq!(taken(&agreeing), [(2, 40), (3, 41), (4, 42)]);
}

#[test]
fn placements_far_from_where_the_way_leads_wait_for_more_of_them() {
    let agreeing = |count: usize| -> Vec<Candidate> {
        let at = |i: usize| beside(2 + i, 40 + i, 1.0);
        (0..count).map(at).collect()
    };
    let surprised = |count, surprise| Judged::surprised(&agreeing(count), surprise);
    let taken = |count, by_loops| surprised(count, [3.0, by_loops]).taken.len();
    // As far as expected: three of them are enough, as before.
    assert_eq!(taken(3, 3.0), 3);
    // Another four standard deviations require e^8 times as much: two more submaps.
    assert_eq!(taken(3, 3.0 + 16.0), 0);
    assert_eq!(taken(5, 3.0 + 16.0), 5);
    // An aisle that looks like another fits it along its whole length: beyond the assumed drift of
    // the path it is another aisle, however much of it fits.
    let aisle = surprised(30, [17.0; 2]);
    assert_eq!(aisle.taken, []);
    let why = Delay::BeyondBelief;
    assert_eq!(aisle.fate(31, 69), ClosureFate::Waiting { why });
    assert!(!surprised(30, [16.0; 2]).taken.is_empty());
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
    // The same corridor again 20 m further on: each new submap fits in either.
    let twice = |new: usize| [beside(new - 38, new, 1.0), beside(new - 34, new, 1.0)];
    let alike: Vec<Candidate> = (40..46).flat_map(twice).collect();
    assert_eq!(taken(&alike), []);
    // What comes after fits only in one of them.
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

#[test]
fn what_is_not_believed_says_why() {
    let waits = |why: Delay| ClosureFate::Waiting { why };
    let alone = Judged::of(&[beside(2, 40, 1.0)]);
    assert_eq!(alone.fate(2, 40), waits(Delay::TooLittleProof));

    let twice = |new: usize| [beside(new - 38, new, 1.0), beside(new - 34, new, 1.0)];
    let mut alike: Vec<Candidate> = (40..46).flat_map(twice).collect();
    let undecided = Judged::of(&alike);
    assert_eq!(undecided.fate(7, 45), waits(Delay::Rivals));
    assert_eq!(undecided.fate(11, 45), waits(Delay::Rivals));

    alike.extend((46..52).map(|new| beside(new - 38, new, 1.0)));
    let decided = Judged::of(&alike);
    assert!(decided.taken.contains(&(7, 45)), "{:?}", decided.taken);
    assert_eq!(decided.fate(11, 45), refused(Refusal::PlacedElsewhere));
}

#[test]
fn rivals_of_a_placement_wait_until_the_graph_follows_it() {
    let rival = beside(2, 42, 9.0);
    let agreeing = [beside(2, 40, 1.0), beside(3, 41, 1.05), beside(4, 42, 1.0)];
    let mut judged = Judged::default();
    (agreeing.iter().chain([&rival])).for_each(|candidate| judged.push(candidate));
    let proved = (judged.waiting).take_proved(42, &judged.ways, 1.0, &mut judged.records);
    assert_eq!(proved.len(), 3);
    let waiting: Vec<f64> = (judged.waiting.iter())
        .map(|c| c.closure.motion.y())
        .collect();
    assert_eq!(waiting, [9.0]);
    judged
        .waiting
        .refuse_others(&[40, 41, 42], &mut judged.records);
    assert_eq!(judged.waiting.iter().count(), 0);
}

#[test]
fn a_record_has_the_figures_that_decided() {
    let agreeing = [beside(2, 40, 1.0), beside(3, 41, 1.05), beside(4, 42, 1.0)];
    let judged = Judged::of(&agreeing);
    for record in judged.records.iter() {
        let proof = record.proof.unwrap();
        // Each proves one submap's worth, and all were searched for in the same window.
        assert!((proof.evidence - 3.0).abs() < 1e-12, "{proof:?}");
        assert!((proof.asked - places_proof(&record.doubt)).abs() < 1e-12);
        assert!(proof.lacks().is_none() && proof.rival == 0.0, "{proof:?}");
        assert!((record.overlap - 0.7).abs() + (record.part - 0.95).abs() < 1e-12);
    }
}

#[test]
fn records_of_what_was_refused_are_few_however_long_the_run() {
    let mut judged = Judged::default();
    for new in 40..2_000 {
        judged.push(&beside(2, new, 100.0));
    }
    let fates: Vec<ClosureFate> = judged.records.iter().map(|r| r.fate).collect();
    let waiting = fates.iter().filter(|f| {
        **f == ClosureFate::Waiting {
            why: Delay::NotJudged,
        }
    });
    assert_eq!(waiting.count(), MOST_WAITING);
    assert!(fates.len() <= 2 * MOST_WAITING, "{}", fates.len());
    assert!(fates.contains(&refused(Refusal::NeverProved)));
    assert!(judged.records.changes() > 2_000);
}
