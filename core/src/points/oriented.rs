//! In: [`Points`]. Out: the hits thinned to an even spacing, each with the direction of the surface
//! it lies on.
//!
//! 1. Hits are taken in the order of the beams; a neighbour belongs to the same surface while the
//!    step to it is not much longer than the spacing of the beams at this range.
//! 2. A line is fitted to the neighbours within reach (total least squares: the eigenvectors of
//!    their scatter).
//! 3. Points whose neighbours do not form a line are dropped: a meaningless surface direction would
//!    pull a match anywhere.
//! 4. A point is moved onto its line, away from where its own noise put it.
//! 5. Points nearer than [`SPACING`] to the last one kept are dropped: otherwise close walls, seen
//!    by many beams, would outvote far ones. The distance along the surface is counted in beams. If
//!    it were measured from point to point, noise would select: of a wall ahead the points that
//!    came out too near, of the same wall behind those too far, and a robot that passes it would
//!    turn by 0.0008 rad per metre.
//!
//! A single scan of few beams has no neighbours on one surface. Several of them gathered along the
//! way have ([`oriented_cloud`]), but in no order: there, neighbours are points that lie near.
//!
//! Why surface directions: point-to-line matching converges in a third of the iterations of
//! point-to-point matching, and lets the point slide along a wall, which is a direction that no
//! scan can measure (Censi 2008, "An ICP variant using a point-to-line metric").

use nalgebra::{Point2, Vector2};

use super::scatter::Scatter;
use super::{Beam, Points};
use crate::geom::Length;

/// A point on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientedPoint {
    /// Where it lies, m.
    pub position: Point2<f64>,
    /// Unit normal of the surface, towards the side from which it was seen.
    pub normal: Vector2<f64>,
}

/// Hits farther than this are dropped, m; far ones are sparse and meet their wall at a flat angle.
const MAX_RANGE: f64 = 40.0;
/// Least distance between two kept points, m; larger is faster and less precise.
const SPACING: f64 = 0.04;
/// Half of the piece of surface that gives a direction, m; larger smooths noise but rounds corners.
const REACH: f64 = 0.12;
/// For drawing, the reach is at least this many standard deviations of the range: a set of points
/// as wide as it is long has no direction.
const REACH_SIGMAS: f64 = 8.0;
/// The reach among gathered scans, m, ...
const CLOUD_REACH: f64 = 0.3;
/// ... and the least number of points in it.
const CLOUD_NEIGHBOURS: f64 = 4.0;
/// Neighbouring beams farther apart than this say nothing about what is in between, rad.
pub(crate) const WIDEST_GAP: f64 = 0.1;
/// Assumed spacing of beams if there is only one, rad: about the 1° of most lidars; without
/// neighbours it cannot mislead.
const LONE_SPACING: f64 = 0.02;
/// Spacings that differ only by rounding count as equal.
const ALMOST: f64 = 0.999;
/// For the spacing of beams on a surface, its direction is taken from this many hits before to as
/// many after, ...
const FACING_NEIGHBOURS: usize = 3;
/// ... as long as they are no farther apart than this, m; ...
const FACING_REACH: f64 = 1.0;
/// ... and a smaller cosine than this is not believed.
const GRAZING: f64 = 0.1;
/// Most neighbours on each side.
const MAX_NEIGHBOURS: usize = 8;

/// Finds the surfaces of a scan; positions and normals are in the robot frame.
#[must_use]
pub fn oriented_points(points: &Points) -> Vec<OrientedPoint> {
    let beams = oriented_beams(points);
    beams.into_iter().map(|(_, surface)| surface).collect()
}

