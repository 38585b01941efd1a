//! Explorations of the flat, with every strategy and with return home.

use super::*;
use crate::estimation::Edge;
use crate::geom::{Length, sides_of};
use crate::plan::FrontierChoice;

/// Explores the flat with a pose graph in which the two poses are 20 m apart; returns also how near
/// the robot came to each of `watched` while it closed the loop.
fn closed(
    ends: [(f64, f64); 2],
    close_loops: bool,
    watched: &[(f64, f64)],
) -> (Toy, Pilot, Vec<f64>) {
    let mut toy = Toy::new(flat(), Pose2::identity(), RobotModel::rp6());
    let [older, newer] = ends.map(|(x, y)| Pose2::new(x, y, 0.0));
    let mut graph = PoseGraph::default();
    graph.add_pose(older);
    graph.add_pose(Pose2::new(older.x(), older.y() + 10.0, 0.0));
    graph.add_pose(newer);
    for (from, to) in [(0, 1), (1, 2)] {
        graph.add_edge(Edge {
            from,
            to,
            motion: Pose2::new(10.0, 0.0, 0.0),
            information: Matrix3::identity(),
            cauchy: None,
        });
    }
    toy.graph = Some(graph);
    let config = PilotConfig {
        close_loops,
        ..PilotConfig::default()
    };
    let mut pilot = Pilot::new(toy.model, config, 1);
    pilot.set_mode(Mode::Explore);
    let mut nearest = vec![f64::INFINITY; watched.len()];
    while !pilot.status().is_over() && toy.stamp().seconds() < 600.0 {
        toy.run(&mut pilot, toy.stamp().seconds() + 0.1);
        if pilot.is_closing_loop() {
            for (nearest, &(x, y)) in nearest.iter_mut().zip(watched) {
                *nearest = nearest.min((toy.pose.position() - Point2::new(x, y)).length());
            }
        }
    }
    assert!(
        matches!(pilot.status(), Status::Finished(Finish::Explored { .. })),
        "{}",
        pilot.status()
    );
    assert!(toy.nearest > toy.model.radius(), "{}", toy.nearest);
    (toy, pilot, nearest)
}

#[test]
fn all_explored_the_gap_of_a_loop_is_driven_through_once() {
    let ends = [(0.0, 0.0), (2.0, 1.0)];
    let (toy, _, nearest) = closed(ends, true, &ends);
    let (left_open, _, never) = closed(ends, false, &ends);
    assert!(nearest.iter().all(|off| *off < 0.5), "{nearest:?}");
    assert!(never.iter().all(|off| off.is_infinite()));
    assert!(toy.driven > left_open.driven + 1.0);
}

#[test]
fn places_with_a_wall_between_them_are_no_loop() {
    // Below and above the wall at y = 3: the way round through its gap at x = 6 is longer.
    let ends = [(0.0, 2.3), (0.0, 3.7)];
    let (toy, _, nearest) = closed(ends, true, &ends);
    let (left_open, ..) = closed(ends, false, &ends);
    assert!(nearest.iter().all(|off| off.is_infinite()), "{nearest:?}");
    assert!(toy.driven == left_open.driven);
}

/// Explores the flat from a heading of `seed` rad.
fn explored(choice: FrontierChoice, return_home: bool, seed: u64) -> (Toy, Pilot) {
    let mut toy = Toy::new(flat(), Pose2::new(0.0, 0.0, seed as f64), RobotModel::rp6());
    let mut config = PilotConfig {
        return_home,
        ..PilotConfig::default()
    };
    config.frontier.choice = choice;
    let mut pilot = Pilot::new(toy.model, config, seed);
    pilot.set_mode(Mode::Explore);
    toy.run(&mut pilot, 600.0);
    assert!(
        matches!(pilot.status(), Status::Finished(Finish::Explored { .. })),
        "{choice:?}, seed {seed}: {}",
        pilot.status()
    );
    (toy, pilot)
}

#[test]
fn every_strategy_ends_by_itself_with_everything_seen_and_nothing_touched() {
    for (name, choice, _) in FrontierChoice::ALL {
        for seed in 0..4 {
            let (toy, _) = explored(choice, false, seed);
            let part = toy.explored(Point2::origin());
            assert!(part > 0.95, "{name}, seed {seed}: {part}");
            assert!(
                toy.nearest > toy.model.radius(),
                "{name}, seed {seed}: {}",
                toy.nearest
            );
        }
    }
}

#[test]
fn asked_to_come_home_it_does_and_says_the_same() {
    for seed in 0..3 {
        let (away, _) = explored(FrontierChoice::default(), false, seed);
        let (home, pilot) = explored(FrontierChoice::default(), true, seed);
        let off = |toy: &Toy| toy.pose.position().coords.length();
        // Up to that point both drove the same way.
        assert!(off(&away) > 1.0 && home.driven > away.driven + 0.9 * off(&away));
        assert!(off(&home) < 0.05, "{} m from home", off(&home));
        assert!(home.explored(Point2::origin()) > 0.95 && home.nearest > home.model.radius());
        let said = pilot.status().to_string();
        assert!(
            said.starts_with("explored") && said.ends_with("; home again"),
            "{said}"
        );
    }
}

#[test]
fn who_cannot_come_home_has_explored_all_the_same_and_says_both() {
    let mut toy = Toy::new(flat(), Pose2::identity(), RobotModel::rp6());
    let config = PilotConfig {
        return_home: true,
        ..PilotConfig::default()
    };
    let mut pilot = Pilot::new(toy.model, config, 1);
    pilot.set_mode(Mode::Explore);
    while !pilot.is_homeward() && toy.stamp().seconds() < 600.0 {
        toy.run(&mut pilot, toy.stamp().seconds() + 0.1);
    }
    // Meanwhile somebody has walled its home in.
    let corners = [(0.6, 0.6), (-0.6, 0.6), (-0.6, -0.6), (0.6, -0.6)];
    let corners = corners.map(|(x, y)| Point2::new(x, y));
    toy.walls
        .extend(sides_of(&corners).map(|(&a, &b)| Segment::new(a, b)));
    toy.run(&mut pilot, 1200.0);
    let said = pilot.status().to_string();
    assert!(said.starts_with("explored: "), "{said}");
    assert!(
        said.contains("; not home again: no way leads to (0.00, 0.00) m"),
        "{said}"
    );
    assert!(!pilot.is_homeward() && toy.explored(toy.pose.position()) > 0.9);
    assert!(toy.nearest > toy.model.radius(), "{}", toy.nearest);
}
