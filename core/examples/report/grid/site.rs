//! A square kilometre inside a fence: buildings of 40 m with streets of 20 m between them; a robot
//! drives along every street.

use anyhow::Result;
use nalgebra::{Point2, Vector2};
use slamlab_core::geom::Pose2;
use slamlab_core::map::{FreeCells, Grid, GridConfig};
use slamlab_core::sim::{Caster, Material, Wall};
use stats_alloc::Region;

use super::{mapped_area, scan_from};
use crate::Outcome;
use crate::memory::{ALLOCATOR, bytes};
use crate::scenes::sides;

const SIDE: f64 = 1000.0;
const PITCH: f64 = 60.0;
const STREET: f64 = 20.0;
const RANGE: f64 = 18.0;
/// Distance between two scans, m: a tenth of the scans that a robot would make.
const SPACING: f64 = 0.5;

pub(super) fn measure(outcome: &mut Outcome, most_bytes: f64) -> Result<()> {
    let caster = Caster::new(buildings());
    let config = GridConfig {
        free_cells: FreeCells::Area,
        ..GridConfig::default()
    };
    let region = Region::new(ALLOCATOR);
    let mut grid = Grid::new(config)?;
    let (mut scans, mut most) = (0, 0.0_f64);
    for pose in drive() {
        let evidence = scan_from(&caster, &pose, RANGE);
        grid.draw(&evidence, &pose);
        scans += 1;
        if scans % 1000 == 0 {
            most = most.max(bytes(&region));
        }
    }
    most = most.max(bytes(&region));
    let area = mapped_area(&grid);
    outcome.figure("site_side_m", SIDE);
    outcome.figure("site_scans", scans);
    outcome.figure("site_mapped_m2", area);
    outcome.figure("site_blocks", grid.block_count());
    outcome.figure("site_bytes_per_mapped_m2", bytes(&region) / area);
    outcome.at_most("site_most_bytes", most, most_bytes);
    outcome.require(grid.block_count() < config.max_blocks, || {
        format!("the site filled all {} blocks", config.max_blocks)
    });
    Ok(())
}

fn buildings() -> Vec<Wall> {
    let count = (SIDE / PITCH) as usize;
    let half = STREET / 2.0;
    let corners = (0..count * count).flat_map(|at| {
        let low = Point2::new((at % count) as f64, (at / count) as f64) * PITCH;
        let (near, far) = (half, PITCH - half);
        let corners = [(near, near), (far, near), (far, far), (near, far)];
        sides(&corners.map(|(x, y)| low + Vector2::new(x, y))).collect::<Vec<_>>()
    });
    let wall = |segment| Wall {
        segment,
        material: Material::Opaque,
    };
    let fence = [(0.0, 0.0), (SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE)];
    let fence = fence.map(|(x, y)| Point2::new(x - half, y - half));
    corners.chain(sides(&fence)).map(wall).collect()
}

/// Along the middle of every street, both ways across the site.
fn drive() -> impl Iterator<Item = Pose2> {
    let streets = (SIDE / PITCH) as usize + 1;
    let stops = ((SIDE - STREET) / SPACING) as usize;
    (0..2 * streets * stops).map(move |at| {
        let (street, along) = (at / stops, (at % stops) as f64 * SPACING);
        let across = (street / 2) as f64 * PITCH;
        match street % 2 {
            0 => Pose2::new(along, across, 0.0),
            _ => Pose2::new(across, along, 0.0),
        }
    })
}
