//! The fields of a world file, and their conversion to a [`World`] and back.

use nalgebra::{Point2, Vector2};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

use crate::geom::{Pose2, Segment};
use crate::sim::{Door, Material, Mover, Obstacle, RobotKind, SensorKind, Shape, World};

/// The longest name, bytes.
const LONGEST_NAME: usize = 200;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a world { \"slamlab_world\": 1, … }")]
pub(super) struct WorldFile {
    #[serde(deserialize_with = "version")]
    slamlab_world: u32,
    #[serde(deserialize_with = "name")]
    name: String,
    start: PoseFile,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    goal: Option<PointFile>,
    #[serde(default, with = "RobotFile")]
    robot: RobotKind,
    #[serde(default, with = "SensorFile")]
    sensor: SensorKind,
    #[serde(default = "first_seed")]
    seed: u64,
    obstacles: Vec<ObstacleFile>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    doors: Vec<DoorFile>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    movers: Vec<MoverFile>,
}

#[derive(Serialize, Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "a pose { \"x\": …, \"y\": …, \"heading\": … }"
)]
struct PoseFile {
    x: f64,
    y: f64,
    #[serde(default)]
    heading: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a point { \"x\": …, \"y\": … }")]
struct PointFile {
    x: f64,
    y: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "RobotKind", rename_all = "snake_case")]
enum RobotFile {
    Rp6,
    Pioneer,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "SensorKind", rename_all = "snake_case")]
enum SensorFile {
    Lidar,
    Sick,
    Rangers,
    Sonar,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Material", rename_all = "snake_case")]
enum MaterialFile {
    Opaque,
    Glass,
    Dark,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum ShapeFile {
    #[default]
    Polyline,
    Polygon,
    Rectangle,
    Circle,
}

/// All shapes in one flat record: a tagged enum would lose the line of an error inside it.
#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an obstacle { \"shape\": …, … }")]
struct ObstacleFile {
    shape: ShapeFile,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    points: Option<Vec<[f64; 2]>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    closed: Option<bool>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    centre: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    size: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    angle: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    radius: Option<f64>,
    #[serde(default, with = "MaterialFile", skip_serializing_if = "is_default")]
    material: Material,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a door { \"from\": …, \"to\": … }")]
struct DoorFile {
    from: [f64; 2],
    to: [f64; 2],
    #[serde(default)]
    open: bool,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    switches: Vec<f64>,
}

#[derive(Serialize, Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "a mover { \"waypoints\": …, \"speed\": …, \"radius\": … }"
)]
struct MoverFile {
    waypoints: Vec<[f64; 2]>,
    #[serde(default)]
    closed: bool,
    speed: f64,
    radius: f64,
    #[serde(default, skip_serializing_if = "is_default")]
    pause: f64,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

fn first_seed() -> u64 {
    1
}

fn version<'de, D: Deserializer<'de>>(from: D) -> Result<u32, D::Error> {
    match u32::deserialize(from)? {
        1 => Ok(1),
        other => Err(D::Error::custom(format!(
            "slamlab_world is {other}, expected 1"
        ))),
    }
}

fn name<'de, D: Deserializer<'de>>(from: D) -> Result<String, D::Error> {
    let name = String::deserialize(from)?;
    if name.len() <= LONGEST_NAME {
        return Ok(name);
    }
    let bytes = name.len();
    let error = format!("name has {bytes} bytes, expected at most {LONGEST_NAME}");
    Err(D::Error::custom(error))
}

impl ObstacleFile {
    fn into_obstacle(self) -> Result<Obstacle, String> {
        self.refuse_strangers()?;
        let material = self.material;
        let shape = match self.shape {
            ShapeFile::Polyline => Shape::Polyline {
                points: points(&need("polyline", "points", self.points)?),
                closed: self.closed.unwrap_or(false),
            },
            ShapeFile::Polygon => Shape::Polygon(points(&need("polygon", "points", self.points)?)),
            ShapeFile::Rectangle => Shape::Rectangle {
                centre: need("rectangle", "centre", self.centre)?.into(),
                size: Vector2::from(need("rectangle", "size", self.size)?),
                angle: self.angle.unwrap_or(0.0),
            },
            ShapeFile::Circle => Shape::Circle {
                centre: need("circle", "centre", self.centre)?.into(),
                radius: need("circle", "radius", self.radius)?,
            },
        };
        Ok(Obstacle { shape, material })
    }

