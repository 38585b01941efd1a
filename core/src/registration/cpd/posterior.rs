//! The E step: sums of (1.45) over fixed and moving points.
//!
//! p_mn = k_mn / (Σ_m k_mn + c) with k_mn = exp(-|x_n - y_m|² / 2σ²) and c = 2πσ² w/(1-w) M/N. The
//! M step needs only P1, P X and Pᵀ1 ([`Posterior`]). A linear motion needs less: for each fixed
//! point, Σ p, Σ p d and Σ p d dᵀ of d = y_m - x_n ([`Pull`]). Its sums stay in registers, because
//! the division by the denominator comes after they are complete.
//!
//! If points are few, or few are near each other, the sums are taken pair by pair, in single
//! precision. Which points are near is remembered while points hardly move, as in most iterations.
//! Many points that all affect each other go through the Gauss transform twice, (1.54) and (1.55).

use std::f64::consts::{LOG2_E, PI};
use std::ops::Range;

use nalgebra::{Matrix2, Point2, Vector2};

use super::super::gauss_transform::{
    Cells, Plan, SINGLE_COST, TransformMethod, exp2_of_minus, gauss_transform,
};
use super::CpdConfig;
use crate::lanes::{self, EIGHT, Eight, Kernel, Lanes, total_of_eight};

/// The neighbour search uses σ times this factor, so points may move a little and stay in the
/// lists.
const SPARE: f64 = 1.02;
/// If the radius of the last search is more than this factor larger than needed, neighbours are
/// searched again.
const MOST_SPARE: f64 = 1.1;

/// Coordinates of moving points, processed side by side.
type Group = [f32; EIGHT];

/// Which moving points are near each fixed point.
pub(super) struct Near {
    /// Where the moving points were.
    places: Vec<Point2<f64>>,
    /// Their indices in the order of their cells.
    order: Vec<u32>,
    /// Runs of groups of moving points, and for each fixed point the end of its own runs in that
    /// list.
    runs: Vec<Range<usize>>,
    ends: Vec<usize>,
    radius: f64,
    /// The largest σ for which all relevant points are within the radius.
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
                let start = run.start / EIGHT;
                let end = run.end.div_ceil(EIGHT);
                // Adjacent runs that share a group are merged.
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

    /// The runs of a fixed point; the previous point's runs ended at `begin`.
    #[inline(always)]
    fn of_fixed(&self, index: usize, begin: &mut usize) -> &[Range<usize>] {
        let end = self.ends.get(index).copied().unwrap_or(*begin);
        let runs = self.runs.get(*begin..end);
        *begin = end;
        runs.unwrap_or_default()
    }

    /// Whether the lists still contain all points that are near, and not many others.
    pub(super) fn holds(&self, y: &[Point2<f64>], sigma: f64) -> bool {
        let reach = self.radius * sigma / self.sigma;
        let spare = self.radius - reach;
        let is_still =
            |(place, y): (&Point2<f64>, &Point2<f64>)| (y - place).norm_squared() <= spare * spare;
        self.radius <= MOST_SPARE * reach && spare >= 0.0 && self.places.iter().zip(y).all(is_still)
    }
}

/// The sums for one moving point.
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

/// How the sums are computed.
enum Way<'a> {
    Transform,
    /// Over all pairs, or those that are near.
    Pairs(Option<&'a Near>),
}

impl<'a> Way<'a> {
    /// The way that takes the least work; `near` holds the lists from before, and is updated.
    fn of(
        y: &[Point2<f64>],
        x: &[Point2<f64>],
        sigma: f64,
        config: &CpdConfig,
        near: &'a mut Option<Near>,
    ) -> Self {
        if near.as_ref().is_some_and(|near| near.holds(y, sigma)) {
            return Self::Pairs(near.as_ref());
        }
        *near = None;
        let wider = SPARE * sigma;
        match Plan::of(y, x, wider, config.error, SINGLE_COST) {
            Plan::Chebyshev(_) => Self::Transform,
            Plan::Direct => Self::Pairs(None),
            Plan::Grid(cells) => Self::Pairs(Some(near.insert(Near::of(cells, y, x, wider)))),
        }
    }
}

/// c: the part of outliers in each denominator.
fn by_outliers(y: &[Point2<f64>], x: &[Point2<f64>], variance: f64, config: &CpdConfig) -> f64 {
    let w = config.outliers.clamp(0.0, 0.999);
    2.0 * PI * variance * w / (1.0 - w) * y.len() as f64 / x.len() as f64
}

impl Posterior {
    fn of_sums(of_moving: Vec<Owed>, of_fixed: Vec<f64>) -> Self {
        let total = of_fixed.iter().sum();
        Self {
            of_moving,
            of_fixed,
            total,
        }
    }

