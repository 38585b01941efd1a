//! One wall: direction and offset from an anchor with their covariance, its ends, and which parts
//! of it exist.

use nalgebra::{Matrix2, Point2, RowVector2, Vector2};

use super::cover::Cover;
use super::{BEYOND, GAP, GATE, LEAST_LENGTH, MOST_OFFSET, Sighting, THICKNESS, Wall};
use crate::geom::{Length, Segment, sin_cos, symmetrize, wrap};

/// Error of a sighting beyond its own covariance, because the pose has errors too: rad and m.
const LEAST_SIGMA: [f64; 2] = [0.004, 0.005];
/// Additional uncertainty of a wall's direction and offset at each sighting, so that new sightings
/// keep their weight, also after a correction of the pose. rad and m.
const DRIFT: [f64; 2] = [0.0004, 0.0007];
/// Pieces whose direction differs by more than this plus two of their standard deviations do not
/// belong to a wall, rad.
const LARGEST_TURN: f64 = 0.1;
/// Beams that run along a wall rather than across it say nothing about it: least sine of the angle
/// between them.
const LEAST_CROSSING: f64 = 0.25;

#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) id: u32,
    /// Fixed reference point.
    anchor: Point2<f64>,
    /// Direction of the wall; the side that it was seen from is on the left.
    direction: f64,
    /// Offset of the wall from the anchor, to the left, m.
    offset: f64,
    /// Covariance of direction and offset.
    cov: Matrix2<f64>,
    /// Both ends, m along the wall from the anchor.
    extent: [f64; 2],
    cover: Cover,
    pub(super) sightings: u32,
    /// Number of the last scan that saw it.
    pub(super) last_seen: u32,
}

/// A piece compared with a wall.
struct Seen {
    /// Direction and offset of the piece minus the wall's own.
    residual: Vector2<f64>,
    /// Jacobian of the residual by the wall's direction and offset.
    jacobian: Matrix2<f64>,
    /// Variances of the piece's direction and of the offset at its middle.
    noise: Matrix2<f64>,
    extent: [f64; 2],
}

impl Entry {
    pub(super) fn new(id: u32, sighting: &Sighting, scan: u32) -> Self {
        let seen = sighting.ordered();
        let half = 0.5 * seen.length();
        let along = seen.vector();
        let mut entry = Self {
            id,
            anchor: seen.a + along * 0.5,
            direction: seen.heading(),
            offset: 0.0,
            cov: noise_of(sighting),
            extent: [-half, half],
            cover: Cover::default(),
            sightings: 1,
            last_seen: scan,
        };
        entry.cover.see(entry.extent);
        entry
    }

    fn axes(&self) -> (Vector2<f64>, Vector2<f64>) {
        let (sin, cos) = sin_cos(self.direction);
        (Vector2::new(cos, sin), Vector2::new(-sin, cos))
    }

    fn point(&self, along: f64) -> Point2<f64> {
        let (tangent, normal) = self.axes();
        self.anchor + tangent * along + normal * self.offset
    }

    pub(super) fn length(&self) -> f64 {
        self.extent[1] - self.extent[0]
    }

    pub(super) fn wall(&self) -> Wall {
        let middle = 0.5 * (self.extent[0] + self.extent[1]);
        let row = RowVector2::new(middle, 1.0);
        Wall {
            id: self.id,
            segment: Segment::new(self.point(self.extent[0]), self.point(self.extent[1])),
            sigma_direction: self.cov[(0, 0)].max(0.0).sqrt(),
            sigma_across: (row * self.cov * row.transpose())[0].max(0.0).sqrt(),
            sightings: self.sightings,
        }
    }

    /// Compares a piece on the same side with about the same direction; `None` for all others.
    fn compare(&self, sighting: &Sighting) -> Option<Seen> {
        let seen = sighting.ordered();
        let along = seen.vector();
        let noise = noise_of(sighting);
        let turn = wrap(seen.heading() - self.direction);
        if turn.abs() > LARGEST_TURN + 2.0 * noise[(0, 0)].sqrt() {
            return None;
        }
        let (tangent, normal) = self.axes();
        let to_middle = seen.a + along * 0.5 - self.anchor;
        let ends = [seen.a, seen.b].map(|end| (end - self.anchor).dot(&tangent));
        Some(Seen {
            residual: Vector2::new(turn, to_middle.dot(&normal) - self.offset),
            // The middle lies at n · m = offset; turning the wall by δ moves it by (t · m) δ.
            jacobian: Matrix2::new(1.0, 0.0, to_middle.dot(&tangent), 1.0),
            noise,
            extent: [ends[0].min(ends[1]), ends[0].max(ends[1])],
        })
    }

    /// Squared Mahalanobis distance of a piece that belongs to this wall; `None` if it does not
    /// belong.
    pub(super) fn misfit(&self, sighting: &Sighting) -> Option<f64> {
        let seen = self.compare(sighting)?;
        self.misfit_of(&seen)
    }

    fn misfit_of(&self, seen: &Seen) -> Option<f64> {
        let gap = (seen.extent[0] - self.extent[1]).max(self.extent[0] - seen.extent[1]);
        let aside = seen.residual.y.abs();
        if gap > GAP || aside > MOST_OFFSET {
            return None;
        }
        let spread = seen.jacobian * self.cov * seen.jacobian.transpose() + seen.noise;
        let d2 = (seen.residual.transpose() * spread.try_inverse()? * seen.residual)[0];
        (d2 <= GATE || aside <= THICKNESS).then_some(d2)
    }

