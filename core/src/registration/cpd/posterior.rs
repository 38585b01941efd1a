//! The E step: sums of (1.45) over fixed and moving points.
//!
//! p_mn = k_mn / (Σ_m k_mn + c) with k_mn = exp(-|x_n - y_m|² / 2σ²) and
//! c = 2πσ² w/(1-w) M/N. What the M step needs of it: P1, P X and Pᵀ1.
//!
//! Few points, and near ones, are taken pair by pair, in single precision: each exponential serves
//! the denominator and then the sums. Which are near is kept while points move by next to nothing,
//! as they do in most iterations. Many points that all hear each other go through the Gauss
//! transform twice, (1.54) and (1.55).

use std::f64::consts::{LOG2_E, PI};
use std::ops::Range;

use nalgebra::{Point2, Vector2};
use pulp::NullaryFnOnce;

use super::super::gauss_transform::{Cells, Plan, TransformMethod, exp2_of_minus, gauss_transform};
use super::CpdConfig;
use crate::lanes::widened;

/// Moving points worked on side by side.
const SIDE_BY_SIDE: usize = 8;
/// Points are taken for near as if σ were so many times as wide: they may move a little, and stay
/// so.
const SPARE: f64 = 1.02;
/// Points that were looked for in a radius more than so many times as wide as it takes are looked
/// for anew.
const MOST_SPARE: f64 = 1.1;

/// Numbers of moving points side by side.
type Group = [f32; SIDE_BY_SIDE];

/// Which moving points are near which fixed ones.
pub(super) struct Near {
    /// Where the moving points were.
    places: Vec<Point2<f64>>,
    /// They in the order of their cells.
    order: Vec<u32>,
    /// Groups of them, and of each fixed point where its own end in that list.
    runs: Vec<Range<usize>>,
    ends: Vec<usize>,
    radius: f64,
    /// The σ whose points are all within the radius.
    sigma: f64,
}

impl Near {
    fn of(cells: Cells, y: &[Point2<f64>], x: &[Point2<f64>], sigma: f64) -> Self {
        let mut near = Self {
            places: y.to_vec(),
            runs: vec![],
            ends: Vec::with_capacity(x.len()),
            radius: cells.radius,
            sigma,
            order: vec![],
        };
        for fixed in x {
            let first = near.runs.len();
            for run in cells.near(fixed).filter(|run| !run.is_empty()) {
                let start = run.start / SIDE_BY_SIDE;
                let end = run.end.div_ceil(SIDE_BY_SIDE);
                // Neighbours that share a group are joined.
                match near.runs.get_mut(first..).and_then(<[_]>::last_mut) {
                    Some(last) if start <= last.end => last.end = last.end.max(end),
                    _ => near.runs.push(start..end),
                }
            }
            near.ends.push(near.runs.len());
        }
        near.order = cells.order;
        near
    }

