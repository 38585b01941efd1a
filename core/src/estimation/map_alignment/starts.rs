//! Where a loaded map may lie: places where walls lie on walls, and the one given by landmarks.

use nalgebra::{Matrix2, Point2, Vector2};

use crate::association::{PointMatchConfig, PointMatching, match_points};
use crate::estimation::measures::align;
use crate::features::{PointFeature, PointKind};
use crate::geom::{Pose2, PoseEstimate};
use crate::points::thinned;
use crate::registration::{ModesConfig, SearchConfig, modes};

/// The most places of the search from which matching starts.
const MOST_STARTS: usize = 16;
/// The most points used in the search.
const MOST_SEARCHED: usize = 250;
/// Standard deviation of a landmark in its map, m: maps bend.
const LANDMARK_SIGMA: f64 = 0.08;
/// The most landmarks of each map that are compared: the work grows with the fourth power.
const MOST_LANDMARKS: usize = 60;

/// Places of the loaded walls, the likeliest first.
pub(super) fn by_walls(loaded: &[Point2<f64>], drawn: &[Point2<f64>]) -> Vec<Pose2> {
    let is_smaller = loaded.len() <= drawn.len();
    let (small, large) = match is_smaller {
        true => (loaded, drawn),
        false => (drawn, loaded),
    };
    let some = thinned(small, MOST_SEARCHED, 0);
    // Rotating about its centre needs fewer rotations.
    let sum: Vector2<f64> = some.iter().map(|p| p.coords).sum();
    let middle = sum / some.len().max(1) as f64;
    let about: Vec<_> = some.iter().map(|p| p - middle).collect();
    let places = large.iter().copied();
    let Some(map) = SearchConfig::IN_PRIOR_MAP.likelihood_of(&places) else {
        return vec![];
    };
    let config = ModesConfig {
        most: MOST_STARTS,
        ..ModesConfig::default()
    };
    let found = modes(&about, &map, &config).found;
    let from_middle = Pose2::new(-middle.x, -middle.y, 0.0);
    let large_from_small = found.iter().map(|mode| mode.pose * from_middle);
    large_from_small
        .map(|pose| if is_smaller { pose } else { pose.inverse() })
        .collect()
}

/// Where landmarks alone place the loaded map.
pub(super) fn by_landmarks(loaded: &[Point2<f64>], drawn: &[Point2<f64>]) -> Option<Pose2> {
    let config = PointMatchConfig {
        method: PointMatching::Relations,
        ..PointMatchConfig::default()
    };
    let [before, now] = [loaded, drawn].map(features);
    // Relations need no motion.
    let anywhere = PoseEstimate::exact(Pose2::identity());
    let pairs = match_points(&before, &now, &anywhere, &config);
    let place = |of: &[PointFeature], at: usize| of.get(at).map(|point| point.position);
    let (target, source): (Vec<_>, Vec<_>) = pairs
        .iter()
        .filter_map(|pair| Some((place(&now, pair.now)?, place(&before, pair.before)?)))
        .unzip();
    align(&target, &source)
}

/// Files give positions of landmarks, but not their uncertainty.
fn features(landmarks: &[Point2<f64>]) -> Vec<PointFeature> {
    let feature = |position: &Point2<f64>| PointFeature {
        position: *position,
        cov: Matrix2::identity() * LANDMARK_SIGMA * LANDMARK_SIGMA,
        kind: PointKind::Corner,
        confidence: 1.0,
        beams: [0, 0],
    };
    let near = landmarks.iter().filter(|at| at.coords.amax() < 1e6);
    near.take(MOST_LANDMARKS).map(feature).collect()
}

/// How many landmarks of one map coincide with one of the other, each counted once.
pub(super) fn shared(loaded: &[Point2<f64>], drawn: &[Point2<f64>], pose: &Pose2) -> usize {
    let [before, now] = [loaded, drawn].map(features);
    let config = PointMatchConfig::default();
    match_points(&before, &now, &PoseEstimate::exact(*pose), &config).len()
}
