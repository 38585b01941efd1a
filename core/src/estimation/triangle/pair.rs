//! One match in a scan: a single pair of vectors is subtracted from the triangle.
//!
//! In: the packed triangle and two vectors. Out: P - a aᵀ - b bᵀ, with the same bits as the pass
//! that subtracts many vectors.
//!
//! 1. Four rows are processed together along the columns that all of them have, so each number of
//!    the vectors is read once for four.
//! 2. With only two vectors, their numbers in the four rows stay in registers and nothing needs to
//!    be sorted by tiles. The pass over tiles, made for twenty vectors at a time, takes 1.2 times
//!    as long natively and 1.9 times in WebAssembly at a hundred landmarks.
//! 3. The rest at the ends of the rows, three numbers at most, follows row by row.

use super::ROWS;

/// The pass for the vectors `a` and `b`. It is not a closure, because closures are not always
/// inlined into code compiled for the wider instructions.
pub(super) struct PairPass<'a> {
    pub(super) packed: &'a mut [f64],
    pub(super) a: &'a [f64],
    pub(super) b: &'a [f64],
}

impl pulp::NullaryFnOnce for PairPass<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { packed, a, b } = self;
        let (mut rest, mut lengths) = (packed, 1..);
        for (own_a, own_b) in a.chunks(ROWS).zip(b.chunks(ROWS)) {
            let mut rows: [&mut [f64]; ROWS] = Default::default();
            let mut shared = usize::MAX;
            for (row, length) in rows.iter_mut().zip(&mut lengths).take(own_a.len()) {
                let Some((elements, next)) = std::mem::take(&mut rest).split_at_mut_checked(length)
                else {
                    return;
                };
                (*row, rest) = (elements, next);
                shared = shared.min(length);
            }
            // There may be fewer than four last rows of the matrix.
            if let (&[a0, a1, a2, a3], &[b0, b1, b2, b3]) = (own_a, own_b) {
                four_rows(&mut rows, [[a0, b0], [a1, b1], [a2, b2], [a3, b3]], a, b);
            } else {
                shared = 0;
            }
            let rows = rows.into_iter().zip(own_a.iter().zip(own_b));
            for (row, (own_a, own_b)) in rows {
                subtract(row, shared, [*own_a, *own_b], a, b);
            }
        }
    }
}

/// The columns that the first and shortest of four rows has.
#[inline(always)]
fn four_rows(
    [r0, r1, r2, r3]: &mut [&mut [f64]; ROWS],
    [f0, f1, f2, f3]: [[f64; 2]; ROWS],
    a: &[f64],
    b: &[f64],
) {
    let first = r0.iter_mut().zip(r1.iter_mut());
    let last = r2.iter_mut().zip(r3.iter_mut());
    for (((e0, e1), (e2, e3)), (a, b)) in first.zip(last).zip(a.iter().zip(b)) {
        *e0 = (*e0 - f0[0] * a) - f0[1] * b;
        *e1 = (*e1 - f1[0] * a) - f1[1] * b;
        *e2 = (*e2 - f2[0] * a) - f2[1] * b;
        *e3 = (*e3 - f3[0] * a) - f3[1] * b;
    }
}

/// The columns of one row from `first` on.
#[inline(always)]
fn subtract(row: &mut [f64], first: usize, factors: [f64; 2], a: &[f64], b: &[f64]) {
    let columns = row.iter_mut().zip(a.iter().zip(b)).skip(first);
    for (element, (a, b)) in columns {
        *element = (*element - factors[0] * a) - factors[1] * b;
    }
}
