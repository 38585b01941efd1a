//! Two scans in a built-in world, and the motion between them, for testing registration.
//!
//! In: a seed and a condition. Out: the hits of a sensor at two poses, each in its own frame.
//!
//! Poses are up to [`SHIFT`] and [`TURN`] apart and see each other. How well the visible walls
//! constrain each direction is computed from the walls themselves, not from the scans, so pairs
//! along corridors can be left out, or looked for.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix2, Matrix3, Point2, SymmetricEigen, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{Caster, World, worlds};
use crate::geom::{Length, Pose2, gaussian_pair, unit_vector, wrap};

/// Beams of a scan, all round.
pub const BEAMS: usize = 360;
/// How far two scans are apart at most, m.
pub const SHIFT: f64 = 1.0;
/// How much they are turned at most, rad.
pub const TURN: f64 = PI / 4.0;
/// If a direction gets less than this part of the walls' information, the motion is not determined.
pub const LEAST_SHARE: f64 = 0.04;
/// A direction with less than this part is not constrained at all.
const NO_SHARE: f64 = 0.01;

const RANGE: f64 = 12.0;
/// How far sensors stay from walls, m.
const CLEAR: f64 = 0.3;
/// With fewer hits it is no scan.
const FEWEST: usize = 60;
const TRIES: usize = 10_000;

/// Two scans, and the motion between them.
#[derive(Clone, Debug, PartialEq)]
pub struct ScanPair {
    /// The first one, in its sensor's frame, m.
    pub fixed: Vec<Point2<f64>>,
    /// The second one, in its own.
    pub moving: Vec<Point2<f64>>,
    /// `fixed_from_moving`.
    pub truth: Pose2,
}

/// What is wrong with the scans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Condition {
    /// Its name in reports.
    pub name: &'static str,
    /// σ of a range, m.
    pub sigma: f64,
    /// Whether each sees only half of its surroundings, and half of that is what the other sees.
    pub is_half: bool,
    /// Part of the beams that are cut short.
    pub outliers: f64,
}

impl Condition {
    /// A good lidar.
    pub const CLEAN: Self = Self {
        name: "clean",
        sigma: 0.01,
        is_half: false,
        outliers: 0.0,
    };
    /// All conditions under which registration is measured.
    pub const ALL: [Self; 4] = [
        Self::CLEAN,
        Self {
            name: "sigma_3_cm",
            sigma: 0.03,
            ..Self::CLEAN
        },
        Self {
            name: "half_overlap",
            is_half: true,
            ..Self::CLEAN
        },
        Self {
            name: "outliers_30_percent",
            outliers: 0.3,
            ..Self::CLEAN
        },
    ];
}

/// A fixed pair, always the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuiltinPair {
    /// Its name.
    pub name: &'static str,
    /// What people call it.
    pub title: &'static str,
    world: &'static str,
    condition: Condition,
    is_observable: bool,
    seed: u64,
}

impl BuiltinPair {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::of("office", "Office", Condition::ALL[0]),
        Self::of("noise", "Office, σ 3 cm", Condition::ALL[1]),
        Self::of("half-overlap", "Half overlap", Condition::ALL[2]),
        Self::of("outliers", "30 % outliers", Condition::ALL[3]),
        Self {
            world: "corridor",
            is_observable: false,
            ..Self::of("corridor", "Corridor", Condition::CLEAN)
        },
    ];

    const fn of(name: &'static str, title: &'static str, condition: Condition) -> Self {
        Self {
            name,
            title,
            world: "office",
            condition,
            is_observable: true,
            seed: 10,
        }
    }

    /// The pair; `None` only if the world has no two such places.
    #[must_use]
    pub fn draw(&self) -> Option<ScanPair> {
        let buildings = Buildings::of([worlds::builtin(self.world)?]);
        let is_wanted = |share: f64| match self.is_observable {
            true => share > LEAST_SHARE,
            false => share < NO_SHARE,
        };
        buildings.pair(self.seed, &self.condition, is_wanted)
    }
}

/// The walls of buildings in which pairs are drawn.
#[derive(Clone, Debug)]
pub struct Buildings(Vec<Building>);

