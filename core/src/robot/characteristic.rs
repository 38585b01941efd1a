//! The characteristic of an infra-red ranger: from volts to range.
//!
//! In: pairs of a known range and the volts measured there. Out: a polynomial of the fifth degree,
//! its residuals, and whether it can be trusted between the pairs.
//!
//! 1. The variable is volts or 1/volts, shifted and scaled so that the pairs span [-1, 1]: fifth
//!    powers of raw volts would cost half the digits.
//! 2. Least squares by Householder QR of the Vandermonde matrix (Golub & Van Loan §5.3).
//! 3. The ends of the pairs bound the domain: volts beyond are clamped, because a polynomial
//!    diverges there.
//! 4. Where the derivative changes sign, the polynomial turns round, and two voltages give the same
//!    range: that is reported.
//!
//! Why 1/volts: the ranger triangulates, so volts fall nearly like 1/range, and range is nearly a
//! straight line in 1/volts. In volts, the polynomial has to bend, and ripples.
//!
//! Source: TDK 2016 §1.3 (polynomial of the fifth degree); the specification, "Sensors", for the
//! pairs.

mod polynomial;
#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, DVector};

use self::polynomial::{DEGREE, Polynomial};
use crate::bounds::{self, OutOfBounds, POSITIVE};

/// Fewest pairs for a fit: one more than there are coefficients, so that a residual remains to
/// judge it.
pub const LEAST_PAIRS: usize = DEGREE + 2;

/// A range set up by hand, and the ranger's output there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CalibrationPair {
    /// True range, m.
    pub range: f64,
    /// Volts measured.
    pub volts: f64,
}

/// The variable of the polynomial.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Variable {
    /// Volts, as in TDK 2016.
    Volts,
    /// 1/volts.
    #[default]
    PerVolt,
}

/// Range as a polynomial of volts or 1/volts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Characteristic {
    variable: Variable,
    polynomial: Polynomial,
    /// Middle and half of the span of the variable.
    centre: f64,
    half_span: f64,
    /// Lowest and highest volts of the pairs.
    domain: [f64; 2],
}

/// A characteristic, and how well it fits.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The polynomial.
    pub characteristic: Characteristic,
    /// For each pair: fitted minus true range, m.
    pub residuals: Vec<f64>,
    /// Root of the sum of the squared residuals over the degrees of freedom, m.
    pub sigma: f64,
    /// Volts at which the range begins to rise with the volts; `None` if it falls throughout, as it
    /// should.
    pub reverses_at: Option<f64>,
}

/// Why no characteristic can be fitted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CharacteristicError {
    /// Too few pairs.
    #[error(
        "calibration: {count} pairs, expected at least {LEAST_PAIRS} for a polynomial of degree {DEGREE}"
    )]
    TooFew {
        /// Number of pairs.
        count: usize,
    },
    /// A figure that is impossible.
    #[error("calibration pair {pair}: {figure}")]
    Value {
        /// Number of the pair, from 1.
        pair: usize,
        /// The figure at fault.
        figure: OutOfBounds,
    },
    /// Ranges must rise and volts must fall from pair to pair: closer than the peak, the ranger is
    /// ambiguous.
    #[error(
        "calibration pair {pair}: {range} m, {volts} V after {last_range} m, {last_volts} V; expected a greater range and \
         fewer volts"
    )]
    OutOfOrder {
        /// Number of the pair, from 1.
        pair: usize,
        /// Its range, m.
        range: f64,
        /// Its volts.
        volts: f64,
        /// Range of the pair before, m.
        last_range: f64,
        /// Volts of the pair before.
        last_volts: f64,
    },
    /// The pairs do not determine the coefficients.
    #[error("calibration: the volts lie too close together to settle {} coefficients", DEGREE + 1)]
    Singular,
}

impl Characteristic {
    /// Fits the polynomial to pairs in the order of rising range.
    ///
    /// # Errors    [`CharacteristicError`], naming the first pair that cannot be used.
    pub fn fit(pairs: &[CalibrationPair], variable: Variable) -> Result<Fit, CharacteristicError> {
        check(pairs)?;
        let xs: Vec<f64> = pairs.iter().map(|p| variable.of(p.volts)).collect();
        let low = xs.iter().copied().fold(f64::INFINITY, f64::min);
        let high = xs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let (centre, half_span) = (0.5 * (low + high), 0.5 * (high - low));
        let scaled: Vec<f64> = xs.iter().map(|x| (x - centre) / half_span).collect();
        let ranges: Vec<f64> = pairs.iter().map(|p| p.range).collect();
        let volts = pairs.iter().map(|p| p.volts);
        let characteristic = Self {
            variable,
            polynomial: least_squares(&scaled, &ranges)?,
            centre,
            half_span,
            domain: [
                volts.clone().fold(f64::INFINITY, f64::min),
                volts.fold(f64::NEG_INFINITY, f64::max),
            ],
        };
        Ok(characteristic.judged_by(pairs))
    }

