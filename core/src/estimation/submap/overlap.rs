//! Two submaps where they lie in the map: whether they agree, and where they would.
//!
//! In: two closed submaps and the pose of one in the other. Out: what one says of the surfaces of
//! the other ([`Said`]), and another pose at which they would agree, if there is one nearby.
//!
//! 1. A surface agrees that lies on one of the other that faces the same way; it stands beside
//!    where that is within reach but not nearer than a wall is thick: a wall that is drawn twice.
//!    It contradicts where the other saw through the place and all around it, and has no surface
//!    near. What the other never saw says nothing.
//! 2. Only surfaces are asked about that were seen again and again, as far as there are such: what
//!    is seen in glass, and people, are not.
//! 3. Where little agrees, the other is matched to it from where it lies, and searched for in a
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

/// Surfaces that are asked about, at most: evenly chosen ones say the same as all.
const MOST_ASKED: usize = 200;
/// How far is searched for a place where two submaps agree: what is farther off contradicts.
const WINDOW: SearchWindow = SearchWindow {
    shift: 1.0,
    turn: 0.15,
};
/// What is believed of the pose beforehand, 1/m² and 1/rad²: next to nothing.
const FLAT: f64 = 0.01;

/// What a submap says of surfaces of another.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::estimation) struct Said {
    pub(in crate::estimation) total: usize,
    pub(in crate::estimation) agree: usize,
    /// Surfaces that stand beside one of the submap, or twice.
    pub(in crate::estimation) beside: usize,
    pub(in crate::estimation) contradict: usize,
    /// Sum of the places of what does not agree, in the submap.
    wrong: Vector2<f64>,
    /// The same of what agrees.
    right: Vector2<f64>,
}

impl Said {
    /// Surfaces of which the submap says something.
    pub(in crate::estimation) fn spoken_of(&self) -> usize {
        self.agree + self.beside + self.contradict
    }

    /// Of those, the part that agrees; 1 where nothing is said.
    pub(in crate::estimation) fn part(&self) -> f64 {
        match self.spoken_of() {
            0 => 1.0,
            said => self.agree as f64 / said as f64,
        }
    }

    /// The middle of what does not agree, in the submap.
    pub(in crate::estimation) fn middle_of_wrong(&self) -> Option<Point2<f64>> {
        let wrong = self.beside + self.contradict;
        (wrong > 0).then(|| Point2::from(self.wrong / wrong as f64))
    }

    /// The middle of what agrees, in the submap.
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

    /// What it says of the surfaces of `other`, which lies at `pose` in it.
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

    /// Other poses of `other`, which lies at `pose`, that its surfaces fix in all directions: the
    /// one that matching leads to and the best within a metre.
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

/// How a surface stands to a submap.
enum Stands {
    Agrees,
    Beside,
    Contradicts,
    Unknown,
}

impl ClosedSubmap {
    /// How often its surfaces were seen that are asked about: the half of them that was seen most,
    /// or more.
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
