//! Iterated closest points, in all its forms.
//!
//! In: two clouds and a start. Out: the pose at which pairs of nearest points lie best on each
//! other.
//!
//! 1. Points of the moving cloud are **selected**.
//! 2. Each is **paired** with a point of the fixed cloud.
//! 3. Pairs are **rejected**, or given less weight the farther they are apart. The distance allowed
//!    shrinks from iteration to iteration: a bad start is pulled in, and outliers lose their
//!    weight.
//! 4. The motion that minimises the **metric** of all pairs is taken: for point to point in closed
//!    form (the SVD of the cross covariance, which in the plane is one angle), otherwise by a
//!    Gauss-Newton step.
//!
//! Sources: Besl & McKay (1992), "A method for registration of 3-D shapes"; Censi (2008), "An ICP
//! variant using a point-to-line metric"; Segal, Haehnel & Thrun (2009), "Generalized-ICP"; the
//! stages as in Rusinkiewicz & Levoy (2001), "Efficient variants of the ICP algorithm".

mod options;
mod pairs;
mod select;
mod step;

pub use self::options::{Association, IcpConfig, Metric, RobustKernel, Selection, Weighting};

use self::pairs::{Pairing, Search, Seeker};
use self::step::Lines;
use super::super::trace::Watch;
use super::{Cloud, Found};
use crate::geom::{Length, Pose2};
use crate::lanes;

/// With fewer pairs than this, the pose is unknown.
const FEWEST_PAIRS: usize = 3;
/// A scale that exceeds the last one by less than this factor is set to the last one.
const ALMOST: f64 = 1.2;

/// Runs ICP from `start`.
pub(super) fn run<W: Watch>(
    moving: &Cloud,
    fixed: &Cloud,
    start: &Pose2,
    config: &IcpConfig,
    watch: &mut W,
) -> Found {
    let search = Search::of(moving, fixed, config);
    let selected = select::select(moving, config.selection).into_iter();
    let mut points: Vec<_> = selected
        .map(|index| Seeker {
            index,
            partner: None,
        })
        .collect();
    let mut found = Found::start(start);
    let mut scale = config.first_scale.max(config.last_scale);
    // Points to lines are summed as they are paired, unless all pairs are needed at once.
    let is_summed = config.metric == Metric::PointToLine && config.kept >= 1.0 && !W::LOOKS;
    let mut pairs = Vec::with_capacity(if is_summed { 0 } else { points.len() });
    while found.iterations < config.max_iterations && !found.is_settled {
        found.iterations += 1;
        let stride = if scale > config.last_scale {
            config.coarse_stride.max(1)
        } else {
            1
        };
        let pose = found.pose;
        let (search, points) = (&search, points.as_mut_slice());
        let step = if is_summed {
            let mut lines = Lines::at(scale, config);
            lanes::run(Pairing {
                search,
                points,
                stride,
                pose: &pose,
                scale,
                taker: &mut lines,
            });
            lines.step()
        } else {
            pairs.clear();
            lanes::run(Pairing {
                search,
                points,
                stride,
                pose: &pose,
                scale,
                taker: &mut pairs,
            });
            if config.kept < 1.0 {
                pairs::trim(&mut pairs, config.kept);
            }
            watch.see(|| step::iteration(&pairs, &pose, scale, config));
            step::step(&pairs, &pose, scale, config)
        };
        let Some(step) = step else {
            break;
        };
        found.pose = pose.plus(&step);
        let is_small =
            step.xy().length() < config.shift_tolerance && step.z.abs() < config.turn_tolerance;
        found.is_settled = is_small && scale <= config.last_scale;
        scale = shrunk(scale, config);
    }
    found
}

/// The scale of the next iteration; one that is almost the last one becomes the last one.
fn shrunk(scale: f64, config: &IcpConfig) -> f64 {
    let next = config.shrink * scale;
    if next < ALMOST * config.last_scale {
        config.last_scale
    } else {
        next
    }
}
