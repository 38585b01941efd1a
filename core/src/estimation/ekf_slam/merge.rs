//! Step 5: merges two landmarks that are one wall.
//!
//! In: the landmarks that this scan saw. Out: fewer landmarks, and a better estimate of all of
//! them.
//!
//! 1. Two landmarks are compared only if their known parts overlap or nearly touch, by the rule
//!    that matches sightings (`max_gap`).
//! 2. Their difference in (α, r) is taken about a point between the parts, with its covariance from
//!    the 4x4 block of P: landmarks seen from one pose share its error, and their difference is
//!    much more certain than each of them.
//! 3. They are one if the difference is compatible with zero, d² within the gate, and known to be
//!    small: landmarks that are merely not known well enough to tell apart stay apart until they
//!    are. Lines beside the known part of a wall are matched by the same rule. Two that differ in
//!    the mean of many sightings and yet lie on each other within less than the thickness of a wall
//!    are one wall too, one of which was made from lines corrupted by something else (a pillar in
//!    front of it, a corner). Then the one that was seen less is dropped, and nothing is learnt
//!    from it.
//! 4. That they are one is a measurement without noise: the difference is zero. The update moves
//!    everything that is correlated with it (a loop closes here too); then the younger one's rows
//!    and columns are removed, which leaves the marginal of a Gaussian.

use nalgebra::{Matrix2, Point2, SMatrix, Vector2};

use super::landmark::{Entry, hull};
use super::{EkfSlam, Merged};
use crate::features::LineFeature;
use crate::geom::{sin_cos, wrap};

/// What the known parts of two landmarks share.
struct Shared {
    /// The middle of the overlap, or of the gap.
    about: Point2<f64>,
    /// Length of the overlap, m; negative for a gap.
    overlap: f64,
    /// The largest distance of the two lines there, m.
    off: f64,
}

/// How two landmarks differ.
struct Difference {
    /// Whether the covariance allows them to be one wall, and they are known to be; otherwise they
    /// at most lie on each other.
    is_joined: bool,
    v: Vector2<f64>,
    cov: Matrix2<f64>,
    d2: f64,
    columns: [(usize, [f64; 2]); 4],
}

impl EkfSlam {
    /// Whether this scan has already shown this part of a landmark.
    pub(super) fn is_taken(&self, landmark: usize, seen: &LineFeature) -> bool {
        let entry = &self.landmarks[landmark];
        if entry.last_seen != self.scans {
            return false;
        }
        let [from, to] = entry.extent_of(seen, &self.pose);
        let shared = self.config.merge.shared;
        from < entry.seen_now[1] - shared && to > entry.seen_now[0] + shared
    }

    /// Step 5, for each landmark that this scan saw.
    pub(super) fn merge_all(&mut self) {
        // From the youngest on, so that the remaining indices stay valid.
        for landmark in (0..self.landmarks.len()).rev() {
            let was_seen = |entry: &Entry| entry.last_seen == self.scans;
            if self.landmarks.get(landmark).is_some_and(was_seen)
                && let Some((other, difference)) = self.twin(landmark)
            {
                self.merge(landmark, other, &difference);
            }
        }
    }

    /// The likeliest landmark that is surely the same wall.
    fn twin(&self, landmark: usize) -> Option<(usize, Difference)> {
        let is_wall = |entry: &Entry| entry.sightings >= self.config.confirm_sightings;
        let own = self.landmarks.get(landmark).filter(|e| is_wall(e))?;
        let own = Placed::of(own);
        let mut best: Option<(usize, Difference)> = None;
        for (index, entry) in self.landmarks.iter().enumerate() {
            if index == landmark || !is_wall(entry) {
                continue;
            }
            let Some(shared) = self.between(&own, entry) else {
                continue;
            };
            let difference = self.difference(landmark, index, shared.about);
            let is_one = difference.is_joined || self.is_double(&shared, &difference);
            if is_one && best.as_ref().is_none_or(|b| difference.d2 < b.1.d2) {
                best = Some((index, difference));
            }
        }
        best
    }

    /// What two landmarks share; `None` if the gap is too large, or if direction or distance rule
    /// out that they are one.
    fn between(&self, a: &Placed, b: &Entry) -> Option<Shared> {
        let merge = &self.config.merge;
        if wrap(a.entry.line[0] - b.line[0]).abs() > merge.max_turn {
            return None;
        }
        let b = Placed::of(b);
        let along = |end: Point2<f64>| a.tangent.dot(&(end - a.entry.anchor));
        let [from, to] = b.entry.extent.map(|end| along(b.foot + b.tangent * end));
        let known = a.entry.extent;
        let (low, high) = (known[0].max(from.min(to)), known[1].min(from.max(to)));
        if low - high > self.config.association.max_gap {
            return None;
        }
        let off = |along: f64| {
            let point = a.foot + a.tangent * along;
            (b.distance(point) - a.distance(point)).abs()
        };
        let middle = 0.5 * (low + high);
        (off(middle) <= merge.r).then(|| Shared {
            about: a.foot + a.tangent * middle,
            overlap: high - low,
            off: off(low).max(off(high)),
        })
    }

