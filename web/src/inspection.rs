//! The filter's inside, flattened for the page: how errors hang together, and why each line was
//! matched.

use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use slamlab_core::estimation::{Considered, Correlations, Explanation, Verdict as CoreVerdict};
use slamlab_core::pilot::Stage;
use slamlab_core::session::Session;
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{
    CandidateRow, Float32Array, Float64Array, Gate, SightingRow, Uint32Array, Verdict, WebError,
    flat, typed,
};
use crate::run::WebRun;
use crate::view::map_from_robot_at_scan;

/// The line filter after the last scan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct Inspection {
    /// Rows of the matrix that belong to the robot; two for each landmark follow, α and r.
    pub robot_rows: u32,
    /// Landmarks in the order of their rows.
    pub landmarks: Uint32Array,
    /// Correlation coefficients, row by row, -1 to 1; empty where they were not asked for.
    pub coefficients: Float32Array,
    /// Lines of the scan, see `SIGHTING`.
    pub sightings: Float64Array,
    /// What they were compared with, in the same order, see `CANDIDATE`.
    pub candidates: Float64Array,
    /// What was learned of the odometry.
    pub odometry: LearnedOdometry,
    /// Largest d² of a match.
    pub gate: f64,
    /// Smallest d² to every landmark of a new one.
    pub new_gate: f64,
    /// Largest free distance between the seen and the known part of one wall, m.
    pub max_gap: f64,
}

/// What the filter learned of the odometry.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct LearnedOdometry {
    /// Turn in a drive that it takes for straight, rad/m.
    pub curvature: f64,
    /// Part by which a turn is larger than it says.
    pub turn_scale: f64,
    /// σ of the curvature, rad/m.
    pub curvature_sigma: f64,
    /// σ of the turn scale.
    pub turn_scale_sigma: f64,
}

#[wasm_bindgen]
impl WebRun {
    /// Why the last scan's lines were matched, and, with `matrix`, how errors hang together;
    /// nothing for methods without a line map.
    ///
    /// # Errors    None that a page can cause.
    pub fn inspect(&self, matrix: bool) -> Result<Option<Ts<Inspection>>, WebError> {
        let inside = Inspection::of(self.session(), matrix);
        inside.as_ref().map(typed).transpose()
    }
}

impl Inspection {
    /// `None` for methods without a line map, and while lines were found that are not yet compared
    /// with it. Without `matrix` the coefficients are left out: they are many.
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
        let seen: Vec<_> = report
            .explanations()
            .filter_map(|explanation| {
                let feature = slam.view().features.get(explanation.feature)?;
                Some((explanation, feature.ends.map(|end| map_from_robot * end)))
            })
            .collect();
        let candidates = seen.iter().flat_map(|(e, _)| e.candidates);
        Some(Self {
            robot_rows: correlations.first_landmark as u32,
            landmarks: correlations.landmarks.iter().map(|id| id.0).collect(),
            coefficients: correlations.coefficients.into(),
            sightings: flat(seen.iter().map(|(e, ends)| sighting(e, *ends))),
            candidates: flat(candidates.map(candidate)),
            odometry: LearnedOdometry {
                curvature: learned.curvature,
                turn_scale: learned.turn_scale,
                curvature_sigma: sigmas.curvature,
                turn_scale_sigma: sigmas.turn_scale,
            },
            gate: association.gate,
            new_gate: association.new_gate,
            max_gap: association.max_gap,
        })
    }
}

fn sighting(explanation: &Explanation<'_>, [a, b]: [Point2<f64>; 2]) -> SightingRow {
    let landmark = match explanation.verdict {
        CoreVerdict::Matched(id) | CoreVerdict::Added(id) => f64::from(id.0),
        CoreVerdict::Rejected(_) => f64::NAN,
    };
    SightingRow {
        x1: a.x,
        y1: a.y,
        x2: b.x,
        y2: b.y,
        verdict: f64::from(Verdict::from(&explanation.verdict) as u8),
        landmark,
        candidates: explanation.candidates.len() as f64,
    }
}

fn candidate(c: &Considered) -> CandidateRow {
    let ([delta_alpha, delta_r], [sigma_alpha, sigma_r]) = (c.innovation, c.sigmas);
    CandidateRow {
        landmark: f64::from(c.landmark.0),
        d2: c.d2,
        gap: c.gap,
        delta_alpha,
        delta_r,
        sigma_alpha,
        sigma_r,
        gate: f64::from(Gate::from(&c.gate) as u8),
    }
}
