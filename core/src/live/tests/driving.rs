//! Driving to a goal and mapping on the way, live and from its recording.

use super::*;
use crate::geom::Length;
use crate::settings::LogSettings;

#[test]
fn a_robot_behind_a_bridge_is_driven_to_a_goal_and_mapped() {
    let goal = Point2::new(0.7, 0.0);
    let (bridge, live) = drive_to(goal, SensorModel::lidar());
    let truth = truth(&bridge);
    let off = (truth.position() - goal).length();
    assert!(
        off < 0.15,
        "stands {off} m from the goal: {}",
        live.session().pilot().status()
    );
    let error = (live.session().slam().estimate().pose.position() - truth.position()).length();
    assert!(error < 0.02, "estimate is {error} m off");
    assert!(live.session().scans() > 20 && live.session().slam().view().landmarks.len() >= 4);
    assert_eq!(live.dropped, 0);

    let mut replay = replayed(&bridge.reported);
    assert_eq!(replay.take_notes(), [""; 0]);
    assert_eq!(
        (replay.progress(), replay.session().robot().name),
        (1.0, "rp6")
    );
    assert_eq!(replay.session().scans(), live.session().scans());
    assert_eq!(
        replay.session().slam().trajectory(),
        live.session().slam().trajectory()
    );
    assert!(
        replay.time() > 2.0 && replay.odometry_trajectory().count() == replay.session().scans()
    );
}

#[test]
fn a_robot_behind_a_bridge_finds_itself_in_a_prior_map_and_fits_another_building_worse() {
    let goal = Point2::new(0.7, 0.0);
    let known_to = |name: &str| {
        let world = worlds::builtin(name).unwrap();
        let walls = world.walls();
        let walls = walls.iter().map(|wall| wall.segment);
        let mut live = live();
        live.config.method = Method::PriorMap;
        live.config.prior_map = Some(PriorMap::of_walls(walls, &world.start));
        live
    };
    let (mut bridge, mut live) = drive(Bridge::new(SensorModel::lidar()), known_to("arena"), goal);
    // Whether it fits is reported after thirty scans.
    while live.session().scans() < 40 {
        bridge.step(&mut live);
    }
    assert_eq!(live.session().slam().method(), Method::PriorMap);
    let fit = live.session().slam().view().prior_map_fit.unwrap();
    assert!(!fit.is_misfit() && fit.part() > Some(0.9), "{fit:?}");
    let error =
        (live.session().slam().estimate().pose.position() - truth(&bridge).position()).length();
    assert!(error < 0.02, "estimate is {error} m off");
    // The maze is another building.
    let (mut bridge, mut live) = (Bridge::new(SensorModel::lidar()), known_to("maze"));
    bridge.greet(&mut live);
    for _ in 0..200 {
        bridge.step(&mut live);
    }
    let part = live.session().slam().view().prior_map_fit.unwrap().part();
    assert!(part.is_some_and(|part| part < 0.9), "{part:?}");
}

#[test]
fn a_lidar_behind_a_bridge_drives_by_the_cycle_when_asked_to() {
    let goal = Point2::new(0.7, 0.0);
    let mut live = live();
    live.set_cycle(true);
    let (bridge, mut live) = drive(Bridge::new(SensorModel::lidar()), live, goal);
    let off = (truth(&bridge).position() - goal).length();
    assert!(off < 0.15, "stands {off} m from the goal");
    let driven: Vec<&Command> = bridge
        .said
        .iter()
        .filter_map(|message| match message {
            ToBridge::Drive(body) => Some(&body.motion),
            _ => None,
        })
        .collect();
    // Turns and legs, as for a sensor that scans on command; its own sensor gets no such command.
    assert!(
        driven
            .iter()
            .any(|motion| matches!(motion, Command::Forward(_)))
    );
    let is_continuous =
        |motion: &&&Command| matches!(motion, Command::Velocity { .. } | Command::Scan);
    assert_eq!(driven.iter().find(is_continuous), None);
    let stages = live.session().stages();
    for (name, stage) in crate::pilot::Stage::ALL {
        assert!(stages.report(stage).is_some(), "{name}: {stages:?}");
    }
    // By hand it drives while it scans: the cycle continues with the next task.
    live.drive(0.5, 0.0);
    assert!(!live.session().scans_on_command());
    live.set_mode(Mode::Explore);
    assert!(live.session().scans_on_command());
}

#[test]
fn without_a_map_the_line_filter_draws_its_own() {
    let mut live = live();
    live.config.method = Method::PriorMap;
    Bridge::new(SensorModel::lidar()).greet(&mut live);
    assert_eq!(live.session().slam().method(), Method::LineEkf);
    let notes = live.take_notes();
    assert!(notes[0].text.contains("No map was given"), "{notes:?}");
}

#[test]
fn a_robot_that_drives_by_the_cycle_behind_a_bridge_shows_it_as_a_simulated_one() {
    let (_, live) = drive_to(Point2::new(0.8, 0.3), SensorModel::rangers());
    let stages = live.session().stages();
    assert!(live.session().scans_on_command() && stages.round() > 1);
    for (name, stage) in crate::pilot::Stage::ALL {
        assert!(stages.report(stage).is_some(), "{name}");
    }
}

/// Sweeps of a standing robot take seconds; the recording names the robot, so it is mapped as one.
#[test]
fn a_recording_of_sweeps_is_mapped_as_it_was_live() {
    let (bridge, live) = drive_to(Point2::new(0.8, 0.3), SensorModel::rangers());
    let replay = replayed(&bridge.reported);
    assert!(replay.log().scans_on_command());
    assert_eq!(
        replay.session().slam().trajectory(),
        live.session().slam().trajectory()
    );
}

#[test]
fn a_recording_without_the_robots_name_has_its_odometry_all_the_same() {
    let (mut bridge, _) = drive_to(Point2::new(0.5, 0.0), SensorModel::lidar());
    bridge
        .reported
        .retain(|(_, message)| !matches!(message, FromBridge::Hello(_)));
    let replay = replayed(&bridge.reported);
    assert_eq!(
        (
            replay.session().robot().name,
            replay.log().robot(&LogSettings::default()).name
        ),
        ("pioneer", "pioneer")
    );
    let off =
        (replay.session().slam().estimate().pose.position() - truth(&bridge).position()).length();
    assert!(off < 0.03, "{off} m");
}

#[test]
fn legs_turns_and_sweeps_of_the_cycle_are_waited_for() {
    let goal = Point2::new(0.8, 0.3);
    let (bridge, live) = drive_to(goal, SensorModel::rangers());
    let error =
        (live.session().slam().estimate().pose.position() - truth(&bridge).position()).length();
    assert!(error < 0.10, "estimate is {error} m off");
    let drives: Vec<Command> = bridge
        .said
        .iter()
        .filter_map(|message| match message {
            ToBridge::Drive(body) => Some(body.motion),
            _ => None,
        })
        .collect();
    let sweeps = drives
        .iter()
        .filter(|motion| **motion == Command::Scan)
        .count();
    // The first sweep, begun by hand, was given up for the task.
    assert!(
        sweeps >= 3 && live.session().scans() == sweeps - 1,
        "{drives:?}"
    );
    assert!(
        drives
            .iter()
            .any(|motion| matches!(motion, Command::Forward(_)))
    );
    assert!(
        bridge
            .said
            .iter()
            .any(|message| matches!(message, ToBridge::Hold { .. }))
    );
}
