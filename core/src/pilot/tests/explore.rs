//! Explorations of the flat, by every strategy and home again.

use super::*;
use crate::plan::FrontierChoice;

/// Explores the flat from a heading of `seed` rad.
fn explored(choice: FrontierChoice, return_home: bool, seed: u64) -> (Toy, Pilot) {
    let home = Point2::origin();
    explored_from(home, choice, return_home, seed)
}

fn explored_from(
    home: Point2<f64>,
    choice: FrontierChoice,
    return_home: bool,
    seed: u64,
) -> (Toy, Pilot) {
    let mut toy = Toy::new(flat(), Pose2::new(0.0, 0.0, seed as f64), RobotModel::rp6());
    let mut config = PilotConfig {
        return_home,
        ..PilotConfig::default()
    };
    config.frontier.choice = choice;
    let mut pilot = Pilot::new(toy.model, config, seed).at_home(home);
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
        let off = |toy: &Toy| toy.pose.position().coords.norm();
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
fn home_is_where_it_is_told_that_it_began() {
    let began = Point2::new(1.0, 0.5);
    let (toy, pilot) = explored_from(began, FrontierChoice::default(), true, 1);
    let off = (toy.pose.position() - began).norm();
    assert!(off < 0.05, "{off} m from home: {}", pilot.status());
}

#[test]
fn who_cannot_come_home_has_explored_all_the_same_and_says_both() {
    // Beyond the walls of the flat.
    let outside = Point2::new(40.0, 0.0);
    let (toy, pilot) = explored_from(outside, FrontierChoice::default(), true, 1);
    let said = pilot.status().to_string();
    assert!(
        said.contains("; not home again: no way leads to (40.00, 0.00) m"),
        "{said}"
    );
    assert!(!pilot.is_homeward() && toy.explored(Point2::origin()) > 0.95);
}
