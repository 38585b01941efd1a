//! What a person sees of a map, flattened for the page.

use nalgebra::{Matrix2, Point2, Vector2};
use serde::{Deserialize, Serialize};
use slamlab_core::estimation::{Localisation, PoseQuality};
use slamlab_core::features::{PointFeature, PointKind};
use slamlab_core::geom::{Pose2, Segment};
use slamlab_core::map::{CellState, Grid};
use slamlab_core::pilot::Stage;
use slamlab_core::plan::Path;
use slamlab_core::points::{Beam, Points};
use slamlab_core::session::Session;
use slamlab_core::slam::Slam;
use slamlab_core::tracking::Track;
use tsify::Tsify;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{
    BeamRow, Float32Array, Float64Array, HypothesisRow, Int32Array, LineRow, PointName, PointRow,
    TrackMotionName, TrackRow, Typed, Uint8Array, WebError, flat, typed,
};
use crate::run::WebRun;

/// Maximum numbers of hypotheses and of particles that the page is given at once.
const MOST_HYPOTHESES: usize = 64;
const MOST_PARTICLES: usize = 500;
/// Cells along one side of a block of the grid.
const BLOCK_CELLS: u32 = 64;

/// Blocks of the grid that changed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct GridChange {
    /// Side of a cell, m.
    pub resolution: f64,
    /// Cells along one side of a block.
    pub block_cells: u32,
    /// Column and row of each block, in blocks.
    pub index: Int32Array,
    /// Cells of each block in rows from the lower left: 0 unknown, else 1 + 254 p with the
    /// probability p of an obstacle; for a field 1 + the value in steps, limited to 255.
    pub cells: Uint8Array,
}

#[wasm_bindgen]
impl WebRun {
    /// The map since `revision` of `generation`, and the last scan.
    ///
    /// # Errors    None that a page can cause.
    pub fn view(&self, generation: u32, revision: f64) -> Typed<SlamView> {
        typed(&SlamView::since(self.session(), generation, revision))
    }

    /// Pairs of walls that the last scan showed to be the same: the one that stays and the one that
    /// is removed.
    #[must_use]
    pub fn merged(&self) -> Vec<u32> {
        let update = self.slam().view().update;
        let merged = update.into_iter().flat_map(|report| &report.merged);
        merged.flat_map(|m| [m.kept.0, m.gone.0]).collect()
    }

    /// Corners, spikes, crossings and circles of the last scan, see `POINT`. Costs more than
    /// reading what is there.
    ///
    /// # Errors    None that a page can cause.
    pub fn points_found(&self) -> Result<Vec<f32>, WebError> {
        let session = self.session();
        if session.stages().awaits(Stage::Lines) {
            return Ok(vec![]);
        }
        let map_from_robot = map_from_robot_at_scan(session);
        let found = session.slam().point_features()?;
        Ok(flat(
            found
                .iter()
                .map(|point| PointRow::of(point, &map_from_robot)),
        ))
    }

    /// Tracks of moving objects, see `TRACK`.
    #[must_use]
    pub fn tracks(&self) -> Vec<f32> {
        let map_from_robot = map_from_robot_at_scan(self.session());
        let tracks = self.slam().tracks().iter();
        flat(tracks.map(|track| TrackRow::of(track, &map_from_robot)))
    }

    /// x y of the hits of the last scan that were kept out of pose and map, m.
    #[must_use]
    pub fn taken_out(&self) -> Vec<f32> {
        let map_from_robot = map_from_robot_at_scan(self.session());
        let points = self.slam().taken_out().iter();
        points.flat_map(|at| pair(map_from_robot * *at)).collect()
    }

    /// x1 y1 x2 y2 of the walls of the prior map, m; empty for other methods.
    #[must_use]
    pub fn prior_map_walls(&self) -> Vec<f32> {
        let slam = self.slam();
        let faces = match slam.view().prior_map_fit {
            Some(_) => slam.config().prior_map.faces.as_slice(),
            None => &[],
        };
        let ends = faces.iter().flat_map(|face| [face.a, face.b]);
        ends.flat_map(pair).collect()
    }