    pub(super) fn of(
        y: &[Point2<f64>],
        x: &[Point2<f64>],
        variance: f64,
        config: &CpdConfig,
        near: &mut Option<Near>,
    ) -> Self {
        let by_outliers = by_outliers(y, x, variance, config);
        let sigma = variance.sqrt();
        match Way::of(y, x, sigma, config, near) {
            Way::Transform => by_transform(y, x, sigma, by_outliers, config.error),
            Way::Pairs(near) => by_pairs(y, x, near, 0.5 / variance, by_outliers),
        }
    }
}

/// The moving points that a fixed point belongs to, relative to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pull {
    /// Σ p: a row of Pᵀ1.
    pub(super) part: f64,
    /// Σ p d.
    pub(super) off: Vector2<f64>,
    /// Σ p d dᵀ.
    pub(super) spread: Matrix2<f64>,
}

/// The sums of one E step for a linear motion.
pub(super) enum Pulls {
    /// For each fixed point.
    OfFixed(Vec<Pull>),
    /// If the Gauss transform was used.
    OfBoth(Posterior),
}

impl Pulls {
    pub(super) fn of(
        y: &[Point2<f64>],
        x: &[Point2<f64>],
        variance: f64,
        config: &CpdConfig,
        near: &mut Option<Near>,
    ) -> Self {
        let by_outliers = by_outliers(y, x, variance, config);
        let near = match Way::of(y, x, variance.sqrt(), config, near) {
            Way::Transform => {
                let owed = by_transform(y, x, variance.sqrt(), by_outliers, config.error);
                return Self::OfBoth(owed);
            }
            Way::Pairs(near) => near,
        };
        let moving = Columns::of(y, near, 0.5 / variance);
        Self::OfFixed(lanes::run(PullsOfPairs {
            moving: &moving,
            fixed: x,
            near,
            by_outliers: by_outliers as f32,
        }))
    }
}

/// Moving points by columns, times `root`, in the order of their cells if they are sorted.
struct Columns {
    x: Vec<Group>,
    y: Vec<Group>,
    root: f64,
}

impl Columns {
    fn of(points: &[Point2<f64>], near: Option<&Near>, scale: f64) -> Self {
        // exp(-d² scale) = 2^-(d root)².
        let root = (scale * LOG2_E).sqrt();
        // Whole groups; the last one is padded with points that are too far away to count.
        let groups = points.len().div_ceil(EIGHT);
        let (mut x, mut y) = (vec![[FAR; EIGHT]; groups], vec![[FAR; EIGHT]; groups]);
        let places = x.as_flattened_mut().iter_mut().zip(y.as_flattened_mut());
        let put = |((x, y), point): ((&mut f32, &mut f32), &Point2<f64>)| {
            (*x, *y) = ((root * point.x) as f32, (root * point.y) as f32);
        };
        match near {
            None => places.zip(points).for_each(put),
            Some(near) => {
                let sorted = near.order.iter().filter_map(|at| points.get(*at as usize));
                places.zip(sorted).for_each(put);
            }
        }
        Self { x, y, root }
    }
}

fn by_transform(
    y: &[Point2<f64>],
    x: &[Point2<f64>],
    sigma: f64,
    by_outliers: f64,
    error: f64,
) -> Posterior {
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
    Posterior::of_sums(of_moving.collect(), of_fixed)
}

fn by_pairs(
    y: &[Point2<f64>],
    x: &[Point2<f64>],
    near: Option<&Near>,
    scale: f64,
    by_outliers: f64,
) -> Posterior {
    let moving = Columns::of(y, near, scale);
    let (sums, of_fixed) = lanes::run(Pairs {
        moving: &moving,
        fixed: x,
        near,
        by_outliers: by_outliers as f32,
    });
    let all: Vec<u32>;
    let order = match near {
        Some(near) => &near.order,
        None => {
            all = (0..y.len() as u32).collect();
            &all
        }
    };
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
    Posterior::of_sums(of_moving, of_fixed)
}

/// A place so far away that its exponential is practically zero.
const FAR: f32 = 1e12;

/// All pairs, or those that are near.
struct Pairs<'a> {
    moving: &'a Columns,
    fixed: &'a [Point2<f64>],
    near: Option<&'a Near>,
    by_outliers: f32,
}

