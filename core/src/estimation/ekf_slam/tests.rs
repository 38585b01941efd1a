use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, SVector, Vector2, Vector3};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::super::line_model::place;
use super::robot_state::Step;
use super::*;
use crate::geom::{CHI2_2DOF_99, Line, Segment, wrap};
use crate::robot::{OdometryNoise, Stamp, Tracks};

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (rng.random(), rng.random());
    (-2.0 * libm::log(1.0 - u)).sqrt() * libm::cos(TAU * v)
}

/// Two correlated normal numbers of the given covariance.
fn correlated(cov: &Matrix2<f64>, rng: &mut ChaCha8Rng) -> Vector2<f64> {
    let l = cov.cholesky().unwrap().l();
    l * Vector2::new(normal(rng), normal(rng))
}

pub(super) const ONCE: SweepTiming = SweepTiming {
    lag: 0.0,
    stamp: Stamp(1),
    seconds: 0.0,
    n_beams: 0,
};

fn odometry(motion: Pose2, cov: Matrix3<f64>) -> Odometry {
    Odometry {
        from: Stamp(0),
        to: Stamp(1),
        motion,
        cov,
    }
}

pub(super) fn feature(alpha: f64, r: f64) -> LineFeature {
    let line = Line::new(alpha, r);
    let foot = Point2::from(line.normal() * line.r());
    let tangent = Vector2::new(-line.normal().y, line.normal().x);
    LineFeature {
        line,
        cov: Matrix2::new(1e-4, 3e-5, 3e-5, 2e-4),
        ends: [foot - tangent, foot + tangent],
        seen_from_origin_side: true,
        first_beam: 0,
        last_beam: 20,
        n_points: 21,
        chi2: 19.0,
        by_heading: [Vector2::zeros(); 2],
    }
}

pub(super) fn dense(slam: &EkfSlam) -> DMatrix<f64> {
    let p = &slam.cov;
    DMatrix::from_fn(p.n(), p.n(), |i, j| p.get(i, j))
}

pub(super) fn plain() -> EkfConfig {
    EkfConfig {
        consistency: Consistency::Plain,
        alpha_sigma: 0.0,
        r_sigma: 0.0,
        odometry_prior: OdometryErrors::default(),
        ..EkfConfig::default()
    }
}

/// A filter that has moved and seen three walls.
fn some_state() -> EkfSlam {
    let mut slam = EkfSlam::new(EkfConfig {
        odometry_prior: EkfConfig::default().odometry_prior,
        ..plain()
    });
    let noise = Matrix3::from_diagonal(&Vector3::new(4e-3, 2e-3, 1e-3));
    slam.predict(&odometry(Pose2::new(1.0, 0.3, 0.4), noise))
        .unwrap();
    slam.update(
        &[feature(0.2, 2.0), feature(1.8, 1.0), feature(-2.0, 3.0)],
        &ONCE,
    )
    .unwrap();
    slam.advance(&odometry(Pose2::new(0.5, -0.1, -0.3), noise));
    assert_eq!(slam.landmarks().count(), 3);
    slam
}

#[test]
fn prediction_is_the_dense_one() {
    let mut slam = some_state();
    let (before, pose, errors) = (dense(&slam), slam.pose, slam.errors);
    let motion = odometry(
        Pose2::new(0.7, 0.2, 0.5),
        Matrix3::new(2e-3, 1e-4, 2e-4, 1e-4, 1e-3, 3e-4, 2e-4, 3e-4, 5e-3),
    );
    slam.advance(&motion);
    // Full Jacobians, by central differences.
    let n = before.nrows();
    let after = |p: SVector<f64, ROBOT>, u: Vector3<f64>| {
        let errors = OdometryErrors {
            curvature: p[3],
            turn_scale: p[4],
        };
        let read = odometry(motion.motion, Matrix3::zeros());
        let start = Pose2::new(p[0], p[1], p[2]);
        let exact = Step::new(&Pose2::identity(), &errors, &read, Point2::origin()).pose;
        let noisy = Pose2::new(exact.x() + u.x, exact.y() + u.y, exact.heading() + u.z);
        let moved = start * noisy;
        Vector3::new(moved.x(), moved.y(), moved.heading())
    };
    let p = SVector::from([
        pose.x(),
        pose.y(),
        pose.heading(),
        errors.curvature,
        errors.turn_scale,
    ]);
    let (mut fx, mut fu) = (DMatrix::identity(n, n), DMatrix::zeros(n, 3));
    let none = Vector3::zeros();
    for axis in 0..ROBOT {
        let mut h = SVector::<f64, ROBOT>::zeros();
        h[axis] = 1e-6;
        let by_robot = (after(p + h, none) - after(p - h, none)) / 2e-6;
        fx.view_mut((0, axis), (3, 1)).copy_from(&by_robot);
    }
    for axis in 0..3 {
        let mut h = Vector3::zeros();
        h[axis] = 1e-6;
        let by_motion = (after(p, h) - after(p, -h)) / 2e-6;
        fu.view_mut((0, axis), (3, 1)).copy_from(&by_motion);
    }
    let q = DMatrix::from_fn(3, 3, |i, j| motion.cov[(i, j)]);
    let expect = &fx * before * fx.transpose() + &fu * q * fu.transpose();
    assert!((dense(&slam) - expect).norm() < 1e-9);
}

