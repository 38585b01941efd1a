//! Runs through known walls, with sightings computed directly from the truth.

use nalgebra::{Vector2, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::super::super::innovation::Innovations;
use super::super::*;
use super::{ONCE, odometry};
use crate::features::PointKind;
use crate::geom::{Length, Line, Segment, sides_of, wrap};
use crate::points::fixture::normal;
use crate::robot::{OdometryNoise, Tracks};

/// A run through known walls with sightings computed directly from the truth.
pub(super) struct Run {
    pub(super) slam: EkfSlam,
    truth: Pose2,
    pub(super) walls: Vec<Segment>,
    pub(super) noise: OdometryNoise,
    rng: ChaCha8Rng,
    range: f64,
    /// Round objects in the world, map frame.
    pub(super) posts: Vec<Point2<f64>>,
    /// Whether the corners of neighbouring walls are seen too.
    pub(super) corners: Corners,
    /// The true position of each point landmark.
    pub(super) true_points: Vec<(LandmarkId, Point2<f64>)>,
    /// Sum and number of NEES values of the pose.
    pub(super) nees: (f64, u32),
    pub(super) nis: (f64, usize),
    /// For each scan.
    pub(super) innovations: Vec<Innovations>,
    /// Which wall a landmark is, and how often another one was mistaken for it.
    wall_of: Vec<(LandmarkId, usize)>,
    pub(super) wrong: u32,
}

const WIDTH: f64 = 0.2;
/// Standard deviation of the seen position of a post, along each axis, m.
pub(super) const POST_SIGMA: f64 = 0.02;

/// Which corners a run sees: where the lines of two walls cross, as these were seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Corners {
    None,
    /// With the beams of both walls.
    Honest,
    /// The same, as if found by beams of their own.
    Posing,
}

impl Run {
    pub(super) fn new(
        config: EkfConfig,
        walls: &[Segment],
        start: Pose2,
        range: f64,
        seed: u64,
    ) -> Self {
        // Walls in the map frame, which starts at the robot.
        let to_map = start.inverse();
        let in_map = |w: &Segment| Segment::new(to_map * w.a, to_map * w.b);
        Self {
            slam: EkfSlam::new(config).unwrap(),
            truth: Pose2::identity(),
            walls: walls.iter().map(in_map).collect(),
            noise: OdometryNoise {
                per_metre: 2.5e-4,
                lateral_per_metre: 1e-4,
                heading_per_radian: 2e-3,
            },
            rng: ChaCha8Rng::seed_from_u64(seed),
            range,
            posts: vec![],
            corners: Corners::None,
            true_points: vec![],
            nees: (0.0, 0),
            nis: (0.0, 0),
            innovations: vec![],
            wall_of: vec![],
            wrong: 0,
        }
    }

    /// Drives to `goal` (map frame): a turn and a straight line, a scan every 0.1 m.
    pub(super) fn go(&mut self, goal: Point2<f64>) {
        let step = self.truth.inverse() * goal;
        let turn = libm::atan2(step.y, step.x);
        let parts = 1 + (turn.abs() / 0.2) as usize;
        for _ in 0..parts {
            let arc = 0.5 * WIDTH * turn / parts as f64;
            self.step(Tracks {
                left: -arc,
                right: arc,
            });
        }
        let parts = 1 + ((goal - self.truth.position()).length() / 0.1) as usize;
        let advance = (goal - self.truth.position()).length() / parts as f64;
        for _ in 0..parts {
            self.step(Tracks {
                left: advance,
                right: advance,
            });
        }
    }

    /// Moves by the odometry plus noise drawn from its covariance, and takes a scan.
    pub(super) fn step(&mut self, tracks: Tracks) {
        let motion = tracks.motion(WIDTH);
        let cov = tracks.covariance(WIDTH, &self.noise) + Matrix3::identity() * 1e-10;
        let l = cov.cholesky().unwrap().l();
        let rng = &mut self.rng;
        let e = l * Vector3::new(normal(rng), normal(rng), normal(rng));
        self.truth =
            self.truth * Pose2::new(motion.x() + e.x, motion.y() + e.y, motion.heading() + e.z);
        self.slam.predict(&odometry(motion, cov)).unwrap();
        let features = self.see();
        let (points, truths): (Vec<_>, Vec<_>) = self.see_points(&features).into_iter().unzip();
        let report = (self.slam)
            .update_with_points(&features, &points, &ONCE)
            .unwrap();
        for &(point, id) in &report.points_added {
            self.true_points.push((id, truths[point]));
        }
        for &(feature, id) in &report.added {
            self.wall_of.push((id, features[feature].first_beam));
        }
        for m in &report.matches {
            let wall = features[m.feature].first_beam;
            let right = self.wall_of.contains(&(m.landmark, wall));
            self.wrong += u32::from(!right);
        }
        self.innovations.push(report.innovations());
        let matches = report.nis_degrees() / 2;
        self.nis = (self.nis.0 + report.nis, self.nis.1 + matches);
        if let Some(nees) = self.slam.estimate().nees(&self.truth) {
            self.nees = (self.nees.0 + nees, self.nees.1 + 1);
        }
    }

