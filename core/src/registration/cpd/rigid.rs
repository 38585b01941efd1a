//! The linear motion that makes the owed squared distances least: (1.46)-(1.53).

use nalgebra::{Matrix2, Point2, Vector2};

use super::posterior::Posterior;

/// What the closed forms are made of: (1.46).
pub(super) struct Sums {
    /// N_P.
    total: f64,
    x_mean: Vector2<f64>,
    y_mean: Vector2<f64>,
    /// A = X̂ᵀ Pᵀ Ŷ.
    across: Matrix2<f64>,
    /// Ŷᵀ d(P1) Ŷ.
    y_spread: Matrix2<f64>,
    /// tr(X̂ᵀ d(Pᵀ1) X̂).
    x_square: f64,
}

/// B, t and σ² after it.
type Fit = (Matrix2<f64>, Vector2<f64>, f64);

impl Sums {
    pub(super) fn of(y: &[Point2<f64>], x: &[Point2<f64>], owed: &Posterior) -> Self {
        let total = owed.total;
        let mut x_mean = Vector2::zeros();
        let mut x_square = 0.0;
        for (x, part) in x.iter().zip(&owed.of_fixed) {
            x_mean += x.coords * *part;
            x_square += x.coords.norm_squared() * part;
        }
        let (mut y_mean, mut across, mut y_spread) =
            (Vector2::zeros(), Matrix2::zeros(), Matrix2::zeros());
        for (y, owed) in y.iter().zip(&owed.of_moving) {
            y_mean += y.coords * owed.part;
            across += owed.place * y.coords.transpose();
            y_spread += y.coords * y.coords.transpose() * owed.part;
        }
        (x_mean, y_mean) = (x_mean / total, y_mean / total);
        Self {
            total,
            x_mean,
            y_mean,
            across: across - x_mean * y_mean.transpose() * total,
            y_spread: y_spread - y_mean * y_mean.transpose() * total,
            x_square: x_square - total * x_mean.norm_squared(),
        }
    }

    /// (1.47)-(1.50). In the plane R = U C Vᵀ is the rotation by the angle of A's antisymmetric
    /// part beside its trace.
    pub(super) fn rigid(&self, scales: bool) -> Option<Fit> {
        let a = &self.across;
        let (cos, sin) = (a[(0, 0)] + a[(1, 1)], a[(1, 0)] - a[(0, 1)]);
        let length = (cos * cos + sin * sin).sqrt();
        if length.is_nan() || length <= 0.0 {
            return None;
        }
        let (cos, sin) = (cos / length, sin / length);
        let rotation = Matrix2::new(cos, -sin, sin, cos);
        // tr(Aᵀ R) is that length.
        let y_square = self.y_spread.trace();
        let scale = if scales { length / y_square } else { 1.0 };
        let linear = rotation * scale;
        let left = self.x_square - 2.0 * scale * length + scale * scale * y_square;
        let variance = left / (2.0 * self.total);
        let shift = self.x_mean - linear * self.y_mean;
        (scale.is_finite() && variance.is_finite()).then_some((linear, shift, variance))
    }

    /// (1.51)-(1.53).
    pub(super) fn affine(&self) -> Option<Fit> {
        let linear = self.across * self.y_spread.try_inverse()?;
        let left = self.x_square - (self.across * linear.transpose()).trace();
        let variance = left / (2.0 * self.total);
        let shift = self.x_mean - linear * self.y_mean;
        variance.is_finite().then_some((linear, shift, variance))
    }
}
