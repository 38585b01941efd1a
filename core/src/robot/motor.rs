//! DC motors, and the two motors of a robot as one linear system.
//!
//! In: a motor's figures. Out: the matrices of x' = A x + B u.
//!
//! 1. One motor with its track: x = (Ψ, Ψ', i), the angle and speed of the shaft that drives the
//!    track and the current: Θ Ψ'' = c2 i - f Ψ' - load, L i' = u - R i - c1 Ψ'.
//! 2. The robot: x = (ΔΨ, Ψ'_L, i_L, Ψ'_R, i_R) with ΔΨ = Ψ_L - Ψ_R, two voltages in; outputs ΔΨ
//!    and Ψ'_L.
//!
//! All figures are those at the track's shaft, behind the gear: with a gear 1:n the constants c1
//! and c2 are n times the motor's and its inertia n² times. Each track carries half of the robot's
//! mass.
//!
//! Source: TDK 2016 §1.1.

use nalgebra::{Matrix3, SMatrix, Vector3};

use crate::bounds::{Bounds, NOT_NEGATIVE, OutOfBounds, POSITIVE, check};

/// Figures of one motor with gear and track, at the track's shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorModel {
    /// Viscous friction f, N m s.
    pub friction: f64,
    /// Moment of inertia Θ: rotor, gear, and the mass that this track moves, kg m².
    pub inertia: f64,
    /// Speed constant c1: voltage that turning induces, V s.
    pub speed_constant: f64,
    /// Torque constant c2: torque per current, N m/A. Below c1 because of losses in the gear.
    pub torque_constant: f64,
    /// Resistance R, Ω.
    pub resistance: f64,
    /// Inductance L, H.
    pub inductance: f64,
    /// Dry friction of gear and track, N m: it has to be overcome before anything turns. It is not
    /// in the linear model; the controller treats it as a load, and in the simulation it stops the
    /// shaft.
    pub dry_friction: f64,
}

/// Both motors of a robot, and what they drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveTrain {
    /// Left motor.
    pub left: MotorModel,
    /// Right motor.
    pub right: MotorModel,
    /// Voltage of the battery, V: no motor gets more.
    pub battery: f64,
    /// Distance of a track for each radian of its shaft, m.
    pub metres_per_radian: f64,
    /// The largest force of one track before it slips on the ground, N: half of weight times
    /// friction.
    pub grip: f64,
    /// How far the motors of a single robot are from these figures, as a part of their constants.
    /// The simulation draws each motor's own from its seed; the controller does not know them.
    pub spread: f64,
}

/// Why figures of motors are impossible.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{motor}: {figure}")]
pub struct MotorError {
    /// Which motor, or `drive train`.
    pub motor: &'static str,
    /// The figure at fault.
    pub figure: OutOfBounds,
}

/// How far the motors of a robot may be from their model.
const SPREAD: Bounds = [0.0, 0.49];

impl MotorModel {
    /// A motor of the RP6 with its gear and track.
    ///
    /// There is no published data sheet of this motor. Known: 7.2 V, gear 1:72, two motors that
    /// move about 1 kg at 0.30 m/s at most with reserve. Assumed, from motors of this size (280
    /// class): 4.5 Ω, 2 mH, 5.4 mV s at the rotor, rotor 5 g cm², a gear that loses a quarter, and
    /// friction that leaves about 0.37 m/s at full voltage.
    #[must_use]
    pub fn rp6() -> Self {
        let gear = 72.0;
        let (rotor, mass, radius) = (5e-7, 1.0, 0.023_87);
        let speed_constant = gear * 5.4e-3;
        Self {
            friction: 1.5e-3,
            inertia: rotor * gear * gear + 0.5 * mass * radius * radius,
            speed_constant,
            torque_constant: 0.75 * speed_constant,
            resistance: 4.5,
            inductance: 2e-3,
            dry_friction: 0.02,
        }
    }

    /// A motor of the Pioneer 2, similar to Pittman's GM9236 (12 V, 0.71 Ω, 0.66 mH, 0.023 V s,
    /// rotor 71 g cm²), with gear 1:19.7, wheels of 0.165 m, and 9 kg to move. Gear losses and
    /// friction are assumed.
    #[must_use]
    pub fn pioneer() -> Self {
        let gear = 19.7;
        let (rotor, mass, radius) = (7.1e-6, 9.0, 0.082_5);
        let speed_constant = gear * 0.023;
        Self {
            friction: 8e-3,
            inertia: rotor * gear * gear + 0.5 * mass * radius * radius,
            speed_constant,
            torque_constant: 0.75 * speed_constant,
            resistance: 0.71,
            inductance: 0.66e-3,
            dry_friction: 0.1,
        }
    }