    /// Range for these volts, m. Volts beyond the pairs are clamped to the nearest of them.
    #[must_use]
    pub fn range_at(&self, volts: f64) -> f64 {
        self.polynomial.at(self.scaled(volts))
    }

    /// Derivative of the range by the volts, m/V; beyond the pairs, that at the nearest one.
    #[must_use]
    pub fn slope_at(&self, volts: f64) -> f64 {
        let [low, high] = self.domain;
        let slope = self.polynomial.derivative().at(self.scaled(volts)) / self.half_span;
        slope * self.variable.slope(volts.clamp(low, high))
    }

    /// Lowest and highest volts of the pairs it was fitted to.
    #[must_use]
    pub fn domain(&self) -> [f64; 2] {
        self.domain
    }

    fn scaled(&self, volts: f64) -> f64 {
        let [low, high] = self.domain;
        (self.variable.of(volts.clamp(low, high)) - self.centre) / self.half_span
    }

    fn judged_by(self, pairs: &[CalibrationPair]) -> Fit {
        let residual = |p: &CalibrationPair| self.range_at(p.volts) - p.range;
        let residuals: Vec<f64> = pairs.iter().map(residual).collect();
        let squares: f64 = residuals.iter().map(|r| r * r).sum();
        let freedom = (pairs.len() - (DEGREE + 1)) as f64;
        Fit {
            reverses_at: self.reverses_at(),
            characteristic: self,
            residuals,
            sigma: (squares / freedom).sqrt(),
        }
    }

    /// The derivative is a polynomial too: between its own roots its sign is constant, so checking
    /// each stretch once is enough.
    fn reverses_at(&self) -> Option<f64> {
        let derivative = self.polynomial.derivative();
        let mut borders = vec![-1.0];
        borders.extend(derivative.roots_within(-1.0, 1.0));
        borders.push(1.0);
        let stretches = borders.iter().zip(borders.iter().skip(1));
        // Range rises with 1/volts, and falls with volts.
        let right = match self.variable {
            Variable::Volts => -1.0,
            Variable::PerVolt => 1.0,
        };
        let wrong = |(from, to): &(&f64, &f64)| right * derivative.at(0.5 * (*from + *to)) < 0.0;
        let (from, _) = stretches.into_iter().find(wrong)?;
        Some(self.variable.of(self.centre + self.half_span * from))
    }
}

impl Variable {
    /// The variable for volts; it is its own inverse, so also the volts for the variable.
    fn of(self, volts: f64) -> f64 {
        match self {
            Self::Volts => volts,
            Self::PerVolt => 1.0 / volts,
        }
    }

    /// Derivative of the variable by the volts.
    fn slope(self, volts: f64) -> f64 {
        match self {
            Self::Volts => 1.0,
            Self::PerVolt => -1.0 / (volts * volts),
        }
    }
}

fn check(pairs: &[CalibrationPair]) -> Result<(), CharacteristicError> {
    if pairs.len() < LEAST_PAIRS {
        return Err(CharacteristicError::TooFew { count: pairs.len() });
    }
    for (pair, CalibrationPair { range, volts }) in (1..).zip(pairs) {
        let figures = [("range", *range, POSITIVE), ("volts", *volts, POSITIVE)];
        bounds::check(&figures).map_err(|figure| CharacteristicError::Value { pair, figure })?;
    }
    for (index, (last, pair)) in pairs.iter().zip(pairs.iter().skip(1)).enumerate() {
        if pair.range <= last.range || pair.volts >= last.volts {
            return Err(CharacteristicError::OutOfOrder {
                pair: index + 2,
                range: pair.range,
                volts: pair.volts,
                last_range: last.range,
                last_volts: last.volts,
            });
        }
    }
    Ok(())
}

fn least_squares(xs: &[f64], ys: &[f64]) -> Result<Polynomial, CharacteristicError> {
    let mut rows = DMatrix::from_element(xs.len(), DEGREE + 1, 1.0);
    for power in 1..=DEGREE {
        for (row, x) in xs.iter().enumerate() {
            rows[(row, power)] = rows[(row, power - 1)] * x;
        }
    }
    let qr = rows.qr();
    let r = qr.r();
    let diagonal = r.diagonal().abs();
    if diagonal.min() < 1e-12 * diagonal.max() {
        return Err(CharacteristicError::Singular);
    }
    let right = qr.q().tr_mul(&DVector::from_column_slice(ys));
    let solved = r.solve_upper_triangular(&right);
    let solved = solved.ok_or(CharacteristicError::Singular)?;
    let mut coefficients = [0.0; DEGREE + 1];
    coefficients.copy_from_slice(solved.as_slice());
    Ok(Polynomial(coefficients))
}