#[test]
fn update_is_the_dense_joseph_form() {
    for landmark in 0..3 {
        let mut slam = some_state();
        let before = dense(&slam);
        let n = before.nrows();
        let expected = slam.expect(landmark);
        let seen = feature(expected.line.alpha + 0.01, expected.line.r - 0.02);
        let mut h = DMatrix::zeros(2, n);
        h.view_mut((0, 0), (2, 3)).copy_from(&expected.by_pose);
        h.view_mut((0, ROBOT + 2 * landmark), (2, 2))
            .copy_from(&expected.by_line);
        let r = DMatrix::from_fn(2, 2, |i, j| seen.cov[(i, j)]);
        let z = &h * &before * h.transpose() + &r;
        let k = &before * h.transpose() * z.try_inverse().unwrap();
        let rest = DMatrix::identity(n, n) - &k * &h;
        let joseph = &rest * &before * rest.transpose() + &k * r * k.transpose();
        let shift = &k * DMatrix::from_column_slice(2, 1, &[0.01, -0.02]);
        let state = |s: &EkfSlam| {
            let pose = [
                s.pose.x(),
                s.pose.y(),
                s.pose.heading(),
                s.errors.curvature,
                s.errors.turn_scale,
            ];
            let lines = s.landmarks.iter().flat_map(|e| e.line);
            pose.into_iter().chain(lines).collect::<Vec<_>>()
        };
        let old = state(&slam);
        slam.correct(landmark, &seen, &mut Gain::default());
        assert!((dense(&slam) - &joseph).norm() < 1e-12, "{landmark}");
        for (i, (new, old)) in state(&slam).iter().zip(&old).enumerate() {
            assert!((new - old - shift[i]).abs() < 1e-9, "state {i}");
        }
    }
}

#[test]
fn augmentation_is_the_dense_one() {
    let mut slam = some_state();
    let (before, pose) = (dense(&slam), slam.pose);
    let seen = feature(2.9, 4.0);
    slam.augment(&seen);
    let anchor = slam.landmarks[3].anchor;
    // y' = g(y, z), its Jacobians by central differences.
    let n = before.nrows();
    let g = |p: [f64; 3], z: [f64; 2]| {
        let pose = Pose2::new(p[0] - anchor.x, p[1] - anchor.y, p[2]);
        place(&pose, z, Point2::origin()).0
    };
    let (p, z) = ([pose.x(), pose.y(), pose.heading()], [2.9, 4.0]);
    let mut by_state = DMatrix::zeros(n + 2, n);
    by_state.view_mut((0, 0), (n, n)).fill_with_identity();
    let mut by_seen = DMatrix::zeros(n + 2, 2);
    let column = |plus: [f64; 2], minus: [f64; 2]| {
        [wrap(plus[0] - minus[0]) / 2e-6, (plus[1] - minus[1]) / 2e-6]
    };
    for axis in 0..3 {
        let (mut plus, mut minus) = (p, p);
        (plus[axis], minus[axis]) = (p[axis] + 1e-6, p[axis] - 1e-6);
        let c = column(g(plus, z), g(minus, z));
        (by_state[(n, axis)], by_state[(n + 1, axis)]) = (c[0], c[1]);
    }
    for axis in 0..2 {
        let (mut plus, mut minus) = (z, z);
        (plus[axis], minus[axis]) = (z[axis] + 1e-6, z[axis] - 1e-6);
        let c = column(g(p, plus), g(p, minus));
        (by_seen[(n, axis)], by_seen[(n + 1, axis)]) = (c[0], c[1]);
    }
    let r = DMatrix::from_fn(2, 2, |i, j| seen.cov[(i, j)]);
    let expect = &by_state * before * by_state.transpose() + &by_seen * r * by_seen.transpose();
    assert!((dense(&slam) - expect).norm() < 1e-8);
}

