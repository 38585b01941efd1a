//! The dense work on one supernode: columns in blocks of three, rows by fours.
//!
//! A panel holds columns of the factor with all their rows, those of its own diagonal blocks first.
//! Columns are padded to whole fours. A loop begins at the four that contains its first row, so it
//! also writes above the diagonal, which is set to zero again, and into the padding. The diagonal
//! of a factor holds reciprocals, because it is divided by repeatedly.

use crate::lanes::{LANES, Lanes};

/// Rows and columns of a block.
pub(super) const BLOCK: usize = 3;

/// Four rows of a column.
pub(super) type Four = [f64; LANES];

/// Turns a panel, columns of a symmetric matrix from its diagonal on, into columns of its factor;
/// `false` if it is not positive definite. `fours` is the length of a column.
#[inline(always)]
pub(super) fn factor<L: Lanes>(machine: L::Machine, panel: &mut [Four], fours: usize) -> bool {
    let block = BLOCK * fours;
    for index in 0..panel.len() / block {
        let (done, rest) = panel.split_at_mut(index * block);
        let at = BLOCK * index;
        subtract::<L>(machine, &mut rest[..block], at, done, fours);
        if !factor_block::<L>(machine, &mut rest[..block], at, fours) {
            return false;
        }
    }
    true
}

/// Subtracts L Lᵀ of the finished columns of a panel from three columns of a symmetric matrix whose
/// diagonal block begins at row `at` of the panel. Columns of the target end with those of the
/// panel but may begin later, at whole fours.
#[inline(always)]
pub(super) fn subtract<L: Lanes>(
    machine: L::Machine,
    target: &mut [Four],
    at: usize,
    done: &[Four],
    fours: usize,
) {
    let own = target.len() / BLOCK;
    let from = at / LANES;
    let (x, rest) = target.split_at_mut(own);
    let (y, z) = rest.split_at_mut(own);
    let skip = from + own - fours;
    let (x, y, z) = (&mut x[skip..], &mut y[skip..], &mut z[skip..]);
    let count = fours - from;
    let mut pairs = done.chunks_exact(2 * BLOCK * fours);
    for columns in &mut pairs {
        let (left, right) = columns.split_at(BLOCK * fours);
        let (a, b, c) = three(left, fours);
        let (d, e, f) = three(right, fours);
        let (p, q, r) = (
            head::<L>(machine, a, at),
            head::<L>(machine, b, at),
            head::<L>(machine, c, at),
        );
        let (s, t, u) = (
            head::<L>(machine, d, at),
            head::<L>(machine, e, at),
            head::<L>(machine, f, at),
        );
        let (a, b, c) = (
            &a[from..][..count],
            &b[from..][..count],
            &c[from..][..count],
        );
        let (d, e, f) = (
            &d[from..][..count],
            &e[from..][..count],
            &f[from..][..count],
        );
        for i in 0..count {
            let (a, b, c) = (
                L::load(machine, &a[i]),
                L::load(machine, &b[i]),
                L::load(machine, &c[i]),
            );
            let (d, e, f) = (
                L::load(machine, &d[i]),
                L::load(machine, &e[i]),
                L::load(machine, &f[i]),
            );
            let by_x = (a * p.0 + b * q.0 + c * r.0) + (d * s.0 + e * t.0 + f * u.0);
            let by_y = (a * p.1 + b * q.1 + c * r.1) + (d * s.1 + e * t.1 + f * u.1);
            let by_z = (a * p.2 + b * q.2 + c * r.2) + (d * s.2 + e * t.2 + f * u.2);
            x[i] = (L::load(machine, &x[i]) - by_x).to_array();
            y[i] = (L::load(machine, &y[i]) - by_y).to_array();
            z[i] = (L::load(machine, &z[i]) - by_z).to_array();
        }
    }
    let last = pairs.remainder();
    if !last.is_empty() {
        let (a, b, c) = three(last, fours);
        let (p, q, r) = (
            head::<L>(machine, a, at),
            head::<L>(machine, b, at),
            head::<L>(machine, c, at),
        );
        let (a, b, c) = (
            &a[from..][..count],
            &b[from..][..count],
            &c[from..][..count],
        );
        for i in 0..count {
            let (a, b, c) = (
                L::load(machine, &a[i]),
                L::load(machine, &b[i]),
                L::load(machine, &c[i]),
            );
            let (by_x, by_y, by_z) = (
                a * p.0 + b * q.0 + c * r.0,
                a * p.1 + b * q.1 + c * r.1,
                a * p.2 + b * q.2 + c * r.2,
            );
            x[i] = (L::load(machine, &x[i]) - by_x).to_array();
            y[i] = (L::load(machine, &y[i]) - by_y).to_array();
            z[i] = (L::load(machine, &z[i]) - by_z).to_array();
        }
    }
}

