//! Fields of the map, flattened for the page.

use serde::{Deserialize, Serialize};
use slamlab_core::map::Field;
use slamlab_core::plan::RouteConfig;
use slamlab_core::slam::Slam;
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{FieldName, Typed, typed};
use crate::run::WebRun;
use crate::view::GridChange;

/// σ of surfaces in the likelihood field, m: as in the search for loop closures.
const LIKELIHOOD_SIGMA: f64 = 0.1;

/// A field of the map where it may have changed; map frame, m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[tsify(missing_as_null)]
pub struct FieldChange {
    /// Name of the field.
    pub name: FieldName,
    /// Changes when the grid was redrawn and old blocks are invalid.
    pub generation: u32,
    /// Pass it with `generation` to the next call to get what changed since.
    pub revision: f64,
    /// Value of one step of a byte: m, for the likelihood 1/254.
    pub step: f64,
    /// Blocks that may have changed.
    pub grid: Option<GridChange>,
}

#[wasm_bindgen]
impl WebRun {
    /// A field of the grid that the pose's sensor draws, in the blocks in which it may have changed
    /// since `revision` of `generation`.
    ///
    /// # Errors    None that a page can cause.
    pub fn field(
        &self,
        name: &Ts<FieldName>,
        generation: u32,
        revision: f64,
    ) -> Typed<FieldChange> {
        let (radius, name) = (self.robot().radius(), name.to_rust()?);
        let field = FieldChange::since(self.slam(), radius, name, generation, revision);
        typed(&field)
    }
}

impl FieldChange {
    /// A field for a reader who knows it up to `revision` of `generation`, for a robot of this
    /// radius (m).
    pub(crate) fn since(
        slam: &Slam,
        radius: f64,
        name: FieldName,
        generation: u32,
        revision: f64,
    ) -> Self {
        let field = match name {
            FieldName::Distance => Field::Distance,
            FieldName::Likelihood => Field::Likelihood {
                sigma: LIKELIHOOD_SIGMA,
            },
            FieldName::Room => Field::Room {
                keep: radius + RouteConfig::default().narrowest(),
            },
        };
        let (grid, now) = (slam.grid(), slam.grid_version() as u32);
        let known = if now == generation { revision } else { 0.0 };
        let field = field.since(grid, known as u64);
        let index = field.blocks.iter().flat_map(|b| [b.col, b.row]).collect();
        Self {
            name,
            generation: now,
            revision: grid.revision() as f64,
            step: field.step,
            grid: GridChange::of(grid.resolution(), index, field.bytes),
        }
    }
}

#[cfg(test)]
mod tests {
    use slamlab_core::experiment::{Experiment, ExperimentConfig};
    use slamlab_core::pilot::Mode;
    use slamlab_core::robot::RobotModel;
    use slamlab_core::sim::{SensorModel, worlds};

    use super::*;

    /// The value at a place of the map, decoded from its byte, m.
    fn value_at(view: &FieldChange, x: f64, y: f64) -> Option<f64> {
        let grid = view.grid.as_ref()?;
        let (col, row) = ((x / grid.resolution) as i32, (y / grid.resolution) as i32);
        let (blocks, _) = grid.index.as_chunks::<2>();
        let block = [col.div_euclid(64), row.div_euclid(64)];
        let at = blocks.iter().position(|b| *b == block)?;
        let offset = (row.rem_euclid(64) * 64 + col.rem_euclid(64)) as usize;
        let byte = *grid.cells.get(at * 4096 + offset)?;
        (byte > 0).then(|| f64::from(byte - 1) * view.step)
    }

    #[test]
    fn fields_are_told_as_far_as_they_changed() {
        let world = worlds::builtin("arena").unwrap();
        let config = ExperimentConfig {
            mode: Mode::Explore,
            ..ExperimentConfig::new(world, RobotModel::rp6(), SensorModel::lidar(), 7)
        };
        let mut run = Experiment::new(config).unwrap();
        for _ in 0..100 {
            run.step().unwrap();
        }
        let of = |name, generation, revision| {
            FieldChange::since(run.session().slam(), 0.18, name, generation, revision)
        };
        let distance = of(FieldName::Distance, 0, 0.0);
        let blocks = distance.grid.clone().unwrap();
        assert_eq!(blocks.cells.len(), blocks.index.len() / 2 * 4096);
        let here = run.session().slam().estimate().pose;
        let (x, y) = (here.x(), here.y());
        let far = value_at(&distance, x, y).unwrap();
        assert!(far > 0.2, "the robot stands clear of walls: {far}");
        let room = of(FieldName::Room, 0, 0.0);
        let rest = value_at(&room, x, y).unwrap();
        assert!(rest > 0.0 && rest < far - 0.18, "{rest} of {far}");
        let likelihood = of(FieldName::Likelihood, 0, 0.0);
        assert!(value_at(&likelihood, x, y).unwrap() < 0.2);
        assert!(
            likelihood.grid.unwrap().cells.contains(&255),
            "cells of walls fit best"
        );
        let again = of(FieldName::Distance, distance.generation, distance.revision);
        assert!(again.grid.is_none(), "nothing is new");
        let other = of(
            FieldName::Distance,
            distance.generation + 1,
            distance.revision,
        );
        assert_eq!(
            other.grid, distance.grid,
            "another generation knows nothing"
        );
    }
}
