//! The simulated robot: the same commands in and the same readings out as from a real one.
//!
//! Time runs in steps of [`TIME_STEP`]. In each step: movers walk, the drive turns the tracks, the body slips and
//! collides, the sensor takes the readings that fall into the step.

use std::collections::VecDeque;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::body::{Body, Bumpers};
use super::drive::Drive;
use super::movers::Walker;
use super::sensors::{Sensor, SensorError, SensorModel, Span, View};
use super::{Caster, Disc, World, WorldError};
use crate::geom::Pose2;
use crate::robot::{Command, RobotModel, Scan, Stamp, Tracks};

/// Simulated time of one step, s.
pub const TIME_STEP: f64 = 0.005;
const STEP_MICROS: u64 = 5_000;
/// Steps that are remembered for readings at an earlier stamp: two seconds.
const REMEMBERED: usize = 400;
/// Scans that wait to be taken; more push out the oldest.
const MOST_WAITING: usize = 16;

/// Why a simulation cannot begin.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
    /// The world cannot be used.
    #[error("world {name:?}: {source}")]
    World {
        /// Name of the world.
        name: String,
        /// What is wrong with it.
        source: WorldError,
    },
    /// The sensor cannot be used.
    #[error(transparent)]
    Sensor(#[from] SensorError),
    /// The robot cannot be used.
    #[error("robot: {field} is {value}, expected more than 0 and finite")]
    Robot {
        /// The figure.
        field: &'static str,
        /// What stands there.
        value: f64,
    },
}

/// A robot in a world.
#[derive(Clone, Debug)]
pub struct Simulation {
    world: World,
    robot: RobotModel,
    sensor_model: SensorModel,
    caster: Caster,
    walkers: Vec<Walker>,
    movers: Vec<Disc>,
    drive: Drive,
    body: Body,
    sensor: Sensor,
    motion_rng: ChaCha8Rng,
    sensor_rng: ChaCha8Rng,
    steps: u64,
    /// Time asked for that is less than a step, s.
    pending: f64,
    /// What the tracks ran since the start, m.
    run: Tracks,
    /// The last steps, the newest at the back.
    memory: VecDeque<Moment>,
    scans: VecDeque<Scan>,
    scan: ScanOrder,
}

#[derive(Clone, Copy, Debug)]
struct Moment {
    ticks: [i64; 2],
    truth: Pose2,
}

/// How far a [`Command::Scan`] has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ScanOrder {
    None,
    /// The robot still has to stop.
    Waiting,
    UnderWay,
}

impl Simulation {
    /// A robot at the start of `world`.
    ///
    /// # Errors    [`SimError`]: a figure of world, robot or sensor is outside of its range, or the robot stands in a wall.
    pub fn new(
        world: World,
        robot: RobotModel,
        sensor: SensorModel,
        seed: u64,
    ) -> Result<Self, SimError> {
        check_robot(&robot)?;
        sensor.validate()?;
        if let Err(source) = world.validate(robot.radius()) {
            return Err(SimError::World {
                name: world.name,
                source,
            });
        }
        let walkers: Vec<Walker> = world.movers.iter().map(Walker::new).collect();
        let mut motion_rng = ChaCha8Rng::seed_from_u64(seed);
        motion_rng.set_stream(1);
        let mut sensor_rng = ChaCha8Rng::seed_from_u64(seed);
        sensor_rng.set_stream(2);
        let start = Moment {
            ticks: [0, 0],
            truth: world.start,
        };
        Ok(Self {
            caster: Caster::new(world.walls()),
            movers: walkers.iter().map(Walker::disc).collect(),
            walkers,
            drive: Drive::new(&robot),
            body: Body::new(&robot, &world.start),
            sensor: Sensor::new(&sensor),
            motion_rng,
            sensor_rng,
            steps: 0,
            pending: 0.0,
            run: Tracks::default(),
            memory: VecDeque::from([start]),
            scans: VecDeque::new(),
            scan: ScanOrder::None,
            world,
            robot,
            sensor_model: sensor,
        })
    }

