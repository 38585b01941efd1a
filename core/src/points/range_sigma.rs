//! σ of the range, as a function of the range, from scans taken standing still.
//!
//! In: scans of a robot that did not move. Out: σ(ρ) = a + b ρ or a + b ρ², with the covariance of
//! a and b.
//!
//! 1. Two readings of the same beam in successive scans differ by √2 σ: no mean is needed, and slow
//!    drift cancels (von Neumann 1941, "Distribution of the ratio of the mean square successive
//!    difference to the variance").
//! 2. Differences are gathered in bins of range. Those beyond [`CLIP`] deviations are outliers,
//!    edges and people, and are skipped; this is repeated until none is left.
//! 3. σ of a bin of n differences is known to σ √3 / (2 √n) (same paper, for large n); a and b
//!    follow by weighted least squares.
//!
//! Why differences: the variance about the mean of each beam needs long recordings, and counts a
//! door that was opened as noise.

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use nalgebra::{Matrix2, Vector2};

use crate::robot::Scan;

/// Most rounds of skipping outliers; noise without outliers needs two.
const MOST_ROUNDS: usize = 20;

/// How σ grows with the range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Growth {
    /// a + b ρ: time-of-flight sensors.
    #[default]
    Linear,
    /// a + b ρ²: triangulation sensors.
    Square,
}

/// Width of a bin of range, m; wider bins blur the growth.
const BIN: f64 = 0.5;
/// Differences beyond this many deviations are skipped.
const CLIP: f64 = 4.0;
/// Fewest differences in a bin for the bin to count.
const LEAST_IN_BIN: usize = 50;

/// σ(ρ), with its uncertainty.
#[derive(Clone, Debug, PartialEq)]
pub struct SigmaFit {
    /// How it grows.
    pub growth: Growth,
    /// a in m, b in m/m or m/m².
    pub coefficients: Vector2<f64>,
    /// Covariance of a and b.
    pub cov: Matrix2<f64>,
    /// Squared misfit of the bins over their variance; about the number of bins minus two if the
    /// growth is the right one.
    pub chi_squared: f64,
    /// The bins to which it was fitted.
    pub bins: Vec<SigmaBin>,
}

/// The readings within one interval of range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SigmaBin {
    /// Mean range, m.
    pub range: f64,
    /// Standard deviation of a reading, m.
    pub sigma: f64,
    /// Number of differences that were used.
    pub used: usize,
    /// Number of differences that were skipped.
    pub clipped: usize,
}

/// σ(ρ) to use instead of the values given by a scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeSigma {
    /// How it grows.
    pub growth: Growth,
    /// a, m.
    pub constant: f64,
    /// b, m/m or m/m².
    pub slope: f64,
    /// Least value of σ, m, more than 0: a fit may fall below 0 where nothing was measured.
    pub least: f64,
}

impl RangeSigma {
    /// σ at `range`, m.
    #[must_use]
    pub fn at(&self, range: f64) -> f64 {
        let terms = self.growth.terms(range);
        (self.constant + self.slope * terms[1]).max(self.least)
    }
}

/// Why no σ(ρ) can be estimated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SigmaError {
    /// The scans come from different sensors.
    #[error(
        "scan {scan} has {found} beams and the first has {expected}: they are not of one sensor"
    )]
    Uneven {
        /// Number of the scan, from 0.
        scan: usize,
        /// Its number of beams.
        found: usize,
        /// Number of beams of the first scan.
        expected: usize,
    },
    /// There are too few readings, or all at one range.
    #[error(
        "{bins} bins of range have {LEAST_IN_BIN} differences or more, expected at least 3; record longer, or where ranges vary"
    )]
    TooFew {
        /// Number of bins with enough readings.
        bins: usize,
    },
    /// The readings have no noise at all, as from a perfect simulation, so no bin has a weight.
    #[error("the readings at {range:.2} m do not differ at all: there is no noise to estimate")]
    NoNoise {
        /// Mean range of the bin, m.
        range: f64,
    },
}

impl SigmaFit {
    /// σ at `range`, m.
    #[must_use]
    pub fn at(&self, range: f64) -> f64 {
        self.coefficients.dot(&self.growth.terms(range))
    }

