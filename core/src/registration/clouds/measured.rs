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
            row("point-to-point", [0.478, 0.934], 402.0, 0.0076),
            row("point-to-line", [0.721, 0.975], 93.6, 0.0085),
            row("surface-to-surface", [0.691, 0.975], 103.5, 0.0015),
            row("ndt", [0.415, 0.828], 2010.9, 0.0050),
            row("cpd", [0.930, 0.992], 4516.0, 0.0099),
            row("gmm", [0.838, 0.951], 17729.6, 0.0061),
            row("correlation", [0.986, 1.000], 1737.7, 0.0135),
        ],
    },
    MeasuredCondition {
        name: "sigma_3_cm",
        title: "noisy scans, σ 3 cm",
        likeness: Likeness {
            overlap: 0.627,
            sigma: 0.0254,
            scatter: 0.367,
        },
        methods: [
            row("point-to-point", [0.235, 0.590], 341.1, 0.0662),
            row("point-to-line", [0.633, 0.959], 129.3, 0.0251),
            row("surface-to-surface", [0.599, 0.951], 129.5, 0.0181),
            row("ndt", [0.407, 0.852], 2023.6, 0.0198),
            row("cpd", [0.933, 0.992], 4945.6, 0.0182),
            row("gmm", [0.834, 0.934], 17643.2, 0.0258),
            row("correlation", [0.980, 1.000], 2004.4, 0.0133),
        ],
    },
    MeasuredCondition {
        name: "half_overlap",
        title: "scans that overlap by half",
        likeness: Likeness {
            overlap: 0.500,
            sigma: 0.0107,
            scatter: 0.103,
        },
        methods: [
            row("point-to-point", [0.133, 0.260], 139.8, 0.1927),
            row("point-to-line", [0.403, 0.699], 48.0, 0.0272),
            row("surface-to-surface", [0.379, 0.675], 50.6, 0.0291),
            row("ndt", [0.221, 0.520], 818.4, 0.0211),
            row("cpd", [0.010, 0.016], 1816.1, 0.6154),
            row("gmm", [0.098, 0.106], 7638.2, 0.2617),
            row("correlation", [0.582, 0.561], 2619.9, 0.0319),
        ],
    },
    MeasuredCondition {
        name: "outliers_30_percent",
        title: "scans with 30 % outliers",
        likeness: Likeness {
            overlap: 0.376,
            sigma: 0.0110,
            scatter: 0.533,
        },
        methods: [
            row("point-to-point", [0.022, 0.074], 195.8, 0.2222),
            row("point-to-line", [0.419, 0.943], 121.6, 0.0625),
            row("surface-to-surface", [0.357, 0.910], 134.3, 0.0659),
            row("ndt", [0.448, 0.877], 2540.2, 0.0611),
            row("cpd", [0.599, 0.787], 7058.8, 0.0463),
            row("gmm", [0.698, 0.861], 18403.2, 0.0596),
            row("correlation", [0.924, 0.992], 6177.4, 0.0306),
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
