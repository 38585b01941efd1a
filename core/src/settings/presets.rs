//! Named sets of settings.

/// Settings that belong together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preset {
    /// The group of settings that it belongs to.
    pub group: &'static str,
    /// Its name for people.
    pub name: &'static str,
    /// What it is for, in one line.
    pub meaning: &'static str,
    /// Keys and numbers; the other settings of the group take their defaults.
    pub values: &'static [(&'static str, f64)],
}

/// All presets.
pub const PRESETS: &[Preset] = &[
    Preset {
        group: "Odometry",
        name: "Grows with the way",
        meaning: "The more the tracks run and turn, the less is known of the pose: true of real tracks.",
        values: &[],
    },
    Preset {
        group: "Odometry",
        name: "Constant Q (TDK 2016)",
        meaning: "The same noise in each reading, as in the paper: a robot that stands loses its way too.",
        values: &[("odometry.model", 1.0)],
    },
    Preset {
        group: "Lines",
        name: "Noise-aware",
        meaning: "What a point may be off depends on how uncertain it is (TDK 2016 §4.2).",
        values: &[],
    },
    Preset {
        group: "Lines",
        name: "Textbook",
        meaning: "Split beyond a fixed distance, keep all lines: what the noise-aware rule is compared with.",
        values: &[
            ("lines.rule", 1.0),
            ("lines.trim", 0.0),
            ("lines.max_alpha_sigma", 1.0),
            ("lines.max_chi2_sigmas", 100.0),
            ("lines.max_bend_sigmas", 100.0),
        ],
    },
    Preset {
        group: "Filter",
        name: "Consistent",
        meaning: "Jacobians at the first estimates, lines matched together.",
        values: &[],
    },
    Preset {
        group: "Filter",
        name: "Textbook EKF",
        meaning: "Jacobians at the newest estimates, each line for itself, no wear of the tracks: watch NEES.",
        values: &[
            ("ekf.association", 0.0),
            ("ekf.consistency", 0.0),
            ("ekf.prior_curvature", 0.0),
            ("ekf.prior_turn", 0.0),
        ],
    },
    Preset {
        group: "Map",
        name: "Lidar",
        meaning: "Each beam is believed a little: many fall on each cell.",
        values: &[("grid.hit", 0.7), ("grid.miss", 0.4)],
    },
    Preset {
        group: "Map",
        name: "Celej",
        meaning: "Each beam is believed much: few fall on each cell.",
        values: &[("grid.hit", 0.8), ("grid.miss", 0.2)],
    },
];
