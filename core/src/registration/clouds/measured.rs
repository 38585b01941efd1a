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
            row("point-to-point", [0.533, 0.943], 315.7, 0.0024),
            row("point-to-line", [0.715, 0.975], 65.6, 0.0000),
            row("surface-to-surface", [0.687, 0.975], 76.7, 0.0000),
            row("ndt", [0.415, 0.828], 1978.2, 0.0000),
            row("cpd", [0.930, 0.992], 1858.1, 0.0000),
            row("gmm", [0.831, 0.951], 4471.9, 0.0000),
            row("correlation", [0.986, 1.000], 1459.1, 0.0000),
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
            row("point-to-point", [0.395, 0.852], 342.1, 0.0061),
            row("point-to-line", [0.641, 0.959], 112.2, 0.0016),
            row("surface-to-surface", [0.603, 0.951], 125.7, 0.0000),
            row("ndt", [0.407, 0.852], 2361.4, 0.0000),
            row("cpd", [0.933, 0.992], 2164.8, 0.0000),
            row("gmm", [0.826, 0.934], 4696.6, 0.0000),
            row("correlation", [0.980, 1.000], 1897.7, 0.0000),
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
            row("point-to-point", [0.139, 0.276], 146.6, 0.0088),
            row("point-to-line", [0.419, 0.707], 61.7, 0.0029),
            row("surface-to-surface", [0.389, 0.707], 71.5, 0.0000),
            row("ndt", [0.221, 0.520], 1004.6, 0.0000),
            row("cpd", [0.010, 0.016], 963.8, 0.0000),
            row("gmm", [0.081, 0.114], 3132.2, 0.0000),
            row("correlation", [0.582, 0.561], 3399.8, 0.0041),
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
            row("point-to-point", [0.078, 0.287], 187.9, 0.0000),
            row("point-to-line", [0.443, 0.943], 185.7, 0.0023),
            row("surface-to-surface", [0.391, 0.934], 167.5, 0.0000),
            row("ndt", [0.448, 0.877], 3603.6, 0.0000),
            row("cpd", [0.599, 0.787], 4471.8, 0.0027),
            row("gmm", [0.695, 0.852], 7634.7, 0.0015),
            row("correlation", [0.924, 0.992], 9104.3, 0.0023),
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
