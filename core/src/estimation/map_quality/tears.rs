//! From pairs of submaps that are witnesses to the places where the map is torn.
//!
//! Witnesses are grouped if they are near one another in the map and would move its parts in the
//! same direction: two pieces of furniture do not agree on that, two sides of a tear do. A single
//! witness does not count, unless nothing else explains it.

use nalgebra::{Point2, Vector2};

use super::{Placed, TORN_BEYOND, Tear, TearKind};
use crate::geom::Length;
use crate::robot::Stamp;

/// Witnesses within this distance count for one tear, m: about a room.
const ONE_PLACE: f64 = 5.0;
/// The least number of witnesses of a tear.
const LEAST_WITNESSES: usize = 2;

/// A pair of submaps that does not agree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Witness {
    /// The older first.
    pub(super) submaps: [usize; 2],
    /// Map frame.
    pub(super) place: Point2<f64>,
    /// The distance between walls that stand twice, m; `None` if nothing fits nearby.
    pub(super) off: Option<f64>,
    /// The same as a motion in the map, in either direction; `None` if it is not known.
    pub(super) direction: Option<Vector2<f64>>,
    /// Whether it counts as the only witness.
    pub(super) is_proof: bool,
}

impl Witness {
    /// Whether both witness the same tear. The older side may have moved, or the newer.
    fn says_the_same(&self, other: &Self) -> bool {
        let is_alike = match (self.direction, other.direction) {
            (Some(a), Some(b)) => (a - b).length().min((a + b).length()) < TORN_BEYOND,
            _ => true,
        };
        is_alike && (self.place - other.place).length() < ONE_PLACE
    }
}

/// The tears with enough witnesses.
pub(super) fn gather(witnesses: impl Iterator<Item = Witness>, placed: &[Placed<'_>]) -> Vec<Tear> {
    let mut groups: Vec<Vec<Witness>> = vec![];
    for witness in witnesses {
        let says_the_same = |group: &&mut Vec<Witness>| witness.says_the_same(&group[0]);
        match groups.iter_mut().find(says_the_same) {
            Some(group) => group.push(witness),
            None => groups.push(vec![witness]),
        }
    }
    groups.retain(|group| {
        group.len() >= LEAST_WITNESSES || group.iter().any(|witness| witness.is_proof)
    });
    groups
        .iter()
        .filter_map(|group| tear(group, placed))
        .collect()
}

fn tear(group: &[Witness], placed: &[Placed<'_>]) -> Option<Tear> {
    let count = group.len();
    let sum = group
        .iter()
        .map(|witness| witness.place.coords)
        .sum::<Vector2<f64>>();
    let mut offs: Vec<f64> = group.iter().filter_map(|witness| witness.off).collect();
    offs.sort_by(f64::total_cmp);
    // Witnesses that could measure the offset say more than those that only contradict.
    let off = offs.get(offs.len() / 2).copied();
    let seen = |side: usize| {
        let of_side = group
            .iter()
            .filter_map(|witness| placed.get(witness.submaps[side]));
        of_side.map(|placed| placed.seen).reduce(united)
    };
    Some(Tear {
        kind: match off {
            Some(_) => TearKind::Doubled,
            None => TearKind::Contradicted,
        },
        place: Point2::from(sum / count as f64),
        off,
        earlier: seen(0)?,
        later: seen(1)?,
        witnesses: count,
    })
}

fn united(a: [Stamp; 2], b: [Stamp; 2]) -> [Stamp; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}
