//! The filter's inside, flattened for the page: how errors hang together, and why each line was matched.

use nalgebra::Point2;
use slamlab_core::estimation::{Considered, Correlations, Explanation, Gate, Rejection, Verdict};
use slamlab_core::pilot::Stage;
use slamlab_core::session::Session;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::view::map_from_robot_at_scan;

/// The line filter after the last scan; codes and strides as in `Inspection` of www/src/protocol/filter.ts.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug, PartialEq)]
pub struct Inspection {
    /// Rows that belong to the robot, before those of the landmarks.
    pub robot_rows: u32,
    /// Landmarks in the order of their rows, two each: α, then r.
    pub landmarks: Vec<u32>,
    /// Correlation coefficients, row by row; empty where they were not asked for.
    pub coefficients: Vec<f32>,
    /// For each line of the scan: x1, y1, x2, y2 in the map frame (m), verdict, landmark (NaN without), number of
    /// candidates.
    pub sightings: Vec<f64>,
    /// For each candidate, in the order of the sightings: landmark, d², gap (m), Δα, Δr, σ of Δα, σ of Δr (rad, m), gate.
    pub candidates: Vec<f64>,
    /// What was learned of the odometry: curvature (rad/m) and turn scale, then their standard deviations.
    pub odometry: Vec<f64>,
    /// Largest d² of a match.
    pub gate: f64,
    /// Smallest d² to every landmark of a new one.
    pub new_gate: f64,
    /// Largest free distance between the seen and the known part of one wall, m.
    pub max_gap: f64,
}

impl Inspection {
    /// `None` for methods without a line map, and while lines were found that are not yet compared with it. Without `matrix` the
    /// coefficients are left out: they are many.
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
        let association = &slam.config().ekf.association;
        let map_from_robot = map_from_robot_at_scan(session);
        let mut inspection = Self {
            robot_rows: correlations.first_landmark as u32,
            landmarks: correlations.landmarks.iter().map(|id| id.0).collect(),
            coefficients: correlations.coefficients,
            sightings: vec![],
            candidates: vec![],
            odometry: slam
                .view()
                .odometry_errors?
                .into_iter()
                .flat_map(|errors| [errors.curvature, errors.turn_scale])
                .collect(),
            gate: association.gate,
            new_gate: association.new_gate,
            max_gap: association.max_gap,
        };
        for explanation in report.explanations() {
            let Some(feature) = slam.view().features.get(explanation.feature) else {
                continue;
            };
            let ends = feature.ends.map(|end| map_from_robot * end);
            inspection.sightings.extend(sighting(&explanation, ends));
            let candidates = explanation.candidates.iter().flat_map(candidate);
            inspection.candidates.extend(candidates);
        }
        Some(inspection)
    }
}

fn sighting(explanation: &Explanation<'_>, [a, b]: [Point2<f64>; 2]) -> [f64; 7] {
    let (code, landmark) = match explanation.verdict {
        Verdict::Matched(id) => (0.0, f64::from(id.0)),
        Verdict::Added(id) => (1.0, f64::from(id.0)),
        Verdict::Rejected(reason) => (rejection(reason), f64::NAN),
    };
    let n = explanation.candidates.len() as f64;
    [a.x, a.y, b.x, b.y, code, landmark, n]
}

fn rejection(reason: Rejection) -> f64 {
    match reason {
        Rejection::Ambiguous => 2.0,
        Rejection::OutsideGate => 3.0,
        Rejection::Taken => 4.0,
        Rejection::Seam => 5.0,
        Rejection::Singular => 6.0,
    }
}

fn candidate(c: &Considered) -> [f64; 8] {
    let ([alpha, r], [sigma_alpha, sigma_r]) = (c.innovation, c.sigmas);
    let gate = match c.gate {
        Gate::Match => 0.0,
        Gate::Near => 1.0,
        Gate::Far => 2.0,
        Gate::Beyond => 3.0,
    };
    let landmark = f64::from(c.landmark.0);
    [landmark, c.d2, c.gap, alpha, r, sigma_alpha, sigma_r, gate]
}
