//! What `report -- registration` has measured: [`super::advice`] reads it.

use super::advice::{MeasuredCondition, MeasuredMethod};
use super::judge::Likeness;

/// Pairs of each condition that were measured.
pub const MEASURED_PAIRS: usize = 1000;

/// All conditions that were measured.
pub const MEASURED: [MeasuredCondition; 4] = [
    MeasuredCondition {
        name: "clean",
        title: "clean scans of one place",
        likeness: Likeness {
            overlap: 0.839,
            sigma: 0.0090,
            scatter: 0.106,
        },
        methods: [
            row("point-to-point", [0.533, 0.943], 347.0, 0.0024),
            row("point-to-line", [0.717, 0.975], 66.0, 0.0000),
            row("surface-to-surface", [0.690, 0.975], 81.3, 0.0000),
            row("ndt", [0.415, 0.828], 1997.6, 0.0000),
            row("cpd", [0.930, 0.992], 3138.5, 0.0000),
            row("gmm", [0.838, 0.951], 16212.6, 0.0000),
            row("correlation", [0.986, 1.000], 1536.3, 0.0000),
        ],
    },
    MeasuredCondition {
        name: "sigma_3_cm",
        title: "noisy scans, σ 3 cm",
        likeness: Likeness {
            overlap: 0.628,
            sigma: 0.0254,
            scatter: 0.367,
        },
        methods: [
            row("point-to-point", [0.395, 0.852], 368.6, 0.0061),
            row("point-to-line", [0.645, 0.959], 115.1, 0.0000),
            row("surface-to-surface", [0.606, 0.951], 129.6, 0.0000),
            row("ndt", [0.407, 0.852], 2251.6, 0.0000),
            row("cpd", [0.933, 0.992], 3748.2, 0.0000),
            row("gmm", [0.834, 0.934], 16690.4, 0.0000),
            row("correlation", [0.980, 1.000], 2121.0, 0.0010),
        ],
    },
    MeasuredCondition {
        name: "half_overlap",
        title: "scans that overlap by half",
        likeness: Likeness {
            overlap: 0.522,
            sigma: 0.0112,
            scatter: 0.103,
        },
        methods: [
            row("point-to-point", [0.139, 0.276], 157.7, 0.0088),
            row("point-to-line", [0.421, 0.707], 68.4, 0.0029),
            row("surface-to-surface", [0.389, 0.707], 70.5, 0.0000),
            row("ndt", [0.221, 0.520], 1010.7, 0.0000),
            row("cpd", [0.010, 0.016], 1204.7, 0.0000),
            row("gmm", [0.098, 0.106], 7526.5, 0.0000),
            row("correlation", [0.582, 0.561], 3533.0, 0.0021),
        ],
    },
    MeasuredCondition {
        name: "outliers_30_percent",
        title: "scans with 30 % outliers",
        likeness: Likeness {
            overlap: 0.378,
            sigma: 0.0110,
            scatter: 0.533,
        },
        methods: [
            row("point-to-point", [0.078, 0.287], 202.1, 0.0000),
            row("point-to-line", [0.447, 0.951], 211.5, 0.0023),
            row("surface-to-surface", [0.392, 0.934], 185.3, 0.0000),
            row("ndt", [0.448, 0.877], 3542.9, 0.0000),
            row("cpd", [0.599, 0.787], 6599.3, 0.0027),
            row("gmm", [0.698, 0.861], 19490.1, 0.0015),
            row("correlation", [0.925, 0.992], 9197.4, 0.0034),
        ],
    },
];

const fn row(name: &'static str, found: [f64; 2], micros: f64, wrong: f64) -> MeasuredMethod {
    MeasuredMethod {
        name,
        found,
        micros,
        wrong,
    }
}
