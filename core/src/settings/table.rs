//! The settings, those of a group together. A row holds key, name, figures, field, attributes and
//! meaning.

mod driving;
mod estimation;
mod map;
mod perception;
mod robot;
mod sensor;

use super::setting::{Acts, Group, Needs, Setting, Source};
use crate::slam::Method;

/// A simulated robot's.
const SIMULATED: Group = Group {
    name: "",
    sources: &[Source::Simulation],
    methods: &[],
    needs: Needs::Nothing,
    acts: Acts::OnRestart,
};
/// A robot's that is driven from here.
const DRIVEN: Group = Group {
    sources: &[Source::Simulation, Source::Live],
    acts: Acts::AtOnce,
    ..SIMULATED
};
/// A recorded log's.
const RECORDED: Group = Group {
    sources: &[Source::Recording],
    ..SIMULATED
};
/// Any robot's.
const ANY: Group = Group {
    sources: &[Source::Simulation, Source::Recording, Source::Live],
    ..DRIVEN
};
/// The methods that look for lines, and draw a grid as each scan comes.
const BY_LINES: &[Method] = &[Method::LineEkf, Method::PriorMap];
/// All settings, each group in one piece, a choice before the settings that depend on it.
const TABLE: [&[Setting]; 19] = [
    sensor::LIDAR,
    sensor::RANGERS,
    sensor::SONAR,
    sensor::SONARS_BESIDE,
    robot::BODY,
    robot::TRACKS,
    robot::ODOMETRY,
    robot::LOG,
    perception::POINTS,
    perception::LINES,
    perception::POINT_FEATURES,
    perception::BLIND_ZONE,
    perception::MOVING,
    estimation::FILTER,
    estimation::SCAN_MATCHING,
    estimation::GRID_PARTICLES,
    map::MAP,
    driving::DRIVING,
    driving::EXPLORATION,
];

/// All settings, those of a group together.
pub fn table() -> impl Iterator<Item = &'static Setting> + Clone {
    TABLE.into_iter().flatten()
}
