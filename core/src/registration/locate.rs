//! Where points lie in a map: matched from the believed pose; otherwise searched for; otherwise
//! lost.
//!
//! In: oriented points, a [`Target`], a believed pose, and how many scans in a row were not found.
//! Out: [`Located`].
//!
//! 1. **Match** from the believed pose. If enough of the points lie on the map, they are located.
//! 2. Otherwise odometry is doubted, and the pose is **searched** for by branch and bound in a
//!    window around the believed pose. The window grows with each scan that is not found. The best
//!    pose is matched again, under a weak prior.
//! 3. A searched pose counts only if the points fix it in all directions and it explains enough of
//!    them: a corridor fits itself anywhere, and the more poses are tried, the likelier it is that
//!    one fits by chance.
//! 4. Otherwise the scan is **lost**: the first match is returned for what it is worth.
//!
//! Localisation in a prior map locates scans in this way. Scan matching and loop closure use the
//! same functions to match and search, but weigh the results in their own ways.

use nalgebra::{Matrix3, Point2};

use super::{
    MatchConfig, Prior, Registration, SearchWindow, Target, Verdict, register, search_turned,
};
use crate::geom::Pose2;
use crate::map::LikelihoodPyramid;
use crate::points::OrientedPoint;

/// How points are located.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocateConfig {
    /// How points are matched.
    pub matching: MatchConfig,
    /// Where a smaller part of the points than this lies on the map, the pose is searched for, 0 to
    /// 1. Larger: more searches, and more wrong poses among them.
    pub lost_below: f64,
    /// The window of the first search. Larger finds a robot that slipped farther, takes longer, and
    /// finds more wrong poses.
    pub window: SearchWindow,
    /// The window after `widest_after` scans that were not found.
    pub widest: SearchWindow,
    /// Scans after which the whole of `widest` is searched, at least 1. Larger: the window grows
    /// more slowly.
    pub widest_after: usize,
    /// How poses are searched for.
    pub search: SearchConfig,
    /// The least part of the points that a searched pose puts on the map, in the first window and
    /// in the widest, 0 to 1. Larger: fewer wrong poses, and more scans lost.
    pub found_above: [f64; 2],
    /// A searched pose puts a part of the points on the map that is larger by more than this than
    /// where they were believed to be, 0 to 1. Larger: as above.
    pub min_gain: f64,
}

impl LocateConfig {
    /// For a scan among those of the last metres, where odometry is seldom far off: it is searched
    /// for nearby, over fine cells.
    #[must_use]
    pub fn in_recent_scans() -> Self {
        let window = SearchWindow {
            shift: 0.6,
            turn: 0.2,
        };
        Self {
            matching: MatchConfig::default(),
            lost_below: 0.55,
            window,
            widest: window,
            widest_after: 1,
            search: SearchConfig::IN_SUBMAP,
            found_above: [0.0, 0.0],
            min_gain: 0.1,
        }
    }

    /// For a scan in a prior map. Much may stand there that is not drawn, and the robot may begin
    /// elsewhere than it was told, so the longer nothing is found, the wider the search.
    #[must_use]
    pub fn in_prior_map() -> Self {
        Self {
            matching: MatchConfig::default(),
            lost_below: 0.4,
            window: SearchWindow {
                shift: 0.5,
                turn: 0.2,
            },
            widest: SearchWindow {
                shift: 4.0,
                turn: 1.0,
            },
            widest_after: 20,
            search: SearchConfig::IN_PRIOR_MAP,
            found_above: [0.5, 0.8],
            min_gain: 0.0,
        }
    }
}

/// How poses are searched for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchConfig {
    /// Side of a cell of the likelihood and standard deviation of a surface in it, m. Larger is
    /// quicker and coarser: a pose is found to within a cell, and has to be matched from there.
    pub cell: f64,
    /// A map that spans more than a likelihood holds is laid in cells twice as large, at most so
    /// many times; 0 leaves it unsearched.
    pub coarser: u32,
    /// Levels of the pyramid, 1 to 12: the coarsest bounds 2^(levels - 1) cells at once. More is
    /// quicker in wide windows.
    pub levels: usize,
    /// Of more points than this only some, evenly chosen, are searched with. Larger is slower and
    /// surer.
    pub most_points: usize,
    /// Least mean likelihood of a pose, 0 to 1. Larger: fewer wrong poses, and a search that ends
    /// sooner.
    pub min_score: f64,
    /// What is believed of the pose that was found, while it is matched.
    pub prior: SearchedPrior,
}

/// The prior of a searched pose while it is matched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SearchedPrior {
    /// This part of the previous information, now about the searched pose: odometry was wrong, but
    /// not completely.
    PartOfBefore(f64),
    /// This information of x, y and θ, 1/m² and 1/rad², whatever was believed before.
    Flat(f64),
}

impl SearchConfig {
    /// In the running submap: all points, fine cells.
    pub const IN_SUBMAP: Self = Self {
        cell: 0.05,
        coarser: 0,
        levels: 5,
        most_points: usize::MAX,
        min_score: 0.2,
        prior: SearchedPrior::PartOfBefore(0.01),
    };

