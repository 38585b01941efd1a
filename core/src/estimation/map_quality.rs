//! Whether a map is whole, and where it is torn: how well the stretches of a way that show the same
//! places agree, as they lie in the map.
//!
//! In: the submaps where they lie, when they were seen, and what holds each to the next. Out:
//! [`MapQuality`].
//!
//! 1. All submaps are compared that overlap in the map and share no scan (`pairs`). What one never
//!    saw of the other says nothing.
//! 2. Two of them bear witness to a tear where the same walls stand twice: they would surely agree
//!    at another pose nearby, which also says how far the map is off. Or where each saw through
//!    most of what the other has drawn.
//! 3. A submap and the next share scans, which lie in both. Where these are apart in the map,
//!    either the scans behind were laid wrong or the map is bent: the way bears witness, too. That
//!    is the only one where a long corridor agrees with itself wherever it lies. What the next one
//!    took over is drawn as the one before has it, so it is not asked about anything else then.
//! 4. One witness may be furniture that was moved, a glass door, or a turn that was mended at once.
//!    Several at one place that say the same are a tear (`tears`). Scans that were shifted are one
//!    by themselves: no furniture moves them.
//! 5. Parts of the way that no loop holds to one another are as far off as the way between them may
//!    be: where the robot was lost there, the map is torn as well; else it is only doubtful.
//! 6. Where no scan was matched to another, nothing could contradict: that is no good map either,
//!    and it is said why ([`Unjudgeable`]).
//!
//! 7. Beside the verdict: how far ways were off when loops were closed over them, in units of what
//!    the pose graph said of them ([`MapQuality::loop_ratio`]). Where that is several times more
//!    on the median, its covariances are not to be believed; the map may be good all the same.
//!
//! None of this asks how closures were found, so that it tells also of what nobody thought of. What
//! it does not see: a part that was seen only once, and lies wrong.

mod pairs;
mod tears;
#[cfg(test)]
mod tests;

use nalgebra::Point2;

use self::pairs::{Pair, Pairs, agreement};
use self::tears::{Witness, gather};
use super::loop_error::LoopError;
use super::submap::{ClosedSubmap, Doubt};
use crate::geom::Pose2;
use crate::map::SurfelConfig;
use crate::registration::MatchConfig;
use crate::robot::Stamp;

/// A map that is off by more than this somewhere is torn, m: a robot no longer finds through doors.
const TORN_BEYOND: f64 = 0.3;
/// A turn moves walls by what it moves those that lie so far ahead, m: where a robot looks that
/// goes through a door.
const AHEAD: f64 = 2.0;
/// Doubt, m, that makes parts of a map doubtful which nothing holds together: as far as a wall is
/// searched for that stands twice.
const DOUBTFUL_BEYOND: f64 = 1.0;
/// Of fewer closed loops nothing systematic is said.
const LEAST_LOOPS: usize = 5;
/// Ways that are off by more than so many times what was known of them, on the median, were known
/// worse than was said.
const MOST_RATIO: f64 = 3.0;

/// What is to be thought of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapVerdict {
    /// Wherever a place was seen twice, both agree.
    Good,
    /// Nothing contradicts, but the way to some parts is known badly, and nothing else holds them;
    /// or nothing can be said at all.
    Doubtful,
    /// At some places it contradicts itself, or falls apart.
    Torn,
}

impl MapVerdict {
    /// Its name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Doubtful => "doubtful",
            Self::Torn => "torn",
        }
    }
}

/// Why nothing can be said of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unjudgeable {
    /// No scan showed a surface to which others could be matched.
    NoSurfaces,
    /// There was one scan.
    OneScan,
    /// One scan was drawn, and the last one could not be matched to it.
    Unmatched,
}

impl Unjudgeable {
    /// Its name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::NoSurfaces => "no-surfaces",
            Self::OneScan => "one-scan",
            Self::Unmatched => "unmatched",
        }
    }
}

/// Why a map is torn at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TearKind {
    /// The same walls stand twice, or the same scans.
    Doubled,
    /// Walls stand where the robot saw through at another time.
    Contradicted,
    /// The robot was lost, and no loop holds what came after to what was before.
    Loose,
    /// As `Loose`, but the robot was not lost: the way was only long. This alone tears no map.
    Unproven,
}

impl TearKind {
    /// Its name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Doubled => "doubled",
            Self::Contradicted => "contradicted",
            Self::Loose => "loose",
            Self::Unproven => "unproven",
        }
    }
}

