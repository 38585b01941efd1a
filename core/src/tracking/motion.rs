//! Decides whether a track moves.
//!
//! In: the position of a track at each scan. Out: its state: new, moving, paused after it moved, or
//! standing ever since.
//!
//! Only sightings in free space count: where nothing is known, the end of a wall comes into sight
//! as fast as the robot drives. The velocity is the mean over the last [`WINDOW`] seconds, because
//! that of the newest instant is too uncertain: slow walkers would not seem to move. A track moves
//! if this velocity is significant by its covariance, and so exceeds the apparent motion of an edge
//! of which the robot comes to see another side.

use std::collections::VecDeque;

use nalgebra::{Matrix2, Point2};

use super::config::TrackingConfig;
use crate::geom::Length;

/// The velocity is the mean over this time, s, ...
const WINDOW: f64 = 2.0;
/// ... and over at least this time.
const SHORTEST: f64 = 0.3;
/// A track that moves has come this far in that time, m.
const LEAST_WAY: f64 = 0.2;
/// A track that was not seen to move for longer than this does not count as moving, s.
const SHORTLY: f64 = 1.0;
/// A track that moved is remembered as possibly moving on for this long for each scan that saw it
/// move, s: what only seemed to move is soon forgotten.
const PER_SIGHTING: f64 = 1.0;
/// A track that never moved counts as new for this long, s.
const NEW: f64 = 2.0;
/// Number of sightings before which nothing is decided.
const LEAST_SIGHTINGS: usize = 3;

/// The motion of a track.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrackMotion {
    /// It is too new to tell.
    New,
    /// It moves.
    Moving,
    /// It moved before and may move on.
    Paused,
    /// It was not seen to move for long: it belongs in the map.
    Standing,
}

/// The past of a track.
#[derive(Clone, Debug)]
pub(super) struct History {
    begun: f64,
    /// Time, position and its covariance in each scan that saw it in free space, the newest last.
    seen: VecDeque<(f64, Point2<f64>, Matrix2<f64>)>,
    sightings: usize,
    moved: Option<f64>,
    /// Number of scans in which it moved.
    moves_seen: u32,
    /// Whether its velocity was significant in the newest scan that saw it, and in the one before.
    is_significant: bool,
    moves: bool,
}

impl History {
    pub(super) fn begun(now: f64) -> Self {
        Self {
            begun: now,
            seen: VecDeque::new(),
            sightings: 0,
            moved: None,
            moves_seen: 0,
            is_significant: false,
            moves: false,
        }
    }

    /// Notes the position of a track seen in free space; a track that was not adds nothing new.
    pub(super) fn see(
        &mut self,
        now: f64,
        at: Point2<f64>,
        cov: Matrix2<f64>,
        config: &TrackingConfig,
    ) {
        self.sightings += 1;
        self.seen.retain(|(then, _, _)| now - then <= WINDOW);
        let moves = |(then, before, cov_before): &(f64, Point2<f64>, Matrix2<f64>)| {
            let way = at - before;
            let inverse = (cov + cov_before).try_inverse();
            let d2 = inverse.map_or(0.0, |inverse| way.dot(&(inverse * way)));
            now - then >= SHORTEST && way.length() > LEAST_WAY && d2 > config.significance
        };
        let is_significant =
            self.sightings >= LEAST_SIGHTINGS && self.seen.front().is_some_and(moves);
        let before = std::mem::replace(&mut self.is_significant, is_significant);
        self.moves = is_significant && before;
        if self.moves {
            self.moved = Some(now);
            self.moves_seen += 1;
        }
        self.seen.push_back((now, at, cov));
    }

    /// Whether it moves, or may move on.
    pub(super) fn moved_lately(&self, now: f64, config: &TrackingConfig) -> bool {
        let memory = config.memory.min(PER_SIGHTING * f64::from(self.moves_seen));
        self.moved
            .is_some_and(|moved| now - moved <= memory.max(SHORTLY))
    }

    pub(super) fn motion(&self, now: f64, config: &TrackingConfig) -> TrackMotion {
        match self.moved {
            Some(moved) if self.moves && now - moved <= SHORTLY => TrackMotion::Moving,
            _ if self.moved_lately(now, config) => TrackMotion::Paused,
            None if now - self.begun <= NEW => TrackMotion::New,
            _ => TrackMotion::Standing,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::gaussian_pair;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    const STEP: f64 = 0.2;

    /// The motion, scan by scan, of a track at `x(seconds)`, known to 5 cm.
    fn motions(x: impl Fn(f64) -> f64, scans: usize, seed: u64) -> Vec<TrackMotion> {
        let config = TrackingConfig::default();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut history = History::begun(0.0);
        let each = |number: usize| {
            let now = number as f64 * STEP;
            let (a, b) = gaussian_pair(&mut rng);
            let at = Point2::new(x(now) + 0.05 * a, 0.05 * b);
            history.see(now, at, Matrix2::identity() * 0.0025, &config);
            history.motion(now, &config)
        };
        (0..scans).map(each).collect()
    }

    #[test]
    fn who_walks_moves_and_who_stops_may_move_on_for_a_while() {
        for seed in 0..20 {
            // Walks 0.5 m/s for 4 s, then stands.
            let found = motions(|t| 0.5 * t.min(4.0), 110, seed);
            assert_eq!(found[1], TrackMotion::New);
            assert!(
                found[9..20].iter().all(|m| *m == TrackMotion::Moving),
                "{found:?}"
            );
            assert!(
                found[35..80].iter().all(|m| *m == TrackMotion::Paused),
                "{found:?}"
            );
            // 15 s after it was last seen to move.
            assert_eq!(found[109], TrackMotion::Standing, "{seed}");
        }
    }

    #[test]
    fn what_stands_moves_hardly_ever_whatever_the_noise() {
        let mut moving = 0;
        for seed in 0..100 {
            let found = motions(|_| 0.0, 60, seed);
            moving += usize::from(found.contains(&TrackMotion::Moving));
            if !found.contains(&TrackMotion::Moving) {
                assert_eq!(found[5], TrackMotion::New);
                assert_eq!(found[59], TrackMotion::Standing);
            }
        }
        // One in a thousand of 6000 scans is significant, and two in a row far fewer; exceptions
        // are scans that share an outlier as the oldest position.
        assert!(moving <= 3, "{moving} of 100 seemed to move");
    }
}
