//! From two clouds to the motion between them, by any method.
//!
//! In: a moving and a fixed [`Cloud`], and a start. Out: `fixed_from_moving` with covariance,
//! residual, overlap, iterations and a verdict.
//!
//! Each method is a file here and a row of [`CloudMethod`]. It only looks for the pose.
//! One judge rates the poses of all methods ([`JudgeConfig`]), by how the two clouds lie on each
//! other there.

mod advice;
mod basin;
mod bearings;
mod cloud;
mod correlation;
mod icp;
mod judge;
mod measured;
mod ndt;
mod neighbours;
mod rival;
mod surfaces;
#[cfg(test)]
mod tests;

pub use advice::{Advice, MeasuredCondition, MeasuredMethod, NEAR_SHIFT, NEAR_TURN, advise};
pub use basin::{Basin, BasinAxes, BasinCell, BasinConfig, BasinOutcome};
pub use cloud::{Cloud, CloudError};
pub use correlation::CorrelationConfig;
pub use icp::{Association, IcpConfig, Metric, RobustKernel, Selection, Weighting};
pub use judge::{JudgeConfig, Likeness, likeness};
pub use measured::{MEASURED, MEASURED_PAIRS};
pub use ndt::NdtConfig;

use nalgebra::Vector2;

use super::cpd::{CpdConfig, CpdKind, drift_watched};
use super::gmm::{GmmConfig, register_mixtures_watched};
use super::trace::{FromStart, Iteration, Watch};
use super::{Registration, Verdict};
use crate::geom::Pose2;

/// How the motion between two clouds is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CloudMethod {
    /// Iterated closest points.
    Icp(IcpConfig),
    /// Normal distributions transform.
    Ndt(NdtConfig),
    /// Coherent point drift.
    Cpd(CpdConfig),
    /// Least L2 distance of two Gaussian mixtures.
    Gmm(GmmConfig),
    /// Branch and bound in a window, then points to lines.
    Correlation(CorrelationConfig),
}

impl CloudMethod {
    /// How many there are.
    pub const COUNT: usize = 7;

    /// All methods by name, each with its best settings.
    #[must_use]
    pub fn all() -> [(&'static str, Self); Self::COUNT] {
        let icp = |metric| {
            Self::Icp(IcpConfig {
                metric,
                ..IcpConfig::default()
            })
        };
        [
            ("point-to-point", Self::Icp(IcpConfig::point_to_point())),
            ("point-to-line", icp(Metric::PointToLine)),
            ("surface-to-surface", icp(Metric::SurfaceToSurface)),
            ("ndt", Self::Ndt(NdtConfig::default())),
            ("cpd", Self::Cpd(CpdConfig::default())),
            ("gmm", Self::Gmm(GmmConfig::default())),
            (
                "correlation",
                Self::Correlation(CorrelationConfig::default()),
            ),
        ]
    }
}

/// Cosine of the angle between two surfaces; 1 where one is unknown. Surfaces of clouds without a
/// sensor have no sides.
#[inline(always)]
fn facing(a: Option<Vector2<f64>>, b: Option<Vector2<f64>>, is_sided: bool) -> f64 {
    let Some((a, b)) = a.zip(b) else {
        return 1.0;
    };
    let cosine = a.dot(&b);
    if is_sided { cosine } else { cosine.abs() }
}

/// Where a method ended.
#[derive(Clone, Copy, Debug)]
struct Found {
    pose: Pose2,
    iterations: usize,
    is_settled: bool,
}

impl Found {
    fn start(start: &Pose2) -> Self {
        Self {
            pose: *start,
            iterations: 0,
            is_settled: false,
        }
    }
}

/// The motion from `moving` to `fixed` by `method`, from `start`.
#[must_use]
pub fn register_clouds(
    moving: &Cloud,
    fixed: &Cloud,
    start: &Pose2,
    method: &CloudMethod,
    config: &JudgeConfig,
) -> Registration {
    register_watched(moving, fixed, start, method, config, &mut ())
}

/// [`register_clouds`] by ICP. A caller that needs no other method links none: the page's module
/// contains everything that it might call.
#[must_use]
pub fn register_clouds_by_icp(
    moving: &Cloud,
    fixed: &Cloud,
    start: &Pose2,
    icp: &IcpConfig,
    config: &JudgeConfig,
) -> Registration {
    register_by(moving, fixed, start, config, |start| {
        icp::run(moving, fixed, start, icp, &mut ())
    })
}

/// A registration, and how it came about.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// As returned by [`register_clouds`], to the bit.
    pub registration: Registration,
    /// Every iteration, from the start on. A correlation begins with its search, which is one
    /// iteration here and counted nowhere else.
    pub iterations: Vec<Iteration>,
}