/// Cholesky of three columns whose diagonal block begins at row `at`.
#[inline(always)]
fn factor_block<L: Lanes>(
    machine: L::Machine,
    columns: &mut [Four],
    at: usize,
    fours: usize,
) -> bool {
    let (a, rest) = columns.split_at_mut(fours);
    let (b, c) = rest.split_at_mut(fours);
    let (p, q, r) = (rows(a, at), rows(b, at), rows(c, at));
    // Pivots by quotients, so that none has to wait for the square root of another.
    let d0 = 1.0 / p[0];
    let second = q[1] - p[1] * (p[1] * d0);
    let off = q[2] - p[1] * (p[2] * d0);
    let d1 = 1.0 / second;
    let third = r[2] - p[2] * (p[2] * d0) - off * (off * d1);
    let d2 = 1.0 / third;
    let [i00, i11, i22] = [d0, d1, d2].map(f64::sqrt);
    let (l10, l20, l21) = (p[1] * i00, p[2] * i00, off * i11);
    // NaN and infinity are not pivots either.
    let is_pivot = |value: f64| value > 0.0 && value < f64::INFINITY;
    if !(is_pivot(p[0]) && is_pivot(second) && is_pivot(third)) {
        return false;
    }
    let (v00, v10, v11) = (
        L::splat(machine, i00),
        L::splat(machine, l10),
        L::splat(machine, i11),
    );
    let (v20, v21, v22) = (
        L::splat(machine, l20),
        L::splat(machine, l21),
        L::splat(machine, i22),
    );
    let from = at / LANES;
    for ((a, b), c) in a[from..].iter_mut().zip(&mut b[from..]).zip(&mut c[from..]) {
        let x = L::load(machine, a) * v00;
        let y = (L::load(machine, b) - x * v10) * v11;
        let z = (L::load(machine, c) - x * v20 - y * v21) * v22;
        (*a, *b, *c) = (x.to_array(), y.to_array(), z.to_array());
    }
    let (a, b, c) = (
        a.as_flattened_mut(),
        b.as_flattened_mut(),
        c.as_flattened_mut(),
    );
    (a[at], b[at + 1], c[at + 2]) = (i00, i11, i22);
    // Clear what is above the diagonal in its fours, so that it may be multiplied.
    let begin = at / LANES * LANES;
    a[begin..at].fill(0.0);
    b[begin..=at].fill(0.0);
    c[begin..at + 2].fill(0.0);
    true
}

/// Three rows of a column, each broadcast to all lanes.
#[inline(always)]
fn head<L: Lanes>(machine: L::Machine, column: &[Four], at: usize) -> (L, L, L) {
    let [a, b, c] = rows(column, at);
    (
        L::splat(machine, a),
        L::splat(machine, b),
        L::splat(machine, c),
    )
}

/// Three rows of a column.
#[inline(always)]
pub(super) fn rows(column: &[Four], at: usize) -> [f64; BLOCK] {
    match column.as_flattened().get(at..) {
        Some(&[a, b, c, ..]) => [a, b, c],
        _ => [0.0; BLOCK],
    }
}

/// The columns of a block.
#[inline(always)]
pub(super) fn three(block: &[Four], fours: usize) -> (&[Four], &[Four], &[Four]) {
    let (a, rest) = block.split_at(fours);
    let (b, c) = rest.split_at(fours);
    (a, b, &c[..fours])
}
