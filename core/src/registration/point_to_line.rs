//! Points matched to the surfaces of a map, from a start that is nearly right.
//!
//! In: oriented points, a [`SurfelMap`], a start and what is believed of it. Out: a [`Registration`].
//!
//! 1. Each point looks up the surfel nearest to where it would lie. It takes part if the two surfaces look the same way.
//! 2. Its residual is the distance to the surfel's line; far ones are doubted by a Cauchy kernel whose scale shrinks
//!    from iteration to iteration, so that a bad start is pulled in and outliers end without a say.
//! 3. Gauss-Newton on (x, y, θ), with the prior as one more residual, until the step is nothing.
//! 4. A direction of which the points say next to nothing is the prior's alone, in each iteration: what little they seem to say
//!    along a corridor comes of noisy normals, and pulls towards where the map was seen from.
//! 5. The covariance is the inverse of what the points and the prior say. The verdict looks at the points alone: a
//!    corridor says nothing about the way along it, and that is told, not hidden.
//!
//! Source: Censi (2008), "An ICP variant using a point-to-line metric"; the Cauchy kernel's scale is in metres. Step 4: Zhang,
//! Kaess & Singh (2016), "On degeneracy of optimization-based state estimation problems".

use nalgebra::{Matrix2, Matrix3, SymmetricEigen, Vector2, Vector3};

use crate::geom::{Pose2, PoseEstimate, symmetrize, wrap};
use crate::map::SurfelMap;
use crate::points::OrientedPoint;

/// How to match.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatchConfig {
    /// Most iterations. Default 20.
    pub max_iterations: usize,
    /// Scale of the kernel at the first iteration, m. Default 0.15.
    pub first_kernel: f64,
    /// Scale of the kernel at the end, m. Default 0.03; larger listens to more, smaller to less.
    pub last_kernel: f64,
    /// Standard deviation of a residual, m: a point's noise and the map's. Default 0.03.
    pub sigma: f64,
    /// Points that say one thing, since neighbours err alike. Default 3; larger gives larger covariances.
    pub redundancy: f64,
    /// Cosine of the largest angle between surfaces that may be the same. Default 0.7.
    pub min_cosine: f64,
    /// Fewer matched points than this are too few. Default 12.
    pub min_points: usize,
    /// Where fewer of the points than this part lie on the map, the points' say is lowered with the square of the part:
    /// what little matches there may match by chance. Default 0.5.
    pub full_overlap: f64,
    /// A direction is degenerate where it gets less than this part of the points' say. Default 0.02.
    pub min_share: f64,
}

impl Default for MatchConfig {
    fn default() -> Self {
        Self {
            max_iterations: 20,
            first_kernel: 0.15,
            last_kernel: 0.03,
            sigma: 0.03,
            redundancy: 3.0,
            min_cosine: 0.7,
            min_points: 12,
            full_overlap: 0.5,
            min_share: 0.02,
        }
    }
}

/// What is believed of the pose before the points are asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// The believed pose.
    pub pose: Pose2,
    /// Inverse of its covariance of (x, y, θ), in the frame of the pose's coordinates.
    pub information: Matrix3<f64>,
}

/// What a match is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// The points fix the pose.
    Converged,
    /// They do not say how far along this direction (unit vector in the map frame); there the prior stands.
    Degenerate {
        /// The direction.
        direction: Vector2<f64>,
    },
    /// Too few points lie on a surface.
    TooFewPoints {
        /// How many did.
        found: usize,
    },
    /// The last step was still large.
    NotConverged,
}

/// The result of a match.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Registration {
    /// `map_from_points`, with the covariance of points and prior together.
    pub estimate: PoseEstimate,
    /// What the points alone say: the inverse of their covariance; nothing along a degenerate direction.
    pub information: Matrix3<f64>,
    /// Points within two of the kernel's scales from their surface.
    pub inliers: usize,
    /// Inliers as a part of all points.
    pub overlap: f64,
    /// Root of the mean squared residual of the inliers, m.
    pub residual: f64,
    /// Iterations taken.
    pub iterations: usize,
    /// What it is worth.
    pub verdict: Verdict,
}

