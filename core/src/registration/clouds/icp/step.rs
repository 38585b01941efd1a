//! From pairs to the motion that minimises their metric.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use super::super::super::gauss_newton::{MatchConfig, Sums, free_direction};
use super::super::super::trace::{Correspondence, Iteration};
use super::pairs::{Pair, Taker};
use super::{FEWEST_PAIRS, IcpConfig, Metric, RobustKernel, Weighting};
use crate::geom::{Length, Pose2};

/// Standard deviation of a point along its surface, relative to that across it, for surface to
/// surface.
const ALONG: f64 = 30.0;

impl Pair {
    /// From the line through the partner to the point, m.
    #[inline(always)]
    fn across(&self, normal: &Vector2<f64>) -> f64 {
        normal.dot(&self.off)
    }

    /// The information of the pair by both surfaces, and its distance weighted by it, m.
    #[inline(always)]
    fn between_surfaces(&self) -> Option<(Matrix2<f64>, f64)> {
        let [Some(normal), own] = self.normals else {
            return None;
        };
        let across = |n: &Vector2<f64>| n * n.transpose() * (1.0 / (ALONG * ALONG) - 1.0);
        let one = |n: &Vector2<f64>| Matrix2::identity() + across(n);
        let cov = one(&normal) + one(&own.unwrap_or(normal));
        let information = cov.try_inverse()?;
        let square = self.off.dot(&(information * self.off));
        Some((
            information,
            std::f64::consts::SQRT_2 / ALONG * square.sqrt(),
        ))
    }

    /// The distance that the metric minimises.
    fn residual(&self, metric: Metric) -> Option<f64> {
        match metric {
            Metric::PointToPoint => Some(self.off.length()),
            Metric::PointToLine => self.normals[0].map(|normal| self.across(&normal)),
            Metric::SurfaceToSurface => self.between_surfaces().map(|(_, residual)| residual),
        }
    }
}

/// The pairs of an iteration, with their weights.
pub(super) fn iteration(pairs: &[Pair], pose: &Pose2, scale: f64, config: &IcpConfig) -> Iteration {
    let correspondence = |pair: &Pair| {
        let residual = pair.residual(config.metric)?;
        let from = pose.position() + pair.arm;
        Some(Correspondence {
            from,
            to: from - pair.off,
            weight: weight(pair, residual, 1.0 / scale, config),
        })
    };
    Iteration::of(*pose, scale, pairs.iter().filter_map(correspondence))
}

/// The weight of a pair this far apart, m; `per_scale` is 1 over the scale of the kernel.
#[inline(always)]
fn weight(pair: &Pair, residual: f64, per_scale: f64, config: &IcpConfig) -> f64 {
    let parts = residual * per_scale;
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
        Weighting::ByDistance => 1.0 - pair.square.sqrt() * per_scale / config.max_scales,
    };
    by_kernel * by_weighting
}

/// The motion (x, y, θ) that minimises the metric of the pairs; `None` if there are too few.
pub(super) fn step(
    pairs: &[Pair],
    pose: &Pose2,
    scale: f64,
    config: &IcpConfig,
) -> Option<Vector3<f64>> {
    if pairs.len() < FEWEST_PAIRS {
        return None;
    }
    let per_scale = 1.0 / scale;
    let weight = |pair: &Pair, residual: f64| weight(pair, residual, per_scale, config);
    // One row for each metric.
    match config.metric {
        Metric::PointToPoint => rigid_fit(pairs, pose, weight),
        Metric::PointToLine => {
            let mut lines = Lines::at(scale, config);
            for pair in pairs {
                lines.add(pair);
            }
            lines.step()
        }
        Metric::SurfaceToSurface => gauss_newton(pairs, |pair, sums| {
            let Some((information, residual)) = pair.between_surfaces() else {
                return;
            };
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

/// The step to the minimum. A direction that the pairs hardly constrain is left unchanged.
fn least(sums: Sums) -> Option<Vector3<f64>> {
    let free = free_direction(&sums.hessian, MatchConfig::default().min_share);
    sums.step(free.as_ref())
}

/// Points to lines, summed as they are paired.
pub(super) struct Lines<'a> {
    sums: LineSums,
    count: usize,
    per_scale: f64,
    config: &'a IcpConfig,
}

impl<'a> Lines<'a> {
    /// No pairs yet, with a kernel of this scale, m.
    pub(super) fn at(scale: f64, config: &'a IcpConfig) -> Self {
        Self {
            sums: LineSums::default(),
            count: 0,
            per_scale: 1.0 / scale,
            config,
        }
    }

    #[inline(always)]
    fn add(&mut self, pair: &Pair) {
        let [Some(normal), _] = pair.normals else {
            return;
        };
        let residual = pair.across(&normal);
        let weight = weight(pair, residual, self.per_scale, self.config);
        self.sums.add(&normal, &pair.arm, residual, weight);
        self.count += 1;
    }

    /// The motion (x, y, θ) that minimises their distances; `None` if there are too few.
    pub(super) fn step(self) -> Option<Vector3<f64>> {
        if self.count < FEWEST_PAIRS {
            return None;
        }
        least(self.sums.into())
    }
}

impl Taker for Lines<'_> {
    #[inline(always)]
    fn take(&mut self, pair: Pair) {
        self.add(&pair);
    }
}

/// [`Sums`] of distances across lines, with each number held once, so they stay in registers.
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
    /// Adds a distance across a surface with this normal, of a point `arm` from the moving origin.
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
