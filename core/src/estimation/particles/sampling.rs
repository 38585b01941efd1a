//! Drawing particles: how many, which, and where a motion takes them.
//!
//! 1. **How many** (Fox 2003, "Adapting the sample size in particle filters through KLD-sampling",
//!    eq. (7)): enough that the Kullback-Leibler distance between the sampled and the true
//!    distribution is below ε with probability 1 - δ, where k is the number of bins that the
//!    particles fall into.
//! 2. **Which**: each with a probability equal to its weight.
//! 3. **Where to**: the odometry's motion, drawn from its covariance.

use std::collections::BTreeSet;

use nalgebra::{Matrix3, Vector3};
use rand::{Rng, RngExt};

use super::Particle;
use crate::bounds::config;
use crate::geom::{Pose2, gaussian_pair};

config! {
    /// How many particles are drawn.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct KldConfig {
        /// Side of a bin, m. Default 0.25; smaller: more particles.
        pub bin: f64 = 0.25,
        /// Angle of a bin, rad. Default 0.175 (10°); smaller: more particles.
        pub bin_turn: f64 = 0.175,
        /// ε: the distance of distributions that is allowed. Default 0.05; larger: fewer particles.
        pub epsilon: f64 = 0.05,
        /// z: the upper 1 - δ quantile of the standard normal distribution. Default 2.33, 99 %.
        pub quantile: f64 = 2.33,
        /// Fewest particles. Default 250.
        pub least: usize = 250,
        /// Most particles. Default 5000; larger: slower where nothing is known.
        pub most: usize = 5000,
    }
}

impl KldConfig {
    /// n if `bins` bins contain a particle, by the Wilson-Hilferty transformation of the χ²
    /// quantile; 1 for one bin, where there is nothing to approximate.
    #[must_use]
    pub fn count(&self, bins: usize) -> usize {
        if bins < 2 {
            return 1;
        }
        let degrees = bins as f64 - 1.0;
        let a = 2.0 / (9.0 * degrees);
        let root = 1.0 - a + a.sqrt() * self.quantile;
        (degrees / (2.0 * self.epsilon) * root * root * root).ceil() as usize
    }

    /// The bin of a pose.
    #[must_use]
    pub fn bin_of(&self, pose: &Pose2) -> Bin {
        let at = |value: f64, side: f64| (value / side).floor() as i32;
        Bin {
            col: at(pose.x(), self.bin),
            row: at(pose.y(), self.bin),
            turn: at(pose.heading(), self.bin_turn),
        }
    }
}

/// A cell of pose space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Bin {
    /// Along x.
    pub col: i32,
    /// Along y.
    pub row: i32,
    /// Of the heading; those at -π and at π are neighbours.
    pub turn: i32,
}

/// Draws particles of equal weight: with probability `fresh_part` by `fresh`, else one of
/// `particles` by its weight; as many as required for the bins that they fall into.
///
/// Source: Fox (2003), table 2 without its prediction; Thrun, Burgard & Fox (2005), "Probabilistic
/// Robotics", table 8.3, line 14, for the fresh ones.
pub(super) fn draw<R: Rng>(
    particles: &[Particle],
    fresh_part: f64,
    mut fresh: impl FnMut(&mut R) -> Pose2,
    config: &KldConfig,
    rng: &mut R,
) -> Vec<Particle> {
    let mut sums: Vec<f64> = Vec::with_capacity(particles.len());
    let mut sum = 0.0;
    for particle in particles {
        sum += particle.weight;
        sums.push(sum);
    }
    let (mut drawn, mut bins) = (vec![], BTreeSet::new());
    let mut enough = config.least;
    while drawn.len() < enough.min(config.most) {
        let is_fresh = rng.random::<f64>() < fresh_part;
        let at = rng.random::<f64>() * sum;
        let pose = match particles.get(sums.partition_point(|&sum| sum <= at)) {
            Some(particle) if !is_fresh => particle.pose,
            _ => fresh(rng),
        };
        if bins.insert(config.bin_of(&pose)) {
            enough = config.count(bins.len()).max(config.least);
        }
        drawn.push(pose);
    }
    let weight = 1.0 / drawn.len() as f64;
    let particles = drawn.into_iter().map(|pose| Particle { pose, weight });
    particles.collect()
}

/// A Gaussian distribution of poses.
#[derive(Clone, Debug)]
pub(in crate::estimation) struct Gaussian {
    mean: Pose2,
    /// L of its covariance L Lᵀ.
    spread: Matrix3<f64>,
}

