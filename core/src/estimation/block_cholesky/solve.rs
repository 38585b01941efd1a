//! Forward and backward substitution.
//!
//! Supernode by supernode, three columns at a time: their own rows one by one, the rows below by
//! fours.

use nalgebra::Vector3;

use super::dense::{BLOCK, Four, rows, three};
use super::{BlockFactor, BlockPattern};
use crate::lanes::{self, Kernel, LANES, Lanes, total};

impl BlockPattern {
    /// Solves with a factor, in place.
    pub(in super::super) fn solve(&self, factor: &BlockFactor, right: &mut [Vector3<f64>]) {
        let mut x = vec![[0.0; BLOCK]; self.size()];
        for (value, &place) in right.iter().zip(&self.tree.place) {
            x[place] = (*value).into();
        }
        lanes::run(Solving {
            pattern: self,
            factor,
            x: &mut x,
        });
        for (value, &place) in right.iter_mut().zip(&self.tree.place) {
            *value = x[place].into();
        }
    }
}

struct Solving<'a> {
    pattern: &'a BlockPattern,
    factor: &'a BlockFactor,
    /// By place in the order.
    x: &'a mut [[f64; BLOCK]],
}

impl Kernel for Solving<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) {
        let Self { pattern, factor, x } = self;
        let tree = &pattern.tree;
        let fronts = || tree.supernodes.iter().zip(&pattern.fronts);
        let highest = pattern.fronts.iter().map(|front| front.fours).max();
        // The rows of one supernode.
        let mut local = vec![[0.0; LANES]; highest.unwrap_or(0)];
        for (node, front) in fronts() {
            let local = &mut local[..front.fours];
            let panel = &factor.panels[front.panel..][..BLOCK * node.width * front.fours];
            let (own, above) = x[node.first..].split_at_mut(node.width);
            local.fill([0.0; LANES]);
            forward::<L>(machine, panel, local, own);
            let sums = local.as_flattened()[BLOCK * node.width..].chunks_exact(BLOCK);
            for (sum, &row) in sums.zip(tree.below(node)) {
                let x = &mut above[row - node.first - node.width];
                for (x, sum) in x.iter_mut().zip(sum) {
                    *x += sum;
                }
            }
        }
        for (node, front) in fronts().rev() {
            let local = &mut local[..front.fours];
            let panel = &factor.panels[front.panel..][..BLOCK * node.width * front.fours];
            let (own, above) = x[node.first..].split_at_mut(node.width);
            let below = tree.below(node).iter();
            let below = below.map(|&row| &above[row - node.first - node.width]);
            write(local, own.iter().map(|_| &[0.0; BLOCK]).chain(below));
            backward::<L>(machine, panel, local, own);
        }
    }
}

/// Writes blocks into the rows of a supernode, and zeros into the remaining rows.
#[inline(always)]
fn write<'a>(local: &mut [Four], blocks: impl Iterator<Item = &'a [f64; BLOCK]>) {
    let local = local.as_flattened_mut();
    let mut at = 0;
    for block in blocks {
        local[at..at + BLOCK].copy_from_slice(block);
        at += BLOCK;
    }
    local[at..].fill(0.0);
}

/// Solves with the columns of a supernode: `own` becomes the solution, and `local`, initially zero,
/// what the solution subtracts from the rows below.
#[inline(always)]
fn forward<L: Lanes>(
    machine: L::Machine,
    panel: &[Four],
    local: &mut [Four],
    own: &mut [[f64; BLOCK]],
) {
    let fours = local.len();
    for (index, (block, own)) in panel.chunks_exact(BLOCK * fours).zip(own).enumerate() {
        let at = BLOCK * index;
        let (a, b, c) = three(block, fours);
        let [p, q, r] = rows(local, at);
        let [p, q, r] = [own[0] + p, own[1] + q, own[2] + r];
        let ([i0, l10, l20], [_, i1, l21], [_, _, i2]) = (rows(a, at), rows(b, at), rows(c, at));
        let x = p * i0;
        let y = (q - l10 * x) * i1;
        let z = (r - l20 * x - l21 * y) * i2;
        *own = [x, y, z];
        let [x, y, z] = own.map(|value| L::splat(machine, value));
        let from = at / LANES;
        let columns = a[from..].iter().zip(&b[from..]).zip(&c[from..]);
        for (((a, b), c), local) in columns.zip(&mut local[from..]) {
            let [a, b, c] = [a, b, c].map(|four| L::load(machine, four));
            *local = (L::load(machine, local) - (a * x + b * y + c * z)).to_array();
        }
    }
}

/// Solves with the transposed columns of a supernode, from the solution `local` at the rows below;
/// its own rows there are zero.
#[inline(always)]
fn backward<L: Lanes>(
    machine: L::Machine,
    panel: &[Four],
    local: &mut [Four],
    own: &mut [[f64; BLOCK]],
) {
    let fours = local.len();
    let blocks = panel.chunks_exact(BLOCK * fours).zip(own).enumerate();
    for (index, (block, own)) in blocks.rev() {
        let at = BLOCK * index;
        let (a, b, c) = three(block, fours);
        let zero = L::splat(machine, 0.0);
        let mut sums = [zero; BLOCK];
        let from = at / LANES;
        let columns = a[from..].iter().zip(&b[from..]).zip(&c[from..]);
        for (((a, b), c), local) in columns.zip(&local[from..]) {
            let known = L::load(machine, local);
            for (sum, column) in sums.iter_mut().zip([a, b, c]) {
                *sum += L::load(machine, column) * known;
            }
        }
        let [p, q, r] = sums.map(|sum| total(sum));
        let ([i0, l10, l20], [_, i1, l21], [_, _, i2]) = (rows(a, at), rows(b, at), rows(c, at));
        let z = (own[2] - r) * i2;
        let y = (own[1] - q - l21 * z) * i1;
        let x = (own[0] - p - l10 * y - l20 * z) * i0;
        *own = [x, y, z];
        local.as_flattened_mut()[at..at + BLOCK].copy_from_slice(own);
    }
}
