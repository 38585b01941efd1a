//! Advice follows the table.

use super::*;

#[test]
fn the_table_names_every_method_in_order() {
    let names = CloudMethod::all().map(|(name, _)| name);
    for condition in &MEASURED {
        assert_eq!(condition.methods.map(|method| method.name), names);
        for method in &condition.methods {
            let parts = [method.found[0], method.found[1], method.wrong];
            assert!(parts.iter().all(|part| (0.0..=1.0).contains(part)));
            assert!(method.micros > 0.0);
        }
    }
}

#[test]
fn scans_as_they_were_measured_get_what_did_best_there() {
    for condition in &MEASURED {
        for (shift, turn, which) in [(0.1, -0.1, 1), (0.9, 0.1, 0), (0.1, -0.5, 0)] {
            let advice = advise(&condition.likeness, shift, turn).unwrap();
            assert_eq!(advice.condition.name, condition.name);
            assert_eq!(advice.is_near, which == 1);
            let found = condition.methods.iter().map(|method| method.found[which]);
            let best = found.fold(0.0, f64::max);
            assert_eq!(advice.surest.found[which], best);
            assert!(advice.method.found[which] >= best - 0.03);
            for method in &condition.methods {
                let is_as_good = method.found[which] >= best - 0.03;
                assert!(!is_as_good || method.micros >= advice.method.micros);
                assert!(method.micros >= advice.fastest.micros);
            }
        }
    }
}

#[test]
fn likeness_tells_noise_and_outliers_and_overlap() {
    let truth = Pose2::new(0.25, -0.15, 0.12);
    let judge = JudgeConfig::default();
    let of = |sigma: f64| {
        let fixed = look(&room(), &Pose2::identity(), sigma, 60);
        let moving = look(&room(), &truth, sigma, 61);
        likeness(&moving, &fixed, &truth, &judge)
    };
    let (clean, noisy) = (of(0.01), of(0.03));
    assert!(clean.overlap > 0.8 && clean.scatter < 0.1, "{clean:?}");
    assert!((clean.sigma - 0.01).abs() < 0.004, "{clean:?}");
    assert!((noisy.sigma - 0.03).abs() < 0.01, "{noisy:?}");
    // A third of the points lie anywhere in front of the walls.
    let fixed = look(&room(), &Pose2::identity(), 0.01, 60);
    let cut = |(index, point): (usize, &Point2<f64>)| match index % 3 {
        0 => Point2::from(point.coords * (0.2 + 0.07 * ((index / 3 * 7) % 11) as f64)),
        _ => *point,
    };
    let cut: Vec<_> = fixed.points().iter().enumerate().map(cut).collect();
    let spoiled = Cloud::scan(cut).unwrap();
    let spoiled = likeness(&spoiled, &fixed, &Pose2::identity(), &judge);
    assert!(spoiled.scatter > clean.scatter + 0.1, "{spoiled:?}");
    assert!(spoiled.overlap < 0.75, "{spoiled:?}");
    // From a place where half of the room was not seen.
    let half: Vec<_> = fixed
        .points()
        .iter()
        .copied()
        .filter(|p| p.y > 0.0)
        .collect();
    let half = likeness(
        &fixed,
        &Cloud::scan(half).unwrap(),
        &Pose2::identity(),
        &judge,
    );
    assert!(half.overlap < 0.7, "{half:?}");
    assert!((half.scatter - clean.scatter).abs() < 0.1, "{half:?}");
}
