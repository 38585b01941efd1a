//! Which particles survive: systematic resampling, and when it is worth the loss of maps.

/// Weights from their logarithms, normalised to sum to 1.
pub(super) fn normalised(logs: &[f64]) -> Vec<f64> {
    // Scale the largest to 1: numbers like e^-1000 would vanish.
    let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = logs.iter().map(|log| libm::exp(log - most)).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|weight| weight / sum).collect()
}

/// The effective number of particles: the number of equally weighted ones that would estimate as
/// well.
///
/// Source: Liu (1996), "Metropolized independent sampling with comparisons to rejection sampling
/// and importance sampling"; Grisetti et al. (2007), eq. (20).
pub(super) fn effective_number(weights: &[f64]) -> f64 {
    1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>()
}

/// Draws as many particles as there are weights, each n w times, rounded up or down, in the order
/// of the weights. `at` is the only random number, in [0, 1).
///
/// Source: Thrun, Burgard & Fox (2005), "Probabilistic Robotics", table 4.4 (low variance sampler).
pub(super) fn systematic(weights: &[f64], at: f64) -> Vec<usize> {
    let count = weights.len();
    let mut drawn = Vec::with_capacity(count);
    let (mut index, mut sum) = (0, weights.first().copied().unwrap_or(0.0));
    for step in 0..count {
        let pointer = (step as f64 + at) / count as f64;
        // Rounding may leave the sum of the weights slightly below 1.
        while sum <= pointer && index + 1 < count {
            index += 1;
            sum += weights[index];
        }
        drawn.push(index);
    }
    drawn
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn each_is_drawn_as_often_as_its_weight_says() {
        let weights = [0.07, 0.0, 0.33, 0.25, 0.35];
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (runs, mut counts) = (20_000, [0.0; 5]);
        for _ in 0..runs {
            let drawn = systematic(&weights, rng.random::<f64>());
            assert_eq!(drawn.len(), 5);
            for (index, weight) in weights.iter().enumerate() {
                let times = drawn.iter().filter(|&&i| i == index).count() as f64;
                // Never off by one or more: this is the advantage over drawing one by one.
                assert!((times - 5.0 * weight).abs() < 1.0);
                counts[index] += times;
            }
        }
        for (count, weight) in counts.iter().zip(weights) {
            let mean = count / f64::from(runs);
            // The fractional part is a Bernoulli variable: σ at most 1/2.
            assert!((mean - 5.0 * weight).abs() < 5.0 * 0.5 / f64::from(runs).sqrt());
        }
    }

    #[test]
    fn equal_weights_leave_all_as_they_are() {
        let weights = [0.125; 8];
        assert_eq!(systematic(&weights, 0.5), [0, 1, 2, 3, 4, 5, 6, 7]);
        assert!((effective_number(&weights) - 8.0).abs() < 1e-12);
        assert_eq!(systematic(&[], 0.3), [0_usize; 0]);
    }

    #[test]
    fn weights_come_of_logarithms_that_have_no_exponential() {
        let weights = normalised(&[-2000.0, -2000.0 + libm::log(3.0), -9000.0]);
        assert!((weights[0] - 0.25).abs() < 1e-12 && (weights[1] - 0.75).abs() < 1e-12);
        assert_eq!(weights[2], 0.0);
        assert!((effective_number(&weights) - 1.6).abs() < 1e-12);
    }
}
