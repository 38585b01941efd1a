//! The E step: sums of (1.45) over fixed and moving points.
//!
//! p_mn = k_mn / (Σ_m k_mn + c) with k_mn = exp(-|x_n - y_m|² / 2σ²) and
//! c = 2πσ² w/(1-w) M/N. What the M step needs of it: P1, P X and Pᵀ1.
//!
//! Few points, and near ones, are taken pair by pair, in single precision: each exponential serves
//! the denominator and then the sums. Many points that all hear each other go through the Gauss
//! transform twice, (1.54) and (1.55).

use std::f64::consts::PI;
use std::ops::Range;

use nalgebra::{Point2, Vector2};
use pulp::NullaryFnOnce;

use super::super::gauss_transform::{Cells, Plan, TransformMethod, exp_f32, gauss_transform};
use super::CpdConfig;
use crate::lanes::widened;

/// Moving points worked on side by side.
const SIDE_BY_SIDE: usize = 16;

/// What a moving point is owed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Owed {
    /// A row of P1.
    pub(super) part: f64,
    /// A row of P X.
    pub(super) place: Vector2<f64>,
}

/// The sums of one E step.
#[derive(Clone, Debug)]
pub(super) struct Posterior {
    pub(super) of_moving: Vec<Owed>,
    /// Pᵀ1.
    pub(super) of_fixed: Vec<f64>,
    /// N_P.
    pub(super) total: f64,
}

impl Posterior {
    pub(super) fn of(
        y: &[Point2<f64>],
        x: &[Point2<f64>],
        variance: f64,
        config: &CpdConfig,
    ) -> Self {
        let w = config.outliers.clamp(0.0, 0.999);
        let by_outliers = 2.0 * PI * variance * w / (1.0 - w) * y.len() as f64 / x.len() as f64;
        let (sigma, scale) = (variance.sqrt(), 0.5 / variance);
        let (of_moving, of_fixed) = match Plan::of(y, x, sigma, config.error) {
            Plan::Chebyshev(_) => by_transform(y, x, sigma, by_outliers, config.error),
            Plan::Direct => by_pairs(y, x, None, scale, by_outliers),
            Plan::Grid(cells) => by_pairs(y, x, Some(&cells), scale, by_outliers),
        };
        let total = of_fixed.iter().sum();
        Self {
            of_moving,
            of_fixed,
            total,
        }
    }
}

fn by_transform(
    y: &[Point2<f64>],
    x: &[Point2<f64>],
    sigma: f64,
    by_outliers: f64,
    error: f64,
) -> (Vec<Owed>, Vec<f64>) {
    let way = Some(TransformMethod::Chebyshev);
    let ones = vec![[1.0]; y.len()];
    let sums = gauss_transform(y, &ones, x, sigma, error, way);
    let shares = sums
        .iter()
        .map(|[sum]| sum.max(0.0) / (sum.max(0.0) + by_outliers));
    let of_fixed: Vec<f64> = shares
        .map(|share| if share.is_nan() { 0.0 } else { share })
        .collect();
    let weights: Vec<[f64; 3]> = (sums.iter().zip(x))
        .map(|([sum], x)| {
            let a = 1.0 / (sum.max(0.0) + by_outliers).max(1e-300);
            [a, a * x.x, a * x.y]
        })
        .collect();
    let owed = gauss_transform(x, &weights, y, sigma, error, way);
    let of_moving = owed.into_iter().map(|[part, x, y]| Owed {
        part,
        place: Vector2::new(x, y),
    });
    (of_moving.collect(), of_fixed)
}

fn by_pairs(
    y: &[Point2<f64>],
    x: &[Point2<f64>],
    cells: Option<&Cells>,
    scale: f64,
    by_outliers: f64,
) -> (Vec<Owed>, Vec<f64>) {
    let order: Vec<u32> = match cells {
        Some(cells) => cells.order.clone(),
        None => (0..y.len() as u32).collect(),
    };
    let sorted = order.iter().filter_map(|index| y.get(*index as usize));
    let (mut ys, mut xs) = (Vec::with_capacity(y.len()), Vec::with_capacity(y.len()));
    for point in sorted {
        xs.push(point.x as f32);
        ys.push(point.y as f32);
    }
    // Whole groups, the last ones of points that are too far to be owed anything.
    let whole = y.len().next_multiple_of(SIDE_BY_SIDE);
    xs.resize(whole, FAR);
    ys.resize(whole, FAR);
    let (sums, of_fixed) = widened(Pairs {
        x: &xs,
        y: &ys,
        fixed: x,
        cells,
        scale: scale as f32,
        by_outliers: by_outliers as f32,
    });
    let mut of_moving = vec![Owed::default(); y.len()];
    for (at, index) in order.iter().enumerate() {
        let sum = |column: &Vec<f32>| f64::from(column.get(at).copied().unwrap_or(0.0));
        if let Some(owed) = of_moving.get_mut(*index as usize) {
            let [part, x, y] = &sums;
            *owed = Owed {
                part: sum(part),
                place: Vector2::new(sum(x), sum(y)),
            };
        }
    }
    (of_moving, of_fixed)
}

