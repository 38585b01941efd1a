//! What a scan adds to the vector map: the line filter's features as pieces of wall, and the paths
//! of the beams.

use nalgebra::{Matrix2, Point2};

use super::View;
use crate::geom::{Line, Pose2, PoseEstimate, Segment, sin_cos};
use crate::map::{Sighting, VectorMap};
use crate::points::Points;

/// One in this many beams is checked for passing through walls: neighbours give the same answer.
const EVERY: usize = 3;

/// Hands the last scan of a method with a line map to the vector map. A feature that was matched to
/// a wall is placed where the filter now estimates that wall, which is more accurate; the others
/// are placed by the pose.
pub(super) fn observe(map: &mut VectorMap, view: &View, estimate: &PoseEstimate, points: &Points) {
    if view.update.is_none() {
        return;
    }
    let map_from_robot = estimate.pose;
    let sensor = map_from_robot * points.sensor_in_robot;
    let sightings: Vec<Sighting> = (view.features.iter())
        .enumerate()
        .map(|(number, feature)| {
            let matched = view.matches().iter().find(|m| m.feature == number);
            let known = matched.and_then(|m| view.landmarks.iter().find(|l| l.id == m.landmark));
            let ends = feature.ends.map(|end| map_from_robot * end);
            let (seen, [sigma_direction, sigma_across]) = match known {
                Some(wall) => {
                    let ends = ends.map(|end| wall.line.project(end));
                    let sigmas = sigmas(&wall.line, &wall.cov, middle(ends));
                    (ends, sigmas)
                }
                None => {
                    let own = sigmas(&feature.line, &feature.cov, middle(feature.ends));
                    (ends, with_pose(own, &feature.line, estimate))
                }
            };
            Sighting {
                seen: Segment::new(seen[0], seen[1]),
                sigma_direction,
                sigma_across,
                from: sensor,
            }
        })
        .collect();
    map.observe(&sightings, &beams(points, &map_from_robot));
}

fn beams(points: &Points, map_from_robot: &Pose2) -> Vec<[Point2<f64>; 2]> {
    let beams = points.beams.iter().step_by(EVERY);
    let ends = beams.map(|beam| [beam.origin_in_robot, beam.end_in_robot]);
    ends.map(|ends| ends.map(|end| *map_from_robot * end))
        .collect()
}

fn middle([a, b]: [Point2<f64>; 2]) -> Point2<f64> {
    a + (b - a) * 0.5
}

/// Standard deviations of a line's direction, and of its offset at a point on it.
fn sigmas(line: &Line, cov: &Matrix2<f64>, at: Point2<f64>) -> [f64; 2] {
    let (sin, cos) = sin_cos(line.alpha());
    // The distance is x cos α + y sin α - r.
    let by_alpha = -at.x * sin + at.y * cos;
    let across = by_alpha * by_alpha * cov[(0, 0)] - 2.0 * by_alpha * cov[(0, 1)] + cov[(1, 1)];
    [cov[(0, 0)], across].map(|variance| variance.max(0.0).sqrt())
}

/// Adds the uncertainty of the pose: of its heading, and of its position across the line.
fn with_pose([direction, across]: [f64; 2], line: &Line, estimate: &PoseEstimate) -> [f64; 2] {
    let (sin, cos) = sin_cos(line.alpha() + estimate.pose.heading());
    let cov = &estimate.cov;
    let place = cos * cos * cov[(0, 0)] + 2.0 * sin * cos * cov[(0, 1)] + sin * sin * cov[(1, 1)];
    let add = |sigma: f64, variance: f64| (sigma * sigma + variance.max(0.0)).sqrt();
    [add(direction, cov[(2, 2)]), add(across, place)]
}
