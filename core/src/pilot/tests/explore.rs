//! Explorations of the flat, by every strategy and home again.

use super::*;
use crate::geom::{Length, sides_of};
use crate::plan::FrontierChoice;

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
        // Up to there both drove the same.
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
