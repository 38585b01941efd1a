//! The whole loop over a bridge: what robot and sensors say feeds [`Slam`], and what [`Pilot`] decides goes back to the robot.
//!
//! ```text
//!   bridge ── messages ──> Client ── odometry, scans ──> Timeline ──> Slam ── estimate, grid ──> Pilot ──┐
//!          <── messages ──        <──────────────────────────── commands ──────────────────────────────┘
//! ```
//!
//! 1. The bridge's hello names the robot; estimate and map begin with it. A robot in a new connection goes on in the old map.
//! 2. [`Live::receive`] takes a message, [`Live::tick`] lets the pilot decide; both say what to send by
//!    [`Live::take_outgoing`]. Time is µs of the caller's clock.
//! 3. The pilot's commands go out only while this client has the lease and the robot is armed. Whatever disarms it also ends
//!    the pilot's errand: nothing goes on by itself when the robot is armed again.

#[cfg(test)]
mod tests;

use crate::estimation::{ConsistencyWindow, Drive, DriveFit, OdometryFit};
use crate::geom::Pose2;
use crate::pilot::{Mode, Pilot, PilotConfig, Situation};
use crate::robot::{Bumpers, Command, Odometry, RobotModel, Scan, Stamp, ToldOdometry};
use crate::slam::{KnownMap, Method, Slam, SlamConfig, SlamError};
use crate::twin::Twin;
use crate::wire::client::{Client, ClientError};
use crate::wire::message::{
    Device, FromBridge, Motion, RecordingBody, RefusalReason, RobotFigures, Severity,
};
use crate::wire::timeline::{Reading, Timeline, explain_gap};

/// How often [`Live::tick`] is due: the pilot decides, and a command is told again, s.
pub const TICK_PERIOD: f64 = 0.05;

/// Something for a person to read.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    /// How grave it is.
    pub severity: Severity,
    /// In a sentence.
    pub text: String,
}

/// What a session with a bridge begins with.
#[derive(Clone, Debug)]
pub struct LiveConfig {
    /// How others see this client.
    pub name: String,
    /// The right to drive; none to watch.
    pub token: Option<String>,
    /// How the pose is estimated.
    pub method: Method,
    /// The map that [`Method::KnownMap`] finds the robot in, placed by where the robot is when the bridge names it; without one the
    /// line filter draws its own.
    pub known: Option<KnownMap>,
    /// Of the planner's random numbers.
    pub seed: u64,
}

/// A robot behind a bridge that is mapped and driven from here.
#[derive(Clone, Debug)]
pub struct Live {
    config: LiveConfig,
    client: Client,
    /// Estimate and intention; begins anew with the bridge's hello.
    state: State,
    /// How often it did.
    begun: u32,
    notes: Vec<Note>,
    devices: Vec<Device>,
    recording: Option<RecordingBody>,
    battery: Option<f32>,
    dropped: u64,
    watchers: u16,
    /// Arm as soon as the lease is granted.
    wants_to_arm: bool,
}

/// Estimate and intention.
#[derive(Clone, Debug)]
struct State {
    figures: Option<RobotFigures>,
    timeline: Timeline,
    slam: Slam,
    pilot: Pilot,
    model: RobotModel,
    bumpers: Bumpers,
    now: Stamp,
    scans: u32,
    distance: f64,
    dead_reckoning: Pose2,
    consistency: ConsistencyWindow,
    /// Standing was told already.
    is_told_to_stand: bool,
    /// What the tracks counted.
    drive: Drive,
    /// What is known better of the robot than it says.
    told: ToldOdometry,
    twin: Option<Twin>,
}

impl Live {
    /// A session that has not heard anything yet.
    ///
    /// # Errors    [`SlamError`] naming the first setting out of range.
    pub fn new(config: LiveConfig) -> Result<Self, SlamError> {
        Ok(Self {
            client: Client::new(&config.name, config.token.as_deref()),
            state: State::new(&config, None)?,
            config,
            begun: 0,
            notes: vec![],
            devices: vec![],
            recording: None,
            battery: None,
            dropped: 0,
            watchers: 0,
            wants_to_arm: false,
        })
    }

    /// The connection ended and another begins: map and pose stay, the right to drive does not.
    pub fn reconnect(&mut self) {
        self.client = Client::new(&self.config.name, self.config.token.as_deref());
        self.end_errand();
    }