    /// Tells the robot what to do; whatever was under way is given up.
    pub fn command(&mut self, command: Command) {
        self.drive.command(command);
        self.sensor.abort();
        self.scan = match command {
            Command::Scan => ScanOrder::Waiting,
            _ => ScanOrder::None,
        };
    }

    /// Lets time pass; what is less than a step is kept for the next call.
    ///
    /// # Units    `seconds` of simulated time; negative or not finite lets none pass.
    pub fn advance(&mut self, seconds: f64) {
        if !(seconds > 0.0 && seconds.is_finite()) {
            return;
        }
        self.pending += seconds;
        // Half a nanosecond of rounding must not delay a step to the next call.
        while self.pending > TIME_STEP - 5e-10 {
            self.pending -= TIME_STEP;
            self.step();
        }
    }

    /// The robot's clock: the end of the last step.
    #[must_use]
    pub fn stamp(&self) -> Stamp {
        Stamp(self.steps * STEP_MICROS)
    }

    /// Encoder counts since the start: left, right.
    #[must_use]
    pub fn ticks(&self) -> [i64; 2] {
        let counts = |metres: f64| (metres / self.robot.metres_per_tick).round() as i64;
        [counts(self.run.left), counts(self.run.right)]
    }

    /// Encoder counts at an earlier stamp (that of a scan, say), up to two seconds back; in between steps the nearest
    /// count of a straight line.
    #[must_use]
    pub fn ticks_at(&self, stamp: Stamp) -> Option<[i64; 2]> {
        let (before, after, part) = self.moments_around(stamp)?;
        let at = |i: i64, j: i64| i + ((j - i) as f64 * part).round() as i64;
        let ([left, right], [next_left, next_right]) = (before.ticks, after.ticks);
        Some([at(left, next_left), at(right, next_right)])
    }

    /// The oldest scan that nobody took yet.
    pub fn take_scan(&mut self) -> Option<Scan> {
        self.scans.pop_front()
    }

    /// Whether a `Forward`, `Turn` or `Scan` is under way.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        self.drive.is_busy() || self.scan != ScanOrder::None
    }

    /// Where the robot really is: `world_from_robot`.
    #[must_use]
    pub fn truth(&self) -> Pose2 {
        self.body.pose()
    }

    /// Where the robot really was at an earlier stamp, up to two seconds back: `world_from_robot`.
    #[must_use]
    pub fn truth_at(&self, stamp: Stamp) -> Option<Pose2> {
        let (before, after, part) = self.moments_around(stamp)?;
        Some(before.truth * before.truth.delta_to(&after.truth).fraction(part))
    }

    /// Forward speed, m/s, and turn rate, rad/s, that the tracks run at.
    #[must_use]
    pub fn speeds(&self) -> (f64, f64) {
        self.drive.speeds()
    }

    /// How often the body began to touch something.
    #[must_use]
    pub fn contacts(&self) -> u32 {
        self.body.contacts()
    }

    /// Which bumpers are pressed now.
    #[must_use]
    pub fn bumpers(&self) -> Bumpers {
        self.body.bumpers()
    }

    /// The world.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The walls of the world, ready for rays.
    #[must_use]
    pub fn caster(&self) -> &Caster {
        &self.caster
    }

    /// Where the movers are now, in the order of the world's.
    #[must_use]
    pub fn movers(&self) -> &[Disc] {
        &self.movers
    }

    /// The robot's figures.
    #[must_use]
    pub fn robot(&self) -> &RobotModel {
        &self.robot
    }

    /// The sensor's figures.
    #[must_use]
    pub fn sensor(&self) -> &SensorModel {
        &self.sensor_model
    }

    fn step(&mut self) {
        if self.scan == ScanOrder::Waiting && self.drive.stands() {
            self.sensor.begin(self.seconds());
            self.scan = ScanOrder::UnderWay;
        }
        let start = (self.body.position(), self.body.heading());
        let from = self.seconds();
        self.walk_movers();
        self.move_robot();
        self.steps += 1;
        let span = Span {
            from,
            to: self.seconds(),
            start,
            end: (self.body.position(), self.body.heading()),
        };
        let view = View {
            caster: &self.caster,
            movers: &self.movers,
        };
        if let Some(scan) = self.sensor.step(&span, &view, &mut self.sensor_rng) {
            self.keep(scan);
        }
        self.remember();
    }

    fn walk_movers(&mut self) {
        let robot = Disc {
            centre: self.body.position(),
            radius: self.body.radius(),
        };
        for (walker, disc) in self.walkers.iter_mut().zip(&mut self.movers) {
            walker.step(TIME_STEP, &robot);
            *disc = walker.disc();
        }
    }

    fn move_robot(&mut self) {
        let tracks = self.drive.step(TIME_STEP);
        self.run.left += tracks.left;
        self.run.right += tracks.right;
        self.body
            .step(&tracks, &self.caster, &self.movers, &mut self.motion_rng);
    }

    fn keep(&mut self, scan: Scan) {
        if self.scan == ScanOrder::UnderWay {
            self.scan = ScanOrder::None;
        }
        if self.scans.len() == MOST_WAITING {
            self.scans.pop_front();
        }
        self.scans.push_back(scan);
    }

    fn remember(&mut self) {
        if self.memory.len() == REMEMBERED {
            self.memory.pop_front();
        }
        self.memory.push_back(Moment {
            ticks: self.ticks(),
            truth: self.body.pose(),
        });
    }

    /// The remembered steps before and after `stamp`, and how far it is from the one to the other.
    fn moments_around(&self, stamp: Stamp) -> Option<(Moment, Moment, f64)> {
        let oldest = self.steps - (self.memory.len() as u64 - 1);
        let before = (stamp.0 / STEP_MICROS).checked_sub(oldest)? as usize;
        let part = (stamp.0 % STEP_MICROS) as f64 / STEP_MICROS as f64;
        let first = *self.memory.get(before)?;
        let second = if part > 0.0 {
            *self.memory.get(before + 1)?
        } else {
            first
        };
        Some((first, second, part))
    }

    fn seconds(&self) -> f64 {
        self.stamp().seconds()
    }
}