    /// The part of each wall within range and in sight (middle and quarters), noisy.
    fn see(&mut self) -> Vec<LineFeature> {
        let robot_from_map = self.truth.inverse();
        let mut seen = vec![];
        for (number, wall) in self.walls.iter().enumerate() {
            let local = Segment::new(robot_from_map * wall.a, robot_from_map * wall.b);
            let visible: Vec<Point2<f64>> = (0..=20)
                .map(|i| local.a + local.vector() * (f64::from(i) / 20.0))
                .filter(|p| p.coords.length() < self.range && self.is_free(*p, &local))
                .collect();
            let (Some(a), Some(b)) = (visible.first(), visible.last()) else {
                continue;
            };
            let Some(line) = Line::through(*a, *b) else {
                continue;
            };
            if (b - a).length() < 0.4 || line.r() < 0.1 {
                continue;
            }
            let (middle, length) = (nalgebra::center(a, b), (b - a).length());
            // A regression over points every 0.1 m with σ = 0.02 m, moved from the middle of the
            // wall to the origin.
            let n = (length / 0.1).max(4.0);
            let (var_alpha, var_middle) = (12.0 * 4e-4 / (n * length * length), 4e-4 / n);
            let lever = Vector2::new(-line.normal().y, line.normal().x).dot(&middle.coords);
            let cov = Matrix2::new(
                var_alpha,
                lever * var_alpha,
                lever * var_alpha,
                var_middle + lever * lever * var_alpha,
            );
            let e = correlated(&cov, &mut self.rng);
            let noisy = Line::new(line.alpha() + e.x, line.r() + e.y);
            seen.push(LineFeature {
                line: noisy,
                cov,
                ends: [noisy.project(*a), noisy.project(*b)],
                seen_from_origin_side: true,
                first_beam: number,
                last_beam: number,
                n_points: n as usize,
                chi2: n - 2.0,
                by_heading: [Vector2::zeros(); 2],
            });
        }
        seen
    }

    /// Posts within range, and the corners of lines that were seen; each with its true position,
    /// map frame.
    fn see_points(&mut self, lines: &[LineFeature]) -> Vec<(PointFeature, Point2<f64>)> {
        let robot_from_map = self.truth.inverse();
        let mut seen = vec![];
        for (number, post) in self.posts.iter().enumerate() {
            let local = robot_from_map * *post;
            let sight = Segment::new(self.truth.position(), *post);
            let is_hidden = self.walls.iter().any(|wall| wall.crosses(&sight));
            if local.coords.length() > self.range || is_hidden {
                continue;
            }
            let noise = Vector2::new(normal(&mut self.rng), normal(&mut self.rng)) * POST_SIGMA;
            let feature = PointFeature {
                position: local + noise,
                cov: Matrix2::identity() * (POST_SIGMA * POST_SIGMA),
                kind: PointKind::Circle {
                    radius: 0.1,
                    var_radius: 1e-6,
                },
                confidence: 1.0,
                beams: [1000 + number, 1000 + number],
            };
            seen.push((feature, *post));
        }
        for pair in lines.windows(2) {
            let [a, b] = [pair[0].first_beam, pair[1].first_beam];
            let apart = (self.walls[a].b - self.walls[b].a).length();
            if self.corners == Corners::None || b != a + 1 || apart > 1e-9 {
                continue;
            }
            let truth = self.walls[a].b;
            let near = robot_from_map * truth;
            if pair
                .iter()
                .all(|l| (l.ends[0] - near).length().min((l.ends[1] - near).length()) < 0.3)
            {
                let beams = match self.corners {
                    Corners::Posing => [2000 + a, 2000 + a],
                    _ => [a, b],
                };
                seen.push((corner_of(&pair[0], &pair[1], beams), truth));
            }
        }
        seen
    }