    /// `other` minus `landmark`, (α, r) with r counted from `about`.
    fn difference(&self, landmark: usize, other: usize, about: Point2<f64>) -> Difference {
        let (a, b) = (&self.landmarks[landmark], &self.landmarks[other]);
        let lever = |entry: &Entry| {
            let (sin, cos) = sin_cos(self.linearised_alpha(entry));
            Vector2::new(-sin, cos).dot(&(entry.anchor - about))
        };
        let v = Vector2::new(
            wrap(b.line[0] - a.line[0]),
            Placed::of(a).distance(about) - Placed::of(b).distance(about),
        );
        let (i, j) = (a.row, b.row);
        let columns = [
            (i, [-1.0, -lever(a)]),
            (i + 1, [0.0, -1.0]),
            (j, [1.0, lever(b)]),
            (j + 1, [0.0, 1.0]),
        ];
        let h = SMatrix::<f64, 2, 4>::from_fn(|row, k| columns[k].1[row]);
        let p = SMatrix::<f64, 4, 4>::from_fn(|k, l| self.cov.get(columns[k].0, columns[l].0));
        let cov = h * p * h.transpose();
        let d2 = cov
            .cholesky()
            .map_or(f64::INFINITY, |c| v.dot(&c.solve(&v)));
        let merge = &self.config.merge;
        Difference {
            is_joined: d2 <= merge.gate
                && merge.is_small(v.x, cov[(0, 0)], merge.alpha)
                && merge.is_small(v.y, cov[(1, 1)], merge.r),
            v,
            cov,
            d2,
            columns,
        }
    }

    /// Whether two lie on each other, whatever their directions: over a short wall, a corrupted
    /// line may cross it at a large angle.
    fn is_double(&self, shared: &Shared, difference: &Difference) -> bool {
        let merge = &self.config.merge;
        difference.d2.is_finite()
            && shared.overlap >= merge.doubled
            && merge.is_small(shared.off, difference.cov[(1, 1)], merge.r)
    }

    /// Merges two: the older one stays, or the one seen more often if they do not agree.
    fn merge(&mut self, landmark: usize, other: usize, difference: &Difference) {
        // The measurement is zero, so the innovation is minus the difference.
        let v = -difference.v;
        if difference.is_joined && !self.absorb(&v, &difference.cov, &difference.columns) {
            return;
        }
        let (own, twin) = (&self.landmarks[landmark], &self.landmarks[other]);
        let stays = if difference.is_joined {
            own.id < twin.id
        } else {
            own.sightings >= twin.sightings
        };
        let (kept, gone) = if stays {
            (landmark, other)
        } else {
            (other, landmark)
        };
        let entry = self.landmarks.remove(gone);
        self.remove_rows(entry.row);
        let stays = &mut self.landmarks[if gone < kept { kept - 1 } else { kept }];
        let tangent = stays.tangent();
        let shifted = |extent: [f64; 2]| {
            let foot = tangent.dot(&(entry.anchor - stays.anchor));
            extent.map(|along| along + foot)
        };
        let (extent, seen_now) = (shifted(entry.extent), shifted(entry.seen_now));
        stays.extent = hull(stays.extent, extent);
        stays.seen_now = match stays.last_seen.cmp(&entry.last_seen) {
            std::cmp::Ordering::Less => seen_now,
            std::cmp::Ordering::Equal => hull(stays.seen_now, seen_now),
            std::cmp::Ordering::Greater => stays.seen_now,
        };
        stays.sightings += entry.sightings;
        stays.last_seen = stays.last_seen.max(entry.last_seen);
        self.report.merged.push(Merged {
            kept: stays.id,
            gone: entry.id,
            d2: difference.d2,
            is_joined: difference.is_joined,
        });
    }
}

/// A landmark with its axes; sine and cosine are computed only once.
struct Placed<'a> {
    entry: &'a Entry,
    tangent: Vector2<f64>,
    normal: Vector2<f64>,
    /// The foot of the anchor on the line.
    foot: Point2<f64>,
}

impl<'a> Placed<'a> {
    fn of(entry: &'a Entry) -> Self {
        let tangent = entry.tangent();
        let normal = Vector2::new(tangent.y, -tangent.x);
        Self {
            entry,
            tangent,
            normal,
            foot: entry.anchor + normal * entry.line[1],
        }
    }

    /// Signed distance of a point from the line, along its normal.
    fn distance(&self, point: Point2<f64>) -> f64 {
        self.normal.dot(&(point - self.entry.anchor)) - self.entry.line[1]
    }
}

#[cfg(test)]
mod tests;
