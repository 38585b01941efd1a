//! From the hits of a scan to sightings of things that may move.
//!
//! In: hits in the order of their beams, each with what the map knows of its place. Out: groups of
//! neighbours, and a sighting of each group in free space.
//!
//! 1. Neighbouring hits nearer than [`LINK`](crate::points::LINK) belong to one thing: two legs do.
//! 2. A lidar sees only the near side. Across the line of sight the middle of the thing is the
//!    middle of what is seen, which is a beam wider than its outermost hits; along the line of
//!    sight it lies half a width behind the nearest hit, as for a round thing.

use std::f64::consts::PI;

use nalgebra::{Matrix2, Point2, Vector2};

use super::config::TrackingConfig;
use super::free_space::Place;
use super::state::Sighting;
use crate::geom::Length;
use crate::points::{Beam, are_linked};

/// Range of half the depth of a thing, m: a leg, a body.
const HALF_DEPTH: [f64; 2] = [0.08, 0.3];
/// Hits nearer to the sensor than this have no direction, m.
const NEAREST: f64 = 1e-6;
/// Fraction of a sighting's hits that must stand in free space for a track to begin.
const FREE_PART: f64 = 0.6;

/// A hit and what the map knows of its place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit<'a> {
    pub(super) beam: &'a Beam,
    pub(super) place: Place,
}

/// Groups of neighbouring hits (step 1), in a scan that may go all the way round; none is empty.
pub(super) fn clusters<'a>(hits: &[Hit<'a>]) -> Vec<Vec<Hit<'a>>> {
    let is_linked = |a: &Hit, b: &Hit| are_linked(a.beam, b.beam);
    let mut found: Vec<Vec<Hit>> = hits.chunk_by(is_linked).map(<[_]>::to_vec).collect();
    if found.len() > 1
        && let (Some(first), Some(last)) = (hits.first(), hits.last())
        && is_linked(last, first)
        && let Some(end) = found.pop()
    {
        found[0].splice(0..0, end);
    }
    found
}

/// The greatest distance between hits of a cluster, m.
pub(super) fn extent(cluster: &[Hit]) -> f64 {
    let places = cluster.iter().map(|hit| hit.beam.end_in_robot);
    let far = |from: Point2<f64>| {
        let others = cluster
            .iter()
            .map(move |hit| (hit.beam.end_in_robot - from).length());
        others.fold(0.0, f64::max)
    };
    places.map(far).fold(0.0, f64::max)
}

/// The sighting of a cluster that may move (step 2), robot frame; `None` if it is too wide, or has
/// too few hits. `heading_sigma` is the standard deviation of directions, rad; `spacing` the angle
/// between two beams.
pub(super) fn sighting(
    cluster: &[Hit],
    sensor: Point2<f64>,
    spacing: f64,
    heading_sigma: f64,
    config: &TrackingConfig,
) -> Option<Sighting> {
    if cluster.len() < config.min_hits.max(1) || extent(cluster) > config.max_width {
        return None;
    }
    let count = cluster.len() as f64;
    let ends = cluster.iter().map(|hit| hit.beam.end_in_robot - sensor);
    let mean: Vector2<f64> = ends.clone().sum::<Vector2<f64>>() / count;
    let distance = mean.length();
    if distance < NEAREST {
        return None;
    }
    let along = mean / distance;
    let across = Vector2::new(-along.y, along.x);
    let (mut nearest, mut sides) = (f64::INFINITY, [f64::INFINITY, f64::NEG_INFINITY]);
    for end in ends {
        let (ahead, aside) = (along.dot(&end), across.dot(&end));
        nearest = nearest.min(ahead);
        sides = [sides[0].min(aside), sides[1].max(aside)];
    }
    let width = sides[1] - sides[0] + spacing.min(PI / 8.0) * distance;
    let [least, most] = HALF_DEPTH;
    let depth = nearest + (0.5 * width).clamp(least, most);
    let at = sensor + along * depth + across * (0.5 * (sides[0] + sides[1]));
    let free = cluster
        .iter()
        .filter(|hit| hit.place == Place::Free)
        .count();
    // An error of direction moves it sideways.
    let aside = heading_sigma * depth;
    let own = config.position_sigma * config.position_sigma;
    let cov = Matrix2::identity() * own + across * across.transpose() * (aside * aside);
    Some(Sighting {
        at,
        cov,
        age: cluster.iter().map(|hit| hit.beam.age).sum::<f64>() / count,
        is_free: free as f64 >= FREE_PART * count,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::unit_vector;
    use crate::points::fixture::{beam_along, hit};

    fn of(beams: &[Beam]) -> Vec<Hit<'_>> {
        let free = |beam| Hit {
            beam,
            place: Place::Free,
        };
        beams.iter().map(free).collect()
    }

    /// The beams, a degree apart, that hit a disc; `None` past it.
    fn disc(at: Point2<f64>, radius: f64) -> Vec<Beam> {
        let seen = |number: usize| {
            let along = unit_vector((number as f64).to_radians());
            let middle = at.coords.dot(&along);
            let root = radius * radius - (at.coords.norm_squared() - middle * middle);
            (root > 0.0 && middle > 0.0)
                .then(|| beam_along(number, along, middle - root.sqrt(), true))
        };
        (0..360).filter_map(seen).collect()
    }

    #[test]
    fn the_middle_of_a_person_is_found_from_one_side() {
        let config = TrackingConfig::default();
        for distance in [1.0, 2.0, 4.0, 6.0] {
            for turn in [0.3, 1.7, 3.1, 5.0] {
                let at = Point2::from(unit_vector(turn) * distance);
                let beams = disc(at, 0.22);
                let found = clusters(&of(&beams));
                assert_eq!(found.len(), 1);
                let seen = sighting(
                    &found[0],
                    Point2::origin(),
                    1.0_f64.to_radians(),
                    0.0,
                    &config,
                );
                let seen = seen.unwrap();
                let off = (seen.at - at).length();
                assert!(off < 0.05, "{off} m at {distance} m, {turn} rad");
                assert!(seen.is_free);
            }
        }
    }

    #[test]
    fn legs_are_one_thing_and_walls_none() {
        let config = TrackingConfig::default();
        let legs = [
            (0, 2.0, -0.12),
            (1, 2.0, -0.1),
            (2, 2.05, 0.1),
            (3, 2.05, 0.13),
        ];
        let legs = legs.map(|(number, x, y)| hit(number, Point2::new(x, y)));
        let see = |beams: &[Beam]| {
            let found = clusters(&of(beams));
            assert_eq!(found.len(), 1, "{beams:?}");
            sighting(&found[0], Point2::origin(), 0.01, 0.0, &config)
        };
        assert!(see(&legs).is_some());
        let wall: Vec<Beam> = (0..20)
            .map(|n| hit(n, Point2::new(2.0, 0.1 * n as f64 - 1.0)))
            .collect();
        assert_eq!(see(&wall), None);
        assert_eq!(see(&legs[..2]), None, "too few hits");
    }

    #[test]
    fn a_scan_that_goes_round_has_no_end() {
        let angles = [-3.1_f64, 0.0, 3.11, 3.13];
        let at =
            |(number, angle): (usize, &f64)| beam_along(number, unit_vector(*angle), 2.0, true);
        let beams: Vec<Beam> = angles.iter().enumerate().map(at).collect();
        let sizes: Vec<usize> = clusters(&of(&beams)).iter().map(Vec::len).collect();
        assert_eq!(sizes, [3, 1]);
        assert!(clusters(&[]).is_empty());
    }
}
