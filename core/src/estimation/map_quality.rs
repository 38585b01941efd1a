//! Whether a map is whole, and where it is torn: how well those stretches of the trajectory that
//! show the same places agree, as they lie in the map.
//!
//! In: the submaps where they lie, when they were seen, and what joins each to the next. Out:
//! [`MapQuality`].
//!
//! 1. All submaps that overlap in the map and share no scan are compared (`pairs`). Where one saw
//!    nothing, it says nothing about the other.
//! 2. Two of them witness a tear if the same walls stand twice: they would surely agree at another
//!    pose nearby, which also tells how far the map is off. Or if each saw as free most of what the
//!    other has drawn.
//! 3. A submap and the next share scans, which lie in both. If these are apart in the map, either
//!    the later scans were placed wrongly or the map is bent: the trajectory is a witness, too. It
//!    is the only one where a long corridor agrees with itself at any position. What the next
//!    submap took over is drawn as the previous one has it, so that submap is then no witness of
//!    anything else.
//! 4. A single witness may be furniture that was moved, a glass door, or a rotation that was
//!    corrected at once. Several at one place that say the same are a tear (`tears`). Scans that
//!    were shifted are a tear by themselves: no furniture moves them.
//! 5. Parts of the trajectory that no loop ties to one another are as far off as the path between
//!    them may be: if the robot was lost there, the map is torn as well; otherwise it is only
//!    doubtful.
//! 6. If no scan was matched to another, nothing could contradict: such a map is not good either,
//!    and the reason is reported ([`Unjudgeable`]).
//!
//! 7. Beside the verdict: how far paths were off when loops were closed over them, relative to the
//!    covariance by the pose graph ([`MapQuality::loop_ratio`]). If the median is several times too
//!    large, its covariances are not credible; the map may be good all the same.
//!
//! None of this asks how closures were found, so it also detects errors that nobody thought of.
//! What it does not detect: a part that was seen only once, and lies wrong.

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

/// A map that is off by more than this somewhere is torn, m: a robot no longer fits through doors.
const TORN_BEYOND: f64 = 0.3;
/// A heading error counts as the shift of walls at this distance ahead, m: where a robot looks when
/// it drives through a door.
const AHEAD: f64 = 2.0;
/// Uncertainty, m, above which parts of a map that nothing ties together are doubtful: the distance
/// up to which a wall that stands twice is searched for.
const DOUBTFUL_BEYOND: f64 = 1.0;
/// With fewer closed loops than this, nothing systematic is claimed.
const LEAST_LOOPS: usize = 5;
/// If paths are off, on the median, by more than this many times their claimed uncertainty, that
/// uncertainty was too small.
const MOST_RATIO: f64 = 3.0;

/// The verdict on a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapVerdict {
    /// Wherever a place was seen twice, both agree.
    Good,
    /// Nothing contradicts, but the path to some parts is poorly known and nothing else ties them
    /// down; or the map cannot be judged at all.
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

/// Why a map cannot be judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unjudgeable {
    /// No scan showed a surface to which others could be matched.
    NoSurfaces,
    /// There was only one scan.
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
    /// Walls stand where the robot saw free space at another time.
    Contradicted,
    /// The robot was lost, and no loop ties what came after to what was before.
    Loose,
    /// Like `Loose`, but the robot was not lost: the path was only long. This alone tears no map.
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

/// A place where a map is torn, or may be torn.
#[derive(Clone, Debug, PartialEq)]
pub struct Tear {
    /// Why.
    pub kind: TearKind,
    /// Where, map frame, m.
    pub place: Point2<f64>,
    /// How far the two sides are off, m: measured between walls that stand twice, or one standard
    /// deviation of the uncertainty; `None` if they are so far off that nothing fits.
    pub off: Option<f64>,
    /// When the earlier side was seen, from and to.
    pub earlier: [Stamp; 2],
    /// When the later side was seen, from and to.
    pub later: [Stamp; 2],
    /// Number of pairs of submaps that witness it, including those that share scans.
    pub witnesses: usize,
}

