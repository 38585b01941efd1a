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
            row("point-to-point", [0.533, 0.943], 345.7, 0.0024),
            row("point-to-line", [0.717, 0.975], 68.6, 0.0000),
            row("surface-to-surface", [0.690, 0.975], 91.9, 0.0000),
            row("ndt", [0.415, 0.828], 2002.7, 0.0000),
            row("cpd", [0.930, 0.992], 3106.8, 0.0000),
            row("gmm", [0.838, 0.951], 15964.0, 0.0000),
            row("correlation", [0.986, 1.000], 1478.5, 0.0000),
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
            row("point-to-point", [0.395, 0.852], 364.1, 0.0061),
            row("point-to-line", [0.645, 0.959], 115.1, 0.0000),
            row("surface-to-surface", [0.606, 0.951], 125.0, 0.0000),
            row("ndt", [0.407, 0.852], 2197.4, 0.0000),
            row("cpd", [0.933, 0.992], 3639.1, 0.0000),
            row("gmm", [0.834, 0.934], 16167.8, 0.0000),
            row("correlation", [0.980, 1.000], 1854.9, 0.0010),
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
            row("point-to-point", [0.139, 0.276], 153.4, 0.0088),
            row("point-to-line", [0.421, 0.707], 59.5, 0.0029),
            row("surface-to-surface", [0.389, 0.707], 61.5, 0.0000),
            row("ndt", [0.221, 0.520], 987.2, 0.0000),
            row("cpd", [0.010, 0.016], 1161.4, 0.0000),
            row("gmm", [0.098, 0.106], 6787.9, 0.0000),
            row("correlation", [0.582, 0.561], 3275.3, 0.0021),
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
            row("point-to-point", [0.078, 0.287], 197.0, 0.0000),
            row("point-to-line", [0.447, 0.951], 207.6, 0.0023),
            row("surface-to-surface", [0.392, 0.934], 175.5, 0.0000),
            row("ndt", [0.448, 0.877], 3455.7, 0.0000),
            row("cpd", [0.599, 0.787], 6475.3, 0.0027),
            row("gmm", [0.698, 0.861], 18741.8, 0.0015),
            row("correlation", [0.925, 0.992], 8717.5, 0.0034),
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
