//! The turn that makes the third moments of two whitened clouds agree best.
//!
//! The third moments are a symmetric tensor; its part m_30 turns by 3α, its part m_21 by α, and the
//! square of its length is |m_30|²/4 + 3|m_21|²/4. With p and q of the two clouds, the difference
//! is least where
//!
//! ```text
//! f(α) = Re(e^{3iα} p_30 q̄_30) / 4 + 3 Re(e^{iα} p_21 q̄_21) / 4
//! ```
//!
//! is largest: a curve with at most three maxima.
//!
//! Source: Heikkilä (2004). His J(α) sums the four moments unweighted, so if the clouds differ, its
//! minimum depends on the axes.

use std::f64::consts::TAU;

use super::Turn;
use super::signature::Signature;
use crate::geom::sin_cos;

/// Places where the search for a maximum starts: eight for the narrowest of them.
const PLACES: u32 = 24;
/// Steps of Newton's method from each place; every step doubles the correct digits.
const STEPS: usize = 8;
/// Third moments that are smaller than this determine no rotation.
const NOTHING: f64 = 1e-6;

/// The best turn without a reflection and the best one with it; none if the moments determine none.
pub(super) fn turns(p: &Signature, q: &Signature) -> Vec<Turn> {
    let turn = |is_reflected| {
        let unturned = Turn {
            angle: 0.0,
            is_reflected,
        };
        let thrice = unturned.before(p.moment(3, 0)) * q.moment(3, 0).conj() * 0.25;
        let once = unturned.before(p.moment(2, 1)) * q.moment(2, 1).conj() * 0.75;
        if thrice.norm_sqr() + once.norm_sqr() < NOTHING * NOTHING {
            return None;
        }
        // f and its first two derivatives.
        let at = |angle: f64| {
            let ((s1, c1), (s3, c3)) = (sin_cos(angle), sin_cos(3.0 * angle));
            let (re1, im1) = (c1 * once.re - s1 * once.im, c1 * once.im + s1 * once.re);
            let (re3, im3) = (
                c3 * thrice.re - s3 * thrice.im,
                c3 * thrice.im + s3 * thrice.re,
            );
            [re1 + re3, -im1 - 3.0 * im3, -re1 - 9.0 * re3]
        };
        let places = (0..PLACES).map(|place| TAU * f64::from(place) / f64::from(PLACES));
        let mut angle = places.max_by(|a, b| at(*a)[0].total_cmp(&at(*b)[0]))?;
        for _ in 0..STEPS {
            let [_, slope, bend] = at(angle);
            // At a maximum the curve bends down.
            if bend < 0.0 {
                angle -= slope / bend;
            }
        }
        Some(Turn {
            angle,
            is_reflected,
        })
    };
    [false, true].into_iter().filter_map(turn).collect()
}
