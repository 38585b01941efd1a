//! Whether a figure grows: a straight line through samples over time.

use serde_json::{Value, json};

/// Growth over the whole time that is ignored, as a fraction of the mean.
const LITTLE: f64 = 0.05;

/// A least-squares line, with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Trend {
    mean: f64,
    /// Growth over the whole time, and its standard deviation: neighbouring samples are correlated,
    /// so the effective number is taken to be a tenth.
    growth: f64,
    sigma: f64,
}

impl Trend {
    /// From samples (time, value) in order of time; at least three.
    pub(crate) fn of(samples: &[(f64, f64)]) -> Option<Self> {
        let (first, last) = (samples.first()?, samples.last()?);
        let n = samples.len() as f64;
        let mean = |f: fn(&(f64, f64)) -> f64| samples.iter().map(f).sum::<f64>() / n;
        let (mean_t, mean_v) = (mean(|s| s.0), mean(|s| s.1));
        let s_tt: f64 = samples.iter().map(|s| (s.0 - mean_t).powi(2)).sum();
        let s_tv: f64 = samples
            .iter()
            .map(|s| (s.0 - mean_t) * (s.1 - mean_v))
            .sum();
        if n < 3.0 || s_tt <= 0.0 {
            return None;
        }
        let slope = s_tv / s_tt;
        let residual = |s: &(f64, f64)| s.1 - mean_v - slope * (s.0 - mean_t);
        let variance = samples.iter().map(|s| residual(s).powi(2)).sum::<f64>() / (n - 2.0);
        let seconds = last.0 - first.0;
        Some(Self {
            mean: mean_v,
            growth: slope * seconds,
            sigma: (10.0 * variance / s_tt).sqrt() * seconds,
        })
    }

    /// Whether it grows: by more than 5 % of the mean and `least`, and by more than chance (3 σ).
    pub(crate) fn grows(&self, least: f64) -> bool {
        self.growth > (LITTLE * self.mean).max(least) && self.growth > 3.0 * self.sigma
    }

    pub(crate) fn figures(&self, least: f64) -> Value {
        let round = |value: f64| (value * 1e3).round() / 1e3;
        json!({
            "mean": round(self.mean), "growth": round(self.growth), "growth_sigma": round(self.sigma),
            "grows": self.grows(least),
        })
    }
}

/// A line through known points, and noise without a trend: checked before each soak, because a test
/// that never fails proves nothing.
pub(crate) fn check() {
    let line: Vec<_> = (0..100)
        .map(|k| (f64::from(k), 100.0 + f64::from(k)))
        .collect();
    let trend = Trend::of(&line).unwrap();
    assert!((trend.growth - 99.0).abs() < 1e-9 && trend.grows(1.0));
    let noise: Vec<_> = slamlab_tests::numbers()
        .take(500)
        .zip(0..)
        .map(|(number, k)| (f64::from(k), 100.0 + 10.0 * number))
        .collect();
    assert!(!Trend::of(&noise).unwrap().grows(1.0));
}
