//! What submaps that overlap in the map say about each other, and which of them witness a tear.

use nalgebra::{Point2, Vector2};

use super::{Placed, TORN_BEYOND, Witness};
use crate::estimation::submap::{ClosedSubmap, Laid, REACH, Said};
use crate::geom::{Length, Pose2};
use crate::map::SurfelConfig;
use crate::registration::MatchConfig;

/// Fewer compared surfaces than these, or than this part of all, say nothing about the rest.
const LEAST_SPOKEN_OF: usize = 20;
const SPOKEN_OF: f64 = 0.2;
/// If less than this part of all that is said about a stretch agrees, the stretch does not lie
/// where it belongs.
const LEAST_AGREEMENT: f64 = 0.25;
/// If less than this part agrees, walls may stand twice; they surely do if at the other pose this
/// part agrees, ...
const SUSPECT_PART: f64 = 0.8;
const SURE_PART: f64 = 0.85;
/// ... of at least this many surfaces, and at least this part of all, ...
const LEAST_AGREEING: usize = 30;
const AGREEING: f64 = 0.25;
/// ... and this many times as many as before. Both submaps have to say so, ...
const GAIN: f64 = 1.5;
/// ... unless it is this part of all surfaces of one: if a submap is itself bent, its other half
/// lies right.
const AGREEING_ALONE: f64 = 0.5;

/// Two submaps that overlap in the map, the older first.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    pub(super) submaps: [usize; 2],
    /// What each says about the other.
    pub(super) said: [Said; 2],
    doubled: Option<Doubled>,
}

/// Walls that stand twice, map frame.
#[derive(Clone, Copy, Debug)]
struct Doubled {
    place: Point2<f64>,
    /// From one of their places to the other, m.
    off: Vector2<f64>,
}

/// All pairs that overlap and share no scan, found submap by submap.
#[derive(Clone, Debug, Default)]
pub(super) struct Pairs {
    pub(super) found: Vec<Pair>,
    /// For each submap, the pairs of which it is the later. Only one submap is indexed at a time,
    /// because this takes memory: first the earlier of a pair is asked, then the later when its
    /// turn comes.
    of_later: Vec<Vec<usize>>,
    /// Number of submaps that have been examined.
    pub(super) done: usize,
}

impl Pairs {
    /// Examines the next submap; `false` when all have been examined.
    pub(super) fn step(
        &mut self,
        placed: &[Placed<'_>],
        surfels: &SurfelConfig,
        matching: &MatchConfig,
    ) -> bool {
        let index = self.done;
        let Some(this) = placed.get(index) else {
            return false;
        };
        self.done += 1;
        self.of_later.resize(placed.len(), vec![]);
        let laid = Laid::new(this.submap, surfels);
        let with = |other: usize| Together {
            laid: &laid,
            this,
            other: &placed[other],
            surfels,
        };
        for &pair in &self.of_later[index] {
            let pair = &mut self.found[pair];
            let together = with(pair.submaps[0]);
            pair.said[1] = together.said();
            if pair.doubled.is_none() {
                pair.doubled = together.doubled(&pair.said[1], matching);
            }
        }
        for (other, of_other) in self.of_later.iter_mut().enumerate().skip(index + 2) {
            let together = with(other);
            if !together.is_near() {
                continue;
            }
            let said = together.said();
            if said.spoken_of() == 0 {
                continue;
            }
            of_other.push(self.found.len());
            self.found.push(Pair {
                submaps: [index, other],
                said: [said, Said::default()],
                doubled: together.doubled(&said, matching),
            });
        }
        self.done < placed.len()
    }
}

impl Pair {
    /// The tear that it witnesses, if any. `agreements` are those of the stretches of the
    /// trajectory.
    pub(super) fn witness(
        &self,
        placed: &[Placed<'_>],
        agreements: &[Option<f64>],
    ) -> Option<Witness> {
        let submaps = self.submaps;
        if let Some(Doubled { place, off }) = self.doubled {
            return Some(Witness {
                submaps,
                place,
                off: Some(off.length()),
                direction: Some(off),
                is_proof: false,
            });
        }
        let contradicts = |said: &Said| speaks(said) && 2 * said.contradict > said.spoken_of();
        let is_alone =
            |&index: &usize| agreements[index].is_some_and(|part| part < LEAST_AGREEMENT);
        if !self.said.iter().all(contradicts) || !submaps.iter().any(is_alone) {
            return None;
        }
        let place = self.said[0].middle_of_wrong()?;
        let map_from_submap = placed.get(submaps[0])?.map_from_submap;
        Some(Witness {
            submaps,
            place: map_from_submap * place,
            off: None,
            direction: None,
            is_proof: false,
        })
    }
}

/// The part of all that these pairs say that agrees; `None` if they say too little.
pub(super) fn agreement<'a>(pairs: impl Iterator<Item = &'a Pair>) -> Option<f64> {
    let said = pairs.flat_map(|pair| pair.said).filter(speaks);
    let (agree, all) = said.fold((0, 0), |(agree, all), said| {
        (agree + said.agree, all + said.spoken_of())
    });
    (all > 0).then(|| agree as f64 / all as f64)
}

/// Whether enough is said to be representative.
fn speaks(said: &Said) -> bool {
    let least = (SPOKEN_OF * said.total as f64).max(LEAST_SPOKEN_OF as f64);
    said.spoken_of() as f64 >= least
}

/// An indexed submap, and another.
struct Together<'a> {
    laid: &'a Laid<'a>,
    this: &'a Placed<'a>,
    other: &'a Placed<'a>,
    surfels: &'a SurfelConfig,
}

