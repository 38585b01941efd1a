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
            row("point-to-point", [0.533, 0.943], 321.3, 0.0024),
            row("point-to-line", [0.718, 0.975], 69.1, 0.0000),
            row("surface-to-surface", [0.690, 0.975], 77.1, 0.0000),
            row("ndt", [0.415, 0.828], 1938.6, 0.0000),
            row("cpd", [0.930, 0.992], 3319.5, 0.0034),
            row("gmm", [0.838, 0.951], 16984.0, 0.0000),
            row("correlation", [0.986, 1.000], 1426.3, 0.0000),
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
            row("point-to-point", [0.395, 0.852], 332.8, 0.0030),
            row("point-to-line", [0.645, 0.959], 94.0, 0.0000),
            row("surface-to-surface", [0.606, 0.951], 99.1, 0.0000),
            row("ndt", [0.407, 0.852], 1956.6, 0.0000),
            row("cpd", [0.933, 0.992], 3750.9, 0.0011),
            row("gmm", [0.834, 0.934], 16733.4, 0.0000),
            row("correlation", [0.980, 1.000], 1658.3, 0.0021),
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
            row("point-to-point", [0.139, 0.276], 123.5, 0.1034),
            row("point-to-line", [0.421, 0.707], 36.2, 0.0164),
            row("surface-to-surface", [0.389, 0.707], 38.2, 0.0179),
            row("ndt", [0.221, 0.520], 793.3, 0.0056),
            row("cpd", [0.010, 0.016], 1397.4, 0.5000),
            row("gmm", [0.098, 0.106], 6974.8, 0.0595),
            row("correlation", [0.582, 0.561], 2429.6, 0.0144),
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
            row("point-to-point", [0.078, 0.287], 179.7, 0.0000),
            row("point-to-line", [0.448, 0.951], 109.3, 0.0023),
            row("surface-to-surface", [0.394, 0.934], 113.9, 0.0027),
            row("ndt", [0.448, 0.877], 2446.9, 0.0023),
            row("cpd", [0.599, 0.787], 5776.2, 0.0053),
            row("gmm", [0.698, 0.861], 17381.2, 0.0030),
            row("correlation", [0.925, 0.992], 5903.0, 0.0034),
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
