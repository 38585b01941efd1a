//! The settings, group by group. A row holds key, name, figures, field, attributes and meaning.

mod driving;
mod estimation;
mod map;
mod perception;
mod robot;
mod sensor;

use super::setting::{Acts, Group, Needs, Setting, Source};
use crate::slam::Method;

/// Settings of a simulated robot.
const SIMULATED: Group = Group {
    name: "",
    sources: &[Source::Simulation],
    methods: &[],
    needs: Needs::Nothing,
    acts: Acts::OnRestart,
};
/// Settings of a robot that is driven from here.
const DRIVEN: Group = Group {
    sources: &[Source::Simulation, Source::Live],
    acts: Acts::AtOnce,
    ..SIMULATED
};
/// Settings of a recorded log.
const RECORDED: Group = Group {
    sources: &[Source::Recording],
    ..SIMULATED
};
/// Settings of any robot.
const ANY: Group = Group {
    sources: &[Source::Simulation, Source::Recording, Source::Live],
    ..DRIVEN
};
/// The methods that find lines, and draw each scan into the grid as it comes.
const BY_LINES: &[Method] = &[Method::LineEkf, Method::PriorMap];
/// All settings, each group contiguous, a choice before the settings that depend on it.
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

/// All settings, group by group.
pub fn table() -> impl Iterator<Item = &'static Setting> + Clone {
    TABLE.into_iter().flatten()
}
