use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use super::*;
use crate::association::AssociationMethod;
use crate::geom::{CHI2_2DOF_99, Length};

const CONFIG: AssociationConfig = AssociationConfig {
    method: AssociationMethod::Joint,
    gate: CHI2_2DOF_99,
    new_gate: 25.0,
    outlier_gate: f64::INFINITY,
    ambiguity: 0.0,
    max_gap: 0.5,
    same_place: 0.03,
    most_sets: 20_000,
};

fn joint_matches(
    candidates: &[Vec<Pairing>],
    cross: impl Fn(&Pairing, &Pairing) -> Option<Matrix2<f64>>,
    config: &AssociationConfig,
) -> JointSearch {
    let mut search = JointSearch::default();
    for own in candidates {
        search.sight(own.iter().copied());
    }
    search.run(cross, config);
    search
}

/// The covariance of the innovations of two pairings whose only common error is `sigma` along r.
fn common(sigma: f64) -> impl Fn(&Pairing, &Pairing) -> Option<Matrix2<f64>> {
    move |a, b| (a.landmark != b.landmark).then(|| Matrix2::new(0.0, 0.0, 0.0, sigma * sigma))
}

/// All sets by brute force, each with the dense inverse: the size and the distance of the best.
fn brute_force(
    candidates: &[Vec<Pairing>],
    cross: &dyn Fn(&Pairing, &Pairing) -> Option<Matrix2<f64>>,
) -> (usize, f64) {
    let sets = candidates.iter().map(|c| c.len() + 1).product();
    let mut best = (0, 0.0);
    for mut number in 0..sets {
        let mut set = vec![];
        for own in candidates {
            if let Some(pairing) = own.get(number % (own.len() + 1)) {
                set.push(*pairing);
            }
            number /= own.len() + 1;
        }
        // As in the search, each beginning of a set must also pass.
        let mut d2 = 0.0;
        let passes = (1..=set.len()).all(|m| {
            d2 = distance(&set[..m], cross).unwrap_or(f64::INFINITY);
            chi2_survival(d2, m) >= libm::exp(-0.5 * CHI2_2DOF_99)
        });
        let m = set.len();
        if passes && (m > best.0 || (m == best.0 && m > 0 && d2 < best.1)) {
            best = (m, d2);
        }
    }
    best
}

/// Joint distance by the dense inverse; `None` if two exclude each other.
fn distance(
    set: &[Pairing],
    cross: &dyn Fn(&Pairing, &Pairing) -> Option<Matrix2<f64>>,
) -> Option<f64> {
    let m = set.len();
    let mut c = DMatrix::zeros(2 * m, 2 * m);
    for (i, a) in set.iter().enumerate() {
        c.view_mut((2 * i, 2 * i), (2, 2)).copy_from(&a.cov);
        for (j, b) in set.iter().enumerate().take(i) {
            let block = cross(a, b)?;
            c.view_mut((2 * i, 2 * j), (2, 2)).copy_from(&block);
            c.view_mut((2 * j, 2 * i), (2, 2))
                .copy_from(&block.transpose());
        }
    }
    let v = DVector::from_iterator(2 * m, set.iter().flat_map(|p| [p.v.x, p.v.y]));
    Some((v.transpose() * c.try_inverse()? * v)[0])
}

/// Walls seen from a pose whose uncertainty along the normal of all of them is `sigma`.
fn parallel(shift: f64, sigma: f64, spacing: f64, n: usize) -> Vec<Vec<Pairing>> {
    let noise = Matrix2::new(1e-4, 0.0, 0.0, 1e-4);
    let pose = Matrix2::new(0.0, 0.0, 0.0, sigma * sigma);
    (0..n)
        .map(|sighting| {
            let seen = sighting as f64 * spacing + shift;
            (0..n)
                .map(|landmark| Pairing {
                    sighting,
                    landmark,
                    v: Vector2::new(0.0, seen - landmark as f64 * spacing),
                    cov: pose + noise,
                })
                .filter(|p| p.v.dot(&(p.cov.try_inverse().unwrap() * p.v)) < CHI2_2DOF_99)
                .collect()
        })
        .collect()
}

#[test]
fn walls_shifted_together_are_matched_together_where_the_nearest_are_wrong() {
    // Three walls 0.3 m apart, seen from 0.2 m further back than believed.
    let candidates = parallel(-0.2, 0.15, 0.3, 3);
    let cross = common(0.15);
    let nearest = |own: &Vec<Pairing>| {
        let by_size = |a: &&Pairing, b: &&Pairing| a.v.length().total_cmp(&b.v.length());
        own.iter().min_by(by_size).map(|p| p.landmark)
    };
    let by_nearest: Vec<_> = candidates.iter().map(nearest).collect();
    assert_eq!(by_nearest, [Some(0), Some(0), Some(1)]);
    let found = joint_matches(&candidates, &cross, &CONFIG);
    assert_eq!(found.paired, [0, 1, 2].map(Paired::Landmark));
    assert!(found.n_sets < CONFIG.most_sets);
}

