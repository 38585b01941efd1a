//! `features`: which points does a scan show, and are they found again in the next? Under a minute.
//!
//! In: built-in worlds ([`WORLDS`]), 60 places each (`--seeds`, `--world`), where the robot can
//! stand; from each place, two scans of 720 beams with σ 1 cm, for each of two moves:
//!
//! | move | how far | what is known of it |
//! |---|---|---|
//! | `near` | up to 0.3 m, 15° | odometry: σ 2 cm, 1.5° |
//! | `far` | 0.5 to 1.5 m, any turn | nothing: odometry says that the robot stood still |
//!
//! Truth: a point belongs to the nearest true corner (where sides end or meet) or pillar of the
//! simulator's world, if that is within 10 cm; of two scans, points of one kind at one true thing
//! are the same. Spikes are left out: the edge of an occluding object lies elsewhere in each scan,
//! so they have no truth.
//!
//! Out, for each move and method of matching (Pilch 2016 §1.2.3, eq. 1.13-1.16), by the points of
//! the second scan: TPR, those of the first found again as what they are; FPR, those that the first
//! scan does not have and that are taken for one of it; PPV, pairs that are right; ACC, points
//! decided rightly. The ROC of `near` has (FPR, TPR) over the gate. Also for each kind, how many of
//! 100 points stand at a true thing, with the NEES of those.
//!
//! It holds if a near move gives TPR ≥ 0.9 and PPV ≥ 0.95 by both methods that know the motion, if
//! TPR and FPR grow with the gate, and if relations find the far move with TPR ≥ 0.5 and PPV ≥
//! 0.95; if 95 % of the corners, crossings and circles stand where something is, with a median NEES
//! from 0.8 to 2 (1.39 is honest), and at most 10 % beyond the 99 % of their covariance. These
//! bounds apply to all four worlds together: things narrower than the window, like the posts of the
//! glazing in `lab` and the ends of thin walls, are seldom told apart.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use anyhow::{Context, Result};
use nalgebra::{Point2, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;
use slamlab_core::association::{PointMatchConfig, PointMatching, RefindingCounts, match_points};
use slamlab_core::features::{
    LineConfig, LineExtractor, PointFeature, PointFeatureConfig, PointKind, find_points,
};
use slamlab_core::geom::{Length, Pose2, PoseEstimate, pose_cov, unit_vector};
use slamlab_core::points::{Beam, Points};
use slamlab_core::robot::Stamp;
use slamlab_core::sim::{Caster, Material, Thing, Things, World, reachable_area, worlds};

use crate::Args;
use crate::outcome::Outcome;
use crate::scenes::hit;
use crate::statistics::{median, normal};

const WORLDS: [&str; 4] = ["office", "arena", "lab", "loop"];
const PLACES: u64 = 60;
const BEAMS: usize = 720;
const SIGHT: f64 = 8.0;
const SIGMA: f64 = 0.01;
/// σ of the odometry, m and rad.
const WAY_SIGMA: f64 = 0.02;
const TURN_SIGMA: f64 = 0.026;
/// A point farther from every true thing belongs to none, m.
const REACH: f64 = 0.1;
/// 99 % of χ² with 2 degrees of freedom.
const BEYOND: f64 = 9.21;
/// Gates of the ROC, d².
const GATES: [f64; 9] = [0.05, 0.2, 0.5, 1.0, 2.0, 4.0, 9.21, 20.0, 60.0];
const KINDS: [&str; 3] = ["corner", "crossing", "circle"];

/// A move, and how often the methods of matching decided rightly.
struct Move {
    name: &'static str,
    way: [f64; 2],
    turn: f64,
    is_known: bool,
}

const MOVES: [Move; 2] = [
    Move {
        name: "near",
        way: [0.0, 0.3],
        turn: 0.26,
        is_known: true,
    },
    Move {
        name: "far",
        way: [0.5, 1.5],
        turn: PI,
        is_known: false,
    },
];

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let sites: Vec<Site> = (args.worlds(WORLDS)?.into_iter())
        .map(Site::of)
        .collect::<Result<_>>()?;
    let mut outcome = Outcome::default();
    let mut kinds: BTreeMap<&str, Standing> = BTreeMap::new();
    for step in MOVES {
        let mut pairs = vec![];
        for site in &sites {
            for seed in args.seeds(PLACES) {
                pairs.push(Pair::drawn(site, &step, seed, &mut kinds)?);
            }
        }
        let mut scores = BTreeMap::new();
        for (name, method) in PointMatching::ALL {
            let score = score_of(
                &pairs,
                &PointMatchConfig {
                    method,
                    ..PointMatchConfig::default()
                },
            );
            scores.insert(name, score);
        }
        for (name, score) in &scores {
            outcome.figure(format!("{}_{name}", step.name), json!(ratios(score)));
        }
        require(&mut outcome, step.name, &scores);
        if step.name == "near" {
            roc(&mut outcome, &pairs);
        }
    }
    for (kind, standing) in kinds {
        let part = standing.nees.len() as f64 / standing.found as f64;
        outcome.figure(format!("{kind}_found"), standing.found);
        outcome.within(
            &format!("{kind}_median_nees"),
            median(&standing.nees),
            [0.8, 2.0],
        );
        let beyond = standing.nees.iter().filter(|nees| **nees > BEYOND).count();
        let beyond = beyond as f64 / standing.nees.len() as f64;
        outcome.at_most(&format!("{kind}_part_beyond_99_percent"), beyond, 0.1);
        outcome.at_least(&format!("{kind}_part_at_something"), part, 0.95);
    }
    Ok(outcome)
}