/// A place where a map is torn, or may be.
#[derive(Clone, Debug, PartialEq)]
pub struct Tear {
    /// Why.
    pub kind: TearKind,
    /// Where, map frame, m.
    pub place: Point2<f64>,
    /// How far the two sides are off, m: as measured between walls that stand twice, or one
    /// standard deviation of what is not known; `None` where they are so far off that nothing fits.
    pub off: Option<f64>,
    /// When the one side was seen, from and to.
    pub earlier: [Stamp; 2],
    /// When the other was.
    pub later: [Stamp; 2],
    /// Pairs of submaps that bear witness, those that share scans included.
    pub witnesses: usize,
}

/// A stretch of the way, as long as a submap, and what else was seen of its places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// When it was seen, from and to.
    pub seen: [Stamp; 2],
    /// Of all that the rest of the way says of its walls, the part that agrees; `None` where they
    /// were seen only once.
    pub agreement: Option<f64>,
}

/// What a map is worth.
#[derive(Clone, Debug, PartialEq)]
pub struct MapQuality {
    /// In a word.
    pub verdict: MapVerdict,
    /// Why nothing can be said of it, where that is so; it is doubtful then.
    pub unjudgeable: Option<Unjudgeable>,
    /// Of all that stretches of the way say of each other's walls, the part that agrees; `None`
    /// where no place was seen twice.
    pub agreement: Option<f64>,
    /// The stretches of the way, in the order of time.
    pub stretches: Vec<Stretch>,
    /// The places where it is torn or doubtful, the worst first.
    pub tears: Vec<Tear>,
    /// The loops that were closed, in the order of time; of those of one submap the one whose way
    /// was known worst.
    pub loops: Vec<ClosedLoop>,
}

/// A loop that was closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosedLoop {
    /// When its earlier end was seen, from and to.
    pub earlier: [Stamp; 2],
    /// When its later end was.
    pub later: [Stamp; 2],
    /// How far off the way between them was, and what was known of it.
    pub error: LoopError,
}

impl MapQuality {
    /// How far off ways were when loops were closed over them, in units of what was known of them:
    /// the median. 1 is honest, about; `None` of fewer than five.
    #[must_use]
    pub fn loop_ratio(&self) -> Option<f64> {
        let mut ratios: Vec<f64> = self.loops.iter().map(|closed| closed.error.ratio).collect();
        ratios.sort_by(f64::total_cmp);
        let is_enough = ratios.len() >= LEAST_LOOPS;
        ratios.get(ratios.len() / 2).copied().filter(|_| is_enough)
    }

    /// Whether ways are systematically known worse than the pose graph says.
    #[must_use]
    pub fn is_overconfident(&self) -> bool {
        self.loop_ratio().is_some_and(|ratio| ratio > MOST_RATIO)
    }
}

/// A submap where it lies.
pub(super) struct Placed<'a> {
    pub(super) submap: &'a ClosedSubmap,
    pub(super) map_from_submap: Pose2,
    /// When it was seen, from and to.
    pub(super) seen: [Stamp; 2],
}

/// A submap and the next, which share scans and lie apart in the map.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parted {
    /// The earlier of the two.
    pub(super) earlier: usize,
    /// How far the later lies from where the scans that both hold put it, m.
    pub(super) shift: f64,
    /// The same, rad.
    pub(super) turn: f64,
}

/// Submaps one after the other that no loop holds together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Untied {
    /// The submaps on either side.
    pub(super) between: [usize; 2],
    /// What is not known of the way between them, m: a standard deviation.
    pub(super) doubt: f64,
    /// Whether the robot was lost on it.
    pub(super) is_lost: bool,
}

/// A map that is being judged, submap by submap, as it was when that began.
#[derive(Clone, Debug)]
pub struct MapJudgement {
    /// Where each submap lay, and when it was seen.
    pub(super) places: Vec<(Pose2, [Stamp; 2])>,
    pub(super) untied: Vec<Untied>,
    parted: Vec<Parted>,
    loops: Vec<ClosedLoop>,
    unjudgeable: Option<Unjudgeable>,
    pairs: Pairs,
}

impl MapJudgement {
    /// Of submaps in the order in which they were made; each shares scans with the next.
    pub(super) fn new(
        places: Vec<(Pose2, [Stamp; 2])>,
        untied: Vec<Untied>,
        parted: Vec<Parted>,
        loops: Vec<ClosedLoop>,
        unjudgeable: Option<Unjudgeable>,
    ) -> Self {
        Self {
            places,
            untied,
            parted,
            loops,
            unjudgeable,
            pairs: Pairs::default(),
        }
    }

