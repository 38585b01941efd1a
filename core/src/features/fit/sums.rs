//! The sums behind a fitted line: steps 1, 2 and 4 of [`super`].
//!
//! `scatter` and `line_sums` are the plain forms, point by point as the equations stand; the tests
//! compare the others with them. [`ScatterSums`] and [`LineSums`] are what runs: four points at a
//! time, added up lane by lane. The changed order of additions alters the last digits, and the
//! terms of the bearings are skipped if bearings are exact.

use std::ops::Range;

use nalgebra::{Matrix2, Vector2};

use crate::features::columns::Columns;
#[cfg(test)]
use crate::features::columns::Sample;
use crate::features::moments::normal_of_scatter;
use crate::features::piece::Piece;
use crate::geom::Line;
use crate::lanes::{Kernel, Lanes, run, total};

/// Step 2: Σ wᵢ dᵢ dᵢᵀ - Σ wᵢ (1 - wᵢ/W) Rᵢ, with d from the weighted mean, and R the covariance of
/// a point's position.
#[cfg(test)]
fn scatter(points: &[Sample]) -> Matrix2<f64> {
    let total: f64 = points.iter().map(|p| p.weight).sum();
    let mean = points
        .iter()
        .map(|p| p.end * p.weight)
        .sum::<Vector2<f64>>()
        / total;
    let square = |v: Vector2<f64>| v * v.transpose();
    let of_point = |p: &Sample| {
        let noise = square(p.along) * p.var_along + square(p.across()) * p.var_across;
        square(p.end - mean) * p.weight - noise * p.weight * (1.0 - p.weight / total)
    };
    points.iter().map(of_point).sum()
}

/// Step 4: A, B and C, and the effect of a turn of the robot on α and on n.
#[cfg(test)]
fn line_sums(points: &[Sample], frame: &Frame, faded: &Faded) -> Sums {
    use crate::features::columns::square;

    let (mut sums, zero) = (Sums::default(), 0.0_f64);
    for p in points {
        // From the robot, and from the middle of the wall.
        let (robot_n, robot_t) = (frame.normal.dot(&p.end), frame.tangent.dot(&p.end));
        let (n, t) = (robot_n - frame.line.r(), robot_t - frame.mean_t);
        let (un, ut) = (frame.normal.dot(&p.along), frame.tangent.dot(&p.along));
        let (by_range, by_bearing) = (t * un + n * ut, n * un - t * ut);
        let w_bearing = p.weight * p.weight * p.var_across;
        sums.a += p.weight * square(by_range) + w_bearing * square(by_bearing);
        sums.b += p.weight * by_range * un - w_bearing * by_bearing * ut;
        sums.c += p.weight * square(un) + w_bearing * square(ut);
        // A turn moves the point by -t across the line and by n along it; it fades towards the
        // middle beam.
        let from_middle = (p.number - faded.middle) * faded.per_half;
        let shares = [
            zero.max(-from_middle).min(1.0),
            zero.max(from_middle).min(1.0),
        ];
        for (side, share) in shares.into_iter().enumerate() {
            sums.turn_alpha[side] += share * p.weight * (n * robot_n - t * robot_t);
            sums.turn_n[side] -= share * p.weight * robot_t;
        }
    }
    sums
}

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
        let [count, xx, xy, yy] = run(ScatterSums {
            columns,
            range: &piece.range(),
            mean: &mean,
            per_total: 1.0 / w,
        });
        Self {
            n_points: count as usize,
            w,
            mean,
            xx,
            xy,
            yy,
        }
    }

    /// `None` if no direction stands out.
    pub(super) fn frame(&self) -> Option<Frame> {
        let (double, cross) = (self.yy - self.xx, -2.0 * self.xy);
        // The greater eigenvalue of the scatter: the line runs along it.
        let spread = (double * double + cross * cross).sqrt();
        let both = self.xx + self.yy;
        let along = 0.5 * (both + spread);
        // A spread along the line of a few standard deviations of one point is no direction. Nor is
        // one that only stands out because subtracting the noise has left a negative spread across
        // it.
        if !(along > 4.0 && spread > 4.0 && spread.is_finite()) {
            return None;
        }
        let normal = normal_of_scatter(self.xx, self.xy, self.yy);
        let r = normal.dot(&self.mean);
        let sign = if r < 0.0 { -1.0 } else { 1.0 };
        let (normal, tangent) = (normal * sign, Vector2::new(-normal.y, normal.x) * sign);
        Some(Frame {
            line: Line::new(0.5 * libm::atan2(cross, double), r),
            normal,
            tangent,
            spread,
            mean_t: tangent.dot(&self.mean),
        })
    }
}