    /// Takes one binary message of the bridge that came at `now`.
    ///
    /// # Errors    [`ClientError`]: the connection is of no use any more; map and pose are kept.
    pub fn receive(&mut self, now: u64, bytes: &[u8]) -> Result<(), ClientError> {
        let was_armed = self.client.is_armed();
        let (header, message) = self.client.receive(now, bytes)?;
        self.take_in(now, header.micros, message);
        if was_armed && !self.client.is_armed() {
            self.end_errand();
        }
        Ok(())
    }

    fn take_in(&mut self, now: u64, arrived: u64, message: FromBridge) {
        match message {
            FromBridge::Hello(hello) => self.begin(hello.robot),
            FromBridge::Odometry(body) => match body.odometry() {
                Ok(odometry) => {
                    self.feed(|state| state.timeline.odometry(body.source, arrived, odometry))
                }
                Err(error) => self.note(Severity::Warning, error.to_string()),
            },
            FromBridge::Scan(body) => {
                let source = body.source;
                match body.scan() {
                    Ok(scan) => self.feed(|state| {
                        let has_robot = state.figures.is_some();
                        state.timeline.scan(source, arrived, scan, has_robot)
                    }),
                    Err(error) => self.note(Severity::Warning, error.to_string()),
                }
            }
            FromBridge::Bumpers(body) => {
                self.state.bumpers = Bumpers {
                    left: body.left,
                    right: body.right,
                };
            }
            FromBridge::Battery(body) => self.battery = Some(body.volts),
            FromBridge::Devices(devices) => self.devices = devices,
            FromBridge::Recording(recording) => self.recording = Some(recording),
            FromBridge::Heartbeat(beat) => {
                (self.dropped, self.watchers) = (beat.dropped, beat.clients);
            }
            FromBridge::Event(event) => self.note(event.severity, event.text),
            FromBridge::Refused(reason) => self.refused(reason),
            FromBridge::Granted(_) if std::mem::take(&mut self.wants_to_arm) => {
                self.client.arm(now);
            }
            _ => (),
        }
    }

    /// Begins with this robot, or goes on with it.
    fn begin(&mut self, figures: Option<RobotFigures>) {
        if self.begun > 0 && self.state.figures == figures {
            return;
        }
        match State::new(&self.config, figures) {
            Ok(fresh) => {
                let told = self.state.told;
                self.state = State { told, ..fresh };
            }
            Err(error) => self.note(Severity::Error, error.to_string()),
        }
        self.begun += 1;
    }

    /// Hands on what the timeline lets through.
    fn feed(&mut self, through: impl FnOnce(&mut State) -> Vec<Reading>) {
        for reading in through(&mut self.state) {
            let taken = match reading {
                Reading::Odometry(odometry) => self.state.odometry(&odometry),
                Reading::Scan(scan) => self.state.scan(&scan),
                Reading::Gap { seconds } => {
                    self.state.drive.gap();
                    let text = explain_gap(seconds);
                    self.notes.push(Note {
                        severity: Severity::Warning,
                        text,
                    });
                    Ok(())
                }
            };
            if let Err(error) = taken {
                let text = format!("A reading was left out: {error}");
                self.notes.push(Note {
                    severity: Severity::Warning,
                    text,
                });
            }
        }
    }

    fn refused(&mut self, reason: RefusalReason) {
        self.wants_to_arm = false;
        let text = match reason {
            RefusalReason::NoRight => "Only whoever has the bridge's token may drive",
            RefusalReason::Held => "Somebody else drives; take over to stop the robot and drive it",
            RefusalReason::Emergency => "The emergency stop is latched; reset it first",
            RefusalReason::NoRobot => {
                "The robot's link is down: it cannot be armed, nor its emergency stop reset"
            }
            RefusalReason::TooOld | RefusalReason::FromTheFuture => {
                "A command came too late and was left out: the network is slow"
            }
            // The bridge has said by then why the lease or the arming ended.
            _ => return,
        };
        self.note(Severity::Warning, text.to_owned());
    }

    fn note(&mut self, severity: Severity, text: String) {
        self.notes.push(Note { severity, text });
    }

    /// Nothing is under way any more, an arming that waits for its lease neither: it would come after the Stop.
    fn end_errand(&mut self) {
        self.wants_to_arm = false;
        let state = &mut self.state;
        state.pilot.stop();
        state.is_told_to_stand = false;
        self.client.give_up_errand();
    }

