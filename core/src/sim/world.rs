//! What stands in the building, and where the robot starts.
//!
//! Obstacles are kept as the shapes they were drawn as (an editor and a file need those) and
//! flattened to straight [`Wall`]s for ray casting and collision: a circle becomes an inscribed
//! polygon, to within 2 mm. The flattened walls ARE the truth, for the sensors and for the robot's
//! body alike.
//!
//! Polygons, rectangles and circles are solid; the outline of a room is a closed polyline.

mod check;
mod door;
mod mover;
mod shape;
#[cfg(test)]
mod tests;

use nalgebra::{Point2, Vector2};

use self::check::{check_coordinate, check_count, check_point};
use super::SensorKind;
use crate::geom::{Length, Pose2, Segment, bounds};
use crate::robot::RobotModel;

pub use self::check::WorldError;
pub use self::door::Door;
pub use self::mover::{Disc, Mover};
pub use self::shape::Shape;

/// More walls than this are refused.
const MOST_WALLS: usize = 200_000;
/// More doors than this are refused.
const MOST_DOORS: usize = 1_000;
/// More movers than this are refused.
const MOST_MOVERS: usize = 1_000;

/// A building to explore, in the world frame.
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    /// Name, for people.
    pub name: String,
    /// What stands still.
    pub obstacles: Vec<Obstacle>,
    /// What opens and shuts.
    pub doors: Vec<Door>,
    /// What walks about.
    pub movers: Vec<Mover>,
    /// Where the robot starts: `world_from_robot` at time 0.
    pub start: Pose2,
    /// Where the robot should go, if the world sets a task.
    pub goal: Option<Point2<f64>>,
    /// The robot this world was made for.
    pub robot: RobotKind,
    /// The sensor this world was made for.
    pub sensor: SensorKind,
    /// The seed that is used if nobody chooses another.
    pub seed: u64,
}

/// What a surface does to light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Material {
    /// Reflects well.
    #[default]
    Opaque,
    /// Lets most beams through; only those that meet it squarely come back.
    Glass,
    /// Reflects so little that it is seen only from near.
    Dark,
}

/// A static object: a shape of one material.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// Its outline.
    pub shape: Shape,
    /// Its surface.
    pub material: Material,
}

/// A straight piece of surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// Where.
    pub segment: Segment,
    /// Of what.
    pub material: Material,
}

/// The robots that a world file can name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RobotKind {
    /// [`RobotModel::rp6`].
    #[default]
    Rp6,
    /// [`RobotModel::pioneer`].
    Pioneer,
}

impl RobotKind {
    /// The figures of this robot.
    #[must_use]
    pub fn model(self) -> RobotModel {
        match self {
            Self::Rp6 => RobotModel::rp6(),
            Self::Pioneer => RobotModel::pioneer(),
        }
    }
}

impl World {
    /// An empty world.
    #[must_use]
    pub fn new(name: impl Into<String>, start: Pose2) -> Self {
        Self {
            name: name.into(),
            obstacles: Vec::new(),
            doors: Vec::new(),
            movers: Vec::new(),
            start,
            goal: None,
            robot: RobotKind::default(),
            sensor: SensorKind::default(),
            seed: 1,
        }
    }

    /// Adds thin opaque walls from corner to corner.
    #[must_use]
    pub fn with_walls(self, corners: &[(f64, f64)]) -> Self {
        self.with_polyline(corners, false)
    }

    /// Adds the outline of a room.
    #[must_use]
    pub fn with_room(self, corners: &[(f64, f64)]) -> Self {
        self.with_polyline(corners, true)
    }

    fn with_polyline(self, corners: &[(f64, f64)], closed: bool) -> Self {
        let points = corners.iter().map(|&(x, y)| Point2::new(x, y)).collect();
        self.with(Shape::Polyline { points, closed })
    }

    /// Sets the task of driving there.
    #[must_use]
    pub fn with_goal(mut self, (x, y): (f64, f64)) -> Self {
        self.goal = Some(Point2::new(x, y));
        self
    }

    /// Adds a solid opaque box between two opposite corners.
    #[must_use]
    pub fn with_box(self, (x0, y0): (f64, f64), (x1, y1): (f64, f64)) -> Self {
        let centre = (0.5 * (x0 + x1), 0.5 * (y0 + y1));
        self.with_turned_box(centre, ((x1 - x0).abs(), (y1 - y0).abs()), 0.0)
    }

    /// Adds a solid opaque box by its middle, full size and turn (rad).
    #[must_use]
    pub fn with_turned_box(self, centre: (f64, f64), size: (f64, f64), angle: f64) -> Self {
        self.with(Shape::Rectangle {
            centre: Point2::new(centre.0, centre.1),
            size: Vector2::new(size.0, size.1),
            angle,
        })
    }

