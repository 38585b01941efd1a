//! What a feature truly shows: the walls, corners and round objects of a world.
//!
//! 1. A line's true wall is the one that rays from the true pose through the line meet; glass in
//!    front of the line only lets them through.
//! 2. A corner's true place is the nearest one where a side ends or another meets it, a circle's
//!    the nearest centre of a round obstacle, if it is near enough.
//!
//! Doors and people are not counted, because they do not stay.

use std::collections::BTreeMap;

use nalgebra::{Point2, Vector2};

use super::world::{Material, Shape, Wall, World};
use crate::geom::{Length, Pose2, Segment, ring_holds};

/// Glass this far in front of a line, m, did not send its beams back.
const BEFORE: f64 = 0.3;
/// Sine of the greatest angle between a line and its wall.
const SLANT: f64 = 0.2;
/// Sides that miss each other by less than this do meet, m.
const TOUCH: f64 = 1e-4;
/// Extents that miss each other by less than this are compared, m.
const NEAR: f64 = 10.0 * TOUCH;
/// Walls on one line are parallel to within this sine, and less than this apart, m.
const PARALLEL: f64 = 1e-3;
const ONE_LINE: f64 = 0.01;
/// A point of a sweep that is farther than this from a true object does not show it, m. What
/// odometry turns the point by within the sweep is added, m for each m of its distance.
const REACH: f64 = 0.1;
const REACH_PER_METRE: f64 = 0.03;

/// What a feature shows. Two are the same thing if they are equal; walls also if they lie on one
/// line ([`Thing::is_same`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Thing {
    /// A side of an obstacle.
    Wall {
        /// Its index in [`World::walls`].
        number: usize,
        /// Where it is.
        segment: Segment,
    },
    /// Where a side ends.
    Corner(Point2<f64>),
    /// The centre of something round.
    Round(Point2<f64>),
}

impl Thing {
    /// Whether a landmark of one is right for the other: the same thing, or walls on one line,
    /// which have the same direction and distance.
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Wall { segment: a, .. }, Self::Wall { segment: b, .. }) => {
                a == b || on_one_line(a, b)
            }
            (a, b) => a == b,
        }
    }
}

/// The things of a world, world frame.
#[derive(Clone, Debug)]
pub struct Things {
    walls: Vec<Wall>,
    corners: Vec<Point2<f64>>,
    round: Vec<Point2<f64>>,
}

impl Things {
    /// What a point found in a sweep of a driving robot shows, as in [`Self::of_point`], no farther
    /// away than odometry may have turned it meanwhile.
    #[must_use]
    pub fn of_point_in_sweep(
        &self,
        world_from_robot: &Pose2,
        point: Point2<f64>,
        is_round: bool,
    ) -> Option<Thing> {
        let reach = REACH + REACH_PER_METRE * point.coords.length();
        self.of_point(world_from_robot, point, is_round, reach)
    }

    /// The things of `world` that a lidar can see as they are; for glass, only walls, because a
    /// beam that meets it squarely comes back.
    #[must_use]
    pub fn of(world: &World) -> Self {
        let solid = (world.obstacles.iter()).filter(|o| o.material != Material::Glass);
        let (round, flat): (Vec<_>, Vec<_>) =
            solid.partition(|o| matches!(o.shape, Shape::Circle { .. }));
        let sides: Vec<Segment> = flat.iter().flat_map(|o| o.shape.segments()).collect();
        let rings: Vec<(Extent, Vec<Point2<f64>>)> = (flat.iter())
            .map(|o| o.shape.segments().iter().map(|side| side.a).collect())
            .map(|ring: Vec<Point2<f64>>| (Extent::of(&ring), ring))
            .collect();
        let mut corners = corners(&sides);
        corners.retain(|corner| {
            let at = Extent::of(&[*corner]);
            let near = rings.iter().filter(|(extent, _)| extent.meets(&at));
            !near
                .map(|(_, ring)| ring)
                .any(|ring| is_inside(ring, *corner))
        });
        let middles = round.iter().filter_map(|o| match o.shape {
            Shape::Circle { centre, .. } => Some(centre),
            _ => None,
        });
        Self {
            walls: world.walls(),
            corners,
            round: middles.collect(),
        }
    }