    /// Due every [`TICK_PERIOD`]: heartbeats, and the pilot's decision where this client drives.
    ///
    /// # Errors    [`ClientError`]: the bridge is gone; map and pose are kept.
    pub fn tick(&mut self, now: u64) -> Result<(), ClientError> {
        self.client.tick(now)?;
        if !self.client.is_armed() {
            return Ok(());
        }
        if let Some(command) = self.state.decide(self.client.is_busy()) {
            self.client.drive(now, command.into());
        } else if self.client.is_busy() {
            self.client.hold(now);
        }
        Ok(())
    }

    /// Messages to send, in order; they are forgotten here.
    pub fn take_outgoing(&mut self) -> Vec<Vec<u8>> {
        self.client.take_outgoing()
    }

    /// What a person should read, in order; it is forgotten here.
    pub fn take_notes(&mut self) -> Vec<Note> {
        std::mem::take(&mut self.notes)
    }

    /// Asks for the right to drive, and arms the robot with it, but where its motors are cut off: then the right to undo that is wanted.
    /// With `force` also from somebody else.
    pub fn take_wheel(&mut self, now: u64, force: bool) {
        if self.client.has_lease() {
            self.client.arm(now);
        } else {
            let is_cut_off = self.client.safety().is_some_and(|s| s.emergency);
            self.wants_to_arm = !is_cut_off;
            self.client.take(now, force);
        }
    }

    /// Gives the right to drive back; the robot stops.
    pub fn leave_wheel(&mut self, now: u64) {
        self.end_errand();
        self.client.release(now);
    }

    /// Another errand for the robot. It moves while armed only.
    pub fn set_mode(&mut self, mode: Mode) {
        self.state.pilot.set_mode(mode);
        self.client.give_up_errand();
    }

    /// By hand, with these parts of the robot's highest speeds, -1 to 1.
    pub fn drive(&mut self, forward: f64, turn: f64) {
        let model = self.state.model;
        let (forward, turn) = (forward * model.max_speed, turn * model.max_turn_rate);
        self.state.pilot.drive(forward, turn);
        self.client.give_up_errand();
    }

    /// Stops the robot and disarms it, whoever drives it.
    pub fn stop(&mut self, now: u64) {
        self.end_errand();
        self.client.stop(now);
    }

    /// Cuts the motors off, whoever drives.
    pub fn emergency_stop(&mut self, now: u64) {
        self.end_errand();
        self.client.emergency_stop(now);
    }

    /// Unlatches the emergency stop; the robot stays disarmed.
    pub fn reset_emergency_stop(&mut self, now: u64) {
        self.client.reset_emergency_stop(now);
    }

    /// From here on the odometry is that of a robot of which so much is known; what is fitted stays what it counts.
    pub fn tell_odometry(&mut self, told: ToldOdometry) {
        self.state.told = told;
    }

    /// From here on a twin with these figures runs beside the robot; none: no longer.
    pub fn set_twin(&mut self, told: Option<ToldOdometry>) {
        let state = &mut self.state;
        let (width, at) = (state.model.track_width, state.slam.estimate().pose);
        state.twin = told.map(|told| Twin::new(told, width, at));
    }

    /// The twin that runs beside the robot.
    #[must_use]
    pub fn twin(&self) -> Option<&Twin> {
        self.state.twin.as_ref()
    }

    /// What the drive so far tells of the odometry, with the poses of SLAM as the truth. Scans are not kept: of the ranges a recording
    /// tells.
    #[must_use]
    pub fn fit(&self) -> DriveFit {
        let trajectory = self.state.slam.trajectory();
        let poses: Vec<Pose2> = trajectory.iter().map(|(_, pose)| *pose).collect();
        DriveFit {
            odometry: OdometryFit::new(&self.state.drive, &poses, &self.state.model),
            ranges: None,
            is_lidar: false,
        }
    }

    /// The conversation with the bridge.
    #[must_use]
    pub fn client(&self) -> &Client {
        &self.client
    }

    /// How often estimate and map began: with the first hello of a bridge, and with one that names another robot.
    #[must_use]
    pub fn begun(&self) -> u32 {
        self.begun
    }

    /// What the robot believes.
    #[must_use]
    pub fn slam(&self) -> &Slam {
        &self.state.slam
    }

    /// What it intends.
    #[must_use]
    pub fn pilot(&self) -> &Pilot {
        &self.state.pilot
    }

    /// Figures of the robot; of a Pioneer where none is known.
    #[must_use]
    pub fn model(&self) -> &RobotModel {
        &self.state.model
    }

    /// Where the wheels alone put the robot, map frame.
    #[must_use]
    pub fn odometry_pose(&self) -> Pose2 {
        self.state.dead_reckoning
    }

