//! The sums behind a fitted line: steps 1, 2 and 4 of [`super`].

use std::ops::Range;

use nalgebra::{Matrix2, Point2, Vector2};
use wide::f64x4;

use super::FitError;
use crate::features::columns::{Columns, total};
use crate::features::moments::normal_of_scatter;
use crate::features::piece::Piece;
use crate::geom::Line;

/// Steps 1 and 2: weights, mean and the scatter of the wall alone.
pub(super) struct Scatter {
    pub(super) n_points: usize,
    w: f64,
    mean: Vector2<f64>,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Scatter {
    pub(super) fn of(columns: &Columns, piece: &Piece) -> Self {
        let w = piece.moments.w;
        let mean = Vector2::new(piece.moments.x, piece.moments.y) / w;
        let [mx, my, per_total] = [mean.x, mean.y, 1.0 / w].map(f64x4::splat);
        let exact = columns.bearings_are_exact();
        let zero = f64x4::ZERO;
        let (mut count, mut xx, mut xy, mut yy) = (zero, zero, zero, zero);
        let blocks = columns.blocks(piece.range());
        for block in 0..blocks.len() {
            let b = blocks.at(block);
            let (dx, dy) = (b.x - mx, b.y - my);
            let weight = b.weight * b.keep;
            let (wx, wy) = (weight * dx, weight * dy);
            // What the noise adds: `along` on the beam, since w σ² = 1, and `across` it.
            let along = b.keep - weight * per_total;
            let (ux, uy) = (along * b.ux, along * b.uy);
            count += b.keep;
            xx += wx * dx - ux * b.ux;
            xy += wx * dy - ux * b.uy;
            yy += wy * dy - uy * b.uy;
            if !exact {
                let across = weight * b.var_across * along;
                let (vx, vy) = (across * b.uy, across * b.ux);
                xx -= vx * b.uy;
                xy += vx * b.ux;
                yy -= vy * b.ux;
            }
        }
        Self {
            n_points: total(count) as usize,
            w,
            mean,
            xx: total(xx),
            xy: total(xy),
            yy: total(yy),
        }
    }

    pub(super) fn frame(&self) -> Result<Frame, FitError> {
        let (double, cross) = (self.yy - self.xx, -2.0 * self.xy);
        // Eigenvalues of the scatter: the line runs along the greater.
        let spread = (double * double + cross * cross).sqrt();
        let both = self.xx + self.yy;
        let (along, across) = (0.5 * (both + spread), 0.5 * (both - spread));
        // A spread along the line of a few standard deviations of one point is no direction. Nor is one that only stands
        // out because the noise that was taken off has left less than nothing across it.
        if !(along > 4.0 && spread > 4.0 && spread.is_finite()) {
            return Err(FitError::Degenerate { along, across });
        }
        let normal = normal_of_scatter(self.xx, self.xy, self.yy);
        let r = normal.dot(&self.mean);
        let sign = if r < 0.0 { -1.0 } else { 1.0 };
        let (normal, tangent) = (normal * sign, Vector2::new(-normal.y, normal.x) * sign);
        Ok(Frame {
            line: Line::new(0.5 * libm::atan2(cross, double), r),
            normal,
            tangent,
            spread,
            mean_t: tangent.dot(&self.mean),
        })
    }
}

/// The frame of the line: n across it, t along it from the mean.
pub(super) struct Frame {
    pub(super) line: Line,
    pub(super) normal: Vector2<f64>,
    tangent: Vector2<f64>,
    /// Ctt - Cnn.
    spread: f64,
    mean_t: f64,
}

/// How an error of the heading at the first beam, or at the last, fades to none at the middle one.
pub(super) struct Faded {
    middle: f64,
    per_half: f64,
}

impl Faded {
    pub(super) fn between(first: usize, last: usize) -> Self {
        let middle = 0.5 * (first + last) as f64;
        Self {
            middle,
            per_half: 1.0 / (last as f64 - middle).abs().max(0.5),
        }
    }
}

/// Where a point lies along the line, as -1 at the first point and 1 at the last.
pub(super) struct Along {
    middle: f64,
    per_half: f64,
}

impl Along {
    pub(super) fn between(frame: &Frame, first: Point2<f64>, last: Point2<f64>) -> Self {
        let [first, last] = [first, last].map(|p| frame.tangent.dot(&p.coords) - frame.mean_t);
        Self {
            middle: 0.5 * (first + last),
            per_half: 2.0 / (last - first).abs().max(f64::MIN_POSITIVE),
        }
    }
}

/// Step 4: the sums over the points in the frame of the line.
pub(super) struct Sums {
    a: f64,
    b: f64,
    c: f64,
    pub(super) chi2: f64,
    pub(super) bend: Bend,
    /// What a turn does to α and to n, before and after the middle.
    turn_alpha: [f64; 2],
    turn_n: [f64; 2],
}

impl Sums {
    pub(super) fn of(
        columns: &Columns,
        range: Range<usize>,
        frame: &Frame,
        faded: &Faded,
        along: &Along,
    ) -> Self {
        let [middle_t, per_half_t] = [along.middle, along.per_half].map(f64x4::splat);
        let [nx, ny, tx, ty, r, mean_t, middle, per_half, surface] = [
            frame.normal.x,
            frame.normal.y,
            frame.tangent.x,
            frame.tangent.y,
            frame.line.r(),
            frame.mean_t,
            faded.middle,
            faded.per_half,
            // Where nothing at all is uncertain a distance is infinitely many sigmas, not NaN.
            columns.var_surface() + f64::MIN_POSITIVE,
        ]
        .map(f64x4::splat);
        let zero = f64x4::ZERO;
        let (mut a, mut b, mut c, mut chi2) = (zero, zero, zero, zero);
        let (mut turn_alpha, mut turn_n) = ([zero; 2], [zero; 2]);
        let (mut powers, mut products) = ([zero; 5], [zero; 3]);
        let exact = columns.bearings_are_exact();
        let blocks = columns.blocks(range);
        for block in 0..blocks.len() {
            let p = blocks.at(block);
            let weight = p.weight * p.keep;
            let (n, t) = (nx * p.x + ny * p.y - r, tx * p.x + ty * p.y - mean_t);
            let (un, ut) = (nx * p.ux + ny * p.uy, tx * p.ux + ty * p.uy);
            let by_range = t * un + n * ut;
            let w_range = weight * by_range;
            a += w_range * by_range;
            b += w_range * un;
            c += weight * un * un;
            let mut variance = un * un * p.var_along + surface;
            if !exact {
                let by_bearing = n * un - t * ut;
                let w_bearing = weight * p.weight * p.var_across;
                a += w_bearing * by_bearing * by_bearing;
                b -= w_bearing * by_bearing * ut;
                c += w_bearing * ut * ut;
                variance += ut * ut * p.var_across;
            }
            // Σ g sᵏ and Σ g n sᵏ, with g the information of a point and s its place along the line.
            let (g, s) = (p.keep / variance, (t - middle_t) * per_half_t);
            let (gn, gs) = (g * n, g * s);
            let gss = gs * s;
            chi2 += gn * n;
            powers[0] += g;
            powers[1] += gs;
            powers[2] += gss;
            powers[3] += gss * s;
            powers[4] += gss * s * s;
            products[0] += gn;
            products[1] += gn * s;
            products[2] += gn * s * s;
            // A turn about the robot moves the point by its distance, at right angles.
            let (dn, dt) = (-(t + mean_t), r + n);
            let w_alpha = weight * (t * dn + n * dt);
            let w_n = weight * dn;
            let from_middle = (p.number - middle) * per_half;
            let (before, after) = (
                (-from_middle).fast_max(zero).fast_min(f64x4::ONE),
                from_middle.fast_max(zero).fast_min(f64x4::ONE),
            );
            turn_alpha[0] += w_alpha * before;
            turn_alpha[1] += w_alpha * after;
            turn_n[0] += w_n * before;
            turn_n[1] += w_n * after;
        }
        Self {
            a: total(a),
            b: total(b),
            c: total(c),
            chi2: total(chi2),
            bend: Bend {
                powers: powers.map(total),
                products: products.map(total),
            },
            turn_alpha: turn_alpha.map(total),
            turn_n: turn_n.map(total),
        }
    }