#[test]
fn landmark_in_the_map_has_the_covariance_of_numeric_propagation() {
    let slam = some_state();
    for (index, landmark) in slam.landmarks().enumerate() {
        let entry = &slam.landmarks[index];
        let in_map = |da: f64, dr: f64| {
            let mut moved = entry.clone();
            moved.line = [entry.line[0] + da, entry.line[1] + dr];
            moved.in_map(&Matrix2::zeros()).0
        };
        let h = 1e-6;
        let column = |da: f64, dr: f64| {
            let (plus, minus) = (in_map(da, dr), in_map(-da, -dr));
            Vector2::new(wrap(plus.alpha() - minus.alpha()), plus.r() - minus.r()) / (2.0 * h)
        };
        let jacobian = Matrix2::from_columns(&[column(h, 0.0), column(0.0, h)]);
        let expect = jacobian * slam.block(ROBOT + 2 * index) * jacobian.transpose();
        assert!((landmark.cov - expect).norm() < 1e-9);
        assert!(
            landmark
                .ends
                .iter()
                .all(|end| landmark.line.signed_distance(*end).abs() < 1e-9)
        );
    }
}

#[test]
fn forgetting_leaves_the_marginal_of_the_rest() {
    let mut slam = some_state();
    let before = dense(&slam);
    let ids: Vec<_> = slam.landmarks().map(|l| l.id).collect();
    slam.landmarks[0].sightings = 5;
    slam.landmarks[2].sightings = 5;
    slam.scans += slam.config.patience + 1;
    let report = slam.update(&[], &ONCE).unwrap();
    assert_eq!(report.forgotten, [ids[1]]);
    assert_eq!(
        dense(&slam),
        before
            .remove_rows(ROBOT + 2, 2)
            .remove_columns(ROBOT + 2, 2)
    );
    assert_eq!(
        slam.landmarks().map(|l| l.id).collect::<Vec<_>>(),
        [ids[0], ids[2]]
    );
}

#[test]
fn each_line_says_why_it_was_taken_for_what() {
    let mut slam = some_state();
    let ids: Vec<_> = slam.landmarks().map(|l| l.id).collect();
    // The first wall as expected; the second one a metre off, and the third beyond a door on its own line.
    let expected: Vec<_> = (0..3).map(|l| slam.expect(l).line).collect();
    let door = Vector2::new(-libm::sin(expected[2].alpha), libm::cos(expected[2].alpha)) * 4.0;
    let mut beyond = feature(expected[2].alpha, expected[2].r);
    beyond.ends = beyond.ends.map(|end| end + door);
    let scan = [
        feature(expected[0].alpha, expected[0].r),
        feature(expected[1].alpha, expected[1].r + 1.0),
        beyond,
    ];
    let report = slam.update(&scan, &ONCE).unwrap();
    let of = |i: usize, landmark: usize| {
        let explanation = report.explain(i).unwrap();
        let candidate = explanation
            .candidates
            .iter()
            .find(|c| c.landmark == ids[landmark]);
        (explanation.verdict, *candidate.unwrap())
    };
    let (verdict, candidate) = of(0, 0);
    assert_eq!(
        (verdict, candidate.gate),
        (Verdict::Matched(ids[0]), Gate::Match)
    );
    assert!(candidate.d2 < 1e-9 && candidate.gap < 0.0);
    let (verdict, candidate) = of(1, 1);
    assert!(matches!(verdict, Verdict::Added(_)) && candidate.gate == Gate::Far);
    assert!((candidate.innovation[1] - 1.0).abs() < 0.1);
    let (verdict, candidate) = of(2, 2);
    assert!(matches!(verdict, Verdict::Added(_)) && candidate.gate == Gate::Beyond);
    assert!(candidate.d2 < 9.0 && candidate.gap > 0.5);
    assert_eq!((report.matches.len(), report.nis_degrees()), (1, 2));
    assert!((report.nis - report.matches[0].d2).abs() < 1e-12);
}

