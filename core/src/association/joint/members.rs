//! A set of pairings with the Cholesky factor of the covariance of their innovations, which grows
//! and shrinks at its end.

use nalgebra::{Matrix2, Vector2};

use super::{Cross, Pairing};

/// L of C = L Lᵀ in blocks of 2x2, row by row up to the diagonal, and L⁻¹ v.
#[derive(Clone, Debug, Default)]
pub(super) struct Members {
    /// Places of the pairings.
    places: Vec<usize>,
    blocks: Vec<Matrix2<f64>>,
    whitened: Vec<Vector2<f64>>,
    /// L⁻¹, as `blocks`.
    inverse: Vec<Matrix2<f64>>,
}

/// Where row `row` begins.
fn start(row: usize) -> usize {
    row * (row + 1) / 2
}

impl Members {
    pub(super) fn clear(&mut self) {
        self.places.clear();
        self.blocks.clear();
        self.whitened.clear();
    }

    pub(super) fn len(&self) -> usize {
        self.places.len()
    }

    /// Adds a pairing and returns what it adds to the joint distance; `None`, with nothing changed,
    /// if it excludes a member or if the covariance is not positive definite.
    pub(super) fn join(
        &mut self,
        place: usize,
        pairings: &[Pairing],
        cross: &impl Cross,
    ) -> Option<f64> {
        let first = self.blocks.len();
        let added = self.row(place, pairings, cross);
        if added.is_none() {
            self.blocks.truncate(first);
        }
        let whitened = added?;
        self.places.push(place);
        self.whitened.push(whitened);
        Some(whitened.norm_squared())
    }

    /// Appends the row of a pairing to L; returns its part of L⁻¹ v.
    fn row(
        &mut self,
        place: usize,
        pairings: &[Pairing],
        cross: &impl Cross,
    ) -> Option<Vector2<f64>> {
        let pairing = pairings.get(place)?;
        let first = self.blocks.len();
        let (mut rest, mut v) = (pairing.cov, pairing.v);
        for (column, other) in self.places.iter().enumerate() {
            let mut block = cross(pairing, pairings.get(*other)?)?;
            let theirs = self.blocks.get(start(column)..start(column + 1))?;
            let (own, theirs) = theirs.split_last()?;
            for (mine, theirs) in self.blocks.get(first..)?.iter().zip(theirs) {
                block -= mine * theirs.transpose();
            }
            // Block Lᵀ = the remainder, for the lower triangle L of the member.
            let block = own.solve_lower_triangular(&block.transpose())?.transpose();
            rest -= block * block.transpose();
            v -= block * self.whitened.get(column)?;
            self.blocks.push(block);
        }
        let own = rest.cholesky()?.l();
        self.blocks.push(own);
        own.solve_lower_triangular(&v)
    }

    /// Removes the last pairing.
    pub(super) fn leave(&mut self) {
        self.places.pop();
        self.whitened.pop();
        self.blocks.truncate(start(self.places.len()));
    }

    /// The member farthest from what all others predict for it, and its d²; (0, 0) for an empty
    /// set.
    ///
    /// With u = C⁻¹ v and S the member's block of C⁻¹, the others expect it with covariance S⁻¹,
    /// and it is S⁻¹ u away: d² = uᵀ S⁻¹ u.
    pub(super) fn worst(&mut self) -> (usize, f64) {
        self.invert();
        let mut worst = (0, 0.0);
        for member in 0..self.len() {
            let (mut u, mut s) = (Vector2::zeros(), Matrix2::zeros());
            for (row, whitened) in self.whitened.iter().enumerate().skip(member) {
                if let Some(m) = self.inverse.get(start(row) + member) {
                    u += m.transpose() * whitened;
                    s += m.transpose() * m;
                }
            }
            let d2 = s.try_inverse().map_or(0.0, |inverse| u.dot(&(inverse * u)));
            if d2 > worst.1 {
                worst = (member, d2);
            }
        }
        worst
    }

    /// L⁻¹ by forward substitution, column by column of blocks.
    fn invert(&mut self) {
        self.inverse.clear();
        self.inverse.resize(self.blocks.len(), Matrix2::zeros());
        let n = self.len();
        for column in 0..n {
            for row in column..n {
                let mut sum = match row == column {
                    true => Matrix2::identity(),
                    false => Matrix2::zeros(),
                };
                for k in column..row {
                    sum -= self.blocks[start(row) + k] * self.inverse[start(k) + column];
                }
                let own = self.blocks[start(row) + row];
                self.inverse[start(row) + column] =
                    own.solve_lower_triangular(&sum).unwrap_or_default();
            }
        }
    }
}