/// A stretch of the trajectory, as long as a submap, and how well the rest agrees with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// When it was seen, from and to.
    pub seen: [Stamp; 2],
    /// Of all that the rest of the trajectory says about its walls, the part that agrees; `None` if
    /// they were seen only once.
    pub agreement: Option<f64>,
}

/// The quality of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct MapQuality {
    /// The verdict, in a word.
    pub verdict: MapVerdict,
    /// Why it cannot be judged, if so; the verdict is then doubtful.
    pub unjudgeable: Option<Unjudgeable>,
    /// Of all that stretches of the trajectory say about each other's walls, the part that agrees;
    /// `None` if no place was seen twice.
    pub agreement: Option<f64>,
    /// The stretches of the trajectory, in the order of time.
    pub stretches: Vec<Stretch>,
    /// The places where it is torn or doubtful, the worst first.
    pub tears: Vec<Tear>,
    /// The closed loops in the order of time; for each submap only the one whose path was least
    /// certain.
    pub loops: Vec<ClosedLoop>,
}

/// A loop that was closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosedLoop {
    /// When its earlier end was seen, from and to.
    pub earlier: [Stamp; 2],
    /// When its later end was seen, from and to.
    pub later: [Stamp; 2],
    /// How far off the path between them was, and how well it was known.
    pub error: LoopError,
}

impl MapQuality {
    /// The median of how far off paths were when loops were closed over them, relative to their
    /// claimed uncertainty. About 1 is honest; `None` if there are fewer than five.
    #[must_use]
    pub fn loop_ratio(&self) -> Option<f64> {
        let mut ratios: Vec<f64> = self.loops.iter().map(|closed| closed.error.ratio).collect();
        ratios.sort_by(f64::total_cmp);
        let is_enough = ratios.len() >= LEAST_LOOPS;
        ratios.get(ratios.len() / 2).copied().filter(|_| is_enough)
    }

    /// Whether paths are systematically less certain than the pose graph claims.
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

/// A submap and the next one, which share scans and yet lie apart in the map.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parted {
    /// The earlier of the two.
    pub(super) earlier: usize,
    /// How far the later one lies from where the shared scans put it, m.
    pub(super) shift: f64,
    /// The same, rad.
    pub(super) turn: f64,
}

/// Consecutive submaps that no loop ties together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Untied {
    /// The submaps on either side.
    pub(super) between: [usize; 2],
    /// The uncertainty of the path between them, m: a standard deviation.
    pub(super) doubt: f64,
    /// Whether the robot was lost on that path.
    pub(super) is_lost: bool,
}

/// A judgement in progress, submap by submap, of a map as it was at the start.
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
    /// For submaps in the order in which they were made; each shares scans with the next.
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

    /// Examines the next submap; `false` when all have been examined.
    pub(super) fn step(
        &mut self,
        placed: &[Placed<'_>],
        surfels: &SurfelConfig,
        matching: &MatchConfig,
    ) -> bool {
        self.pairs.step(placed, surfels, matching)
    }

    /// The completed part, 0 to 1.
    #[must_use]
    pub fn progress(&self) -> f64 {
        self.pairs.done as f64 / self.places.len().max(1) as f64
    }

    /// The quality of the map by the submaps examined so far.
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
        // What a submap took over is drawn as the previous one has it. If that lies elsewhere, the
        // submap shows what it took over in the wrong place, and says nothing about the map.
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

/// Tears so far off that nothing fits come first, those only unproven last.
fn severity(tear: &Tear) -> f64 {
    let off = tear.off.unwrap_or(f64::MAX);
    match tear.kind {
        TearKind::Unproven => -1.0 / off.max(1e-9),
        _ => off,
    }
}

/// How far walls ahead of a place with this uncertainty may be off, m: a standard deviation.
pub(super) fn doubt_ahead(doubt: &Doubt) -> f64 {
    libm::hypot(doubt.shift, AHEAD * doubt.turn)
}

impl Parted {
    /// How far walls that both show are off, m.
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