    /// Poses that the robot may have, see `HYPOTHESIS`, the likeliest first; empty if it is
    /// localised, and for methods with a single pose.
    #[must_use]
    pub fn hypotheses(&self) -> Vec<f32> {
        let view = self.slam().view();
        let is_known = |quality: PoseQuality| quality.localisation == Localisation::Localised;
        if view.pose_quality.is_none_or(is_known) {
            return vec![];
        }
        flat(view.hypotheses.iter().take(MOST_HYPOTHESES).map(|each| {
            let pose = each.estimate.pose;
            HypothesisRow {
                x: pose.x() as f32,
                y: pose.y() as f32,
                heading: pose.heading() as f32,
                weight: each.weight as f32,
            }
        }))
    }

    /// x y of the particles behind the hypotheses, at most some hundreds; none if the robot is
    /// localised in a prior map. Particles with maps are always given.
    #[must_use]
    pub fn particles(&self) -> Vec<f32> {
        let view = self.slam().view();
        let is_known = |quality: PoseQuality| quality.localisation == Localisation::Localised;
        if view.prior_map_fit.is_some() && view.pose_quality.is_none_or(is_known) {
            return vec![];
        }
        let particles = view.particles;
        let every = particles.len().div_ceil(MOST_PARTICLES).max(1);
        let places = particles.iter().step_by(every).map(|p| p.pose.position());
        places.flat_map(pair).collect()
    }

    /// Area known to be free, m². Costs more than a step.
    #[must_use]
    pub fn known_area(&self) -> f64 {
        let grid = self.slam().grid();
        let cells = grid.blocks_since(0).flat_map(|(_, cells)| cells);
        let free = cells.filter(|&&l| grid.state_of(l) == CellState::Free);
        free.count() as f64 * grid.resolution() * grid.resolution()
    }
}

impl GridChange {
    /// A whole grid; nothing if it is empty.
    pub(crate) fn whole(grid: &Grid) -> Option<Self> {
        Self::since(grid, 0)
    }

    /// What changed in a grid since a revision.
    pub(crate) fn since(grid: &Grid, revision: u64) -> Option<Self> {
        let (mut index, mut cells) = (vec![], vec![]);
        for (block, log_odds) in grid.blocks_since(revision) {
            index.extend([block.col, block.row]);
            cells.extend(log_odds.iter().map(|&l| tone(l)));
        }
        Self::of(grid.resolution(), index, cells)
    }

    /// Nothing if no block changed.
    pub(crate) fn of(resolution: f64, index: Vec<i32>, cells: Vec<u8>) -> Option<Self> {
        (!index.is_empty()).then(|| Self {
            resolution,
            block_cells: BLOCK_CELLS,
            index: index.into(),
            cells: cells.into(),
        })
    }
}

/// What a person sees of [`Slam`], for any source: map frame, m and rad.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
#[tsify(missing_as_null)]
pub struct SlamView {
    /// Changes when the grid was redrawn and old blocks are invalid.
    pub generation: u32,
    /// Pass it with `generation` to the next call to get what changed since.
    pub revision: f64,
    /// The grid where it changed.
    pub grid: Option<GridChange>,
    /// x y of the hits of the last scan.
    pub scan: Float32Array,
    /// How each of these was read, see `BEAM`.
    pub beams: Float32Array,
    /// x1 y1 x2 y2 of the lines found in the last scan.
    pub found: Float32Array,
    /// The walls of the line map, see `LINE`; none while the present ones are not to be shown yet.
    pub lines: Option<Float64Array>,
}

