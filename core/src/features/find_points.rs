//! In: [`Points`] and the lines found in them. Out: [`PointFeature`]s.
//!
//! Corners and circles are looked for in runs of neighbours, as lines are; spikes at the borders
//! between runs; crossings among the lines. Round things have no corners.

use super::circle::{CircleConfig, circles};
use super::columns::{Columns, Noise};
use super::config::{LineConfig, LineError};
use super::corner::{CornerConfig, Row, corners};
use super::crossing::{CrossingConfig, crossings};
use super::feature::LineFeature;
use super::fit::check_beams;
use super::point::{PointFeature, PointKind};
use super::spike::{SpikeConfig, spikes};
use crate::bounds::{self, Bounds, NOT_NEGATIVE, OutOfBounds, check};
use crate::geom::Length;
use crate::points::{Beam, Points, Run, SpacingModel, segment};

/// Which points of a scan are looked for, and how.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointFeatureConfig {
    /// Corners, by a sliding window.
    pub corners: CornerConfig,
    /// Where lines cross.
    pub crossings: CrossingConfig,
    /// What stands out in range.
    pub spikes: SpikeConfig,
    /// What is round.
    pub circles: CircleConfig,
}

impl PointFeatureConfig {
    /// What [`CornerConfig::half_window`] may be: the windows of 11, 13 and 15 points.
    pub const HALF_WINDOW: Bounds = [5.0, 7.0];
    /// What angles of corners may be, rad.
    pub const CORNER_ANGLE: Bounds = [0.1, 3.1];
    /// What [`CornerConfig::back_checks`] may be.
    pub const BACK_CHECKS: Bounds = [0.0, 6.0];
    /// What [`CornerConfig::back_check_sigmas`] may be.
    pub const BACK_CHECK_SIGMAS: Bounds = [0.0, 10.0];
    /// What [`CornerConfig::max_stretch`] may be, spacings.
    pub const MAX_STRETCH: Bounds = [1.0, 20.0];
    /// What [`CornerConfig::leg_points`] may be.
    pub const LEG_POINTS: Bounds = [5.0, 200.0];
    /// What [`CrossingConfig::min_angle`] may be, rad.
    pub const CROSSING_ANGLE: Bounds = [0.05, 1.5];
    /// What [`CrossingConfig::reach`] may be, m.
    pub const REACH: Bounds = [0.0, 100.0];
    /// What [`SpikeConfig::threshold`] may be, m.
    pub const THRESHOLD: Bounds = [0.02, 10.0];
    /// What radii may be, m.
    pub const RADIUS: Bounds = [0.01, 2.0];
    /// What [`CircleConfig::cell`] may be, m.
    pub const CELL: Bounds = [0.005, 0.2];
    /// What [`CircleConfig::min_points`] may be.
    pub const CIRCLE_POINTS: Bounds = [4.0, 100.0];
    /// What [`CircleConfig::min_gain`] may be.
    pub const MIN_GAIN: Bounds = [0.0, 100.0];
    /// What [`CircleConfig::min_arc`] may be, rad.
    pub const MIN_ARC: Bounds = [0.1, 3.1];

    /// The same, limited to what can be a landmark: corners and circles. A crossing of two lines
    /// adds nothing to the lines, and where the silhouette of an object ends depends on the
    /// viewpoint.
    #[must_use]
    pub fn of_landmarks(mut self) -> Self {
        (self.crossings.is_on, self.spikes.is_on) = (false, false);
        self
    }

    /// Checks all settings.
    ///
    /// # Errors    [`OutOfBounds`] with the first one out of range.
    pub fn validate(&self) -> Result<(), OutOfBounds> {
        let (corners, circles) = (&self.corners, &self.circles);
        let count = |number: usize| number as f64;
        check(&[
            (
                "corners.half_window",
                count(corners.half_window),
                Self::HALF_WINDOW,
            ),
            ("corners.min_angle", corners.min_angle, Self::CORNER_ANGLE),
            ("corners.max_angle", corners.max_angle, Self::CORNER_ANGLE),
            (
                "corners.back_checks",
                count(corners.back_checks),
                Self::BACK_CHECKS,
            ),
            (
                "corners.back_check_sigmas",
                corners.back_check_sigmas,
                Self::BACK_CHECK_SIGMAS,
            ),
            (
                "corners.max_stretch",
                corners.max_stretch,
                Self::MAX_STRETCH,
            ),
            (
                "corners.leg_points",
                count(corners.leg_points),
                Self::LEG_POINTS,
            ),
            (
                "corners.max_alpha_sigma",
                corners.max_alpha_sigma,
                LineConfig::MAX_ALPHA_SIGMA,
            ),
            (
                "crossings.min_angle",
                self.crossings.min_angle,
                Self::CROSSING_ANGLE,
            ),
            ("crossings.reach", self.crossings.reach, Self::REACH),
            ("spikes.threshold", self.spikes.threshold, Self::THRESHOLD),
            (
                "spikes.max_step",
                self.spikes.max_step,
                LineConfig::MAX_STEP,
            ),
            ("circles.min_radius", circles.min_radius, Self::RADIUS),
            ("circles.max_radius", circles.max_radius, Self::RADIUS),
            ("circles.cell", circles.cell, Self::CELL),
            (
                "circles.min_points",
                count(circles.min_points),
                Self::CIRCLE_POINTS,
            ),
            ("circles.min_gain", circles.min_gain, Self::MIN_GAIN),
            ("circles.min_arc", circles.min_arc, Self::MIN_ARC),
            (
                "circles.max_chi2_sigmas",
                circles.max_chi2_sigmas,
                LineConfig::MAX_SIGMAS,
            ),
            (
                "circles.min_radius_sigmas",
                circles.min_radius_sigmas,
                LineConfig::MAX_SIGMAS,
            ),
        ])
    }
}

