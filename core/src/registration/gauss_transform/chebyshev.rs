//! The fast Gauss transform by interpolation.
//!
//! The plane is cut into boxes of half-side a = r √2 σ. For a box of sources and one of targets,
//! the kernel is interpolated at p Chebyshev nodes in each direction of each box: g(t - s) ≈ Σ c_jk
//! T_j(t) T_k(s), separately in x and y, because the Gaussian is their product.
//!
//! 1. Each box of sources: moments Σ q T_j(x) T_k(y).
//! 2. Each pair of boxes that are not too far apart: the moments, times the coefficients of x and
//!    of y, are added to the box of targets.
//! 3. Each target reads the polynomial of its box.
//!
//! Error: in units of √2 σ the p-th derivative of exp(-u²) is below 1.09 √(2^p p!) (Cramér), so
//! interpolating one variable errs by at most e = 2.18 (r/√2)^p / √p!, and both variables of one
//! direction by E = e (1 + Λ), Λ being the Lebesgue constant of the nodes; both directions by 2 E +
//! E². p is the least for which this plus the part beyond reach is below the error allowed.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_2_PI, PI, SQRT_2};

use nalgebra::Point2;
use pulp::NullaryFnOnce;

use super::reach;
use crate::lanes::widened;

/// Half-sides of boxes that are considered, in √2 σ.
const HALF_SIDES: [f64; 4] = [0.25, 0.5, 1.0, 2.0];
/// Most nodes in a direction.
const MOST_NODES: usize = 48;
/// Part of the error that may come from sources beyond reach.
const BEYOND: f64 = 0.1;
/// Cost of a product, relative to a pair.
const PRODUCT: f64 = 0.15;
/// Cost of an exponential by libm, relative to a pair.
const EXPONENTIAL: f64 = 12.0;

/// How boxes are cut.
pub(in crate::registration) struct Plan {
    nodes: usize,
    /// m.
    half_side: f64,
    /// How far apart boxes may be to affect each other, in boxes.
    boxes: i64,
    /// In multiples of the cost of a pair.
    pub(super) work: f64,
}

impl Plan {
    /// The way to cut boxes that takes the least work.
    pub(super) fn of(
        sources: &[Point2<f64>],
        targets: &[Point2<f64>],
        sigma: f64,
        error: f64,
    ) -> Self {
        let far = reach(0.5 / (sigma * sigma), BEYOND * error);
        let (from_extent, to_extent) = (extent(sources), extent(targets));
        let plan = |r: f64| {
            let half_side = r * SQRT_2 * sigma;
            let nodes = nodes(r, (1.0 - BEYOND) * error);
            let boxes = (0.5 * far / half_side).ceil() + 1.0;
            let (from, to) = (
                occupied(sources.len(), from_extent, half_side),
                occupied(targets.len(), to_extent, half_side),
            );
            let pairs = to * from.min((2.0 * boxes + 1.0) * (2.0 * boxes + 1.0));
            let (n, points) = (nodes as f64, (sources.len() + targets.len()) as f64);
            let products = points * (n * n + 8.0 * n) + pairs * 2.0 * n * n * n;
            // The coefficients for each distance between boxes: exponentials, and two matrix
            // products.
            let distances = 2.0 * boxes + 1.0;
            let coefficients = distances * (EXPONENTIAL * n * n + PRODUCT * 2.0 * n * n * n);
            Self {
                nodes,
                half_side,
                boxes: boxes.min(1e6) as i64,
                work: if nodes > MOST_NODES {
                    f64::INFINITY
                } else {
                    PRODUCT * products + coefficients
                },
            }
        };
        let mut best = plan(HALF_SIDES[0]);
        for r in HALF_SIDES.into_iter().skip(1) {
            let other = plan(r);
            if other.work < best.work {
                best = other;
            }
        }
        best
    }
}

/// How far points spread, m.
fn extent(points: &[Point2<f64>]) -> [f64; 2] {
    // Points are finite, so no check for NaN as in `f64::min`.
    let lesser = |a: f64, b: f64| if b < a { b } else { a };
    let greater = |a: f64, b: f64| if b > a { b } else { a };
    let (mut least, mut most) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for point in points {
        for (axis, along) in [point.x, point.y].into_iter().enumerate() {
            least[axis] = lesser(least[axis], along);
            most[axis] = greater(most[axis], along);
        }
    }
    [0, 1].map(|axis| greater(most[axis] - least[axis], 0.0))
}

