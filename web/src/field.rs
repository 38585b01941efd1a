//! Fields of the map, flattened for the page.

use slamlab_core::map::Field;
use slamlab_core::plan::RouteConfig;
use slamlab_core::slam::Slam;
use wasm_bindgen::prelude::wasm_bindgen;

/// How far surfaces are off in the likelihood field, m: as in the search for closed loops.
const LIKELIHOOD_SIGMA: f64 = 0.1;

/// No field of that name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no field `{0}`; expected distance, likelihood or room")]
pub struct UnknownField(String);

/// A field of the map in blocks, as `SlamView` has the grid; map frame, m.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug, PartialEq)]
pub struct FieldView {
    /// Changes when the grid was drawn anew and old blocks are worth nothing.
    pub generation: u32,
    /// With `generation`, hand it in next time to get what changed since.
    pub revision: f64,
    /// Side of a cell, m.
    pub resolution: f64,
    /// What a byte more means: m, of the likelihood 1/254.
    pub step: f64,
    /// Column and row of each block that may have changed, in blocks.
    pub blocks: Vec<i32>,
    /// 64 x 64 cells of each such block in rows from the lower left: 0 unknown, else 1 + the value in steps, 255 for all that is more.
    pub cells: Vec<u8>,
}

impl FieldView {
    /// A field by its name, for someone who knows it up to `revision` of `generation`: `distance` to the nearest wall, `likelihood` of
    /// a beam's end, or `room` around the centre of a robot of this radius (m), 0 where it may not be.
    pub(crate) fn since(
        slam: &Slam,
        radius: f64,
        name: &str,
        generation: u32,
        revision: f64,
    ) -> Result<Self, UnknownField> {
        let field = match name {
            "distance" => Field::Distance,
            "likelihood" => Field::Likelihood {
                sigma: LIKELIHOOD_SIGMA,
            },
            "room" => Field::Room {
                keep: radius + RouteConfig::default().narrowest(),
            },
            other => return Err(UnknownField(other.to_owned())),
        };
        let (grid, now) = (slam.grid(), slam.grid_version() as u32);
        let known = if now == generation { revision } else { 0.0 };
        let told = field.since(grid, known as u64);
        Ok(Self {
            generation: now,
            revision: grid.revision() as f64,
            resolution: grid.resolution(),
            step: told.step,
            blocks: told.blocks.iter().flat_map(|b| [b.col, b.row]).collect(),
            cells: told.bytes,
        })
    }
}

#[cfg(test)]
mod tests {
    use slamlab_core::experiment::{Experiment, ExperimentConfig};
    use slamlab_core::pilot::Mode;
    use slamlab_core::robot::RobotModel;
    use slamlab_core::sim::{SensorModel, worlds};

    use super::*;

    /// What a byte tells at a place of the map, m.
    fn value_at(view: &FieldView, x: f64, y: f64) -> Option<f64> {
        let (col, row) = ((x / view.resolution) as i32, (y / view.resolution) as i32);
        let (blocks, _) = view.blocks.as_chunks::<2>();
        let block = [col.div_euclid(64), row.div_euclid(64)];
        let at = blocks.iter().position(|b| *b == block)?;
        let offset = (row.rem_euclid(64) * 64 + col.rem_euclid(64)) as usize;
        let byte = *view.cells.get(at * 4096 + offset)?;
        (byte > 0).then(|| f64::from(byte - 1) * view.step)
    }

    #[test]
    fn fields_are_told_by_name_as_far_as_they_changed() {
        let world = worlds::builtin("arena").unwrap();
        let config = ExperimentConfig {
            mode: Mode::Explore,
            ..ExperimentConfig::new(world, RobotModel::rp6(), SensorModel::lidar(), 7)
        };
        let mut run = Experiment::new(config).unwrap();
        for _ in 0..100 {
            run.step().unwrap();
        }
        let of = |name: &str, generation, revision| {
            FieldView::since(run.session().slam(), 0.18, name, generation, revision)
        };
        let distance = of("distance", 0, 0.0).unwrap();
        assert_eq!(distance.cells.len(), distance.blocks.len() / 2 * 4096);
        let here = run.session().slam().estimate().pose;
        let (x, y) = (here.x(), here.y());
        let far = value_at(&distance, x, y).unwrap();
        assert!(far > 0.2, "the robot stands clear of walls: {far}");
        let room = of("room", 0, 0.0).unwrap();
        let left = value_at(&room, x, y).unwrap();
        assert!(left > 0.0 && left < far - 0.18, "{left} of {far}");
        let likelihood = of("likelihood", 0, 0.0).unwrap();
        assert!(value_at(&likelihood, x, y).unwrap() < 0.2);
        assert!(likelihood.cells.contains(&255), "cells of walls fit best");
        let again = of("distance", distance.generation, distance.revision).unwrap();
        assert!(again.blocks.is_empty(), "nothing is new");
        let other = of("distance", distance.generation + 1, distance.revision).unwrap();
        assert_eq!(
            other.blocks, distance.blocks,
            "another generation knows nothing"
        );
        let error = of("cake", 0, 0.0).unwrap_err().to_string();
        assert_eq!(
            error,
            "there is no field `cake`; expected distance, likelihood or room"
        );
    }
}