    /// Whether all that is near is still among them, and not much else.
    pub(super) fn holds(&self, y: &[Point2<f64>], sigma: f64) -> bool {
        let reach = self.radius * sigma / self.sigma;
        let spare = self.radius - reach;
        let is_still =
            |(place, y): (&Point2<f64>, &Point2<f64>)| (y - place).norm_squared() <= spare * spare;
        self.radius <= MOST_SPARE * reach && spare >= 0.0 && self.places.iter().zip(y).all(is_still)
    }
}

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
        near: &mut Option<Near>,
    ) -> Self {
        let w = config.outliers.clamp(0.0, 0.999);
        let by_outliers = 2.0 * PI * variance * w / (1.0 - w) * y.len() as f64 / x.len() as f64;
        let (sigma, scale) = (variance.sqrt(), 0.5 / variance);
        let (of_moving, of_fixed) = match near {
            Some(near) if near.holds(y, sigma) => by_pairs(y, x, Some(near), scale, by_outliers),
            _ => {
                *near = None;
                let wider = SPARE * sigma;
                match Plan::of(y, x, wider, config.error) {
                    Plan::Chebyshev(_) => by_transform(y, x, sigma, by_outliers, config.error),
                    Plan::Direct => by_pairs(y, x, None, scale, by_outliers),
                    Plan::Grid(cells) => {
                        let near = near.insert(Near::of(cells, y, x, wider));
                        by_pairs(y, x, Some(near), scale, by_outliers)
                    }
                }
            }
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
    near: Option<&Near>,
    scale: f64,
    by_outliers: f64,
) -> (Vec<Owed>, Vec<f64>) {
    let all: Vec<u32>;
    let order = match near {
        Some(near) => &near.order,
        None => {
            all = (0..y.len() as u32).collect();
            &all
        }
    };
    let sorted = order.iter().filter_map(|index| y.get(*index as usize));
    // Whole groups, the last ones of points that are too far to be owed anything.
    let groups = y.len().div_ceil(SIDE_BY_SIDE);
    let (mut xs, mut ys) = (
        vec![[FAR; SIDE_BY_SIDE]; groups],
        vec![[FAR; SIDE_BY_SIDE]; groups],
    );
    let places = xs.as_flattened_mut().iter_mut().zip(ys.as_flattened_mut());
    // exp(-d² scale) = 2^-(d root)².
    let root = (scale * LOG2_E).sqrt();
    for ((x, y), point) in places.zip(sorted) {
        (*x, *y) = ((root * point.x) as f32, (root * point.y) as f32);
    }
    let (sums, of_fixed) = widened(Pairs {
        x: &xs,
        y: &ys,
        fixed: x,
        near,
        root,
        by_outliers: by_outliers as f32,
    });
    let mut of_moving = vec![Owed::default(); y.len()];
    let [parts, px, py] = sums.each_ref().map(|column| column.as_flattened());
    let sums = parts.iter().zip(px.iter().zip(py));
    for (index, (part, (x, y))) in order.iter().zip(sums) {
        if let Some(owed) = of_moving.get_mut(*index as usize) {
            *owed = Owed {
                part: f64::from(*part),
                place: Vector2::new(f64::from(*x), f64::from(*y)),
            };
        }
    }
    (of_moving, of_fixed)
}

/// Where nothing is: its exponential is as good as none.
const FAR: f32 = 1e15;

/// All pairs, or those that are near.
struct Pairs<'a> {
    /// Places of the moving points, times `root`.
    x: &'a [Group],
    y: &'a [Group],
    fixed: &'a [Point2<f64>],
    near: Option<&'a Near>,
    root: f64,
    by_outliers: f32,
}

impl NullaryFnOnce for Pairs<'_> {
    type Output = ([Vec<Group>; 3], Vec<f64>);

    #[inline(always)]
    fn call(self) -> Self::Output {
        let groups = self.x.len();
        let nothing = || vec![[0.0; SIDE_BY_SIDE]; groups];
        let (mut sums, mut values) = ([nothing(), nothing(), nothing()], nothing());
        let mut of_fixed = Vec::with_capacity(self.fixed.len());
        let all = 0..groups;
        let mut begin = 0;
        for (index, fixed) in self.fixed.iter().enumerate() {
            let runs = match self.near {
                None => std::slice::from_ref(&all),
                Some(near) => {
                    let end = near.ends.get(index).copied().unwrap_or(begin);
                    let runs = near.runs.get(begin..end);
                    begin = end;
                    runs.unwrap_or_default()
                }
            };
            let (fx, fy) = ((self.root * fixed.x) as f32, (self.root * fixed.y) as f32);
            let mut lanes = [0.0_f32; SIDE_BY_SIDE];
            for run in runs {
                let (Some(x), Some(y), Some(values)) = (
                    self.x.get(run.clone()),
                    self.y.get(run.clone()),
                    values.get_mut(run.clone()),
                ) else {
                    continue;
                };
                for ((x, y), values) in x.iter().zip(y).zip(values) {
                    *values = group(x, y, fx, fy);
                    for at in 0..SIDE_BY_SIDE {
                        lanes[at] += values[at];
                    }
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
            let (by_x, by_y) = (share * fixed.x as f32, share * fixed.y as f32);
            let [parts, px, py] = &mut sums;
            for run in runs {
                let (Some(values), Some(parts), Some(px), Some(py)) = (
                    values.get(run.clone()),
                    parts.get_mut(run.clone()),
                    px.get_mut(run.clone()),
                    py.get_mut(run.clone()),
                ) else {
                    continue;
                };
                for (((values, part), x), y) in values.iter().zip(parts).zip(px).zip(py) {
                    for at in 0..SIDE_BY_SIDE {
                        part[at] += values[at] * share;
                        x[at] += values[at] * by_x;
                        y[at] += values[at] * by_y;
                    }
                }
            }
        }
        (sums, of_fixed)
    }
}

/// k_mn of moving points and a fixed one, all places times the root of the scale.
#[inline(always)]
fn group(x: &Group, y: &Group, fx: f32, fy: f32) -> Group {
    let mut squares = [0.0; SIDE_BY_SIDE];
    for at in 0..SIDE_BY_SIDE {
        let (dx, dy) = (x[at] - fx, y[at] - fy);
        squares[at] = dx * dx + dy * dy;
    }
    exp2_of_minus(&squares)
}