/// About how many boxes this many points occupy: from their extent, but never more than there are
/// points.
fn occupied(count: usize, extent: [f64; 2], half_side: f64) -> f64 {
    let [x, y] = extent.map(|along| along / (2.0 * half_side) + 1.0);
    (x * y).min(count as f64)
}

/// The least number of nodes whose error is at most `error`.
fn nodes(r: f64, error: f64) -> usize {
    let mut one = 2.18;
    for nodes in 1..=MOST_NODES {
        one *= r / SQRT_2 / (nodes as f64).sqrt();
        let lebesgue = FRAC_2_PI * libm::log(nodes as f64 + 1.0) + 1.0;
        let both = one * (1.0 + lebesgue);
        if 2.0 * both + both * both <= error {
            return nodes;
        }
    }
    MOST_NODES + 1
}

/// The sums at each target.
pub(super) fn transform<const K: usize>(
    sources: &[Point2<f64>],
    weights: &[[f64; K]],
    targets: &[Point2<f64>],
    sigma: f64,
    plan: &Plan,
) -> Vec<[f64; K]> {
    if plan.nodes > MOST_NODES {
        return super::direct::all(sources, weights, targets, 0.5 / (sigma * sigma));
    }
    let origin = sources.first().copied().unwrap_or_default();
    let from = Boxes::of(sources, origin, plan);
    let to = Boxes::of(targets, origin, plan);
    let coefficients = Coefficients::of(sigma, plan);
    widened(Transform {
        weights,
        count: targets.len(),
        from: &from,
        to: &to,
        coefficients: &coefficients,
        plan,
    })
}

/// Points in boxes, by row and column.
struct Boxes(BTreeMap<(i64, i64), Vec<InBox>>);

/// A point: its index in the list, and its place within the box, -1 to 1.
type InBox = (usize, [f64; 2]);

impl Boxes {
    fn of(points: &[Point2<f64>], origin: Point2<f64>, plan: &Plan) -> Self {
        let mut boxes: BTreeMap<_, Vec<_>> = BTreeMap::new();
        let along = |x: f64| {
            let boxes = x / (2.0 * plan.half_side);
            let whole = boxes.floor();
            (whole as i64, 2.0 * (boxes - whole) - 1.0)
        };
        for (index, point) in points.iter().enumerate() {
            let ((column, x), (row, y)) = (along(point.x - origin.x), along(point.y - origin.y));
            boxes
                .entry((row, column))
                .or_default()
                .push((index, [x, y]));
        }
        Self(boxes)
    }
}

/// For each distance between boxes, from `-boxes` to `boxes`: c_jk of T_j(t) T_k(s).
struct Coefficients {
    nodes: usize,
    boxes: i64,
    all: Vec<f64>,
}

impl Coefficients {
    fn of(sigma: f64, plan: &Plan) -> Self {
        let p = plan.nodes;
        let angle = |node: usize| PI * (node as f64 + 0.5) / p as f64;
        let places: Vec<f64> = (0..p).map(|node| libm::cos(angle(node))).collect();
        // T_j at the nodes, scaled so that it turns values into coefficients.
        let to_coefficients = |j: usize, node: usize| {
            let scale = if j == 0 { 1.0 } else { 2.0 };
            scale / p as f64 * libm::cos(j as f64 * angle(node))
        };
        let cosines: Vec<f64> = (0..p * p)
            .map(|at| to_coefficients(at / p, at % p))
            .collect();
        let transposed: Vec<f64> = (0..p * p)
            .map(|at| to_coefficients(at % p, at / p))
            .collect();
        let mut all = vec![];
        for apart in -plan.boxes..=plan.boxes {
            let value = |t: f64, s: f64| {
                let off = plan.half_side * (2.0 * apart as f64 + t - s) / (SQRT_2 * sigma);
                libm::exp(-off * off)
            };
            let values: Vec<f64> = places
                .iter()
                .flat_map(|t| places.iter().map(move |s| value(*t, *s)))
                .collect();
            // Both sides: C V Cᵀ.
            let mut left = vec![0.0; p * p];
            add_product(&cosines, &values, &mut left, p);
            let begin = all.len();
            all.resize(begin + p * p, 0.0);
            add_product(&left, &transposed, &mut all[begin..], p);
        }
        Self {
            nodes: p,
            boxes: plan.boxes,
            all,
        }
    }