/// [`register_clouds`], with a record of its iterations.
#[must_use]
pub fn trace_clouds(
    moving: &Cloud,
    fixed: &Cloud,
    start: &Pose2,
    method: &CloudMethod,
    config: &JudgeConfig,
) -> Trace {
    let mut iterations = vec![];
    let registration = register_watched(moving, fixed, start, method, config, &mut iterations);
    Trace {
        registration,
        iterations,
    }
}

fn register_watched(
    moving: &Cloud,
    fixed: &Cloud,
    start: &Pose2,
    method: &CloudMethod,
    config: &JudgeConfig,
    watch: &mut impl Watch,
) -> Registration {
    // One row for each method.
    register_by(moving, fixed, start, config, |start| match method {
        CloudMethod::Icp(config) => icp::run(moving, fixed, start, config, watch),
        CloudMethod::Ndt(config) => ndt::run(moving, fixed, start, config, watch),
        CloudMethod::Cpd(config) => by_drift(moving, fixed, start, config, watch),
        CloudMethod::Gmm(config) => by_mixtures(moving, fixed, start, config, watch),
        CloudMethod::Correlation(config) => correlation::run(moving, fixed, start, config, watch),
    })
}

fn register_by(
    moving: &Cloud,
    fixed: &Cloud,
    start: &Pose2,
    config: &JudgeConfig,
    run: impl FnOnce(&Pose2) -> Found,
) -> Registration {
    let start = if start.is_finite() {
        *start
    } else {
        Pose2::identity()
    };
    if moving.points().is_empty() || fixed.points().is_empty() {
        return judge::nothing(&Found::start(&start), moving.points().len());
    }
    let found = run(&start);
    let mut judged = judge::judge(moving, fixed, &found, config);
    if rival::is_ambiguous(moving, fixed, &start, &judged, config) {
        judged.registration.verdict = Verdict::Ambiguous;
    }
    judged.registration
}

/// Coherent point drift of the cloud, as it lies at the start.
fn by_drift(
    moving: &Cloud,
    fixed: &Cloud,
    start: &Pose2,
    config: &CpdConfig,
    watch: &mut impl Watch,
) -> Found {
    let config = CpdConfig {
        scales: false,
        ..*config
    };
    let moved: Vec<_> = moving.points().iter().map(|p| *start * *p).collect();
    let mut watch = FromStart {
        start: *start,
        watch,
    };
    let drifted = drift_watched(&moved, fixed.points(), CpdKind::Rigid, &config, &mut watch).ok();
    let found = drifted.and_then(|drift| Some((drift.map?.rigid(), drift)));
    found.map_or_else(
        || Found::start(start),
        |(by, drift)| Found {
            pose: by * *start,
            iterations: drift.iterations,
            is_settled: drift.is_settled,
        },
    )
}

fn by_mixtures(
    moving: &Cloud,
    fixed: &Cloud,
    start: &Pose2,
    config: &GmmConfig,
    watch: &mut impl Watch,
) -> Found {
    let config = GmmConfig {
        is_affine: false,
        ..*config
    };
    let fit = register_mixtures_watched(moving.points(), fixed.points(), start, &config, watch);
    fit.map_or_else(
        || Found::start(start),
        |fit| Found {
            pose: fit.map.rigid(),
            iterations: fit.iterations,
            is_settled: fit.is_settled,
        },
    )
}