    /// Asks the next submap; `false` when all have been.
    pub(super) fn step(
        &mut self,
        placed: &[Placed<'_>],
        surfels: &SurfelConfig,
        matching: &MatchConfig,
    ) -> bool {
        self.pairs.step(placed, surfels, matching)
    }

    /// The part that is done, 0 to 1.
    #[must_use]
    pub fn progress(&self) -> f64 {
        self.pairs.done as f64 / self.places.len().max(1) as f64
    }

    /// What the submaps asked so far make of the map.
    pub(super) fn quality(&self, placed: &[Placed<'_>]) -> MapQuality {
        let quality = MapQuality::of(&self.pairs.found, placed, &self.untied, &self.parted);
        MapQuality {
            verdict: match (quality.verdict, self.unjudgeable) {
                (MapVerdict::Good, Some(_)) => MapVerdict::Doubtful,
                (verdict, _) => verdict,
            },
            unjudgeable: self.unjudgeable,
            loops: self.loops.clone(),
            ..quality
        }
    }
}

impl MapQuality {
    fn of(pairs: &[Pair], placed: &[Placed<'_>], untied: &[Untied], parted: &[Parted]) -> Self {
        let of_one = |index: usize| {
            pairs
                .iter()
                .filter(move |pair| pair.submaps.contains(&index))
        };
        let agreements: Vec<Option<f64>> = (0..placed.len())
            .map(|index| agreement(of_one(index)))
            .collect();
        // What a submap took over is drawn as the one before has it. Where that lies elsewhere, the
        // submap shows what it took over in the wrong place, and says nothing of the map.
        let is_misled = |index: &usize| {
            let by = |parted: &Parted| parted.earlier + 1 == *index && parted.off() > TORN_BEYOND;
            parted.iter().any(by)
        };
        let of_pairs = pairs
            .iter()
            .filter(|pair| !pair.submaps.iter().any(is_misled))
            .filter_map(|pair| pair.witness(placed, &agreements));
        let of_ways = parted.iter().filter_map(|parted| parted.witness(placed));
        let mut tears = gather(of_ways.chain(of_pairs), placed);
        tears.extend(untied.iter().filter_map(|untied| untied.tear(placed)));
        tears.sort_by(|a, b| severity(b).total_cmp(&severity(a)));
        let is_torn = |tear: &Tear| tear.kind != TearKind::Unproven;
        let verdict = match (tears.iter().any(is_torn), tears.is_empty()) {
            (true, _) => MapVerdict::Torn,
            (false, false) => MapVerdict::Doubtful,
            (false, true) => MapVerdict::Good,
        };
        Self {
            verdict,
            unjudgeable: None,
            agreement: agreement(pairs.iter()),
            stretches: (placed.iter().zip(agreements))
                .map(|(placed, agreement)| Stretch {
                    seen: placed.seen,
                    agreement,
                })
                .collect(),
            tears,
            loops: vec![],
        }
    }
}

/// What is so far off that nothing fits comes first, what is only unproven last.
fn severity(tear: &Tear) -> f64 {
    let off = tear.off.unwrap_or(f64::MAX);
    match tear.kind {
        TearKind::Unproven => -1.0 / off.max(1e-9),
        _ => off,
    }
}

/// How far walls may be off that lie ahead of a place in doubt, m: a standard deviation.
pub(super) fn doubt_ahead(doubt: &Doubt) -> f64 {
    libm::hypot(doubt.shift, AHEAD * doubt.turn)
}

impl Parted {
    /// How far walls are off that both show, m.
    fn off(&self) -> f64 {
        self.shift + AHEAD * self.turn
    }

    fn witness(&self, placed: &[Placed<'_>]) -> Option<Witness> {
        if self.off() <= TORN_BEYOND {
            return None;
        }
        let submaps = [self.earlier, self.earlier + 1];
        let [earlier, later] = submaps.map(|index| placed.get(index));
        let [earlier, later] = [earlier?, later?].map(|placed| placed.map_from_submap.position());
        Some(Witness {
            submaps,
            place: nalgebra::center(&earlier, &later),
            off: Some(self.off()),
            direction: None,
            is_proof: self.shift > TORN_BEYOND,
        })
    }
}

impl Untied {
    fn tear(&self, placed: &[Placed<'_>]) -> Option<Tear> {
        let least = match self.is_lost {
            true => TORN_BEYOND,
            false => DOUBTFUL_BEYOND,
        };
        if self.doubt < least {
            return None;
        }
        let [before, after] = self.between.map(|index| placed.get(index));
        let (before, after) = (before?, after?);
        Some(Tear {
            kind: match self.is_lost {
                true => TearKind::Loose,
                false => TearKind::Unproven,
            },
            place: after.map_from_submap.position(),
            off: Some(self.doubt),
            earlier: before.seen,
            later: after.seen,
            witnesses: 0,
        })
    }
}
