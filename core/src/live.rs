//! A robot behind a bridge as the source of a [`Session`]: the readings of robot and sensors feed
//! it, and its decisions go back.
//!
//! ```text
//!   bridge ── messages ──> Client ── odometry, scans ──> Timeline ──> Session ──┐
//!          <── messages ──        <─────────────── commands ───────────────────┘
//! ```
//!
//! 1. The bridge's hello names the robot; then estimate and map begin. If the same robot is named
//!    in a new connection, it continues in the old map.
//! 2. [`Live::receive`] takes a message, [`Live::tick`] lets the pilot decide; after either,
//!    [`Live::take_outgoing`] returns what to send. Time is µs of the caller's clock.
//! 3. The pilot's commands go out only while this client has the lease and the robot is armed.
//!    Whatever disarms it also ends the pilot's task, and so does asking for the right to drive:
//!    when the robot is armed, nothing begins or continues by itself.

mod bridge_map;
mod homing;
mod pose_state;
#[cfg(test)]
mod tests;

use nalgebra::Point2;

use crate::estimation::EditKind;
use crate::geom::geofence::GeofenceError;
use crate::pilot::Mode;
use crate::robot::{Bumpers, Command, OdometryCalibration, RobotModel};
use crate::session::{Session, SessionConfig};
use crate::settings::{Scope, SettingError, Settings, Source};
use crate::slam::{EarlierMap, Method, PriorMap, SlamError};
use crate::wire::client::{Client, ClientError};
use crate::wire::message::{
    Device, FromBridge, PoseBody, RecordingBody, RefusalReason, RobotFigures, Severity, ZoneBody,
    fence_of,
};
use crate::wire::timeline::{Reading, Timeline, explain_gap};
pub use bridge_map::BridgeMap;
pub use homing::{Homing, HomingConfig};

/// A message for people.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    /// Its severity.
    pub severity: Severity,
    /// Its text, a sentence.
    pub text: String,
}

/// The initial configuration of a session with a bridge.
#[derive(Clone, Debug)]
pub struct LiveConfig {
    /// The name that others see.
    pub name: String,
    /// The token for the right to drive; `None` to watch.
    pub token: Option<String>,
    /// How the pose is estimated.
    pub method: Method,
    /// The map in which a method localises the robot ([`Method::needs_prior_map`]), placed relative
    /// to where the robot is when the bridge names it; without one, the line filter draws its own.
    pub prior_map: Option<PriorMap>,
    /// Whether it drives by the cycle of TDK 2016 §6.3 (scan standing, plan, one turn, one leg),
    /// even if its sensor scans all the time.
    pub cycle: bool,
    /// Settings that differ from the defaults of the robot that the bridge names
    /// ([`Settings::of_robot`]); those of simulated sensors and bodies do not matter.
    pub settings: Vec<(String, f64)>,
    /// Seed of the planner's random numbers.
    pub seed: u64,
}

/// Why a session with a bridge cannot begin, or cannot use other settings.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LiveError {
    /// A setting that does not exist, or is out of range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// A setting that the estimation refuses.
    #[error(transparent)]
    Slam(#[from] SlamError),
}

/// A robot behind a bridge that is mapped and driven from here.
#[derive(Debug)]
pub struct Live {
    config: LiveConfig,
    client: Client,
    /// The saved map in which it continues.
    saved_map: Option<EarlierMap>,
    /// The robot that the bridge named.
    figures: Option<RobotFigures>,
    /// Restarts with each robot that is named, and so does the history of readings.
    session: Session,
    timeline: Timeline,
    bumpers: Bumpers,
    /// Whether standing still was already commanded.
    is_halted: bool,
    /// How often estimate and map have begun: with the first hello of a bridge, and with one that
    /// names another robot.
    pub begun: u32,
    notes: Vec<Note>,
    /// Robot and sensors, as last reported.
    pub devices: Vec<Device>,
    /// State of the recording; `None` if nothing is recorded.
    pub recording: Option<RecordingBody>,
    /// Volts of the battery; `None` before the robot reported them.
    pub battery: Option<f32>,
    /// Readings that this client missed because newer ones arrived first.
    pub dropped: u64,
    /// Clients that are connected to the bridge, this one included.
    pub watchers: u16,
    /// The bridge's own map.
    pub bridge_map: BridgeMap,
    /// End of the newest odometry, on the robot's own clock, µs.
    newest: u64,
    /// Whether to arm as soon as the lease is granted.
    wants_to_arm: bool,
}