impl SlamView {
    /// The view for a reader who knows the grid up to `revision` of `generation`. In the cycle
    /// stage by stage, changes appear when their stage is shown.
    pub(crate) fn since(session: &Session, generation: u32, revision: f64) -> Self {
        let slam = session.slam();
        let (layers, now) = (slam.layers(), slam.shown_version() as u32);
        let known = if now == generation {
            revision as u64
        } else {
            0
        };
        let mut view = Self {
            generation: now,
            revision: layers.revision() as f64,
            grid: None,
            scan: hits(session),
            beams: beams(slam),
            found: found(session),
            lines: (!session.stages().awaits(Stage::Localise)).then(|| lines(slam)),
        };
        if session.stages().awaits(Stage::Map) {
            (view.generation, view.revision) = (generation, revision);
            return view;
        }
        let (mut index, mut cells) = (vec![], vec![]);
        for (block, log_odds) in layers.blocks_since(known) {
            index.extend([block.col, block.row]);
            cells.extend(log_odds.iter().map(|&l| tone(l)));
        }
        view.grid = GridChange::of(slam.grid().resolution(), index, cells);
        view
    }
}

/// A probability as one byte in which "unknown" differs from "as likely as not".
fn tone(log_odds: f32) -> u8 {
    if log_odds == 0.0 {
        return 0;
    }
    let p = 1.0 / (1.0 + (-log_odds).exp());
    1 + (254.0 * p).round() as u8
}

fn hits(session: &Session) -> Float32Array {
    let map_from_robot = map_from_robot_at_scan(session);
    let ends = hits_of(session.slam()).map(|beam| pair(map_from_robot * beam.end_in_robot));
    ends.flatten().collect()
}

fn beams(slam: &Slam) -> Float32Array {
    flat(hits_of(slam).map(|beam| BeamRow {
        range: beam.range as f32,
        sigma: beam.sigma as f32,
        quality: beam.quality.map_or(f32::NAN, f32::from),
        number: beam.beam_idx as f32,
    }))
}

pub(crate) fn hits_of(slam: &Slam) -> impl Iterator<Item = &Beam> {
    slam.points().into_iter().flat_map(Points::hits)
}

pub(crate) fn map_from_robot_at_scan(session: &Session) -> Pose2 {
    session.shown_estimate().pose * session.slam().motion_since_scan().inverse()
}

fn found(session: &Session) -> Float32Array {
    if session.stages().awaits(Stage::Lines) {
        return Float32Array::default();
    }
    let map_from_robot = map_from_robot_at_scan(session);
    let ends = session
        .slam()
        .view()
        .features
        .iter()
        .flat_map(|line| line.ends);
    ends.flat_map(|end| pair(map_from_robot * end)).collect()
}

impl PointRow {
    fn of(point: &PointFeature, map_from_robot: &Pose2) -> Self {
        let at = *map_from_robot * point.position;
        let cov = turned(&point.cov, map_from_robot);
        Self {
            x: at.x as f32,
            y: at.y as f32,
            var_x: cov[(0, 0)] as f32,
            cov_xy: cov[(0, 1)] as f32,
            var_y: cov[(1, 1)] as f32,
            kind: f32::from(PointName::from(&point.kind) as u8),
            radius: match point.kind {
                PointKind::Circle { radius, .. } => radius as f32,
                _ => 0.0,
            },
            confidence: point.confidence as f32,
        }
    }
}

impl TrackRow {
    fn of(track: &Track, map_from_robot: &Pose2) -> Self {
        let at = *map_from_robot * track.position;
        let velocity = map_from_robot.rotate(track.velocity);
        let cov = turned(
            &track.cov.fixed_view::<2, 2>(0, 0).into_owned(),
            map_from_robot,
        );
        Self {
            id: track.id as f32,
            x: at.x as f32,
            y: at.y as f32,
            velocity_x: velocity.x as f32,
            velocity_y: velocity.y as f32,
            var_x: cov[(0, 0)] as f32,
            cov_xy: cov[(0, 1)] as f32,
            var_y: cov[(1, 1)] as f32,
            motion: f32::from(TrackMotionName::from(&track.motion) as u8),
            seen: flag(track.is_seen) as f32,
        }
    }
}