    /// The same motor with both constants larger by a part (both come from the same magnet).
    #[must_use]
    pub fn with_stronger_magnet(self, part: f64) -> Self {
        Self {
            speed_constant: self.speed_constant * (1.0 + part),
            torque_constant: self.torque_constant * (1.0 + part),
            ..self
        }
    }

    /// A of x = (Ψ, Ψ', i), with the columns of the voltage and of a load torque.
    #[must_use]
    pub fn matrices(&self) -> (Matrix3<f64>, Vector3<f64>, Vector3<f64>) {
        let (inertia, inductance) = (self.inertia, self.inductance);
        #[rustfmt::skip]
        let a = Matrix3::new(
            0.0, 1.0, 0.0,
            0.0, -self.friction / inertia, self.torque_constant / inertia,
            0.0, -self.speed_constant / inductance, -self.resistance / inductance,
        );
        (
            a,
            Vector3::new(0.0, 0.0, 1.0 / inductance),
            Vector3::new(0.0, -1.0 / inertia, 0.0),
        )
    }

    /// Current, A, and voltage, V, that hold a speed (rad/s) and an acceleration (rad/s²) against a
    /// load (N m). The change of the current itself is neglected: it lasts only L/R.
    #[must_use]
    pub fn to_hold(&self, speed: f64, acceleration: f64, load: f64) -> (f64, f64) {
        let torque = self.inertia * acceleration + self.friction * speed + load;
        let current = torque / self.torque_constant;
        let voltage = self.resistance * current + self.speed_constant * speed;
        (current, voltage)
    }

    fn check(&self, motor: &'static str) -> Result<(), MotorError> {
        check(&[
            ("inertia", self.inertia, POSITIVE),
            ("resistance", self.resistance, POSITIVE),
            ("inductance", self.inductance, POSITIVE),
            ("friction", self.friction, NOT_NEGATIVE),
            ("speed_constant", self.speed_constant, NOT_NEGATIVE),
            ("torque_constant", self.torque_constant, NOT_NEGATIVE),
            ("dry_friction", self.dry_friction, NOT_NEGATIVE),
        ])
        .map_err(|figure| MotorError { motor, figure })
    }
}

impl DriveTrain {
    /// The RP6: 6 NiMH cells, 625 counts of 0.24 mm per turn of the shaft (a radian is 23.9 mm), 1
    /// kg on rubber.
    #[must_use]
    pub fn rp6() -> Self {
        Self {
            left: MotorModel::rp6(),
            right: MotorModel::rp6(),
            battery: 7.2,
            metres_per_radian: 625.0 * 0.000_24 / std::f64::consts::TAU,
            grip: 3.0,
            spread: 0.1,
        }
    }

    /// The Pioneer 2-DX.
    #[must_use]
    pub fn pioneer() -> Self {
        Self {
            left: MotorModel::pioneer(),
            right: MotorModel::pioneer(),
            battery: 12.0,
            metres_per_radian: 0.082_5,
            grip: 25.0,
            spread: 0.05,
        }
    }

    /// A and B of x = (ΔΨ, Ψ'_L, i_L, Ψ'_R, i_R), u = (u_L, u_R).
    ///
    /// Source: TDK 2016 §1.1, as printed.
    #[must_use]
    pub fn matrices(&self) -> (SMatrix<f64, 5, 5>, SMatrix<f64, 5, 2>) {
        let mut a = SMatrix::<f64, 5, 5>::zeros();
        let mut b = SMatrix::<f64, 5, 2>::zeros();
        a[(0, 1)] = 1.0;
        a[(0, 3)] = -1.0;
        for (side, motor) in [&self.left, &self.right].into_iter().enumerate() {
            let (of_motor, voltage, _) = motor.matrices();
            let at = 1 + 2 * side;
            a.fixed_view_mut::<2, 2>(at, at)
                .copy_from(&of_motor.fixed_view::<2, 2>(1, 1));
            b[(at + 1, side)] = voltage.z;
        }
        (a, b)
    }

    /// Checks that every figure is possible.
    ///
    /// # Errors    [`MotorError`] naming the motor, the field and its value.
    pub fn validate(&self) -> Result<(), MotorError> {
        self.left.check("left motor")?;
        self.right.check("right motor")?;
        let motor = "drive train";
        check(&[
            ("battery", self.battery, POSITIVE),
            ("metres_per_radian", self.metres_per_radian, POSITIVE),
            ("grip", self.grip, POSITIVE),
            ("spread", self.spread, SPREAD),
        ])
        .map_err(|figure| MotorError { motor, figure })
    }
}
