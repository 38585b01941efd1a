//! Two submaps at their poses in the map: whether they agree, and where they would.
//!
//! In: two closed submaps and the pose of one in the other. Out: what one says about the surfaces
//! of the other ([`Said`]), and another pose at which they would agree, if there is one nearby.
//!
//! 1. A surface agrees if it lies on one of the other submap that faces the same way. It stands
//!    beside that surface if it is within reach but farther away than a wall is thick: a wall that
//!    is drawn twice. It contradicts if the other saw the place and all around it as free, and has
//!    no surface near. Where the other saw nothing, it says nothing.
//! 2. Only surfaces that were seen repeatedly are compared, as far as there are such: reflections
//!    in glass, and people, are not.
//! 3. If little agrees, the other is matched to it from its present pose, and searched for in a
//!    window around that.

use nalgebra::{Matrix3, Point2, Vector2};

use super::ClosedSubmap;
use crate::estimation::agreement::{AGREES_COSINE, AGREES_WITHIN, CONTRADICTS_BEYOND};
use crate::geom::Pose2;
use crate::map::{SEEN_OFTEN, Surfel, SurfelConfig, SurfelMap};
use crate::points::OrientedPoint;
use crate::registration::{
    MatchConfig, Prior, Registration, SearchConfig, SearchWindow, Verdict, register,
    search_and_match,
};

/// The most surfaces that are compared: an even selection says the same as all.
const MOST_ASKED: usize = 200;
/// The window searched for a pose at which two submaps agree: what is farther off contradicts.
const WINDOW: SearchWindow = SearchWindow {
    shift: 1.0,
    turn: 0.15,
};
/// The information of the prior pose, 1/m² and 1/rad²: almost none.
const FLAT: f64 = 0.01;

/// What a submap says about the surfaces of another.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::estimation) struct Said {
    pub(in crate::estimation) total: usize,
    pub(in crate::estimation) agree: usize,
    /// Surfaces that stand beside one of the submap: walls that stand twice.
    pub(in crate::estimation) beside: usize,
    pub(in crate::estimation) contradict: usize,
    /// Sum of the positions of what does not agree, in the submap.
    wrong: Vector2<f64>,
    /// The same of what agrees.
    right: Vector2<f64>,
}

impl Said {
    /// Surfaces about which the submap says something.
    pub(in crate::estimation) fn spoken_of(&self) -> usize {
        self.agree + self.beside + self.contradict
    }

    /// The part of these that agrees; 1 if there are none.
    pub(in crate::estimation) fn part(&self) -> f64 {
        match self.spoken_of() {
            0 => 1.0,
            said => self.agree as f64 / said as f64,
        }
    }

    /// The centre of what does not agree, in the submap.
    pub(in crate::estimation) fn middle_of_wrong(&self) -> Option<Point2<f64>> {
        let wrong = self.beside + self.contradict;
        (wrong > 0).then(|| Point2::from(self.wrong / wrong as f64))
    }

    /// The centre of what agrees, in the submap.
    pub(in crate::estimation) fn middle_of_right(&self) -> Option<Point2<f64>> {
        (self.agree > 0).then(|| Point2::from(self.right / self.agree as f64))
    }
}

/// A closed submap with the index of its surfaces.
pub(in crate::estimation) struct Laid<'a> {
    submap: &'a ClosedSubmap,
    map: SurfelMap,
}

impl<'a> Laid<'a> {
    pub(in crate::estimation) fn new(submap: &'a ClosedSubmap, config: &SurfelConfig) -> Self {
        Self {
            submap,
            map: submap.indexed(config),
        }
    }

    /// What it says about the surfaces of `other`, which lies at `pose` in it.
    pub(in crate::estimation) fn says_of(&self, other: &ClosedSubmap, pose: &Pose2) -> Said {
        let often = other.often();
        let seen = || other.surfels.iter().filter(|s| s.weight >= often);
        let every = seen().count() / MOST_ASKED + 1;
        let mut said = Said::default();
        for surfel in seen().step_by(every) {
            said.total += 1;
            let place = *pose * surfel.position;
            match self.stands(place, &pose.rotate(surfel.normal)) {
                Stands::Agrees => {
                    said.agree += 1;
                    said.right += place.coords;
                }
                Stands::Beside => {
                    said.beside += 1;
                    said.wrong += place.coords;
                }
                Stands::Contradicts => {
                    said.contradict += 1;
                    said.wrong += place.coords;
                }
                Stands::Unknown => {}
            }
        }
        said
    }

    fn stands(&self, place: Point2<f64>, normal: &Vector2<f64>) -> Stands {
        if let Some(near) = self.map.nearest(place) {
            let off = place - near.position;
            if near.normal.dot(normal) > AGREES_COSINE {
                return match near.normal.dot(&off).abs() < AGREES_WITHIN {
                    true => Stands::Agrees,
                    false => Stands::Beside,
                };
            }
            if off.norm_squared() < CONTRADICTS_BEYOND * CONTRADICTS_BEYOND {
                return Stands::Unknown;
            }
        }
        match self.submap.free.contains_around(place) {
            true => Stands::Contradicts,
            false => Stands::Unknown,
        }
    }

    /// Other poses of `other`, which lies at `pose`, that its surfaces constrain in all directions:
    /// the one to which matching leads, and the best within a metre.
    pub(in crate::estimation) fn other_poses(
        &self,
        other: &ClosedSubmap,
        pose: &Pose2,
        matching: &MatchConfig,
    ) -> impl Iterator<Item = Pose2> {
        let points: Vec<OrientedPoint> = other.points();
        let prior = Prior {
            pose: *pose,
            information: Matrix3::from_diagonal_element(FLAT),
        };
        let matched = register(&points, &self.map, pose, &prior, matching);
        let (pivot, search) = (other.centre, SearchConfig::BETWEEN_SUBMAPS);
        let searched = search_and_match(
            &points, pivot, &self.map, &prior, &WINDOW, &search, matching,
        );
        let fixed = |found: &Registration| found.verdict == Verdict::Converged;
        let found = [Some(matched).filter(fixed), searched];
        found.into_iter().flatten().map(|found| found.estimate.pose)
    }
}

/// How a surface relates to a submap.
enum Stands {
    Agrees,
    Beside,
    Contradicts,
    Unknown,
}

impl ClosedSubmap {
    /// The number of sightings from which on surfaces are compared: no more than the median, so at
    /// least half of them are.
    fn often(&self) -> f64 {
        let mut weights: Vec<f64> = self.surfels.iter().map(|s: &Surfel| s.weight).collect();
        let middle = weights.len() / 2;
        if weights.is_empty() {
            return SEEN_OFTEN;
        }
        let (_, median, _) = weights.select_nth_unstable_by(middle, f64::total_cmp);
        median.min(SEEN_OFTEN)
    }
}
