use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::estimation::OdometryErrors;
use crate::geom::{Line, Pose2, PoseEstimate, sides_of};
use crate::points::fixture::normal;
use crate::robot::{Odometry, OdometryNoise, Stamp, Tracks};

const WIDTH: f64 = 0.2;

/// A room of 5 x 4 m, seen from inside.
fn room() -> Vec<Segment> {
    let corners = [(0.0, 0.0), (5.0, 0.0), (5.0, 4.0), (0.0, 4.0)].map(|(x, y)| Point2::new(x, y));
    sides_of(&corners)
        .map(|(a, b)| Segment::new(*a, *b))
        .collect()
}

/// A known line as it is seen from `pose`, with errors drawn from `cov`.
fn sighting(
    known: &Segment,
    pose: &Pose2,
    cov: &Matrix2<f64>,
    rng: &mut ChaCha8Rng,
) -> LineFeature {
    let ends = [known.a, known.b].map(|end| pose.inverse() * end);
    let line = Line::through(ends[0], ends[1]).unwrap();
    let e = cov.cholesky().unwrap().l() * Vector2::new(normal(rng), normal(rng));
    let line = Line::new(line.alpha() + e.x, line.r() + e.y);
    LineFeature {
        line,
        cov: *cov,
        ends: ends.map(|end| line.project(end)),
        seen_from_origin_side: true,
        first_beam: 0,
        last_beam: 20,
        n_points: 21,
        chi2: 19.0,
        by_heading: [Vector2::zeros(); 2],
    }
}

fn at(pose: Pose2, sigmas: [f64; 3]) -> PoseEstimate {
    let variances = Vector3::from(sigmas.map(|s| s * s));
    PoseEstimate {
        pose,
        cov: Matrix3::from_diagonal(&variances),
    }
}

/// Starts in the room, with exact odometry.
fn begun(start: &PoseEstimate, association: AssociationConfig) -> (LineLocaliser, RobotState) {
    let state = RobotState::starting(start, &OdometryErrors::default()).unwrap();
    (LineLocaliser::new(&room(), association).unwrap(), state)
}

#[test]
fn faces_look_to_both_sides() {
    let wall = Segment::new(Point2::new(1.0, 0.0), Point2::new(1.0, 2.0));
    let [left, right] =
        [wall, Segment::new(wall.b, wall.a)].map(|face| Face::left_of(&face).unwrap());
    // Seen from x < 1 the normal into the wall points along +x.
    assert!(left.alpha.abs() < 1e-12 && (left.r - 1.0).abs() < 1e-12);
    assert!(
        (right.alpha.abs() - std::f64::consts::PI).abs() < 1e-12 && (right.r + 1.0).abs() < 1e-12
    );
    assert!(Face::left_of(&Segment::new(wall.a, wall.a)).is_none());
}

#[test]
fn information_of_a_standing_robot_adds_up() {
    // Heading 0, one wall ahead: x and θ are measured independently, y is not. By hand: 1/σ² =
    // 1/σ₀² + n/σ_z².
    let truth = Pose2::new(2.0, 1.5, 0.0);
    let start = at(truth, [0.1, 0.2, 0.05]);
    let (localiser, mut state) = begun(&start, AssociationConfig::default());
    let cov = Matrix2::new(4e-4, 0.0, 0.0, 9e-4);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let ahead = room()[1];
    for n in 1..=20 {
        let seen = sighting(&ahead, &truth, &cov, &mut rng);
        let matches = localiser.update(&mut state, &[seen]).unwrap();
        assert_eq!(matches, [(0, 1)]);
        let found = state.estimate().cov;
        let expect = |prior: f64, measured: f64| 1.0 / (1.0 / prior + f64::from(n) / measured);
        assert!((found[(0, 0)] - expect(0.01, 9e-4)).abs() < 1e-12);
        assert!((found[(1, 1)] - 0.04).abs() < 1e-12);
        assert!((found[(2, 2)] - expect(0.0025, 4e-4)).abs() < 1e-12);
    }
}

#[test]
fn average_nees_lies_in_the_band_of_the_mean() {
    // 1 000 runs around the room; the pose at the end is χ² with 3 degrees of freedom, its mean
    // within 3 ± 1.96 √(6/1000). The gate is wide: one of 99 % would drop the sightings that reveal
    // large errors, and the mean over all runs would be 3.4.
    let runs = 1000;
    let wide = AssociationConfig {
        gate: 40.0,
        new_gate: 60.0,
        ..AssociationConfig::default()
    };
    let noise = OdometryNoise {
        per_metre: 2.5e-4,
        lateral_per_metre: 1e-4,
        heading_per_radian: 2e-3,
    };
    let cov = Matrix2::new(1e-4, 2e-5, 2e-5, 2e-4);
    let (mut sum, mut matched, mut wrong) = (0.0, 0, 0);
    for seed in 0..runs {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let start = at(Pose2::new(1.0, 1.0, 0.0), [0.05, 0.05, 0.03]);
        let mut truth = Pose2::new(
            1.0 + 0.05 * normal(&mut rng),
            1.0 + 0.05 * normal(&mut rng),
            0.03 * normal(&mut rng),
        );
        let (localiser, mut state) = begun(&start, wide);
        for step in 0..60 {
            let turn = if step % 15 > 11 { 0.05 } else { 0.0 };
            let tracks = Tracks {
                left: 0.1 - turn,
                right: 0.1 + turn,
            };
            let (motion, q) = (tracks.motion(WIDTH), tracks.covariance(WIDTH, &noise));
            let q = q + Matrix3::identity() * 1e-10;
            let e = q.cholesky().unwrap().l()
                * Vector3::new(normal(&mut rng), normal(&mut rng), normal(&mut rng));
            truth = truth * Pose2::new(motion.x() + e.x, motion.y() + e.y, motion.heading() + e.z);
            state
                .predict(&Odometry {
                    from: Stamp(0),
                    to: Stamp(1),
                    motion,
                    cov: q,
                })
                .unwrap();
            // Two of the walls at a time.
            let seen = [step % 4, (step + 1) % 4];
            let features = seen.map(|wall| sighting(&room()[wall], &truth, &cov, &mut rng));
            for (feature, line) in localiser.update(&mut state, &features).unwrap() {
                matched += 1;
                wrong += usize::from(line != seen[feature]);
            }
        }
        sum += state.estimate().nees(&truth).unwrap();
    }
    let mean = sum / runs as f64;
    println!("NEES {mean:.3}, {matched} matched, {wrong} wrong");
    assert!(
        (mean - 3.0).abs() < 1.96 * (6.0 / runs as f64).sqrt(),
        "{mean}"
    );
    assert!(wrong == 0 && matched > 90 * runs as usize);
}

#[test]
fn bad_input_is_named_and_changes_nothing() {
    let truth = Pose2::new(2.0, 1.5, 0.0);
    let start = at(truth, [0.1, 0.2, 0.05]);
    let (localiser, mut state) = begun(&start, AssociationConfig::default());
    let before = state.estimate();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut bad = sighting(&room()[0], &truth, &(Matrix2::identity() * 1e-4), &mut rng);
    bad.cov = Matrix2::new(1.0, 2.0, 2.0, 1.0);
    let error = localiser
        .update(&mut state, &[bad])
        .unwrap_err()
        .to_string();
    assert!(error.starts_with("feature 0: "), "{error}");
    let mut odometry = Odometry::standing(Stamp(0));
    odometry.motion = Pose2::new(f64::NAN, 0.0, 0.0);
    assert!(state.predict(&odometry).is_err());
    assert_eq!(state.estimate(), before);
}