/// The sums behind [`Scatter`].
struct ScatterSums<'a> {
    columns: &'a Columns,
    range: &'a Range<usize>,
    mean: &'a Vector2<f64>,
    /// One over the sum of the weights.
    per_total: f64,
}

impl Kernel for ScatterSums<'_> {
    /// Number of points, then the scatter xx, xy, yy.
    type Output = [f64; 4];

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) -> [f64; 4] {
        let splat = |value| L::splat(machine, value);
        let (mx, my) = (splat(self.mean.x), splat(self.mean.y));
        let per_total = splat(self.per_total);
        let exact = self.columns.bearings_are_exact();
        let zero = splat(0.0);
        let (mut count, mut xx, mut xy, mut yy) = (zero, zero, zero, zero);
        let blocks = self.columns.blocks(self.range);
        for block in 0..blocks.len() {
            let b = blocks.at(machine, block);
            let (dx, dy) = (b.x - mx, b.y - my);
            let weight = b.weight * b.keep;
            let (wx, wy) = (weight * dx, weight * dy);
            // The noise's contribution: `along` the beam, where w σ² = 1, and `across` it.
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
        [total(count), total(xx), total(xy), total(yy)]
    }
}

/// The frame of the line: n across it, t along it from the mean.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) line: Line,
    pub(super) normal: Vector2<f64>,
    pub(super) tangent: Vector2<f64>,
    /// Ctt - Cnn.
    spread: f64,
    pub(super) mean_t: f64,
}

/// How an error of the heading at the first beam, or at the last, fades to zero at the middle one.
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

/// Step 4: the sums over the points in the frame of the line.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    a: f64,
    b: f64,
    c: f64,
    /// The effect of a turn on α and on n, before and after the middle.
    turn_alpha: [f64; 2],
    turn_n: [f64; 2],
}

impl Sums {
    pub(super) fn of(columns: &Columns, range: Range<usize>, frame: &Frame, faded: &Faded) -> Self {
        run(LineSums {
            columns,
            range: &range,
            frame,
            faded,
        })
    }

    /// Covariance of (α, r); `None` if the beams do not measure the distance.
    pub(super) fn covariance(&self, scatter: &Scatter, frame: &Frame) -> Option<Matrix2<f64>> {
        let (spread, w, mean_t) = (frame.spread, scatter.w, frame.mean_t);
        let aa = self.a / (spread * spread);
        let a_n = -self.b / (spread * w);
        let nn = self.c / (w * w);
        let ar = a_n + mean_t * aa;
        let rr = nn + 2.0 * mean_t * a_n + mean_t * mean_t * aa;
        // 3e-5 rad: at 30 m the line is a millimetre wide.
        let is_seen = self.c / w > 1e-9 && aa > 0.0 && aa * nn - a_n * a_n > 1e-12 * aa * nn;
        (is_seen && rr.is_finite() && aa * rr - ar * ar > 0.0).then(|| Matrix2::new(aa, ar, ar, rr))
    }

    /// Change of (α, r) if the heading was off by 1 rad at the first beam, and at the last.
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

/// The sums behind [`Sums`].
struct LineSums<'a> {
    columns: &'a Columns,
    range: &'a Range<usize>,
    frame: &'a Frame,
    faded: &'a Faded,
}

