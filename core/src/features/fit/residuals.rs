//! In: the points of a line and its frame. Out: how far they lie from it, relative to their known
//! noise.
//!
//! 1. χ² = Σ d²/σ_d².
//! 2. The bend: the part of s² that no line explains, s the place along the line, as a share of the
//!    residuals.
//!
//! `residuals` is the plain form, and the tests compare [`ResidualSums`] with it: four points at a
//! time, with the bend computed from sums of powers of s alone, so one pass over the points is
//! enough. It loses digits, because the sums of s⁴ cancel.

use std::ops::Range;

use nalgebra::Point2;

use super::sums::Frame;
use crate::features::columns::Columns;
#[cfg(test)]
use crate::features::columns::Sample;
use crate::lanes::{Kernel, Lanes, run, total};

/// χ² = Σ n²/σ_n², and |Σ g q n| / √(Σ g q²) with g = 1/σ_n² and q the residual of s² by least
/// squares.
#[cfg(test)]
fn residuals(points: &[Sample], var_surface: f64, frame: &Frame, along: &Along) -> Residuals {
    use nalgebra::{Matrix2, Vector2};

    use crate::features::columns::square;

    let rows = points.iter().map(|p| {
        let (n, t) = (frame.normal.dot(&p.end), frame.tangent.dot(&p.end));
        let s = (t - frame.mean_t - along.middle) * along.per_half;
        let g = 1.0 / (p.variance(&frame.normal) + var_surface);
        (g, n - frame.line.r(), s)
    });
    let rows: Vec<_> = rows.collect();
    // The line a + b s nearest to s².
    let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
    for (g, _, s) in &rows {
        let row = Vector2::new(1.0, *s);
        normal += row * row.transpose() * *g;
        right += row * square(*s) * *g;
    }
    let line = normal.try_inverse().unwrap_or_default() * right;
    let q = |s: f64| square(s) - line.x - line.y * s;
    let sum = |of: &dyn Fn(f64, f64, f64) -> f64| rows.iter().map(|&(g, n, s)| of(g, n, s)).sum();
    let (product, norm): (f64, f64) = (
        sum(&|g, n, s| g * q(s) * n),
        sum(&|g, _, s| g * square(q(s))),
    );
    Residuals {
        chi2: sum(&|g, n, _| g * square(n)),
        bend: product.abs() / norm.sqrt(),
    }
}

/// The points' distances from a line.
pub(in super::super) struct Residuals {
    pub(in super::super) chi2: f64,
    /// The quadratic term along the line, in standard deviations; 0 if it was not asked for.
    pub(in super::super) bend: f64,
}

impl Residuals {
    /// `range`: from the first point of the line to one past the last.
    pub(super) fn of(
        columns: &Columns,
        range: Range<usize>,
        frame: &Frame,
        with_bend: bool,
    ) -> Self {
        let [first, last] = [range.start, range.end.max(1) - 1].map(|index| columns.point(index));
        let (chi2, bend) = run(ResidualSums {
            columns,
            range: &range,
            frame,
            along: &Along::between(frame, first, last),
            with_bend,
        });
        Self {
            chi2,
            bend: bend.sigmas(),
        }
    }
}

/// A point's place along the line: -1 at the first point, 1 at the last.
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

/// The sums behind [`Residuals`].
struct ResidualSums<'a> {
    columns: &'a Columns,
    range: &'a Range<usize>,
    frame: &'a Frame,
    along: &'a Along,
    with_bend: bool,
}

impl Kernel for ResidualSums<'_> {
    type Output = (f64, Bend);

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) -> (f64, Bend) {
        let splat = |value| L::splat(machine, value);
        let (normal, tangent) = (self.frame.normal, self.frame.tangent);
        let (nx, ny, tx, ty) = (
            splat(normal.x),
            splat(normal.y),
            splat(tangent.x),
            splat(tangent.y),
        );
        let r = splat(self.frame.line.r());
        let middle = splat(self.frame.mean_t + self.along.middle);
        let per_half = splat(self.along.per_half);
        // If nothing is uncertain, a distance is infinitely many sigmas, not NaN.
        let surface = splat(self.columns.var_surface() + f64::MIN_POSITIVE);
        let zero = splat(0.0);
        let mut chi2 = zero;
        let (mut g0, mut g1, mut g2, mut g3, mut g4) = (zero, zero, zero, zero, zero);
        let (mut n0, mut n1, mut n2) = (zero, zero, zero);
        let exact = self.columns.bearings_are_exact();
        let blocks = self.columns.blocks(self.range);
        for block in 0..blocks.len() {
            let p = blocks.at(machine, block);
            let mut variance = p.variance_by_range(nx, ny) + surface;
            if !exact {
                variance += p.variance_by_bearing(nx, ny);
            }
            let n = nx * p.x + ny * p.y - r;
            // The information of a point.
            let g = p.keep / variance;
            let gn = g * n;
            chi2 += gn * n;
            if self.with_bend {
                let s = (tx * p.x + ty * p.y - middle) * per_half;
                let (gs, gns) = (g * s, gn * s);
                let gss = gs * s;
                let gsss = gss * s;
                g0 += g;
                g1 += gs;
                g2 += gss;
                g3 += gsss;
                g4 += gsss * s;
                n0 += gn;
                n1 += gns;
                n2 += gns * s;
            }
        }
        let bend = Bend {
            powers: [total(g0), total(g1), total(g2), total(g3), total(g4)],
            products: [total(n0), total(n1), total(n2)],
        };
        (total(chi2), bend)
    }
}

/// How bent the points are: the part of s² that no line explains, q = s² - a - b s by least
/// squares, so that Σ g q = Σ g q s = 0, against the residuals.
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
mod tests {
    use proptest::prelude::*;

    use super::super::fit_columns;
    use super::*;
    use crate::features::columns::Noise;
    use crate::features::columns::tests::wall_in_noise;
    use crate::features::piece::Piece;

    proptest! {
        #[test]
        fn residuals_by_fours_are_those_of_the_plain_form(
            (beams, skipped) in wall_in_noise(),
            bearing_sigma in prop_oneof![Just(0.0), 1e-4..0.01_f64],
            surface_sigma in 0.0..0.01_f64,
        ) {
            let mut columns = Columns::default();
            let noise = Noise { bearing_sigma, surface_sigma };
            columns.load(&beams, std::iter::once(0..beams.len()), noise);
            let mut piece = Piece::whole(&columns, 0..beams.len());
            skipped.iter().for_each(|&index| piece.drop_point(&mut columns, index));
            let Some(fit) = fit_columns(&columns, &piece) else {
                return Ok(());
            };
            let kept: Vec<Sample> = columns.kept(piece.range())
                .map(|index| Sample::of(&beams[index], bearing_sigma))
                .collect();
            let [first, last] = [fit.first, fit.last].map(|index| columns.point(index));
            let along = Along::between(&fit.frame, first, last);
            let plain = residuals(&kept, surface_sigma * surface_sigma, &fit.frame, &along);
            let found = fit.residuals(&columns, true);
            prop_assert!((found.chi2 - plain.chi2).abs() <= 1e-9 * plain.chi2);
            prop_assert!((found.bend - plain.bend).abs() <= 1e-6 * (1.0 + plain.bend), "{} {}", found.bend, plain.bend);
        }
    }
}