    /// A function for use with other scans of the sensor, not below half of the least value that
    /// was measured.
    #[must_use]
    pub fn to_use(&self) -> RangeSigma {
        let least = self.bins.iter().map(|bin| bin.sigma);
        RangeSigma {
            growth: self.growth,
            constant: self.coefficients[0],
            slope: self.coefficients[1],
            least: 0.5 * least.fold(f64::INFINITY, f64::min),
        }
    }
}

/// Estimates σ(ρ) from stretches of scans. In each stretch a sensor that did not move took one scan
/// after another; between two stretches it may have moved.
///
/// # Errors    [`SigmaError`]: scans of different sensors in one stretch, too few readings.
pub fn estimate_sigma(stretches: &[&[Scan]], growth: Growth) -> Result<SigmaFit, SigmaError> {
    let bins: Vec<SigmaBin> = differences(stretches)?
        .into_values()
        .map(clipped)
        .filter(|bin| bin.used >= LEAST_IN_BIN)
        .collect();
    if bins.len() < 3 {
        return Err(SigmaError::TooFew { bins: bins.len() });
    }
    fit(bins, growth)
}

/// (range, difference) of successive readings, by bin.
type Bins = BTreeMap<u32, Vec<(f64, f64)>>;

/// The differences of the same beam, within each stretch.
fn differences(stretches: &[&[Scan]]) -> Result<Bins, SigmaError> {
    let mut bins = Bins::new();
    for scans in stretches {
        let pairs = scans.iter().zip(scans.iter().skip(1)).enumerate();
        for (index, (before, after)) in pairs {
            if after.len() != before.len() {
                return Err(SigmaError::Uneven {
                    scan: index + 1,
                    found: after.len(),
                    expected: before.len(),
                });
            }
            compare(before, after, &mut bins);
        }
    }
    Ok(bins)
}

fn compare(before: &Scan, after: &Scan, bins: &mut Bins) {
    // Some sensors report the greatest range if nothing came back.
    let is_reading = |r: &f64| r.is_finite() && *r < before.max_range;
    for (&first, &second) in before.ranges.iter().zip(&after.ranges) {
        let (first, second) = (f64::from(first), f64::from(second));
        if is_reading(&first) && is_reading(&second) {
            let range = 0.5 * (first + second);
            let of_bin = bins.entry((range / BIN) as u32).or_default();
            of_bin.push((range, second - first));
        }
    }
}

fn clipped(mut differences: Vec<(f64, f64)>) -> SigmaBin {
    let all = differences.len();
    let mut sigma = 0.0;
    for _ in 0..MOST_ROUNDS {
        let before = differences.len();
        let squares: f64 = differences.iter().map(|d| d.1 * d.1).sum();
        sigma = (0.5 * squares / before.max(1) as f64).sqrt();
        let most = CLIP * sigma * std::f64::consts::SQRT_2;
        differences.retain(|d| d.1.abs() <= most);
        if differences.len() == before {
            break;
        }
    }
    let used = differences.len();
    SigmaBin {
        range: differences.iter().map(|d| d.0).sum::<f64>() / used.max(1) as f64,
        sigma,
        used,
        clipped: all - used,
    }
}

fn fit(bins: Vec<SigmaBin>, growth: Growth) -> Result<SigmaFit, SigmaError> {
    let mut normal = Matrix2::zeros();
    let mut right = Vector2::zeros();
    for bin in &bins {
        if bin.sigma <= 0.0 {
            return Err(SigmaError::NoNoise { range: bin.range });
        }
        let terms = growth.terms(bin.range);
        let weight = 1.0 / bin.variance();
        normal += terms * terms.transpose() * weight;
        right += terms * (weight * bin.sigma);
    }
    let Some(cov) = normal.try_inverse() else {
        return Err(SigmaError::TooFew { bins: 1 });
    };
    let coefficients = cov * right;
    let misfit = |bin: &SigmaBin| {
        let error = bin.sigma - coefficients.dot(&growth.terms(bin.range));
        error * error / bin.variance()
    };
    Ok(SigmaFit {
        growth,
        chi_squared: bins.iter().map(misfit).sum(),
        coefficients,
        cov,
        bins,
    })
}

impl SigmaBin {
    /// Variance of its σ, m².
    fn variance(&self) -> f64 {
        0.75 * self.sigma * self.sigma / self.used as f64
    }
}

impl Growth {
    fn terms(self, range: f64) -> Vector2<f64> {
        match self {
            Self::Linear => Vector2::new(1.0, range),
            Self::Square => Vector2::new(1.0, range * range),
        }
    }
}
