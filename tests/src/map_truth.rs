//! How accurate a saved map is: the image that the page saves, against the walls of the world.
//!
//! In: a world, PGM and YAML as `format::map_server` writes them; the map's frame begins where the
//! robot did. Out: [`MapTruth`].
//!
//! 1. For each occupied cell: the distance of its centre from the nearest true wall.
//! 2. For each true wall that can be seen from where the robot can be, every 5 cm: whether an
//!    occupied cell is near.
//! 3. For the floor that can be reached or seen: how much of it is known in the map.

use nalgebra::{Point2, Vector2};
use slamlab_core::format::map_server::{self, MapServerError, NOTHING_KNOWN, OccupancyMap};
use slamlab_core::geom::Pose2;
use slamlab_core::sim::{Caster, ReachableArea, World, reachable_area};

/// Cells nearer than this count as at the wall, m: two cells.
const NEAR: f64 = 0.1;
/// Spacing of the tested points along a wall, and of the raster of what can be reached, m.
const SPACING: f64 = 0.05;
/// Radius of the robot, m.
const RADIUS: f64 = 0.11;

/// The accuracy of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapTruth {
    /// Fraction of the floor that the map knows, 0 to 1.
    pub explored: f64,
    /// Fraction of the occupied cells within 10 cm of a true wall.
    pub true_walls: f64,
    /// Mean distance of an occupied cell from the nearest true wall, m.
    pub wall_error: f64,
    /// Fraction of the walls that are in the map.
    pub found_walls: f64,
}

/// Why files are not a map that can be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MapFileError {
    /// The image or the text beside it.
    #[error(transparent)]
    File(#[from] MapServerError),
    /// The map has no known cells.
    #[error("no cell is occupied")]
    Empty,
}

/// A map with the positions of its cells.
struct Picture(OccupancyMap);

/// Compares a map with its world.
///
/// # Errors    [`MapFileError`].
pub fn compare(world: &World, pgm: &[u8], yaml: &str) -> Result<MapTruth, MapFileError> {
    let picture = Picture(map_server::read(yaml.as_bytes(), pgm)?);
    let caster = Caster::new(world.walls());
    let errors: Vec<f64> = picture
        .occupied()
        .map(|in_map| caster.clearance(world.start * in_map, 2.0))
        .collect();
    if errors.is_empty() {
        return Err(MapFileError::Empty);
    }
    let area = reachable_area(world, RADIUS, SPACING);
    let map_from_world = world.start.inverse();
    let near = errors.iter().filter(|error| **error < NEAR).count();
    Ok(MapTruth {
        explored: area.known_fraction(|at| {
            let cell = picture.cell(map_from_world * at);
            cell.is_some_and(|cell| cell != NOTHING_KNOWN)
        }),
        true_walls: near as f64 / errors.len() as f64,
        wall_error: errors.iter().sum::<f64>() / errors.len() as f64,
        found_walls: found(world, &area, &picture, &map_from_world),
    })
}

fn found(world: &World, area: &ReachableArea, picture: &Picture, map_from_world: &Pose2) -> f64 {
    // What bounds visible floor can be seen.
    let floor: Vec<Point2<f64>> = area.centres().collect();
    let (mut all, mut seen) = (0_u32, 0_u32);
    for wall in world.walls() {
        let segment = wall.segment;
        let (from, along) = (segment.a, segment.vector());
        let count = (along.norm() / SPACING).ceil().max(1.0);
        for k in 0..=count as u32 {
            let at = from + along * (f64::from(k) / count);
            if !floor.iter().any(|cell| (cell - at).norm() < 2.0 * NEAR) {
                continue;
            }
            all += 1;
            seen += u32::from(picture.is_occupied_near(*map_from_world * at));
        }
    }
    f64::from(seen) / f64::from(all.max(1))
}

impl Picture {
    fn cell(&self, in_map: Point2<f64>) -> Option<i8> {
        let at = (self.0.origin.inverse() * in_map) / self.0.resolution;
        if at.x < 0.0 || at.y < 0.0 {
            return None;
        }
        let (col, row) = (at.x as usize, at.y as usize);
        (col < self.0.width && row < self.0.height).then(|| self.0.cells[row * self.0.width + col])
    }

    fn occupied(&self) -> impl Iterator<Item = Point2<f64>> {
        self.0.occupied().into_iter()
    }

    fn is_occupied_near(&self, in_map: Point2<f64>) -> bool {
        let reach = (NEAR / self.0.resolution).round() as i32;
        (-reach..=reach).any(|row| {
            (-reach..=reach).any(|col| {
                let by = Vector2::new(f64::from(col), f64::from(row)) * self.0.resolution;
                self.cell(in_map + by) == Some(100)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use slamlab_core::sim::worlds;

    use super::*;

    /// The arena with every wall drawn `shift` metres too far to the left.
    fn drawn(shift: f64) -> (World, Vec<u8>, String) {
        let world = worlds::builtin("arena").unwrap();
        let caster = Caster::new(world.walls());
        let (cols, rows) = (120, 100);
        let low = Point2::new(-1.0, -1.0);
        let mut pgm = format!("P5\n# test\n{cols} {rows}\n255\n").into_bytes();
        for row in (0..rows).rev() {
            for col in 0..cols {
                let middle = Vector2::new(f64::from(col) + 0.5, f64::from(row) + 0.5) * 0.05;
                let at = world.start * (low + middle + Vector2::new(shift, 0.0));
                let is_wall = caster.clearance(at, 1.0) < 0.03;
                pgm.push(if is_wall { 0 } else { 254 });
            }
        }
        (
            world,
            pgm,
            "image: a.pgm\nresolution: 0.05\norigin: [-1.0, -1.0, 0]\nnegate: 0\noccupied_thresh: 0.65\n\
             free_thresh: 0.196\n".into(),
        )
    }

    #[test]
    fn a_true_map_is_found_true() {
        let (world, pgm, yaml) = drawn(0.0);
        let truth = compare(&world, &pgm, &yaml).unwrap();
        assert!(
            truth.explored > 0.999 && truth.found_walls > 0.999,
            "{truth:?}"
        );
        assert!(
            truth.true_walls > 0.999 && truth.wall_error < 0.03,
            "{truth:?}"
        );
    }

    #[test]
    fn a_map_off_by_a_third_of_a_metre_is_found_out() {
        let (world, pgm, yaml) = drawn(0.33);
        let truth = compare(&world, &pgm, &yaml).unwrap();
        assert!(
            truth.true_walls < 0.7 && truth.wall_error > 0.06,
            "{truth:?}"
        );
        assert!(truth.found_walls < 0.8, "{truth:?}");
    }

    #[test]
    fn what_is_no_map_is_named() {
        let (world, pgm, yaml) = drawn(0.0);
        let error_of = |pgm: &[u8], yaml: &str| compare(&world, pgm, yaml).unwrap_err().to_string();
        assert!(error_of(&pgm[..99], &yaml).contains("the header promises 120 x 100 pixels"));
        assert!(error_of(&pgm, "x: 1").contains("the key `image` is missing"));
    }
}
