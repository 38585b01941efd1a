//! In: beams on one wall. Out: the wall's line (α, r) in the robot frame, with covariance.
//!
//! 1. Weighted total least squares with w = 1/σ²: α = ½ atan2(-2 Cxy, Cyy - Cxx), r = x̄ cos α + ȳ sin α, then r ≥ 0
//!    (TDK 2016 §4.1, with the erratum of the specification on the arctangent; Siegwart & Nourbakhsh 2004, §4.3.1).
//! 2. C is the weighted scatter less what the noise alone contributes to it, Σ wᵢ (1 - wᵢ/W) Rᵢ with Rᵢ the covariance of
//!    point i. Noise runs along the beam, not around the point, so without this α is biased towards the side seen
//!    at the flatter angle; a bias does not average out over hundreds of scans, and a filter that believes σ_α would.
//! 3. Covariance F C_X Fᵀ of range and bearing noise (Arras & Siegwart 1997, "Feature extraction and scene
//!    interpretation for map-based navigation and map building"), with F in closed form. In the frame of the line
//!    (t along it, n across it) ∂α = -w (t ∂n + n ∂t) / (Ctt - Cnn) and ∂r = w/W ∂n + t̄ ∂α. The source's numeric F is
//!    the test.
//! 4. With (uₙ, uₜ) the beam in that frame, the range moves a point by (uₙ, uₜ), the bearing by (-uₜ, uₙ), and
//!    p = t uₙ + n uₜ, q = n uₙ - t uₜ are what they do to α. So three sums over the points give the whole covariance:
//!    A = Σ w p² + w² σ⊥² q², B = Σ w p uₙ - w² σ⊥² q uₜ, C = Σ w uₙ² + w² σ⊥² uₜ².

use std::ops::Range;

use nalgebra::{Matrix2, Point2, Vector2};
use wide::f64x4;

use super::columns::{Columns, Noise, total};
use super::feature::LineFeature;
use super::moments::normal_of_scatter;
use super::piece::Piece;
use crate::geom::Line;
use crate::points::Beam;

/// Why no line goes through some beams.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// A line needs two points.
    #[error("{n_points} points; a line needs at least 2")]
    TooFew {
        /// How many there are.
        n_points: usize,
    },
    /// The points are not longer than they are wide.
    #[error(
        "points spread {along:.3} along the line and {across:.3} across it (weighted, noise removed); no direction stands out"
    )]
    Degenerate {
        /// Weighted scatter along the line.
        along: f64,
        /// Weighted scatter across the line.
        across: f64,
    },
    /// The beams run along the line: their ranges say nothing about where it lies.
    #[error(
        "beams meet the line at {incidence:.1e} rad (root mean square); its distance from the sensor is not measured"
    )]
    Unobservable {
        /// Sine of the angle between beams and line, with what the bearings measure.
        incidence: f64,
    },
    /// A beam whose numbers cannot be used.
    #[error(
        "beam {beam_idx}: ends at ({x}, {y}) m, range {range} m, sigma {sigma} m; expected finite numbers, range and sigma greater than 0"
    )]
    Value {
        /// Number of the beam in the scan.
        beam_idx: usize,
        /// Where it ends, m.
        x: f64,
        /// Where it ends, m.
        y: f64,
        /// Its range, m.
        range: f64,
        /// Its standard deviation, m.
        sigma: f64,
    },
    /// A standard deviation that cannot be used.
    #[error("{field} is {value}; expected a finite number, not negative")]
    Noise {
        /// Which one.
        field: &'static str,
        /// Its value, rad or m.
        value: f64,
    },
}

/// Fits one line to `beams`.
///
/// # Units    `bearing_sigma`: rad. `surface_sigma`: how far from flat a wall may be, m; it enters the χ² only.
/// # Errors   [`FitError`]: fewer than 2 beams, no direction that stands out, beams along the line, numbers that are not finite.
/// # Source   TDK 2016 §4.1; Arras & Siegwart (1997). The noise's own scatter is removed, see the module.
/// # Example
/// ```
/// use nalgebra::{Point2, Vector2};
/// use slamlab_core::features::fit_line;
/// use slamlab_core::points::Beam;
/// let on_x_2 = |y: f64| Beam {
///     beam_idx: 0,
///     origin_in_robot: Point2::origin(),
///     end_in_robot: Point2::new(2.0, y),
///     range: Vector2::new(2.0, y).norm(),
///     sigma: 0.01,
///     is_hit: true,
/// };
/// let wall = fit_line(&[on_x_2(-1.0), on_x_2(0.0), on_x_2(1.0)], 0.0, 0.0).unwrap();
/// assert!(wall.line.alpha().abs() < 1e-9 && (wall.line.r() - 2.0).abs() < 1e-9);
/// ```
pub fn fit_line(
    beams: &[Beam],
    bearing_sigma: f64,
    surface_sigma: f64,
) -> Result<LineFeature, FitError> {
    for (field, value) in [
        ("bearing_sigma", bearing_sigma),
        ("surface_sigma", surface_sigma),
    ] {
        if !(value >= 0.0 && value.is_finite()) {
            return Err(FitError::Noise { field, value });
        }
    }
    if let Some(beam) = beams.iter().find(|beam| !is_usable(beam)) {
        return Err(FitError::Value {
            beam_idx: beam.beam_idx,
            x: beam.end_in_robot.x,
            y: beam.end_in_robot.y,
            range: beam.range,
            sigma: beam.sigma,
        });
    }
    let mut columns = Columns::default();
    let noise = Noise {
        bearing_sigma,
        surface_sigma,
    };
    columns.reset(beams.len(), noise);
    columns.extend(beams);
    let all = Piece::whole(&columns, 0..columns.len());
    let origin = beams
        .first()
        .map_or_else(Point2::origin, |b| b.origin_in_robot);
    Ok(fit_columns(&columns, &all)?.feature(&columns, origin))
}

