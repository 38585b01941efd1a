//! The counts of finding again agree with the filter's own report, scan by scan; and most are right
//! in a plain world.

use super::*;
use crate::estimation::LandmarkKinds;

const GATE: f64 = 10.0;

fn exploring(world: &str, landmarks: LandmarkKinds, method: crate::slam::Method) -> Experiment {
    let world = worlds::builtin(world).unwrap();
    let robot = world.robot.model();
    let mut config = ExperimentConfig::new(world, robot, SensorKind::Lidar.model(), 5);
    config.method = method;
    config.slam.ekf.landmarks = landmarks;
    Experiment::new(config).unwrap()
}

#[test]
fn counts_are_those_of_the_report_and_mostly_right() {
    for (landmarks, has_points) in [(LandmarkKinds::Lines, false), (LandmarkKinds::Both, true)] {
        let mut run = exploring("arena", landmarks, crate::slam::Method::LineEkf);
        // By brute force: how many were seen, and for how many the nearest candidate that is not
        // another part of a wall lies within the gate.
        let gate = nearest_gate(&run);
        let (mut seen, mut found, mut points) = (0, 0, 0);
        for _ in 0..400 {
            if !run.step().unwrap() {
                continue;
            }
            let slam = run.session().slam();
            let report = slam.view().update.unwrap();
            let max_gap = slam.config().ekf.association.max_gap;
            points += report.point_explanations().count();
            for seen_now in report.explanations().chain(report.point_explanations()) {
                seen += 1;
                let own = seen_now.candidates.iter().filter(|c| c.gap <= max_gap);
                let d2 = own.map(|c| c.d2).fold(f64::INFINITY, f64::min);
                found += usize::from(d2 <= gate);
            }
        }
        let counts = run.refinding().points().iter().find(|p| p.0 == gate);
        let counts = counts.unwrap().1;
        // For nearly all of them, the world knows what they show.
        let within = |part: usize, whole: usize| part <= whole && 10 * part >= 8 * whole;
        let judged = counts.with_partner + counts.without;
        assert!(within(judged, seen), "{judged} of {seen}");
        let judged = counts.right + counts.wrong;
        assert!(within(judged, found), "{judged} of {found}");
        assert!(counts.right <= counts.with_partner && counts.taken <= counts.without);
        assert_eq!(points > 0, has_points);
        assert!(seen > 300, "{seen}");
        assert!(counts.tpr() > 0.9, "{landmarks:?}: {counts:?}");
        assert!(counts.ppv() > 0.95, "{landmarks:?}: {counts:?}");
    }
}

/// The gate of the curve that is nearest to [`GATE`].
fn nearest_gate(run: &Experiment) -> f64 {
    let gates = run.refinding().points().iter().map(|p| p.0);
    let off = |gate: &f64| (gate - GATE).abs();
    gates.min_by(|a, b| off(a).total_cmp(&off(b))).unwrap()
}

#[test]
fn a_method_without_landmarks_has_nothing_to_count() {
    let method = crate::slam::Method::ScanMatching;
    let mut run = exploring("arena", LandmarkKinds::Lines, method);
    for _ in 0..40 {
        run.step().unwrap();
    }
    let points = run.refinding().points();
    assert!(points.iter().all(|(_, c)| c.with_partner + c.without == 0));
    assert!(!points.is_empty());
}
