//! Details of one thing in the map, for when a person points at it.

use nalgebra::Point2;
use slamlab_core::geom::Segment;
use slamlab_core::map::{CellFigures, CellState, beam_among};
use slamlab_core::points::Beam;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{CellRow, ExaminedBeamRow, LeafRow, flat};
use crate::run::WebRun;
use crate::view::{hits_of, map_from_robot_at_scan};

#[wasm_bindgen]
impl WebRun {
    /// What is known of the cell at a point, map frame, m, see `CELL`.
    #[must_use]
    pub fn cell(&self, x: f64, y: f64) -> Vec<f64> {
        let figures = self.slam().layers().figures(Point2::new(x, y));
        flat([CellRow::from(figures)])
    }

    /// What the map expects of a beam of the last scan, by the beam's number, see `EXAMINED_BEAM`;
    /// nothing for a beam that hit nothing.
    ///
    /// Methods that localise in a prior map weight a beam by the walls of that map (likelihood
    /// field); for all others it is compared with the drawn grid.
    #[must_use]
    pub fn beam(&self, number: u32) -> Option<Vec<f64>> {
        let mut hits = hits_of(self.slam());
        let beam = hits.find(|beam| beam.beam_idx == number as usize)?;
        Some(flat([self.beam_row(beam)]))
    }

    /// Whether a gap is open according to the map, see `LEAF`. `ends`: x1 y1 x2 y2, map frame, m;
    /// nothing if these are not four numbers.
    #[must_use]
    pub fn leaf(&self, ends: &[f64]) -> Option<Vec<f64>> {
        let &[x1, y1, x2, y2] = ends else {
            return None;
        };
        let posts = Segment::new(Point2::new(x1, y1), Point2::new(x2, y2));
        let leaf = self.slam().layers().leaf(&posts);
        Some(flat([LeafRow {
            cells: leaf.cells as f64,
            known: leaf.known as f64,
            log_odds: leaf.log_odds,
            open: leaf.open,
        }]))
    }
}

impl WebRun {
    fn beam_row(&self, beam: &Beam) -> ExaminedBeamRow {
        let slam = self.slam();
        let map_from_robot = map_from_robot_at_scan(self.session());
        let from = map_from_robot * beam.origin_in_robot;
        let to = map_from_robot * beam.end_in_robot;
        let prior = slam.view().prior_map_fit.map(|_| slam.config());
        let told = match prior {
            Some(config) => beam_among(&config.prior_map.faces, from, to),
            None => slam.grid().beam(from, to),
        };
        // The surface of a cell may be anywhere in it.
        let of_map = match prior {
            Some(config) => config.prior_map.sigma,
            None => slam.grid().resolution() / 12.0_f64.sqrt(),
        };
        let of_beam = prior.map_or(beam.sigma, |config| config.particles.sigma);
        ExaminedBeamRow {
            from_x: from.x,
            from_y: from.y,
            x: to.x,
            y: to.y,
            range: beam.range,
            sigma: beam.sigma,
            quality: beam.quality.map_or(f64::NAN, f64::from),
            expected: told.expected.unwrap_or(f64::NAN),
            nearest: told.nearest.unwrap_or(f64::NAN),
            field_sigma: of_beam.hypot(of_map),
            random: prior.map_or(0.0, |config| config.particles.random_part),
            walls: f64::from(u8::from(prior.is_some())),
        }
    }
}

impl From<CellFigures> for CellRow {
    fn from(of: CellFigures) -> Self {
        Self {
            col: f64::from(of.cell.col),
            row: f64::from(of.cell.row),
            resolution: of.resolution,
            log_odds: of.log_odds,
            probability: of.probability,
            state: match of.state {
                CellState::Unknown => 0.0,
                CellState::Free => -1.0,
                CellState::Occupied => 1.0,
            },
            of_sensor: of.of_sensor,
            of_sonars: of.of_sonars.unwrap_or(f64::NAN),
            hit: of.hit,
            miss: of.miss,
            limit: of.limit,
            after_hit: of.after_hit,
            after_miss: of.after_miss,
        }
    }
}