/// The surfaces of a scan, each with the index of its beam in `points.beams`.
#[must_use]
pub fn oriented_beams(points: &Points) -> Vec<(usize, OrientedPoint)> {
    let hits = near_hits(points);
    let angle = points.beam_spacing().unwrap_or(LONE_SPACING);
    let mut kept: Vec<(usize, OrientedPoint)> = Vec::with_capacity(hits.len());
    for (at, (place, beam)) in hits.iter().enumerate() {
        let beam_spacing = beam.range * angle;
        let is_too_near = |(last, _): &(usize, OrientedPoint)| {
            // Beams that lost their echo count as well.
            (place - last) as f64 * beam_spacing < ALMOST * SPACING * facing(&hits, at)
        };
        if kept.last().is_some_and(is_too_near) {
            continue;
        }
        kept.extend(
            line_at(&hits, at, beam_spacing, REACH).map(|(normal, to_line)| {
                let mut surface = seen(beam, normal);
                surface.position += to_line;
                (*place, surface)
            }),
        );
    }
    kept
}

/// The hits of a scan moved onto their surfaces: each hit on a surface is moved onto the line of
/// its neighbours, as in [`oriented_beams`], and its range is updated. All other hits stay, and a
/// scan whose beams are farther apart than a tenth of a radian is not changed at all.
#[must_use]
pub fn on_surfaces(points: &Points) -> Points {
    let mut moved = points.clone();
    let angle = points.beam_spacing().unwrap_or(LONE_SPACING);
    if angle > WIDEST_GAP {
        return moved;
    }
    let hits = near_hits(points);
    for (at, (place, beam)) in hits.iter().enumerate() {
        let reach = REACH.max(REACH_SIGMAS * beam.sigma);
        let line = line_at(&hits, at, beam.range * angle, reach);
        if let (Some((_, to_line)), Some(beam)) = (line, moved.beams.get_mut(*place)) {
            beam.end_in_robot += to_line;
            beam.range = (beam.end_in_robot - beam.origin_in_robot).length();
        }
    }
    moved
}

/// The line of a hit's neighbours within `least_reach` or a few beams: its normal, and the vector
/// from the hit to it.
fn line_at(
    hits: &[(usize, &Beam)],
    at: usize,
    beam_spacing: f64,
    least_reach: f64,
) -> Option<(Vector2<f64>, Vector2<f64>)> {
    let position = hits.get(at)?.1.end_in_robot;
    let gap = 0.06 + 3.0 * beam_spacing;
    let reach = least_reach.max(2.5 * beam_spacing);
    let squares = [gap * gap, reach * reach];
    let mut scatter = Scatter::default();
    scatter.add(Vector2::zeros());
    let (before, from_here) = hits.split_at(at);
    let ends = |hit: &(usize, &Beam)| hit.1.end_in_robot;
    add_neighbours(
        &mut scatter,
        position,
        from_here.iter().skip(1).map(ends),
        squares,
    );
    add_neighbours(
        &mut scatter,
        position,
        before.iter().rev().map(ends),
        squares,
    );
    let normal = scatter.normal()?;
    Some((normal, normal * normal.dot(&scatter.mean())))
}

/// Adds the neighbours of a hit on one side, as long as each is near enough to the one before it
/// and to the hit; `gap` and `reach` are squared.
fn add_neighbours(
    scatter: &mut Scatter,
    position: Point2<f64>,
    neighbours: impl Iterator<Item = Point2<f64>>,
    [gap, reach]: [f64; 2],
) {
    let mut last = position;
    for next in neighbours.take(MAX_NEIGHBOURS) {
        let off = next - position;
        let is_near = (next - last).norm_squared() <= gap && off.norm_squared() <= reach;
        if !is_near {
            break;
        }
        scatter.add(off);
        last = next;
    }
}

/// The cosine of the angle at which a hit's beam meets the surface, from the hits around it.
fn facing(hits: &[(usize, &Beam)], at: usize) -> f64 {
    let end = |at: usize| hits.get(at).map(|(_, beam)| beam.end_in_robot);
    let last = hits.len().saturating_sub(1);
    let about =
        end(at.saturating_sub(FACING_NEIGHBOURS)).zip(end((at + FACING_NEIGHBOURS).min(last)));
    let (Some((before, after)), Some((_, beam))) = (about, hits.get(at)) else {
        return 1.0;
    };
    let (along, ray) = (after - before, beam.end_in_robot - beam.origin_in_robot);
    let across = along.perp(&ray).abs() / (along.length() * ray.length());
    // Ends on different surfaces tell nothing about either.
    match along.length() < FACING_REACH && across.is_finite() {
        true => across.max(GRAZING),
        false => 1.0,
    }
}

