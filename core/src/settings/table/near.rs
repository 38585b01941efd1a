//! What is remembered of things too near for the sensor to see.

use crate::settings::{Acts, Kind, Setting};

/// The settings.
pub(super) const NEAR: &[Setting] = &[
    Setting {
        key: "near.reach",
        group: "Near field",
        name: "Remembered up to",
        unit: "m",
        range: [0.0, 5.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Hits nearer than this are remembered from scan to scan, so that the robot does not drive into what it no longer sees.",
        get: |s| Some(s.slam.blind_zone.reach),
        set: |s, v| s.slam.blind_zone.reach = v,
    },
    Setting {
        key: "near.blind",
        group: "Near field",
        name: "May look far below",
        unit: "m",
        range: [0.0, 1.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Of an IR ranger a wall nearer than the peak of its curve looks far: readings towards a remembered wall nearer than this are not used. 0 for a lidar.",
        get: |s| Some(s.slam.blind_zone.blind),
        set: |s, v| s.slam.blind_zone.blind = v,
    },
    Setting {
        key: "near.behind",
        group: "Near field",
        name: "Gone if seen behind by",
        unit: "m",
        range: [0.0, 1.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "A beam that ends this far behind a remembered point says that it has gone; above the noise of the ranges.",
        get: |s| Some(s.slam.blind_zone.behind),
        set: |s, v| s.slam.blind_zone.behind = v,
    },
    Setting {
        key: "near.beams",
        group: "Near field",
        name: "Beams that speak of a point",
        unit: "beams",
        range: [0.0, 20.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "How far beside a remembered point a beam may pass and still tell that it has gone, in angles between two beams.",
        get: |s| Some(s.slam.blind_zone.beams),
        set: |s, v| s.slam.blind_zone.beams = v,
    },
];
