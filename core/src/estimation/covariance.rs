//! The covariance of the filter, whose corrections are collected and written several at a time.
//!
//! Each correction P -= W Wᵀ goes over the whole triangle, which for some hundred landmarks is
//! larger than a cache: ten lines of a scan cost ten times the memory traffic of one. But the next
//! correction needs only a few columns of P. So P is kept as T - Σ wₖ wₖᵀ: T in the triangle, the
//! wₖ beside it. Reading a column costs O(n) for each pending vector, and [`Covariance::settle`]
//! writes them all in one pass. Except for rounding, the numbers equal those of the corrections
//! made one by one.
//!
//! Source: the idea is that of the compressed filter (Guivant & Nebot 2001), here with the exact
//! state at each line.

use nalgebra::Matrix5;

use super::triangle::{MOST, SymmetricMatrix, TILE};
use crate::lanes::widened;

/// A column of a measurement's Jacobian: the state, and the derivatives of the two numbers by it.
pub type Column = (usize, [f64; 2]);

/// The covariance, some of which may still have to be written.
#[derive(Clone, Debug)]
pub struct Covariance {
    settled: SymmetricMatrix,
    /// The vectors wₖ one after another, n numbers each.
    waiting: Vec<f64>,
    tiles: Vec<[f64; TILE]>,
}

impl Covariance {
    /// The robot's own block, of (x, y, θ, κ, s); there are no landmarks yet.
    #[must_use]
    pub fn new(robot: &Matrix5<f64>) -> Self {
        Self {
            settled: SymmetricMatrix::from_fn(5, |row, column| robot[(row, column)]),
            waiting: vec![],
            tiles: vec![],
        }
    }

    /// Number of states.
    #[must_use]
    pub fn n(&self) -> usize {
        self.settled.n()
    }

    /// The written part: all of it after [`Self::settle`].
    #[must_use]
    pub fn settled(&self) -> &SymmetricMatrix {
        debug_assert!(self.waiting.is_empty());
        &self.settled
    }

    /// The element in `row` and `column`; NaN outside of the matrix.
    #[must_use]
    pub fn get(&self, row: usize, column: usize) -> f64 {
        let settled = self.settled.get(row, column);
        self.vectors().fold(settled, |value, w| {
            let pair = w.get(row).zip(w.get(column));
            pair.map_or(f64::NAN, |(a, b)| value - a * b)
        })
    }

    /// An upper bound of the variance of a state, without pending corrections, which only reduce
    /// it. O(1).
    #[must_use]
    pub fn variance_bound(&self, state: usize) -> f64 {
        self.settled.get(state, state)
    }

    /// Moves the robot: F P Fᵀ + Q, where `robot` does this for the robot's own block and the rows
    /// of `f` belong to x, y and θ.
    pub fn advance(
        &mut self,
        f: &nalgebra::SMatrix<f64, 3, 5>,
        robot: impl FnOnce(&Matrix5<f64>) -> Matrix5<f64>,
    ) {
        let own = Matrix5::from_fn(|row, column| self.settled.get(row, column));
        let own = robot(&own);
        for row in 0..5 {
            for column in 0..=row {
                self.settled.set(row, column, own[(row, column)]);
            }
        }
        let n = self.n();
        let landmarks = self.settled.rows_mut(5);
        for row in landmarks.chain(self.waiting.chunks_exact_mut(n)) {
            // F is the identity except for the effects of heading, curvature and turn scale on the
            // step.
            if let [x, y, turn, curvature, scale, ..] = row {
                *x += f[(0, 2)] * *turn + f[(0, 3)] * *curvature + f[(0, 4)] * *scale;
                *y += f[(1, 2)] * *turn + f[(1, 3)] * *curvature + f[(1, 4)] * *scale;
                *turn += f[(2, 3)] * *curvature + f[(2, 4)] * *scale;
            }
        }
    }

    /// P Hᵀ for a measurement of two numbers with few columns: `first` and `second` become its two
    /// columns.
    pub fn product(&self, h: &[Column], first: &mut Vec<f64>, second: &mut Vec<f64>) {
        for product in [&mut *first, &mut *second] {
            product.clear();
            product.resize(self.n(), 0.0);
        }
        for neighbours in h.chunk_by(|a, b| a.0 + 1 == b.0) {
            self.add_neighbours(neighbours, first, second);
        }
        let mut factors = [[0.0; 2]; MOST];
        for (factors, w) in factors.iter_mut().zip(self.vectors()) {
            let by = |axis: usize| -> f64 {
                h.iter()
                    .map(|(state, h)| w.get(*state).map_or(f64::NAN, |w| w * h[axis]))
                    .sum()
            };
            *factors = [by(0), by(1)];
        }
        let (n, waiting) = (self.n(), &self.waiting);
        widened(
            #[inline(always)]
            || subtract_multiples(waiting, n, &factors, first, second),
        );
    }

    /// Adds neighbouring columns, two or three at a time.
    fn add_neighbours(&self, columns: &[Column], first: &mut [f64], second: &mut [f64]) {
        match columns {
            [] => {}
            [a] => self.settled.add_columns(a.0, &[a.1], first, second),
            [a, b] => self.settled.add_columns(a.0, &[a.1, b.1], first, second),
            [a, b, c, rest @ ..] => {
                self.settled
                    .add_columns(a.0, &[a.1, b.1, c.1], first, second);
                self.add_neighbours(rest, first, second);
            }
        }
    }

    /// P -= a aᵀ + b bᵀ.
    pub fn subtract(&mut self, a: &[f64], b: &[f64]) {
        let n = self.n();
        debug_assert!(a.len() == n && b.len() == n);
        if self.waiting.len() + 2 * n > MOST * n {
            self.settle();
        }
        self.waiting.extend_from_slice(a);
        self.waiting.extend_from_slice(b);
    }

