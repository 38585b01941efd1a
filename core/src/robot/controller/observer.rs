//! Estimates what an encoder does not count from what it does.
//!
//! In: the voltage of the last period, the counted angle. Out: angle, speed, current and load of
//! one motor.
//!
//! 1. Predict by the motor's model. 2. Correct by the stationary Kalman gain times the innovation.

use nalgebra::Vector4;

use super::ObserverGains;

/// Below this a state is insignificant, and on its way to 0 it would only become slow (subnormal).
const NEGLIGIBLE: f64 = 1e-12;

/// The observer of one motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observer {
    gains: ObserverGains,
    /// (Ψ, Ψ', i, load).
    state: Vector4<f64>,
}

impl Observer {
    /// An observer of a motor that stands at angle 0.
    #[must_use]
    pub fn new(gains: ObserverGains) -> Self {
        Self {
            gains,
            state: Vector4::zeros(),
        }
    }

    /// Angle Ψ, rad.
    #[must_use]
    pub fn angle(&self) -> f64 {
        self.state[0]
    }

    /// Speed Ψ', rad/s.
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.state[1]
    }

    /// Current i, A.
    #[must_use]
    pub fn current(&self) -> f64 {
        self.state[2]
    }

    /// Load torque, N m: the braking torque beyond the friction of the model.
    #[must_use]
    pub fn load(&self) -> f64 {
        self.state[3]
    }

    /// Resets it to a motor that stands at this angle.
    pub fn settle(&mut self, angle: f64) {
        self.state = Vector4::new(angle, 0.0, 0.0, 0.0);
    }

    /// Updates with an angle counted a period after the last one, with `voltage` on the motor in
    /// between.
    pub fn update(&mut self, voltage: f64, angle: f64) {
        let ObserverGains {
            transition,
            input,
            gain,
        } = &self.gains;
        let predicted = transition * self.state + input * voltage;
        let innovation = angle - predicted[0];
        self.state = predicted + gain * innovation;
        self.state.apply(|x| {
            if x.abs() < NEGLIGIBLE {
                *x = 0.0;
            }
        });
    }
}
