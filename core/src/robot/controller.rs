//! The controller of the two motors: encoder counts and desired speeds in, two voltages out, once
//! per period.
//!
//! In: counts of both encoders, desired speeds and accelerations of both shafts. Out: voltages
//! within the battery's.
//!
//! 1. Two observers follow the counts: angle, speed, current and load of each motor.
//! 2. The desired motion is a state of its own: speeds as commanded, their integrals as angles, and
//!    the currents and voltages that would hold them against the observed loads. The observed state
//!    minus this is the error e; u = u_wished - K e.
//! 3. Both output errors are integrated, so neither a load nor a wrong figure leaves a lasting
//!    error. The integral of the error of Ψ'_L is taken from the angle itself: so rounding errors
//!    of the estimated speed do not accumulate, and the distance is kept too.
//! 4. Saturation: the common part of both voltages gives way to their difference, so a weak battery
//!    makes the robot slow, not crooked. While a part is cut off, its integrator does not run
//!    further in that direction (conditional integration), so nothing has to be unwound afterwards.
//! 5. At rest the voltages are zero (the motors are shorted and brake), and all memory is cleared:
//!    nothing hums or hunts between two counts.
//!
//! Driving straight is two equal speeds, turning on the spot two opposite ones, and any arc lies
//! between: ΔΨ is then a ramp. Source: TDK 2016 §1.1.

mod design;
mod discrete;
pub mod fixed;
mod observer;
mod riccati;
#[cfg(test)]
mod tests;

pub use design::{DesignError, Gains, ObserverGains};
pub use discrete::discretize;
pub use observer::Observer;
pub use riccati::{RiccatiError, filter_gain, regulator_gain, riccati};

use nalgebra::SVector;

use super::DriveTrain;

/// The desired motion of one shaft now.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wish {
    /// Speed, rad/s.
    pub speed: f64,
    /// Acceleration, rad/s².
    pub acceleration: f64,
}

/// Drives two motors.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveController {
    train: DriveTrain,
    gains: Gains,
    /// The limit of each motor's voltage, V.
    supply: f64,
    radians_per_count: f64,
    observers: [Observer; 2],
    /// Desired angles, relative to the observed ones when the motion began: of the left shaft, and
    /// ΔΨ, rad.
    wished: Angles,
    /// Integral of the error of ΔΨ, rad s.
    difference_integral: f64,
    voltages: [f64; 2],
}

/// Two angles that the controller regulates, rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Angles {
    /// Ψ_L.
    pub left: f64,
    /// ΔΨ = Ψ_L - Ψ_R.
    pub difference: f64,
}

impl Angles {
    /// (Ψ_L + Ψ_R) / 2.
    #[must_use]
    pub fn middle(&self) -> f64 {
        self.left - 0.5 * self.difference
    }
}

impl DriveController {
    /// A controller for a robot that stands, with its counts at `counts`; `train` holds the figures
    /// that the controller assumes.
    ///
    /// # Units    `period` s; `radians_per_count` of a shaft.
    /// # Errors    [`DesignError`].
    pub fn new(
        train: &DriveTrain,
        period: f64,
        radians_per_count: f64,
    ) -> Result<Self, DesignError> {
        let gains = Gains::design(train, period, radians_per_count)?;
        Ok(Self {
            train: *train,
            supply: train.battery,
            gains,
            radians_per_count,
            observers: gains.observers.map(Observer::new),
            wished: Angles::default(),
            difference_integral: 0.0,
            voltages: [0.0; 2],
        })
    }

    /// Sets the battery's present voltage, V, which limits the output. It is never taken to be more
    /// than the drive train's own figure; a value that is not a number changes nothing.
    pub fn set_supply(&mut self, volts: f64) {
        if volts.is_finite() {
            self.supply = volts.clamp(0.0, self.train.battery);
        }
    }

    /// The desired angles at present.
    #[must_use]
    pub fn wished(&self) -> Angles {
        self.wished
    }

    /// Voltages of the present period, V: left, right.
    #[must_use]
    pub fn voltages(&self) -> [f64; 2] {
        self.voltages
    }