    /// A field that belongs to another shape is an error.
    fn refuse_strangers(&self) -> Result<(), String> {
        let (kind, fields): (_, &[&str]) = match self.shape {
            ShapeFile::Polyline => ("polyline", &["points", "closed"]),
            ShapeFile::Polygon => ("polygon", &["points"]),
            ShapeFile::Rectangle => ("rectangle", &["centre", "size", "angle"]),
            ShapeFile::Circle => ("circle", &["centre", "radius"]),
        };
        let given = [
            ("points", self.points.is_some()),
            ("closed", self.closed.is_some()),
            ("centre", self.centre.is_some()),
            ("size", self.size.is_some()),
            ("angle", self.angle.is_some()),
            ("radius", self.radius.is_some()),
        ];
        let is_strange = |(field, given): &&(&str, bool)| *given && !fields.contains(field);
        let Some((field, _)) = given.iter().find(is_strange) else {
            return Ok(());
        };
        let expected = fields.join("`, `");
        Err(format!(
            "{kind} has the field `{field}`, expected only `{expected}`"
        ))
    }

    fn of(obstacle: &Obstacle) -> Self {
        let bare = |shape| Self {
            shape,
            material: obstacle.material,
            ..Self::default()
        };
        match &obstacle.shape {
            Shape::Polyline { points, closed } => Self {
                points: Some(pairs(points)),
                closed: closed.then_some(true),
                ..bare(ShapeFile::Polyline)
            },
            Shape::Polygon(points) => Self {
                points: Some(pairs(points)),
                ..bare(ShapeFile::Polygon)
            },
            Shape::Rectangle {
                centre,
                size,
                angle,
            } => Self {
                centre: Some([centre.x, centre.y]),
                size: Some([size.x, size.y]),
                angle: Some(*angle),
                ..bare(ShapeFile::Rectangle)
            },
            Shape::Circle { centre, radius } => Self {
                centre: Some([centre.x, centre.y]),
                radius: Some(*radius),
                ..bare(ShapeFile::Circle)
            },
        }
    }
}

fn need<T>(kind: &str, field: &str, value: Option<T>) -> Result<T, String> {
    value.ok_or_else(|| format!("{kind} lacks the field `{field}`"))
}

fn points(pairs: &[[f64; 2]]) -> Vec<Point2<f64>> {
    pairs.iter().map(|&p| p.into()).collect()
}

fn pairs(points: &[Point2<f64>]) -> Vec<[f64; 2]> {
    points.iter().map(|p| [p.x, p.y]).collect()
}

impl WorldFile {
    /// The world, or the number of the first invalid obstacle and why.
    pub(super) fn into_world(self) -> Result<World, (usize, String)> {
        let mover = |m: MoverFile| Mover {
            waypoints: points(&m.waypoints),
            closed: m.closed,
            speed: m.speed,
            radius: m.radius,
            pause: m.pause,
        };
        let door = |d: DoorFile| Door {
            leaf: Segment::new(d.from.into(), d.to.into()),
            is_open: d.open,
            switches: d.switches,
        };
        let obstacle =
            |(index, o): (usize, ObstacleFile)| o.into_obstacle().map_err(|e| (index, e));
        let obstacles = self.obstacles.into_iter().enumerate().map(obstacle);
        Ok(World {
            name: self.name,
            obstacles: obstacles.collect::<Result<_, _>>()?,
            doors: self.doors.into_iter().map(door).collect(),
            movers: self.movers.into_iter().map(mover).collect(),
            start: Pose2::new(self.start.x, self.start.y, self.start.heading),
            goal: self.goal.map(|g| Point2::new(g.x, g.y)),
            robot: self.robot,
            sensor: self.sensor,
            seed: self.seed,
        })
    }
}

impl From<&World> for WorldFile {
    fn from(world: &World) -> Self {
        let mover = |m: &Mover| MoverFile {
            waypoints: pairs(&m.waypoints),
            closed: m.closed,
            speed: m.speed,
            radius: m.radius,
            pause: m.pause,
        };
        let door = |d: &Door| DoorFile {
            from: [d.leaf.a.x, d.leaf.a.y],
            to: [d.leaf.b.x, d.leaf.b.y],
            open: d.is_open,
            switches: d.switches.clone(),
        };
        Self {
            slamlab_world: 1,
            name: world.name.clone(),
            start: PoseFile {
                x: world.start.x(),
                y: world.start.y(),
                heading: world.start.heading(),
            },
            goal: world.goal.map(|g| PointFile { x: g.x, y: g.y }),
            robot: world.robot,
            sensor: world.sensor,
            seed: world.seed,
            obstacles: world.obstacles.iter().map(ObstacleFile::of).collect(),
            doors: world.doors.iter().map(door).collect(),
            movers: world.movers.iter().map(mover).collect(),
        }
    }
}