    /// The wall that most of three rays through a line with these `ends` meet, in the robot frame
    /// at `world_from_robot`; `None` if they do not agree on one that is parallel to it.
    #[must_use]
    pub fn of_line(&self, world_from_robot: &Pose2, ends: [Point2<f64>; 2]) -> Option<Thing> {
        let [a, b] = ends.map(|end| *world_from_robot * end);
        let (origin, length) = (world_from_robot.position(), (b - a).length());
        let hits = [0.25, 0.5, 0.75].map(|part| {
            let way = a + (b - a) * part - origin;
            let towards = way / way.length();
            let distances = self.walls.iter().enumerate().filter_map(|(index, wall)| {
                let distance = wall.segment.hit_by_ray(origin, towards)?;
                let is_glass_before =
                    wall.material == Material::Glass && distance < way.length() - BEFORE;
                (!is_glass_before).then_some((index, distance))
            });
            let nearest = distances.min_by(|a, b| a.1.total_cmp(&b.1))?.0;
            let wall = self.walls.get(nearest)?.segment.vector();
            let slant = (b - a).perp(&wall) / (length * wall.length());
            (slant.abs() < SLANT).then_some(nearest)
        });
        let [first, second, third] = hits;
        let agreed = second
            .filter(|_| second == first || second == third)
            .or(first.filter(|_| first == third))?;
        Some(Thing::Wall {
            number: agreed,
            segment: self.walls.get(agreed)?.segment,
        })
    }

    /// What a point shows, in the robot frame at `world_from_robot`: the nearest round thing or the
    /// nearest corner, no farther than `reach`, m.
    #[must_use]
    pub fn of_point(
        &self,
        world_from_robot: &Pose2,
        point: Point2<f64>,
        is_round: bool,
        reach: f64,
    ) -> Option<Thing> {
        let at = *world_from_robot * point;
        let things = if is_round { &self.round } else { &self.corners };
        let off = |thing: &Point2<f64>| (thing - at).length();
        let nearest = things.iter().min_by(|a, b| off(a).total_cmp(&off(b)))?;
        let thing = if is_round {
            Thing::Round(*nearest)
        } else {
            Thing::Corner(*nearest)
        };
        (off(nearest) <= reach).then_some(thing)
    }
}

/// The axis-aligned rectangle around some places.
struct Extent {
    low: Point2<f64>,
    high: Point2<f64>,
}

impl Extent {
    fn of(places: &[Point2<f64>]) -> Self {
        let far = f64::INFINITY;
        let nothing = (Point2::new(far, far), Point2::new(-far, -far));
        let (low, high) = (places.iter()).fold(nothing, |(low, high), place| {
            (low.inf(place), high.sup(place))
        });
        Self { low, high }
    }

    /// Whether two extents share a place, or nearly.
    fn meets(&self, other: &Self) -> bool {
        self.reaches(other.low.x)
            && other.reaches(self.low.x)
            && self.low.y <= other.high.y + NEAR
            && other.low.y <= self.high.y + NEAR
    }

    /// Whether it extends to the right as far as this, or nearly.
    fn reaches(&self, x: f64) -> bool {
        x <= self.high.x + NEAR
    }
}

/// Ends of all sides, and where one side meets another: the visible corners of shapes that overlap.
/// Each place once.
fn corners(sides: &[Segment]) -> Vec<Point2<f64>> {
    let mut found = Places::default();
    for side in sides {
        found.add(side.a);
        found.add(side.b);
    }
    for (a, near) in sides.iter().zip(near_each_other(sides)) {
        let along = a.b - a.a;
        let (length, way) = (along.length(), along / along.length());
        // From a little before its end, so that a side that it only touches is met.
        let from = a.a - way * TOUCH;
        let met = near
            .into_iter()
            .filter_map(|b| sides[b].hit_by_ray(from, way));
        let within = met.filter(|distance| *distance <= length + 2.0 * TOUCH);
        within.for_each(|distance| found.add(from + way * distance));
    }
    found.list
}

/// For each side, the others whose extents share a place with its own, in their order. Large worlds
/// have thousands of sides, most of them far from each other: a sweep from left to right compares
/// only those that overlap in x.
fn near_each_other(sides: &[Segment]) -> Vec<Vec<usize>> {
    let extents: Vec<Extent> = sides.iter().map(|s| Extent::of(&[s.a, s.b])).collect();
    let mut order: Vec<usize> = (0..sides.len()).collect();
    order.sort_by(|&a, &b| extents[a].low.x.total_cmp(&extents[b].low.x));
    let mut near = vec![vec![]; sides.len()];
    let mut open: Vec<usize> = vec![];
    for this in order {
        open.retain(|&other| extents[other].reaches(extents[this].low.x));
        for &other in &open {
            if extents[this].meets(&extents[other]) {
                near[this].push(other);
                near[other].push(this);
            }
        }
        open.push(this);
    }
    near.iter_mut().for_each(|others| others.sort_unstable());
    near
}