/// Whether the sums can take a beam.
#[inline]
pub(super) fn is_usable(beam: &Beam) -> bool {
    // A difference of a number with itself is 0, or NaN where the number is not finite.
    let difference = beam.end_in_robot - beam.end_in_robot;
    let at = beam.origin_in_robot - beam.origin_in_robot;
    let (range, sigma) = (beam.range - beam.range, beam.sigma - beam.sigma);
    (difference.x + difference.y + at.x + at.y + range + sigma).abs() <= 0.0
        && beam.range > 0.0
        && beam.sigma > 0.0
}

/// A line through the kept points of a range.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    pub(super) line: Line,
    pub(super) cov: Matrix2<f64>,
    /// Unit normal; the line is `normal · p = r` with r ≥ 0.
    pub(super) normal: Vector2<f64>,
    /// Feet of the first and the last point.
    pub(super) ends: [Point2<f64>; 2],
    pub(super) n_points: usize,
    pub(super) chi2: f64,
    /// The quadratic term of the residuals along the line, in standard deviations.
    pub(super) bend: f64,
    by_heading: [Vector2<f64>; 2],
    first: usize,
    last: usize,
}

impl Fit {
    /// With where the sensor was at the first beam.
    pub(super) fn feature(&self, columns: &Columns, origin: Point2<f64>) -> LineFeature {
        LineFeature {
            line: self.line,
            cov: self.cov,
            ends: self.ends,
            seen_from_origin_side: self.normal.dot(&origin.coords) <= self.line.r(),
            first_beam: columns.number(self.first),
            last_beam: columns.number(self.last),
            n_points: self.n_points,
            chi2: self.chi2,
            by_heading: self.by_heading,
        }
    }

    /// Index of the first point.
    pub(super) fn first(&self) -> usize {
        self.first
    }
}

/// Fits one line to the points of a piece that were not left out.
pub(super) fn fit_columns(columns: &Columns, piece: &Piece) -> Result<Fit, FitError> {
    let (Some(first), Some(last)) = (piece.first(columns), piece.last(columns)) else {
        return Err(FitError::TooFew { n_points: 0 });
    };
    let scatter = Scatter::of(columns, piece);
    let n_points = scatter.n_points;
    if n_points < 2 {
        return Err(FitError::TooFew { n_points });
    }
    let frame = scatter.frame()?;
    let faded = Faded::between(columns.number(first), columns.number(last));
    let along = Along::between(&frame, columns.point(first), columns.point(last));
    let sums = Sums::of(columns, piece.range(), &frame, &faded, &along);
    let foot = |index: usize| {
        let p = columns.point(index);
        p - frame.normal * (frame.normal.dot(&p.coords) - frame.line.r())
    };
    Ok(Fit {
        line: frame.line,
        cov: sums.covariance(&scatter, &frame)?,
        normal: frame.normal,
        ends: [foot(first), foot(last)],
        n_points,
        chi2: sums.chi2,
        bend: sums.bend.sigmas(),
        by_heading: sums.by_heading(&scatter, &frame),
        first,
        last,
    })
}

/// Steps 1 and 2: weights, mean and the scatter of the wall alone.
struct Scatter {
    n_points: usize,
    w: f64,
    mean: Vector2<f64>,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Scatter {
    fn of(columns: &Columns, piece: &Piece) -> Self {
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

    fn frame(&self) -> Result<Frame, FitError> {
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
struct Frame {
    line: Line,
    normal: Vector2<f64>,
    tangent: Vector2<f64>,
    /// Ctt - Cnn.
    spread: f64,
    mean_t: f64,
}

/// How an error of the heading at the first beam, or at the last, fades to none at the middle one.
struct Faded {
    middle: f64,
    per_half: f64,
}

impl Faded {
    fn between(first: usize, last: usize) -> Self {
        let middle = 0.5 * (first + last) as f64;
        Self {
            middle,
            per_half: 1.0 / (last as f64 - middle).abs().max(0.5),
        }
    }
}

/// Where a point lies along the line, as -1 at the first point and 1 at the last.
struct Along {
    middle: f64,
    per_half: f64,
}

impl Along {
    fn between(frame: &Frame, first: Point2<f64>, last: Point2<f64>) -> Self {
        let [first, last] = [first, last].map(|p| frame.tangent.dot(&p.coords) - frame.mean_t);
        Self {
            middle: 0.5 * (first + last),
            per_half: 2.0 / (last - first).abs().max(f64::MIN_POSITIVE),
        }
    }
}

/// Step 4: the sums over the points in the frame of the line.
struct Sums {
    a: f64,
    b: f64,
    c: f64,
    chi2: f64,
    bend: Bend,
    /// What a turn does to α and to n, before and after the middle.
    turn_alpha: [f64; 2],
    turn_n: [f64; 2],
}

impl Sums {
    fn of(
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
    fn covariance(&self, scatter: &Scatter, frame: &Frame) -> Result<Matrix2<f64>, FitError> {
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
    fn by_heading(&self, scatter: &Scatter, frame: &Frame) -> [Vector2<f64>; 2] {
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
struct Bend {
    /// Σ g sᵏ for k = 0 to 4.
    powers: [f64; 5],
    /// Σ g n sᵏ for k = 0 to 2.
    products: [f64; 3],
}

impl Bend {
    /// Σ g q n / √(Σ g q²).
    fn sigmas(&self) -> f64 {
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

#[cfg(test)]
mod tests;