fn check_robot(robot: &RobotModel) -> Result<(), SimError> {
    let figures = [
        ("length", robot.length),
        ("width", robot.width),
        ("track_width", robot.track_width),
        ("metres_per_tick", robot.metres_per_tick),
        ("max_speed", robot.max_speed),
        ("max_turn_rate", robot.max_turn_rate),
        ("max_acceleration", robot.max_acceleration),
        ("max_turn_acceleration", robot.max_turn_acceleration),
    ];
    match figures
        .into_iter()
        .find(|(_, value)| !(*value > 0.0 && value.is_finite()))
    {
        None => Ok(()),
        Some((field, value)) => Err(SimError::Robot { field, value }),
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, TAU};

    use nalgebra::{Matrix3, Vector3};

    use super::*;
    use crate::robot::TrackOdometry;
    use crate::sim::{Material, worlds};

    fn simulation(name: &str, sensor: SensorModel, seed: u64) -> Simulation {
        let world = worlds::builtin(name).unwrap();
        Simulation::new(world, RobotModel::rp6(), sensor, seed).unwrap()
    }

    fn finish(sim: &mut Simulation, command: Command) {
        sim.command(command);
        while sim.is_busy() {
            sim.advance(TIME_STEP);
            assert!(sim.stamp().seconds() < 1e4);
        }
    }

    /// Drives like a cleaning robot: ahead until it touches something, then a turn; gives dead reckoning at the end.
    fn bounce(sim: &mut Simulation, seconds: f64) -> Pose2 {
        let mut odometry = TrackOdometry::new(sim.robot());
        let mut reckoned = sim.world().start;
        odometry.update(sim.stamp(), sim.ticks());
        let mut leg = 0_u32;
        while sim.stamp().seconds() < seconds {
            let clear = sim
                .caster()
                .clearance(sim.truth() * nalgebra::Point2::new(0.25, 0.0), 0.2)
                >= 0.2;
            if clear {
                sim.command(Command::Velocity {
                    forward: 0.25,
                    turn: 0.0,
                });
                sim.advance(0.05);
            } else {
                leg += 1;
                let turn = 1.3 + 0.37 * f64::from(leg % 5);
                finish(sim, Command::Turn(turn));
            }
            reckoned = reckoned * odometry.update(sim.stamp(), sim.ticks()).motion;
        }
        reckoned
    }

    #[test]
    fn same_seed_same_bits_and_sensor_does_not_change_the_motion() {
        let run = |sensor: SensorModel, seed| {
            let mut sim = simulation("arena", sensor, seed);
            sim.command(Command::Velocity {
                forward: 0.3,
                turn: 0.2,
            });
            sim.advance(3.0);
            let truth = sim.truth();
            (
                truth.x().to_bits(),
                truth.y().to_bits(),
                truth.heading().to_bits(),
                sim,
            )
        };
        let (mut first, mut again) = (run(SensorModel::lidar(), 5), run(SensorModel::lidar(), 5));
        assert_eq!((first.0, first.1, first.2), (again.0, again.1, again.2));
        let mut scans = 0;
        while let Some(scan) = first.3.take_scan() {
            let other = again.3.take_scan().unwrap();
            assert!(
                scan.ranges
                    .iter()
                    .zip(&other.ranges)
                    .all(|(a, b)| a.to_bits() == b.to_bits())
            );
            scans += 1;
        }
        assert_eq!(scans, 16);
        let rangers = run(SensorModel::rangers(), 5);
        assert_eq!(
            (first.0, first.1, first.2),
            (rangers.0, rangers.1, rangers.2)
        );
        let other = run(SensorModel::lidar(), 6);
        assert_ne!(first.0, other.0);
    }

    #[test]
    fn how_time_is_cut_does_not_matter() {
        let run = |part: f64, times: usize| {
            let mut sim = simulation("office", SensorModel::lidar(), 1);
            sim.command(Command::Velocity {
                forward: 0.2,
                turn: -0.1,
            });
            for _ in 0..times {
                sim.advance(part);
            }
            (sim.stamp(), sim.ticks(), sim.truth())
        };
        let whole = run(2.0, 1);
        assert_eq!(whole.0, Stamp(2_000_000));
        assert_eq!(whole, run(0.05, 40));
        assert_eq!(whole, run(0.001, 2000));
        let mut sim = simulation("office", SensorModel::lidar(), 1);
        for seconds in [f64::NAN, -1.0, f64::INFINITY] {
            sim.advance(seconds);
        }
        assert_eq!(sim.stamp(), Stamp(0));
    }

    #[test]
    fn forward_and_turn_end_at_the_count_that_was_asked_for() {
        let mut sim = simulation("office", SensorModel::lidar(), 3);
        let tick = sim.robot().metres_per_tick;
        finish(&mut sim, Command::Forward(0.6));
        let count = (0.6 / tick).round() as i64;
        assert_eq!(sim.ticks(), [count, count]);
        finish(&mut sim, Command::Turn(-FRAC_PI_2));
        let [left, right] = sim.ticks();
        let turned = (right - left) as f64 * tick / sim.robot().track_width;
        assert!((turned + FRAC_PI_2).abs() <= 2.0 * tick / sim.robot().track_width);
        assert_eq!(sim.contacts(), 0);
    }

    #[test]
    fn dead_reckoning_is_honest_about_its_error() {
        // One step of odometry over a small displacement, many seeds: NEES is χ² with 3 degrees of freedom.
        for (forward, turn) in [
            (0.25, 0.0),
            (0.2, 0.5),
            (-0.2, 0.3),
            (0.1, -1.0),
            (0.02, 1.2),
        ] {
            let runs = 600;
            let (mut sum, mut outer_five_percent) = (0.0, 0);
            let mut spread = Matrix3::zeros();
            for seed in 0..runs {
                let mut sim = simulation("office", SensorModel::rangers(), seed);
                let mut odometry = TrackOdometry::new(sim.robot());
                sim.command(Command::Velocity { forward, turn });
                // Up to speed first; then the odometry starts anew.
                sim.advance(0.7);
                odometry.update(sim.stamp(), sim.ticks());
                let before = sim.truth();
                sim.advance(0.4);
                let reckoned = odometry.update(sim.stamp(), sim.ticks());
                let truth = before.delta_to(&sim.truth());
                let error = Vector3::new(
                    truth.x() - reckoned.motion.x(),
                    truth.y() - reckoned.motion.y(),
                    truth.heading() - reckoned.motion.heading(),
                );
                let nees = error.dot(&reckoned.cov.cholesky().unwrap().solve(&error));
                sum += nees;
                // 95 % quantile of χ² with 3 degrees of freedom.
                outer_five_percent += u32::from(nees > 7.815);
                spread += error * error.transpose();
            }
            let n = runs as f64;
            // The mean of χ²(3) is 3, its variance 6; the part beyond the quantile is binomial.
            let mean = sum / n;
            assert!(
                (mean - 3.0).abs() < 4.0 * (6.0 / n).sqrt(),
                "{forward} {turn}: mean NEES {mean}"
            );
            let beyond = f64::from(outer_five_percent) / n;
            assert!(
                (beyond - 0.05).abs() < 4.0 * (0.05 * 0.95 / n).sqrt(),
                "{forward} {turn}: {beyond} beyond 95 %"
            );
        }
    }

    #[test]
    fn dead_reckoning_is_lost_after_a_few_tens_of_metres() {
        let errors = |name: &str, seconds: f64| {
            let mut errors: Vec<f64> = (0..20)
                .map(|seed| {
                    let mut sim = simulation(name, SensorModel::rangers(), seed);
                    let reckoned = bounce(&mut sim, seconds);
                    (reckoned.position() - sim.truth().position()).norm()
                })
                .collect();
            errors.sort_by(f64::total_cmp);
            errors
        };
        for (name, seconds) in [("arena", 120.0), ("doors", 240.0), ("office", 400.0)] {
            let errors = errors(name, seconds);
            println!("{name} {seconds} s: {errors:.2?}");
            assert!(errors[10] > 0.5, "{name}: median {}", errors[10]);
        }
    }

    #[test]
    fn driving_at_the_wall_makes_one_contact_and_no_hole() {
        let mut sim = simulation("corridor", SensorModel::lidar(), 2);
        sim.command(Command::Turn(FRAC_PI_2));
        sim.advance(3.0);
        sim.command(Command::Velocity {
            forward: 0.3,
            turn: 0.0,
        });
        sim.advance(10.0);
        assert_eq!(sim.contacts(), 1);
        assert!(sim.bumpers().left || sim.bumpers().right);
        let touch = 2.0 - sim.robot().radius();
        assert!(
            sim.truth().y() <= touch && sim.truth().y() > touch - 1e-3,
            "{:?}",
            sim.truth()
        );
        // The encoders know nothing of it.
        assert!(sim.ticks()[0] as f64 * sim.robot().metres_per_tick > 2.0);
    }

    #[test]
    fn standing_lidar_tells_the_true_ranges_within_its_sigmas() {
        let mut sim = simulation("office", SensorModel::lidar(), 9);
        sim.advance(9.0);
        let (mut squares, mut count, mut lost, mut wild) = (0.0, 0.0, 0.0, 0.0);
        while let Some(scan) = sim.take_scan() {
            assert_eq!(scan.validate(), Ok(()));
            assert!(scan.bearings.windows(2).all(|w| w[1] > w[0]));
            for (i, &bearing) in scan.bearings.iter().enumerate() {
                let angle = sim.truth().heading() + bearing;
                let direction = nalgebra::Vector2::new(libm::cos(angle), libm::sin(angle));
                let truth = sim.caster().cast(sim.truth().position(), direction, 12.0);
                let (range, sigma) = (f64::from(scan.ranges[i]), f64::from(scan.sigmas[i]));
                let Some(truth) = truth.filter(|t| t.distance < 11.5) else {
                    continue;
                };
                if range.is_nan() {
                    lost += 1.0;
                    continue;
                }
                // What the bearing's noise does to the range depends on the slant: only fairly square beams count.
                let wall = sim.caster().walls()[truth.surface]
                    .segment
                    .vector()
                    .normalize();
                if wall.perp(&direction).abs() < 0.7 {
                    continue;
                }
                let error = (range - truth.distance) / sigma;
                if error.abs() > 5.0 {
                    wild += 1.0;
                } else {
                    squares += error * error;
                    count += 1.0;
                }
            }
        }
        let variance: f64 = squares / count;
        assert!(
            count > 3000.0 && (variance - 1.0).abs() < 0.1,
            "{variance} of {count}"
        );
        assert!(
            lost / count < 0.03 && wild / count < 0.01,
            "{lost} {wild} of {count}"
        );
    }

    #[test]
    fn moving_lidar_takes_each_beam_from_where_it_was() {
        // Driving at a wall: the beam straight ahead is in the middle of the revolution, half a sweep old.
        let quiet = super::super::sensors::LidarModel {
            sigma: 1e-6,
            sigma_per_metre: 0.0,
            bearing_sigma: 0.0,
            dropouts: 0.0,
            outliers: 0.0,
            ..Default::default()
        };
        let mut robot = RobotModel::rp6();
        robot.odometry_noise = crate::robot::OdometryNoise {
            per_metre: 0.0,
            lateral_per_metre: 0.0,
            heading_per_radian: 0.0,
        };
        let mut world = worlds::builtin("corridor").unwrap();
        world.start = Pose2::new(25.0, 1.0, 0.0);
        let mut sim = Simulation::new(world, robot, SensorModel::Lidar(quiet), 0).unwrap();
        sim.command(Command::Velocity {
            forward: 0.3,
            turn: 0.0,
        });
        sim.advance(1.8);
        let scan = std::iter::from_fn(|| sim.take_scan()).last().unwrap();
        assert_eq!(scan.stamp, sim.stamp());
        assert_eq!(sim.truth_at(scan.stamp), Some(sim.truth()));
        for (i, &range) in scan.ranges.iter().enumerate() {
            let x = sim.truth().x() - 0.3 * scan.sweep * scan.age_fraction(i);
            let ahead = libm::cos(scan.bearings[i]);
            if ahead > 0.98 {
                let expect = (30.0 - x) / ahead;
                assert!(
                    (f64::from(range) - expect).abs() < 1e-4,
                    "beam {i}: {range} against {expect}"
                );
            }
        }
    }

    #[test]
    fn rangers_look_round_once_when_told_and_the_robot_stands_meanwhile() {
        let mut sim = simulation("arena", SensorModel::rangers(), 4);
        sim.advance(5.0);
        assert_eq!(sim.take_scan(), None);
        sim.command(Command::Velocity {
            forward: 0.3,
            turn: 0.0,
        });
        sim.advance(1.0);
        let began = sim.stamp();
        finish(&mut sim, Command::Scan);
        let scan = sim.take_scan().unwrap();
        assert_eq!(scan.validate(), Ok(()));
        assert_eq!((scan.len(), scan.sweep), (180, 0.0));
        assert!(
            scan.bearings
                .windows(2)
                .all(|w| (w[1] - w[0] - TAU / 180.0).abs() < 1e-9)
        );
        let seconds = sim.stamp().since(began);
        assert!(
            seconds > 45.0 * 0.038 && seconds < 45.0 * 0.038 + 0.6,
            "{seconds}"
        );
        assert!(
            scan.ranges.iter().any(|r| r.is_finite())
                && scan.ranges.iter().any(|r| r.is_infinite())
        );
        // A command in the middle gives the sweep up.
        sim.command(Command::Scan);
        sim.advance(1.0);
        sim.command(Command::Stop);
        sim.advance(3.0);
        assert!(sim.take_scan().is_none() && !sim.is_busy());
    }

    #[test]
    fn lidar_answers_scan_with_one_revolution_taken_standing() {
        let mut sim = simulation("arena", SensorModel::lidar(), 4);
        sim.command(Command::Velocity {
            forward: 0.3,
            turn: 0.0,
        });
        sim.advance(1.0);
        while sim.take_scan().is_some() {}
        finish(&mut sim, Command::Scan);
        let scan = std::iter::from_fn(|| sim.take_scan()).last().unwrap();
        assert_eq!(
            sim.truth_at(Stamp(scan.stamp.0 - 175_000)),
            Some(sim.truth())
        );
    }

    #[test]
    fn mover_is_seen_waits_for_the_robot_and_is_not_driven_through() {
        let mut world = worlds::builtin("corridor").unwrap();
        world.movers.push(super::super::Mover {
            waypoints: vec![
                nalgebra::Point2::new(5.0, 1.0),
                nalgebra::Point2::new(0.5, 1.0),
            ],
            closed: false,
            speed: 0.5,
            radius: 0.25,
        });
        let mut sim = Simulation::new(world, RobotModel::rp6(), SensorModel::lidar(), 1).unwrap();
        sim.advance(10.0);
        let gap = |sim: &Simulation| {
            let mover = sim.movers()[0];
            (mover.centre - sim.truth().position()).norm() - mover.radius - sim.robot().radius()
        };
        assert!(gap(&sim) > 0.09 && sim.contacts() == 0, "{}", gap(&sim));
        let scan = std::iter::from_fn(|| sim.take_scan()).last().unwrap();
        assert!(
            scan.ranges.iter().any(|r| *r < 0.3),
            "the mover is not seen"
        );
        sim.command(Command::Velocity {
            forward: 0.3,
            turn: 0.0,
        });
        sim.advance(3.0);
        assert!(
            gap(&sim) > -1e-6 && sim.contacts() == 1,
            "{} {}",
            gap(&sim),
            sim.contacts()
        );
    }

    #[test]
    fn counts_and_truth_of_the_past_are_those_that_were() {
        let mut sim = simulation("office", SensorModel::lidar(), 1);
        sim.command(Command::Velocity {
            forward: 0.3,
            turn: 0.4,
        });
        sim.advance(1.0);
        let (stamp, ticks, truth) = (sim.stamp(), sim.ticks(), sim.truth());
        sim.advance(1.5);
        assert_eq!(sim.ticks_at(stamp), Some(ticks));
        let then = sim.truth_at(stamp).unwrap();
        assert!((then.position() - truth.position()).norm() < 1e-12);
        assert_eq!(sim.ticks_at(sim.stamp()), Some(sim.ticks()));
        assert_eq!(sim.ticks_at(Stamp(0)), None);
        assert_eq!(sim.ticks_at(Stamp(sim.stamp().0 + 1)), None);
        let between = sim.truth_at(Stamp(stamp.0 + 2_500)).unwrap();
        assert!((between.position() - truth.position()).norm() < 0.3 * 0.005);
    }

    #[test]
    fn dark_walls_are_lost_from_afar_and_bad_figures_are_refused() {
        let mut world = worlds::builtin("corridor").unwrap();
        world.obstacles[0].material = Material::Dark;
        let mut sim = Simulation::new(world, RobotModel::rp6(), SensorModel::lidar(), 1).unwrap();
        sim.advance(0.2);
        let scan = sim.take_scan().unwrap();
        assert!(scan.ranges.iter().all(|r| r.is_nan() || *r < 3.2));

        let error = |robot: RobotModel, sensor: SensorModel, start: Pose2| {
            let mut world = worlds::builtin("arena").unwrap();
            world.start = start;
            Simulation::new(world, robot, sensor, 0)
                .unwrap_err()
                .to_string()
        };
        let fine = Pose2::new(0.6, 0.7, 0.0);
        let inside = error(
            RobotModel::rp6(),
            SensorModel::lidar(),
            Pose2::new(1.5, 1.3, 0.0),
        );
        assert!(inside.contains("world \"arena\": start: a robot of radius 0.1101 m at (1.5, 1.3) stands in obstacle 1 (a rectangle)"), "{inside}");
        let mut robot = RobotModel::rp6();
        robot.track_width = 0.0;
        assert!(error(robot, SensorModel::lidar(), fine).contains("track_width is 0"));
        let sensor = super::super::sensors::LidarModel {
            beams: 0,
            ..Default::default()
        };
        assert!(
            error(RobotModel::rp6(), SensorModel::Lidar(sensor), fine)
                .contains("lidar: beams is 0")
        );
    }
}