/// A sighting of each of `n` landmarks, `v` off along r, with noise of 1 cm.
fn each_its_own(v: &[f64], sigma: f64) -> Vec<Vec<Pairing>> {
    let cov = Matrix2::new(1e-4, 0.0, 0.0, 1e-4 + sigma * sigma);
    let pairing = |(landmark, v): (usize, &f64)| Pairing {
        sighting: landmark,
        landmark,
        v: Vector2::new(0.0, *v),
        cov,
    };
    v.iter().enumerate().map(|p| vec![pairing(p)]).collect()
}

#[test]
fn one_that_contradicts_nine_others_is_dropped_though_their_gate_has_room_for_it() {
    let mut v = [0.2; 10];
    v[3] += 0.045;
    let candidates = each_its_own(&v, 0.2);
    let lenient = joint_matches(&candidates, common(0.2), &CONFIG);
    assert!(lenient.paired.iter().all(|p| *p != Paired::Nothing));
    let config = AssociationConfig {
        outlier_gate: 13.82,
        ..CONFIG
    };
    let found = joint_matches(&candidates, common(0.2), &config);
    for (sighting, paired) in found.paired.iter().enumerate() {
        assert_eq!(*paired == Paired::Nothing, sighting == 3, "{sighting}");
    }
}

#[test]
fn what_two_walls_explain_as_well_is_ambiguous_but_for_walls_at_one_place() {
    let config = AssociationConfig {
        ambiguity: 4.0,
        ..CONFIG
    };
    for (apart, is_ambiguous) in [(0.032, true), (0.02, false), (0.2, false)] {
        // Three walls fix the pose to 1 cm; the fourth could be another one as well.
        let mut candidates = each_its_own(&[0.1; 4], 0.2);
        candidates[3][0].v.y += 0.008;
        let mut rival = candidates[3][0];
        rival.landmark = 9;
        rival.v.y -= apart;
        candidates[3].push(rival);
        let found = joint_matches(&candidates, common(0.2), &config);
        let expect = match is_ambiguous {
            true => Paired::Ambiguous,
            false => Paired::Landmark(3),
        };
        assert_eq!(found.paired[3], expect, "{apart}");
        assert_eq!(found.paired[..3], [0, 1, 2].map(Paired::Landmark));
    }
}

#[test]
fn survival_is_that_of_the_tables() {
    assert!((chi2_survival(5.991_464_547, 1) - 0.05).abs() < 1e-9);
    assert!((chi2_survival(9.487_729, 2) - 0.05).abs() < 1e-6);
    assert!((chi2_survival(37.566_235, 10) - 0.01).abs() < 1e-6);
}

#[test]
fn search_that_is_cut_short_has_looked_at_as_many_sets_as_it_may() {
    let config = AssociationConfig {
        most_sets: 2,
        ..CONFIG
    };
    let candidates = parallel(0.1, 0.5, 0.05, 6);
    assert_eq!(joint_matches(&candidates, common(0.5), &config).n_sets, 2);
}

proptest! {
    #[test]
    fn search_finds_what_brute_force_finds(
        shift in -0.4..0.4_f64, sigma in 0.02..0.4_f64, spacing in 0.05..0.5_f64,
        noise in prop::collection::vec((-0.02..0.02_f64, -0.03..0.03_f64), 4),
    ) {
        let mut candidates = parallel(shift, sigma, spacing, 4);
        for (own, (da, dr)) in candidates.iter_mut().zip(&noise) {
            for pairing in own.iter_mut() {
                pairing.v += Vector2::new(*da, *dr);
            }
        }
        let cross = common(sigma);
        let found = joint_matches(&candidates, &cross, &CONFIG);
        let size = found.paired.iter().filter(|p| **p != Paired::Nothing).count();
        let (best, d2) = brute_force(&candidates, &cross);
        prop_assert!(found.n_sets < CONFIG.most_sets);
        prop_assert_eq!(size, best);
        prop_assert!(best == 0 || (found.d2 - d2).abs() < 1e-6 * (1.0 + d2), "{} {d2}", found.d2);
    }

    #[test]
    fn worst_member_is_that_of_dense_conditioning(
        v in prop::collection::vec(-0.3..0.3_f64, 2..7), sigma in 0.0..0.3_f64,
    ) {
        let candidates = each_its_own(&v, sigma);
        let all: Vec<Pairing> = candidates.concat();
        let cross = common(sigma);
        let mut members = Members::default();
        for place in 0..all.len() {
            members.join(place, &all, &cross);
        }
        // What a member adds to the distance of all others, by dense inverses.
        let whole = distance(&all, &cross).unwrap();
        let added = |i: usize| {
            let mut others = all.clone();
            others.remove(i);
            whole - distance(&others, &cross).unwrap()
        };
        let most = (0..all.len()).map(added).fold(0.0, f64::max);
        let (worst, d2) = members.worst();
        prop_assert!((d2 - most).abs() < 1e-6 * (1.0 + most), "{d2} {most}");
        prop_assert!((added(worst) - most).abs() < 1e-6 * (1.0 + most));
    }
}
