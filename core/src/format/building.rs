//! Buildings from the files of other programs: a map of ROS map_server, a submap of points, or a
//! floor plan drawn as SVG, becomes a [`World`] to drive in.
//!
//! In: an [`OccupancyMap`], or the bytes of a drawing. Out: an [`Imported`] world. [`BuildingFile`]
//! recognises the kind of a file.
//!
//! 1. The outlines of the occupied cells of a map become walls, straightened to within a cell; a
//!    drawing's lines are walls as they are ([`of_svg`]).
//! 2. The robot starts where the building has most room, or where a drawing says (an element with
//!    the id `start`). In a map it starts at the origin, where the robot that made the map began,
//!    if there is room.
//! 3. A fence around everything keeps the robot near the walls: doors may lead outside, and an
//!    unfinished map is open.
//!
//! The world's frame is that of the file: poses in it mean the same in both.

mod error;
mod file;
#[cfg(test)]
mod file_tests;
mod room;
mod submap;
mod svg;
mod svg_copies;
mod svg_shape;
mod svg_style;
#[cfg(test)]
mod svg_tests;
#[cfg(test)]
mod tests;

use nalgebra::Point2;

use crate::format::map_server::OccupancyMap;
use crate::geom::{Pose2, Segment};
use crate::map::{outlines, surfaces};
use crate::sim::{Shape, World};
use room::Room;

pub use self::error::{BuildingError, SvgError};
pub use self::file::{BuildingFile, BuildingFileError, PriorWalls};
pub use self::svg::of_svg;

/// Cells of a map above this percentage are walls.
const WALL_ABOVE: i8 = 65;
/// Cells of a map up to this percentage are floor.
const FLOOR_UPTO: i8 = 35;
/// Maps with more cells are refused: 400 m x 400 m in cells of 5 cm.
const MOST_CELLS: usize = 64_000_000;
/// How far walls may deviate from the borders of the cells, in cells: staircases become straight.
const TOLERANCE: f64 = 1.0;
/// Sides of the fence around a building.
const FENCE_SIDES: usize = 4;
/// Room around the robot where it starts, m.
const CLEARANCE: f64 = 0.05;

/// A world, and what it lacks of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// The building.
    pub world: World,
    /// What was skipped, in words.
    pub skipped: Vec<String>,
}

/// The building that a map shows.
///
/// # Errors    [`BuildingError`]: too many cells, no wall, no room for the robot, or an invalid
/// world.
pub fn of_map(map: &OccupancyMap, name: &str) -> Result<Imported, BuildingError> {
    let mut world = World::new(name, start_in_map(map)?);
    for points in walls_of_map(map)? {
        let closed = points.len() > 2;
        world = world.with(Shape::Polyline { points, closed });
    }
    let reach = |cells: usize| (cells + 1) as f64 * map.resolution;
    let (left, right, top) = (-map.resolution, reach(map.width), reach(map.height));
    let fence = [(left, left), (right, left), (right, top), (left, top)];
    world = fenced(world, fence.map(|(x, y)| map.origin * Point2::new(x, y)));
    Ok(Imported {
        world: checked(world)?,
        skipped: vec![],
    })
}

/// Where a robot starts in a map: at the map's origin, where the robot that made it began, if there
/// is room, otherwise where there is most room.
///
/// # Errors    [`BuildingError::TooLarge`], [`BuildingError::NoWalls`], [`BuildingError::NoRoom`].
fn start_in_map(map: &OccupancyMap) -> Result<Pose2, BuildingError> {
    check_size(map)?;
    if !map.cells.iter().any(|&cell| cell > WALL_ABOVE) {
        return Err(BuildingError::NoWalls);
    }
    let radius = World::new("", Pose2::identity()).robot.model().radius() + CLEARANCE;
    let stands = map.cells.iter().map(|&cell| !is_floor(cell)).collect();
    let room = Room::new(map.width, map.resolution, stands);
    let from_map = map.origin.inverse() * Point2::origin();
    let in_map = match room.clearance(from_map) >= radius {
        true => from_map,
        false => room.roomiest(radius)?,
    };
    let start = map.origin * in_map;
    Ok(Pose2::new(start.x, start.y, 0.0))
}

fn is_floor(cell: i8) -> bool {
    (0..=FLOOR_UPTO).contains(&cell)
}

fn check_size(map: &OccupancyMap) -> Result<(), BuildingError> {
    let (cells, most) = (map.cells.len(), MOST_CELLS);
    if cells > most {
        return Err(BuildingError::TooLarge { cells, most });
    }
    Ok(())
}

/// The surfaces of the occupied cells of a map, in the map's frame, with free space on the left:
/// what a robot can be localised by. In a map without free cells front and back cannot be told
/// apart, so each surface appears as both.
///
/// # Errors    [`BuildingError::TooLarge`], [`BuildingError::NoWalls`].
pub fn surfaces_of_map(map: &OccupancyMap) -> Result<Vec<Segment>, BuildingError> {
    check_size(map)?;
    let occupied: Vec<bool> = map.cells.iter().map(|&cell| cell > WALL_ABOVE).collect();
    let has_floor = map.cells.iter().any(|&cell| is_floor(cell));
    let free: Vec<bool> = (map.cells.iter())
        .map(|&cell| is_floor(cell) || !has_floor)
        .collect();
    let in_cells = surfaces(map.width, &occupied, &free, TOLERANCE);
    if in_cells.is_empty() {
        return Err(BuildingError::NoWalls);
    }
    let place = |corner: Point2<f64>| map.origin * (corner * map.resolution);
    let placed = |side: Segment| Segment::new(place(side.a), place(side.b));
    Ok(in_cells.into_iter().map(placed).collect())
}

/// The outlines of the occupied cells of a map, in the map's frame, with free space on the left as
/// they are followed: what stands in the way of a robot that drives in it.
///
/// # Errors    [`BuildingError::TooLarge`], [`BuildingError::NoWalls`].
pub fn walls_of_map(map: &OccupancyMap) -> Result<Vec<Vec<Point2<f64>>>, BuildingError> {
    check_size(map)?;
    let occupied: Vec<bool> = map.cells.iter().map(|&cell| cell > WALL_ABOVE).collect();
    let in_cells = outlines(map.width, &occupied, TOLERANCE);
    if in_cells.is_empty() {
        return Err(BuildingError::NoWalls);
    }
    let place = |corner: Point2<f64>| map.origin * (corner * map.resolution);
    let placed = |polygon: Vec<Point2<f64>>| polygon.into_iter().map(place).collect();
    Ok(in_cells.into_iter().map(placed).collect())
}

fn fenced(world: World, corners: [Point2<f64>; FENCE_SIDES]) -> World {
    world.with(Shape::Polyline {
        points: corners.to_vec(),
        closed: true,
    })
}

/// # Errors    [`BuildingError::World`].
fn checked(world: World) -> Result<World, BuildingError> {
    world.validate(world.robot.model().radius())?;
    Ok(world)
}
