//! What stands in the building, and where the robot starts.
//!
//! Obstacles are kept as the shapes they were drawn as (an editor and a file want those back) and flattened to
//! straight [`Wall`]s for ray casting and collision: a circle becomes a polygon inscribed to within
//! [`CIRCLE_SAGITTA`]. The flattened walls ARE the truth, for the sensors and for the robot's body alike.
//!
//! Polygons, rectangles and circles are solid; the outline of a room is a closed polyline.

use std::f64::consts::TAU;

use nalgebra::{Point2, Vector2};

use super::SensorKind;
use crate::geom::{Pose2, Segment, sin_cos};
use crate::robot::RobotModel;

/// Greatest distance between a circle and its polygon, m.
const CIRCLE_SAGITTA: f64 = 0.002;
/// Coordinates beyond this are refused, m.
const FARTHEST: f64 = 10_000.0;
/// More walls than this are refused.
const MOST_WALLS: usize = 200_000;
/// More movers than this are refused.
const MOST_MOVERS: usize = 1_000;

/// A building to explore, in the world frame.
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    /// Name, for people.
    pub name: String,
    /// What stands still.
    pub obstacles: Vec<Obstacle>,
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
    /// The seed that is used where nobody chooses another.
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
    /// Reflects so little that it is seen from near only.
    Dark,
}

/// A still object: a shape of one material.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// Its outline.
    pub shape: Shape,
    /// Its surface.
    pub material: Material,
}

/// Outlines, in metres.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Thin walls from point to point; closed ones return to the first, as the outline of a room does.
    Polyline {
        /// At least two corners.
        points: Vec<Point2<f64>>,
        /// Whether the last corner joins the first.
        closed: bool,
    },
    /// A solid polygon.
    Polygon(Vec<Point2<f64>>),
    /// A solid rectangle.
    Rectangle {
        /// Its middle.
        centre: Point2<f64>,
        /// Full width along its own x and its own y.
        size: Vector2<f64>,
        /// Turn of its own x axis from the world's, rad.
        angle: f64,
    },
    /// A solid disc.
    Circle {
        /// Its middle.
        centre: Point2<f64>,
        /// Its radius.
        radius: f64,
    },
}

/// A disc that walks along way-points: a person, another robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Mover {
    /// Corners of its way; it starts at the first.
    pub waypoints: Vec<Point2<f64>>,
    /// Whether it walks on from the last way-point to the first; otherwise it walks the same way back.
    pub closed: bool,
    /// Walking speed, m/s.
    pub speed: f64,
    /// Radius of its disc, m.
    pub radius: f64,
}

/// A disc: where a mover is now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Its middle, world frame.
    pub centre: Point2<f64>,
    /// Its radius, m.
    pub radius: f64,
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

/// Why a [`World`] cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WorldError {
    /// A figure outside of its range.
    #[error("{part}: {field} is {value}, expected {expected}")]
    Value {
        /// The part of the world: "start", "obstacle 3", "mover 0".
        part: String,
        /// The field of that part.
        field: &'static str,
        /// What stands there.
        value: f64,
        /// What may stand there.
        expected: &'static str,
    },
    /// A list too short or too long.
    #[error("{part}: has {count} {field}, expected {expected}")]
    Count {
        /// The part of the world.
        part: String,
        /// What is counted.
        field: &'static str,
        /// How many there are.
        count: usize,
        /// How many there may be.
        expected: &'static str,
    },
    /// The robot cannot stand where it should start.
    #[error(
        "start: a robot of radius {radius} m at ({x}, {y}) stands in {what}, {distance:.3} m from its surface; \
         expected free room of at least the radius"
    )]
    StartBlocked {
        /// Start, m.
        x: f64,
        /// Start, m.
        y: f64,
        /// Radius of the robot, m.
        radius: f64,
        /// What it collides with.
        what: String,
        /// Distance of the robot's middle from that surface, m.
        distance: f64,
    },
}

