//! Fits compared with polynomials known beforehand, with the normal equations, and with published
//! pairs.

use super::*;

/// Sharp GP2Y0A21: ranges in cm and volts, from the specification.
const SHORT: [(f64, f64); 8] = [
    (10.0, 2.28),
    (20.0, 1.30),
    (30.0, 0.90),
    (40.0, 0.75),
    (50.0, 0.60),
    (60.0, 0.50),
    (70.0, 0.45),
    (80.0, 0.40),
];

fn pairs(centimetres: &[(f64, f64)]) -> Vec<CalibrationPair> {
    let pair = |&(range, volts): &(f64, f64)| CalibrationPair {
        range: 0.01 * range,
        volts,
    };
    centimetres.iter().map(pair).collect()
}

#[test]
fn a_polynomial_is_found_again() {
    // Range as an exact quintic of 1/V that rises throughout.
    let truth = |x: f64| 0.05 + 0.3 * x + 0.02 * x * x * x + 0.004 * x * x * x * x * x;
    let pairs: Vec<_> = (1..=12)
        .map(|i| {
            let per_volt = 0.2 * f64::from(i);
            CalibrationPair {
                range: truth(per_volt),
                volts: 1.0 / per_volt,
            }
        })
        .collect();
    let fit = Characteristic::fit(&pairs, Variable::PerVolt).unwrap();
    assert!(fit.sigma < 1e-12, "{}", fit.sigma);
    assert_eq!(fit.reverses_at, None);
    for volts in [0.45, 0.7, 1.3, 4.0] {
        let range = fit.characteristic.range_at(volts);
        assert!((range - truth(1.0 / volts)).abs() < 1e-11, "{volts}");
        let difference = truth(1.0 / (volts + 1e-6)) - truth(1.0 / (volts - 1e-6));
        let slope = fit.characteristic.slope_at(volts);
        assert!((slope - difference / 2e-6).abs() < 1e-6, "{volts}: {slope}");
    }
}

#[test]
fn residuals_are_at_right_angles_to_every_power() {
    // The property that defines a least-squares fit, however it is computed.
    for variable in [Variable::Volts, Variable::PerVolt] {
        let pairs = pairs(&SHORT);
        let fit = Characteristic::fit(&pairs, variable).unwrap();
        for power in (0..=DEGREE).map(|power| power as f64) {
            let x = |p: &CalibrationPair| libm::pow(fit.characteristic.scaled(p.volts), power);
            let product: f64 = pairs
                .iter()
                .zip(&fit.residuals)
                .map(|(p, r)| x(p) * r)
                .sum();
            assert!(
                product.abs() < 1e-12,
                "{variable:?}, power {power}: {product}"
            );
        }
    }
}

#[test]
fn published_pairs_ripple_in_volts_and_not_in_their_inverse() {
    let pairs = pairs(&SHORT);
    let volts = Characteristic::fit(&pairs, Variable::Volts).unwrap();
    let per_volt = Characteristic::fit(&pairs, Variable::PerVolt).unwrap();
    let largest = |fit: &Fit| fit.residuals.iter().fold(0.0, |m: f64, r| m.max(r.abs()));
    // By the SVD of another library (numpy.polyfit over the same scaled variable).
    assert!(
        (largest(&volts) - 0.010_002).abs() < 1e-5,
        "{}",
        largest(&volts)
    );
    assert!(
        (largest(&per_volt) - 0.013_582).abs() < 1e-5,
        "{}",
        largest(&per_volt)
    );
    let turns = volts.reverses_at.expect("it turns round");
    let slope = |v: f64| volts.characteristic.slope_at(v);
    assert!((0.4..2.28).contains(&turns));
    // The oracle: an exhaustive search.
    let everywhere = || (1..1880).map(|i| 0.4 + 0.001 * f64::from(i));
    assert!(everywhere().any(|v| slope(v) > 0.0));
    assert_eq!(per_volt.reverses_at, None);
    assert!(everywhere().all(|v| per_volt.characteristic.slope_at(v) < 0.0));
}

#[test]
fn beyond_the_pairs_it_stays_where_they_end() {
    let fit = Characteristic::fit(&pairs(&SHORT), Variable::PerVolt).unwrap();
    let c = fit.characteristic;
    assert_eq!(c.domain(), [0.40, 2.28]);
    assert_eq!(c.range_at(5.0), c.range_at(2.28));
    assert_eq!(c.range_at(0.0), c.range_at(0.40));
    assert_eq!(c.slope_at(-1.0), c.slope_at(0.40));
}

#[test]
fn bad_pairs_are_named() {
    let fit = |pairs: &[(f64, f64)]| Characteristic::fit(&self::pairs(pairs), Variable::PerVolt);
    let message = |pairs: &[(f64, f64)]| fit(pairs).unwrap_err().to_string();
    assert!(message(&SHORT[..6]).contains("6 pairs, expected at least 7"));
    assert!(message(&[]).contains("0 pairs"));
    let changed = |index: usize, pair: (f64, f64)| {
        let mut all = SHORT;
        all[index] = pair;
        message(&all)
    };
    let order = changed(3, (25.0, 0.75));
    assert!(
        order.starts_with("calibration pair 4: 0.25 m, 0.75 V after 0.3 m, 0.9 V"),
        "{order}"
    );
    assert!(changed(3, (40.0, 0.95)).starts_with("calibration pair 4"));
    assert!(changed(3, (40.0, 0.90)).starts_with("calibration pair 4"));
    assert!(changed(2, (30.0, f64::NAN)).contains("pair 3: volts is NaN"));
    assert!(changed(2, (f64::INFINITY, 0.9)).contains("pair 3: range is inf"));
    assert!(changed(7, (80.0, -0.4)).contains("pair 8: volts is -0.4"));
    // All but one have the same volts, up to rounding.
    let mut close: Vec<_> = (0..8)
        .map(|i| (10.0 + f64::from(i), 1.0 - 1e-15 * f64::from(i)))
        .collect();
    close[0].1 = 2.0;
    assert!(message(&close).contains("too close together"));
}
