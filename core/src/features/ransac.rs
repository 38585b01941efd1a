//! Lines by random samples: the line through two points that most neighbours lie on, then the next
//! one among the rest.
//!
//! 1. Two points of an interval are drawn; their score is the longest stretch of points near the
//!    line through them ([`super::consensus`]).
//! 2. That is repeated N = log(1 - p) / log(1 - u²) times, u being the part of the interval in the
//!    best stretch so far: with probability p, at least one pair lay entirely on it. N shrinks as
//!    better lines are found.
//! 3. The best line is refined and its points are removed; what remains of the interval before and
//!    after it become intervals of their own.
//!
//! Source: Fischler & Bolles (1981), "Random sample consensus"; Pilch 2016 §1.2.1, eq. (1.2)-(1.3),
//! with m = 2. Pilch notes that the data must contain only one model. Removing points, and
//! intervals that end where neighbours do not belong together, lift this limit. The generator is
//! seeded anew for each scan, so a scan always gives the same lines.

use std::ops::Range;

use nalgebra::Vector2;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::columns::Columns;
use super::consensus::{is_near, longest_stretch, refined, settle_borders};
use super::piece::Piece;
use crate::bounds::config;
use crate::geom::Length;

config! {
    /// How lines are looked for by random samples.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Ransac {
        /// A point is on a line within so many standard deviations. Default 3. Larger: shallow
        /// corners stay undetected.
        pub inlier_sigmas: f64 = 3.0,
        /// p: the probability with which one pair at least lies on the longest wall. Default 0.99.
        /// Larger: more samples, fewer walls overlooked.
        pub confidence: f64 = 0.99,
        /// Most samples for a line. Default 500: enough where a wall has a tenth of the points.
        pub max_samples: u32 = 500,
        /// Seed of the samples. Default 1.
        pub seed: u32 = 1,
    }
}

impl Ransac {
    /// Splits a run of points; `pieces` receives its lines in order, each of at least `few` points.
    pub(super) fn split(
        &self,
        columns: &mut Columns,
        run: Range<usize>,
        few: usize,
        rng: &mut ChaCha8Rng,
        pieces: &mut Vec<Piece>,
    ) {
        let first = pieces.len();
        let mut intervals = vec![run];
        while let Some(interval) = intervals.pop() {
            if interval.len() < few {
                continue;
            }
            let Some([a, b]) = self.best_pair(columns, &interval, rng) else {
                continue;
            };
            let near = |index| {
                line_through(columns, a, b).is_some_and(|(normal, r)| {
                    is_near(columns, index, (&normal, r), self.inlier_sigmas, 0.0)
                })
            };
            let limits = (self.inlier_sigmas, few);
            if let Some(found) = refined(columns, &interval, limits, |_| true, near) {
                let range = found.stretch.range.clone();
                intervals.push(interval.start..range.start);
                intervals.push(range.end..interval.end);
                pieces.push(found.take(columns, self.inlier_sigmas));
            }
        }
        let own = pieces.get_mut(first..).unwrap_or_default();
        own.sort_by_key(|piece| piece.start);
        settle_borders(columns, own, few);
    }

    /// Steps 1 and 2.
    fn best_pair(
        &self,
        columns: &Columns,
        interval: &Range<usize>,
        rng: &mut ChaCha8Rng,
    ) -> Option<[usize; 2]> {
        let n = u32::try_from(interval.len()).ok()?;
        let (mut best, mut most, mut needed) = (None, 0, f64::from(self.max_samples));
        let mut drawn = 0.0;
        while drawn < needed {
            drawn += 1.0;
            // Any two different points, each pair equally likely.
            let (i, j) = (rng.random_range(0..n), rng.random_range(0..n - 1));
            let j = if j < i { j } else { j + 1 };
            let [a, b] = [i, j].map(|offset| interval.start + offset as usize);
            let Some((normal, r)) = line_through(columns, a, b) else {
                continue;
            };
            let near = |index| is_near(columns, index, (&normal, r), self.inlier_sigmas, 0.0);
            let stretch = longest_stretch(interval.clone(), near);
            if stretch.n_inliers > most {
                (best, most) = (Some([a, b]), stretch.n_inliers);
                needed = needed.min(self.samples(most as f64 / f64::from(n)));
            }
        }
        best
    }

    /// N for a part u of inliers.
    fn samples(&self, u: f64) -> f64 {
        let miss = 1.0 - u * u;
        if miss <= 0.0 {
            return 1.0;
        }
        (libm::log(1.0 - self.confidence) / libm::log(miss)).ceil()
    }
}

/// Normal and signed distance of the line through two points; `None` if they coincide.
fn line_through(columns: &Columns, a: usize, b: usize) -> Option<(Vector2<f64>, f64)> {
    let (a, b) = (columns.point(a), columns.point(b));
    let along = b - a;
    let length = along.length();
    (length > 0.0).then(|| {
        let normal = Vector2::new(-along.y, along.x) / length;
        (normal, normal.dot(&a.coords))
    })
}

#[cfg(test)]
mod tests;