impl World {
    /// An empty world.
    #[must_use]
    pub fn new(name: impl Into<String>, start: Pose2) -> Self {
        Self {
            name: name.into(),
            obstacles: Vec::new(),
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
        self.with(Shape::Polyline {
            points: points(corners),
            closed: false,
        })
    }

    /// Adds the outline of a room.
    #[must_use]
    pub fn with_room(self, corners: &[(f64, f64)]) -> Self {
        self.with(Shape::Polyline {
            points: points(corners),
            closed: true,
        })
    }

    /// Adds a solid opaque box between two opposite corners.
    #[must_use]
    pub fn with_box(self, (x0, y0): (f64, f64), (x1, y1): (f64, f64)) -> Self {
        self.with_turned_box(
            (0.5 * (x0 + x1), 0.5 * (y0 + y1)),
            ((x1 - x0).abs(), (y1 - y0).abs()),
            0.0,
        )
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

    /// Every straight piece of surface, in the order of the obstacles.
    #[must_use]
    pub fn walls(&self) -> Vec<Wall> {
        let of_obstacle = |obstacle: &Obstacle| {
            let material = obstacle.material;
            obstacle
                .shape
                .segments()
                .into_iter()
                .map(move |segment| Wall { segment, material })
        };
        self.obstacles.iter().flat_map(of_obstacle).collect()
    }

    /// The least rectangle around walls, start and goal, as (lower corner, upper corner).
    #[must_use]
    pub fn bounds(&self) -> (Point2<f64>, Point2<f64>) {
        let ends = self
            .walls()
            .into_iter()
            .flat_map(|w| [w.segment.a, w.segment.b]);
        let ways = self.movers.iter().flat_map(|m| m.waypoints.iter().copied());
        let start = self.start.position();
        ends.chain(ways)
            .chain(self.goal)
            .fold((start, start), |(low, high), p| (low.inf(&p), high.sup(&p)))
    }

    /// Checks the figures, and that a robot of `radius` (m) can stand at the start.
    ///
    /// # Errors    [`WorldError`], naming the first part that cannot be used.
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
        check_count(
            "world",
            "walls",
            walls,
            walls <= MOST_WALLS,
            "at most 200000",
        )?;
        let movers = self.movers.len();
        check_count(
            "world",
            "movers",
            movers,
            movers <= MOST_MOVERS,
            "at most 1000",
        )?;
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
        for (index, mover) in self.movers.iter().enumerate() {
            let distance = mover
                .waypoints
                .first()
                .map_or(f64::INFINITY, |p| (p - start).norm());
            if distance < radius + mover.radius {
                return blocked(format!("mover {index}"), distance - mover.radius);
            }
        }
        Ok(())
    }
}

impl Shape {
    /// What the world file calls it.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Polyline { .. } => "polyline",
            Self::Polygon(_) => "polygon",
            Self::Rectangle { .. } => "rectangle",
            Self::Circle { .. } => "circle",
        }
    }

    /// Its straight pieces.
    #[must_use]
    pub fn segments(&self) -> Vec<Segment> {
        let (corners, closed) = self.corners();
        let mut segments: Vec<Segment> = corners
            .iter()
            .zip(corners.iter().skip(1))
            .map(|(&a, &b)| Segment::new(a, b))
            .collect();
        if let (true, [first, _, .., last]) = (closed, corners.as_slice()) {
            segments.push(Segment::new(*last, *first));
        }
        segments
    }

    /// Whether `point` lies inside of it; a polyline has no inside.
    ///
    /// Source: crossing number, Shimrat (1962), Algorithm 112.
    #[must_use]
    pub fn holds(&self, point: Point2<f64>) -> bool {
        if matches!(self, Self::Polyline { .. }) {
            return false;
        }
        let crossed = |s: &Segment| {
            (s.a.y > point.y) != (s.b.y > point.y)
                && point.x < s.a.x + (point.y - s.a.y) / (s.b.y - s.a.y) * (s.b.x - s.a.x)
        };
        self.segments().iter().filter(|s| crossed(s)).count() % 2 == 1
    }

    fn corners(&self) -> (Vec<Point2<f64>>, bool) {
        match self {
            Self::Polyline { points, closed } => (points.clone(), *closed),
            Self::Polygon(points) => (points.clone(), true),
            Self::Rectangle {
                centre,
                size,
                angle,
            } => {
                let (sin, cos) = sin_cos(*angle);
                let u = Vector2::new(cos, sin) * (0.5 * size.x);
                let v = Vector2::new(-sin, cos) * (0.5 * size.y);
                (
                    vec![
                        centre - u - v,
                        centre + u - v,
                        centre + u + v,
                        centre - u + v,
                    ],
                    true,
                )
            }
            Self::Circle { centre, radius } => {
                let sides = circle_sides(*radius);
                let corner = |i: usize| {
                    let (sin, cos) = sin_cos(TAU * i as f64 / sides as f64);
                    centre + Vector2::new(cos, sin) * *radius
                };
                ((0..sides).map(corner).collect(), true)
            }
        }
    }

    fn segment_count(&self) -> usize {
        match self {
            Self::Polyline { points, closed } => {
                (points.len() + usize::from(*closed)).saturating_sub(1)
            }
            Self::Polygon(points) => points.len(),
            Self::Rectangle { .. } => 4,
            Self::Circle { radius, .. } => circle_sides(*radius),
        }
    }

    fn check(&self, part: &str) -> Result<(), WorldError> {
        let size = |field, value: f64| {
            let fits = (0.001..=FARTHEST).contains(&value);
            check_value(part, field, value, fits, "0.001 to 10000 m")
        };
        match self {
            Self::Polyline { points, closed } => {
                let least = if *closed { 3 } else { 2 };
                let expected = "at least 2, or 3 where closed";
                check_count(
                    part,
                    "points",
                    points.len(),
                    points.len() >= least,
                    expected,
                )?;
                points.iter().try_for_each(|p| check_point(part, p))
            }
            Self::Polygon(points) => {
                check_count(
                    part,
                    "points",
                    points.len(),
                    points.len() >= 3,
                    "at least 3",
                )?;
                points.iter().try_for_each(|p| check_point(part, p))
            }
            Self::Rectangle {
                centre,
                size: full,
                angle,
            } => {
                check_point(part, centre)?;
                size("size x", full.x)?;
                size("size y", full.y)?;
                check_coordinate(part, "angle", *angle)
            }
            Self::Circle { centre, radius } => {
                check_point(part, centre)?;
                size("radius", *radius)
            }
        }
    }
}

