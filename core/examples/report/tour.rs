//! A simulated robot on a fixed tour, steered by the truth, with line filters listening; and which
//! wall each line belongs to.
//!
//! In: a world, waypoints or a number of random errands, a seed, the settings of each filter. Out:
//! the results of each filter.
//!
//! 1. The robot follows the waypoints by its true pose, so all filters of a seed get the same ticks
//!    and scans, and none steers by its own error.
//! 2. A landmark belongs to the wall that its first sighting came from. A match with the landmark
//!    of another wall is an error, unless both walls lie on one line: then α and r are right all
//!    the same.

use std::collections::{BTreeMap, VecDeque};

use anyhow::Result;
use nalgebra::{Point2, Vector2};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use slamlab_core::estimation::{EkfConfig, EkfSlam, Landmark, LandmarkId, SweepTiming, ate_rmse};
use slamlab_core::features::{
    LineConfig, LineExtractor, LineFeature, PointFeature, PointFeatureConfig, find_points,
};
use slamlab_core::geom::{Length, Pose2, wrap};
use slamlab_core::points::{MotionHistory, PointConfig, Points};
use slamlab_core::robot::{Command, Odometry, RobotModel, Scan, TrackOdometry};
use slamlab_core::sim::{SensorModel, Simulation, Thing, Things, Wall};

use crate::errand::errand;
use crate::ride::world_named;

/// Simulated time of one decision, s, and the number of odometry readings in it, as in
/// `Experiment`.
const PERIOD: f64 = 0.05;
const READINGS: u32 = 5;
/// More decisions than any tour needs.
const MOST_STEPS: usize = 40_000;

/// Where the robot goes.
pub(crate) struct Tour {
    pub(crate) world: &'static str,
    /// World frame, m; the first one is where the robot starts.
    pub(crate) waypoints: &'static [(f64, f64)],
    /// Number of routes to random places afterwards.
    pub(crate) errands: usize,
}

impl Tour {
    /// Random errands in a built-in world.
    pub(crate) const fn errands(world: &'static str, errands: usize) -> Self {
        Self {
            world,
            waypoints: &[],
            errands,
        }
    }
}

/// Once around the ring, and 10 m of the second lap.
#[rustfmt::skip]
pub(crate) const LOOP: Tour = Tour {
    world: "loop",
    waypoints: &[
        (2.5, 1.0), (11.5, 0.8), (13.0, 0.8), (20.0, 1.0),
        (20.0, 12.0), (19.4, 13.9), (10.0, 14.2), (1.0, 14.0),
        (1.0, 1.0), (2.5, 1.0), (12.0, 0.8),
    ],
    errands: 0,
};

/// Into seven of the eight rooms and back to the start; a row per room, from the corridor into it.
#[rustfmt::skip]
pub(crate) const OFFICE: Tour = Tour {
    world: "office",
    waypoints: &[
        (1.0, 6.0),
        (2.3, 6.0), (2.3, 4.0), (2.3, 6.0),
        (5.4, 6.0), (5.4, 8.0), (5.4, 6.0),
        (6.9, 6.0), (6.9, 4.2), (6.9, 6.0),
        (9.3, 6.0), (9.3, 4.2), (9.3, 6.0),
        (10.7, 6.0), (10.7, 7.9), (10.7, 6.0),
        (13.3, 6.0), (13.3, 7.8), (13.3, 6.0),
        (14.1, 6.0), (14.1, 4.2), (14.1, 6.0),
        (1.7, 6.0), (1.7, 8.0), (1.7, 6.0),
        (1.0, 6.0),
    ],
    errands: 0,
};

/// The results of one filter on a tour.
#[derive(Default)]
pub(crate) struct Listener {
    pub(crate) seed: u64,
    /// NEES of the pose at each scan.
    pub(crate) nees: Vec<f64>,
    /// NEES of the heading alone.
    pub(crate) heading_nees: Vec<f64>,
    pub(crate) ate: f64,
    pub(crate) end_error: f64,
    pub(crate) nis: f64,
    pub(crate) nis_degrees: usize,
    pub(crate) matches: usize,
    /// Matches with the landmark of a wall on another line.
    pub(crate) wrong_matches: usize,
    /// How often one wall was taken for another, by their numbers in the world.
    pub(crate) wrong_pairs: BTreeMap<(usize, usize), usize>,
    /// Matches of lines that ray casting does not find on a single wall: across a corner, a gap, a
    /// pillar.
    pub(crate) matches_of_no_wall: usize,
    /// Pairs of confirmed landmarks of one wall whose known parts overlap or touch.
    pub(crate) duplicates: usize,
    pub(crate) point_matches: usize,
    /// Matches with the landmark of another corner or post.
    pub(crate) wrong_point_matches: usize,
    pub(crate) confirmed_points: usize,
    pub(crate) confirmed: usize,
    pub(crate) merged: usize,
    pub(crate) wrong_merges: usize,
    /// The wall or point that each landmark belongs to.
    wall_of: Vec<(LandmarkId, Thing)>,
    track: Vec<Point2<f64>>,
}