#[test]
fn correlations_are_those_of_the_dense_matrix() {
    let slam = some_state();
    let (p, found) = (dense(&slam), slam.correlations());
    assert_eq!((found.n, found.landmarks.len()), (p.nrows(), 3));
    assert_eq!(found.first_landmark + 2 * found.landmarks.len(), found.n);
    for i in 0..found.n {
        for j in 0..found.n {
            let expect = p[(i, j)] / (p[(i, i)] * p[(j, j)]).sqrt();
            assert!((f64::from(found.coefficients[i * found.n + j]) - expect).abs() < 1e-6);
        }
    }
}

#[test]
fn bad_input_is_named_and_changes_nothing() {
    let mut slam = some_state();
    let before = (
        slam.pose,
        slam.landmarks.clone(),
        dense(&slam),
        slam.scans,
        slam.pending.len(),
    );
    let mut bad_cov = feature(0.2, 2.0);
    bad_cov.cov = Matrix2::new(1.0, 2.0, 2.0, 1.0);
    let mut bad_end = feature(0.2, 2.0);
    bad_end.ends[1].x = f64::NAN;
    for bad in [bad_cov, bad_end, feature(f64::NAN, 1.0)] {
        let error = slam.update(&[feature(0.2, 2.0), bad], &ONCE).unwrap_err();
        assert!(error.to_string().starts_with("feature 1: "), "{error}");
    }
    let nan = odometry(Pose2::new(f64::NAN, 0.0, 0.0), Matrix3::zeros());
    assert!(
        slam.predict(&nan)
            .unwrap_err()
            .to_string()
            .contains("motion is not finite")
    );
    let negative = odometry(Pose2::identity(), Matrix3::identity() * -1.0);
    assert!(slam.predict(&negative).is_err());
    let p = dense(&slam);
    let after = (slam.pose, slam.landmarks, p, slam.scans, slam.pending.len());
    assert_eq!(before, after);
}

#[test]
fn singular_innovation_is_told_and_changes_nothing() {
    let mut slam = some_state();
    let before = (slam.pose, slam.landmarks.clone(), dense(&slam));
    let columns = [(0, [1.0, 1.0]), (1, [0.0, 0.0])];
    let v = Vector2::new(0.1, 0.1);
    for z in [
        Matrix2::zeros(),
        Matrix2::new(1.0, 1.0, 1.0, 1.0),
        Matrix2::new(-1.0, 0.0, 0.0, 1.0),
        Matrix2::new(f64::NAN, 0.0, 0.0, 1.0),
    ] {
        assert!(!slam.absorb(&v, &z, &columns, &mut Gain::default()), "{z}");
    }
    let infinite = Vector2::new(f64::INFINITY, 0.0);
    let fine = Matrix2::identity();
    assert!(!slam.absorb(&infinite, &fine, &columns, &mut Gain::default()));
    assert_eq!(before, (slam.pose, slam.landmarks.clone(), dense(&slam)));
}

#[test]
fn lines_matched_together_outvote_a_nearer_wrong_wall() {
    // Walls 0.3 m apart one behind the other; then the robot moves 0.2 m towards them unnoticed.
    let walls = [1.0, 1.3, 1.6].map(|r| feature(0.0, r));
    let with = |method| {
        let mut config = plain();
        config.association.method = method;
        // The nearest one is taken, however near the next.
        config.association.ambiguity = 0.0;
        config.association.new_gate = 16.0;
        let mut slam = EkfSlam::new(config);
        for _ in 0..5 {
            slam.update(&walls, &ONCE).unwrap();
        }
        let unsure = Matrix3::from_diagonal(&Vector3::new(0.02, 1e-6, 1e-6));
        slam.predict(&odometry(Pose2::identity(), unsure)).unwrap();
        // The one that stands nearer to another wall's place than to its own comes first.
        let seen = [1.3, 1.0, 1.6].map(|r| feature(0.0, r - 0.2));
        let report = slam.update(&seen, &ONCE).unwrap();
        let ids: Vec<_> = report
            .matches
            .iter()
            .map(|m| (m.feature, m.landmark.0))
            .collect();
        (ids, slam.pose.x())
    };
    let (together, x) = with(AssociationMethod::Joint);
    assert_eq!(together, [(0, 1), (1, 0), (2, 2)]);
    assert!((x - 0.2).abs() < 0.02, "{x}");
    let (nearest, x) = with(AssociationMethod::Nearest);
    assert!(nearest.contains(&(0, 0)), "{nearest:?}");
    assert!((x - 0.2).abs() > 0.1, "{x}");
}