impl Mover {
    fn check(&self, part: &str) -> Result<(), WorldError> {
        let count = self.waypoints.len();
        check_count(
            part,
            "waypoints",
            count,
            (1..=10_000).contains(&count),
            "1 to 10000",
        )?;
        self.waypoints
            .iter()
            .try_for_each(|p| check_point(part, p))?;
        let speed_fits = (0.0..=20.0).contains(&self.speed);
        check_value(part, "speed", self.speed, speed_fits, "0 to 20 m/s")?;
        let radius_fits = (0.01..=10.0).contains(&self.radius);
        check_value(part, "radius", self.radius, radius_fits, "0.01 to 10 m")
    }
}

fn points(corners: &[(f64, f64)]) -> Vec<Point2<f64>> {
    corners.iter().map(|&(x, y)| Point2::new(x, y)).collect()
}

/// Sides of the polygon that stays within [`CIRCLE_SAGITTA`] of a circle: r (1 - cos(π/n)) ≈ r π²/(2 n²).
fn circle_sides(radius: f64) -> usize {
    let sides = std::f64::consts::PI * (radius / (2.0 * CIRCLE_SAGITTA)).sqrt();
    (sides.ceil() as usize).clamp(8, 512)
}

fn check_point(part: &str, point: &Point2<f64>) -> Result<(), WorldError> {
    check_coordinate(part, "x", point.x)?;
    check_coordinate(part, "y", point.y)
}

fn check_coordinate(part: &str, field: &'static str, value: f64) -> Result<(), WorldError> {
    check_value(
        part,
        field,
        value,
        value.abs() <= FARTHEST,
        "a finite number within ±10000",
    )
}

fn check_value(
    part: &str,
    field: &'static str,
    value: f64,
    fits: bool,
    expected: &'static str,
) -> Result<(), WorldError> {
    if fits {
        return Ok(());
    }
    Err(WorldError::Value {
        part: part.to_owned(),
        field,
        value,
        expected,
    })
}

fn check_count(
    part: &str,
    field: &'static str,
    count: usize,
    fits: bool,
    expected: &'static str,
) -> Result<(), WorldError> {
    if fits {
        return Ok(());
    }
    Err(WorldError::Count {
        part: part.to_owned(),
        field,
        count,
        expected,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygon_of_a_circle_stays_within_two_millimetres() {
        for radius in [0.05, 0.3, 2.0] {
            let circle = Shape::Circle {
                centre: Point2::new(1.0, -2.0),
                radius,
            };
            for segment in circle.segments() {
                let nearest = segment.distance(Point2::new(1.0, -2.0));
                assert!(
                    radius - nearest <= CIRCLE_SAGITTA * 1.01,
                    "{radius}: {nearest}"
                );
            }
            assert_eq!(circle.segments().len(), circle.segment_count());
        }
    }

    #[test]
    fn turned_rectangle_holds_what_it_should() {
        let shape = Shape::Rectangle {
            centre: Point2::new(1.0, 1.0),
            size: Vector2::new(2.0, 0.2),
            angle: std::f64::consts::FRAC_PI_4,
        };
        assert!(shape.holds(Point2::new(1.5, 1.5)));
        assert!(!shape.holds(Point2::new(1.5, 0.5)));
        assert_eq!(shape.segments().len(), 4);
    }

    #[test]
    fn bad_figures_are_named() {
        let room = World::new("room", Pose2::identity()).with_room(&[
            (-1.0, -1.0),
            (1.0, -1.0),
            (1.0, 1.0),
            (-1.0, 1.0),
        ]);
        assert_eq!(room.validate(0.1), Ok(()));
        let message = |world: World| world.validate(0.1).unwrap_err().to_string();
        let inside = message(room.clone().with_pillar((0.0, 0.0), 0.5));
        assert!(
            inside.contains("robot of radius 0.1 m at (0, 0) stands in obstacle 1 (a circle)"),
            "{inside}"
        );
        let near = message(room.clone().with_walls(&[(0.05, -1.0), (0.05, 1.0)]));
        assert!(near.contains("0.050 m from its surface"), "{near}");
        let flat = message(room.clone().with_turned_box((5.0, 5.0), (0.0, 1.0), 0.0));
        assert!(flat.contains("obstacle 1: size x is 0"), "{flat}");
        let far = message(room.clone().with_walls(&[(0.0, 5.0), (f64::NAN, 5.0)]));
        assert!(far.contains("obstacle 1: x is NaN"), "{far}");
        let short = message(room.with_walls(&[(0.0, 5.0)]));
        assert!(short.contains("has 1 points"), "{short}");
    }
}
