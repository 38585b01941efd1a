//! A map of straight walls that stays as small as the building.
//!
//! In: after each scan the straight pieces that it showed, with their uncertainty, and the paths of
//! its beams, all in the map frame. Out: the walls, as segments with the uncertainty of their
//! position.
//!
//! 1. A piece belongs to a wall that was seen from the same side, has the same direction, lies in
//!    the same place (within its gate, or within [`THICKNESS`]), and overlaps it or is at most
//!    [`GAP`] away along it.
//! 2. It corrects that wall by a Kalman filter in two numbers, the wall's direction and its offset
//!    from an anchor; and it extends the wall to where the piece was seen. A piece that belongs to
//!    no wall starts a new one, shown once it was seen often enough.
//! 3. Two walls that belong together by the same rule are merged. If two lie side by side nearer
//!    than [`MOST_OFFSET`] and were seen from the same side, one would hide the other: the one that
//!    is no longer seen while the other is was an error, and is removed.
//! 4. Each decimetre of a wall has a score. Being seen raises it, up to a bound; beams that pass
//!    through well beyond it lower it. Parts whose score falls to zero are cut away: from the end
//!    (the wall becomes shorter), from the middle (a door opened: two walls), or all of it
//!    (erased).
//!
//! Hence the number of walls is bounded by the building and not by the length of the run. The
//! source left this open (TDK 2016 §6.4); the rules for growing are those of its landmarks.

mod cover;
mod entry;
#[cfg(test)]
mod tests;

use nalgebra::Point2;

use crate::geom::Segment;
use entry::Entry;

/// Longer pieces are not walls but corrupt readings, and would use memory in proportion to their
/// length, m.
const LONGEST: f64 = 1000.0;

/// Largest squared Mahalanobis distance between a piece and its wall: 99.9 % of χ² with two degrees
/// of freedom.
const GATE: f64 = 13.8;
/// A piece nearer than this beside a wall belongs to it whatever the gate says, m.
const THICKNESS: f64 = 0.03;
/// A piece farther than this beside a wall does not belong to it, m: less than the thickness of a
/// partition.
const MOST_OFFSET: f64 = 0.08;
/// Largest gap along a wall that is bridged, m: less than any door.
const GAP: f64 = 0.25;
/// Pieces shorter than this are skipped, m.
const LEAST_LENGTH: f64 = 0.15;
/// How often a wall has to be seen before it is shown.
const CONFIRM: u32 = 3;
/// A wall that was not confirmed is forgotten when it was not seen for this many scans.
const FORGET: u32 = 50;
/// How far a beam has to go on behind a wall to count against it, m.
const BEYOND: f64 = 0.15;

/// A straight piece of wall as one scan showed it; map frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// The piece from end to end.
    pub seen: Segment,
    /// Standard deviation of its direction, rad.
    pub sigma_direction: f64,
    /// Standard deviation of its middle across it, m.
    pub sigma_across: f64,
    /// Where the sensor was; this side of the wall was seen.
    pub from: Point2<f64>,
}

/// A wall of the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// Its identifier, which is never reused.
    pub id: u32,
    /// Its ends; looking from `a` to `b`, the side from which it was seen is on the left.
    pub segment: Segment,
    /// Standard deviation of its direction, rad.
    pub sigma_direction: f64,
    /// Standard deviation of its middle across it, m.
    pub sigma_across: f64,
    /// How often it was seen.
    pub sightings: u32,
}

/// Walls that extend, confirm, merge and vanish; none by default.
#[derive(Clone, Debug, Default)]
pub struct VectorMap {
    entries: Vec<Entry>,
    next_id: u32,
    scans: u32,
}

