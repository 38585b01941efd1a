//! In: weighted points. Out: their sums, and the total-least-squares line through any set of them
//! in a few operations.

use nalgebra::Vector2;

/// Weighted sums over points; differences of prefix sums give those of any range.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Moments {
    pub(super) w: f64,
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) xx: f64,
    pub(super) xy: f64,
    pub(super) yy: f64,
}

impl Moments {
    pub(super) fn of(w: f64, x: f64, y: f64) -> Self {
        let (wx, wy) = (w * x, w * y);
        Self {
            w,
            x: wx,
            y: wy,
            xx: wx * x,
            xy: wx * y,
            yy: wy * y,
        }
    }

    #[inline]
    pub(super) fn plus(&self, o: &Self) -> Self {
        Self {
            w: self.w + o.w,
            x: self.x + o.x,
            y: self.y + o.y,
            xx: self.xx + o.xx,
            xy: self.xy + o.xy,
            yy: self.yy + o.yy,
        }
    }

    #[inline]
    pub(super) fn minus(&self, o: &Self) -> Self {
        Self {
            w: self.w - o.w,
            x: self.x - o.x,
            y: self.y - o.y,
            xx: self.xx - o.xx,
            xy: self.xy - o.xy,
            yy: self.yy - o.yy,
        }
    }

    /// The mean, and the scatter xx, xy, yy about it.
    #[inline]
    fn scatter(&self) -> ([f64; 2], [f64; 3]) {
        let (x, y) = (self.x / self.w, self.y / self.w);
        let (xx, xy) = (self.xx - self.x * x, self.xy - self.x * y);
        ([x, y], [xx, xy, self.yy - self.y * y])
    }

    /// Normal and distance of the total-least-squares line; the distance may be negative.
    #[inline]
    pub(super) fn line(&self) -> (Vector2<f64>, f64) {
        let ([x, y], [xx, xy, yy]) = self.scatter();
        let normal = normal_of_scatter(xx, xy, yy);
        (normal, normal.x * x + normal.y * y)
    }

    /// Whether the sum of squared distances from every line is greater than `most`: the smaller
    /// eigenvalue of the scatter is at least determinant over trace. False proves nothing.
    #[inline]
    pub(super) fn is_wider_than(&self, most: f64) -> bool {
        let per = 1.0 / self.w;
        let (xx, xy, yy) = (
            self.xx - self.x * self.x * per,
            self.xy - self.x * self.y * per,
            self.yy - self.y * self.y * per,
        );
        xx * yy - xy * xy > most * (xx + yy)
    }

    /// Sums of squared distances from that line, and along it, about the mean: the eigenvalues of
    /// the scatter.
    pub(super) fn spreads(&self) -> (f64, f64) {
        let (_, [xx, xy, yy]) = self.scatter();
        let half_gap = 0.5 * ((yy - xx) * (yy - xx) + 4.0 * xy * xy).sqrt();
        let mean = 0.5 * (xx + yy);
        // Rounding must not make a square negative.
        ((mean - half_gap).max(0.0), mean + half_gap)
    }
}

/// (cos α, sin α) with α = ½ atan2(-2 Cxy, Cyy - Cxx), by the half-angle formulas: two roots
/// instead of calls of atan2 and sincos. Without a direction, (1, 0) as atan2(0, 0) gives.
#[inline]
pub(super) fn normal_of_scatter(xx: f64, xy: f64, yy: f64) -> Vector2<f64> {
    let (c, s) = (yy - xx, -2.0 * xy);
    let length = (c * c + s * s).sqrt();
    if length.is_nan() || length <= 0.0 {
        return Vector2::new(1.0, 0.0);
    }
    let half = (0.5 + 0.5 * c.abs() / length).sqrt();
    let other = s / (2.0 * half * length);
    if c >= 0.0 {
        Vector2::new(half, other)
    } else {
        Vector2::new(other.abs(), half.copysign(s))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::geom::Length;
    use crate::geom::sin_cos;

    #[test]
    fn half_angle_is_that_of_atan2() {
        for i in -720..=720_i32 {
            let double = PI * f64::from(i) / 720.0;
            let (sin, cos) = sin_cos(double);
            // xx - yy = -cos, 2 xy = -sin.
            let found = normal_of_scatter(1.0 - 0.5 * cos, -0.5 * sin, 1.0 + 0.5 * cos);
            let (s, c) = sin_cos(0.5 * libm::atan2(sin, cos));
            // At ±π both signs of the normal describe the same line.
            let error = (found - Vector2::new(c, s)).length();
            let turned = (found + Vector2::new(c, s)).length();
            assert!(error < 1e-9 || i.abs() == 720 && turned < 1e-9, "{double}");
        }
        assert_eq!(normal_of_scatter(2.0, 0.0, 2.0), Vector2::new(1.0, 0.0));
    }

    #[test]
    fn what_is_wider_for_sure_is_wider() {
        let mut answers = [0; 2];
        for i in 0..400_u32 {
            let mut sum = Moments::default();
            for k in 0..7_u32 {
                let along = f64::from(k * k * (1 + i % 7));
                let across = f64::from((k * 37 + i) % 11) * 0.01 * f64::from(i % 13);
                sum = sum.plus(&Moments::of(
                    0.5 + f64::from(k),
                    along,
                    3.0 + along - across,
                ));
            }
            let (across, along) = sum.spreads();
            let most = 0.02 * f64::from(1 + i % 17);
            let is_wider = sum.is_wider_than(most);
            assert!(!is_wider || across > most, "{i}: {across}");
            // It misses at most those that are less than twice as wide.
            assert!(is_wider || across * along / (across + along) <= most * 1.0001);
            answers[usize::from(is_wider)] += 1;
        }
        assert!(answers.iter().all(|&n| n > 40), "{answers:?}");
    }

    #[test]
    fn spreads_of_a_cross_are_its_arms() {
        // Two points 3 m apart along (3, 4)/5, two 1 m apart across it.
        let (along, across) = (Vector2::new(0.6, 0.8), Vector2::new(-0.8, 0.6));
        let mut sum = Moments::default();
        for p in [along * 1.5, along * -1.5, across * 0.5, across * -0.5] {
            sum = sum.plus(&Moments::of(2.0, p.x + 7.0, p.y - 3.0));
        }
        let (across, along) = sum.spreads();
        assert!((across - 1.0).abs() < 1e-12 && (along - 9.0).abs() < 1e-12);
    }
}
