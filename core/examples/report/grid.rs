//! `grid`: what the occupancy grid costs, and whether its cells are correct. About a minute.
//!
//! 1. 100 scans of 360 beams from random places in `office`, up to 12 m, drawn by each rule for
//!    free cells, against a grid that shares no code (`grid/naive.rs`): every cell to the bit.
//!    Cells whose centre lies on a side of the area are skipped and counted.
//! 2. Memory per mapped square metre, after 1 000 scans; and a site of 1 km² of streets between
//!    buildings, in which a robot drives along every street: all allocations of the program must
//!    stay below 1 GB.
//! 3. With `--peers FILE` (lines of the peers' programs and of the example `workloads`, from one
//!    machine and hour): the time of the area rule as a fraction of MRPT's, on its scans.

mod naive;
mod site;

use std::f64::consts::TAU;
use std::hint::black_box;

use anyhow::Result;
use nalgebra::Point2;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use slamlab_core::geom::{Pose2, unit_vector};
use slamlab_core::map::{Evidence, FreeCells, Grid, GridConfig};
use slamlab_core::sim::Caster;
use stats_alloc::Region;

use crate::memory::{ALLOCATOR, bytes};
use crate::peers::{Peers, Race};
use crate::ride::world_named;
use crate::statistics::place_between;
use crate::{Args, Outcome};

const SCANS: usize = 1000;
const BEAMS: usize = 360;
const RANGE: f64 = 12.0;
/// Number of scans that the naive grid draws too.
const CHECKED: usize = 100;
/// What a browser allows a page, with some to spare.
const BROWSER_BYTES: f64 = 1e9;
const RULES: [(&str, FreeCells); 3] = [
    ("crossed", FreeCells::Crossed),
    ("bresenham", FreeCells::Bresenham),
    ("area", FreeCells::Area),
];

/// A scan and where it was taken.
pub(crate) struct Seen {
    pub(crate) pose: Pose2,
    pub(crate) evidence: Evidence,
}

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let mut outcome = Outcome::default();
    let scans = scans()?;
    for (name, free_cells) in RULES {
        let config = GridConfig {
            free_cells,
            ..GridConfig::default()
        };
        equality(&mut outcome, name, &config, &scans)?;
    }
    memory(&mut outcome, &scans)?;
    site::measure(&mut outcome, BROWSER_BYTES)?;
    match &args.peers {
        Some(file) => against_peers(&mut outcome, &Peers::read(file)?)?,
        None => outcome.figure("peers", "not compared: no --peers FILE"),
    }
    Ok(outcome)
}

/// Point 1.
fn equality(outcome: &mut Outcome, name: &str, config: &GridConfig, scans: &[Seen]) -> Result<()> {
    let (mut grid, mut naive) = (Grid::new(*config)?, naive::NaiveGrid::default());
    for seen in scans.iter().take(CHECKED) {
        grid.draw(&seen.evidence, &seen.pose);
        naive.draw(seen, config);
    }
    let [wrong, compared, skipped] = naive.differences(&grid);
    outcome.figure(format!("{name}_cells_compared"), compared);
    outcome.figure(format!("{name}_cells_on_a_side"), skipped);
    outcome.at_most(&format!("{name}_cells_unlike_naive"), wrong as f64, 0.0);
    outcome.require(compared > 50_000, || {
        format!("only {compared} cells were compared")
    });
    Ok(())
}

/// Point 2, first part.
fn memory(outcome: &mut Outcome, scans: &[Seen]) -> Result<()> {
    let region = Region::new(ALLOCATOR);
    let mut grid = Grid::new(GridConfig::default())?;
    for seen in scans {
        grid.draw(black_box(&seen.evidence), &seen.pose);
    }
    let (bytes, area) = (bytes(&region), mapped_area(&grid));
    outcome.figure("office_mapped_m2", area);
    outcome.figure("office_bytes_per_mapped_m2", bytes / area);
    Ok(())
}

/// Area of the known cells, m².
fn mapped_area(grid: &Grid) -> f64 {
    let all = grid.blocks_since(0).flat_map(|(_, cells)| cells);
    let known = all.filter(|odds| **odds != 0.0).count();
    known as f64 * grid.resolution() * grid.resolution()
}

/// Point 3.
fn against_peers(outcome: &mut Outcome, peers: &Peers) -> Result<()> {
    let grid = Race {
        workload: "gridmap_1000x360_2000x2000",
        ours: "slamlab-Grid(area)",
        theirs: "mrpt-2.5.8-COccupancyGridMap2D(int8 log-odds)",
        at_most: 0.6,
    };
    peers.race(outcome, &grid)
}

fn scans() -> Result<Vec<Seen>> {
    let world = world_named("office")?;
    let (low, high) = world.bounds();
    let caster = Caster::new(world.walls());
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    // Walls of the world lie on borders of cells, where rounding decides; this map frame avoids
    // that.
    let map_from_world = Pose2::new(0.0123, 0.0217, 0.1);
    let mut pose = |_| {
        let at = place_between(low, high, &mut rng);
        Pose2::new(at.x, at.y, rng.random_range(0.0..TAU))
    };
    let poses: Vec<Pose2> = (0..SCANS).map(&mut pose).collect();
    let seen = |pose: Pose2| Seen {
        evidence: scan_from(&caster, &pose, RANGE),
        pose: map_from_world * pose,
    };
    Ok(poses.into_iter().map(seen).collect())
}

/// What a lidar at `pose` sees: every beam free up to its end.
fn scan_from(caster: &Caster, pose: &Pose2, range: f64) -> Evidence {
    let mut evidence = Evidence::default();
    let origin = *pose * Point2::origin();
    for beam in 0..BEAMS {
        let way = unit_vector(TAU * beam as f64 / BEAMS as f64);
        let direction = (*pose * Point2::from(way)) - origin;
        let hit = caster.cast(origin, direction, range).map(|h| h.distance);
        let end = Point2::from(way * hit.unwrap_or(range));
        evidence.free.push([Point2::origin(), end]);
        evidence.hits.extend(hit.map(|_| end));
    }
    evidence
}
