use nalgebra::{Point2, Vector2};
use proptest::prelude::*;

use super::*;
use crate::geom::{Length, Pose2, Segment};
use crate::points::SpacingModel;
use crate::points::fixture::{beam_along, range_to, scan_of};

/// `n` beams from the origin around the circle (or the arc `from..to`, degrees) against walls.
fn look(walls: &[Segment], n: usize, from: f64, to: f64) -> Points {
    let beams = (0..n).map(|i| {
        let bearing = (from + (to - from) * i as f64 / n as f64).to_radians();
        let direction = Vector2::new(libm::cos(bearing), libm::sin(bearing));
        let range = range_to(walls, &Pose2::identity(), direction);
        beam_along(i, direction, range.min(12.0), range < 12.0)
    });
    scan_of(beams)
}

fn wall(ax: f64, ay: f64, bx: f64, by: f64) -> Segment {
    Segment::new(Point2::new(ax, ay), Point2::new(bx, by))
}

fn room() -> Vec<Segment> {
    vec![
        wall(-2.0, -1.5, 3.0, -1.5),
        wall(3.0, -1.5, 3.0, 2.0),
        wall(3.0, 2.0, -2.0, 2.0),
        wall(-2.0, 2.0, -2.0, -1.5),
    ]
}

fn runs(points: &Points, config: &SegmentationConfig) -> Vec<Run> {
    let mut runs = vec![];
    segment(points, config, &mut runs);
    runs
}

#[test]
fn closed_room_is_one_run_that_starts_in_a_corner() {
    let points = look(&room(), 360, 0.0, 360.0);
    let runs = runs(&points, &SegmentationConfig::default());
    assert_eq!(runs.len(), 1);
    assert_eq!(runs[0].len, 360);
    let start = runs[0].beams(&points).next().unwrap().end_in_robot;
    assert!((start - Point2::new(3.0, 2.0)).length() < 0.06, "{start}");
}

#[test]
fn wall_across_the_first_beam_is_one_run() {
    // Beam 0 points at the middle of the only wall.
    let points = look(&[wall(2.0, -1.0, 2.0, 1.0)], 360, 0.0, 360.0);
    let runs = runs(&points, &SegmentationConfig::default());
    assert_eq!(runs.len(), 1);
    let ends: Vec<_> = runs[0].beams(&points).map(|b| b.end_in_robot.y).collect();
    assert!(ends.windows(2).all(|w| w[0] < w[1]) && ends.len() == runs[0].len);
}

#[test]
fn half_circle_is_not_closed() {
    let points = look(&room(), 180, -90.0, 90.0);
    let runs = runs(&points, &SegmentationConfig::default());
    assert_eq!(runs, [Run { first: 0, len: 180 }]);
}

#[test]
fn box_in_front_of_a_wall_is_a_run_of_its_own() {
    let walls = [wall(4.0, -3.0, 4.0, 3.0), wall(2.0, -0.3, 2.0, 0.3)];
    let points = look(&walls, 360, -180.0, 180.0);
    let runs = runs(&points, &SegmentationConfig::default());
    assert_eq!(runs.len(), 3, "{runs:?}");
    assert!(
        runs[1]
            .beams(&points)
            .all(|b| (b.end_in_robot.x - 2.0).abs() < 1e-9)
    );
}

#[test]
fn no_return_breaks_a_wall() {
    let mut points = look(&[wall(2.0, -2.0, 2.0, 2.0)], 360, -180.0, 180.0);
    points.beams[180].is_hit = false;
    assert_eq!(runs(&points, &SegmentationConfig::default()).len(), 2);
}

/// Number of runs by the adaptive, the mean and the spacing rule for half a degree a beam.
fn by_each_rule(points: &Points) -> [usize; 3] {
    let count = |rule| {
        let config = SegmentationConfig {
            rule,
            ..SegmentationConfig::default()
        };
        runs(points, &config).len()
    };
    let spacing = SpacingModel::even(720.0);
    [
        count(BreakRule::default()),
        count(BreakRule::MeanRatio { ratio: 4.0 }),
        count(BreakRule::Spacing {
            spacing,
            ratio: 2.0,
        }),
    ]
}

#[test]
fn slit_seen_head_on_fools_the_adaptive_rule_alone() {
    // A narrow slit between two walls on one line: the beams through it are lost, and the surface
    // could go on.
    let walls = [wall(1.0, -1.0, 1.0, -0.04), wall(1.0, 0.04, 1.0, 1.0)];
    let mut points = look(&walls, 360, -90.0, 90.0);
    points.beams.retain(|b| b.is_hit);
    assert_eq!(by_each_rule(&points), [1, 2, 2]);
}

#[test]
fn long_wall_beside_the_robot_is_whole_by_the_adaptive_rule_alone() {
    // Far beams are far apart.
    let points = look(&[wall(-1.0, 1.0, 5.0, 1.0)], 720, -180.0, 180.0);
    let [adaptive, mean, spacing] = by_each_rule(&points);
    assert_eq!(adaptive, 1);
    assert!(mean > 1 && spacing > 1, "{mean} {spacing}");
}