    fn apart(&self, boxes: i64) -> &[f64] {
        let size = self.nodes * self.nodes;
        let at = usize::try_from(boxes + self.boxes).unwrap_or(usize::MAX);
        let range = at.saturating_mul(size)..at.saturating_add(1).saturating_mul(size);
        self.all.get(range).unwrap_or(&[])
    }
}

/// Adds A B to `sums`, all of them square matrices row by row. It works on whole rows, which
/// compilers vectorise.
#[inline(always)]
fn add_product(a: &[f64], b: &[f64], sums: &mut [f64], size: usize) {
    for (sums, row) in sums.chunks_exact_mut(size).zip(a.chunks_exact(size)) {
        for (a, row) in row.iter().zip(b.chunks_exact(size)) {
            for (sum, b) in sums.iter_mut().zip(row) {
                *sum += a * b;
            }
        }
    }
}

struct Transform<'a, const K: usize> {
    weights: &'a [[f64; K]],
    count: usize,
    from: &'a Boxes,
    to: &'a Boxes,
    coefficients: &'a Coefficients,
    plan: &'a Plan,
}

impl<const K: usize> NullaryFnOnce for Transform<'_, K> {
    type Output = Vec<[f64; K]>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        let p = self.plan.nodes;
        let mut moments = BTreeMap::new();
        let (mut tx, mut ty) = ([0.0; MOST_NODES], [0.0; MOST_NODES]);
        for (place, points) in &self.from.0 {
            let mut sums = [const { vec![] }; K];
            for column in &mut sums {
                column.resize(p * p, 0.0);
            }
            for (index, [x, y]) in points {
                let Some(weights) = self.weights.get(*index) else {
                    continue;
                };
                polynomials(*x, &mut tx, p);
                polynomials(*y, &mut ty, p);
                for (column, weight) in sums.iter_mut().zip(weights) {
                    for (row, tx) in column.chunks_exact_mut(p).zip(&tx) {
                        let scaled = tx * weight;
                        for (sum, ty) in row.iter_mut().zip(&ty) {
                            *sum += scaled * ty;
                        }
                    }
                }
            }
            moments.insert(*place, sums);
        }
        let mut found = vec![[0.0; K]; self.count];
        let (mut half, mut local) = (vec![0.0; p * p], [const { vec![] }; K]);
        let reach = self.plan.boxes;
        for ((row, column), points) in &self.to.0 {
            for sums in &mut local {
                sums.clear();
                sums.resize(p * p, 0.0);
            }
            for away in -reach..=reach {
                let from = (row - away, column - reach);
                let to = (row - away, column + reach);
                for ((_, other), sums) in moments.range(from..=to) {
                    let by_x = self.coefficients.apart(column - other);
                    // Transposed, because the kernel is even.
                    let by_y = self.coefficients.apart(-away);
                    for (local, moments) in local.iter_mut().zip(sums) {
                        half.fill(0.0);
                        add_product(by_x, moments, &mut half, p);
                        add_product(&half, by_y, local, p);
                    }
                }
            }
            for (index, [x, y]) in points {
                polynomials(*x, &mut tx, p);
                polynomials(*y, &mut ty, p);
                let Some(found) = found.get_mut(*index) else {
                    continue;
                };
                for (value, local) in found.iter_mut().zip(&local) {
                    let mut along = [0.0; MOST_NODES];
                    add_product(&tx[..p], local, &mut along[..p], p);
                    *value = along.iter().zip(&ty).take(p).map(|(c, ty)| c * ty).sum();
                }
            }
        }
        found
    }
}

/// T_0 to T_{p-1} at x.
#[inline(always)]
fn polynomials(x: f64, values: &mut [f64; MOST_NODES], p: usize) {
    let (mut before, mut here) = (1.0, x);
    for value in values.iter_mut().take(p) {
        *value = before;
        (before, here) = (here, 2.0 * x * here - before);
    }
}
