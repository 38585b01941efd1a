//! Which parts of a wall exist: a score for each decimetre along it.

use std::collections::BTreeMap;

/// Length of a part, m.
const PART: f64 = 0.1;
/// Added to a part's score when it is seen, and the upper bound of scores: this many scans with
/// beams through it remove a wall.
const SEEN: i32 = 3;
const MOST: i32 = 30;

/// Scores of the parts of a wall, by their number along it.
#[derive(Clone, Debug, Default)]
pub(super) struct Cover {
    scores: BTreeMap<i32, i32>,
}

fn part_at(along: f64) -> i32 {
    (along / PART).floor() as i32
}

impl Cover {
    /// Marks the parts from `low` to `high`, m along the wall, as seen.
    pub(super) fn see(&mut self, [low, high]: [f64; 2]) {
        for part in part_at(low)..=part_at(high) {
            let score = self.scores.entry(part).or_insert(0);
            *score = (*score + SEEN).min(MOST);
        }
    }

    /// Notes that something was seen behind the wall through the parts at `along`.
    pub(super) fn see_through(&mut self, along: impl Iterator<Item = f64>) {
        let mut parts: Vec<i32> = along.map(part_at).collect();
        parts.sort_unstable();
        parts.dedup();
        for part in parts {
            if let Some(score) = self.scores.get_mut(&part) {
                *score -= 1;
            }
        }
        self.scores.retain(|_, score| *score > 0);
    }

    /// Takes over the parts of another wall, whose point at `along` lies at `map(along)` here.
    pub(super) fn absorb(&mut self, other: &Self, map: impl Fn(f64) -> f64) {
        for (&part, &score) in &other.scores {
            let middle = (f64::from(part) + 0.5) * PART;
            let own = self.scores.entry(part_at(map(middle))).or_insert(0);
            *own = (*own).max(score);
        }
    }

    /// The stretches that exist, separated where more than `gap` metres are missing; none is empty.
    pub(super) fn stretches(&self, gap: f64) -> Vec<[f64; 2]> {
        let mut stretches: Vec<[f64; 2]> = vec![];
        for &part in self.scores.keys() {
            let (low, high) = (f64::from(part) * PART, f64::from(part + 1) * PART);
            match stretches.last_mut() {
                Some(last) if low - last[1] <= gap => last[1] = high,
                _ => stretches.push([low, high]),
            }
        }
        stretches
    }

    /// The parts within a stretch.
    pub(super) fn within(&self, [low, high]: [f64; 2]) -> Self {
        let parts = self.scores.range(part_at(low)..=part_at(high));
        Self {
            scores: parts.map(|(&part, &score)| (part, score)).collect(),
        }
    }
}