/// Places, each once: those nearer than [`TOUCH`] to one are the same.
#[derive(Default)]
struct Places {
    list: Vec<Point2<f64>>,
    /// Which of them lie in a square of that size.
    by_square: BTreeMap<(i64, i64), Vec<usize>>,
}

impl Places {
    fn add(&mut self, at: Point2<f64>) {
        let [col, row] = [at.x, at.y].map(|v| libm::floor(v / TOUCH) as i64);
        let beside = |square: i64| [square.saturating_sub(1), square, square.saturating_add(1)];
        let is_known = (beside(col).into_iter())
            .flat_map(|col| beside(row).map(|row| (col, row)))
            .filter_map(|square| self.by_square.get(&square))
            .flatten()
            .any(|&known| (self.list[known] - at).length() < TOUCH);
        if !is_known {
            let square = self.by_square.entry((col, row)).or_default();
            square.push(self.list.len());
            self.list.push(at);
        }
    }
}

/// Whether a place is within an outline and not on its border: nobody sees the end of a wall that
/// stands inside another one.
fn is_inside(ring: &[Point2<f64>], place: Point2<f64>) -> bool {
    let around = [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)];
    let mut around = around
        .map(|(x, y)| place + Vector2::new(x, y) * (10.0 * TOUCH))
        .into_iter();
    ring.len() > 2 && around.all(|near| ring_holds(ring, near))
}

