//! From the figures of the motors to the gains of the controller.
//!
//! In: a [`DriveTrain`] and the period. Out: [`Gains`], or the reason why there are none.
//!
//! 1. The five-state model must be controllable: for each eigenvalue λ of A, the rows of [λI - A,
//!    B] are independent (Hautus). An uncontrollable mode is reported by its main state.
//! 2. The model is made discrete for a voltage that is held during the period, and each output gets
//!    an integrator: z ← z + h (y - y_wished), for ΔΨ and for Ψ'_L.
//! 3. The weights of a linear-quadratic regulator are inverse squares of the acceptable deviations
//!    (Bryson's rule).
//! 4. Each motor's observer has the states (Ψ, Ψ', i, load), because encoders count only Ψ. The
//!    load torque is a state too: without it, a load or a wrong figure leaves a lasting error in
//!    the estimated speed. The gain is that of the stationary Kalman filter; the measurement noise
//!    is that of rounding to counts, one twelfth of a count squared.
//!
//! Source: TDK 2016 §1.1 (model, state feedback, integrators); Åström & Wittenmark (1997),
//! "Computer-controlled systems", ch. 9 and 11.

use nalgebra::{DMatrix, Matrix2, Matrix4, SMatrix, SVector, Vector4};

use super::discrete::discretize;
use super::riccati::{RiccatiError, filter_gain, regulator_gain};
use crate::bounds::{OutOfBounds, POSITIVE, check};
use crate::robot::{DriveTrain, MotorError, MotorModel};

/// Pivots of [λI - A, B] below this part of the largest count as 0.
const UNCONTROLLABLE: f64 = 1e-9;

/// Acceptable error of ΔΨ, rad: five counts; smaller drives straighter and takes more voltage.
const DIFFERENCE: f64 = 0.05;
/// Acceptable error of a speed, rad/s.
const SPEED: f64 = 0.3;
/// Acceptable error of a current, A.
const CURRENT: f64 = 1.0;
/// Acceptable integral of the error of ΔΨ, rad s; smaller ends lasting errors sooner, but swings
/// sooner.
const DIFFERENCE_INTEGRAL: f64 = 0.02;
/// Acceptable integral of the error of Ψ'_L, rad; as above.
const SPEED_INTEGRAL: f64 = 0.1;
/// Voltage that weighs as much as an acceptable error, as a part of the battery's.
const VOLTAGE: f64 = 0.28;
/// How fast the load drifts, as the observer assumes: part of the stalled motor's torque per √s;
/// more follows loads sooner and lets more of the steps of the counts through.
const LOAD_DRIFT: f64 = 0.3;
/// Of (ΔΨ, Ψ'_L, i_L, Ψ'_R, i_R, z_ΔΨ, z_Ψ').
#[rustfmt::skip]
const ACCEPTABLE: [f64; 7] =
    [DIFFERENCE, SPEED, CURRENT, SPEED, CURRENT, DIFFERENCE_INTEGRAL, SPEED_INTEGRAL];

/// Why there is no controller for these motors.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DesignError {
    /// A figure of the motors.
    #[error(transparent)]
    Motor(#[from] MotorError),
    /// The period, or the encoder.
    #[error("controller: {0}")]
    Config(#[from] OutOfBounds),
    /// No voltage affects one of the modes.
    #[error(
        "the motors cannot be controlled: no voltage moves the mode of eigenvalue {eigenvalue:.4} 1/s, mostly {state}"
    )]
    Uncontrollable {
        /// Real part of the mode's eigenvalue, 1/s.
        eigenvalue: f64,
        /// The state that has the largest part in it.
        state: &'static str,
    },
    /// No gain for the feedback or an observer.
    #[error("no gain for the {of}: {source}")]
    Gain {
        /// Which gain.
        of: &'static str,
        /// Why.
        source: RiccatiError,
    },
}

/// What the controller computes with in each period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// K of u = u_wished - K e, with e = (ΔΨ, Ψ'_L, i_L, Ψ'_R, i_R, z_ΔΨ, z_Ψ'): observed minus
    /// desired.
    pub feedback: SMatrix<f64, 2, 7>,
    /// Of the left and of the right motor.
    pub observers: [ObserverGains; 2],
    /// Period h, s.
    pub period: f64,
}

/// The observer of one motor: x = (Ψ, Ψ', i, load).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObserverGains {
    /// Φ of x⁺ = Φ x + Γ u.
    pub transition: Matrix4<f64>,
    /// Γ.
    pub input: Vector4<f64>,
    /// What one radian of innovation adds.
    pub gain: Vector4<f64>,
}

