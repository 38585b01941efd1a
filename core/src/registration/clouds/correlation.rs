//! The global optimum within a window, by branch and bound, then refined by matching points to
//! lines.

use super::super::trace::{Iteration, Watch};
use super::super::{SearchWindow, search};
use super::icp::{self, IcpConfig};
use super::{Cloud, Found};
use crate::bounds::config;
use crate::geom::Pose2;
use crate::map::LikelihoodPyramid;

config! {
    /// Where and how finely is searched.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct CorrelationConfig {
        /// The window about the start. Default 1.5 m and 1 rad to either side.
        pub window: SearchWindow = SearchWindow { shift: 1.5, turn: 1.0 },
        /// Side of a cell and standard deviation of a surface in it, m. Default 0.05; larger is
        /// quicker and coarser.
        pub cell: f64 = 0.05,
        /// Levels of the pyramid. Default 6: the coarsest bounds 32 cells at once.
        pub levels: usize = 6,
        /// Least mean likelihood of a pose, 0 to 1. Default 0.05.
        pub min_score: f64 = 0.05,
        /// Of more points than this only some, evenly chosen, are searched with. Default 200.
        pub most_points: usize = 200,
    }
}

/// Searches about `start`.
pub(super) fn run(
    moving: &Cloud,
    fixed: &Cloud,
    start: &Pose2,
    config: &CorrelationConfig,
    watch: &mut impl Watch,
) -> Found {
    watch.see(|| Iteration::of(*start, config.window.shift, []));
    let places = fixed.points().iter().copied();
    let pyramid = LikelihoodPyramid::new(places, config.cell, config.cell, config.levels);
    let stride = moving
        .points()
        .len()
        .div_ceil(config.most_points.max(1))
        .max(1);
    let points: Vec<_> = moving.points().iter().copied().step_by(stride).collect();
    let best = pyramid
        .and_then(|pyramid| search(&points, &pyramid, start, &config.window, config.min_score));
    let Some(best) = best else {
        return Found::start(start);
    };
    // From less than a cell away from the true pose.
    let fine = IcpConfig {
        first_scale: 2.0 * config.cell,
        ..IcpConfig::default()
    };
    icp::run(moving, fixed, &best.pose, &fine, watch)
}
