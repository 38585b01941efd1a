//! The simulated robot: takes the same commands and gives the same readings as a real one.
//!
//! Time runs in steps of [`TIME_STEP`]. In each step, movers walk; motors and their controller run
//! for as many periods of [`DRIVE_PERIOD`] as fit; the body slips and collides, which the motors
//! feel in the next step; the sensor takes the readings that fall into the step.

mod beside;
mod check;
mod partial_scans;

use std::collections::VecDeque;

use rand_chacha::ChaCha8Rng;

use self::beside::Beside;
pub use self::check::SimError;
use self::check::check_robot;
use self::partial_scans::PartialScans;
use super::battery::{Battery, BatteryModel};
use super::body::Body;
use super::contact::Contacts;
use super::doors::{Doors, NoDoor};
use super::drive::Drive;
use super::movers::Walker;
use super::noise::stream;
#[cfg(doc)]
use super::response::DRIVE_PERIOD;
use super::sensors::{Sensor, SensorModel, Span, View};
use super::{Caster, Disc, World};
use crate::geom::{Length, Pose2, Segment};
use crate::robot::{
    Bumpers, Command, Odometry, RobotModel, Scan, Stamp, TrackOdometry, TrackWear, Tracks,
};

/// Simulated time of one step, s.
pub const TIME_STEP: f64 = 0.005;
const STEP_MICROS: u64 = 5_000;
/// Periods of the drive in a step.
const DRIVE_PERIODS: usize = 5;
/// Speed of the tracks over the ground from which on they push with all their grip, m/s.
const FULL_SCRUB: f64 = 0.02;
/// Room around a door leaf in which nobody may stand when it shuts, m.
const DOOR_ROOM: f64 = 0.02;
/// Scans that wait to be taken; further ones push out the oldest.
const MOST_WAITING: usize = 16;

/// A robot cannot stand at a given place.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("a robot of radius {radius} m cannot stand at ({x}, {y}): there is room for {room:.3} m")]
pub struct Blocked {
    /// The place, world frame, m.
    pub x: f64,
    /// The place, world frame, m.
    pub y: f64,
    /// Distance of the place from the nearest wall or mover, m.
    pub room: f64,
    /// Radius of the robot, m.
    pub radius: f64,
}

/// A robot in a world.
#[derive(Clone, Debug)]
pub struct Simulation {
    world: World,
    robot: RobotModel,
    sensor_model: SensorModel,
    caster: Caster,
    doors: Doors,
    walkers: Vec<Walker>,
    movers: Vec<Disc>,
    drive: Drive,
    body: Body,
    battery: Battery,
    sensor: Sensor,
    beside: Option<Beside>,
    partial_scans: PartialScans,
    motion_rng: ChaCha8Rng,
    sensor_rng: ChaCha8Rng,
    steps: u64,
    /// Requested time that is less than a step, s.
    pending: f64,
    odometry: TrackOdometry,
    scans: VecDeque<Scan>,
    scan: ScanOrder,
    /// Whether scans that nobody asked for are dropped, whatever the sensor.
    on_command: bool,
}

