//! In: for each line of a scan, the landmarks that it may be. Out: the largest set of pairings that agree with each other.
//!
//! Each pairing by itself may be within its gate and yet contradict the others: a robot that stands 20 cm from where it believes
//! to be sees all walls shifted by 20 cm the same way. The errors of what is expected hang together, through the one pose that
//! they are expected from, and the joint distance of a set of pairings knows it.
//!
//! 1. Depth first over the sightings: each is one of its candidates, or none.
//! 2. A set of m pairings is kept while its joint distance vᵀ C⁻¹ v is within the gate of χ² with 2m degrees of freedom. C's
//!    Cholesky factor grows by two rows for each pairing, so a step costs O(m²).
//! 3. A branch that cannot have more pairings than the best one so far is cut; of two sets of one size the nearer one wins.
//!
//! Source: Neira & Tardós (2001), "Data association in stochastic mapping using the joint compatibility test", algorithm JCBB.

use nalgebra::{Matrix2, Vector2};

/// A landmark that a sighting may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pairing {
    /// Number of the sighting.
    pub sighting: usize,
    /// Index of the landmark.
    pub landmark: usize,
    /// (α, r) seen less expected.
    pub v: Vector2<f64>,
    /// Covariance of `v`.
    pub cov: Matrix2<f64>,
}

/// How far to search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointConfig {
    /// Gate of a single pairing, d²; sets of pairings have the gate of the same probability. Default 9.21, 99 %.
    pub gate: f64,
    /// Sets looked at before the best one so far is taken. Default 20 000: the worst case grows exponentially.
    pub most_sets: usize,
}

/// The pairings that agree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointMatches {
    /// For each sighting in the order of the candidates, its place in their list; `None` where none fits the others.
    pub chosen: Vec<Option<usize>>,
    /// Joint distance, χ² with twice as many degrees of freedom as there are pairings.
    pub d2: f64,
    /// Whether all sets were looked at that could have been better.
    pub is_complete: bool,
}

/// Finds the largest set of pairings that are jointly compatible; of several, the one with the least distance.
///
/// `candidates` holds for each sighting its pairings. `cross` is the covariance of the innovations of two pairings of different
/// sightings (first by second), or `None` where the two exclude each other.
#[must_use]
pub fn joint_matches(
    candidates: &[Vec<Pairing>],
    cross: impl Fn(&Pairing, &Pairing) -> Option<Matrix2<f64>>,
    config: &JointConfig,
) -> JointMatches {
    let mut search = Search {
        candidates,
        cross,
        config,
        set: Vec::with_capacity(candidates.len()),
        chosen: vec![None; candidates.len()],
        n_sets: 0,
        best_size: 0,
        best: JointMatches {
            chosen: vec![None; candidates.len()],
            d2: 0.0,
            is_complete: true,
        },
    };
    search.descend(0, 0.0);
    search.best
}

/// The probability that χ² with `2 * pairs` degrees of freedom is greater than `d2`: e^(-x/2) Σ (x/2)^i / i! for i < pairs.
#[must_use]
pub fn chi2_survival(d2: f64, pairs: usize) -> f64 {
    let half = 0.5 * d2;
    let (mut term, mut sum) = (1.0, 0.0);
    for i in 0..pairs {
        sum += term;
        term *= half / (i + 1) as f64;
    }
    sum * libm::exp(-half)
}

/// A pairing of the set with its rows of the Cholesky factor: blocks against the pairings before it, then its own.
struct Member {
    pairing: Pairing,
    blocks: Vec<Matrix2<f64>>,
    own: Matrix2<f64>,
    /// Its part of L⁻¹ v.
    whitened: Vector2<f64>,
}

struct Search<'a, F> {
    candidates: &'a [Vec<Pairing>],
    cross: F,
    config: &'a JointConfig,
    set: Vec<Member>,
    chosen: Vec<Option<usize>>,
    n_sets: usize,
    best_size: usize,
    best: JointMatches,
}