    /// Writes all pending corrections, in one pass over the triangle.
    pub fn settle(&mut self) {
        self.settled.subtract_outer(&self.waiting, &mut self.tiles);
        self.waiting.clear();
    }

    /// Appends two rows (and so columns), each up to its diagonal.
    pub fn push_pair(&mut self, rows: [Vec<f64>; 2]) {
        self.settle();
        for row in rows {
            self.settled.push_row(row);
        }
    }

    /// Removes rows and columns `first` and `first + 1`; what remains is the marginal.
    pub fn remove_pair(&mut self, first: usize) {
        self.settle();
        self.settled.remove_pair(first);
    }

    fn vectors(&self) -> impl Iterator<Item = &[f64]> {
        self.waiting.chunks_exact(self.n())
    }
}

/// `first` -= Σ f₀ w and `second` -= Σ f₁ w over the vectors w of `n` numbers each: a few numbers
/// at a time stay in registers while all vectors are subtracted.
#[inline(always)]
fn subtract_multiples(
    vectors: &[f64],
    n: usize,
    factors: &[[f64; 2]; MOST],
    first: &mut [f64],
    second: &mut [f64],
) {
    let parts = first.chunks_mut(TILE).zip(second.chunks_mut(TILE));
    for (index, (first, second)) in parts.enumerate() {
        let own = vectors.chunks_exact(n).zip(factors);
        let own = own.filter_map(|(w, f)| Some((w.get(TILE * index..)?, f)));
        if let (Some(a), Some(b)) = (first.as_mut_array(), second.as_mut_array()) {
            subtract_from_tile(own, a, b);
            continue;
        }
        for (w, [by_first, by_second]) in own {
            for ((a, b), w) in first.iter_mut().zip(second.iter_mut()).zip(w) {
                *a -= by_first * w;
                *b -= by_second * w;
            }
        }
    }
}

#[inline(always)]
fn subtract_from_tile<'a>(
    vectors: impl Iterator<Item = (&'a [f64], &'a [f64; 2])>,
    first: &mut [f64; TILE],
    second: &mut [f64; TILE],
) {
    let (mut a, mut b) = (*first, *second);
    for (w, [by_first, by_second]) in vectors {
        let Some(w) = w.first_chunk::<TILE>() else {
            break;
        };
        for lane in 0..TILE {
            a[lane] -= by_first * w[lane];
            b[lane] -= by_second * w[lane];
        }
    }
    (*first, *second) = (a, b);
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, Matrix5, SMatrix};
    use proptest::prelude::*;

    use super::*;
    use crate::geom::Length;

    fn dense(p: &Covariance) -> DMatrix<f64> {
        DMatrix::from_fn(p.n(), p.n(), |i, j| p.get(i, j))
    }

    /// A covariance over the robot and `pairs` landmarks.
    fn some(pairs: usize) -> Covariance {
        let mut p = Covariance::new(&(Matrix5::identity() * 3.0));
        for pair in 0..pairs {
            let row = |n: usize| -> Vec<f64> {
                let off = |column: usize| 0.1 * ((pair * 7 + column * 3 + n) % 5) as f64;
                (0..n).map(off).chain([2.0 + n as f64]).collect()
            };
            let n = p.n();
            p.push_pair([row(n), row(n + 1)]);
        }
        p
    }

    proptest! {
        #[test]
        fn what_waits_counts_like_what_is_written(
            pairs in 0..40_usize, corrections in 0..40_usize, seed in prop::collection::vec(-1.0..1.0_f64, 211),
        ) {
            let mut p = some(pairs);
            let mut expect = dense(&p);
            let n = p.n();
            let f = SMatrix::<f64, 3, 5>::from_fn(|i, j| f64::from(u8::from(i == j)) + if j > i { seed[i + j] } else { 0.0 });
            let mut whole = DMatrix::<f64>::identity(n, n);
            let mut f5 = Matrix5::identity();
            // The only elements that a step uses.
            for (i, j) in [(0, 2), (1, 2), (0, 3), (0, 4), (1, 3), (1, 4), (2, 3), (2, 4)] {
                whole[(i, j)] = f[(i, j)];
                f5[(i, j)] = f[(i, j)];
            }
            for k in 0..corrections {
                let vector = |s: usize| -> Vec<f64> { (0..n).map(|i| 0.1 * seed[(s + 7 * i + 13 * k) % 211]).collect() };
                let (a, b) = (vector(1), vector(2));
                for w in [&a, &b] {
                    let w = DMatrix::from_column_slice(n, 1, w);
                    expect -= &w * w.transpose();
                }
                p.subtract(&a, &b);
                if k % 3 == 0 {
                    p.advance(&f, |own| f5 * own * f5.transpose());
                    expect = &whole * expect * whole.transpose();
                }
            }
            let scale = 1.0 + expect.length();
            prop_assert!((dense(&p) - &expect).length() < 1e-9 * scale);
            // A measurement of the heading and of the last state.
            let h = [(2, [1.0, 0.5]), (n - 1, [-0.3, 2.0])];
            let (mut a, mut b) = (vec![], vec![]);
            p.product(&h, &mut a, &mut b);
            for (axis, got) in [a, b].iter().enumerate() {
                for (row, value) in got.iter().enumerate() {
                    let exact: f64 = h.iter().map(|(s, h)| expect[(row, *s)] * h[axis]).sum();
                    prop_assert!((value - exact).abs() < 1e-9 * scale);
                }
            }
            p.settle();
            prop_assert!((dense(&p) - expect).length() < 1e-9 * scale);
        }
    }
}
