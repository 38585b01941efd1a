//! In: a seed and a condition. Out: two scans in a built-in world, and the motion between them.

use std::f64::consts::{PI, TAU};

use anyhow::{Context, Result};
use nalgebra::{Matrix2, Matrix3, Point2, SymmetricEigen, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use slamlab_core::geom::{Length, Pose2, unit_vector, wrap};
use slamlab_core::registration::Cloud;
use slamlab_core::sim::{Caster, worlds};

use crate::ride::world_named;
use crate::statistics::{normal, place_between};

pub(crate) const BEAMS: usize = 360;
const RANGE: f64 = 12.0;
/// How far sensors stay from walls, m.
const CLEAR: f64 = 0.3;
/// How far two scans lie apart, at most.
pub(crate) const SHIFT: f64 = 1.0;
pub(crate) const TURN: f64 = PI / 4.0;
/// Fewer hits are no scan.
const FEWEST: usize = 60;
const TRIES: usize = 10_000;
/// Where walls say less of some way than this part, a pair does not tell the motion.
pub(crate) const LEAST_SHARE: f64 = 0.04;

/// Two scans, and the motion between them.
pub(crate) struct Pair {
    pub(crate) moving: Cloud,
    pub(crate) fixed: Cloud,
    pub(crate) start: Pose2,
    pub(crate) truth: Pose2,
}

/// What is wrong with the scans.
#[derive(Clone, Copy)]
pub(crate) struct Condition {
    pub(crate) name: &'static str,
    /// σ of a range, m.
    pub(crate) sigma: f64,
    /// Whether each sees only half of what is around it, and half of that what the other sees.
    pub(crate) is_half: bool,
    /// Part of the beams that are cut short.
    pub(crate) outliers: f64,
}

pub(crate) const CLEAN: Condition = Condition {
    name: "clean",
    sigma: 0.01,
    is_half: false,
    outliers: 0.0,
};
pub(crate) const CONDITIONS: [Condition; 4] = [
    CLEAN,
    Condition {
        name: "sigma_3_cm",
        sigma: 0.03,
        ..CLEAN
    },
    Condition {
        name: "half_overlap",
        is_half: true,
        ..CLEAN
    },
    Condition {
        name: "outliers_30_percent",
        outliers: 0.3,
        ..CLEAN
    },
];

/// The walls of all worlds.
pub(crate) struct Drawn {
    worlds: Vec<(Caster, Point2<f64>, Point2<f64>)>,
}

impl Drawn {
    /// All built-in worlds.
    pub(crate) fn new() -> Result<Self> {
        Self::of(&worlds::NAMES)
    }

    pub(crate) fn of(names: &[&str]) -> Result<Self> {
        let open = |name: &&str| {
            let world = world_named(name)?;
            let (low, high) = world.bounds();
            Ok((Caster::new(world.walls()), low, high))
        };
        let worlds = names.iter().map(open).collect::<Result<_>>()?;
        Ok(Self { worlds })
    }

    pub(crate) fn pair(&self, seed: u64, condition: &Condition) -> Result<Pair> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for _ in 0..TRIES {
            let index = rng.random_range(0..self.worlds.len());
            let Some((caster, low, high)) = self.worlds.get(index) else {
                continue;
            };
            let Some(poses) = poses(caster, *low, *high, &mut rng) else {
                continue;
            };
            let half = rng.random_range(0.0..TAU);
            let scans = [0.0, 1.0].map(|which| {
                let pose = &poses[which as usize];
                let arc = condition.is_half.then_some(half + which * 0.5 * PI);
                scan(caster, pose, condition, arc, &mut rng)
            });
            if scans.iter().any(|scan| scan.len() < FEWEST) {
                continue;
            }
            let walls = [0, 1].map(|which: usize| share(caster, &poses[which]));
            if walls.iter().any(|share| *share < LEAST_SHARE) {
                continue;
            }
            let [fixed, moving] = scans;
            return Ok(Pair {
                moving: Cloud::scan(moving)?,
                fixed: Cloud::scan(fixed)?,
                start: Pose2::identity(),
                truth: poses[0].delta_to(&poses[1]),
            });
        }
        None.with_context(|| format!("seed {seed}: no pair in {TRIES} tries"))
    }
}

/// How much the walls in sight say of the way of which they say least, in parts of all they say of
/// the way: by the true walls, the heading being as unknown.
pub(crate) fn share(caster: &Caster, pose: &Pose2) -> f64 {
    let (least, total, _) = spread(caster, pose);
    least / total.max(f64::MIN_POSITIVE)
}

/// The least and the whole of what walls in sight say of the way, and the direction of the least.
pub(crate) fn spread(caster: &Caster, pose: &Pose2) -> (f64, f64, Vector2<f64>) {
    let mut sums = Matrix3::zeros();
    for beam in 0..BEAMS {
        let direction = unit_vector(pose.heading() + TAU * beam as f64 / BEAMS as f64 - PI);
        let Some(hit) = caster.cast(pose.position(), direction, RANGE) else {
            continue;
        };
        let Some(wall) = caster.walls().get(hit.surface) else {
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
    let total = way.trace();
    let eigen = SymmetricEigen::new(way - cross * cross.transpose() / sums[(2, 2)].max(1e-12));
    let (at, least) = eigen.eigenvalues.argmin();
    (least, total, eigen.eigenvectors.column(at).into_owned())
}

/// Two poses that see each other.
pub(crate) fn poses(
    caster: &Caster,
    low: Point2<f64>,
    high: Point2<f64>,
    rng: &mut ChaCha8Rng,
) -> Option<[Pose2; 2]> {
    let place = place_between(low, high, rng);
    let heading = rng.random_range(-PI..PI);
    let fixed = Pose2::new(place.x, place.y, heading);
    let way = SHIFT * rng.random_range(0.0..1.0_f64).sqrt();
    let there = unit_vector(rng.random_range(-PI..PI)) * way;
    let truth = Pose2::new(there.x, there.y, rng.random_range(-TURN..TURN));
    let moving = fixed * truth;
    let is_clear = |pose: &Pose2| caster.clearance(pose.position(), CLEAR) >= CLEAR;
    let towards = moving.position() - fixed.position();
    let is_seen = towards.length() < 1e-6
        || (caster.cast(fixed.position(), towards / towards.length(), RANGE))
            .is_none_or(|hit| hit.distance > towards.length());
    (is_clear(&fixed) && is_clear(&moving) && is_seen).then_some([fixed, moving])
}

/// The hits of a scan, in the frame of the sensor; only of beams within half a turn from `arc` on,
/// which is a direction of the world, if one is given.
pub(crate) fn scan(
    caster: &Caster,
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
        let Some(hit) = caster.cast(pose.position(), pose.rotate(direction), RANGE) else {
            continue;
        };
        let noisy = hit.distance + condition.sigma * normal(rng);
        let is_outlier = rng.random_bool(condition.outliers);
        let cut = rng.random_range(0.0..1.0) * hit.distance;
        let range = if is_outlier { cut } else { noisy };
        points.push(Point2::from(direction * range.max(0.05)));
    }
    points
}