    /// Way driven by the wheels, m.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.state.distance
    }

    /// Scans taken in.
    #[must_use]
    pub fn scans(&self) -> u32 {
        self.state.scans
    }

    /// The robot's clock, as one that never begins anew.
    #[must_use]
    pub fn stamp(&self) -> Stamp {
        self.state.now
    }

    /// Whether the filter was honest in the last scans.
    #[must_use]
    pub fn consistency(&self) -> &ConsistencyWindow {
        &self.state.consistency
    }

    /// Robot and sensors, as last told.
    #[must_use]
    pub fn devices(&self) -> &[Device] {
        &self.devices
    }

    /// How the recording goes; none where nothing is recorded.
    #[must_use]
    pub fn recording(&self) -> Option<&RecordingBody> {
        self.recording.as_ref()
    }

    /// Volts of the battery; none before the robot told.
    #[must_use]
    pub fn battery(&self) -> Option<f32> {
        self.battery
    }

    /// Readings that this client missed because newer ones came before it took them.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Clients that are connected to the bridge, this one included.
    #[must_use]
    pub fn watchers(&self) -> u16 {
        self.watchers
    }
}

impl State {
    fn new(config: &LiveConfig, figures: Option<RobotFigures>) -> Result<Self, SlamError> {
        let (mut slam, pilot) = match &figures {
            Some(figures) if figures.scans_on_command => {
                (SlamConfig::short_range(), PilotConfig::short_range())
            }
            _ => (SlamConfig::default(), PilotConfig::default()),
        };
        // Without wheels, lines alone do not tell how far along a corridor the sensor was carried.
        let method = match (&figures, config.method, &config.known) {
            (Some(_), Method::KnownMap, Some(known)) => {
                slam.known.clone_from(known);
                Method::KnownMap
            }
            // A bridge has no map to hand out.
            (Some(_), Method::KnownMap, None) => Method::LineEkf,
            (Some(_), method, _) => method,
            (None, ..) => Method::ScanMatching,
        };
        let model = figures.as_ref().and_then(RobotFigures::model);
        let model = model.unwrap_or_else(RobotModel::pioneer);
        Ok(Self {
            figures,
            timeline: Timeline::default(),
            slam: Slam::new(method, slam)?,
            pilot: Pilot::new(model, pilot, config.seed),
            model,
            bumpers: Bumpers::default(),
            now: Stamp(0),
            scans: 0,
            distance: 0.0,
            dead_reckoning: Pose2::identity(),
            consistency: ConsistencyWindow::default(),
            is_told_to_stand: false,
            drive: Drive::default(),
            told: ToldOdometry::default(),
            twin: None,
        })
    }

    fn odometry(&mut self, odometry: &Odometry) -> Result<(), SlamError> {
        self.now = odometry.to;
        self.drive.odometry(odometry);
        if let Some(twin) = &mut self.twin {
            twin.odometry(odometry);
        }
        self.dead_reckoning = self.dead_reckoning * odometry.motion;
        self.distance += odometry.motion.position().coords.norm();
        let told = self.told.corrected(odometry, self.model.track_width);
        self.slam.odometry(&told)
    }

    fn scan(&mut self, scan: &Scan) -> Result<(), SlamError> {
        self.scans += 1;
        self.slam.scan(scan)?;
        self.drive.scan();
        if let (Some(twin), Some(points)) = (&mut self.twin, self.slam.points()) {
            let at = scan.stamp.seconds();
            twin.scan(at, &self.slam.estimate(), points, self.slam.grid());
        }
        if let Some(report) = self.slam.explain() {
            self.consistency
                .push(None, report.nis, report.nis_degrees());
        }
        Ok(())
    }

    /// What to tell the robot; `None` where nothing is to be said.
    fn decide(&mut self, robot_is_busy: bool) -> Option<Command> {
        let estimate = self.slam.estimate();
        let command = self.pilot.steer(&Situation {
            stamp: self.now,
            estimate: &estimate,
            grid: self.slam.grid(),
            points: self.slam.obstacles(),
            walkers: self.slam.walkers(),
            bumpers: self.bumpers,
            motion_since_scan: self.slam.motion_since_scan(),
            heading_drift: self.slam.heading_drift(),
            speeds: self.slam.speeds(),
            robot_is_busy,
            scans_on_command: self.figures.as_ref().is_some_and(|f| f.scans_on_command),
        })?;
        // A robot that stands is told so once; the lease is kept without.
        let stands = Motion::from(command) == Motion::Halt;
        let again = stands && self.is_told_to_stand;
        self.is_told_to_stand = stands;
        (!again).then_some(command)
    }
}