    /// Adds a solid opaque pillar.
    #[must_use]
    pub fn with_pillar(self, centre: (f64, f64), radius: f64) -> Self {
        self.with(Shape::Circle {
            centre: Point2::new(centre.0, centre.1),
            radius,
        })
    }

    /// Adds an opaque shape.
    #[must_use]
    pub fn with(mut self, shape: Shape) -> Self {
        self.obstacles.push(Obstacle {
            shape,
            material: Material::Opaque,
        });
        self
    }

    /// Makes the obstacle added last of this material.
    #[must_use]
    pub fn made_of(mut self, material: Material) -> Self {
        if let Some(last) = self.obstacles.last_mut() {
            last.material = material;
        }
        self
    }

    /// Number of [`Self::walls`].
    #[must_use]
    pub fn wall_count(&self) -> usize {
        let counts = self.obstacles.iter().map(|o| o.shape.segment_count());
        counts.sum()
    }

    /// Every straight piece of static surface, in the order of the obstacles. Doors are not
    /// included.
    #[must_use]
    pub fn walls(&self) -> Vec<Wall> {
        let of_obstacle = |Obstacle { shape, material }: &Obstacle| {
            let material = *material;
            let segments = shape.segments().into_iter();
            segments.map(move |segment| Wall { segment, material })
        };
        self.obstacles.iter().flat_map(of_obstacle).collect()
    }

    /// The smallest axis-aligned rectangle around walls, start and goal, as (lower corner, upper
    /// corner).
    #[must_use]
    pub fn bounds(&self) -> (Point2<f64>, Point2<f64>) {
        let start = self.start.position();
        let walls = self.walls().into_iter().map(|wall| wall.segment);
        let segments = walls.chain(self.doors.iter().map(|door| door.leaf));
        let ends = segments.flat_map(|s| [s.a, s.b]);
        let ways = self.movers.iter().flat_map(|m| m.waypoints.iter().copied());
        let places = [start].into_iter().chain(ends).chain(ways).chain(self.goal);
        bounds(places).unwrap_or((start, start))
    }

    /// Checks the figures, and that a robot of `radius` (m) can stand at the start.
    ///
    /// # Errors    [`WorldError`], naming the first unusable part.
    pub fn validate(&self, radius: f64) -> Result<(), WorldError> {
        self.check_figures()?;
        self.check_start(radius)
    }

    fn check_figures(&self) -> Result<(), WorldError> {
        let pose = [self.start.x(), self.start.y(), self.start.heading()];
        for (field, value) in ["x", "y", "heading"].into_iter().zip(pose) {
            check_coordinate("start", field, value)?;
        }
        if let Some(goal) = self.goal {
            check_point("goal", &goal)?;
        }
        let mut walls = 0;
        for (index, obstacle) in self.obstacles.iter().enumerate() {
            obstacle.shape.check(&format!("obstacle {index}"))?;
            walls += obstacle.shape.segment_count();
        }
        check_count("world", "walls", walls, ..=MOST_WALLS, "at most 200000")?;
        let doors = self.doors.len();
        check_count("world", "doors", doors, ..=MOST_DOORS, "at most 1000")?;
        for (index, door) in self.doors.iter().enumerate() {
            door.check(&format!("door {index}"))?;
        }
        let movers = self.movers.len();
        check_count("world", "movers", movers, ..=MOST_MOVERS, "at most 1000")?;
        for (index, mover) in self.movers.iter().enumerate() {
            mover.check(&format!("mover {index}"))?;
        }
        Ok(())
    }

    fn check_start(&self, radius: f64) -> Result<(), WorldError> {
        let start = self.start.position();
        let blocked = |what: String, distance: f64| {
            Err(WorldError::StartBlocked {
                x: start.x,
                y: start.y,
                radius: (radius * 1e4).round() * 1e-4,
                what,
                distance,
            })
        };
        for (index, obstacle) in self.obstacles.iter().enumerate() {
            let segments = obstacle.shape.segments();
            let distances = segments.iter().map(|s| s.distance(start));
            let distance = distances.fold(f64::INFINITY, f64::min);
            if distance < radius || obstacle.shape.holds(start) {
                let kind = obstacle.shape.kind();
                return blocked(format!("obstacle {index} (a {kind})"), distance);
            }
        }
        let shut = |door: &Door| !door.is_open;
        for (index, door) in self.doors.iter().enumerate().filter(|(_, d)| shut(d)) {
            let distance = door.leaf.distance(start);
            if distance < radius {
                return blocked(format!("door {index}"), distance);
            }
        }
        for (index, mover) in self.movers.iter().enumerate() {
            let first = mover.waypoints.first();
            let distance = first.map_or(f64::INFINITY, |p| (p - start).length());
            if distance < radius + mover.radius {
                return blocked(format!("mover {index}"), distance - mover.radius);
            }
        }
        Ok(())
    }
}
