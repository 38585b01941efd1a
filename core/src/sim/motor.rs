//! A running motor: the plant whose true figures the controller does not know.
//!
//! In: voltage, load and brake of one period. Out: angle, speed and current at its end.
//!
//! 1. The linear motor is stepped exactly, with voltage and torque held during the period.
//! 2. Dry friction brakes while the shaft turns, stops it where its direction would change, and
//!    holds it until the current pulls harder. The current of a held shaft follows from R and L
//!    alone.

use nalgebra::{Matrix3, Vector3};

use crate::robot::MotorModel;
use crate::robot::controller::discretize;

/// A current below this is set to zero, A: a number that decays for ever becomes slow to compute
/// with.
const NO_CURRENT: f64 = 1e-9;

/// One motor with gear and track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    model: MotorModel,
    transition: Matrix3<f64>,
    of_voltage: Vector3<f64>,
    of_load: Vector3<f64>,
    /// Factor by which a current decays in a period with the shaft held.
    held_decay: f64,
    /// (Ψ, Ψ', i).
    state: Vector3<f64>,
}

impl Motor {
    /// A standing motor, to be stepped by `period` seconds.
    #[must_use]
    pub fn new(model: &MotorModel, period: f64) -> Self {
        let (a, voltage, load) = model.matrices();
        let (transition, s) = discretize(&a, period);
        Self {
            model: *model,
            transition,
            of_voltage: s * voltage,
            of_load: s * load,
            held_decay: libm::exp(-model.resistance / model.inductance * period),
            state: Vector3::zeros(),
        }
    }

    /// Angle of the shaft, rad.
    #[must_use]
    pub fn angle(&self) -> f64 {
        self.state[0]
    }

    /// Speed of the shaft, rad/s.
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.state[1]
    }

    /// Current, A.
    #[must_use]
    pub fn current(&self) -> f64 {
        self.state[2]
    }

    /// Whether it stands without current, so that nothing changes without voltage.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.speed() == 0.0 && self.current() == 0.0
    }

    /// One period with `voltage` on the motor, `load` (N m, against positive rotation) on its
    /// shaft, and `brake` (N m, against any rotation) in addition to its own dry friction.
    pub fn step(&mut self, voltage: f64, load: f64, brake: f64) {
        let speed = self.speed();
        let pull = self.model.torque_constant * self.current() - load;
        let dry = self.model.dry_friction + brake;
        let grips = dry > 0.0;
        if grips && speed == 0.0 && pull.abs() <= dry {
            self.hold(voltage);
            return;
        }
        let direction = if speed == 0.0 { pull } else { speed };
        let torque = load + dry.copysign(direction);
        let mut next =
            self.transition * self.state + self.of_voltage * voltage + self.of_load * torque;
        if grips && next[1] * direction < 0.0 {
            next[1] = 0.0;
        }
        self.state = next;
    }

    fn hold(&mut self, voltage: f64) {
        let settled = voltage / self.model.resistance;
        let current = settled + (self.current() - settled) * self.held_decay;
        self.state[2] = if current.abs() < NO_CURRENT {
            0.0
        } else {
            current
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn smooth(model: MotorModel) -> MotorModel {
        MotorModel {
            dry_friction: 0.0,
            ..model
        }
    }

    #[test]
    fn settles_at_the_closed_form_of_the_steady_state() {
        let model = smooth(MotorModel::rp6());
        for (voltage, load) in [(7.2, 0.0), (-3.0, 0.02), (5.0, 0.1), (0.0, -0.05)] {
            let mut motor = Motor::new(&model, 1e-3);
            for _ in 0..5_000 {
                motor.step(voltage, load, 0.0);
            }
            // u = R i + c1 ω, c2 i = f ω + load.
            let speed = (voltage - model.resistance * load / model.torque_constant)
                / (model.speed_constant
                    + model.resistance * model.friction / model.torque_constant);
            assert!(
                (motor.speed() - speed).abs() < 1e-9,
                "{} {speed}",
                motor.speed()
            );
            let current = (model.friction * speed + load) / model.torque_constant;
            assert!((motor.current() - current).abs() < 1e-9);
        }
    }

    #[test]
    fn turns_as_fine_euler_steps_of_the_equations_do() {
        let model = smooth(MotorModel::rp6());
        let mut motor = Motor::new(&model, 1e-3);
        let (mut angle, mut speed, mut current) = (0.0, 0.0, 0.0);
        let dt = 1e-7;
        for period in 0..200 {
            let (voltage, load) = if period < 100 {
                (6.0, 0.0)
            } else {
                (-2.0, 0.05)
            };
            motor.step(voltage, load, 0.0);
            for _ in 0..10_000 {
                let torque = model.torque_constant * current - model.friction * speed - load;
                let over = voltage - model.resistance * current - model.speed_constant * speed;
                angle += speed * dt;
                speed += torque / model.inertia * dt;
                current += over / model.inductance * dt;
            }
        }
        assert!(
            (motor.angle() - angle).abs() < 1e-5 && (motor.speed() - speed).abs() < 1e-3,
            "{angle} {speed} {motor:?}"
        );
        assert!((motor.current() - current).abs() < 1e-4);
    }

    #[test]
    fn dry_friction_holds_until_the_current_pulls_harder_and_brings_to_a_full_stop() {
        let model = MotorModel::rp6();
        let breakaway = model.resistance * model.dry_friction / model.torque_constant;
        for sign in [1.0, -1.0] {
            let mut motor = Motor::new(&model, 1e-3);
            for _ in 0..1_000 {
                motor.step(sign * 0.99 * breakaway, 0.0, 0.0);
            }
            assert_eq!((motor.angle(), motor.speed()), (0.0, 0.0));
            for _ in 0..1_000 {
                motor.step(sign * 2.0 * breakaway, 0.0, 0.0);
            }
            assert!(motor.speed() * sign > 0.0);
            for _ in 0..2_000 {
                motor.step(0.0, 0.0, 0.0);
            }
            assert_eq!((motor.speed(), motor.current()), (0.0, 0.0));
        }
    }

    #[test]
    fn top_speed_leaves_the_controller_something_to_control_with() {
        let train = crate::robot::DriveTrain::rp6();
        let mut motor = Motor::new(&train.left, 1e-3);
        for _ in 0..5_000 {
            motor.step(train.battery, 0.0, 0.0);
        }
        let top = motor.speed() * train.metres_per_radian;
        assert!((0.33..0.45).contains(&top), "{top} m/s at full voltage");
    }
}
