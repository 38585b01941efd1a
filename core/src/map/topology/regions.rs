//! The properties of regions and doors: step 5.

use super::doors::Gap;
use super::floor::Floor;
use super::unite::Plan;
use super::{Door, NONE, Region, RegionKind, Topology, TopologyConfig};
use crate::map::{CellRect, DistanceField};

/// A region longer than this many times its width is a corridor.
const CORRIDOR_ELONGATION: f64 = 5.0;
/// This many doors make a corridor of a region that is not as long as that.
const CORRIDOR_DOORS: usize = 4;
/// With many doors, this fraction of the elongation is enough for a corridor.
const WITH_DOORS: f64 = 0.625;

/// Values gathered of a region, cell by cell.
#[derive(Clone, Copy, Default)]
struct Sums {
    cells: usize,
    /// Largest clearance without furniture, m.
    peak: f32,
    /// Largest clearance of all, and its cell.
    middle: Option<(f32, usize)>,
}

pub(super) fn gather(
    rect: CellRect,
    floor: &Floor,
    plan: &Plan,
    gaps: &[Gap],
    config: &TopologyConfig,
) -> Topology {
    let sums = sums(floor, plan);
    let doors = doors(plan, gaps, config);
    let mut regions: Vec<Region> = sums.iter().map(|sums| region(floor, sums)).collect();
    for (number, door) in doors.iter().enumerate() {
        for region in door.regions {
            regions[region].doors.push(number);
        }
    }
    for region in &mut regions {
        region.kind = kind(region);
    }
    Topology {
        rect,
        resolution: floor.resolution(),
        regions,
        doors,
        labels: without_rim(floor, &plan.labels),
    }
}

fn sums(floor: &Floor, plan: &Plan) -> Vec<Sums> {
    let is_full: Vec<bool> = (0..floor.states.len()).map(|c| !floor.is_free(c)).collect();
    let field = DistanceField::new(floor.rect(), floor.resolution(), &is_full);
    let clearances = field.into_distances();
    let mut sums = vec![Sums::default(); plan.count];
    for (cell, &label) in plan.labels.iter().enumerate() {
        if label == NONE {
            continue;
        }
        let sum = &mut sums[label as usize];
        sum.cells += 1;
        sum.peak = sum.peak.max(floor.clearance[cell]);
        let clearance = clearances[cell];
        if sum.middle.is_none_or(|(most, _)| clearance > most) {
            sum.middle = Some((clearance, cell));
        }
    }
    sums
}

fn region(floor: &Floor, sums: &Sums) -> Region {
    let area = sums.cells as f64 * floor.resolution() * floor.resolution();
    let width = Floor::width_at(sums.peak).max(floor.resolution());
    let middle = sums.middle.map_or(0, |(_, cell)| cell);
    Region {
        kind: RegionKind::Room,
        area,
        centre: floor.in_map(floor.place(middle)),
        width,
        elongation: area / (width * width),
        doors: vec![],
    }
}

fn kind(region: &Region) -> RegionKind {
    let part = if region.doors.len() >= CORRIDOR_DOORS {
        WITH_DOORS
    } else {
        1.0
    };
    match region.elongation >= part * CORRIDOR_ELONGATION {
        true => RegionKind::Corridor,
        false => RegionKind::Room,
    }
}

fn doors(plan: &Plan, gaps: &[Gap], config: &TopologyConfig) -> Vec<Door> {
    let door = |gap: &Gap| {
        let [a, b] = gap.regions.map(|basin| plan.regions[basin]);
        let is_door = a != b && a != NONE && b != NONE && gap.width >= config.narrowest_door;
        let regions = [a.min(b) as usize, a.max(b) as usize];
        is_door.then_some(Door { regions, ..*gap })
    };
    gaps.iter().filter_map(door).collect()
}

fn without_rim(floor: &Floor, labels: &[u32]) -> Vec<u32> {
    let rows = labels.chunks(floor.width.max(1));
    let height = rows.len();
    let inner = rows.skip(1).take(height.saturating_sub(2));
    let cells = inner.flat_map(|row| row.iter().skip(1).take(floor.width.saturating_sub(2)));
    cells.copied().collect()
}