impl Live {
    /// The protocol state of the connection with the bridge.
    #[must_use]
    pub fn client(&self) -> &Client {
        &self.client
    }

    /// What robot and sensors have reported so far, and what is intended; if the robot is unknown,
    /// with the figures of a Pioneer.
    #[must_use]
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// Continues in a saved map: now, and with each robot that the bridge names from here on. If
    /// robot or method do not allow it, they begin with an empty map.
    ///
    /// # Errors    [`SlamError`]; then nothing changes.
    pub fn go_on_in(&mut self, saved: EarlierMap) -> Result<(), SlamError> {
        self.session.go_on_in(saved.clone())?;
        self.saved_map = Some(saved);
        Ok(())
    }

    /// Edits the map by hand; see [`crate::slam::Slam::edit`].
    ///
    /// # Errors    [`SlamError`]; then the map stays as it was.
    pub fn edit(&mut self, kind: EditKind, corners: &[Point2<f64>]) -> Result<(), SlamError> {
        self.session.edit(kind, corners)
    }

    /// Undoes the last edit by hand; `false` if there is none.
    pub fn undo_edit(&mut self) -> bool {
        self.session.undo_edit()
    }

    /// Removes a submap from the map; see [`crate::slam::Slam::remove_submap`].
    ///
    /// # Errors    [`SlamError`]; then the map stays as it was.
    pub fn remove_submap(&mut self, submap: usize) -> Result<(), SlamError> {
        self.session.remove_submap(submap)
    }

    /// Puts back the submap that was removed last, and returns its number; `None` if there is none
    /// that can come back.
    pub fn undo_removal(&mut self) -> Option<usize> {
        self.session.undo_removal()
    }

    /// A session that has not received anything yet.
    ///
    /// # Errors    [`LiveError`] naming the first setting that is invalid.
    pub fn new(config: LiveConfig) -> Result<Self, LiveError> {
        let (session, _) = session_for(&config, None)?;
        Ok(Self {
            client: Client::new(&config.name, config.token.as_deref()),
            config,
            saved_map: None,
            figures: None,
            session,
            timeline: Timeline::default(),
            bumpers: Bumpers::default(),
            is_halted: false,
            begun: 0,
            notes: vec![],
            devices: vec![],
            recording: None,
            battery: None,
            dropped: 0,
            watchers: 0,
            bridge_map: BridgeMap::default(),
            newest: 0,
            wants_to_arm: false,
        })
    }

    /// The connection ended and another begins: map and pose stay, the right to drive does not.
    pub fn reconnect(&mut self) {
        self.client = Client::new(&self.config.name, self.config.token.as_deref());
        self.bridge_map = BridgeMap::default();
        self.end_task();
    }

    /// Discards map and pose, including a saved map, and begins where the robot stands.
    pub fn begin_anew(&mut self) {
        self.end_task();
        self.saved_map = None;
        let figures = self.figures.take();
        self.begin_with(figures);
    }

    /// The pose of the robot, for others who have its odometry too; `None` before its first
    /// reading.
    #[must_use]
    pub fn pose(&self) -> Option<PoseBody> {
        let state = pose_state::of(self.session.slam());
        let estimate = self.session.estimate();
        (self.newest > 0).then(|| PoseBody::new(self.newest, &estimate, state))
    }

    /// Takes one binary message of the bridge that arrived at `now`.
    ///
    /// # Errors    [`ClientError`]: the connection can no longer be used; map and pose are kept.
    pub fn receive(&mut self, now: u64, bytes: &[u8]) -> Result<(), ClientError> {
        let was_armed = self.client.is_armed();
        let (header, message) = self.client.receive(now, bytes)?;
        self.take_in(now, header.micros, message);
        if was_armed && !self.client.is_armed() {
            self.end_task();
        }
        Ok(())
    }