/// The points of a scan that can be found again: corners, then spikes, crossings and circles, each
/// in the order of the beams.
///
/// # Units    Robot frame, m. `lines` are those of the same scan; `line_config` says how neighbours
/// are grouped and how rough surfaces are.
/// # Errors   [`LineError`] for a beam with a number that is not finite.
/// # Source   Pilch 2016 §1.2.1 and §3.5.1; see the configuration of each.
pub fn find_points(
    points: &Points,
    lines: &[LineFeature],
    line_config: &LineConfig,
    config: &PointFeatureConfig,
) -> Result<Vec<PointFeature>, LineError> {
    check_beams(points.hits())?;
    bounds::check(&[("bearing sigma", points.bearing_sigma, NOT_NEGATIVE)])?;
    let mut runs = vec![];
    segment(points, &line_config.segmentation, &mut runs);
    let mut columns = Columns::default();
    let noise = Noise {
        bearing_sigma: points.bearing_sigma,
        surface_sigma: line_config.accept.surface_sigma,
    };
    let overlap = config.corners.overlap();
    let rows = load(points, &runs, overlap, noise, &mut columns);
    let (mut found, mut round) = (vec![], vec![]);
    if !columns.is_usable() {
        // So far away or so certain that sums overflow.
        return Ok(found);
    }
    if config.circles.is_on {
        let runs = rows.iter().map(|row| {
            let end = row.range.end - row.n_repeated;
            row.range.start..end
        });
        circles(&columns, runs, &config.circles, &mut round);
    }
    if config.corners.is_on {
        corners(&columns, points, &rows, &config.corners, &mut found);
        found.retain(|corner| !round.iter().any(|circle| lies_on(circle, corner)));
    }
    if config.spikes.is_on {
        spikes(points, &config.spikes, &mut found);
    }
    if config.crossings.is_on {
        crossings(lines, &config.crossings, &mut found);
    }
    found.append(&mut round);
    Ok(found)
}

/// Fills the columns with the runs one after the other; a ring continues with its first beams.
fn load(
    points: &Points,
    runs: &[Run],
    overlap: usize,
    noise: Noise,
    columns: &mut Columns,
) -> Vec<Row> {
    let n_beams = points.beams.len();
    let (mut ranges, mut rows, mut start) = (vec![], vec![], 0);
    for run in runs {
        // A short ring has no window that wraps around.
        let is_ring = run.len > overlap && is_ring(points, run);
        let n_repeated = if is_ring { overlap } else { 0 };
        let again = Run {
            first: run.first,
            len: n_repeated,
        };
        ranges.extend(run.ranges(n_beams).into_iter().chain(again.ranges(n_beams)));
        let end = start + run.len + n_repeated;
        rows.push(Row {
            range: start..end,
            n_repeated,
        });
        start = end;
    }
    columns.load(&points.beams, ranges, noise);
    rows
}

/// Whether a run goes all round, so its last beam and its first are neighbours: seen from one
/// place, and no farther apart in bearing than other neighbours.
fn is_ring(points: &Points, run: &Run) -> bool {
    let beams = &points.beams;
    let (Some(first), Some(last)) = (beams.first(), beams.last()) else {
        return false;
    };
    let ray = |beam: &Beam| beam.end_in_robot - beam.origin_in_robot;
    let step = libm::atan2(ray(last).perp(&ray(first)), ray(last).dot(&ray(first)));
    let stood = (last.origin_in_robot - first.origin_in_robot).length() < 1e-3;
    run.len == beams.len() && stood && step.abs() <= 2.0 * SpacingModel::of(points).slope
}

/// Whether a corner is on something round: within a window of a few points, a thin pillar is bent.
fn lies_on(circle: &PointFeature, corner: &PointFeature) -> bool {
    let PointKind::Circle { radius, .. } = circle.kind else {
        return false;
    };
    (corner.position - circle.position).length() <= 1.5 * radius
}

#[cfg(test)]
mod tests;
