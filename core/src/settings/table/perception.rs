//! What is made of scans: points and lines.

use crate::features::{Classic, LineConfig, NoiseAware, Pilch, SplitRule};
use crate::points::{Growth, RangeSigma, SectorConfig};
use crate::settings::{Acts, Kind, Setting, Settings};

/// The settings.
pub(super) const PERCEPTION: &[Setting] = &[
    Setting {
        key: "points.min_range",
        group: "Points",
        name: "Nearest range used",
        unit: "m",
        range: [0.0, 5.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Nearer readings are dropped: the robot's own body.",
        get: |s| Some(s.slam.points.min_range),
        set: |s, v| s.slam.points.min_range = v,
    },
    Setting {
        key: "points.max_range",
        group: "Points",
        name: "Farthest range used",
        unit: "m",
        range: [0.1, 1000.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Farther readings count as no return; 1000 m leaves it to the sensor.",
        get: |s| Some(s.slam.points.max_range.min(1000.0)),
        set: |s, v| s.slam.points.max_range = if v < 1000.0 { v } else { f64::INFINITY },
    },
    Setting {
        key: "points.sector",
        group: "Points",
        name: "One reading for each sector of",
        unit: "rad",
        range: [0.0, 1.5],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "The least range of a sector stands for it (Celej: 0.175, that is 10°). 0: every beam counts. Wide sectors leave no lines to find the pose by: it drifts with the wheels.",
        get: |s| Some(s.slam.sectors.map_or(0.0, |sectors| sectors.width)),
        set: |s, v| {
            s.slam.sectors = (v > 0.0).then(|| SectorConfig {
                width: v,
                ..s.slam.sectors.unwrap_or_default()
            });
        },
    },
    Setting {
        key: "points.sector_no_returns",
        group: "Points",
        name: "No returns that are errors",
        unit: "",
        range: [0.0, 1000.0],
        kind: Kind::Whole,
        acts: Acts::AtOnce,
        meaning: "With sectors: so many in one do not count; more, and nothing is there.",
        get: |s| s.slam.sectors.map(|sectors| sectors.no_returns as f64),
        set: |s, v| {
            if let Some(sectors) = &mut s.slam.sectors {
                sectors.no_returns = v as usize;
            }
        },
    },
    Setting {
        key: "points.sigma",
        group: "Points",
        name: "σ of the ranges",
        unit: "",
        range: [0.0, 2.0],
        kind: Kind::Choice(&["as the sensor says", "a + b ρ", "a + b ρ²"]),
        acts: Acts::AtOnce,
        meaning: "Own figures for σ(ρ), as estimated from scans taken standing.",
        get: sigma_growth,
        set: set_sigma_growth,
    },
    Setting {
        key: "points.sigma_constant",
        group: "Points",
        name: "a",
        unit: "m",
        range: [-1.0, 1.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "σ at no distance.",
        get: |s| s.slam.points.sigma.map(|m| m.constant),
        set: |s, v| {
            if let Some(m) = &mut s.slam.points.sigma {
                m.constant = v;
            }
        },
    },
    Setting {
        key: "points.sigma_slope",
        group: "Points",
        name: "b",
        unit: "m/m, m/m²",
        range: [-1.0, 1.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Growth of σ with the distance, or with its square.",
        get: |s| s.slam.points.sigma.map(|m| m.slope),
        set: |s, v| {
            if let Some(m) = &mut s.slam.points.sigma {
                m.slope = v;
            }
        },
    },
    Setting {
        key: "points.sigma_least",
        group: "Points",
        name: "Least σ",
        unit: "m",
        range: [1e-05, 1.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "σ is never believed smaller than this.",
        get: |s| s.slam.points.sigma.map(|m| m.least),
        set: |s, v| {
            if let Some(m) = &mut s.slam.points.sigma {
                m.least = v;
            }
        },
    },
    Setting {
        key: "lines.rule",
        group: "Lines",
        name: "Split-and-merge",
        unit: "",
        range: [0.0, 2.0],
        kind: Kind::Choice(&[
            "noise-aware (TDK 2016)",
            "classic",
            "by explained scatter (Pilch 2016)",
        ]),
        acts: Acts::AtOnce,
        meaning: "When a run of points is split into two lines.",
        get: split_rule,
        set: set_split_rule,
    },
    Setting {
        key: "lines.split_k",
        group: "Lines",
        name: "Split at k standard deviations",
        unit: "σ",
        range: [0.5, 10.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "A point farther off splits. Growing: fewer true walls are torn, shallow corners stay undetected.",
        get: |s| noise_aware(s).map(|rule| rule.split_k),
        set: |s, v| noise_aware_mut(s, |rule| rule.split_k = v),
    },
    Setting {
        key: "lines.max_residual",
        group: "Lines",
        name: "Point left out beyond",
        unit: "σ",
        range: [1.0, 20.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "A point so far off its line does not count for it.",
        get: |s| noise_aware(s).map(|rule| rule.max_residual),
        set: |s, v| noise_aware_mut(s, |rule| rule.max_residual = v),
    },
    Setting {
        key: "lines.threshold",
        group: "Lines",
        name: "Split beyond",
        unit: "m",
        range: [0.005, 1.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "A point farther from its line splits. Growing: fewer walls torn by noise, fewer shallow corners.",
        get: |s| classic(s).map(|rule| rule.threshold),
        set: |s, v| classic_mut(s, |rule| rule.threshold = v),
    },
    Setting {
        key: "lines.max_step",
        group: "Lines",
        name: "Largest step in bearing",
        unit: "rad",
        range: [0.005, 1.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Points farther apart in bearing are not of one wall.",
        get: |s| Some(s.slam.lines.segmentation.max_step),
        set: |s, v| s.slam.lines.segmentation.max_step = v,
    },
    Setting {
        key: "lines.gap_points",
        group: "Lines",
        name: "Points between merged lines",
        unit: "",
        range: [0.0, 50.0],
        kind: Kind::Whole,
        acts: Acts::AtOnce,
        meaning: "Two lines become one over at most so many points of neither.",
        get: |s| Some(s.slam.lines.merge.gap_points as f64),
        set: |s, v| s.slam.lines.merge.gap_points = v as usize,
    },
    Setting {
        key: "lines.gap",
        group: "Lines",
        name: "Gap between merged lines",
        unit: "m",
        range: [0.0, 2.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Over at most this distance: less than a door.",
        get: |s| Some(s.slam.lines.merge.gap),
        set: |s, v| s.slam.lines.merge.gap = v,
    },
    Setting {
        key: "lines.trim",
        group: "Lines",
        name: "Points given up at the ends",
        unit: "",
        range: [0.0, 10.0],
        kind: Kind::Whole,
        acts: Acts::AtOnce,
        meaning: "Fewer give longer lines and a less honest map.",
        get: |s| Some(s.slam.lines.accept.trim as f64),
        set: |s, v| s.slam.lines.accept.trim = v as usize,
    },
    Setting {
        key: "lines.min_points",
        group: "Lines",
        name: "Fewest points",
        unit: "",
        range: [3.0, 100.0],
        kind: Kind::Whole,
        acts: Acts::AtOnce,
        meaning: "Growing: fewer, safer lines.",
        get: |s| Some(s.slam.lines.accept.min_points as f64),
        set: |s, v| s.slam.lines.accept.min_points = v as usize,
    },
    Setting {
        key: "lines.min_length",
        group: "Lines",
        name: "Shortest line",
        unit: "m",
        range: [0.0, 5.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Shorter ones are people and pillars more often than walls.",
        get: |s| Some(s.slam.lines.accept.min_length),
        set: |s, v| s.slam.lines.accept.min_length = v,
    },
    Setting {
        key: "lines.max_alpha_sigma",
        group: "Lines",
        name: "Largest σ of the direction",
        unit: "rad",
        range: [0.001, 1.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Less certain lines are left out: what is linear at 2° is not at 6°.",
        get: |s| Some(s.slam.lines.accept.max_alpha_sigma),
        set: |s, v| s.slam.lines.accept.max_alpha_sigma = v,
    },
    Setting {
        key: "lines.max_chi2_sigmas",
        group: "Lines",
        name: "Largest misfit",
        unit: "σ",
        range: [0.5, 100.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "χ² of the residuals above its mean, in standard deviations.",
        get: |s| Some(s.slam.lines.accept.max_chi2_sigmas),
        set: |s, v| s.slam.lines.accept.max_chi2_sigmas = v,
    },
    Setting {
        key: "lines.max_bend_sigmas",
        group: "Lines",
        name: "Largest bend",
        unit: "σ",
        range: [0.5, 100.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "More bent ones are pillars.",
        get: |s| Some(s.slam.lines.accept.max_bend_sigmas),
        set: |s, v| s.slam.lines.accept.max_bend_sigmas = v,
    },
    Setting {
        key: "lines.surface_sigma",
        group: "Lines",
        name: "Roughness of walls",
        unit: "m",
        range: [0.0, 0.1],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "How far from flat a wall may be, one standard deviation.",
        get: |s| Some(s.slam.lines.accept.surface_sigma),
        set: |s, v| s.slam.lines.accept.surface_sigma = v,
    },
];

fn noise_aware(settings: &Settings) -> Option<NoiseAware> {
    match settings.slam.lines.split {
        SplitRule::NoiseAware(rule) => Some(rule),
        _ => None,
    }
}

fn noise_aware_mut(settings: &mut Settings, change: impl FnOnce(&mut NoiseAware)) {
    if let SplitRule::NoiseAware(rule) = &mut settings.slam.lines.split {
        change(rule);
    }
}

fn classic(settings: &Settings) -> Option<Classic> {
    match settings.slam.lines.split {
        SplitRule::Classic(rule) => Some(rule),
        _ => None,
    }
}

fn classic_mut(settings: &mut Settings, change: impl FnOnce(&mut Classic)) {
    if let SplitRule::Classic(rule) = &mut settings.slam.lines.split {
        change(rule);
    }
}

fn split_rule(settings: &Settings) -> Option<f64> {
    Some(match settings.slam.lines.split {
        SplitRule::NoiseAware(_) => 0.0,
        SplitRule::Classic(_) => 1.0,
        SplitRule::Pilch(_) => 2.0,
    })
}

/// The rule with its default figures, unless it is the one already.
fn set_split_rule(settings: &mut Settings, value: f64) {
    if split_rule(settings) == Some(value) {
        return;
    }
    settings.slam.lines.split = if value == 0.0 {
        LineConfig::default().split
    } else if value == 1.0 {
        SplitRule::Classic(Classic::default())
    } else {
        SplitRule::Pilch(Pilch::default())
    };
}

fn sigma_growth(settings: &Settings) -> Option<f64> {
    Some(match settings.slam.points.sigma {
        None => 0.0,
        Some(sigma) if sigma.growth == Growth::Linear => 1.0,
        Some(_) => 2.0,
    })
}

/// Begins with 1 cm and no growth.
fn set_sigma_growth(settings: &mut Settings, value: f64) {
    let growth = if value == 1.0 {
        Growth::Linear
    } else {
        Growth::Square
    };
    let before = settings.slam.points.sigma.unwrap_or(RangeSigma {
        growth,
        constant: 0.01,
        slope: 0.0,
        least: 0.001,
    });
    settings.slam.points.sigma = (value != 0.0).then_some(RangeSigma { growth, ..before });
}