#[test]
fn slit_beside_a_deep_step_is_found_by_the_spacing_rule_alone() {
    // The steps to the wall behind raise the mean distance so much that the slit is missed.
    let walls = [
        wall(1.0, -1.0, 1.0, -0.04),
        wall(1.0, 0.04, 1.0, 1.0),
        wall(6.0, -9.0, 6.0, 9.0),
    ];
    let mut points = look(&walls, 360, -90.0, 90.0);
    // The beams through the slit are lost.
    let through = |b: &Beam| b.end_in_robot.x > 5.0 && b.end_in_robot.y.abs() < 0.3;
    points.beams.retain(|b| b.is_hit && !through(b));
    let near = |rule| {
        let config = SegmentationConfig {
            rule,
            ..SegmentationConfig::default()
        };
        let is_near = |run: &&Run| run.beams(&points).all(|b| b.end_in_robot.x < 1.1);
        runs(&points, &config).iter().filter(is_near).count()
    };
    let spacing = SpacingModel::even(720.0);
    assert_eq!(near(BreakRule::default()), 1);
    assert_eq!(near(BreakRule::MeanRatio { ratio: 4.0 }), 1);
    assert_eq!(
        near(BreakRule::Spacing {
            spacing,
            ratio: 2.0
        }),
        2
    );
}

#[test]
fn short_cut_of_the_adaptive_rule_changes_no_verdict() {
    // The bound as written, for pairs of beams all over the plane.
    let rule = rules::Adaptive::new(0.17, 3.0, 0.12);
    let (mut verdicts, mut sure) = ([0_usize; 2], 0);
    for i in 0..200 {
        for j in 0..200 {
            let (ra, rb, step) = (
                1.0 + 0.02 * f64::from(i),
                1.0 + 0.02 * f64::from(j),
                0.001 * f64::from(1 + (i * 7 + j) % 110),
            );
            let mut pair = look(&[], 2, 0.0, 2.0 * step.to_degrees()).beams;
            for (beam, range) in pair.iter_mut().zip([ra, rb]) {
                beam.end_in_robot = Point2::from(beam.end_in_robot.coords * (range / beam.range));
                beam.range = range;
            }
            let apart = (pair[0].end_in_robot - pair[1].end_in_robot).length();
            let allowed = ra.min(rb) * libm::sin(step)
                / libm::sin(0.17 - step).max(0.5 * libm::sin(0.17))
                + 3.0 * 0.01 * std::f64::consts::SQRT_2;
            let mut surely = [f64::NAN; CHUNK];
            rule.join_surely(&pair, 0..2, &mut surely);
            if surely[1] > 0.0 {
                assert!(apart < allowed);
                sure += 1;
            }
            if (apart - allowed).abs() > 1e-9 {
                assert_eq!(
                    rule.joins(&Ray::of(&pair[0]), &Ray::of(&pair[1])),
                    apart < allowed
                );
                verdicts[usize::from(apart < allowed)] += 1;
            }
        }
    }
    assert!(verdicts.iter().all(|&n| n > 1_000), "{verdicts:?}");
    // It decides most pairs that the full rule joins.
    assert!(2 * sure > verdicts[1], "{sure} of {}", verdicts[1]);
}

#[test]
fn nothing_to_see_gives_no_run() {
    assert!(runs(&look(&[], 360, 0.0, 360.0), &SegmentationConfig::default()).is_empty());
    assert!(
        runs(
            &look(&room(), 0, 0.0, 360.0),
            &SegmentationConfig::default()
        )
        .is_empty()
    );
    assert_eq!(
        runs(
            &look(&room(), 1, 0.0, 360.0),
            &SegmentationConfig::default()
        )
        .len(),
        1
    );
}

proptest! {
    #[test]
    fn every_hit_is_in_exactly_one_run(
        ranges in prop::collection::vec((0.1..12.0_f64, prop::bool::weighted(0.9)), 0..80), ratio in 1.5..6.0_f64, which in 0..3_u8,
    ) {
        let mut points = look(&[], ranges.len(), 0.0, 360.0);
        for (beam, (range, is_hit)) in points.beams.iter_mut().zip(&ranges) {
            let direction = beam.end_in_robot.coords / beam.range;
            beam.range = *range;
            beam.end_in_robot = Point2::from(direction * *range);
            beam.is_hit = *is_hit;
        }
        let rule = match which {
            0 => BreakRule::default(),
            1 => BreakRule::MeanRatio { ratio },
            _ => BreakRule::Spacing { spacing: SpacingModel::even(360.0), ratio },
        };
        let config = SegmentationConfig { rule, ..SegmentationConfig::default() };
        let mut seen: Vec<_> = runs(&points, &config).iter().flat_map(|r| r.beams(&points).map(|b| b.beam_idx).collect::<Vec<_>>()).collect();
        seen.sort_unstable();
        let hits: Vec<_> = points.hits().map(|b| b.beam_idx).collect();
        prop_assert_eq!(seen, hits);
    }
}