fn on_one_line(wall: &Segment, other: &Segment) -> bool {
    let along = wall.vector() / wall.vector().length();
    let off = |p: Point2<f64>| along.perp(&(p - wall.a)).abs();
    let across = other.vector() / other.vector().length();
    along.perp(&across).abs() < PARALLEL && off(other.a) < ONE_LINE && off(other.b) < ONE_LINE
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::sim::worlds;

    /// Every side with every other, and every place with all before it.
    fn corners_by_all_pairs(sides: &[Segment]) -> Vec<Point2<f64>> {
        let ends = sides.iter().flat_map(|side| [side.a, side.b]);
        let met = sides.iter().enumerate().flat_map(|(i, a)| {
            let way = (a.b - a.a) / a.vector().length();
            let from = a.a - way * TOUCH;
            let others = sides.iter().enumerate().filter(move |(j, _)| *j != i);
            others.filter_map(move |(_, b)| {
                let distance = b.hit_by_ray(from, way)?;
                (distance <= a.vector().length() + 2.0 * TOUCH).then(|| from + way * distance)
            })
        });
        let mut found: Vec<Point2<f64>> = vec![];
        for at in ends.chain(met) {
            if !found.iter().any(|known| (known - at).length() < TOUCH) {
                found.push(at);
            }
        }
        found
    }

    #[test]
    fn corners_of_every_world_are_those_that_all_pairs_have() {
        for name in ["office", "warehouse", "look-alikes"] {
            let world = worlds::builtin(name).unwrap();
            let shapes = world.obstacles.iter().flat_map(|o| o.shape.segments());
            let sides: Vec<Segment> = shapes.collect();
            assert!(
                !sides.is_empty() && corners(&sides) == corners_by_all_pairs(&sides),
                "{name}"
            );
        }
    }

    proptest! {
        /// On a raster, so sides touch, cross and lie on one another.
        #[test]
        fn corners_are_those_that_all_pairs_have(
            ends in prop::collection::vec(((-5..5, -5..5), (-5..5, -5..5)), 0..40)
        ) {
            let at = |(x, y): (i32, i32)| Point2::new(f64::from(x), f64::from(y)) * 0.7;
            let sides: Vec<Segment> = (ends.into_iter())
                .filter(|(a, b)| a != b)
                .map(|(a, b)| Segment::new(at(a), at(b)))
                .collect();
            prop_assert_eq!(corners(&sides), corners_by_all_pairs(&sides));
        }
    }

    #[test]
    fn what_lies_on_a_wall_is_of_that_wall_from_any_pose() {
        let world = worlds::builtin("office").unwrap();
        let things = Things::of(&world);
        let pose = Pose2::new(world.start.x(), world.start.y(), 0.7);
        let mut found = 0;
        for (index, wall) in things.walls.iter().enumerate() {
            // A piece of the wall with nothing in front of it.
            let piece = [0.45, 0.55].map(|part| wall.segment.a + wall.segment.vector() * part);
            let origin = pose.position();
            let is_hidden = things.walls.iter().enumerate().any(|(other, before)| {
                other != index
                    && piece.iter().any(|end| {
                        before
                            .segment
                            .crosses(&Segment::new(origin, end + (origin - end) * 1e-3))
                    })
            });
            if is_hidden || wall.material == Material::Glass {
                continue;
            }
            let [a, b] = piece.map(|end| pose.inverse() * end);
            let thing = things.of_line(&pose, [a, b]);
            // Rays along a wall meet only its ends.
            let way = piece[0] - origin;
            let slant =
                way.perp(&wall.segment.vector()) / (way.length() * wall.segment.vector().length());
            if slant.abs() > 0.05 {
                let truth = Thing::Wall {
                    number: index,
                    segment: wall.segment,
                };
                assert!(thing.unwrap().is_same(&truth), "{index}");
                found += 1;
            }
        }
        assert!(found >= 4, "{found}");
    }

    #[test]
    fn points_are_of_the_nearest_thing_of_their_kind() {
        let things = Things::of(&worlds::builtin("arena").unwrap());
        let pose = Pose2::new(1.0, 1.0, -2.0);
        let off = Vector2::new(0.03, -0.04);
        for &corner in &things.corners {
            let of = things.of_point(&pose, pose.inverse() * (corner + off), false, 0.1);
            let Some(Thing::Corner(at)) = of else {
                panic!("{corner} is {of:?}");
            };
            assert!((at - corner).length() <= 2.0 * off.length());
        }
        for &middle in &things.round {
            let near = pose.inverse() * (middle + off);
            let of = |reach| things.of_point(&pose, near, true, reach);
            assert_eq!((of(0.1), of(0.04)), (Some(Thing::Round(middle)), None));
        }
        assert!(!things.corners.is_empty());
        let far = Point2::new(500.0, 0.0);
        assert_eq!(things.of_point(&pose, far, true, 0.1), None);
    }

    /// Compared with all sides and outlines, near or not.
    #[test]
    fn what_is_far_is_passed_over_without_loss() {
        for name in ["office", "warehouse", "lab"] {
            let world = worlds::builtin(name).unwrap();
            let solid = (world.obstacles.iter()).filter(|o| o.material != Material::Glass);
            let flat: Vec<_> = solid
                .filter(|o| !matches!(o.shape, Shape::Circle { .. }))
                .collect();
            let sides: Vec<Segment> = flat.iter().flat_map(|o| o.shape.segments()).collect();
            let mut ends: Vec<Point2<f64>> = sides.iter().flat_map(|s| [s.a, s.b]).collect();
            for a in &sides {
                let way = a.vector() / a.vector().length();
                let from = a.a - way * TOUCH;
                let others = sides.iter().filter(|b| *b != a);
                let met = others.filter_map(|b| b.hit_by_ray(from, way));
                let within = met.filter(|d| *d <= a.vector().length() + 2.0 * TOUCH);
                ends.extend(within.map(|d| from + way * d));
            }
            ends.retain(|end| {
                !flat.iter().any(|o| {
                    let ring: Vec<_> = o.shape.segments().iter().map(|side| side.a).collect();
                    is_inside(&ring, *end)
                })
            });
            let things = Things::of(&world);
            let has = |list: &[Point2<f64>], at: &Point2<f64>| {
                list.iter().any(|other| (other - at).length() < 2.0 * TOUCH)
            };
            assert!(!things.corners.is_empty());
            assert!(ends.iter().all(|end| has(&things.corners, end)), "{name}");
            assert!(things.corners.iter().all(|at| has(&ends, at)), "{name}");
        }
    }

    #[test]
    fn corners_within_another_obstacle_are_none() {
        let ring = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)].map(|(x, y)| Point2::new(x, y));
        for (x, y, expect) in [
            (1.0, 0.5, true),
            (0.01, 0.01, true),
            (2.0, 0.5, false),
            (0.0, 0.0, false),
            (1.0, 1.2, false),
        ] {
            assert_eq!(is_inside(&ring, Point2::new(x, y)), expect, "{x} {y}");
        }
        assert!(!is_inside(&ring[..2], Point2::new(1.0, 0.0)));
    }

    #[test]
    fn walls_on_one_line_are_the_same_thing_and_others_not() {
        let wall = |ax: f64, ay: f64, bx: f64, by: f64| Thing::Wall {
            number: 0,
            segment: Segment::new(Point2::new(ax, ay), Point2::new(bx, by)),
        };
        let own = wall(0.0, 0.0, 2.0, 0.0);
        assert!(own.is_same(&wall(3.0, 0.0, 5.0, 0.0)));
        assert!(own.is_same(&wall(5.0, 0.0, 3.0, 0.0)));
        assert!(!own.is_same(&wall(0.0, 0.1, 2.0, 0.1)));
        assert!(!own.is_same(&wall(2.0, 0.0, 2.0, 3.0)));
        assert!(!own.is_same(&Thing::Corner(Point2::origin())));
    }
}
