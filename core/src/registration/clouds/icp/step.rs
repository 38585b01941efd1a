//! From pairs to the motion that makes their metric least.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use super::super::super::gauss_newton::{MatchConfig, Sums, free_direction};
use super::pairs::Pair;
use super::{IcpConfig, Metric, RobustKernel, Weighting};
use crate::geom::{Length, Pose2};

/// Standard deviation of a point along its surface beside that across it, for surface to surface.
const ALONG: f64 = 30.0;

/// The motion (x, y, θ) that makes the metric of the pairs least.
pub(super) fn step(
    pairs: &[Pair],
    pose: &Pose2,
    scale: f64,
    config: &IcpConfig,
) -> Option<Vector3<f64>> {
    let weight = |pair: &Pair, residual: f64| {
        let parts = residual / scale;
        let by_kernel = match config.kernel {
            RobustKernel::None => 1.0,
            RobustKernel::Huber => 1.0 / parts.abs().max(1.0),
            RobustKernel::Cauchy => 1.0 / (1.0 + parts * parts),
        };
        let by_weighting = match config.weighting {
            Weighting::Equal => 1.0,
            Weighting::ByNormals => match pair.normals {
                [Some(a), Some(b)] => a.dot(&b).abs(),
                _ => 0.5,
            },
            Weighting::ByDistance => 1.0 - pair.square.sqrt() / (config.max_scales * scale),
        };
        by_kernel * by_weighting
    };
    // One row for each metric.
    match config.metric {
        Metric::PointToPoint => rigid_fit(pairs, pose, weight),
        Metric::PointToLine => {
            let mut lines = LineSums::default();
            for pair in pairs {
                let [Some(normal), _] = pair.normals else {
                    continue;
                };
                let residual = normal.dot(&pair.off);
                lines.add(&normal, &pair.arm, residual, weight(pair, residual));
            }
            least(lines.into())
        }
        Metric::SurfaceToSurface => gauss_newton(pairs, |pair, sums| {
            let [Some(normal), own] = pair.normals else {
                return;
            };
            let across = |n: &Vector2<f64>| n * n.transpose() * (1.0 / (ALONG * ALONG) - 1.0);
            let one = |n: &Vector2<f64>| Matrix2::identity() + across(n);
            let cov = one(&normal) + one(&own.unwrap_or(normal));
            let Some(information) = cov.try_inverse() else {
                return;
            };
            let square = pair.off.dot(&(information * pair.off));
            let residual = std::f64::consts::SQRT_2 / ALONG * square.sqrt();
            sums.add_off(&information, &pair.arm, &pair.off, weight(pair, residual));
        }),
    }
}

/// The rigid motion between paired points in closed form: the angle is that of the cross
/// covariance's rotation, which is what its SVD gives in the plane (Umeyama 1991).
fn rigid_fit(
    pairs: &[Pair],
    pose: &Pose2,
    weight: impl Fn(&Pair, f64) -> f64,
) -> Option<Vector3<f64>> {
    let weighted = || {
        pairs
            .iter()
            .map(|pair| (pair, weight(pair, pair.off.length())))
    };
    let to = |pair: &Pair| pose.position().coords + pair.arm - pair.off;
    let (mut total, mut from_mean, mut to_mean) = (0.0, Vector2::zeros(), Vector2::zeros());
    for (pair, weight) in weighted() {
        total += weight;
        from_mean += pair.arm * weight;
        to_mean += to(pair) * weight;
    }
    if total <= 0.0 {
        return None;
    }
    (from_mean, to_mean) = (from_mean / total, to_mean / total);
    let (mut along, mut across) = (0.0, 0.0);
    for (pair, weight) in weighted() {
        let (a, b) = (pair.arm - from_mean, to(pair) - to_mean);
        along += weight * a.dot(&b);
        across += weight * a.perp(&b);
    }
    let turn = libm::atan2(across, along);
    let turned = Pose2::new(0.0, 0.0, turn).rotate(from_mean);
    Some((to_mean - turned - pose.position().coords).push(turn))
}

fn gauss_newton(pairs: &[Pair], mut add: impl FnMut(&Pair, &mut Sums)) -> Option<Vector3<f64>> {
    let mut sums = Sums::default();
    for pair in pairs {
        add(pair, &mut sums);
    }
    least(sums)
}

/// The step to the least; a direction of which the pairs say next to nothing is left as it is.
fn least(sums: Sums) -> Option<Vector3<f64>> {
    let free = free_direction(&sums.hessian, MatchConfig::default().min_share);
    sums.step(free.as_ref())
}

/// [`Sums`] of distances across lines, each number once: in registers, not in memory.
#[derive(Default)]
struct LineSums {
    xx: f64,
    xy: f64,
    yy: f64,
    xt: f64,
    yt: f64,
    tt: f64,
    x: f64,
    y: f64,
    t: f64,
}

impl LineSums {
    /// As [`Sums::add_across`].
    #[inline(always)]
    fn add(&mut self, normal: &Vector2<f64>, arm: &Vector2<f64>, residual: f64, weight: f64) {
        let (x, y) = (normal.x, normal.y);
        let t = y * arm.x - x * arm.y;
        let (wx, wy, wt) = (weight * x, weight * y, weight * t);
        self.xx += wx * x;
        self.xy += wx * y;
        self.yy += wy * y;
        self.xt += wx * t;
        self.yt += wy * t;
        self.tt += wt * t;
        self.x += wx * residual;
        self.y += wy * residual;
        self.t += wt * residual;
    }
}

impl From<LineSums> for Sums {
    fn from(sums: LineSums) -> Self {
        let LineSums {
            xx,
            xy,
            yy,
            xt,
            yt,
            tt,
            x,
            y,
            t,
        } = sums;
        Self {
            hessian: Matrix3::new(xx, xy, xt, xy, yy, yt, xt, yt, tt),
            gradient: Vector3::new(x, y, t),
            ..Self::default()
        }
    }
}