/// The sums of one iteration.
struct Sums {
    hessian: Matrix3<f64>,
    gradient: Vector3<f64>,
    matched: usize,
    inliers: usize,
    squares: f64,
}

/// Matches `points` to `map`, from `start`.
#[must_use]
pub fn match_to_surfels(
    points: &[OrientedPoint],
    map: &SurfelMap,
    start: &Pose2,
    prior: &Prior,
    config: &MatchConfig,
) -> Registration {
    let full = 1.0 / (config.sigma * config.sigma * config.redundancy);
    let weight_of = |sums: &Sums| {
        let overlap = sums.inliers as f64 / points.len().max(1) as f64;
        let part = (overlap / config.full_overlap).min(1.0);
        full * part * part
    };
    let mut pose = *start;
    let mut kernel = config.first_kernel.max(config.last_kernel);
    let mut settled = false;
    let mut iterations = 0;
    while iterations < config.max_iterations && !settled {
        iterations += 1;
        let mut sums = accumulate(points, map, &pose, kernel, config);
        if sums.matched < config.min_points {
            break;
        }
        if let Some(free) = free_direction(&sums.hessian, config.min_share) {
            sums.silence(&free);
        }
        let weight = weight_of(&sums);
        let off = Vector3::new(
            pose.x() - prior.pose.x(),
            pose.y() - prior.pose.y(),
            wrap(pose.heading() - prior.pose.heading()),
        );
        let hessian = sums.hessian * weight + prior.information;
        let gradient = sums.gradient * weight + prior.information * off;
        let Some(cholesky) = hessian.cholesky() else {
            break;
        };
        let step = -cholesky.solve(&gradient);
        pose = Pose2::new(
            pose.x() + step.x,
            pose.y() + step.y,
            pose.heading() + step.z,
        );
        let at_end = kernel <= config.last_kernel;
        settled = at_end && step.x.abs().max(step.y.abs()) < 2e-4 && step.z.abs() < 1e-4;
        kernel = (0.5 * kernel).max(config.last_kernel);
    }
    let mut sums = accumulate(points, map, &pose, config.last_kernel, config);
    let free = free_direction(&sums.hessian, config.min_share);
    if let Some(free) = &free {
        sums.silence(free);
    }
    let information = sums.hessian * weight_of(&sums);
    let verdict = if sums.inliers < config.min_points {
        Verdict::TooFewPoints {
            found: sums.inliers,
        }
    } else if let Some(free) = free {
        Verdict::Degenerate {
            direction: free.xy().normalize(),
        }
    } else if settled {
        Verdict::Converged
    } else {
        Verdict::NotConverged
    };
    let mut cov = (information + prior.information)
        .try_inverse()
        .unwrap_or_else(|| Matrix3::from_diagonal_element(1e6));
    symmetrize(&mut cov);
    Registration {
        estimate: PoseEstimate { pose, cov },
        information,
        inliers: sums.inliers,
        overlap: sums.inliers as f64 / points.len().max(1) as f64,
        residual: (sums.squares / sums.inliers.max(1) as f64).sqrt(),
        iterations,
        verdict,
    }
}

fn accumulate(
    points: &[OrientedPoint],
    map: &SurfelMap,
    pose: &Pose2,
    kernel: f64,
    config: &MatchConfig,
) -> Sums {
    let mut sums = Sums {
        hessian: Matrix3::zeros(),
        gradient: Vector3::zeros(),
        matched: 0,
        inliers: 0,
        squares: 0.0,
    };
    let (cos, sin) = pose.cos_sin();
    let scale = 1.0 / (kernel * kernel);
    let limit = 2.0 * kernel;
    let (mut xx, mut xy, mut yy, mut xt, mut yt, mut tt) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    let (mut gx, mut gy, mut gt) = (0.0, 0.0, 0.0);
    for point in points {
        let (px, py) = (point.position.x, point.position.y);
        let arm = Vector2::new(cos * px - sin * py, sin * px + cos * py);
        let place = nalgebra::Point2::new(arm.x + pose.x(), arm.y + pose.y());
        let Some(surfel) = map.nearest(place) else {
            continue;
        };
        let normal = surfel.normal;
        let (nx, ny) = (point.normal.x, point.normal.y);
        let cosine = normal.x * (cos * nx - sin * ny) + normal.y * (sin * nx + cos * ny);
        if cosine < config.min_cosine {
            continue;
        }
        let residual = normal.dot(&(place - surfel.position));
        let weight = 1.0 / (1.0 + residual * residual * scale);
        // The residual's derivative by the turn: the normal on the arm turned by +90°.
        let by_turn = normal.y * arm.x - normal.x * arm.y;
        let (wx, wy, wt) = (weight * normal.x, weight * normal.y, weight * by_turn);
        xx += wx * normal.x;
        xy += wx * normal.y;
        yy += wy * normal.y;
        xt += wx * by_turn;
        yt += wy * by_turn;
        tt += wt * by_turn;
        gx += wx * residual;
        gy += wy * residual;
        gt += wt * residual;
        sums.matched += 1;
        if residual.abs() < limit {
            sums.inliers += 1;
            sums.squares += residual * residual;
        }
    }
    sums.hessian = Matrix3::new(xx, xy, xt, xy, yy, yt, xt, yt, tt);
    sums.gradient = Vector3::new(gx, gy, gt);
    sums
}