impl Gaussian {
    /// `cov` of (x, y, θ), in the frame of the pose's coordinates; negative eigenvalues count as
    /// zero.
    pub(in crate::estimation) fn new(mean: Pose2, cov: &Matrix3<f64>) -> Self {
        // A covariance with an exactly known direction has no Cholesky factor.
        let eigen = cov.symmetric_eigen();
        let sigmas = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
        Self {
            mean,
            spread: eigen.eigenvectors * Matrix3::from_diagonal(&sigmas),
        }
    }

    pub(in crate::estimation) fn draw(&self, rng: &mut impl Rng) -> Pose2 {
        let (a, b) = gaussian_pair(rng);
        let (c, _) = gaussian_pair(rng);
        self.mean.plus(&(self.spread * Vector3::new(a, b, c)))
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn the_count_is_half_the_quantile_of_chi_squared_over_epsilon() {
        // Abramowitz & Stegun (1964), table 26.8: 99 % of χ² with 1, 10, 30, 100 degrees.
        let config = KldConfig::default();
        for (degrees, quantile, within) in [
            (1.0, 6.635, 0.03),
            (10.0, 23.209, 0.005),
            (30.0, 50.892, 0.003),
            (100.0, 135.807, 0.002),
        ] {
            let exact = quantile / (2.0 * config.epsilon);
            let found = config.count(degrees as usize + 1) as f64;
            assert!(
                (found / exact - 1.0).abs() < within + 1.0 / exact,
                "{degrees}: {found} {exact}"
            );
        }
        assert_eq!((config.count(0), config.count(1)), (1, 1));
    }

    #[test]
    fn each_is_drawn_as_often_as_its_weight_says() {
        let particles: Vec<Particle> = [0.1, 0.0, 0.4, 0.5]
            .iter()
            .enumerate()
            .map(|(i, &weight)| Particle {
                pose: Pose2::new(i as f64, 0.0, 0.0),
                weight,
            })
            .collect();
        let config = KldConfig {
            least: 500,
            ..KldConfig::default()
        };
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let fresh = |_: &mut ChaCha8Rng| Pose2::new(9.0, 0.0, 0.0);
        let (mut counts, mut all) = ([0.0; 10], 0.0);
        for _ in 0..200 {
            for particle in draw(&particles, 0.2, fresh, &config, &mut rng) {
                counts[particle.pose.x().round() as usize] += 1.0;
                all += 1.0;
            }
        }
        let probabilities = [(0, 0.08), (1, 0.0), (2, 0.32), (3, 0.4), (9, 0.2)];
        for (i, p) in probabilities {
            // Five standard errors of a binomial.
            let sigma = f64::sqrt(p * (1.0 - p) / all);
            let part: f64 = counts[i] / all;
            assert!((part - p).abs() <= 5.0 * sigma, "{i}: {part} {p}");
        }
    }

    #[test]
    fn particles_are_as_many_as_their_bins_ask_for() {
        let config = KldConfig::default();
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let spread = |sigma: f64, rng: &mut ChaCha8Rng| {
            let gaussian = Gaussian::new(
                Pose2::identity(),
                &Matrix3::from_diagonal_element(sigma * sigma),
            );
            draw(
                &[],
                1.0,
                |rng: &mut ChaCha8Rng| gaussian.draw(rng),
                &config,
                rng,
            )
        };
        let (few, many) = (spread(0.02, &mut rng), spread(1.0, &mut rng));
        for drawn in [&few, &many] {
            let bins: BTreeSet<Bin> = drawn.iter().map(|p| config.bin_of(&p.pose)).collect();
            let asked = config.count(bins.len()).clamp(config.least, config.most);
            assert_eq!(drawn.len(), asked);
            let sum: f64 = drawn.iter().map(|p| p.weight).sum();
            assert!((sum - 1.0).abs() < 1e-9);
        }
        assert!(many.len() > 4 * few.len());
    }

    #[test]
    fn a_gaussian_has_its_mean_and_covariance() {
        let cov = Matrix3::new(0.04, 0.01, 0.0, 0.01, 0.01, 0.002, 0.0, 0.002, 0.0025);
        let gaussian = Gaussian::new(Pose2::new(1.0, -2.0, 3.1), &cov);
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let (count, mut sum, mut squares) = (40_000, Vector3::zeros(), Matrix3::zeros());
        for _ in 0..count {
            let off = gaussian.draw(&mut rng).minus(&gaussian.mean);
            sum += off;
            squares += off * off.transpose();
        }
        let count = f64::from(count);
        assert!((sum / count).amax() < 5.0 * 0.2 / count.sqrt());
        // The relative standard error of a variance is √(2/n).
        assert!((squares / count - cov).amax() < 5.0 * 0.04 * (2.0 / count).sqrt());
        // Known exactly: no noise, and no failure.
        let exact = Gaussian::new(Pose2::identity(), &Matrix3::zeros());
        assert_eq!(exact.draw(&mut rng), Pose2::identity());
    }
}
