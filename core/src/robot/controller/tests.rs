//! The gains compared with the linear model, and the errors for models that cannot be controlled.

use nalgebra::{SMatrix, SVector};

use super::design::with_integrators;
use super::*;
use crate::geom::Length;
use crate::robot::MotorModel;

const PERIOD: f64 = 1e-3;
const COUNT: f64 = std::f64::consts::TAU / 625.0;

fn design(train: &DriveTrain) -> Result<Gains, DesignError> {
    Gains::design(train, PERIOD, COUNT)
}

#[test]
fn closed_loop_and_observers_are_stable_and_faster_than_the_motors() {
    for train in [DriveTrain::rp6(), DriveTrain::pioneer()] {
        let gains = design(&train).unwrap();
        let (a, b) = with_integrators(&train, PERIOD);
        let slowest = |radii: &[f64]| radii.iter().copied().fold(0.0, f64::max);
        let closed: Vec<f64> = (a - b * gains.feedback)
            .complex_eigenvalues()
            .iter()
            .map(|z| z.norm())
            .collect();
        // Every mode decays to 1/e within half a second.
        assert!(slowest(&closed) < libm::exp(-PERIOD / 0.5), "{closed:?}");
        for observer in gains.observers {
            let measured = SMatrix::<f64, 1, 4>::new(1.0, 0.0, 0.0, 0.0);
            let error =
                (SMatrix::<f64, 4, 4>::identity() - observer.gain * measured) * observer.transition;
            let radii: Vec<f64> = error
                .complex_eigenvalues()
                .iter()
                .map(|z| z.norm())
                .collect();
            assert!(slowest(&radii) < libm::exp(-PERIOD / 0.1), "{radii:?}");
        }
    }
}

#[test]
fn cost_of_the_closed_loop_is_the_riccati_solution_and_no_other_gain_is_cheaper() {
    let train = DriveTrain::rp6();
    let (a, b) = with_integrators(&train, PERIOD);
    let q = SMatrix::<f64, 7, 7>::identity();
    let r = SMatrix::<f64, 2, 2>::identity() * 0.1;
    let (x, k) = (
        riccati(&a, &b, &q, &r).unwrap(),
        regulator_gain(&a, &b, &q, &r).unwrap(),
    );
    let start = SVector::<f64, 7>::from([0.1, 1.0, -0.5, -2.0, 0.3, 0.01, -0.02]);
    let cost = |k: &SMatrix<f64, 2, 7>| {
        let (mut state, mut sum) = (start, 0.0);
        for _ in 0..200_000 {
            let u = -k * state;
            sum += (state.transpose() * q * state).x + (u.transpose() * r * u).x;
            state = a * state + b * u;
        }
        sum
    };
    let best = cost(&k);
    assert!(
        (best - (start.transpose() * x * start).x).abs() < 1e-6 * best,
        "{best}"
    );
    for factor in [0.9, 1.1] {
        assert!(cost(&(k * factor)) > best);
    }
}

#[test]
fn five_states_are_two_motors_and_the_difference_of_their_angles() {
    let train = DriveTrain {
        right: MotorModel::rp6().with_stronger_magnet(0.3),
        ..DriveTrain::rp6()
    };
    let (a, b) = train.matrices();
    let (of_left, _, _) = train.left.matrices();
    let (of_right, _, _) = train.right.matrices();
    let x = SVector::<f64, 5>::from([0.3, 2.0, 0.1, -1.0, 0.4]);
    let u = SVector::<f64, 2>::from([5.0, -3.0]);
    let found = a * x + b * u;
    let one = of_left * nalgebra::Vector3::new(0.0, 2.0, 0.1) + train.left.matrices().1 * 5.0;
    let other = of_right * nalgebra::Vector3::new(0.0, -1.0, 0.4) - train.right.matrices().1 * 3.0;
    let expect = SVector::<f64, 5>::from([one[0] - other[0], one[1], one[2], other[1], other[2]]);
    assert!((found - expect).length() < 1e-12);
}

#[test]
fn motors_that_no_voltage_moves_are_named() {
    let mut train = DriveTrain::rp6();
    train.right.torque_constant = 0.0;
    let error = design(&train).unwrap_err();
    assert!(
        matches!(error, DesignError::Uncontrollable { .. }),
        "{error}"
    );
    assert!(
        error.to_string().contains("the speed of the right motor"),
        "{error}"
    );
    train = DriveTrain::rp6();
    train.left.torque_constant = 0.0;
    assert!(
        design(&train)
            .unwrap_err()
            .to_string()
            .contains("the speed of the left motor")
    );
    assert!(design(&DriveTrain::rp6()).is_ok());
}

#[test]
fn bad_figures_are_named() {
    let message = |train: DriveTrain| design(&train).unwrap_err().to_string();
    let mut train = DriveTrain::rp6();
    train.left.inertia = -1.0;
    assert_eq!(
        message(train),
        "left motor: inertia is -1, expected a finite number, greater than 0"
    );
    train = DriveTrain::rp6();
    train.right.friction = f64::NAN;
    assert!(message(train).starts_with("right motor: friction is NaN"));
    train = DriveTrain::rp6();
    train.battery = 0.0;
    assert!(message(train).starts_with("drive train: battery is 0"));
    let error = Gains::design(&DriveTrain::rp6(), 0.0, COUNT).unwrap_err();
    assert!(error.to_string().starts_with("controller: period is 0"));
}

#[test]
fn saturation_gives_way_in_common_first() {
    assert_eq!(within_battery([3.0, -2.0], 7.0), [3.0, -2.0]);
    assert_eq!(within_battery([12.0, 10.0], 7.0), [7.0, 5.0]);
    assert_eq!(within_battery([-12.0, -10.0], 7.0), [-7.0, -5.0]);
    assert_eq!(within_battery([20.0, -20.0], 7.0), [7.0, -7.0]);
}

#[test]
fn a_battery_that_sags_lowers_the_limit_and_none_raises_it() {
    let train = DriveTrain::rp6();
    let mut controller = DriveController::new(&train, PERIOD, COUNT).unwrap();
    let far_too_fast = [Wish {
        speed: 1e3,
        acceleration: 0.0,
    }; 2];
    for (supply, limit) in [
        (5.0, 5.0),
        (20.0, train.battery),
        (6.0, 6.0),
        (f64::NAN, 6.0),
        (-1.0, 0.0),
    ] {
        controller.set_supply(supply);
        let voltages = controller.step([0; 2], far_too_fast);
        let most = voltages.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        assert!((most - limit).abs() < 1e-9, "{supply} V: {voltages:?}");
    }
}