/// Finds the surfaces in what several scans saw from several places, in the frame and order of
/// `points`, each with the index of its beam there. Points of `before`, in the same frame, only
/// count as neighbours.
#[must_use]
pub fn oriented_cloud(points: &Points, before: &[Point2<f64>]) -> Vec<(usize, OrientedPoint)> {
    let hits = near_hits(points);
    let mut kept: Vec<(usize, OrientedPoint)> = vec![];
    for (place, beam) in &hits {
        let position = beam.end_in_robot;
        let is_near = |other: &Point2<f64>, reach: f64| (other - position).length() < reach;
        if kept.iter().any(|(_, k)| is_near(&k.position, SPACING)) {
            continue;
        }
        let mut scatter = Scatter::default();
        let ends = hits.iter().map(|(_, b)| b.end_in_robot);
        let ends = ends.chain(before.iter().copied());
        for end in ends.filter(|end| is_near(end, CLOUD_REACH)) {
            scatter.add(end - position);
        }
        let normal = (scatter.count >= CLOUD_NEIGHBOURS).then(|| scatter.normal());
        let normal = normal.flatten();
        kept.extend(normal.map(|normal| (*place, seen(beam, normal))));
    }
    kept
}

/// The hits within the greatest range, with their indices in `points.beams`.
fn near_hits(points: &Points) -> Vec<(usize, &Beam)> {
    let beams = points.beams.iter().enumerate();
    let mut hits = Vec::with_capacity(points.beams.len());
    hits.extend(beams.filter(|(_, beam)| beam.is_hit && beam.range <= MAX_RANGE));
    hits
}

