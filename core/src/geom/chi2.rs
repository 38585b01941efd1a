//! Quantiles of χ², for gates and for confidence bands.

/// The quantile of χ² with `degrees` degrees of freedom with the same cumulative probability as
/// `sigmas` in a standard normal distribution: -1.96 and 1.96 bound the middle 95 %. 0 for no
/// degrees of freedom.
///
/// Source: Wilson & Hilferty (1931), "The distribution of chi-square"; within 2 % above 3 degrees
/// of freedom where `sigmas` is positive.
#[must_use]
pub fn chi2_quantile(degrees: f64, sigmas: f64) -> f64 {
    if degrees <= 0.0 {
        return 0.0;
    }
    let k = 2.0 / (9.0 * degrees);
    let root = (1.0 - k + sigmas * k.sqrt()).max(0.0);
    degrees * (root * root * root)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quantiles_are_those_of_the_tables() {
        // Abramowitz & Stegun (1964), table 26.8: 2.5 % and 97.5 %.
        for (degrees, low, high) in [
            (3.0, 0.216, 9.348),
            (10.0, 3.247, 20.483),
            (30.0, 16.791, 46.979),
            (100.0, 74.222, 129.561),
        ] {
            let band = [-1.959_964, 1.959_964].map(|sigmas| chi2_quantile(degrees, sigmas));
            assert!(
                (band[0] - low).abs() < 0.025 * degrees,
                "{degrees}: {band:?}"
            );
            assert!((band[1] / high - 1.0).abs() < 0.02, "{degrees}: {band:?}");
        }
        // 99.9 %.
        for (degrees, high) in [(4.0, 18.467), (10.0, 29.588), (50.0, 86.661)] {
            let quantile = chi2_quantile(degrees, 3.0902);
            assert!(
                (quantile / high - 1.0).abs() < 0.02,
                "{degrees}: {quantile}"
            );
        }
        assert_eq!(chi2_quantile(0.0, 1.96), 0.0);
    }
}