/// A building, and two corners of it.
#[derive(Clone, Debug)]
struct Building {
    caster: Caster,
    low: Point2<f64>,
    high: Point2<f64>,
}

impl Buildings {
    /// All built-in ones.
    #[must_use]
    pub fn builtin() -> Self {
        Self::of(
            worlds::NAMES
                .iter()
                .filter_map(|name| worlds::builtin(name)),
        )
    }

    /// From the given ones.
    #[must_use]
    pub fn of(worlds: impl IntoIterator<Item = World>) -> Self {
        let open = |world: World| {
            let (low, high) = world.bounds();
            Building {
                caster: Caster::new(world.walls()),
                low,
                high,
            }
        };
        Self(worlds.into_iter().map(open).collect())
    }

    /// The pair of a seed for which the walls give as much information as `is_wanted` asks for,
    /// seen from either pose (see [`Buildings::observability`]). `None` if many tries found none.
    #[must_use]
    pub fn pair(
        &self,
        seed: u64,
        condition: &Condition,
        is_wanted: impl Fn(f64) -> bool,
    ) -> Option<ScanPair> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for _ in 0..TRIES {
            let index = rng.random_range(0..self.0.len().max(1));
            let building = self.0.get(index)?;
            let Some(poses) = building.poses(&mut rng) else {
                continue;
            };
            let half = rng.random_range(0.0..TAU);
            let [fixed, moving] = [(poses[0], 0.0), (poses[1], 0.5 * PI)].map(|(pose, turn)| {
                let arc = condition.is_half.then_some(half + turn);
                building.scan(&pose, condition, arc, &mut rng)
            });
            if fixed.len().min(moving.len()) < FEWEST {
                continue;
            }
            if !poses
                .iter()
                .all(|pose| is_wanted(building.observability(pose).share()))
            {
                continue;
            }
            return Some(ScanPair {
                fixed,
                moving,
                truth: poses[0].delta_to(&poses[1]),
            });
        }
        None
    }

    /// Two poses in the first building that see each other, drawn once; `None` if they do not.
    #[must_use]
    pub fn poses(&self, rng: &mut ChaCha8Rng) -> Option<[Pose2; 2]> {
        self.0.first()?.poses(rng)
    }

    /// The information of the first building's walls about a pose, seen from `pose`.
    #[must_use]
    pub fn observability(&self, pose: &Pose2) -> Option<Observability> {
        Some(self.0.first()?.observability(pose))
    }

    /// The hits of a whole scan in the first building, in the sensor frame.
    #[must_use]
    pub fn scan(
        &self,
        pose: &Pose2,
        condition: &Condition,
        rng: &mut ChaCha8Rng,
    ) -> Vec<Point2<f64>> {
        let building = self.0.first();
        building.map_or_else(Vec::new, |building| {
            building.scan(pose, condition, None, rng)
        })
    }
}

/// The information of the visible walls about a shift, from the walls themselves, with the heading
/// unknown too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observability {
    /// Information about the least known direction.
    pub least: f64,
    /// Information about all directions together.
    pub total: f64,
    /// The least known direction, in the building's frame.
    pub axis: Vector2<f64>,
}

impl Observability {
    /// The least as a part of the total.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.least / self.total.max(f64::MIN_POSITIVE)
    }
}

impl Building {
    fn observability(&self, pose: &Pose2) -> Observability {
        let mut sums = Matrix3::zeros();
        for beam in 0..BEAMS {
            let direction = unit_vector(pose.heading() + TAU * beam as f64 / BEAMS as f64 - PI);
            let Some(hit) = self.caster.cast(pose.position(), direction, RANGE) else {
                continue;
            };
            let Some(wall) = self.caster.walls().get(hit.surface) else {
                continue;
            };
            let along = wall.segment.b - wall.segment.a;
            let normal = Vector2::new(-along.y, along.x) / along.length();
            let arm = direction * hit.distance;
            let row = normal.push(normal.y * arm.x - normal.x * arm.y);
            sums += row * row.transpose();
        }
        let cross = Vector2::new(sums[(0, 2)], sums[(1, 2)]);
        let way: Matrix2<f64> = sums.fixed_view::<2, 2>(0, 0).into_owned();
        let left = way - cross * cross.transpose() / sums[(2, 2)].max(1e-12);
        let eigen = SymmetricEigen::new(left);
        let (at, least) = eigen.eigenvalues.argmin();
        Observability {
            least,
            total: way.trace(),
            axis: eigen.eigenvectors.column(at).into_owned(),
        }
    }

