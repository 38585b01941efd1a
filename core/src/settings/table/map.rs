//! How the grid is drawn.

use super::{ANY, Group};
use crate::map::{FreeCells, GridConfig};
use crate::settings::field::{Number, at, rows};
use crate::settings::setting::{
    Acts, CENTIMETRES, Field, METRES, PERCENT, SIGMAS, Setting, one_of, real, si,
};
use crate::slam::Method;

const OF_MAP: Group = Group {
    name: "Map",
    acts: Acts::OnRestart,
    ..ANY
};
/// Methods other than scan matching and grid particles, which draw few scans with parameters of
/// their own.
const SCAN_BY_SCAN: &[Method] = &[
    Method::Odometry,
    Method::LineEkf,
    Method::PriorMap,
    Method::ParticleLocalisation,
    Method::HistogramLocalisation,
];
/// Methods that draw only what a scan says for certain.
const BY_EVIDENCE: &[Method] = &[
    Method::LineEkf,
    Method::GridParticles,
    Method::PriorMap,
    Method::ParticleLocalisation,
    Method::HistogramLocalisation,
];

rows! { MAP = OF_MAP;
    "grid.resolution", "Cell size", real(GridConfig::RESOLUTION, CENTIMETRES),
        [get |s| Some(s.slam.grid.resolution), set |s, v| { s.slam.grid.resolution = v; s.slam.matcher.grid.resolution = v; }].basic(),
        "Side of a cell. Larger: coarser and faster.";
    "grid.hit", "Occupied where a beam ends", real(GridConfig::HIT, PERCENT), [slam.grid.hit].methods(SCAN_BY_SCAN).basic(),
        "Probability that the cell where a beam ended is occupied. Lidar 70 %, Celej 80 %. Larger: fewer beams make a wall.";
    "grid.miss", "Occupied where a beam passes", real(GridConfig::MISS, PERCENT), [slam.grid.miss].methods(SCAN_BY_SCAN).basic(),
        "The same for a cell that a beam crossed. Lidar 40 %, Celej 20 %. Larger: more beams are needed to clear a cell.";
    "grid.clamp", "Never surer than", real(GridConfig::CLAMP, PERCENT), [slam.grid.clamp].methods(SCAN_BY_SCAN),
        "Probabilities stay this far from 0 and 1. Larger: the map changes its mind sooner.";
    "grid.sweep", "Cells that a scan frees", one_of::<FreeCells>(),
        [get |s| Some(s.slam.grid.free_cells.number()), set |s, v| { s.slam.grid.free_cells.put(v); s.slam.matcher.grid.free_cells.put(v); }].basic(),
        "Between the beams is fastest, and leaves no cells unseen where beams are far apart. Sonars beside the sensor keep theirs.";
    "evidence.sigmas", "Width of a beam", real([0.0, 5.0], SIGMAS), [slam.evidence.sigmas].methods(BY_EVIDENCE).at_once(),
        "In standard deviations of its direction. Larger: cleaner walls, less known from afar.";
    "evidence.margin", "Margin of a beam", real([0.0, 5.0], si("cells")), [slam.evidence.margin_cells].methods(BY_EVIDENCE).at_once(),
        "What is cleared is free over so much more to either side. Larger: cleaner walls, less known in narrow places.";
    "evidence.no_return", "No return clears up to", real([0.0, 50.0], METRES),
        [get |s| Some(s.slam.evidence.no_return_clears), set |s, v| { s.slam.evidence.no_return_clears = v; s.slam.matcher.evidence.no_return_clears = v; }],
        "How far a beam without a return is believed to be free. Larger: more is known to be free, glass too.";
}
