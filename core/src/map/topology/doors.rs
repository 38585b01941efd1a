//! Gaps where basins touch, some of which are doors: step 4.

use std::collections::BTreeMap;

use nalgebra::Vector2;

use super::flood::Basins;
use super::floor::Floor;
use super::{Door, NONE};
use crate::geom::{Length, Segment};
use crate::map::{CellState, cells_around, spread};

/// Cells of two basins that touch, as a door whose `regions` are the basins, ascending.
pub(super) type Gap = Door;

/// A wall seen this near to a post makes it a wall post, m: walls seen at a flat angle have holes,
/// and a gap may be equally narrow some cells beyond its frame.
const SEEN_WITHIN: f64 = 0.2;
/// Limit of the cosine of the angle to the other post, which is searched for across the gap.
const ACROSS: f64 = -0.5;

/// All gaps, in the order of their basins.
pub(super) fn gaps(floor: &Floor, basins: &Basins) -> Vec<Gap> {
    let mut borders: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
    for (cell, &label) in basins.labels.iter().enumerate() {
        if label == NONE {
            continue;
        }
        for next in [cell + 1, cell + floor.width] {
            let other = basins.labels[next];
            if other != NONE && other != label {
                let pair = [label.min(other) as usize, label.max(other) as usize];
                borders.entry(pair).or_default().extend([cell, next]);
            }
        }
    }
    let mut found = vec![];
    for (pair, mut cells) in borders {
        cells.sort_unstable();
        cells.dedup();
        let pieces = connected(&cells, floor.width);
        found.extend(pieces.iter().filter_map(|piece| gap(floor, pair, piece)));
    }
    found
}

/// Groups of sorted cells that touch, also at corners.
fn connected(cells: &[usize], width: usize) -> Vec<Vec<usize>> {
    let steps = [1, width - 1, width, width + 1];
    let around = |cell: usize| steps.into_iter().flat_map(move |by| [cell - by, cell + by]);
    let mut left = vec![true; cells.len()];
    let mut pieces = vec![];
    for (at, &seed) in cells.iter().enumerate() {
        if std::mem::take(&mut left[at]) {
            let is_new = |cell: usize| {
                let at = cells.binary_search(&cell);
                at.is_ok_and(|at| std::mem::take(&mut left[at]))
            };
            pieces.push(spread(seed, around, is_new).cells().collect());
        }
    }
    pieces
}

fn gap(floor: &Floor, basins: [usize; 2], cells: &[usize]) -> Option<Gap> {
    let widest = |a: &&usize, b: &&usize| {
        let clearance = |cell: usize| floor.clearance[cell];
        clearance(**a).total_cmp(&clearance(**b)).then(b.cmp(a))
    };
    let saddle = *cells.iter().max_by(widest)?;
    let free = cells.iter().filter(|cell| floor.is_free(**cell));
    let centre = free.max_by(widest).copied().unwrap_or(saddle);
    let at = floor.place(saddle);
    let near = bounding_near(floor, saddle);
    let off = |cell: usize| floor.place(cell) - at;
    let nearest = |cells: &[usize], counts: &dyn Fn(Vector2<f64>) -> bool| {
        let counting = cells.iter().copied().filter(|&cell| counts(off(cell)));
        counting.min_by(|&a, &b| off(a).norm_squared().total_cmp(&off(b).norm_squared()))
    };
    let one = nearest(&near, &|_| true)?;
    let is_across = |by: Vector2<f64>| by.dot(&off(one)) < ACROSS * by.length() * off(one).length();
    let other = nearest(&near, &is_across);
    let is_seen = |post| is_wall_near(floor, post);
    let ends = [
        floor.place(one),
        other.map_or(at - off(one), |cell| floor.place(cell)),
    ];
    let posts = Segment::new(floor.in_map(ends[0]), floor.in_map(ends[1]));
    Some(Gap {
        regions: basins,
        width: posts.length(),
        posts,
        centre: floor.in_map(floor.place(centre)),
        is_framed: is_seen(one) && other.is_some_and(is_seen),
    })
}

/// Bounding cells about as near to a cell as its clearance.
fn bounding_near(floor: &Floor, cell: usize) -> Vec<usize> {
    let reach = (f64::from(floor.clearance[cell]) / floor.resolution()).ceil() as usize + 3;
    let height = floor.bounds.len() / floor.width;
    cells_around(cell, reach, floor.width, height)
        .filter(|&cell| floor.bounds[cell])
        .collect()
}

fn is_wall_near(floor: &Floor, post: usize) -> bool {
    let within = (SEEN_WITHIN / floor.resolution()).ceil() as usize;
    let height = floor.states.len() / floor.width;
    cells_around(post, within, floor.width, height)
        .any(|cell| floor.states[cell] == CellState::Occupied)
}