    fn poses(&self, rng: &mut ChaCha8Rng) -> Option<[Pose2; 2]> {
        let x = rng.random_range(self.low.x..self.high.x);
        let place = Point2::new(x, rng.random_range(self.low.y..self.high.y));
        let heading = rng.random_range(-PI..PI);
        let fixed = Pose2::new(place.x, place.y, heading);
        let way = SHIFT * rng.random_range(0.0..1.0_f64).sqrt();
        let there = unit_vector(rng.random_range(-PI..PI)) * way;
        let truth = Pose2::new(there.x, there.y, rng.random_range(-TURN..TURN));
        let moving = fixed * truth;
        let caster = &self.caster;
        let is_clear = |pose: &Pose2| caster.clearance(pose.position(), CLEAR) >= CLEAR;
        let towards = moving.position() - fixed.position();
        let distance = towards.length();
        let is_seen = distance < 1e-6
            || (caster.cast(fixed.position(), towards / distance, RANGE))
                .is_none_or(|hit| hit.distance > distance);
        (is_clear(&fixed) && is_clear(&moving) && is_seen).then_some([fixed, moving])
    }

    /// If `arc`, a direction of the building, is given: only of beams within half a turn from it
    /// on.
    fn scan(
        &self,
        pose: &Pose2,
        condition: &Condition,
        arc: Option<f64>,
        rng: &mut ChaCha8Rng,
    ) -> Vec<Point2<f64>> {
        let mut points = vec![];
        for beam in 0..BEAMS {
            let bearing = TAU * beam as f64 / BEAMS as f64 - PI;
            let direction = unit_vector(bearing);
            if arc.is_some_and(|arc| wrap(pose.heading() + bearing - arc) < 0.0) {
                continue;
            }
            let ray = pose.rotate(direction);
            let Some(hit) = self.caster.cast(pose.position(), ray, RANGE) else {
                continue;
            };
            let noisy = hit.distance + condition.sigma * gaussian_pair(rng).0;
            let is_outlier = rng.random_bool(condition.outliers);
            let cut = rng.random_range(0.0..1.0) * hit.distance;
            let range = if is_outlier { cut } else { noisy };
            points.push(Point2::from(direction * range.max(0.05)));
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_builtin_pair_is_there_and_its_scans_show_the_same_walls() {
        for builtin in BuiltinPair::ALL {
            let pair = builtin.draw().expect(builtin.name);
            assert_eq!(builtin.draw().as_ref(), Some(&pair), "{}", builtin.name);
            let moved: Vec<_> = pair.moving.iter().map(|p| pair.truth * *p).collect();
            let nearest = |p: &Point2<f64>| {
                let distances = pair.fixed.iter().map(|q| (q - p).length());
                distances.fold(f64::INFINITY, f64::min)
            };
            let near = moved.iter().filter(|p| nearest(p) < 0.2).count();
            let least = if builtin.condition.is_half { 0.3 } else { 0.6 };
            assert!(near as f64 > least * moved.len() as f64, "{}", builtin.name);
            let (shift, turn) = (pair.truth.position().coords.length(), pair.truth.heading());
            assert!(shift <= SHIFT && turn.abs() <= TURN, "{}", builtin.name);
        }
    }

    #[test]
    fn walls_of_a_corridor_tell_nothing_along_it() {
        let corridor = Buildings::of(worlds::builtin("corridor"));
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let told = (0..2000).filter_map(|_| {
            let [pose, _] = corridor.poses(&mut rng)?;
            corridor.observability(&pose)
        });
        let nothing: Vec<_> = told.filter(|told| told.share() < NO_SHARE).collect();
        assert!(!nothing.is_empty());
        assert!(nothing.iter().all(|told| told.least <= told.total));
    }

    #[test]
    fn no_building_gives_no_pair() {
        let none = Buildings::of([]);
        assert_eq!(none.pair(1, &Condition::CLEAN, |_| true), None);
    }
}
