use super::*;
use crate::experiment::Experiment;
use crate::sim::reachable_area;

#[test]
fn every_lesson_begins_and_has_what_it_speaks_of() {
    let mut names: Vec<&str> = LESSONS.iter().map(|lesson| lesson.name).collect();
    for lesson in LESSONS {
        let link = lesson.begin().expect("a link");
        let (config, _) = link.config().expect("a run");
        Experiment::new(config).expect("a run");
        assert_eq!(lesson.check(&link), Ok(()), "{}", lesson.name);
        assert_eq!(Lesson::named(lesson.name), Some(lesson));
        assert!(!lesson.goals.is_empty() && lesson.seconds > 0.0);
        for text in [lesson.title, lesson.fault, lesson.task, lesson.hint] {
            assert!(!text.is_empty(), "{} is silent", lesson.name);
        }
        for key in lesson.given {
            assert!(settings::find(key).is_ok(), "{}: {key}", lesson.name);
        }
    }
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), LESSONS.len(), "a name is there twice");
    assert_eq!(Lesson::named("no-such"), None);
}

#[test]
fn every_measure_has_its_name() {
    let named = [
        (Measure::Explored, "explored"),
        (Measure::TrajectoryError, "trajectory-error"),
        (Measure::PositionError, "position-error"),
        (Measure::WheelDrift, "wheel-drift"),
        (Measure::Nees, "nees"),
        (Measure::Contacts, "contacts"),
    ];
    assert_eq!(named.len(), Measure::NAMES.len());
    for (measure, name) in named {
        assert_eq!(measure.name(), name);
    }
}

#[test]
fn what_was_mended_takes_the_place_of_the_fault() {
    let lesson = Lesson::named("shy").unwrap();
    let change = [("pilot.gap".to_owned(), 0.05)];
    let link = lesson.mended(None, &change).unwrap();
    assert_eq!(link.settings, change);
}

#[test]
fn the_fault_cannot_be_taken_away_instead() {
    let crooked = Lesson::named("crooked").unwrap();
    let straight = crooked.mended(None, &[("wear.left".to_owned(), 0.0)]);
    let words = straight.expect_err("it is given").to_string();
    assert!(
        words.contains("`wear.left`") && words.contains("0.06"),
        "{words}"
    );
    // Not in the link, but still a property of the world.
    let other = crooked.mended(None, &[("wear.right".to_owned(), 0.06)]);
    assert!(matches!(
        other,
        Err(NotOfLesson::Given {
            key: "wear.right",
            ..
        })
    ));
    let by_default = crooked.mended(None, &[("wear.right".to_owned(), 0.0)]);
    assert!(by_default.is_ok(), "{by_default:?}");
    let method = crooked.mended(Some(Method::ScanMatching), &[]);
    let words = method.expect_err("by this method").to_string();
    assert!(
        words.contains("`line-ekf`") && words.contains("`scan-matching`"),
        "{words}"
    );
    let free = Lesson::named("blind-faith").unwrap();
    assert!(free.mended(Some(Method::ScanMatching), &[]).is_ok());
    for (what, given, other) in [
        ("world", "world=doors", "world=arena"),
        ("seed", "seed=7", "seed=8"),
        ("sensor", "sensor=lidar", "sensor=sonar"),
    ] {
        let text = free.link.replace(given, other);
        let link = Link::read(&text).expect("a link");
        let refused = free.check(&link).expect_err(what).to_string();
        assert!(refused.contains(what), "{refused}");
    }
}

#[test]
fn it_is_graded_when_its_time_is_up() {
    let lesson = Lesson {
        seconds: 1.0,
        ..*Lesson::named("shy").unwrap()
    };
    let (config, _) = lesson.begin().unwrap().config().unwrap();
    let area = reachable_area(&config.world, config.robot.radius(), 0.05);
    let mut run = Experiment::new(config).unwrap();
    while run.seconds() < 0.99 {
        assert!(!lesson.grade(&run, &area).is_over);
        run.step().unwrap();
    }
    let grade = lesson.grade(&run, &area);
    assert!(grade.is_over && !grade.is_passed());
    let met: Vec<bool> = grade.marks.iter().map(|mark| mark.is_met).collect();
    assert_eq!(met, [false, true], "little is seen, nothing touched");
}