impl Together<'_> {
    fn this_from_other(&self) -> Pose2 {
        let map_from_this = &self.this.map_from_submap;
        map_from_this.delta_to(&self.other.map_from_submap)
    }

    fn is_near(&self) -> bool {
        let (this, other): (&ClosedSubmap, &ClosedSubmap) = (self.this.submap, self.other.submap);
        let apart = self.this_from_other() * other.centre - this.centre;
        apart.length() <= REACH * (this.radius + other.radius)
    }

    fn said(&self) -> Said {
        let pose = self.this_from_other();
        self.laid.says_of(self.other.submap, &pose)
    }

    /// Where walls stand twice, map frame, and how far apart, m; `said` is what is said about the
    /// other at its present pose.
    fn doubled(&self, said: &Said, matching: &MatchConfig) -> Option<Doubled> {
        let is_suspect = said.part() < SUSPECT_PART && said.spoken_of() >= LEAST_SPOKEN_OF;
        if !is_suspect {
            return None;
        }
        let (this, other, pose) = (self.this.submap, self.other.submap, self.this_from_other());
        let mut back: Option<(Laid<'_>, Said)> = None;
        let candidates = self.laid.other_poses(other, &pose, matching);
        let found = candidates.filter_map(|found| {
            let there = self.laid.says_of(other, &found);
            let place = there.middle_of_right()?;
            let off = place - pose * found.inverse() * place;
            if off.length() <= TORN_BEYOND || !is_better(&there, said) {
                return None;
            }
            let map_from_this = &self.this.map_from_submap;
            let doubled = Doubled {
                place: *map_from_this * place,
                off: map_from_this.rotate(off),
            };
            if there.agree as f64 >= AGREEING_ALONE * there.total as f64 {
                return Some((there.agree, doubled));
            }
            let (other_laid, said_back) = back.get_or_insert_with(|| {
                let laid = Laid::new(other, self.surfels);
                let said = laid.says_of(this, &pose.inverse());
                (laid, said)
            });
            let there_back = other_laid.says_of(this, &found.inverse());
            is_better(&there_back, said_back).then_some((there.agree, doubled))
        });
        let best = found.max_by_key(|(agree, _)| *agree);
        best.map(|(_, doubled)| doubled)
    }
}

/// Whether a submap surely agrees with another if that lies `there`, and far better than at its
/// present pose.
fn is_better(there: &Said, here: &Said) -> bool {
    let agree = there.agree as f64;
    there.part() >= SURE_PART
        && there.agree >= LEAST_AGREEING
        && agree >= AGREEING * there.total as f64
        && agree >= GAIN * here.agree as f64
}
