//! The inverse compared with the forward model, σ with a Monte Carlo run, and when readings were
//! measured.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::robot::Adc;

/// The reading that results from these volts after conversion.
fn read(model: &RangerModel, inverse: &RangerInverse, volts: f64) -> (f32, f32) {
    inverse.read(model.adc.volts(model.adc.counts(volts)))
}

#[test]
fn inverse_gives_the_range_back_within_what_the_fit_says() {
    for model in [RangerModel::long(), RangerModel::short()] {
        let inverse = model.inverse().unwrap();
        let fit = model.fit().unwrap();
        assert_eq!(fit.reverses_at, None);
        for millimetres in 210..760 {
            let truth = 1e-3 * f64::from(millimetres);
            let volts = model.sharp.volts_at(truth);
            let (range, sigma) = read(&model, &inverse, volts);
            let error = f64::from(range) - truth;
            // Without noise, only the fit and the quantisation err.
            assert!(
                error.abs() < 3.0 * f64::from(sigma),
                "{truth}: {range} ± {sigma}"
            );
            assert!(f64::from(sigma) >= fit.sigma as f32 as f64);
        }
    }
}

#[test]
fn sigma_of_the_noise_is_that_of_many_readings() {
    let model = RangerModel::long();
    let inverse = model.inverse().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for truth in [0.3, 0.6, 1.0, 1.2] {
        let volts = model.sharp.volts_at(truth);
        let n = 20_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..n {
            let (noise, _) = gaussian_pair(&mut rng);
            let (range, _) = read(&model, &inverse, volts + model.volts_sigma * noise);
            let range = f64::from(range).min(model.max_range);
            sum += range;
            squares += range * range;
        }
        let mean = sum / f64::from(n);
        let spread = (squares / f64::from(n) - mean * mean).sqrt();
        // The slope changes over the range of the noise, so the two agree only to first order.
        let slope = model.fit().unwrap().characteristic.slope_at(volts).abs();
        let expect = slope * libm::hypot(model.volts_sigma, model.adc.sigma());
        assert!(
            (spread / expect - 1.0).abs() < 0.15,
            "{truth} m: {spread} against {expect}"
        );
    }
}

#[test]
fn far_away_a_step_of_the_converter_is_a_centimetre_and_the_noise_three() {
    // The specification, for the short type at 80 cm.
    let fit = RangerModel::short().fit().unwrap();
    let slope = fit.characteristic.slope_at(0.41).abs();
    let step = slope * Adc::rp6().step();
    let noise = slope * 0.015;
    assert!((0.005..0.02).contains(&step), "{step}");
    assert!((0.015..0.06).contains(&noise), "{noise}");
}

#[test]
fn what_is_read_was_measured_before_and_with_a_slow_servo_in_place() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let late = |period: f64, rng: &mut ChaCha8Rng| {
        let model = RangerModel {
            period,
            ..RangerModel::long()
        };
        let mut rangers = Rangers::new(&model).unwrap();
        let (mut late, mut all) = (0, 0);
        for _ in 0..100 {
            rangers.draw_cycles(rng);
            for ranger in 0..RANGERS {
                for position in 0..45_usize {
                    let read = (position + 1) as f64 * period;
                    let measured = rangers.held_position(ranger, read - 1e-9);
                    assert!(measured <= position);
                    late += i32::from(measured < position);
                    all += 1;
                }
            }
        }
        f64::from(late) / f64::from(all)
    };
    assert_eq!(late(RangerModel::long().period, &mut rng), 0.0);
    // A cycle of mean length c ends within the time p that a shorter period leaves after settling,
    // with probability p/c.
    let part = late(RangerModel::long().settle + 0.02, &mut rng);
    assert!((part - (1.0 - 0.02 / 0.0383)).abs() < 0.06, "{part}");
}

#[test]
fn a_reading_below_the_least_range_is_invalid() {
    let model = RangerModel::long();
    let inverse = model.inverse().unwrap();
    let at = |range| read(&model, &inverse, model.sharp.volts_at(range)).0;
    assert!(at(0.16).is_nan());
    assert!((at(0.23) - 0.23).abs() < 0.03);
}

#[test]
fn bad_calibrations_are_named() {
    let mut model = RangerModel::long();
    model.calibration.swap(3, 4);
    let message = model.validate().unwrap_err().to_string();
    assert!(
        message.starts_with("rangers: calibration pair 5:"),
        "{message}"
    );
    model.calibration.truncate(3);
    let message = model.validate().unwrap_err().to_string();
    assert!(
        message.contains("3 pairs, expected at least 7"),
        "{message}"
    );
}
