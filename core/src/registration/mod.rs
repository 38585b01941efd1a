//! From two clouds, or a cloud and a map, to the motion between them.
//!
//! To find points in a [`Target`], call [`locate`]: it matches them by the [`RegistrationMethod`]
//! of its config, and searches if matching fails. A new registration method is a file here and a
//! row of the table below.
//!
//! To register two clouds, call [`register_clouds`], which has all methods behind one interface and
//! one judge of their results, or [`trace_clouds`] to see each iteration; [`register_affine`],
//! [`drift`] and [`register_mixtures`] find maps that are not rigid.

mod affine;
mod clouds;
mod correlative;
mod cpd;
mod gauss_newton;
mod gauss_transform;
mod gmm;
mod locate;
mod modes;
mod outcome;
mod point_to_line;
mod point_to_point;
mod rolling;
mod target;
mod trace;

pub use affine::{AffineError, AffineFit, AffineMap, AffineMethod, register_affine};
pub use clouds::{
    Advice, Association, Basin, BasinAxes, BasinCell, BasinConfig, BasinOutcome, Cloud, CloudError,
    CloudMethod, CorrelationConfig, IcpConfig, JudgeConfig, Likeness, MEASURED, MEASURED_PAIRS,
    MeasuredCondition, MeasuredMethod, Metric, NEAR_SHIFT, NEAR_TURN, NdtConfig, RobustKernel,
    Selection, Trace, Weighting, advise, likeness, register_clouds, register_clouds_by_icp,
    trace_clouds,
};
pub use correlative::{Candidate, SearchWindow, search, search_turned};
pub use cpd::{CpdConfig, CpdError, CpdKind, Drift, MOST_NON_RIGID, drift};
pub use gauss_newton::MatchConfig;
pub use gauss_transform::{TRANSFORM_ERROR, TransformMethod, gauss_transform};
pub use gmm::{GmmConfig, GmmFit, register_mixtures};
pub use locate::{
    LocateConfig, Located, SearchConfig, SearchedPrior, locate, search_and_match,
    search_turned_and_match,
};
pub use modes::{Modes, ModesConfig, modes};
pub use outcome::{Prior, Registration, Verdict};
pub use rolling::{MotionError, Part, Rolling, RollingPrior, register_rolling};
pub use target::Target;
pub use trace::{Correspondence, Iteration};

use nalgebra::Point2;

use crate::geom::Pose2;
use crate::points::OrientedPoint;

/// Larger coordinates of a cloud are not measurements, m; their higher moments overflow.
const FARTHEST: f64 = 1e6;

/// The first point that is not finite, or farther away than [`FARTHEST`].
fn first_too_far(points: &[Point2<f64>]) -> Option<usize> {
    // NaN compares false with everything.
    let is_near = |p: &Point2<f64>| p.x.abs() <= FARTHEST && p.y.abs() <= FARTHEST;
    points.iter().position(|p| !is_near(p))
}

/// How a pose that is nearly right is refined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RegistrationMethod {
    /// Distances of points to lines (Censi 2008).
    #[default]
    PointToLine,
    /// Distances of points to points (Besl & McKay 1992).
    PointToPoint,
}

impl RegistrationMethod {
    /// All methods, with their names in settings and for people.
    pub const ALL: [(&'static str, Self, &'static str); 2] = [
        ("point-to-line", Self::PointToLine, "points to lines"),
        ("point-to-point", Self::PointToPoint, "points to points"),
    ];
}

/// Matches `points` to `target`, from `start`, by the method of `config`.
#[must_use]
pub fn register<T: Target>(
    points: &[OrientedPoint],
    target: &T,
    start: &Pose2,
    prior: &Prior,
    config: &MatchConfig,
) -> Registration {
    gauss_newton::register(points, start, prior, config, |pose, kernel| {
        sums(points, target, pose, kernel, config)
    })
}

/// What the method computes from all pairs at `pose`, with a kernel of this scale, m.
fn sums<T: Target>(
    points: &[OrientedPoint],
    target: &T,
    pose: &Pose2,
    kernel: f64,
    config: &MatchConfig,
) -> gauss_newton::Sums {
    let pairs = gauss_newton::pairs(points, target, pose, config);
    // One row for each method.
    match config.method {
        RegistrationMethod::PointToLine => point_to_line::sums(pairs, kernel, config),
        RegistrationMethod::PointToPoint => point_to_point::sums(pairs, kernel, config),
    }
}
