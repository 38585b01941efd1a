//! The simulated robot's body.

use crate::robot::BodyShape;
use crate::settings::{Acts, Kind, Setting, Settings, SimulatedBody};

/// A side of a rectangle; a disc has none.
fn side(settings: &Settings, of: impl Fn(&SimulatedBody) -> f64) -> Option<f64> {
    let body = &settings.body;
    (body.shape == BodyShape::Rectangle).then(|| of(body))
}

/// The settings.
pub(super) const BODY: &[Setting] = &[
    Setting {
        key: "body.shape",
        group: "Simulated body",
        name: "Outline of the robot",
        unit: "",
        range: [0.0, 1.0],
        kind: Kind::Choice(&["disc", "rectangle"]),
        acts: Acts::OnRestart,
        meaning: "Disc: the one around the body. Rectangle: on its way to a goal the robot also passes where only the rectangle does, and contacts are the rectangle's; exploring, the cycle and driving by hand keep the disc around it.",
        get: |s| Some(f64::from(u8::from(s.body.shape == BodyShape::Rectangle))),
        set: |s, v| {
            s.body.shape = match v > 0.5 {
                true => BodyShape::Rectangle,
                false => BodyShape::Disc,
            }
        },
    },
    Setting {
        key: "body.length",
        group: "Simulated body",
        name: "Length of the rectangle",
        unit: "m",
        range: [0.0, 1.5],
        kind: Kind::Real,
        acts: Acts::OnRestart,
        meaning: "Along the way it drives, the centre in the middle. 0: as the robot's model says.",
        get: |s| side(s, |body| body.length),
        set: |s, v| s.body.length = v,
    },
    Setting {
        key: "body.width",
        group: "Simulated body",
        name: "Width of the rectangle",
        unit: "m",
        range: [0.0, 1.5],
        kind: Kind::Real,
        acts: Acts::OnRestart,
        meaning: "Across. 0: as the robot's model says.",
        get: |s| side(s, |body| body.width),
        set: |s, v| s.body.width = v,
    },
];