    fn is_free(&self, point: Point2<f64>, own: &Segment) -> bool {
        let to_map = self.truth;
        let ray = point.coords * (1.0 - 1e-6);
        let sight = Segment::new(to_map.position(), to_map * Point2::from(ray));
        let own_in_map = Segment::new(to_map * own.a, to_map * own.b);
        self.walls.iter().all(|w| {
            let same = (w.a - own_in_map.a).length() < 1e-9 && (w.b - own_in_map.b).length() < 1e-9;
            same || !w.crosses(&sight)
        })
    }

    pub(super) fn end_nees(&self) -> f64 {
        self.slam.estimate().nees(&self.truth).unwrap()
    }

    pub(super) fn error(&self) -> (f64, f64) {
        let pose = self.slam.estimate().pose;
        (
            (pose.position() - self.truth.position()).length(),
            wrap(pose.heading() - self.truth.heading()).abs(),
        )
    }
}

pub(super) fn polygon(points: &[(f64, f64)]) -> Vec<Segment> {
    let corner = |p: &(f64, f64)| Point2::new(p.0, p.1);
    sides_of(points)
        .map(|(a, b)| Segment::new(corner(a), corner(b)))
        .collect()
}

/// A ring corridor 2 m wide, centre line 2 * (w + h), around the origin of the world; with niches
/// that show where along it the robot is.
pub(super) fn ring(w: f64, h: f64) -> Vec<Segment> {
    let (x, y) = (0.5 * w, 0.5 * h);
    let mut walls = polygon(&[
        (-x - 1.0, -y - 1.0),
        (-2.0, -y - 1.0),
        (-2.0, -y - 1.5),
        (-1.0, -y - 1.5),
        (-1.0, -y - 1.0),
        (x + 1.0, -y - 1.0),
        (x + 1.0, -1.0),
        (x + 1.6, -1.0),
        (x + 1.6, 0.0),
        (x + 1.0, 0.0),
        (x + 1.0, y + 1.0),
        (1.5, y + 1.0),
        (1.5, y + 1.5),
        (0.0, y + 1.5),
        (0.0, y + 1.0),
        (-x - 1.0, y + 1.0),
    ]);
    walls.extend(polygon(&[
        (-x + 1.0, -y + 1.0),
        (x - 1.0, -y + 1.0),
        (x - 1.0, y - 1.0),
        (-x + 1.0, y - 1.0),
    ]));
    walls
}

pub(super) fn drive_ring(config: EkfConfig, w: f64, h: f64, laps: usize, seed: u64) -> Run {
    let start = Pose2::new(-0.5 * w, -0.5 * h, 0.0);
    let mut run = Run::new(config, &ring(w, h), start, 8.0, seed);
    run.drive_ring(w, h, laps);
    run
}

impl Run {
    pub(super) fn drive_ring(&mut self, w: f64, h: f64, laps: usize) {
        for _ in 0..laps {
            for (x, y) in [
                (0.3 * w, 0.0),
                (w, 0.0),
                (w, h),
                (0.4 * w, h),
                (0.0, h),
                (0.0, 0.0),
            ] {
                self.go(Point2::new(x, y));
            }
        }
    }
}

/// Where two lines cross, with the covariance that follows from theirs by central differences.
fn corner_of(a: &LineFeature, b: &LineFeature, beams: [usize; 2]) -> PointFeature {
    let cross = |by: [f64; 4]| {
        let of = |line: &LineFeature, alpha: f64, r: f64| {
            (
                Line::new(line.line.alpha() + alpha, 1.0).normal(),
                line.line.r() + r,
            )
        };
        let ((na, ra), (nb, rb)) = (of(a, by[0], by[1]), of(b, by[2], by[3]));
        let sin = na.perp(&nb);
        Vector2::new(ra * nb.y - rb * na.y, rb * na.x - ra * nb.x) / sin
    };
    let column = |axis: usize| {
        let nudged = |h: f64| {
            let mut by = [0.0; 4];
            by[axis] = h;
            cross(by)
        };
        (nudged(1e-6) - nudged(-1e-6)) / 2e-6
    };
    let of_a = Matrix2::from_columns(&[column(0), column(1)]);
    let of_b = Matrix2::from_columns(&[column(2), column(3)]);
    PointFeature {
        position: Point2::from(cross([0.0; 4])),
        cov: of_a * a.cov * of_a.transpose() + of_b * b.cov * of_b.transpose(),
        kind: PointKind::Corner,
        confidence: 1.0,
        beams,
    }
}

/// Two correlated normal numbers of the given covariance.
pub(super) fn correlated(cov: &Matrix2<f64>, rng: &mut ChaCha8Rng) -> Vector2<f64> {
    let l = cov.cholesky().unwrap().l();
    l * Vector2::new(normal(rng), normal(rng))
}