    /// One period of standing: no voltage, and the desired angles are set to what the counts say.
    pub fn rest(&mut self, counts: [i64; 2]) -> [f64; 2] {
        let angles = self.angles(counts);
        for (observer, angle) in self.observers.iter_mut().zip(angles) {
            observer.settle(angle);
        }
        self.wished = Angles {
            left: angles[0],
            difference: angles[0] - angles[1],
        };
        self.difference_integral = 0.0;
        self.voltages = [0.0; 2];
        self.voltages
    }

    /// One period of driving: takes the counts at its beginning, returns the voltages until its
    /// end.
    pub fn step(&mut self, counts: [i64; 2], wishes: [Wish; 2]) -> [f64; 2] {
        let angles = self.angles(counts);
        let measured = self.voltages.into_iter().zip(angles);
        for (observer, (voltage, angle)) in self.observers.iter_mut().zip(measured) {
            observer.update(voltage, angle);
        }
        let error = self.error(wishes);
        let wanted = self.wanted(&error, wishes);
        self.voltages = within_battery(wanted, self.supply);
        self.integrate(&error, wanted, wishes);
        self.voltages
    }

    fn angles(&self, counts: [i64; 2]) -> [f64; 2] {
        counts.map(|count| count as f64 * self.radians_per_count)
    }

    /// (ΔΨ, Ψ'_L, i_L, Ψ'_R, i_R, z_ΔΨ, z_Ψ'): observed minus desired.
    fn error(&self, wishes: [Wish; 2]) -> SVector<f64, 7> {
        let [left, right] = &self.observers;
        let [current_left, current_right] = self.held(wishes).map(|(current, _)| current);
        SVector::from([
            left.angle() - right.angle() - self.wished.difference,
            left.speed() - wishes[0].speed,
            left.current() - current_left,
            right.speed() - wishes[1].speed,
            right.current() - current_right,
            self.difference_integral,
            left.angle() - self.wished.left,
        ])
    }

    fn wanted(&self, error: &SVector<f64, 7>, wishes: [Wish; 2]) -> [f64; 2] {
        let feedback = self.gains.feedback * error;
        let [left, right] = self.held(wishes).map(|(_, voltage)| voltage);
        [left - feedback[0], right - feedback[1]]
    }

    /// Current and voltage that hold the desired motion against the observed load.
    fn held(&self, wishes: [Wish; 2]) -> [(f64, f64); 2] {
        let motors = [&self.train.left, &self.train.right];
        [0, 1].map(|side: usize| {
            let load = self.observers[side].load();
            motors[side].to_hold(wishes[side].speed, wishes[side].acceleration, load)
        })
    }

    /// Advances the desired angles and the integral of ΔΨ, unless that would ask for more of the
    /// part that is cut off.
    fn integrate(&mut self, error: &SVector<f64, 7>, wanted: [f64; 2], wishes: [Wish; 2]) {
        let h = self.gains.period;
        let cut = [0, 1].map(|side: usize| wanted[side] - self.voltages[side]);
        let (cut_in_common, cut_apart) = (cut[0] + cut[1], cut[0] - cut[1]);
        let [left, right] = wishes.map(|wish| wish.speed);
        self.wished.difference += h * (left - right);
        // More error lowers the voltage: where voltage is cut off, only an error of the same sign
        // may be added.
        if cut_apart * error[0] >= 0.0 {
            self.difference_integral += h * error[0];
        }
        let is_free = cut_in_common * error[1] >= 0.0;
        // A reference that equals the output freezes the integral (anti-windup).
        self.wished.left += h * if is_free {
            left
        } else {
            self.observers[0].speed()
        };
    }
}

/// Limits voltages to ±`battery`: cuts their common part first, then their difference.
fn within_battery([left, right]: [f64; 2], battery: f64) -> [f64; 2] {
    let (common, apart) = (0.5 * (left + right), 0.5 * (left - right));
    let apart = apart.clamp(-battery, battery);
    let room = battery - apart.abs();
    let common = common.clamp(-room, room);
    // Once more, for the last bit of the sums.
    [common + apart, common - apart].map(|voltage| voltage.clamp(-battery, battery))
}
