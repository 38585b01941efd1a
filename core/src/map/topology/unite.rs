//! Which basins form a region together: those that no framed gap separates, and those too small for
//! a room: step 4.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

use super::disjoint_sets::DisjointSets;
use super::doors::Gap;
use super::flood::Basins;
use super::floor::Floor;
use super::{NONE, TopologyConfig};

/// Region of each cell of the floor's raster, [`NONE`] for none; the largest region is number 0.
pub(super) struct Plan {
    pub(super) labels: Vec<u32>,
    /// The region of each basin.
    pub(super) regions: Vec<u32>,
    pub(super) count: usize,
}

pub(super) fn unite(floor: &Floor, basins: Basins, gaps: &[Gap], config: &TopologyConfig) -> Plan {
    let cell = floor.resolution() * floor.resolution();
    let mut areas = vec![0.0; basins.count];
    for (cell_index, &label) in basins.labels.iter().enumerate() {
        if label != NONE && floor.is_free(cell_index) {
            areas[label as usize] += cell;
        }
    }
    let mut union = Union {
        sets: DisjointSets::of(basins.count),
        areas,
    };
    let passable: Vec<&Gap> = gaps
        .iter()
        .filter(|gap| gap.width >= config.narrowest_door)
        .collect();
    union.over_rims(&passable);
    union.small(&passable, config.least_area);
    let regions = union.numbers(config.least_area);
    let count = regions.iter().filter(|r| **r != NONE).max();
    Plan {
        labels: of_cells(floor, basins.labels, &regions),
        count: count.map_or(0, |most| *most as usize + 1),
        regions,
    }
}

/// Area of the smaller set, width of the gap and its number: a heap returns the smallest area
/// first.
type Turn = Reverse<(u64, Reverse<u64>, usize)>;

struct Union {
    sets: DisjointSets,
    /// Free floor, m², by the name of a set.
    areas: Vec<f64>,
}

impl Union {
    fn unite(&mut self, basins: [usize; 2]) {
        let [a, b] = basins.map(|basin| self.sets.name_of(basin as u32));
        if a != b {
            self.sets.unite(a, b);
            self.areas[a as usize] += self.areas[b as usize];
        }
    }

    /// Unites basins that are separated only by the edge of what was seen.
    fn over_rims(&mut self, gaps: &[&Gap]) {
        let framed = gaps.iter().filter(|gap| gap.is_framed);
        let framed: BTreeSet<[usize; 2]> = framed.map(|gap| gap.regions).collect();
        for gap in gaps.iter().filter(|gap| !framed.contains(&gap.regions)) {
            self.unite(gap.regions);
        }
    }

    /// Merges sets too small for a room into the neighbour with the widest gap, the smallest set
    /// first.
    fn small(&mut self, gaps: &[&Gap], least: f64) {
        let mut queue: BinaryHeap<_> = (0..gaps.len())
            .filter_map(|at| self.turn(gaps, at, least))
            .collect();
        while let Some(turn) = queue.pop() {
            let Reverse((_, _, at)) = turn;
            match self.turn(gaps, at, least) {
                Some(now) if now == turn => self.unite(gaps[at].regions),
                // The set has grown since then.
                later => queue.extend(later),
            }
        }
    }

    /// The turn of a gap: by the area of the smaller set beside it, and of equal ones the widest
    /// gap first. `None` if it separates nothing, or no set that is too small.
    fn turn(&mut self, gaps: &[&Gap], at: usize, least: f64) -> Option<Turn> {
        let gap = gaps[at];
        let [a, b] = gap.regions.map(|basin| self.sets.name_of(basin as u32));
        let area = self.areas[a as usize].min(self.areas[b as usize]);
        // The bits of non-negative numbers sort like the numbers.
        let turn = Reverse((area.to_bits(), Reverse(gap.width.to_bits()), at));
        (a != b && area < least).then_some(turn)
    }

    /// Numbers regions by falling size. A set that is still too small has no gap to anything: it is
    /// a scrap behind a hole.
    fn numbers(&mut self, least: f64) -> Vec<u32> {
        let count = self.areas.len();
        let names: Vec<u32> = (0..count as u32).map(|b| self.sets.name_of(b)).collect();
        let area = |name: &u32| self.areas[*name as usize];
        let roots = (0..count as u32).filter(|&b| names[b as usize] == b);
        let mut roots: Vec<u32> = roots.filter(|root| area(root) >= least).collect();
        // Stable: equal areas keep the order of the raster.
        roots.sort_by(|a, b| area(b).total_cmp(&area(a)));
        let mut numbers = vec![NONE; count];
        for (number, root) in roots.into_iter().enumerate() {
            numbers[root as usize] = number as u32;
        }
        names.iter().map(|&name| numbers[name as usize]).collect()
    }
}

/// Turns basins into regions. Only free cells belong to one; furniture does not.
fn of_cells(floor: &Floor, mut labels: Vec<u32>, regions: &[u32]) -> Vec<u32> {
    for (cell, label) in labels.iter_mut().enumerate() {
        let is_in = *label != NONE && floor.is_free(cell);
        *label = if is_in {
            regions[*label as usize]
        } else {
            NONE
        };
    }
    labels
}