/// Where nothing is: its exponential is as good as none.
const FAR: f32 = 1e15;

struct Pairs<'a> {
    x: &'a [f32],
    y: &'a [f32],
    fixed: &'a [Point2<f64>],
    cells: Option<&'a Cells>,
    scale: f32,
    by_outliers: f32,
}

impl NullaryFnOnce for Pairs<'_> {
    type Output = ([Vec<f32>; 3], Vec<f64>);

    #[inline(always)]
    fn call(self) -> Self::Output {
        let count = self.x.len();
        let mut sums = [const { vec![] }; 3];
        for column in &mut sums {
            column.resize(count, 0.0_f32);
        }
        let mut values = vec![0.0_f32; count];
        let mut of_fixed = Vec::with_capacity(self.fixed.len());
        let all = 0..count;
        let mut runs: Vec<Range<usize>> = Vec::from([all]);
        for fixed in self.fixed {
            if let Some(cells) = self.cells {
                runs.clear();
                for run in cells.near(fixed) {
                    // Whole groups; neighbours that overlap are joined.
                    let start = run.start / SIDE_BY_SIDE * SIDE_BY_SIDE;
                    let end = run.end.next_multiple_of(SIDE_BY_SIDE).min(count);
                    match runs.last_mut() {
                        _ if run.is_empty() => {}
                        Some(last) if start <= last.end => last.end = last.end.max(end),
                        _ => runs.push(start..end),
                    }
                }
            }
            let (fx, fy) = (fixed.x as f32, fixed.y as f32);
            let mut lanes = [0.0_f32; SIDE_BY_SIDE];
            for run in &runs {
                let (Some(x), Some(y), Some(values)) = (
                    self.x.get(run.clone()),
                    self.y.get(run.clone()),
                    values.get_mut(run.clone()),
                ) else {
                    continue;
                };
                let (xs, ys) = (x.as_chunks().0, y.as_chunks().0);
                let values = values.as_chunks_mut().0;
                for ((x, y), values) in xs.iter().zip(ys).zip(values) {
                    group(x, y, fx, fy, self.scale, values, &mut lanes);
                }
            }
            let mut sum = 0.0;
            for lane in lanes {
                sum += lane;
            }
            let all = sum + self.by_outliers;
            let share = if all > 0.0 { 1.0 / all } else { 0.0 };
            of_fixed.push(f64::from(sum * share));
            if share <= 0.0 {
                continue;
            }
            let (by_x, by_y) = (share * fx, share * fy);
            let [parts, px, py] = &mut sums;
            for run in &runs {
                let (Some(values), Some(parts), Some(px), Some(py)) = (
                    values.get(run.clone()),
                    parts.get_mut(run.clone()),
                    px.get_mut(run.clone()),
                    py.get_mut(run.clone()),
                ) else {
                    continue;
                };
                for (((value, part), x), y) in values.iter().zip(parts).zip(px).zip(py) {
                    *part += value * share;
                    *x += value * by_x;
                    *y += value * by_y;
                }
            }
        }
        (sums, of_fixed)
    }
}

#[inline(always)]
fn group(
    x: &[f32; SIDE_BY_SIDE],
    y: &[f32; SIDE_BY_SIDE],
    fx: f32,
    fy: f32,
    scale: f32,
    values: &mut [f32; SIDE_BY_SIDE],
    sums: &mut [f32; SIDE_BY_SIDE],
) {
    for at in 0..SIDE_BY_SIDE {
        let (dx, dy) = (x[at] - fx, y[at] - fy);
        values[at] = exp_f32(-scale * (dx * dx + dy * dy));
        sums[at] += values[at];
    }
}