/// The end of a beam, with the normal of the surface towards the side from which it was seen.
fn seen(beam: &Beam, normal: Vector2<f64>) -> OrientedPoint {
    let is_behind = normal.dot(&(beam.origin_in_robot - beam.end_in_robot)) < 0.0;
    OrientedPoint {
        position: beam.end_in_robot,
        normal: if is_behind { -normal } else { normal },
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::geom::{Pose2, Segment, sin_cos, unit_vector};
    use crate::points::fixture::{look, look_along, normal, scan_of_hits};

    /// 180 beams from the origin at a wall x cos a + y sin a = 2, with hits nearer than 8 m.
    fn wall(a: f64) -> Points {
        let bearings = (0..180).map(|degree| (f64::from(degree) - 90.0).to_radians());
        let (normal, along) = (unit_vector(a), unit_vector(a + FRAC_PI_2));
        let [left, right] = [20.0, -20.0].map(|far| Point2::from(2.0 * normal + far * along));
        look_along(
            bearings,
            &[Segment::new(left, right)],
            &Pose2::identity(),
            8.0,
        )
    }

    #[test]
    fn normals_of_a_wall_look_at_the_robot() {
        for degrees in [-60.0_f64, -45.0, 0.0, 30.0, 45.0, 80.0] {
            let a = degrees.to_radians();
            let found = oriented_points(&wall(a));
            assert!(found.len() > 30, "{degrees}: {}", found.len());
            let (sin, cos) = sin_cos(a);
            for p in &found {
                assert!(
                    (p.normal + Vector2::new(cos, sin)).length() < 1e-4,
                    "{degrees}: {p:?}"
                );
            }
            let near = found
                .windows(2)
                .map(|w| (w[0].position - w[1].position).length());
            assert!(near.fold(f64::INFINITY, f64::min) >= 0.036);
        }
    }

    /// A wall to the left, ahead and behind, seen by 360 beams with a noise of 2 cm: in both halves
    /// it is found where it is, and with less noise.
    #[test]
    fn noise_does_not_choose_the_points_of_a_wall() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (mut sums, mut squares) = ([0.0; 2], 0.0);
        let mut counts = [0.0; 2];
        for _ in 0..400 {
            let bearings = (0..360).map(|degree| (f64::from(degree) - 180.0).to_radians());
            let ends = bearings.filter(|b| (0.3..2.8).contains(b)).map(|bearing| {
                let range = 1.0 / libm::sin(bearing) + 0.02 * normal(&mut rng);
                Point2::from(range * unit_vector(bearing))
            });
            for point in oriented_points(&scan_of_hits(ends)) {
                let half = usize::from(point.position.x < 0.0);
                let off = point.position.y - 1.0;
                if point.position.x.abs() > 0.5 {
                    sums[half] += off;
                    counts[half] += 1.0;
                    squares += off * off;
                }
            }
        }
        let total: f64 = counts.iter().sum();
        let sigma = (squares / total).sqrt();
        assert!(sigma < 0.01, "{sigma}");
        let [ahead, behind] = [0, 1].map(|half| sums[half] / counts[half]);
        // Neighbours share their noise.
        let doubt = 3.0 * sigma / (total / 2.0 / 8.0).sqrt();
        assert!(total > 1e4 && doubt < 1e-3, "{total} {doubt}");
        assert!((ahead - behind).abs() < 2.0 * doubt, "{ahead} {behind}");
    }

    #[test]
    fn a_wall_that_was_gathered_has_its_normals_whatever_the_order() {
        let ends = (0..40).map(|i| Point2::new(2.0, -0.1 + 0.05 * f64::from(i * 7 % 40)));
        let found = oriented_cloud(&scan_of_hits(ends), &[]);
        assert!(found.len() > 30, "{}", found.len());
        for (_, point) in &found {
            assert!((point.normal + Vector2::x()).length() < 1e-9, "{point:?}");
        }
        // With these, one more point on the wall has a normal.
        let before: Vec<_> = found.iter().map(|(_, p)| p.position).collect();
        let one = scan_of_hits([Point2::new(2.0, 0.52)]);
        assert!(oriented_cloud(&one, &[]).is_empty());
        assert_eq!(oriented_cloud(&one, &before).len(), 1);
    }

    /// A room of 4 x 3 m, and noise of 1 cm: walls become half as thick, and without noise corners
    /// stay within 2 cm of their true place.
    #[test]
    fn hits_are_moved_onto_their_walls_and_not_round_corners() {
        let corners = [[-1.5, -1.0], [2.5, -1.0], [2.5, 2.0], [-1.5, 2.0]].map(Point2::from);
        let walls = [0, 1, 2, 3].map(|i| Segment::new(corners[i], corners[(i + 1) % 4]));
        let exact = look(&walls, &Pose2::identity(), 8.0);
        for (before, after) in exact.beams.iter().zip(&on_surfaces(&exact).beams) {
            assert!((before.end_in_robot - after.end_in_robot).length() < 0.02);
        }
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let square_off = |p: Point2<f64>| {
            let off = [p.x + 1.5, 2.5 - p.x, p.y + 1.0, 2.0 - p.y].map(f64::abs);
            let off = off.into_iter().fold(f64::INFINITY, f64::min);
            off * off
        };
        let mut squares = [0.0; 2];
        for _ in 0..50 {
            let mut noisy = exact.clone();
            for beam in &mut noisy.beams {
                let part = 1.0 + 0.01 * normal(&mut rng) / beam.range;
                beam.end_in_robot.coords *= part;
                beam.range *= part;
            }
            let moved = on_surfaces(&noisy);
            for (sum, points) in squares.iter_mut().zip([&noisy, &moved]) {
                *sum += points
                    .beams
                    .iter()
                    .map(|b| square_off(b.end_in_robot))
                    .sum::<f64>();
            }
            for beam in &moved.beams {
                let length = (beam.end_in_robot - beam.origin_in_robot).length();
                assert!((beam.range - length).abs() < 1e-12);
            }
        }
        let thinner = (squares[0] / squares[1]).sqrt();
        assert!(thinner > 1.8, "{thinner}");
    }

    #[test]
    fn lone_points_have_no_surface() {
        let ends = (0..20).map(|i| Point2::new(1.0 + f64::from(i), f64::from(i) * 0.01));
        let points = scan_of_hits(ends);
        assert!(oriented_points(&points).is_empty());
    }
}