/// A run through known walls with sightings made straight from the truth.
struct Run {
    slam: EkfSlam,
    truth: Pose2,
    walls: Vec<Segment>,
    noise: OdometryNoise,
    rng: ChaCha8Rng,
    range: f64,
    /// Sum and number of NEES values of the pose.
    nees: (f64, u32),
    nis: (f64, usize),
    /// Which wall a landmark is, and how often another one was taken for it.
    wall_of: Vec<(LandmarkId, usize)>,
    wrong: u32,
}

const WIDTH: f64 = 0.2;

impl Run {
    fn new(config: EkfConfig, walls: &[Segment], start: Pose2, range: f64, seed: u64) -> Self {
        // Walls in the map frame, which starts at the robot.
        let to_map = start.inverse();
        let in_map = |w: &Segment| Segment::new(to_map * w.a, to_map * w.b);
        Self {
            slam: EkfSlam::new(config),
            truth: Pose2::identity(),
            walls: walls.iter().map(in_map).collect(),
            noise: OdometryNoise {
                per_metre: 2.5e-4,
                lateral_per_metre: 1e-4,
                heading_per_radian: 2e-3,
            },
            rng: ChaCha8Rng::seed_from_u64(seed),
            range,
            nees: (0.0, 0),
            nis: (0.0, 0),
            wall_of: vec![],
            wrong: 0,
        }
    }

    /// Drives to `goal` (map frame): a turn and a straight line, a scan every 0.1 m.
    fn go(&mut self, goal: Point2<f64>) {
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
        let parts = 1 + ((goal - self.truth.position()).norm() / 0.1) as usize;
        let advance = (goal - self.truth.position()).norm() / parts as f64;
        for _ in 0..parts {
            self.step(Tracks {
                left: advance,
                right: advance,
            });
        }
    }