/// All state that changes during the drive.
struct Drive {
    sim: Simulation,
    start: Pose2,
    is_errand: bool,
    walls: Vec<Wall>,
    things: Things,
    finds_points: bool,
    wheels: TrackOdometry,
    history: MotionHistory,
    extractor: LineExtractor,
    lines: Vec<LineFeature>,
    /// Found only if a filter uses them.
    points: Vec<PointFeature>,
    truth: Vec<Point2<f64>>,
    filters: Vec<(EkfSlam, Listener)>,
}

/// Drives the tour once.
pub(crate) fn drive(tour: &Tour, seed: u64, configs: &[EkfConfig]) -> Result<Vec<Listener>> {
    let world = world_named(tour.world)?;
    let (start, robot) = (world.start, RobotModel::rp6());
    let (walls, things) = (world.walls(), Things::of(&world));
    let sim = Simulation::new(world, robot, SensorModel::lidar(), seed)?;
    let mut wheels = TrackOdometry::new(&robot);
    wheels.update(sim.stamp(), sim.ticks());
    let mut drive = Drive {
        sim,
        start,
        is_errand: tour.errands > 0,
        walls,
        things,
        finds_points: configs.iter().any(|config| config.landmarks.has_points()),
        wheels,
        history: MotionHistory::new(5.0),
        extractor: LineExtractor::new(LineConfig::default()),
        lines: vec![],
        points: vec![],
        truth: vec![],
        filters: listeners(configs)?,
    };
    let waypoints = tour.waypoints.iter();
    let mut route: VecDeque<_> = waypoints.map(|&(x, y)| Point2::new(x, y)).collect();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut errands, mut rest) = (tour.errands, 0);
    for _ in 0..MOST_STEPS {
        if route.is_empty() && errands > 0 {
            errands -= 1;
            route = errand(&drive.sim, &mut rng);
        }
        drive.steer(&mut route);
        // Some scans standing, at the end.
        rest += u32::from(route.is_empty());
        if rest > 20 {
            break;
        }
        for _ in 0..READINGS {
            drive.sim.advance(PERIOD / f64::from(READINGS));
            drive.listen()?;
        }
    }
    anyhow::ensure!(
        route.is_empty(),
        "{} {seed}: the tour did not end",
        tour.world
    );
    Ok(drive.finish(seed))
}

/// A filter for each of the settings, and its record.
fn listeners(configs: &[EkfConfig]) -> Result<Vec<(EkfSlam, Listener)>> {
    let with = |config: &EkfConfig| Ok((EkfSlam::new(*config)?, Listener::default()));
    configs.iter().map(with).collect()
}

impl Drive {
    /// Steers for the next waypoint by the true pose.
    fn steer(&mut self, route: &mut VecDeque<Point2<f64>>) {
        let pose = self.sim.truth();
        // The points of an errand lie close together: it steers for one some distance ahead.
        let is_passed = |p: &Point2<f64>| (p - pose.position()).length() < 0.25;
        while self.is_errand && route.len() > 1 && route.front().is_some_and(is_passed) {
            route.pop_front();
        }
        let Some(&goal) = route.front() else {
            return;
        };
        let ahead: Vector2<f64> = (pose.inverse() * goal).coords;
        if ahead.length() < 0.15 {
            route.pop_front();
            if route.is_empty() {
                self.sim.command(Command::Stop);
            }
            return;
        }
        let error = libm::atan2(ahead.y, ahead.x);
        let forward = if error.abs() > 0.4 { 0.0 } else { 0.25 };
        self.sim.command(Command::Velocity {
            forward,
            turn: (2.5 * error).clamp(-1.0, 1.0),
        });
    }

    /// Passes odometry and scans to the filters.
    fn listen(&mut self) -> Result<()> {
        let odometry: Odometry = self.wheels.update(self.sim.stamp(), self.sim.ticks());
        self.history.push(&odometry);
        for (slam, _) in &mut self.filters {
            slam.predict(&odometry)?;
        }
        if let Some(scan) = self.sim.take_scan() {
            self.scan(&scan)?;
        }
        Ok(())
    }

    fn scan(&mut self, scan: &Scan) -> Result<()> {
        let points = Points::from_rolling_scan(scan, &self.history, &PointConfig::default());
        self.extractor.extract(&points, &mut self.lines)?;
        let world_from_robot = self.sim.truth();
        let truth = self.start.inverse() * world_from_robot;
        self.truth.push(truth.position());
        let wall_of = |line: &LineFeature| self.things.of_line(&world_from_robot, line.ends);
        let wall_of_line: Vec<_> = self.lines.iter().map(wall_of).collect();
        if self.finds_points {
            let mut asked = PointFeatureConfig::default();
            (asked.crossings.is_on, asked.spikes.is_on) = (false, false);
            self.points = find_points(&points, &self.lines, &LineConfig::default(), &asked)?;
        }
        let thing_of = |point: &PointFeature| {
            let is_round = point.kind.is_round();
            (self.things).of_point_in_sweep(&world_from_robot, point.position, is_round)
        };
        let things_of_points: Vec<_> = self.points.iter().map(thing_of).collect();
        let timing = SweepTiming::at(points.stamp, scan);
        for (slam, listener) in &mut self.filters {
            slam.update_with_points(&self.lines, &self.points, &timing)?;
            listener.note(slam, &truth, &wall_of_line);
            listener.note_points(slam, &things_of_points);
        }
        Ok(())
    }

