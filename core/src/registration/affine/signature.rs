//! Moments of a whitened cloud, by which two clouds are compared whichever way they are turned.
//!
//! With z = x + iy of each point, m_kl is the mean of zᵏ z̄ˡ. A turn by α multiplies m_kl by
//! e^{i(k-l)α}; a reflection y ↦ -y conjugates it.

use nalgebra::Complex;

use super::Turn;
use crate::geom::sin_cos;

/// Orders k + l that are compared.
const ORDERS: std::ops::RangeInclusive<usize> = 3..=6;

/// The moments with k ≥ l: the others are their conjugates.
#[derive(Clone, Debug)]
pub(super) struct Signature {
    moments: Vec<Moment>,
}

#[derive(Clone, Copy, Debug)]
struct Moment {
    k: usize,
    l: usize,
    /// m_kl.
    value: Complex<f64>,
    /// Mean of |z|ᵏ⁺ˡ: the largest possible |m_kl|.
    most: f64,
}

impl Signature {
    pub(super) fn of(points: &[Complex<f64>]) -> Self {
        let orders = ORDERS.flat_map(|order| (0..=order / 2).map(move |l| (order - l, l)));
        let moment = |(k, l): (usize, usize)| {
            let (mut value, mut most) = (Complex::new(0.0, 0.0), 0.0);
            for z in points {
                let squared = z.norm_sqr();
                // zᵏ z̄ˡ = z^(k-l) |z|²ˡ.
                let length = (0..l).fold(1.0, |product, _| product * squared);
                let power = power(*z, k - l) * length;
                value += power;
                most += power.norm_sqr().sqrt();
            }
            let count = points.len() as f64;
            Moment {
                k,
                l,
                value: value / count,
                most: most / count,
            }
        };
        Self {
            moments: orders.map(moment).collect(),
        }
    }

    /// m_kl; zero where it was not computed.
    pub(super) fn moment(&self, k: usize, l: usize) -> Complex<f64> {
        let found = self.moments.iter().find(|m| (m.k, m.l) == (k, l));
        found.map_or(Complex::new(0.0, 0.0), |m| m.value)
    }

    /// How far the other cloud's moments are from these after a turn: the root mean square of the
    /// differences, each as a part of the largest possible value.
    pub(super) fn disagreement(&self, other: &Self, turn: &Turn) -> f64 {
        let squares = self.moments.iter().zip(&other.moments).map(|(p, q)| {
            let (sin, cos) = sin_cos((p.k - p.l) as f64 * turn.angle);
            let turned = Complex::new(cos, sin) * turn.before(p.value);
            (q.value - turned).norm_sqr() / (p.most * q.most)
        });
        (squares.sum::<f64>() / self.moments.len() as f64).sqrt()
    }
}

impl Turn {
    /// A number, or its complex conjugate if the turn reflects.
    pub(super) fn before(&self, value: Complex<f64>) -> Complex<f64> {
        if self.is_reflected {
            value.conj()
        } else {
            value
        }
    }
}

/// zⁿ.
pub(super) fn power(z: Complex<f64>, n: usize) -> Complex<f64> {
    (0..n).fold(Complex::new(1.0, 0.0), |product, _| product * z)
}