impl Kernel for Pairs<'_> {
    type Output = ([Vec<Group>; 3], Vec<f64>);

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) -> Self::Output {
        let Columns {
            x: all_x,
            y: all_y,
            root,
        } = self.moving;
        let groups = all_x.len();
        let nothing = || vec![[0.0; EIGHT]; groups];
        let (mut sums, mut values) = ([nothing(), nothing(), nothing()], nothing());
        let mut of_fixed = Vec::with_capacity(self.fixed.len());
        let all = 0..groups;
        let mut begin = 0;
        let splat = |value| L::Eight::splat(machine, value);
        let load = |numbers: &Group| L::Eight::load(machine, numbers);
        for (index, fixed) in self.fixed.iter().enumerate() {
            let runs = match self.near {
                None => std::slice::from_ref(&all),
                Some(near) => near.of_fixed(index, &mut begin),
            };
            let place = [fixed.x, fixed.y].map(|along| splat((root * along) as f32));
            let mut sum = splat(0.0);
            for run in runs {
                let (Some(x), Some(y), Some(values)) = (
                    all_x.get(run.clone()),
                    all_y.get(run.clone()),
                    values.get_mut(run.clone()),
                ) else {
                    continue;
                };
                for ((x, y), values) in x.iter().zip(y).zip(values) {
                    let (_, k) = group::<L>(machine, [x, y], place);
                    *values = k.to_array();
                    sum += k;
                }
            }
            let sum = total_of_eight(sum);
            let all = sum + self.by_outliers;
            let share = if all > 0.0 { 1.0 / all } else { 0.0 };
            of_fixed.push(f64::from(sum * share));
            if share <= 0.0 {
                continue;
            }
            let (by_x, by_y) = (splat(share * fixed.x as f32), splat(share * fixed.y as f32));
            let share = splat(share);
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
                    let k = load(values);
                    *part = (load(part) + k * share).to_array();
                    *x = (load(x) + k * by_x).to_array();
                    *y = (load(y) + k * by_y).to_array();
                }
            }
        }
        (sums, of_fixed)
    }
}

/// The pulls of all pairs, or of those that are near.
struct PullsOfPairs<'a> {
    moving: &'a Columns,
    fixed: &'a [Point2<f64>],
    near: Option<&'a Near>,
    by_outliers: f32,
}

impl Kernel for PullsOfPairs<'_> {
    type Output = Vec<Pull>;

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) -> Vec<Pull> {
        let Columns {
            x: all_x,
            y: all_y,
            root,
        } = self.moving;
        let all = 0..all_x.len();
        let mut begin = 0;
        let per_root = 1.0 / root;
        let splat = |value| L::Eight::splat(machine, value);
        let mut pulls = Vec::with_capacity(self.fixed.len());
        for (index, fixed) in self.fixed.iter().enumerate() {
            let runs = match self.near {
                None => std::slice::from_ref(&all),
                Some(near) => near.of_fixed(index, &mut begin),
            };
            let place = [fixed.x, fixed.y].map(|along| splat((root * along) as f32));
            // Σ k, Σ k d and Σ k d dᵀ.
            let nothing = splat(0.0);
            let (mut sum, mut x_sum, mut y_sum) = (nothing, nothing, nothing);
            let (mut xx, mut xy, mut yy) = (nothing, nothing, nothing);
            for run in runs {
                let (Some(x), Some(y)) = (all_x.get(run.clone()), all_y.get(run.clone())) else {
                    continue;
                };
                for (x, y) in x.iter().zip(y) {
                    let ([dx, dy], k) = group::<L>(machine, [x, y], place);
                    let (kx, ky) = (k * dx, k * dy);
                    sum += k;
                    x_sum += kx;
                    y_sum += ky;
                    xx += kx * dx;
                    xy += kx * dy;
                    yy += ky * dy;
                }
            }
            let sum = total_of_eight(sum);
            let heard = f64::from(sum + self.by_outliers);
            let share = if heard > 0.0 { 1.0 / heard } else { 0.0 };
            let of = |numbers: L::Eight, by: f64| f64::from(total_of_eight(numbers)) * by;
            let (once, twice) = (share * per_root, share * per_root * per_root);
            let across = of(xy, twice);
            pulls.push(Pull {
                part: f64::from(sum) * share,
                off: Vector2::new(of(x_sum, once), of(y_sum, once)),
                spread: Matrix2::new(of(xx, twice), across, across, of(yy, twice)),
            });
        }
        pulls
    }
}

/// Offsets from a fixed point to moving ones, and their k_mn; all places are multiplied by the root
/// of the scale.
#[inline(always)]
fn group<L: Lanes>(
    machine: L::Machine,
    moving: [&Group; 2],
    fixed: [L::Eight; 2],
) -> ([L::Eight; 2], L::Eight) {
    let [x, y] = moving.map(|along| L::Eight::load(machine, along));
    let (dx, dy) = (x - fixed[0], y - fixed[1]);
    ([dx, dy], exp2_of_minus(machine, dx * dx + dy * dy))
}