/// The progress of a [`Command::Scan`].
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
    /// # Errors    [`SimError`]: a figure of world, robot or sensor is out of its range, or the
    /// robot stands in a wall.
    pub fn new(
        world: World,
        robot: RobotModel,
        sensor: SensorModel,
        seed: u64,
    ) -> Result<Self, SimError> {
        check_robot(&robot)?;
        let at_work = Sensor::new(&sensor)?;
        if let Err(source) = world.validate(robot.radius()) {
            let name = world.name;
            return Err(SimError::World { name, source });
        }
        let doors = Doors::new(&world.doors);
        let walkers: Vec<Walker> = world.movers.iter().map(Walker::new).collect();
        let mut motion_rng = stream(seed, 1);
        let mut odometry = TrackOdometry::new(&robot);
        odometry.update(Stamp(0), [0, 0]);
        Ok(Self {
            caster: caster_of(&world, &doors),
            doors,
            movers: walkers.iter().map(|walker| walker.disc).collect(),
            walkers,
            body: Body::new(&robot, &world.start, &mut motion_rng),
            drive: Drive::new(&robot, &mut motion_rng)?,
            battery: Battery::new(BatteryModel::for_motors(robot.drive.battery)),
            sensor: at_work,
            beside: None,
            partial_scans: PartialScans::new(seed),
            motion_rng,
            sensor_rng: stream(seed, 2),
            steps: 0,
            pending: 0.0,
            odometry,
            scans: VecDeque::new(),
            scan: ScanOrder::None,
            on_command: false,
            world,
            robot,
            sensor_model: sensor,
        })
    }

    /// Commands the robot; whatever was in progress is given up.
    pub fn command(&mut self, command: Command) {
        self.drive.command(command);
        self.sensor.abort();
        self.sensor
            .moves(partial_scans::moves(&command), self.seconds());
        self.scan = match command {
            Command::Scan => ScanOrder::Waiting,
            _ => ScanOrder::None,
        };
    }

    /// From here on, the robot's tracks differ from its model in this way, whatever the seed gave
    /// it.
    pub fn set_wear(&mut self, wear: TrackWear) {
        self.body.wear = wear;
    }

    /// How the robot's tracks differ from its model: no robot knows this about itself.
    #[must_use]
    pub fn wear(&self) -> TrackWear {
        self.body.wear
    }

    /// Carries the robot elsewhere while its tracks go on as before: it does not notice.
    ///
    /// # Errors    [`Blocked`]: something stands there; the robot then stays where it is.
    pub fn kidnap(&mut self, world_from_robot: &Pose2) -> Result<(), Blocked> {
        let (at, radius) = (world_from_robot.position(), self.robot.radius());
        let walls = self.caster.clearance(at, radius);
        let movers = self.movers.iter();
        let movers = movers.map(|mover| (mover.centre - at).length() - mover.radius);
        let room = movers.fold(walls, f64::min);
        // NaN does not count as room either.
        if !world_from_robot.is_finite() || room.is_nan() || room < radius {
            return Err(Blocked {
                x: at.x,
                y: at.y,
                room,
                radius,
            });
        }
        self.body.place(world_from_robot);
        Ok(())
    }

    /// Whether a sensor that scans all the time returns scans only after [`Command::Scan`], while
    /// the robot stands. Scans that wait to be taken are dropped. Changes nothing for a sensor that
    /// scans on command anyway.
    pub fn set_on_command(&mut self, on_command: bool) {
        self.on_command = on_command;
        self.scans.clear();
        self.scan = ScanOrder::None;
    }

    /// Lets time pass; a remainder of less than a step is kept for the next call.
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
        self.drive.counts
    }

    /// The robot's own estimate of its motion since the last call (at first: since the start), with
    /// covariance.
    pub fn odometry(&mut self) -> Odometry {
        self.odometry.update(self.stamp(), self.ticks())
    }

    /// Whether it scans only on [`Command::Scan`], while standing; others scan all the time.
    #[must_use]
    pub fn scans_on_command(&self) -> bool {
        self.on_command || self.sensor_model.scans_on_command()
    }

    /// The oldest scan that was not taken yet.
    pub fn take_scan(&mut self) -> Option<Scan> {
        self.scans.pop_front()
    }

    /// Whether a `Forward`, `Turn` or `Scan` is in progress.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        self.drive.is_busy() || self.scan != ScanOrder::None
    }

    /// The robot's true pose: `world_from_robot`.
    #[must_use]
    pub fn truth(&self) -> Pose2 {
        self.body.pose()
    }

    /// Forward speed, m/s, and turn rate, rad/s, at which the tracks run.
    #[must_use]
    pub fn speeds(&self) -> (f64, f64) {
        self.drive.speeds()
    }

    /// Currents of the motors, A: left, right. They rise if the tracks push against something.
    #[must_use]
    pub fn motor_currents(&self) -> [f64; 2] {
        self.drive.currents()
    }

    /// How often the body began to touch something, by what was touched and who moved.
    #[must_use]
    pub fn contacts(&self) -> Contacts {
        self.body.contacts
    }

    /// Which bumpers are pressed now.
    #[must_use]
    pub fn bumpers(&self) -> Bumpers {
        self.body.bumpers()
    }

    /// Volts of the battery, as the robot's converter reads them.
    #[must_use]
    pub fn battery_volts(&self) -> f64 {
        self.battery.volts()
    }

    /// The world.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Opens or shuts a door of the world; its own switch times continue from there. A door that
    /// should shut waits until nobody stands in it.
    ///
    /// # Errors    [`NoDoor`].
    pub fn set_door(&mut self, index: usize, open: bool) -> Result<(), NoDoor> {
        self.doors.order(index, open)
    }

    /// Whether each door is open now, in the order of the world's doors.
    pub fn doors_open(&self) -> impl Iterator<Item = bool> + '_ {
        self.doors.are_open()
    }

    /// Whether each door should be open; if that differs from [`Self::doors_open`], it moves with
    /// the next step, or waits until nobody stands in it.
    pub fn doors_ordered(&self) -> impl Iterator<Item = bool> + '_ {
        self.doors.are_to_be_open()
    }

    /// The walls of the world and the doors that are shut now, ready for rays.
    #[must_use]
    pub fn caster(&self) -> &Caster {
        &self.caster
    }

    /// Where the movers are now, in the order of the world's movers.
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
        let start = (self.body.position, self.body.heading);
        let from = self.seconds();
        self.walk_movers();
        self.move_doors();
        self.move_robot();
        self.steps += 1;
        let span = Span {
            from,
            to: self.seconds(),
            start,
            end: (self.body.position, self.body.heading),
        };
        let view = View {
            caster: &self.caster,
            movers: &self.movers,
        };
        if let Some(beside) = &mut self.beside {
            beside.step(&span, &view);
        }
        self.partial_scans.step(&mut self.sensor, &span, &view);
        if let Some(scan) = self.sensor.step(&span, &view, &mut self.sensor_rng) {
            self.keep(scan);
        }
    }

    fn walk_movers(&mut self) {
        let robot = Disc {
            centre: self.body.position,
            radius: self.body.radius,
        };
        for (walker, disc) in self.walkers.iter_mut().zip(&mut self.movers) {
            walker.step(TIME_STEP, &robot);
            *disc = walker.disc;
        }
    }

    fn move_doors(&mut self) {
        let robot = Disc {
            centre: self.body.position,
            radius: self.body.radius,
        };
        let discs = self.movers.iter().chain([&robot]);
        // A body that touches a door leaf must not stand in it because of rounding.
        let is_clear = |leaf: &Segment| {
            let mut discs = discs.clone();
            discs.all(|disc| leaf.distance(disc.centre) > disc.radius + DOOR_ROOM)
        };
        if self.doors.step(self.seconds(), is_clear) {
            self.caster = caster_of(&self.world, &self.doors);
            self.body.forget_free_room();
        }
    }

    fn move_robot(&mut self) {
        let scrubbing = self.body.lost / TIME_STEP;
        let scrub = self.robot.drive.grip * (scrubbing / FULL_SCRUB).clamp(-1.0, 1.0);
        let mut tracks = Tracks::default();
        let mut watts = 0.0;
        self.drive.set_supply(self.battery.volts());
        for _ in 0..DRIVE_PERIODS {
            let ran = self.drive.step(scrub);
            tracks.left += ran.left;
            tracks.right += ran.right;
            watts += self.drive.watts();
        }
        self.battery.step(TIME_STEP, watts / DRIVE_PERIODS as f64);
        self.body
            .step(&tracks, &self.caster, &self.movers, &mut self.motion_rng);
    }

    fn keep(&mut self, scan: Scan) {
        if self.on_command && self.scan != ScanOrder::UnderWay {
            return;
        }
        if self.scan == ScanOrder::UnderWay {
            self.scan = ScanOrder::None;
        }
        keep_newest(&mut self.scans, scan);
    }

    fn seconds(&self) -> f64 {
        self.stamp().seconds()
    }
}

fn keep_newest(waiting: &mut VecDeque<Scan>, scan: Scan) {
    if waiting.len() == MOST_WAITING {
        waiting.pop_front();
    }
    waiting.push_back(scan);
}

/// Walls first, so doors do not change their indices.
fn caster_of(world: &World, doors: &Doors) -> Caster {
    let mut walls = world.walls();
    walls.extend(doors.shut());
    Caster::new(walls)
}

#[cfg(test)]
mod tests;