impl<F: Fn(&Pairing, &Pairing) -> Option<Matrix2<f64>>> Search<'_, F> {
    fn descend(&mut self, sighting: usize, d2: f64) {
        self.keep_best(d2);
        let Some(own) = self.candidates.get(sighting) else {
            return;
        };
        for (place, pairing) in own.iter().enumerate() {
            if self.is_hopeless(sighting + 1, self.set.len() + 1, d2) {
                break;
            }
            let Some(member) = self.joined(pairing) else {
                continue;
            };
            let joint = d2 + member.whitened.norm_squared();
            let enough = libm::exp(-0.5 * self.config.gate);
            if chi2_survival(joint, self.set.len() + 1) < enough {
                continue;
            }
            self.set.push(member);
            self.chosen[sighting] = Some(place);
            self.descend(sighting + 1, joint);
            self.chosen[sighting] = None;
            self.set.pop();
        }
        if !self.is_hopeless(sighting + 1, self.set.len(), d2) {
            self.descend(sighting + 1, d2);
        }
    }

    /// Whether no set that begins like this can be better than the best one so far.
    fn is_hopeless(&mut self, next: usize, size: usize, d2: f64) -> bool {
        if self.n_sets >= self.config.most_sets {
            self.best.is_complete = false;
            return true;
        }
        let most = size + self.candidates.len().saturating_sub(next);
        most < self.best_size
            || (most == self.best_size && self.best_size > 0 && d2 >= self.best.d2)
    }

    fn keep_best(&mut self, d2: f64) {
        self.n_sets += 1;
        let size = self.set.len();
        if size > self.best_size || (size == self.best_size && d2 < self.best.d2) {
            self.best_size = size;
            self.best.d2 = d2;
            self.best.chosen.clone_from(&self.chosen);
        }
    }

    /// The pairing as the next member of the set; `None` where it excludes another one or the covariance is not positive definite.
    fn joined(&self, pairing: &Pairing) -> Option<Member> {
        let mut blocks: Vec<Matrix2<f64>> = Vec::with_capacity(self.set.len());
        let (mut rest, mut v) = (pairing.cov, pairing.v);
        for member in &self.set {
            let mut block = (self.cross)(pairing, &member.pairing)?;
            for (mine, theirs) in blocks.iter().zip(&member.blocks) {
                block -= mine * theirs.transpose();
            }
            // Block Lᵀ = what is left, for the lower triangle L of the member.
            let block = member
                .own
                .solve_lower_triangular(&block.transpose())?
                .transpose();
            rest -= block * block.transpose();
            v -= block * member.whitened;
            blocks.push(block);
        }
        let own = rest.cholesky()?.l();
        Some(Member {
            pairing: *pairing,
            blocks,
            own,
            whitened: own.solve_lower_triangular(&v)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    use super::*;
    use crate::geom::{CHI2_2DOF_95, CHI2_2DOF_99};

    const CONFIG: JointConfig = JointConfig {
        gate: CHI2_2DOF_99,
        most_sets: 20_000,
    };

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
            // As in the search, each beginning of a set must pass too.
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

    /// Joint distance by the dense inverse; `None` where two exclude each other.
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

    /// Walls seen from a pose that is uncertain by `sigma` along the normal of all of them.
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
        let cross = |a: &Pairing, b: &Pairing| {
            (a.landmark != b.landmark).then(|| Matrix2::new(0.0, 0.0, 0.0, 0.15 * 0.15))
        };
        let nearest = |own: &Vec<Pairing>| {
            let by_size = |a: &&Pairing, b: &&Pairing| a.v.norm().total_cmp(&b.v.norm());
            own.iter().min_by(by_size).map(|p| p.landmark)
        };
        let by_nearest: Vec<_> = candidates.iter().map(nearest).collect();
        assert_eq!(by_nearest, [Some(0), Some(0), Some(1)]);
        let found = joint_matches(&candidates, cross, &CONFIG);
        let landmarks: Vec<_> = found
            .chosen
            .iter()
            .zip(&candidates)
            .map(|(place, own)| place.map(|p| own[p].landmark))
            .collect();
        assert_eq!(landmarks, [Some(0), Some(1), Some(2)]);
        assert!(found.is_complete);
    }

    #[test]
    fn survival_is_that_of_the_tables() {
        assert!((chi2_survival(CHI2_2DOF_95, 1) - 0.05).abs() < 1e-9);
        assert!((chi2_survival(9.487_729, 2) - 0.05).abs() < 1e-6);
        assert!((chi2_survival(37.566_235, 10) - 0.01).abs() < 1e-6);
    }

    #[test]
    fn search_that_is_cut_short_says_so() {
        let config = JointConfig {
            most_sets: 2,
            ..CONFIG
        };
        let candidates = parallel(0.1, 0.5, 0.05, 6);
        let cross = |a: &Pairing, b: &Pairing| {
            (a.landmark != b.landmark).then(|| Matrix2::new(0.0, 0.0, 0.0, 0.25))
        };
        assert!(!joint_matches(&candidates, cross, &config).is_complete);
        assert!(joint_matches(&[], cross, &config).is_complete);
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
            let cross = |a: &Pairing, b: &Pairing| {
                (a.landmark != b.landmark).then(|| Matrix2::new(0.0, 0.0, 0.0, sigma * sigma))
            };
            let found = joint_matches(&candidates, cross, &CONFIG);
            let size = found.chosen.iter().flatten().count();
            let (best, d2) = brute_force(&candidates, &cross);
            prop_assert!(found.is_complete);
            prop_assert_eq!(size, best);
            prop_assert!(best == 0 || (found.d2 - d2).abs() < 1e-6 * (1.0 + d2), "{} {d2}", found.d2);
        }
    }
}