impl Gains {
    /// The gains for motors that are read and driven once every `period` seconds, with an encoder
    /// of `radians_per_count`.
    ///
    /// # Errors    [`DesignError`]: an impossible figure, a model that no voltage controls, an
    /// equation that does not converge.
    pub fn design(
        train: &DriveTrain,
        period: f64,
        radians_per_count: f64,
    ) -> Result<Self, DesignError> {
        train.validate()?;
        check(&[
            ("period", period, POSITIVE),
            ("radians_per_count", radians_per_count, POSITIVE),
        ])?;
        check_controllable(train)?;
        let (a, b) = with_integrators(train, period);
        let weight = |acceptable: f64| 1.0 / (acceptable * acceptable);
        let q = SMatrix::<f64, 7, 7>::from_diagonal(&SVector::from(ACCEPTABLE.map(weight)));
        let r = Matrix2::from_diagonal_element(weight(VOLTAGE * train.battery));
        let feedback = regulator_gain(&a, &b, &q, &r).map_err(|source| DesignError::Gain {
            of: "feedback",
            source,
        })?;
        let observer = |motor: &MotorModel, of| {
            let stalled = motor.torque_constant * train.battery / motor.resistance;
            observer(motor, period, radians_per_count, LOAD_DRIFT * stalled)
                .map_err(|source| DesignError::Gain { of, source })
        };
        Ok(Self {
            feedback,
            observers: [
                observer(&train.left, "left observer")?,
                observer(&train.right, "right observer")?,
            ],
            period,
        })
    }
}

/// The discrete model with both integrators: x = (ΔΨ, Ψ'_L, i_L, Ψ'_R, i_R, z_ΔΨ, z_Ψ').
pub(super) fn with_integrators(
    train: &DriveTrain,
    period: f64,
) -> (SMatrix<f64, 7, 7>, SMatrix<f64, 7, 2>) {
    let (a, b) = train.matrices();
    let (phi, s) = discretize(&a, period);
    let mut with = SMatrix::<f64, 7, 7>::identity();
    let mut input = SMatrix::<f64, 7, 2>::zeros();
    with.fixed_view_mut::<5, 5>(0, 0).copy_from(&phi);
    input.fixed_view_mut::<5, 2>(0, 0).copy_from(&(s * b));
    with[(5, 0)] = period;
    with[(6, 1)] = period;
    (with, input)
}

fn observer(
    motor: &MotorModel,
    period: f64,
    radians_per_count: f64,
    load_drift: f64,
) -> Result<ObserverGains, RiccatiError> {
    let (of_motor, voltage, load) = motor.matrices();
    let mut a = Matrix4::zeros();
    a.fixed_view_mut::<3, 3>(0, 0).copy_from(&of_motor);
    a.fixed_view_mut::<3, 1>(0, 3).copy_from(&load);
    let (transition, s) = discretize(&a, period);
    let input = s * Vector4::new(voltage.x, voltage.y, voltage.z, 0.0);
    // A load that drifts moves the other states as well: to first order by S's last column.
    let drift = s.column(3) * (load_drift / period.sqrt());
    let process = drift * drift.transpose();
    let rounding = radians_per_count * radians_per_count / 12.0;
    let measured = Vector4::new(1.0, 0.0, 0.0, 0.0);
    Ok(ObserverGains {
        transition,
        input,
        gain: filter_gain(&transition, &measured, &process, rounding)?,
    })
}

/// Hautus' test on the five-state model.
fn check_controllable(train: &DriveTrain) -> Result<(), DesignError> {
    const STATES: [&str; 5] = [
        "the difference of the angles",
        "the speed of the left motor",
        "the current of the left motor",
        "the speed of the right motor",
        "the current of the right motor",
    ];
    let (a, b) = train.matrices();
    for eigenvalue in a.complex_eigenvalues().iter() {
        // The complex matrix R + i I as a real one, [R -I; I R], in which each singular value
        // occurs twice: complex numbers would need a routine of their own for this alone.
        let rows = DMatrix::from_fn(10, 14, |row, column| {
            let is_diagonal = row % 5 == column % 7;
            match (row / 5 == column / 7, column % 7) {
                (true, input @ 5..) => b[(row % 5, input - 5)],
                (true, state) if is_diagonal => eigenvalue.re - a[(row % 5, state)],
                (true, state) => -a[(row % 5, state)],
                (false, _) if is_diagonal && row < 5 => -eigenvalue.im,
                (false, _) if is_diagonal => eigenvalue.im,
                (false, _) => 0.0,
            }
        });
        // A singular value of zero: its left vector is the mode that no column reaches.
        let svd = rows.svd(true, false);
        let (at, least) = svd.singular_values.argmin();
        if least <= UNCONTROLLABLE * svd.singular_values.max() {
            let part = |u: &DMatrix<f64>, state: usize| {
                let [re, im] = [state, state + 5].map(|row| u[(row, at)]);
                re * re + im * im
            };
            let mode = svd
                .u
                .map(|u| SVector::<f64, 5>::from_fn(|state, _| part(&u, state)));
            return Err(DesignError::Uncontrollable {
                eigenvalue: eigenvalue.re,
                state: mode.map_or("", |mode| STATES[mode.imax()]),
            });
        }
    }
    Ok(())
}
