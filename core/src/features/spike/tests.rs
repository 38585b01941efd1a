use std::f64::consts::TAU;

use nalgebra::Point2;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::geom::unit_vector;
use crate::points::fixture::{beam_along, normal, scan_of};

/// 360 beams with these ranges; infinite ones return nothing.
fn scan(range: impl Fn(usize) -> f64) -> Points {
    scan_of((0..360).map(|i| {
        let range = range(i);
        let direction = unit_vector(TAU * i as f64 / 360.0);
        beam_along(i, direction, range.min(30.0), range < 30.0)
    }))
}

fn find(points: &Points, form: SpikeForm) -> Vec<PointFeature> {
    let config = SpikeConfig {
        form,
        ..SpikeConfig::default()
    };
    let mut found = vec![];
    spikes(points, &config, &mut found);
    found
}

const FORMS: [SpikeForm; 2] = [SpikeForm::Jump, SpikeForm::Sum];

#[test]
fn leg_of_a_table_is_one_spike_where_it_stands() {
    for form in FORMS {
        // One beam wide, and two.
        for (wide, middle) in [(1, 50.0), (2, 50.5)] {
            let points = scan(|i| {
                if (50..50 + wide).contains(&i) {
                    1.2
                } else {
                    3.0
                }
            });
            let found = find(&points, form);
            assert_eq!(found.len(), 1, "{form:?}: {found:?}");
            let at = Point2::from(unit_vector(TAU * middle / 360.0) * 1.2);
            assert!((found[0].position - at).length() < 1e-3, "{found:?}");
            assert_eq!(found[0].beams, [50, 49 + wide]);
            assert!(found[0].confidence > 0.999);
        }
    }
}

#[test]
fn both_edges_of_something_wide_are_spikes_by_jumps() {
    let points = scan(|i| if (50..60).contains(&i) { 1.0 } else { 3.0 });
    let found = find(&points, SpikeForm::Jump);
    let at: Vec<_> = found.iter().map(|f| f.position).collect();
    assert_eq!(found.len(), 2);
    // Half a step beyond the first and the last beam.
    for (position, edge) in at.iter().zip([49.5, 59.5]) {
        let truth = Point2::from(unit_vector(TAU * edge / 360.0));
        assert!(
            (position - truth).length() < 1e-4,
            "{position} against {truth}"
        );
    }
}

#[test]
fn what_does_not_stand_out_is_no_spike() {
    for form in FORMS {
        assert!(find(&scan(|_| 2.0), form).is_empty());
        // A wall that recedes from the robot at 45°.
        assert!(find(&scan(|i| 2.0 + 0.02 * i.min(360 - i) as f64), form).is_empty());
        // A jump of less than the threshold.
        let low = scan(|i| if i == 50 { 2.8 } else { 3.0 });
        assert!(find(&low, form).is_empty());
        // A hole itself is no spike: its edges are.
        let hole = scan(|i| if i == 50 { 9.0 } else { 3.0 });
        let at: Vec<_> = find(&hole, form).iter().map(|f| f.beams[0]).collect();
        assert!(!at.contains(&50), "{form:?}: {at:?}");
        // Nothing came back from around it, so nothing is known.
        let alone = scan(|i| if i == 50 { 1.0 } else { f64::INFINITY });
        assert!(find(&alone, form).is_empty());
    }
}

#[test]
fn sum_is_pilchs_sum_of_distances() {
    // By the definition, over all triples.
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for _ in 0..50 {
        let ranges: Vec<f64> = (0..360).map(|_| rng.random_range(1.0..2.0)).collect();
        let points = scan(|i| ranges[i]);
        let at = |i: usize| points.beams[i % 360].end_in_robot;
        let expected: Vec<usize> = (0..360)
            .filter(|&i| {
                let (a, b, c) = (i + 359, i, i + 1);
                let is_nearest = ranges[b] < ranges[a % 360] && ranges[b] < ranges[c % 360];
                is_nearest && (at(a) - at(b)).length() + (at(c) - at(b)).length() > 0.5
            })
            .collect();
        let found = find(&points, SpikeForm::Sum);
        let found: Vec<usize> = found.iter().map(|f| f.beams[0]).collect();
        assert_eq!(found, expected);
    }
}

#[test]
fn covariance_of_an_edge_is_honest() {
    // A wall of any slope up to 45° ends somewhere between two beams.
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let (mut sum, mut count) = (0.0, 0.0);
    for _ in 0..3000 {
        let end = rng.random_range(0.2..0.8);
        let slope = rng.random_range(-1.0..1.0);
        // The wall through the end, at polar angle `end`, range 2.
        let truth = Point2::from(unit_vector(end) * 2.0);
        let across = Vector2::new(-truth.y, truth.x) / 2.0;
        let along = across - truth.coords * (0.5 * slope);
        let noise: Vec<f64> = (0..360).map(|_| normal(&mut rng)).collect();
        let points = scan(|i| {
            let direction = unit_vector(TAU * i as f64 / 360.0);
            let to_wall = truth.coords.perp(&along) / direction.perp(&along);
            let is_wall = TAU * (i as f64) / 360.0 <= end && i < 60;
            if is_wall {
                to_wall + 0.01 * noise[i]
            } else {
                8.0
            }
        });
        for found in find(&points, SpikeForm::Jump) {
            let error = found.position - truth;
            if error.length() < 0.2 {
                sum += error.dot(&found.cov.cholesky().unwrap().solve(&error));
                count += 1.0;
            }
        }
    }
    let mean = sum / count;
    assert!(count > 2900.0, "{count} found");
    // At most what it claims, and at least a third of that.
    assert!((0.7..2.05).contains(&mean), "mean NEES {mean}");
}
