//! The linear motion that minimises the squared distances weighted by p_mn: (1.46)-(1.53).

use nalgebra::{Matrix2, Point2, Vector2};

use super::posterior::{Posterior, Pull, Pulls};

/// The sums that the closed forms need: (1.46).
pub(super) struct Sums {
    /// N_P.
    pub(super) total: f64,
    x_mean: Vector2<f64>,
    y_mean: Vector2<f64>,
    /// A = X̂ᵀ Pᵀ Ŷ.
    across: Matrix2<f64>,
    /// Ŷᵀ d(P1) Ŷ.
    y_spread: Matrix2<f64>,
    /// tr(X̂ᵀ d(Pᵀ1) X̂).
    x_square: f64,
}

/// B, t and the σ² that results.
type Fit = (Matrix2<f64>, Vector2<f64>, f64);

impl Sums {
    /// From moving points at their present places, and fixed points.
    pub(super) fn of(y: &[Point2<f64>], x: &[Point2<f64>], pulls: &Pulls) -> Self {
        match pulls {
            Pulls::OfFixed(pulls) => Self::of_fixed(x, pulls),
            Pulls::OfBoth(owed) => Self::of_both(y, x, owed),
        }
    }

    /// With y_m = x_n + d.
    fn of_fixed(x: &[Point2<f64>], pulls: &[Pull]) -> Self {
        let (mut total, mut x_square) = (0.0, 0.0);
        let (mut x_sum, mut y_sum) = (Vector2::zeros(), Vector2::zeros());
        let (mut across, mut y_spread) = (Matrix2::zeros(), Matrix2::zeros());
        for (x, Pull { part, off, spread }) in x.iter().zip(pulls) {
            let (x, own) = (x.coords, x.coords * *part);
            let (own_square, by_off) = (own * x.transpose(), x * off.transpose());
            total += part;
            x_sum += own;
            y_sum += own + off;
            x_square += own_square.trace();
            across += own_square + by_off;
            y_spread += own_square + by_off + by_off.transpose() + spread;
        }
        Self::about_means(total, x_sum, y_sum, across, y_spread, x_square)
    }

    fn of_both(y: &[Point2<f64>], x: &[Point2<f64>], owed: &Posterior) -> Self {
        let total = owed.total;
        let mut x_sum = Vector2::zeros();
        let mut x_square = 0.0;
        for (x, part) in x.iter().zip(&owed.of_fixed) {
            x_sum += x.coords * *part;
            x_square += x.coords.norm_squared() * part;
        }
        let (mut y_sum, mut across, mut y_spread) =
            (Vector2::zeros(), Matrix2::zeros(), Matrix2::zeros());
        for (y, owed) in y.iter().zip(&owed.of_moving) {
            y_sum += y.coords * owed.part;
            across += owed.place * y.coords.transpose();
            y_spread += y.coords * y.coords.transpose() * owed.part;
        }
        Self::about_means(total, x_sum, y_sum, across, y_spread, x_square)
    }

    /// From sums that are not yet taken about the means.
    fn about_means(
        total: f64,
        x_sum: Vector2<f64>,
        y_sum: Vector2<f64>,
        across: Matrix2<f64>,
        y_spread: Matrix2<f64>,
        x_square: f64,
    ) -> Self {
        let (x_mean, y_mean) = (x_sum / total, y_sum / total);
        Self {
            total,
            x_mean,
            y_mean,
            across: across - x_mean * y_mean.transpose() * total,
            y_spread: y_spread - y_mean * y_mean.transpose() * total,
            x_square: x_square - total * x_mean.norm_squared(),
        }
    }

    /// (1.47)-(1.50). In the plane, R = U C Vᵀ is the rotation whose angle follows from A's
    /// antisymmetric part and its trace.
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