    fn take_in(&mut self, now: u64, arrived: u64, message: FromBridge) {
        let has_robot = self.figures.is_some();
        let readings = self.timeline.message(arrived, &message, has_robot);
        let is_reading = readings.is_some();
        match readings {
            Some(Ok(readings)) => self.feed(readings),
            Some(Err(error)) => self.note(Severity::Warning, error),
            None => {}
        }
        if let FromBridge::Odometry(body) = &message {
            self.newest = body.to;
        }
        let estimate = self.session.estimate().pose;
        if let Err(error) = self.bridge_map.take(&message, &estimate) {
            self.note(Severity::Warning, format!("The bridge's map: {error}"));
        }
        if let FromBridge::Geofence(_) | FromBridge::Pose(_) | FromBridge::Odometry(_) = message {
            let fence = self.bridge_map.fence_in_run();
            self.session.set_fence(fence.unwrap_or_default());
        }
        if is_reading {
            return;
        }
        match message {
            FromBridge::Hello(hello) => self.begin(hello.robot),
            FromBridge::Bumpers(body) => {
                self.bumpers = Bumpers {
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
            FromBridge::Notice(event) => self.note(event.severity, event.text),
            FromBridge::Refused(reason) => self.refused(reason),
            FromBridge::Granted(_) if std::mem::take(&mut self.wants_to_arm) => {
                self.client.arm(now);
            }
            _ => (),
        }
    }

    /// Begins with this robot, or continues with it.
    fn begin(&mut self, figures: Option<RobotFigures>) {
        if self.begun == 0 || self.figures != figures {
            self.begin_with(figures);
        }
    }

    fn begin_with(&mut self, figures: Option<RobotFigures>) {
        match session_for(&self.config, figures.as_ref()) {
            Ok((session, instead)) => {
                self.session = session;
                self.figures = figures;
                if let Some(saved) = self.saved_map.clone()
                    && let Err(error) = self.session.go_on_in(saved)
                {
                    self.note(Severity::Warning, error.to_string());
                }
                self.timeline = Timeline::default();
                self.bumpers = Bumpers::default();
                self.is_halted = false;
                if let Some(text) = instead {
                    self.note(Severity::Warning, text.to_owned());
                }
            }
            Err(error) => self.note(Severity::Error, error.to_string()),
        }
        self.begun += 1;
    }

    /// Passes on the readings that the timeline releases.
    fn feed(&mut self, readings: Vec<Reading>) {
        for reading in readings {
            let taken = match reading {
                Reading::Odometry(odometry) => self.session.odometry(&odometry),
                Reading::Scan(scan) => self.session.scan(&scan),
                Reading::PartialScan(scan) => self.session.partial_scan(&scan),
                Reading::Gap { seconds } => {
                    self.session.gap();
                    self.note(Severity::Warning, explain_gap(seconds));
                    Ok(())
                }
            };
            if let Err(error) = taken {
                let text = format!("A reading was left out: {error}");
                self.note(Severity::Warning, text);
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
            RefusalReason::Stopped => "The robot was stopped: only a person arms it again",
            RefusalReason::BatteryLow => {
                "The battery is nearly empty: charge it before the robot is armed"
            }
            RefusalReason::NoScan => {
                "The sensor is silent: look at its link before the robot is armed"
            }
            RefusalReason::NoPose => {
                "There is a geofence, and it is not known where the robot is: it cannot be armed until it finds itself in the map, or the geofence is taken away"
            }
            RefusalReason::BadFence => "These areas are no geofence: the one before stays",
            RefusalReason::Fenced => {
                "The map has a geofence: only an owner may begin it anew, for that is gone with it"
            }
            RefusalReason::NoMap => "This bridge does not map: there is nothing to begin anew",
            RefusalReason::TooOld | RefusalReason::FromTheFuture => {
                "A command came too late and was left out: the network is slow"
            }
            // By then the bridge has said why the lease or the arming ended.
            _ => return,
        };
        self.note(Severity::Warning, text.to_owned());
    }

    fn note(&mut self, severity: Severity, text: String) {
        self.notes.push(Note { severity, text });
    }

    /// Ends the task, and also an arming that waits for its lease: it would come after the Stop.
    fn end_task(&mut self) {
        self.wants_to_arm = false;
        self.session.stop();
        self.is_halted = false;
        self.client.give_up_manoeuvre();
    }

    /// To be called every 50 ms: sends heartbeats, and lets the pilot decide if this client drives.
    ///
    /// # Errors    [`ClientError`]: the bridge is gone; map and pose are kept.
    pub fn tick(&mut self, now: u64) -> Result<(), ClientError> {
        self.client.tick(now)?;
        if !self.client.is_armed() {
            return Ok(());
        }
        if let Some(motion) = self.decide() {
            self.client.drive(now, motion);
        } else if self.client.is_busy() {
            self.client.hold(now);
        }
        Ok(())
    }

    /// What to send. A standing robot is commanded to stand only once, because the lease does not
    /// depend on it.
    fn decide(&mut self) -> Option<Command> {
        let command = self.session.decide(self.bumpers, self.client.is_busy())?;
        if command == Command::Scan && !self.waits_for_command() {
            // Its sensor scans all the time: the next scan serves as the requested one.
            return None;
        }
        let was_halted = std::mem::replace(&mut self.is_halted, command == Command::Stop);
        (!(was_halted && self.is_halted)).then_some(command)
    }

    /// The messages to send, in order; the list is then empty.
    pub fn take_outgoing(&mut self) -> Vec<Vec<u8>> {
        self.client.take_outgoing()
    }

    /// Messages for people, in order; the list is then empty.
    pub fn take_notes(&mut self) -> Vec<Note> {
        std::mem::take(&mut self.notes)
    }

    /// Asks for the lease, with `force` even if another client has it, and arms the robot with it.
    /// If the emergency stop is latched, only the lease is taken, to reset it.
    pub fn take_lease(&mut self, now: u64, force: bool) {
        if !self.client.is_armed() {
            // A task chosen while the robot was disarmed must not begin by itself.
            self.end_task();
        }
        if self.client.has_lease() {
            self.client.arm(now);
        } else {
            let is_cut_off = self.client.safety().is_some_and(|s| s.emergency);
            self.wants_to_arm = !is_cut_off;
            self.client.take(now, force);
        }
    }

    /// Gives the lease back; the robot stops.
    pub fn release_lease(&mut self, now: u64) {
        self.end_task();
        self.client.release(now);
    }

    /// Gives the robot another task. It moves only while armed.
    pub fn set_mode(&mut self, mode: Mode) {
        self.choose_driving(mode);
        self.session.set_mode(mode);
        self.client.give_up_manoeuvre();
    }

    /// Drives by hand, at these parts of the robot's highest speeds, -1 to 1.
    pub fn drive(&mut self, forward: f64, turn: f64) {
        let robot = self.session.robot();
        let (forward, turn) = (forward * robot.max_speed, turn * robot.max_turn_rate);
        self.choose_driving(Mode::Manual);
        self.session.drive(forward, turn);
        self.client.give_up_manoeuvre();
    }

    /// Makes the robot drive by the cycle, or as continuously as its sensor allows; its task starts
    /// again.
    pub fn set_cycle(&mut self, cycle: bool) {
        self.config.cycle = cycle;
        self.choose_driving(self.session.pilot().mode());
        self.client.give_up_manoeuvre();
    }

    /// By the cycle or continuously. Driving by hand is always continuous if the sensor allows it:
    /// obstacles are then seen at once, and a silent sensor is noticed.
    fn choose_driving(&mut self, mode: Mode) {
        let by_cycle = self.config.cycle && mode != Mode::Manual;
        let on_command = self.waits_for_command() || by_cycle;
        if on_command != self.session.scans_on_command() {
            self.session.set_scans_on_command(on_command);
        }
    }

    /// The default settings of the present robot.
    #[must_use]
    pub fn defaults(&self) -> Settings {
        Settings::of_robot(self.session.robot(), self.waits_for_command())
    }

    /// Whether the robot's sensor scans only on command.
    fn waits_for_command(&self) -> bool {
        let figures = self.figures.as_ref();
        figures.is_some_and(|figures| figures.scans_on_command)
    }

    /// Stops the robot and disarms it, whoever drives it.
    pub fn stop(&mut self, now: u64) {
        self.end_task();
        self.client.stop(now);
    }

    /// Cuts power to the motors, whoever drives.
    pub fn emergency_stop(&mut self, now: u64) {
        self.end_task();
        self.client.emergency_stop(now);
    }

    /// Asks the bridge to restart its own map.
    pub fn reset_bridge_map(&mut self, now: u64) {
        self.client.reset_map(now);
    }

    /// Sets where in the bridge's own map the robot may be; without zones, everywhere.
    ///
    /// # Errors    [`GeofenceError`]; then nothing is sent.
    pub fn set_geofence(&mut self, now: u64, zones: Vec<ZoneBody>) -> Result<(), GeofenceError> {
        fence_of(&zones)?;
        self.client.set_geofence(now, zones);
        Ok(())
    }

    /// Resets the emergency stop; the robot stays disarmed.
    pub fn reset_emergency_stop(&mut self, now: u64) {
        self.client.reset_emergency_stop(now);
    }

    /// Changes these settings from their defaults from here on, for this robot and for those that
    /// the bridge names later; see [`Session::reconfigure`].
    ///
    /// # Errors    [`LiveError`] naming the first setting that is invalid; the old ones then stay.
    pub fn reconfigure(&mut self, changes: Vec<(String, f64)>) -> Result<(), LiveError> {
        let (method, on_command) = (self.session.slam().method(), self.waits_for_command());
        let settings = settings_of(self.session.robot(), on_command, method, &changes)?;
        self.session.reconfigure(&settings)?;
        self.config.settings = changes;
        Ok(())
    }

    /// See [`Session::draw_dead_reckoned`].
    pub fn draw_dead_reckoned(&mut self) {
        self.session.draw_dead_reckoned();
    }

    /// Runs a twin with this calibration beside the robot from here on, or no twin.
    pub fn set_twin(&mut self, calibration: Option<OdometryCalibration>) {
        self.session.set_twin(calibration);
    }
}

fn settings_of(
    robot: &RobotModel,
    scans_on_command: bool,
    method: Method,
    changes: &[(String, f64)],
) -> Result<Settings, SettingError> {
    let scope = Scope {
        source: Source::Live,
        method,
    };
    let mut settings = Settings::of_robot(robot, scans_on_command);
    settings.take(&scope, changes.iter().map(|(key, value)| (key, *value)))?;
    Ok(settings)
}

/// The session with the robot that the bridge named, if it named one, and the reason if its method
/// is not the requested one.
fn session_for(
    config: &LiveConfig,
    figures: Option<&RobotFigures>,
) -> Result<(Session, Option<&'static str>), LiveError> {
    let on_command = figures.is_some_and(|figures| figures.scans_on_command);
    let robot = figures.and_then(RobotFigures::model);
    let robot = robot.unwrap_or_else(RobotModel::pioneer);
    let (method, instead) = match (figures, config.method, &config.prior_map) {
        (None, Method::ScanMatching, _) => (Method::ScanMatching, None),
        // Without wheels, lines alone do not show how far along a corridor the sensor was carried.
        (None, ..) => (
            Method::ScanMatching,
            Some("The bridge has no robot: what its sensor sees is mapped by scan matching"),
        ),
        // The bridge's own map is only shown, not used for localisation.
        (Some(_), method, None) if method.needs_prior_map() => (
            Method::LineEkf,
            Some("No map was given to find the robot in: the line filter draws one"),
        ),
        (Some(_), method, _) => (method, None),
    };
    let settings = settings_of(&robot, on_command, method, &config.settings)?;
    let mut session = SessionConfig {
        method,
        seed: config.seed,
        ..SessionConfig::of(&settings, robot, on_command)
    };
    if let (true, Some(map)) = (method.needs_prior_map(), &config.prior_map) {
        session.slam.prior_map.clone_from(map);
    }
    Ok((Session::new(session)?, instead))
}
