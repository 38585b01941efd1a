//! Basins of the floor, by a flood from the widest places down: step 3.

use super::NONE;
use super::disjoint_sets::DisjointSets;
use super::floor::Floor;

/// Gaps wider than this divide nothing, m. Larger: halls are divided at their pillars.
const WIDEST_DOOR: f64 = 1.3;
/// A gap divides only if its width is less than this fraction of the narrower side's. Larger:
/// corridors are divided where something stands at their walls.
const DEPTH: f64 = 0.75;

/// The floor in basins.
pub(super) struct Basins {
    /// Basin of each cell, [`NONE`] for what bounds the floor.
    pub(super) labels: Vec<u32>,
    /// Number of basins.
    pub(super) count: usize,
}

/// Floods the floor.
pub(super) fn basins(floor: &Floor) -> Basins {
    let mut flood = Flood {
        floor,
        labels: vec![NONE; floor.bounds.len()],
        sets: DisjointSets::of(0),
        peaks: vec![],
    };
    for cell in widest_first(floor) {
        flood.take(cell as usize);
    }
    flood.settle()
}

struct Flood<'a> {
    floor: &'a Floor,
    labels: Vec<u32>,
    sets: DisjointSets,
    /// Clearance of the widest place of each set, m, by its name.
    peaks: Vec<f32>,
}

impl Flood<'_> {
    fn take(&mut self, cell: usize) {
        let clearances = &self.floor.clearance;
        let mut near = [NONE; 4];
        let mut widest: Option<(f32, u32)> = None;
        for (near, next) in near.iter_mut().zip(self.floor.neighbours(cell)) {
            let label = self.labels[next];
            if label == NONE {
                continue;
            }
            *near = self.sets.name_of(label);
            if widest.is_none_or(|(clearance, _)| clearances[next] > clearance) {
                widest = Some((clearances[next], *near));
            }
        }
        let Some((_, label)) = widest else {
            self.labels[cell] = self.sets.add();
            self.peaks.push(clearances[cell]);
            return;
        };
        self.labels[cell] = label;
        for i in 0..4 {
            for j in i + 1..4 {
                if near[i] != near[j] && near[i] != NONE && near[j] != NONE {
                    self.meet(clearances[cell], [near[i], near[j]]);
                }
            }
        }
    }

    /// Handles two basins that meet at a place of this clearance.
    fn meet(&mut self, clearance: f32, basins: [u32; 2]) {
        let [a, b] = basins.map(|basin| self.sets.name_of(basin));
        if a == b {
            return;
        }
        let peaks = [a, b].map(|basin| self.peaks[basin as usize]);
        let gap = Floor::width_at(clearance);
        let narrower = Floor::width_at(peaks[0].min(peaks[1]));
        if gap > WIDEST_DOOR || gap >= DEPTH * narrower {
            let (stays, goes) = if peaks[0] >= peaks[1] { (a, b) } else { (b, a) };
            self.sets.unite(stays, goes);
        }
    }

    /// Numbers the sets that remain.
    fn settle(mut self) -> Basins {
        let mut numbers = vec![NONE; self.peaks.len()];
        let mut count = 0;
        for label in self.labels.iter_mut().filter(|label| **label != NONE) {
            let name = self.sets.name_of(*label) as usize;
            if numbers[name] == NONE {
                numbers[name] = count;
                count += 1;
            }
            *label = numbers[name];
        }
        Basins {
            labels: self.labels,
            count: count as usize,
        }
    }
}

/// Cells of the floor by falling clearance, and by their number if that is equal; sorted by
/// counting, because squared distances are whole numbers.
fn widest_first(floor: &Floor) -> Vec<u32> {
    let key = |cell: usize| {
        let cells = f64::from(floor.clearance[cell]) / floor.resolution();
        ((cells * cells + 0.5) as usize).min(MOST_SQUARED)
    };
    let open = || (0..floor.bounds.len()).filter(|cell| !floor.bounds[*cell]);
    let mut places: Vec<u32> = vec![];
    for key in open().map(key) {
        if key >= places.len() {
            places.resize(key + 1, 0);
        }
        places[key] += 1;
    }
    // Turns each count into the index of the first such cell: after all that are wider.
    let mut wider = 0;
    for place in places.iter_mut().rev() {
        wider += std::mem::replace(place, wider);
    }
    let mut sorted = vec![0; wider as usize];
    for cell in open() {
        let place = &mut places[key(cell)];
        sorted[*place as usize] = cell as u32;
        *place += 1;
    }
    sorted
}

/// A place farther than this from all walls, in squared cells (51 m at 5 cm), is in a hall so wide
/// that the order of its cells does not matter.
const MOST_SQUARED: usize = 1 << 20;