fn require(outcome: &mut Outcome, step: &str, scores: &BTreeMap<&str, RefindingCounts>) {
    let ratio = |name: &str, quantity: &str| ratios(&scores[name])[quantity];
    let mut least = |name: &str, quantity: &str, least: f64| {
        let value = ratio(name, quantity);
        outcome.require(value >= least, || {
            format!("{step}, {name}: {quantity} is {value}, expected at least {least}")
        });
    };
    if step == "near" {
        for name in ["exhaustive", "nearest"] {
            least(name, "tpr", 0.9);
            least(name, "ppv", 0.95);
        }
    } else {
        least("relations", "ppv", 0.95);
        least("relations", "tpr", 0.5);
    }
}

/// (FPR, TPR) over the gate; both grow with it.
fn roc(outcome: &mut Outcome, pairs: &[Pair]) {
    for (name, method) in PointMatching::ALL {
        let curve: Vec<[f64; 3]> = (GATES.iter())
            .map(|&gate| {
                let config = PointMatchConfig {
                    method,
                    gate,
                    ..PointMatchConfig::default()
                };
                let ratios = ratios(&score_of(pairs, &config));
                [gate, ratios["fpr"], ratios["tpr"]]
            })
            .collect();
        outcome.figure(format!("roc_{name}_gate_fpr_tpr"), json!(curve));
        // Relations stop growing once more chance placements fit.
        let grows = |i: usize| curve.is_sorted_by(|a, b| a[i] <= b[i] + 0.005);
        let holds = method == PointMatching::Relations || grows(1) && grows(2);
        outcome.require(holds, || {
            format!("the ROC of {name} does not grow with the gate")
        });
    }
}

/// A world, and where the robot can stand in it.
struct Site {
    caster: Caster,
    things: Things,
    places: Vec<Point2<f64>>,
}

impl Site {
    fn of(name: &'static str) -> Result<Self> {
        let world = worlds::builtin(name).with_context(|| format!("there is no world {name}"))?;
        // A lidar looks through glass.
        let mut opaque = world.walls();
        opaque.retain(|wall| wall.material != Material::Glass);
        Ok(Self {
            things: Things::of(&world),
            places: standing(&world),
            caster: Caster::new(opaque),
        })
    }

    /// The points in a simulated scan from a pose.
    fn look(&self, pose: &Pose2, rng: &mut ChaCha8Rng) -> Result<Vec<PointFeature>> {
        let beams = (0..BEAMS).map(|beam_idx| {
            let bearing = TAU * beam_idx as f64 / BEAMS as f64;
            let along = pose.rotate(unit_vector(bearing));
            let seen = self.caster.cast(pose.position(), along, SIGHT);
            let range = seen.map_or(SIGHT, |seen| seen.distance + SIGMA * normal(rng));
            Beam {
                is_hit: seen.is_some(),
                ..hit(beam_idx, bearing, range.max(0.05), SIGMA)
            }
        });
        let points = Points {
            stamp: Stamp(0),
            sensor_in_robot: Point2::origin(),
            bearing_sigma: 0.0,
            beams: beams.collect(),
        };
        let (config, mut lines) = (LineConfig::default(), vec![]);
        LineExtractor::new(config).extract(&points, &mut lines)?;
        let mut asked = PointFeatureConfig::default();
        asked.spikes.is_on = false;
        Ok(find_points(&points, &lines, &config, &asked)?)
    }
}

fn standing(world: &World) -> Vec<Point2<f64>> {
    let radius = world.robot.model().radius();
    reachable_area(world, radius, 0.1).centres().collect()
}

/// Points of one kind, and the NEES of those that stand at a true thing.
#[derive(Default)]
struct Standing {
    found: usize,
    nees: Vec<f64>,
}