impl Sums {
    /// Takes away all that is said along the motion `free` (x, y, θ), and nothing of what is said of the rest.
    fn silence(&mut self, free: &Vector3<f64>) {
        let push = self.hessian * free;
        let said = free.dot(&push);
        // Nothing to take away where nothing is said at all.
        if said > 0.0 {
            self.gradient -= push * (free.dot(&self.gradient) / said);
            self.hessian -= push * push.transpose() / said;
        }
    }
}

/// The motion (x, y, θ; its shift of length 1) of which the points say next to nothing, the heading following as it likes best.
fn free_direction(hessian: &Matrix3<f64>, min_share: f64) -> Option<Vector3<f64>> {
    let total = hessian[(0, 0)] + hessian[(1, 1)];
    let cross = Vector2::new(hessian[(0, 2)], hessian[(1, 2)]);
    let turn = hessian[(2, 2)].max(1e-12);
    let shift: Matrix2<f64> =
        hessian.fixed_view::<2, 2>(0, 0).into_owned() - cross * cross.transpose() / turn;
    let eigen = SymmetricEigen::new(shift);
    let (least, _) = eigen.eigenvalues.argmin();
    let direction: Vector2<f64> = eigen.eigenvectors.column(least).into_owned();
    (eigen.eigenvalues[least] < min_share * total)
        .then(|| direction.push(-cross.dot(&direction) / turn))
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;
    use proptest::prelude::*;

    use super::*;
    use crate::map::SurfelConfig;

    type Corner = (f64, f64);

    /// Points every 5 cm along segments, normals to the left of their direction.
    fn walls(segments: &[(Corner, Corner)]) -> Vec<OrientedPoint> {
        let mut points = vec![];
        for &((ax, ay), (bx, by)) in segments {
            let (a, b) = (Point2::new(ax, ay), Point2::new(bx, by));
            let along = (b - a) / (b - a).norm();
            let normal = Vector2::new(-along.y, along.x);
            let n = ((b - a).norm() / 0.05) as usize;
            points.extend((0..n).map(|i| OrientedPoint {
                position: a + along * (i as f64 * 0.05 + 0.01),
                normal,
            }));
        }
        points
    }

    fn room() -> Vec<OrientedPoint> {
        walls(&[
            ((-3.0, -2.0), (3.0, -2.0)),
            ((3.0, -2.0), (3.0, 2.0)),
            ((3.0, 2.0), (-1.0, 2.0)),
            ((-3.0, 1.0), (-3.0, -2.0)),
        ])
    }

    fn seen_from(points: &[OrientedPoint], pose: &Pose2) -> Vec<OrientedPoint> {
        let back = pose.inverse();
        points
            .iter()
            .map(|p| OrientedPoint {
                position: back * p.position,
                normal: back.rotate(p.normal),
            })
            .collect()
    }

    fn map_of(points: &[OrientedPoint]) -> SurfelMap {
        let mut map = SurfelMap::new(SurfelConfig {
            half_side: 16.0,
            ..SurfelConfig::default()
        });
        map.insert(points.iter().copied());
        map
    }

    fn weak(pose: Pose2) -> Prior {
        Prior {
            pose,
            information: Matrix3::from_diagonal_element(1e-3),
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]
        #[test]
        fn comes_back_to_the_true_pose(
            x in -0.2..0.2_f64, y in -0.2..0.2_f64, t in -0.1..0.1_f64, h in -3.1..3.1_f64,
        ) {
            let truth = Pose2::new(0.5, -0.3, h);
            let start = Pose2::new(0.5 + x, -0.3 + y, h + t);
            let found = match_to_surfels(&seen_from(&room(), &truth), &map_of(&room()), &start, &weak(start), &MatchConfig::default());
            prop_assert_eq!(found.verdict, Verdict::Converged);
            prop_assert!((found.estimate.pose.position() - truth.position()).norm() < 2e-3, "{:?}", found);
            prop_assert!(wrap(found.estimate.pose.heading() - h).abs() < 1e-3);
            prop_assert!(found.overlap > 0.95 && found.estimate.cov.cholesky().is_some());
        }

        #[test]
        fn hessian_and_gradient_are_those_of_central_differences(
            x in -0.05..0.05_f64, y in -0.05..0.05_f64, t in -0.02..0.02_f64,
        ) {
            // With a kernel so wide that it says nothing, the cost is half the sum of squares.
            let (points, map, config) = (room(), map_of(&room()), MatchConfig::default());
            let cost = |dx: f64, dy: f64, dt: f64| {
                let pose = Pose2::new(x + dx, y + dy, t + dt);
                0.5 * accumulate(&points, &map, &pose, 1e6, &config).squares
            };
            let sums = accumulate(&points, &map, &Pose2::new(x, y, t), 1e6, &config);
            let h = 1e-7;
            let numeric = Vector3::new(
                cost(h, 0.0, 0.0) - cost(-h, 0.0, 0.0), cost(0.0, h, 0.0) - cost(0.0, -h, 0.0), cost(0.0, 0.0, h) - cost(0.0, 0.0, -h),
            ) / (2.0 * h);
            // A point that changes its cell between the two sides makes a jump; few starts meet one.
            prop_assume!((numeric - sums.gradient).norm() < 10.0);
            prop_assert!((numeric - sums.gradient).norm() < 1e-3 * (1.0 + sums.gradient.norm()), "{} {}", numeric, sums.gradient);
        }
    }

    #[test]
    fn corridor_reports_the_direction_along_it_and_keeps_the_prior_there() {
        let corridor = walls(&[((-5.0, -1.0), (5.0, -1.0)), ((5.0, 1.0), (-5.0, 1.0))]);
        let start = Pose2::new(0.15, 0.1, 0.03);
        let prior = Prior {
            pose: start,
            information: Matrix3::from_diagonal_element(1.0),
        };
        let found = match_to_surfels(
            &corridor,
            &map_of(&corridor),
            &start,
            &prior,
            &MatchConfig::default(),
        );
        let Verdict::Degenerate { direction } = found.verdict else {
            panic!("{found:?}")
        };
        assert!(direction.y.abs() < 0.01, "{direction}");
        let pose = found.estimate.pose;
        assert!(
            (pose.x() - 0.15).abs() < 0.01 && pose.y().abs() < 1e-3,
            "{pose:?}"
        );
        assert!(found.estimate.cov[(0, 0)] > 0.5 && found.estimate.cov[(1, 1)] < 1e-4);
    }

    #[test]
    fn noisy_normals_along_a_corridor_do_not_pull_the_pose_off_a_weak_prior() {
        use rand::{RngExt, SeedableRng};
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        // Normals 0.1 rad off: they seem to tell the way along the walls with a hundredth of the points' say.
        let mut crooked = || {
            let mut points = walls(&[((-5.0, -1.0), (5.0, -1.0)), ((5.0, 1.0), (-5.0, 1.0))]);
            for point in &mut points {
                let turn = Pose2::new(0.0, 0.0, rng.random_range(-0.17..0.17));
                point.normal = turn.rotate(point.normal);
            }
            points
        };
        let (map, points) = (map_of(&crooked()), crooked());
        let start = Pose2::new(0.15, 0.05, 0.02);
        let found = match_to_surfels(&points, &map, &start, &weak(start), &MatchConfig::default());
        let Verdict::Degenerate { direction } = found.verdict else {
            panic!("{found:?}")
        };
        assert!(direction.x.abs() > 0.99, "{direction}");
        // A prior of 30 m keeps the way along the corridor to the millimetre, and its own doubt of it.
        let pose = found.estimate.pose;
        assert!((pose.x() - 0.15).abs() < 5e-3, "{pose:?}");
        assert!(pose.y().abs() < 0.01 && pose.heading().abs() < 2e-3);
        assert!(found.estimate.cov[(0, 0)] > 900.0, "{:?}", found.estimate);
    }

    #[test]
    fn silencing_a_motion_leaves_what_is_said_of_the_others() {
        let free = Vector3::new(0.6, 0.8, -0.3);
        let hessian = Matrix3::new(4.0, 1.0, 0.5, 1.0, 3.0, -0.2, 0.5, -0.2, 2.0);
        let mut sums = Sums {
            hessian,
            gradient: Vector3::new(1.0, -2.0, 0.5),
            matched: 0,
            inliers: 0,
            squares: 0.0,
        };
        let gradient = sums.gradient;
        sums.silence(&free);
        assert!((sums.hessian * free).norm() < 1e-12 && sums.gradient.dot(&free).abs() < 1e-12);
        // Where the way along it is free, what is left is the least that the cost can be: the Schur complement.
        for other in [Vector3::x(), Vector3::new(0.2, -1.0, 0.7)] {
            let cost = |t: f64| {
                let step = other + free * t;
                0.5 * step.dot(&(hessian * step)) + gradient.dot(&step)
            };
            let best = -free.dot(&(hessian * other + gradient)) / free.dot(&(hessian * free));
            let at_rest = -free.dot(&gradient) / free.dot(&(hessian * free));
            let least = cost(best) - (0.5 * at_rest * free.dot(&gradient));
            let left = 0.5 * other.dot(&(sums.hessian * other)) + sums.gradient.dot(&other);
            assert!((left - least).abs() < 1e-12, "{left} {least}");
        }
    }

    #[test]
    fn too_few_points_are_told_and_the_start_is_kept() {
        let points = room();
        let start = Pose2::new(0.0, 0.0, 0.0);
        let found = match_to_surfels(
            &points[..5],
            &map_of(&points),
            &start,
            &weak(start),
            &MatchConfig::default(),
        );
        assert_eq!(found.verdict, Verdict::TooFewPoints { found: 5 });
        assert!((found.estimate.pose.position() - start.position()).norm() < 1e-12);
    }

    #[test]
    fn covariance_is_that_of_a_monte_carlo_run_when_points_err_alone() {
        use rand::{RngExt, SeedableRng};
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(4);
        let (points, map) = (room(), map_of(&room()));
        let sigma = 0.01;
        let config = MatchConfig {
            sigma,
            redundancy: 1.0,
            last_kernel: 0.5,
            first_kernel: 0.5,
            ..MatchConfig::default()
        };
        let (mut sum, runs) = (Matrix3::zeros(), 300);
        let mut cov = Matrix3::zeros();
        for _ in 0..runs {
            let noisy: Vec<_> = points
                .iter()
                .map(|p| {
                    let (u, v): (f64, f64) = (rng.random(), rng.random());
                    let normal =
                        (-2.0 * libm::log(1.0 - u)).sqrt() * libm::cos(std::f64::consts::TAU * v);
                    OrientedPoint {
                        position: p.position + p.normal * (sigma * normal),
                        ..*p
                    }
                })
                .collect();
            let start = Pose2::identity();
            let found = match_to_surfels(&noisy, &map, &start, &weak(start), &config);
            let p = found.estimate.pose;
            let e = Vector3::new(p.x(), p.y(), p.heading());
            sum += e * e.transpose();
            cov = found.estimate.cov;
        }
        let sample = sum / f64::from(runs);
        for i in 0..3 {
            let ratio = sample[(i, i)] / cov[(i, i)];
            // 300 runs: the ratio has a standard deviation of 8 %.
            assert!((0.7..1.35).contains(&ratio), "axis {i}: {ratio}");
        }
    }
}
