//! The inside of the filter, flattened for the page: how errors are correlated, and why each line
//! was matched.

use serde::{Deserialize, Serialize};
use slamlab_core::association::{Flip, FlipOutcome};
use slamlab_core::estimation::{Considered, Correlations, Decision as CoreDecision, Explanation};
use slamlab_core::pilot::Stage;
use slamlab_core::session::Session;
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{
    Decision, FlipRow, Float32Array, Float64Array, Gate, Uint32Array, WebError, flat, typed,
};
use crate::run::WebRun;
use crate::view::map_from_robot_at_scan;

/// The line filter after the last scan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
#[tsify(missing_as_null)]
pub struct Inspection {
    /// Rows of the matrix that belong to the robot; two rows for each landmark follow: α and r, or
    /// x and y.
    pub robot_rows: u32,
    /// Landmarks in the order of their rows.
    pub landmarks: Uint32Array,
    /// Numbers of those that are points.
    pub points: Uint32Array,
    /// Of the points in the last scan: how many there were, how many were matched, and how many
    /// became landmarks.
    pub points_seen: [u32; 3],
    /// Correlation coefficients, row by row, -1 to 1; empty if they were not requested.
    pub coefficients: Float32Array,
    /// Lines of the scan.
    pub sightings: Vec<Sighting>,
    /// What was learned of the odometry errors.
    pub odometry: LearnedOdometry,
    /// Largest d² at which a line is matched.
    pub gate: f64,
    /// A line becomes a new landmark if its d² to every landmark is at least this.
    pub new_gate: f64,
}

/// A line of the scan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[tsify(missing_as_null)]
pub struct Sighting {
    /// x1 y1 x2 y2, map frame, m.
    pub ends: [f64; 4],
    /// What was decided about it.
    pub decision: Decision,
    /// The landmark that it was matched to, or became; null if it was not used.
    pub wall: Option<u32>,
    /// The landmarks that it was compared with, the likeliest first.
    pub candidates: Vec<Candidate>,
    /// What would flip its match, see `FLIP`: at another α, in both directions, then at another r;
    /// empty if it was not matched.
    pub flips: Float64Array,
}

/// A landmark that a line was compared with; see `Considered` of the core.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
#[expect(missing_docs, reason = "as in `Considered` of the core")]
pub struct Candidate {
    pub wall: u32,
    pub d2: f64,
    pub gap: f64,
    pub delta_alpha: f64,
    pub delta_r: f64,
    pub sigma_alpha: f64,
    pub sigma_r: f64,
    pub covariance: f64,
    pub gate: Gate,
}

/// What the filter learned of the odometry errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct LearnedOdometry {
    /// Turn during a drive that the odometry reports as straight, rad/m.
    pub curvature: f64,
    /// By what fraction a turn is larger than reported.
    pub turn_scale: f64,
    /// σ of the curvature, rad/m.
    pub curvature_sigma: f64,
    /// σ of the turn scale.
    pub turn_scale_sigma: f64,
}

#[wasm_bindgen]
impl WebRun {
    /// Why the last scan's lines were matched, and, with `matrix`, how errors are correlated;
    /// nothing for methods without a line map.
    ///
    /// # Errors    None that a page can cause.
    pub fn inspect(&self, matrix: bool) -> Result<Option<Ts<Inspection>>, WebError> {
        let inside = Inspection::of(self.session(), matrix);
        inside.as_ref().map(typed).transpose()
    }
}

impl Inspection {
    /// `None` for methods without a line map, and while the lines found are not yet compared with
    /// it. Without `matrix` the coefficients are left out, because they are many.
    pub(crate) fn of(session: &Session, matrix: bool) -> Option<Self> {
        if session.stages().awaits(Stage::Localise) {
            return None;
        }
        let slam = session.slam();
        let report = slam.view().update?;
        let correlations = if matrix {
            slam.view().correlations()?
        } else {
            Correlations::default()
        };
        let [learned, sigmas] = slam.view().odometry_errors?;
        let association = &slam.config().ekf.association;
        let map_from_robot = map_from_robot_at_scan(session);
        let sighting = |explanation: Explanation<'_>| {
            let feature = slam.view().features.get(explanation.feature)?;
            let [a, b] = feature.ends.map(|end| map_from_robot * end);
            Some(Sighting {
                ends: [a.x, a.y, b.x, b.y],
                decision: (&explanation.decision).into(),
                wall: match explanation.decision {
                    CoreDecision::Matched(id) | CoreDecision::Added(id) => Some(id.0),
                    CoreDecision::Rejected(_) => None,
                },
                candidates: explanation.candidates.iter().map(Into::into).collect(),
                flips: explanation
                    .flips(association)
                    .map_or_else(Float64Array::default, |all| flat(all.map(FlipRow::of))),
            })
        };
        Some(Self {
            robot_rows: correlations.first_landmark as u32,
            landmarks: correlations.landmarks.iter().map(|id| id.0).collect(),
            coefficients: correlations.coefficients.into(),
            points: (slam.view().point_landmarks.iter())
                .map(|point| point.id.0)
                .collect(),
            points_seen: [
                report.point_explanations().count(),
                report.point_matches.len(),
                report.points_added.len(),
            ]
            .map(|count| count as u32),
            sightings: report.explanations().filter_map(sighting).collect(),
            odometry: LearnedOdometry {
                curvature: learned.curvature,
                turn_scale: learned.turn_scale,
                curvature_sigma: sigmas.curvature,
                turn_scale_sigma: sigmas.turn_scale,
            },
            gate: association.gate,
            new_gate: association.new_gate,
        })
    }
}

impl FlipRow {
    /// NaN if nothing would flip it.
    fn of(flip: Option<Flip>) -> Self {
        let wall = |flip: &Flip| match flip.outcome {
            FlipOutcome::LeavesGate => f64::NAN,
            FlipOutcome::Ambiguous(wall) | FlipOutcome::TakenOver(wall) => wall as f64,
        };
        Self {
            shift: flip.map_or(f64::NAN, |flip| flip.shift),
            wall: flip.as_ref().map_or(f64::NAN, wall),
        }
    }
}

impl From<&Considered> for Candidate {
    fn from(c: &Considered) -> Self {
        let ([delta_alpha, delta_r], [sigma_alpha, sigma_r]) = (c.innovation, c.sigmas);
        Self {
            wall: c.landmark.0,
            d2: c.d2,
            gap: c.gap,
            delta_alpha,
            delta_r,
            sigma_alpha,
            sigma_r,
            covariance: c.covariance,
            gate: (&c.gate).into(),
        }
    }
}