impl Kernel for LineSums<'_> {
    type Output = Sums;

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) -> Sums {
        let splat = |value| L::splat(machine, value);
        let (normal, tangent) = (self.frame.normal, self.frame.tangent);
        let (nx, ny, tx, ty) = (
            splat(normal.x),
            splat(normal.y),
            splat(tangent.x),
            splat(tangent.y),
        );
        let (r, mean_t) = (splat(self.frame.line.r()), splat(self.frame.mean_t));
        let (middle, per_half) = (splat(self.faded.middle), splat(self.faded.per_half));
        let (zero, one) = (splat(0.0), splat(1.0));
        let (mut a, mut b, mut c) = (zero, zero, zero);
        let (mut before_alpha, mut after_alpha) = (zero, zero);
        let (mut before_n, mut after_n) = (zero, zero);
        let exact = self.columns.bearings_are_exact();
        let blocks = self.columns.blocks(self.range);
        for block in 0..blocks.len() {
            let p = blocks.at(machine, block);
            let weight = p.weight * p.keep;
            // Relative to the robot, and relative to the line.
            let (robot_n, robot_t) = (nx * p.x + ny * p.y, tx * p.x + ty * p.y);
            let (n, t) = (robot_n - r, robot_t - mean_t);
            let (un, ut) = (nx * p.ux + ny * p.uy, tx * p.ux + ty * p.uy);
            let by_range = t * un + n * ut;
            let w_range = weight * by_range;
            a += w_range * by_range;
            b += w_range * un;
            c += weight * un * un;
            if !exact {
                let by_bearing = n * un - t * ut;
                let w_bearing = weight * p.weight * p.var_across;
                a += w_bearing * by_bearing * by_bearing;
                b -= w_bearing * by_bearing * ut;
                c += w_bearing * ut * ut;
            }
            // A turn about the robot moves the point by its distance, perpendicular to it: by -t
            // across the line and n along it.
            let w_alpha = weight * (n * robot_n - t * robot_t);
            let w_n = weight * robot_t;
            let from_middle = (p.number - middle) * per_half;
            let before = (zero - from_middle).or_greater(zero).or_lesser(one);
            let after = from_middle.or_greater(zero).or_lesser(one);
            before_alpha += w_alpha * before;
            after_alpha += w_alpha * after;
            before_n -= w_n * before;
            after_n -= w_n * after;
        }
        Sums {
            a: total(a),
            b: total(b),
            c: total(c),
            turn_alpha: [total(before_alpha), total(after_alpha)],
            turn_n: [total(before_n), total(after_n)],
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
    use crate::geom::Length;

    proptest! {
        #[test]
        fn sums_by_fours_are_those_of_the_plain_form(
            (beams, skipped) in wall_in_noise(),
            bearing_sigma in prop_oneof![Just(0.0), 1e-4..0.01_f64],
        ) {
            let mut columns = Columns::default();
            let noise = Noise { bearing_sigma, surface_sigma: 0.0 };
            columns.load(&beams, std::iter::once(0..beams.len()), noise);
            let mut piece = Piece::whole(&columns, 0..beams.len());
            skipped.iter().for_each(|&index| piece.drop_point(&mut columns, index));
            let kept: Vec<Sample> = columns.kept(piece.range())
                .map(|index| Sample::of(&beams[index], bearing_sigma))
                .collect();
            let found = Scatter::of(&columns, &piece);
            prop_assert_eq!(found.n_points, kept.len());
            let plain = scatter(&kept);
            let found_scatter = Matrix2::new(found.xx, found.xy, found.xy, found.yy);
            prop_assert!((found_scatter - plain).length() <= 1e-9 * plain.length(), "{found_scatter} {plain}");
            let Some(fit) = fit_columns(&columns, &piece) else {
                return Ok(());
            };
            let faded = Faded::between(columns.number(fit.first), columns.number(fit.last));
            let found = Sums::of(&columns, fit.first..fit.last + 1, &fit.frame, &faded);
            let plain = line_sums(&kept, &fit.frame, &faded);
            // A sum of terms of both signs is as exact as the largest of them.
            let scale = plain.a.abs().max(plain.c.abs()) * 1e-9;
            for (found, plain) in [(found.a, plain.a), (found.b, plain.b), (found.c, plain.c)] {
                prop_assert!((found - plain).abs() <= scale, "{found} {plain}");
            }
            let turns = |sums: &Sums| [sums.turn_alpha, sums.turn_n].concat();
            let (found, plain) = (turns(&found), turns(&plain));
            let scale = plain.iter().fold(0.0_f64, |most, v| most.max(v.abs())) * 1e-9;
            for (found, plain) in found.iter().zip(&plain) {
                prop_assert!((found - plain).abs() <= scale, "{found} {plain}");
            }
        }
    }
}