    /// Covariance of (α, r).
    pub(super) fn covariance(
        &self,
        scatter: &Scatter,
        frame: &Frame,
    ) -> Result<Matrix2<f64>, FitError> {
        let (spread, w, mean_t) = (frame.spread, scatter.w, frame.mean_t);
        let incidence_squared = self.c / w;
        let aa = self.a / (spread * spread);
        let a_n = -self.b / (spread * w);
        let nn = self.c / (w * w);
        let ar = a_n + mean_t * aa;
        let rr = nn + 2.0 * mean_t * a_n + mean_t * mean_t * aa;
        // 3e-5 rad: at 30 m the line is a millimetre wide.
        let is_seen = incidence_squared > 1e-9 && aa > 0.0 && aa * nn - a_n * a_n > 1e-12 * aa * nn;
        if !(is_seen && rr.is_finite() && aa * rr - ar * ar > 0.0) {
            return Err(FitError::Unobservable {
                incidence: incidence_squared.sqrt(),
            });
        }
        Ok(Matrix2::new(aa, ar, ar, rr))
    }

    /// Change of (α, r) by a heading that was off by 1 rad at the first beam, and at the last.
    pub(super) fn by_heading(&self, scatter: &Scatter, frame: &Frame) -> [Vector2<f64>; 2] {
        [0, 1].map(|side| {
            let by_alpha = -self.turn_alpha[side] / frame.spread;
            Vector2::new(
                by_alpha,
                self.turn_n[side] / scatter.w + frame.mean_t * by_alpha,
            )
        })
    }
}

/// How bent the points are: the part of s² that no line can take up, q = s² - a - b s by least squares, so that Σ g q = Σ g q s = 0,
/// against the residuals.
pub(super) struct Bend {
    /// Σ g sᵏ for k = 0 to 4.
    powers: [f64; 5],
    /// Σ g n sᵏ for k = 0 to 2.
    products: [f64; 3],
}

impl Bend {
    /// Σ g q n / √(Σ g q²).
    pub(super) fn sigmas(&self) -> f64 {
        let ([s0, s1, s2, s3, s4], [n0, n1, n2]) = (self.powers, self.products);
        let determinant = s0 * s2 - s1 * s1;
        if determinant.is_nan() || determinant <= 0.0 {
            return 0.0;
        }
        let (a, b) = (
            (s2 * s2 - s1 * s3) / determinant,
            (s0 * s3 - s1 * s2) / determinant,
        );
        let (product, norm) = (n2 - a * n0 - b * n1, s4 - a * s2 - b * s3);
        if norm > 0.0 {
            product.abs() / norm.sqrt()
        } else {
            0.0
        }
    }
}