    fn finish(self, seed: u64) -> Vec<Listener> {
        let (truth, walls, start) = (self.truth, self.walls, self.start);
        let finish = |(slam, listener): (EkfSlam, Listener)| {
            let ends = listener.track.last().zip(truth.last());
            Listener {
                seed,
                ate: ate_rmse(&truth, &listener.track).unwrap_or(f64::NAN),
                end_error: ends.map_or(f64::NAN, |(estimate, truth)| (estimate - truth).length()),
                confirmed_points: slam.point_landmarks().filter(|p| p.is_confirmed).count(),
                confirmed: slam.landmarks().filter(|l| l.is_confirmed).count(),
                duplicates: listener.count_duplicates(&slam, &walls, &start),
                ..listener
            }
        };
        self.filters.into_iter().map(finish).collect()
    }
}

impl Listener {
    fn note(&mut self, slam: &EkfSlam, truth: &Pose2, wall_of_line: &[Option<Thing>]) {
        let report = slam.report();
        for &(feature, id) in &report.added {
            if let Some(Some(wall)) = wall_of_line.get(feature) {
                self.wall_of.push((id, *wall));
            }
        }
        for found in &report.matches {
            let seen = wall_of_line.get(found.feature).copied().flatten();
            self.matches_of_no_wall += usize::from(seen.is_none());
            if let Some((seen, known)) = seen.zip(self.wall(found.landmark))
                && !seen.is_same(&known)
            {
                self.wrong_matches += 1;
                if let Some(pair) = number(&seen).zip(number(&known)) {
                    *self.wrong_pairs.entry(pair).or_default() += 1;
                }
            }
        }
        for merged in &report.merged {
            if let Some((kept, gone)) = self.wall(merged.kept).zip(self.wall(merged.gone)) {
                self.wrong_merges += usize::from(!kept.is_same(&gone));
            }
        }
        self.matches += report.matches.len();
        self.merged += report.merged.len();
        self.nis += report.nis;
        self.nis_degrees += report.nis_degrees();
        let estimate = slam.estimate();
        self.nees.push(estimate.nees(truth).unwrap_or(f64::NAN));
        let turned = wrap(estimate.pose.heading() - truth.heading());
        let variance = estimate.cov[(2, 2)];
        self.heading_nees.push(turned * turned / variance);
        self.track.push(estimate.pose.position());
    }

    fn note_points(&mut self, slam: &EkfSlam, things: &[Option<Thing>]) {
        let report = slam.report();
        for &(point, id) in &report.points_added {
            if let Some(Some(thing)) = things.get(point) {
                self.wall_of.push((id, *thing));
            }
        }
        for found in &report.point_matches {
            let seen = things.get(found.feature).copied().flatten();
            let known = self.wall(found.landmark);
            let is_wrong = seen.zip(known).is_some_and(|(seen, known)| seen != known);
            self.wrong_point_matches += usize::from(is_wrong);
        }
        self.point_matches += report.point_matches.len();
    }

    fn wall(&self, id: LandmarkId) -> Option<Thing> {
        let found = self.wall_of.iter().find(|(known, _)| *known == id);
        found.map(|(_, wall)| *wall)
    }

    fn count_duplicates(&self, slam: &EkfSlam, walls: &[Wall], start: &Pose2) -> usize {
        let touching = EkfConfig::default().association.max_gap;
        // The interval of each landmark along its wall.
        let confirmed = slam.landmarks().filter(|landmark| landmark.is_confirmed);
        let stretch = |landmark: Landmark| {
            let wall = number(&self.wall(landmark.id)?)?;
            let tangent = walls.get(wall)?.segment.vector().normalize();
            let ends = landmark.ends.map(|end| tangent.dot(&(*start * end).coords));
            Some((wall, ends[0].min(ends[1]), ends[0].max(ends[1])))
        };
        let known: Vec<(usize, f64, f64)> = confirmed.filter_map(stretch).collect();
        let pairs = (known.iter().enumerate())
            .flat_map(|(i, a)| known.iter().skip(i + 1).map(move |b| (a, b)));
        let touch = |(a, b): &(&(usize, f64, f64), &(usize, f64, f64))| {
            a.0 == b.0 && a.1.max(b.1) - a.2.min(b.2) <= touching
        };
        pairs.filter(touch).count()
    }
}

/// A wall's index in its world.
fn number(thing: &Thing) -> Option<usize> {
    match thing {
        Thing::Wall { number, .. } => Some(*number),
        Thing::Corner(_) | Thing::Round(_) => None,
    }
}