    /// In a prior map, which may be that of a whole building.
    pub const IN_PRIOR_MAP: Self = Self {
        cell: 0.1,
        coarser: 5,
        levels: 6,
        most_points: 200,
        min_score: 0.3,
        prior: SearchedPrior::Flat(10.0),
    };

    /// A submap in an earlier one: the widest windows.
    pub const BETWEEN_SUBMAPS: Self = Self {
        cell: 0.1,
        coarser: 0,
        levels: 7,
        most_points: 300,
        min_score: 0.25,
        prior: SearchedPrior::Flat(10.0),
    };

    /// The likelihood of surfaces at these places; `None` if there are none, or they span too large
    /// an area.
    #[must_use]
    pub fn likelihood_of(
        &self,
        places: &(impl Iterator<Item = Point2<f64>> + Clone),
    ) -> Option<LikelihoodPyramid> {
        (0..=self.coarser).find_map(|times| {
            let cell = self.cell * f64::from(1 << times);
            LikelihoodPyramid::new(places.clone(), cell, cell, self.levels)
        })
    }
}

/// Where points lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Located {
    /// At the believed pose, or near it.
    Matched(Registration),
    /// Elsewhere in the window that was searched; the believed pose was wrong.
    Found(Registration),
    /// Too few of them lie on the map, at the believed pose and wherever else was searched: the
    /// match from the believed pose.
    Lost(Registration),
}

impl Located {
    /// The match.
    #[must_use]
    pub fn registration(&self) -> &Registration {
        let (Self::Matched(found) | Self::Found(found) | Self::Lost(found)) = self;
        found
    }
}

/// Locates `points` in `target`; `lost_for` scans before this one were lost.
#[must_use]
pub fn locate<T: Target>(
    points: &[OrientedPoint],
    target: &T,
    prior: &Prior,
    lost_for: usize,
    config: &LocateConfig,
) -> Located {
    let matched = register(points, target, &prior.pose, prior, &config.matching);
    if matched.overlap >= config.lost_below {
        return Located::Matched(matched);
    }
    let part = ((lost_for + 1) as f64 / config.widest_after as f64).min(1.0);
    let between = |first: f64, last: f64| first + part * (last - first);
    let window = SearchWindow {
        shift: between(config.window.shift, config.widest.shift),
        turn: between(config.window.turn, config.widest.turn),
    };
    let [in_first, in_widest] = config.found_above;
    let explains_more = |found: &Registration| {
        found.overlap >= between(in_first, in_widest)
            && found.overlap > matched.overlap + config.min_gain
    };
    let (search, matching, pivot) = (&config.search, &config.matching, Point2::origin());
    search_and_match(points, pivot, target, prior, &window, search, matching)
        .filter(explains_more)
        .map_or(Located::Lost(matched), Located::Found)
}

/// Step 2 by itself: the best pose in `window` around the believed one, matched. `None` if no pose
/// is likely enough, or if the points do not fix it in all directions. Points are turned about
/// `pivot`, in their own frame: a cloud that is turned about its middle needs fewer turns.
#[must_use]
pub fn search_and_match<T: Target>(
    points: &[OrientedPoint],
    pivot: Point2<f64>,
    target: &T,
    believed: &Prior,
    window: &SearchWindow,
    config: &SearchConfig,
    matching: &MatchConfig,
) -> Option<Registration> {
    let any = |_| true;
    search_turned_and_match(
        points, pivot, target, believed, window, any, config, matching,
    )
}

/// The same, only among the turns, rad, that `admits` accepts.
#[must_use]
#[expect(
    clippy::too_many_arguments,
    reason = "those of the search and those of the match"
)]
pub fn search_turned_and_match<T: Target>(
    points: &[OrientedPoint],
    pivot: Point2<f64>,
    target: &T,
    believed: &Prior,
    window: &SearchWindow,
    admits: impl Fn(f64) -> bool,
    config: &SearchConfig,
    matching: &MatchConfig,
) -> Option<Registration> {
    let likelihood = target.likelihood(config)?;
    let every = points.len() / config.most_points + 1;
    let some = points.iter().step_by(every);
    let about_pivot: Vec<_> = some.map(|p| p.position - pivot.coords).collect();
    let points_from_pivot = Pose2::new(pivot.x, pivot.y, 0.0);
    let start = believed.pose * points_from_pivot;
    let least = config.min_score;
    let found = search_turned(&about_pivot, &likelihood, &start, window, least, admits)?;
    let pose = found.pose * points_from_pivot.inverse();
    let information = match config.prior {
        SearchedPrior::PartOfBefore(part) => believed.information * part,
        SearchedPrior::Flat(information) => Matrix3::from_diagonal_element(information),
    };
    let prior = Prior { pose, information };
    let matched = register(points, target, &pose, &prior, matching);
    (matched.verdict == Verdict::Converged).then_some(matched)
}