impl VectorMap {
    /// Takes in one scan: the pieces it showed, and the paths of its beams from the sensor to their
    /// ends. Pieces with numbers that are not finite, without length or longer than a kilometre are
    /// skipped.
    pub fn observe(&mut self, sightings: &[Sighting], beams: &[[Point2<f64>; 2]]) {
        self.scans += 1;
        for sighting in sightings {
            if sighting.is_sound() && sighting.seen.length() >= LEAST_LENGTH {
                self.take(sighting);
            }
        }
        self.merge();
        self.drop_hidden();
        self.see_through(beams);
        let now = self.scans;
        self.entries
            .retain(|entry| entry.sightings >= CONFIRM || now - entry.last_seen <= FORGET);
    }

    /// The walls that were seen often enough, in the order in which they were found.
    #[must_use]
    pub fn walls(&self) -> Vec<Wall> {
        let is_shown =
            |entry: &&Entry| entry.sightings >= CONFIRM && entry.length() >= LEAST_LENGTH;
        self.entries
            .iter()
            .filter(is_shown)
            .map(Entry::wall)
            .collect()
    }

    fn take(&mut self, sighting: &Sighting) {
        let misfits = self.entries.iter().enumerate();
        let fitting = misfits.filter_map(|(i, entry)| Some((entry.misfit(sighting)?, i)));
        let best = fitting.min_by(|a, b| a.0.total_cmp(&b.0));
        match best {
            Some((_, best)) => self.entries[best].correct(sighting, self.scans),
            None => {
                let entry = Entry::new(self.next_id, sighting, self.scans);
                self.next_id += 1;
                self.entries.push(entry);
            }
        }
    }

    /// Merges walls that belong together, beginning with those of this scan: only they have moved.
    fn merge(&mut self) {
        let mut at = 0;
        while at < self.entries.len() {
            let entry = &self.entries[at];
            let is_news = entry.last_seen == self.scans;
            let same = |other: &Entry| entry.belongs_with(other);
            let other =
                (0..self.entries.len()).find(|&i| i != at && is_news && same(&self.entries[i]));
            let Some(other) = other else {
                at += 1;
                continue;
            };
            let (kept, gone) = (at.min(other), at.max(other));
            let mut gone = self.entries.remove(gone);
            let kept_entry = &mut self.entries[kept];
            // As in the comparison: the shorter is taken into the longer, under the older name.
            if gone.length() > kept_entry.length() {
                std::mem::swap(&mut gone, kept_entry);
                std::mem::swap(&mut gone.id, &mut kept_entry.id);
            }
            kept_entry.absorb(&gone);
            // A wall that has grown may now belong with others.
            at = kept;
        }
    }

    /// Drops walls that would be hidden by one that this scan saw.
    fn drop_hidden(&mut self) {
        let now = self.scans;
        let seen: Vec<Entry> = self
            .entries
            .iter()
            .filter(|e| e.last_seen == now)
            .cloned()
            .collect();
        self.entries.retain(|entry| {
            let is_unseen = now - entry.last_seen > FORGET;
            !(is_unseen && seen.iter().any(|front| front.lies_beside(entry)))
        });
    }

    /// Lets beams that went through walls wear them away.
    fn see_through(&mut self, beams: &[[Point2<f64>; 2]]) {
        for entry in &mut self.entries {
            entry.see_through(beams, self.scans);
        }
        let mut parts = vec![];
        for entry in self.entries.drain(..) {
            entry.split(&mut self.next_id, &mut parts);
        }
        self.entries = parts;
    }
}

impl Sighting {
    fn is_sound(&self) -> bool {
        let ends = [self.seen.a, self.seen.b, self.from];
        ends.iter().all(|p| p.x.is_finite() && p.y.is_finite())
            && self.sigma_direction.is_finite()
            && self.sigma_across.is_finite()
            && self.seen.length() > 0.0
            && self.seen.length() <= LONGEST
    }

    /// The piece directed so that the sensor was on its left.
    fn ordered(&self) -> Segment {
        let Segment { a, b } = self.seen;
        if (b - a).perp(&(self.from - a)) >= 0.0 {
            self.seen
        } else {
            Segment::new(b, a)
        }
    }
}
