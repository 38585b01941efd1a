//! How pose and map are estimated.

use crate::association::AssociationMethod;
use crate::estimation::Consistency;
use crate::map::FreeCells;
use crate::settings::{Acts, Kind, Setting};
use crate::slam::PriorMapMatching;

/// The settings.
pub(super) const ESTIMATION: &[Setting] = &[
    Setting {
        key: "ekf.association",
        group: "Filter",
        name: "Lines are matched",
        unit: "",
        range: [0.0, 1.0],
        kind: Kind::Choice(&["one by one (nearest)", "together (JCBB)"]),
        acts: Acts::AtOnce,
        meaning: "One by one is faster; together one spoilt line cannot mislead the others.",
        get: |s| {
            Some(f64::from(u8::from(
                s.slam.ekf.association.method == AssociationMethod::Joint,
            )))
        },
        set: |s, v| {
            s.slam.ekf.association.method = if v == 0.0 {
                AssociationMethod::Nearest
            } else {
                AssociationMethod::Joint
            };
        },
    },
    Setting {
        key: "ekf.consistency",
        group: "Filter",
        name: "Jacobians at",
        unit: "",
        range: [0.0, 1.0],
        kind: Kind::Choice(&["the newest estimates", "the first estimates"]),
        acts: Acts::AtOnce,
        meaning: "At the newest the filter believes to learn a heading that nothing measures.",
        get: |s| {
            Some(f64::from(u8::from(
                s.slam.ekf.consistency == Consistency::FirstEstimates,
            )))
        },
        set: |s, v| {
            s.slam.ekf.consistency = if v == 0.0 {
                Consistency::Plain
            } else {
                Consistency::FirstEstimates
            };
        },
    },
    Setting {
        key: "ekf.gate",
        group: "Filter",
        name: "Gate of a match",
        unit: "d²",
        range: [0.1, 100.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "9.21 is 99 % of χ². Growing: more matches, more wrong ones.",
        get: |s| Some(s.slam.ekf.association.gate),
        set: |s, v| s.slam.ekf.association.gate = v,
    },
    Setting {
        key: "ekf.new_gate",
        group: "Filter",
        name: "Gate of a new wall",
        unit: "d²",
        range: [0.1, 1000.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "A line nearer than this to a known wall is no new one. Growing: fewer duplicates.",
        get: |s| Some(s.slam.ekf.association.new_gate),
        set: |s, v| s.slam.ekf.association.new_gate = v,
    },
    Setting {
        key: "ekf.ambiguity",
        group: "Filter",
        name: "Second best is worse by",
        unit: "d²",
        range: [0.0, 100.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Less clear matches are not used.",
        get: |s| Some(s.slam.ekf.association.ambiguity),
        set: |s, v| s.slam.ekf.association.ambiguity = v,
    },
    Setting {
        key: "ekf.max_gap",
        group: "Filter",
        name: "Gap within one wall",
        unit: "m",
        range: [0.0, 10.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Farther along the same line begins another wall: less than a door.",
        get: |s| Some(s.slam.ekf.association.max_gap),
        set: |s, v| s.slam.ekf.association.max_gap = v,
    },
    Setting {
        key: "ekf.confirm_sightings",
        group: "Filter",
        name: "Sightings of a wall",
        unit: "",
        range: [1.0, 50.0],
        kind: Kind::Whole,
        acts: Acts::AtOnce,
        meaning: "After so many a line counts as a wall.",
        get: |s| Some(s.slam.ekf.confirm_sightings as f64),
        set: |s, v| s.slam.ekf.confirm_sightings = v as u32,
    },
    Setting {
        key: "ekf.patience",
        group: "Filter",
        name: "Forgotten after",
        unit: "scans",
        range: [1.0, 10000.0],
        kind: Kind::Whole,
        acts: Acts::AtOnce,
        meaning: "A line that was not confirmed by then is forgotten.",
        get: |s| Some(s.slam.ekf.patience as f64),
        set: |s, v| s.slam.ekf.patience = v as u32,
    },
    Setting {
        key: "ekf.alpha_sigma",
        group: "Filter",
        name: "Unknown of the direction",
        unit: "rad",
        range: [0.0, 0.2],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Added to what each fit says of α. Growing: more cautious.",
        get: |s| Some(s.slam.ekf.alpha_sigma),
        set: |s, v| s.slam.ekf.alpha_sigma = v,
    },
    Setting {
        key: "ekf.r_sigma",
        group: "Filter",
        name: "Unknown of the distance",
        unit: "m",
        range: [0.0, 0.2],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Added to what each fit says of r. Growing: more cautious.",
        get: |s| Some(s.slam.ekf.r_sigma),
        set: |s, v| s.slam.ekf.r_sigma = v,
    },
    Setting {
        key: "ekf.prior_curvature",
        group: "Filter",
        name: "Tracks unequal by",
        unit: "rad/m",
        range: [0.0, 1.0],
        kind: Kind::Real,
        acts: Acts::OnRestart,
        meaning: "How much a straight drive may bend always; the filter learns it. 0: not at all.",
        get: |s| Some(s.slam.ekf.odometry_prior.curvature),
        set: |s, v| s.slam.ekf.odometry_prior.curvature = v,
    },
    Setting {
        key: "ekf.prior_turn",
        group: "Filter",
        name: "Turns wrong by",
        unit: "",
        range: [0.0, 0.5],
        kind: Kind::Real,
        acts: Acts::OnRestart,
        meaning: "Part by which turns may be wrong always; the filter learns it. 0: not at all.",
        get: |s| Some(s.slam.ekf.odometry_prior.turn_scale),
        set: |s, v| s.slam.ekf.odometry_prior.turn_scale = v,
    },
    Setting {
        key: "ekf.merge_gate",
        group: "Filter",
        name: "Gate of a merger",
        unit: "d²",
        range: [0.1, 100.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Two walls that differ less become one.",
        get: |s| Some(s.slam.ekf.merge.gate),
        set: |s, v| s.slam.ekf.merge.gate = v,
    },
    Setting {
        key: "known.by",
        group: "Known map",
        name: "Finds itself by",
        unit: "",
        range: [0.0, 1.0],
        kind: Kind::Choice(&["lines (TDK 2016)", "whole scans"]),
        acts: Acts::OnRestart,
        meaning: "What of a scan is found in a known map: each straight wall by the filter, or all that was hit at once, which a map of cells with furniture in it asks for.",
        get: |s| {
            Some(f64::from(u8::from(
                s.slam.prior_map_matching == PriorMapMatching::Surfaces,
            )))
        },
        set: |s, v| {
            s.slam.prior_map_matching = if v > 0.5 {
                PriorMapMatching::Surfaces
            } else {
                PriorMapMatching::Lines
            };
        },
    },
    Setting {
        key: "match.keyframe_distance",
        group: "Scan matching",
        name: "Way to a keyframe",
        unit: "m",
        range: [0.02, 5.0],
        kind: Kind::Real,
        acts: Acts::OnRestart,
        meaning: "A scan is kept after this way.",
        get: |s| Some(s.slam.matcher.keyframe_distance),
        set: |s, v| s.slam.matcher.keyframe_distance = v,
    },
    Setting {
        key: "match.keyframe_turn",
        group: "Scan matching",
        name: "Turn to a keyframe",
        unit: "rad",
        range: [0.02, 3.0],
        kind: Kind::Real,
        acts: Acts::OnRestart,
        meaning: "A scan is kept after this turn.",
        get: |s| Some(s.slam.matcher.keyframe_turn),
        set: |s, v| s.slam.matcher.keyframe_turn = v,
    },
    Setting {
        key: "match.submap_keyframes",
        group: "Scan matching",
        name: "Keyframes of a submap",
        unit: "",
        range: [2.0, 200.0],
        kind: Kind::Whole,
        acts: Acts::OnRestart,
        meaning: "Larger drifts more inside, smaller makes more work.",
        get: |s| Some(s.slam.matcher.submap_keyframes as f64),
        set: |s, v| s.slam.matcher.submap_keyframes = v as usize,
    },
    Setting {
        key: "match.close_loops",
        group: "Scan matching",
        name: "Loops are closed",
        unit: "",
        range: [0.0, 1.0],
        kind: Kind::Switch,
        acts: Acts::OnRestart,
        meaning: "Whether a place seen again bends the map back.",
        get: |s| Some(f64::from(u8::from(s.slam.matcher.close_loops))),
        set: |s, v| s.slam.matcher.close_loops = v != 0.0,
    },
    Setting {
        key: "match.max_shift",
        group: "Scan matching",
        name: "Search for a loop",
        unit: "m",
        range: [0.1, 50.0],
        kind: Kind::Real,
        acts: Acts::OnRestart,
        meaning: "How far off the map may be when a loop closes.",
        get: |s| Some(s.slam.matcher.closure.max_shift),
        set: |s, v| s.slam.matcher.closure.max_shift = v,
    },
    Setting {
        key: "match.min_agreement",
        group: "Scan matching",
        name: "Agreement of a loop",
        unit: "",
        range: [0.1, 1.0],
        kind: Kind::Real,
        acts: Acts::OnRestart,
        meaning: "Part of the surfaces that must agree.",
        get: |s| Some(s.slam.matcher.closure.min_agreement),
        set: |s, v| s.slam.matcher.closure.min_agreement = v,
    },
    Setting {
        key: "match.no_return_clears",
        group: "Scan matching",
        name: "No return clears",
        unit: "m",
        range: [0.0, 50.0],
        kind: Kind::Real,
        acts: Acts::OnRestart,
        meaning: "How far a beam without a return is believed to be free.",
        get: |s| Some(s.slam.matcher.no_return_clears),
        set: |s, v| s.slam.matcher.no_return_clears = v,
    },
    Setting {
        key: "grid.resolution",
        group: "Map",
        name: "Cell",
        unit: "m",
        range: [0.01, 0.5],
        kind: Kind::Real,
        acts: Acts::OnRestart,
        meaning: "Side of a cell. Smaller: sharper and slower.",
        get: |s| Some(s.slam.grid.resolution),
        set: |s, v| {
            s.slam.grid.resolution = v;
            s.slam.matcher.grid.resolution = v;
        },
    },
    Setting {
        key: "grid.hit",
        group: "Map",
        name: "Hit",
        unit: "",
        range: [0.51, 0.99],
        kind: Kind::Real,
        acts: Acts::OnRestart,
        meaning: "Probability that the cell where a beam ended is occupied. Lidar 0.7, Celej 0.8.",
        get: |s| Some(s.slam.grid.hit),
        set: |s, v| s.slam.grid.hit = v,
    },
    Setting {
        key: "grid.miss",
        group: "Map",
        name: "Miss",
        unit: "",
        range: [0.01, 0.49],
        kind: Kind::Real,
        acts: Acts::OnRestart,
        meaning: "The same for a cell that a beam crossed. Lidar 0.4, Celej 0.2.",
        get: |s| Some(s.slam.grid.miss),
        set: |s, v| s.slam.grid.miss = v,
    },
    Setting {
        key: "grid.clamp",
        group: "Map",
        name: "Never surer than",
        unit: "",
        range: [0.001, 0.4],
        kind: Kind::Real,
        acts: Acts::OnRestart,
        meaning: "Probabilities stay this far from 0 and 1. Larger: changes its mind sooner.",
        get: |s| Some(s.slam.grid.clamp),
        set: |s, v| s.slam.grid.clamp = v,
    },
    Setting {
        key: "grid.sweep",
        group: "Map",
        name: "Free are the cells",
        unit: "",
        range: [0.0, 2.0],
        kind: Kind::Choice(&[
            "that a beam enters",
            "on its Bresenham line",
            "between the beams",
        ]),
        acts: Acts::OnRestart,
        meaning: "Between the beams is fastest, and leaves no cells unseen where beams are far apart. Sonars beside it keep theirs.",
        get: |s| {
            let at = FreeCells::ALL
                .iter()
                .position(|at| *at == s.slam.grid.free_cells);
            at.map(|at| at as f64)
        },
        set: |s, v| {
            let free_cells = FreeCells::ALL.get(v as usize).copied().unwrap_or_default();
            s.slam.grid.free_cells = free_cells;
            s.slam.matcher.grid.free_cells = free_cells;
        },
    },
    Setting {
        key: "evidence.sigmas",
        group: "Map",
        name: "Width of a beam",
        unit: "σ",
        range: [0.0, 5.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "In standard deviations of its direction. Growing: cleaner walls, less known from afar.",
        get: |s| Some(s.slam.evidence.sigmas),
        set: |s, v| s.slam.evidence.sigmas = v,
    },
    Setting {
        key: "evidence.margin",
        group: "Map",
        name: "Margin of a beam",
        unit: "cells",
        range: [0.0, 5.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "What is cleared is free over so much more to either side.",
        get: |s| Some(s.slam.evidence.margin_cells),
        set: |s, v| s.slam.evidence.margin_cells = v,
    },
];