    /// Moves by what the odometry says, disturbed as its covariance says, and takes a scan.
    fn step(&mut self, tracks: Tracks) {
        let motion = tracks.motion(WIDTH);
        let cov = tracks.covariance(WIDTH, &self.noise) + Matrix3::identity() * 1e-10;
        let l = cov.cholesky().unwrap().l();
        let rng = &mut self.rng;
        let e = l * Vector3::new(normal(rng), normal(rng), normal(rng));
        self.truth =
            self.truth * Pose2::new(motion.x() + e.x, motion.y() + e.y, motion.heading() + e.z);
        self.slam.predict(&odometry(motion, cov)).unwrap();
        let features = self.see();
        let report = self.slam.update(&features, &ONCE).unwrap();
        for &(feature, id) in &report.added {
            self.wall_of.push((id, features[feature].first_beam));
        }
        for m in &report.matches {
            let wall = features[m.feature].first_beam;
            let right = self.wall_of.contains(&(m.landmark, wall));
            self.wrong += u32::from(!right);
        }
        self.nis = (self.nis.0 + report.nis, self.nis.1 + report.matches.len());
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
                .filter(|p| p.coords.norm() < self.range && self.is_free(*p, &local))
                .collect();
            let (Some(a), Some(b)) = (visible.first(), visible.last()) else {
                continue;
            };
            let Some(line) = Line::through(*a, *b) else {
                continue;
            };
            if (b - a).norm() < 0.4 || line.r() < 0.1 {
                continue;
            }
            let (middle, length) = (nalgebra::center(a, b), (b - a).norm());
            // A regression over points every 0.1 m with σ = 0.02 m, moved from the middle of the wall to the origin.
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

    fn is_free(&self, point: Point2<f64>, own: &Segment) -> bool {
        let to_map = self.truth;
        let ray = point.coords * (1.0 - 1e-6);
        let sight = Segment::new(to_map.position(), to_map * Point2::from(ray));
        let own_in_map = Segment::new(to_map * own.a, to_map * own.b);
        self.walls.iter().all(|w| {
            let same = (w.a - own_in_map.a).norm() < 1e-9 && (w.b - own_in_map.b).norm() < 1e-9;
            same || !w.crosses(&sight)
        })
    }

    fn error(&self) -> (f64, f64) {
        let pose = self.slam.estimate().pose;
        (
            (pose.position() - self.truth.position()).norm(),
            wrap(pose.heading() - self.truth.heading()).abs(),
        )
    }
}

fn polygon(points: &[(f64, f64)]) -> Vec<Segment> {
    let next = points.iter().cycle().skip(1);
    let corner = |p: &(f64, f64)| Point2::new(p.0, p.1);
    points
        .iter()
        .zip(next)
        .map(|(a, b)| Segment::new(corner(a), corner(b)))
        .collect()
}

/// A ring corridor 2 m wide, centre line 2 * (w + h), around the origin of the world; with niches so that it can be told
/// where along it one is.
fn ring(w: f64, h: f64) -> Vec<Segment> {
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

fn drive_ring(config: EkfConfig, w: f64, h: f64, laps: usize, seed: u64) -> Run {
    let start = Pose2::new(-0.5 * w, -0.5 * h, 0.0);
    let mut run = Run::new(config, &ring(w, h), start, 8.0, seed);
    for _ in 0..laps {
        for (x, y) in [
            (0.3 * w, 0.0),
            (w, 0.0),
            (w, h),
            (0.4 * w, h),
            (0.0, h),
            (0.0, 0.0),
        ] {
            run.go(Point2::new(x, y));
        }
    }
    run
}

fn average_nees(config: EkfConfig, w: f64, h: f64, seeds: u64) -> (f64, f64) {
    let (mut nees, mut nis) = (0.0, 0.0);
    for seed in 0..seeds {
        let run = drive_ring(config, w, h, 1, seed);
        nees += run.nees.0 / f64::from(run.nees.1);
        nis += run.nis.0 / run.nis.1 as f64;
    }
    (nees / seeds as f64, nis / seeds as f64)
}

#[test]
fn average_nees_over_seeds_is_honest_with_first_estimates() {
    // 30 runs of one lap: the mean of a χ²(3) average over a run that is correlated all along has a standard deviation of
    // about 0.45 / sqrt(3) of 3.
    let config = plain();
    let first = EkfConfig {
        consistency: Consistency::FirstEstimates,
        ..config
    };
    let (nees, nis) = average_nees(first, 8.0, 6.0, 30);
    println!("first estimates: pose NEES {nees:.2}, NIS {nis:.2}");
    assert!((2.2..4.0).contains(&nees), "NEES {nees}, 3 is honest");
    assert!((1.7..2.2).contains(&nis), "NIS {nis}, 2 is honest");
}

#[test]
fn first_estimates_are_more_honest_than_the_textbook_on_a_long_loop() {
    // 64 m, heading noise of 6.5 degrees per root metre. Neither is honest here: the heading is lost by more than the linear model
    // bears before the loop closes. This asserts today's behaviour.
    let config = plain();
    let first = EkfConfig {
        consistency: Consistency::FirstEstimates,
        ..config
    };
    let (textbook, _) = average_nees(config, 20.0, 12.0, 12);
    let (first, _) = average_nees(first, 20.0, 12.0, 12);
    println!("64 m: textbook {textbook:.1}, first estimates {first:.1}");
    assert!(first < 0.5 * textbook && first < 30.0);
}

#[test]
fn loop_is_closed_on_the_walls_it_began_with() {
    for seed in 0..5 {
        let run = drive_ring(EkfConfig::default(), 8.0, 6.0, 2, seed);
        let (position, heading) = run.error();
        let confirmed = run.slam.landmarks().filter(|l| l.is_confirmed).count();
        println!(
            "seed {seed}: {position:.3} m, {:.2} deg, {confirmed} of {} walls",
            heading.to_degrees(),
            run.walls.len()
        );
        assert!(position < 0.1 && heading < 0.03);
        // A wall first seen in parts more than `max_gap` apart stays more than one landmark.
        assert!(confirmed <= run.walls.len() + run.walls.len() / 2);
        assert!(f64::from(run.wrong) < 0.01 * run.nis.1 as f64);
    }
}

#[test]
fn ring_corridor_of_sixty_metres_is_closed() {
    for seed in 0..5 {
        let run = drive_ring(EkfConfig::default(), 20.0, 12.0, 1, seed);
        let (position, heading) = run.error();
        let confirmed = run.slam.landmarks().filter(|l| l.is_confirmed).count();
        println!(
            "seed {seed}: {position:.3} m, {:.2} deg, {confirmed} of {} walls",
            heading.to_degrees(),
            run.walls.len()
        );
        // Odometry alone is off by metres; see the test of the NEES on the same loop for what is missing.
        assert!(position < 0.7 && heading < 0.1);
    }
}

#[test]
fn covariance_stays_positive_definite_over_a_long_run() {
    let run = drive_ring(EkfConfig::default(), 8.0, 6.0, 2, 11);
    let p = dense(&run.slam);
    assert!((&p - p.transpose()).norm() < 1e-300);
    assert!(p.cholesky().is_some());
}

#[test]
fn wall_through_the_origin_of_the_map_does_not_jump() {
    // The start lies on the line of a wall that begins 1 m further on: r changes its sign as the estimate breathes.
    let walls = vec![
        Segment::new(Point2::new(1.0, 0.0), Point2::new(4.0, 0.0)),
        Segment::new(Point2::new(5.0, -4.0), Point2::new(5.0, 4.0)),
    ];
    for (seed, side) in [(1, -1.0), (2, 1.0), (3, -1.0), (4, 1.0)] {
        let mut run = Run::new(plain(), &walls, Pose2::identity(), 8.0, seed);
        for (x, y) in [(1.0, 1.0), (3.0, 1.2), (1.5, 0.8), (3.5, 1.5), (0.5, 0.7)] {
            run.go(Point2::new(x, side * y));
        }
        let confirmed: Vec<_> = run.slam.landmarks().filter(|l| l.is_confirmed).collect();
        assert_eq!(confirmed.len(), 2, "{confirmed:?}");
        assert!(run.error().0 < 0.1);
        assert!(
            confirmed
                .iter()
                .all(|l| l.line.r() >= 0.0 && l.cov.cholesky().is_some())
        );
    }
}

#[test]
fn both_faces_of_a_thin_wall_are_two_landmarks() {
    let mut slam = EkfSlam::new(plain());
    slam.update(&[feature(0.0, 1.0)], &ONCE).unwrap();
    let exact = |x: f64| odometry(Pose2::new(x, 0.0, 0.0), Matrix3::identity() * 1e-6);
    slam.predict(&exact(2.0)).unwrap();
    let report = slam.update(&[feature(PI, 1.0)], &ONCE).unwrap();
    assert_eq!((report.matches.len(), report.added.len()), (0, 1));
}

#[test]
fn wall_seen_in_two_parts_across_a_door_is_two_landmarks_until_the_parts_meet() {
    let mut slam = EkfSlam::new(plain());
    let part = |from: f64, to: f64| LineFeature {
        ends: [Point2::new(1.0, from), Point2::new(1.0, to)],
        ..feature(0.0, 1.0)
    };
    slam.update(&[part(-2.0, -0.5)], &ONCE).unwrap();
    assert_eq!(
        slam.update(&[part(0.5, 2.0)], &ONCE).unwrap().added.len(),
        1
    );
    let report = slam
        .update(&[part(-2.0, -0.5), part(0.5, 2.0)], &ONCE)
        .unwrap();
    assert_eq!(report.matches.len(), 2);
    assert!(report.matches.iter().all(|m| m.d2 < CHI2_2DOF_99));
}

proptest! {
    #[test]
    fn ids_are_never_given_twice(seed in 0..200_u64) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut slam = EkfSlam::new(EkfConfig { patience: 1, ..plain() });
        let mut known = vec![];
        for _ in 0..30 {
            let report = slam.update(&[feature(rng.random_range(-3.0..3.0), rng.random_range(0.2..5.0))], &ONCE).unwrap();
            for (_, id) in &report.added {
                prop_assert!(!known.contains(id));
                known.push(*id);
            }
        }
    }
}