/// A covariance in the robot frame, rotated into the map frame.
fn turned(cov: &Matrix2<f64>, map_from_robot: &Pose2) -> Matrix2<f64> {
    // Columns of the rotation.
    let axes = [Vector2::x(), Vector2::y()].map(|axis| map_from_robot.rotate(axis));
    let turn = Matrix2::from_columns(&axes);
    turn * cov * turn.transpose()
}

/// A boolean as a number.
pub(crate) fn flag(yes: bool) -> f64 {
    f64::from(u8::from(yes))
}

fn lines(slam: &Slam) -> Float64Array {
    let is_matched = |id| slam.view().matches().iter().any(|m| m.landmark == id);
    flat(slam.view().landmarks.iter().map(|wall| {
        let [a, b] = wall.ends;
        LineRow {
            alpha: wall.line.alpha(),
            r: wall.line.r(),
            var_alpha: wall.cov[(0, 0)],
            cov_alpha_r: wall.cov[(0, 1)],
            var_r: wall.cov[(1, 1)],
            x1: a.x,
            y1: a.y,
            x2: b.x,
            y2: b.y,
            matched: flag(is_matched(wall.id)),
            confirmed: flag(wall.is_confirmed),
            id: f64::from(wall.id.0),
        }
    }))
}

/// x1 y1 x2 y2 of each segment, moved into the map frame.
pub(crate) fn segments<'a>(
    segments: impl Iterator<Item = &'a Segment>,
    map_from: &Pose2,
) -> Vec<f32> {
    segments
        .flat_map(|s| [pair(*map_from * s.a), pair(*map_from * s.b)])
        .flatten()
        .collect()
}

/// x y of the corners of a path.
pub(crate) fn corners(path: Option<&Path>) -> Vec<f32> {
    path.map_or(vec![], |path| polyline(&path.points))
}

/// x y of each point.
pub(crate) fn polyline(points: &[Point2<f64>]) -> Vec<f32> {
    points.iter().copied().flat_map(pair).collect()
}

fn pair(point: Point2<f64>) -> [f32; 2] {
    [point.x as f32, point.y as f32]
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix4, Vector4};
    use slamlab_core::tracking::TrackMotion;

    #[test]
    fn covariance_of_a_point_turns_with_the_robot() {
        let point = PointFeature {
            position: Point2::new(1.0, 0.0),
            cov: Matrix2::new(4.0, 1.0, 1.0, 9.0),
            kind: PointKind::Circle {
                radius: 0.25,
                var_radius: 0.01,
            },
            confidence: 0.75,
            beams: [0, 3],
        };
        let quarter = Pose2::new(2.0, 3.0, std::f64::consts::FRAC_PI_2);
        let row: [f32; PointRow::STRIDE] = PointRow::of(&point, &quarter).into();
        // x becomes y, y becomes -x.
        let expected = [2.0, 4.0, 9.0, -1.0, 4.0, 3.0, 0.25, 0.75];
        assert!(
            row.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6),
            "{row:?}"
        );
    }

    #[test]
    fn a_track_turns_with_the_robot() {
        let track = Track {
            id: 7,
            position: Point2::new(1.0, 0.0),
            velocity: Vector2::new(0.5, 0.25),
            cov: Matrix4::from_diagonal(&Vector4::new(4.0, 9.0, 1.0, 1.0)),
            motion: TrackMotion::Paused,
            is_seen: true,
        };
        let quarter = Pose2::new(2.0, 3.0, std::f64::consts::FRAC_PI_2);
        let row: [f32; TrackRow::STRIDE] = TrackRow::of(&track, &quarter).into();
        let expected = [7.0, 2.0, 4.0, -0.25, 0.5, 9.0, 0.0, 4.0, 2.0, 1.0];
        assert!(
            row.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6),
            "{row:?}"
        );
    }

    #[test]
    fn nothing_known_is_not_as_likely_as_not() {
        assert_eq!(tone(0.0), 0);
        assert_eq!(tone(1e-6), 128);
        assert_eq!(tone(-30.0), 1);
        assert_eq!(tone(30.0), 255);
    }
}
