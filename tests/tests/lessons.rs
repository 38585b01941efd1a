//! Lessons are headless runs: each fails as given, and passes with a mend that a person can find.

#![cfg(not(target_family = "wasm"))]
// A test binary has no public interface, and failing is its trade.
#![allow(missing_docs, clippy::expect_used)]

use std::thread;

use slamlab_core::experiment::{Experiment, Link};
use slamlab_core::lesson::{Grade, LESSONS, Lesson};
use slamlab_core::sim::reachable_area;
use slamlab_core::slam::Method;

/// What mends each lesson: another method, settings.
type Mend = (&'static str, Option<Method>, &'static [(&'static str, f64)]);

const MENDS: &[Mend] = &[
    ("blind-faith", Some(Method::ScanMatching), &[]),
    ("shy", None, &[("pilot.gap", 0.05)]),
    ("short-sighted", None, &[("points.max_range", 12.0)]),
    ("long-walls", None, &[("lines.min_length", 0.5)]),
    (
        "narrow-gate",
        None,
        &[("ekf.gate", 6.0), ("ekf.new_gate", 9.0)],
    ),
    (
        "perfect-wheels",
        None,
        &[
            ("odometry.per_metre", 2.5e-4),
            ("odometry.lateral", 1e-4),
            ("odometry.turn", 1e-3),
        ],
    ),
    ("crooked", None, &[("odometry.left", 0.06)]),
    ("carried-off", Some(Method::ParticleLocalisation), &[]),
    (
        "too-sure",
        None,
        &[
            ("ekf.consistency", 1.0),
            ("ekf.prior_curvature", 0.1),
            ("ekf.prior_turn", 0.05),
        ],
    ),
    ("one-story", None, &[("mapping.particles", 40.0)]),
];

fn graded(lesson: &Lesson, link: &Link) -> Grade {
    let (config, _) = link.config().expect("a run");
    let area = reachable_area(&config.world, config.robot.radius(), 0.05);
    let mut run = Experiment::new(config).expect("a run");
    run.follow(link.actions.clone());
    while !lesson.is_over(&run) {
        run.step().expect("a good scan");
    }
    lesson.grade(&run, &area)
}

fn mended(&(name, method, changes): &Mend) -> Link {
    let changes: Vec<_> = (changes.iter())
        .map(|&(key, number)| (key.to_owned(), number))
        .collect();
    let lesson = Lesson::named(name).expect(name);
    lesson.mended(method, &changes).expect(name)
}

#[test]
fn each_fails_as_it_is_given_and_can_be_mended() {
    let names = |of: &mut dyn Iterator<Item = &'static str>| of.collect::<Vec<_>>();
    assert_eq!(
        names(&mut MENDS.iter().map(|mend| mend.0)),
        names(&mut LESSONS.iter().map(|lesson| lesson.name)),
        "a mend for each lesson"
    );
    let failures: Vec<String> = thread::scope(|scope| {
        let runs = MENDS.iter().zip(LESSONS).map(|(mend, lesson)| {
            scope.spawn(move || {
                let given = graded(lesson, &lesson.begin().expect("a link"));
                let mended = graded(lesson, &mended(mend));
                let name = lesson.name;
                let mut wrong = vec![];
                if given.is_passed() {
                    wrong.push(format!("{name} passes unmended: {given:?}"));
                }
                if !mended.is_passed() {
                    wrong.push(format!("{name} cannot be mended: {mended:?}"));
                }
                wrong
            })
        });
        let runs: Vec<_> = runs.collect();
        (runs.into_iter())
            .flat_map(|run| run.join().expect("no panic"))
            .collect()
    });
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
