//! Rings of corridors, and drives around them with odometry that turns too far and slips.

use nalgebra::{Matrix3, Point2, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::super::ScanMatcher;
use crate::geom::{Length, Pose2, Segment, unit_vector};
use crate::points::fixture::{normal, range_to};
use crate::points::{PointConfig, Points};
use crate::robot::{Odometry, Scan, Stamp};

/// A motion and what was seen after it.
pub(in super::super) struct Step {
    pub(in super::super) odometry: Odometry,
    pub(in super::super) scan: Scan,
    /// Frame of the building.
    pub(in super::super) truth: Pose2,
}

/// The corners of the corridors, in order.
pub(in super::super) const LAP: [(f64, f64); 4] =
    [(5.0, -4.0), (5.0, 4.0), (-5.0, 4.0), (-5.0, -4.0)];

/// Takes a scan whose beams were all taken at once.
pub(in super::super) fn update(matcher: &mut ScanMatcher, points: &Points) {
    matcher.update(points, &vec![points.bearing_sigma; points.beams.len()]);
}

/// A ring of corridors, 2 m wide, around a block of 8 m x 6 m, with niches that make its sides
/// distinguishable.
pub(in super::super) fn ring() -> Vec<Segment> {
    let rectangle = |x0: f64, y0: f64, x1: f64, y1: f64| {
        let c = [(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)];
        c.windows(2)
            .map(|w| Segment::new(Point2::new(w[0].0, w[0].1), Point2::new(w[1].0, w[1].1)))
            .collect::<Vec<_>>()
    };
    let mut walls = rectangle(-6.0, -5.0, 6.0, 5.0);
    walls.extend(rectangle(-4.0, -3.0, 4.0, 3.0));
    for (x, y, w, h) in [
        (-2.0, -5.0, 0.8, 0.4),
        (1.5, -5.0, 0.4, 0.5),
        (5.5, -1.0, 0.5, 0.6),
        (5.6, 2.0, 0.4, 0.4),
        (-1.0, 4.6, 1.2, 0.4),
        (2.8, 4.7, 0.3, 0.3),
        (-6.0, 0.5, 0.5, 0.9),
        (-6.0, -2.5, 0.4, 0.3),
    ] {
        walls.extend(rectangle(x, y, x + w, y + h));
    }
    walls
}

pub(in super::super) fn points_of(scan: &Scan) -> Points {
    Points::from_scan(scan, &Pose2::identity(), &PointConfig::default())
}

pub(in super::super) fn scan_at(
    walls: &[Segment],
    pose: &Pose2,
    stamp: Stamp,
    rng: &mut impl Rng,
) -> Scan {
    let bearings: Vec<f64> = (0..180)
        .map(|i| (f64::from(i) - 90.0).to_radians())
        .collect();
    let mut range = |&bearing: &f64| {
        let exact = range_to(walls, pose, unit_vector(bearing));
        (exact + 0.01 * normal(rng)) as f32
    };
    let ranges = bearings.iter().map(&mut range).collect();
    Scan {
        stamp,
        robot_from_sensor: Pose2::identity(),
        sigmas: vec![0.01; bearings.len()],
        bearings,
        ranges,
        bearing_sigma: 0.0,
        max_range: 20.0,
        sweep: 0.0,
        qualities: vec![],
    }
}

/// The ring with corridors of different widths, so no two parts of it look alike.
fn lopsided() -> Vec<Segment> {
    let is_inner = |p: Point2<f64>| p.x.abs() <= 4.0 && p.y.abs() <= 3.0;
    let mut walls = ring();
    walls.retain(|wall| !(is_inner(wall.a) && is_inner(wall.b)));
    let corners = [
        (-4.3, -3.1),
        (3.2, -3.1),
        (3.2, 3.3),
        (-1.0, 3.3),
        (-1.0, 2.0),
        (-4.3, 2.0),
    ];
    let corner = |at: usize| {
        let (x, y) = corners[at % corners.len()];
        Point2::new(x, y)
    };
    walls.extend((0..corners.len()).map(|at| Segment::new(corner(at), corner(at + 1))));
    walls
}

/// From corner to corner at 0.1 m and 6° per scan, with odometry that turns 3 % too far and slips.
pub(in super::super) fn drive_along(
    walls: &[Segment],
    corners: &[(f64, f64)],
    from: Pose2,
    seed: u64,
) -> Vec<Step> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut pose, mut stamp) = (from, Stamp(0));
    let mut steps = vec![];
    let mut visit = |pose: &Pose2, motion: Pose2| {
        let (from, to) = (stamp, Stamp(stamp.0 + 200_000));
        stamp = to;
        let motion = Pose2::new(
            motion.x() * 1.02 + 0.003 * normal(&mut rng),
            0.002 * normal(&mut rng),
            motion.heading() * 1.03 + 0.004 * normal(&mut rng),
        );
        let odometry = Odometry {
            from,
            to,
            motion,
            cov: Matrix3::from_diagonal(&Vector3::repeat(1e-4)),
        };
        steps.push(Step {
            odometry,
            scan: scan_at(walls, pose, to, &mut rng),
            truth: *pose,
        });
    };
    visit(&pose, Pose2::identity());
    for &(x, y) in corners {
        loop {
            let ahead = pose.inverse() * Point2::new(x, y);
            let bearing = libm::atan2(ahead.y, ahead.x);
            let motion = if ahead.coords.length() < 0.06 {
                break;
            } else if bearing.abs() > 0.01 {
                Pose2::new(0.0, 0.0, bearing.clamp(-0.1, 0.1))
            } else {
                Pose2::new(ahead.x.min(0.1), 0.0, 0.0)
            };
            pose = pose * motion;
            visit(&pose, motion);
        }
    }
    steps
}

/// The same in the ring in which no two parts look alike.
pub(in super::super) fn drive(corners: &[(f64, f64)], from: Pose2, seed: u64) -> Vec<Step> {
    drive_along(&lopsided(), corners, from, seed)
}

pub(in super::super) fn feed(matcher: &mut ScanMatcher, steps: &[Step]) {
    for step in steps {
        matcher.odometry(&step.odometry);
        update(matcher, &points_of(&step.scan));
    }
}