    /// Takes in a piece that belongs to this wall.
    pub(super) fn correct(&mut self, sighting: &Sighting, scan: u32) {
        let Some(seen) = self.compare(sighting) else {
            return;
        };
        self.cov += Matrix2::from_diagonal(&Vector2::from(DRIFT.map(|s| s * s)));
        self.fuse(&seen);
        self.cover.see(seen.extent);
        self.sightings += 1;
        self.last_seen = scan;
    }

    fn fuse(&mut self, seen: &Seen) {
        let h = seen.jacobian;
        let spread = h * self.cov * h.transpose() + seen.noise;
        let Some(inverse) = spread.try_inverse() else {
            return;
        };
        let gain = self.cov * h.transpose() * inverse;
        let change = gain * seen.residual;
        self.direction = wrap(self.direction + change.x);
        self.offset += change.y;
        let left = Matrix2::identity() - gain * h;
        self.cov = left * self.cov * left.transpose() + gain * seen.noise * gain.transpose();
        symmetrize(&mut self.cov);
        self.extent = [
            self.extent[0].min(seen.extent[0]),
            self.extent[1].max(seen.extent[1]),
        ];
    }

    fn as_sighting(&self) -> Sighting {
        let wall = self.wall();
        let (_, normal) = self.axes();
        Sighting {
            seen: wall.segment,
            sigma_direction: wall.sigma_direction,
            sigma_across: wall.sigma_across,
            from: wall.segment.a + wall.segment.vector() * 0.5 + normal,
        }
    }

    /// Whether another wall is a part of this one.
    pub(super) fn belongs_with(&self, other: &Self) -> bool {
        // The shorter one is compared with the longer: its direction is less certain.
        let (long, short) = match self.length() >= other.length() {
            true => (self, other),
            false => (other, self),
        };
        let seen = long.compare(&short.as_sighting());
        seen.is_some_and(|seen| long.misfit_of(&seen).is_some())
    }

    /// Whether another wall lies beside this one over at least half of its length, so near that it
    /// cannot be another wall.
    pub(super) fn lies_beside(&self, other: &Self) -> bool {
        self.compare(&other.as_sighting()).is_some_and(|seen| {
            let overlap = seen.extent[1].min(self.extent[1]) - seen.extent[0].max(self.extent[0]);
            seen.residual.y.abs() <= MOST_OFFSET && overlap >= 0.5 * other.length()
        })
    }

    /// Merges with a wall that belongs with it.
    pub(super) fn absorb(&mut self, other: &Self) {
        let Some(seen) = self.compare(&other.as_sighting()) else {
            return;
        };
        self.fuse(&seen);
        let (tangent, _) = self.axes();
        self.cover.absorb(&other.cover, |along| {
            (other.point(along) - self.anchor).dot(&tangent)
        });
        // Parts of one wall that was cut carry the same sightings.
        self.sightings = self.sightings.max(other.sightings);
        self.last_seen = self.last_seen.max(other.last_seen);
    }

    /// Lowers the score of parts through which beams went on for `beyond` metres, but not where
    /// this scan saw the wall.
    pub(super) fn see_through(&mut self, beams: &[[Point2<f64>; 2]], scan: u32) {
        if self.last_seen == scan && self.sightings < 2 {
            return;
        }
        let (tangent, normal) = self.axes();
        let crossing = |&[from, to]: &[Point2<f64>; 2]| {
            let way = to - from;
            let length = way.length();
            let across = way.dot(&normal);
            if across.abs() < LEAST_CROSSING * length || length <= 0.0 {
                return None;
            }
            let part = (self.offset - (from - self.anchor).dot(&normal)) / across;
            let behind = (1.0 - part) * length;
            let along = (from + way * part - self.anchor).dot(&tangent);
            let is_through = part > 0.0 && behind > BEYOND;
            let is_within = along >= self.extent[0] && along <= self.extent[1];
            (is_through && is_within).then_some(along)
        };
        let through: Vec<f64> = beams.iter().filter_map(crossing).collect();
        self.cover.see_through(through.into_iter());
    }

    /// What remains of it: the wall itself, a shorter one, two, or nothing.
    pub(super) fn split(self, next_id: &mut u32, parts: &mut Vec<Self>) {
        let stretches = self.cover.stretches(GAP);
        for (number, stretch) in stretches.into_iter().enumerate() {
            // Ends are finer than parts, unless parts were cut away.
            let extent = [
                self.extent[0].max(stretch[0]),
                self.extent[1].min(stretch[1]),
            ];
            if extent[1] - extent[0] < 0.5 * LEAST_LENGTH {
                continue;
            }
            let mut part = self.clone();
            if number > 0 {
                part.id = *next_id;
                *next_id += 1;
            }
            part.cover = self.cover.within(stretch);
            part.extent = extent;
            parts.push(part);
        }
    }
}

fn noise_of(sighting: &Sighting) -> Matrix2<f64> {
    let [direction, across] = LEAST_SIGMA;
    let squared = |sigma: f64, least: f64| sigma * sigma + least * least;
    Matrix2::from_diagonal(&Vector2::new(
        squared(sighting.sigma_direction, direction),
        squared(sighting.sigma_across, across),
    ))
}