/// Two scans, and the truth of their points.
struct Pair {
    before: Vec<PointFeature>,
    now: Vec<PointFeature>,
    /// What each point belongs to; points of one kind with one number are the same.
    of_before: Vec<Option<Thing>>,
    of_now: Vec<Option<Thing>>,
    /// By odometry.
    now_from_before: PoseEstimate,
}

impl Pair {
    fn drawn(
        site: &Site,
        step: &Move,
        seed: u64,
        kinds: &mut BTreeMap<&'static str, Standing>,
    ) -> Result<Self> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (a, b) = site
            .drawn_poses(step, &mut rng)
            .context("there is no room to move")?;
        let (before, now) = (site.look(&a, &mut rng)?, site.look(&b, &mut rng)?);
        let error = Pose2::new(
            WAY_SIGMA * normal(&mut rng),
            WAY_SIGMA * normal(&mut rng),
            TURN_SIGMA * normal(&mut rng),
        );
        let told = if step.is_known {
            b.inverse() * a
        } else {
            Pose2::identity()
        };
        let mut of = |points: &[PointFeature], pose: &Pose2| -> Vec<Option<Thing>> {
            let of_one = |point: &PointFeature| {
                let is_round = point.kind.is_round();
                let thing = (site.things).of_point(pose, point.position, is_round, REACH);
                let at = match thing {
                    Some(Thing::Corner(at) | Thing::Round(at)) => Some(pose.inverse() * at),
                    Some(Thing::Wall { .. }) | None => None,
                };
                note(kinds, point, at);
                thing
            };
            points.iter().map(of_one).collect()
        };
        Ok(Self {
            of_before: of(&before, &a),
            of_now: of(&now, &b),
            before,
            now,
            now_from_before: PoseEstimate {
                pose: Pose2::new(
                    told.x() + error.x(),
                    told.y() + error.y(),
                    told.heading() + error.heading(),
                ),
                cov: pose_cov(WAY_SIGMA, TURN_SIGMA),
            },
        })
    }

    fn is_same(&self, before: usize, now: usize) -> bool {
        let is_alike = self.before[before].kind.is_like(&self.now[now].kind);
        is_alike && self.of_now[now].is_some() && self.of_before[before] == self.of_now[now]
    }
}

impl Site {
    /// Two places with a clear line of sight.
    fn drawn_poses(&self, step: &Move, rng: &mut ChaCha8Rng) -> Option<(Pose2, Pose2)> {
        for _ in 0..10_000 {
            let from = *self.places.get(rng.random_range(0..self.places.len()))?;
            let way = rng.random_range(step.way[0]..step.way[1]);
            let to = from + unit_vector(rng.random_range(-PI..PI)) * way;
            let heading = rng.random_range(-PI..PI);
            let turn = rng.random_range(-step.turn..step.turn);
            let to_it: Vector2<f64> = to - from;
            let is_free = to_it.length() < 1e-6
                || self
                    .caster
                    .cast(from, to_it / to_it.length(), way)
                    .is_none();
            if is_free && self.caster.clearance(to, 0.2) >= 0.2 {
                let a = Pose2::new(from.x, from.y, heading);
                return Some((a, Pose2::new(to.x, to.y, heading + turn)));
            }
        }
        None
    }
}

fn note(
    kinds: &mut BTreeMap<&'static str, Standing>,
    point: &PointFeature,
    truth: Option<Point2<f64>>,
) {
    let [corner, crossing, circle] = KINDS;
    let kind = match point.kind {
        PointKind::Corner => corner,
        PointKind::Crossing => crossing,
        PointKind::Circle { .. } => circle,
        PointKind::Spike => return,
    };
    let standing = kinds.entry(kind).or_default();
    standing.found += 1;
    if let Some(truth) = truth {
        let off = truth - point.position;
        let nees = point.cov.cholesky().map(|c| off.dot(&c.solve(&off)));
        standing.nees.push(nees.unwrap_or(f64::INFINITY));
    }
}

/// Counts over the points of the second scans.
fn score_of(pairs: &[Pair], config: &PointMatchConfig) -> RefindingCounts {
    let mut score = RefindingCounts::default();
    for pair in pairs {
        let matches = match_points(&pair.before, &pair.now, &pair.now_from_before, config);
        for now in 0..pair.now.len() {
            let has_partner = (0..pair.before.len()).any(|before| pair.is_same(before, now));
            let found = matches.iter().find(|found| found.now == now);
            score.count(
                has_partner,
                found.map(|found| pair.is_same(found.before, now)),
            );
        }
    }
    score
}

/// Ratios by name, each from 0 to 1.
fn ratios(score: &RefindingCounts) -> BTreeMap<&'static str, f64> {
    BTreeMap::from([
        ("tpr", score.tpr()),
        ("fpr", score.fpr()),
        ("ppv", score.ppv()),
        ("acc", score.acc()),
    ])
}
