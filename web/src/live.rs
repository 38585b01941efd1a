//! A robot behind a bridge, for the page.

use std::collections::VecDeque;

use nalgebra::Point2;
use slamlab_core::format::carmen::CarmenLog;
use slamlab_core::geom::{Pose2, Segment};
use slamlab_core::live::{Live, LiveConfig, Note};
use slamlab_core::pilot::Mode;
use slamlab_core::session::Session;
use slamlab_core::wire::message::Severity;
use wasm_bindgen::prelude::{JsError, wasm_bindgen};

use crate::building::Known;
use crate::drive_fit::{FitTable, samples_since, told};
use crate::experiment::{activity_of, mode_name};
use crate::export::{ExportError, trajectory_of};
use crate::shows_slam::shows_slam;
use crate::status::RunStatus;
use crate::view;

/// A robot that is mapped and driven through a bridge. Bytes of the WebSocket come in and go out here; times are µs of the
/// page's clock.
#[wasm_bindgen]
#[derive(Debug)]
pub struct WebLive {
    live: Live,
    waiting: VecDeque<Vec<u8>>,
}

/// What a person sees of bridge and robot.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug, PartialEq)]
#[expect(
    missing_docs,
    reason = "names and units as in `BridgeState` of www/src/protocol/devices.ts"
)]
pub struct BridgeStatus {
    pub is_in: bool,
    pub may_drive: bool,
    pub has_lease: bool,
    pub armed: bool,
    pub emergency: bool,
    pub driver: String,
    pub reason: String,
    pub battery: f64,
    pub round_trip: f64,
    pub reading_age: f64,
    pub dropped: f64,
    pub watchers: u32,
    pub recording: String,
    pub recorded: f64,
    /// For each device: name, what it is, state, detail.
    pub devices: Vec<String>,
}

#[wasm_bindgen]
impl WebLive {
    /// `name` is how others see this page; an empty `token` only watches. `known` is the map that the method `known-map` finds the
    /// robot in, placed by where the robot is now.
    ///
    /// # Errors    A sentence on a method that does not exist.
    #[wasm_bindgen(constructor)]
    #[allow(
        clippy::needless_pass_by_value,
        reason = "handed over: the page need not free it"
    )]
    pub fn new(
        name: &str,
        token: &str,
        method: &str,
        seed: u32,
        known: Option<Known>,
    ) -> Result<Self, JsError> {
        let live = Live::new(LiveConfig {
            name: name.to_owned(),
            token: (!token.is_empty()).then(|| token.to_owned()),
            method: method.parse()?,
            prior_map: known.as_ref().map(Into::into),
            settings: vec![],
            seed: u64::from(seed),
        })?;
        Ok(Self {
            live,
            waiting: VecDeque::new(),
        })
    }

    /// Another connection begins; map and pose stay.
    pub fn reconnect(&mut self) {
        self.live.reconnect();
    }

    /// Takes one binary message.
    ///
    /// # Errors    A sentence on why the connection is of no use any more.
    pub fn receive(&mut self, now: f64, bytes: &[u8]) -> Result<(), JsError> {
        Ok(self.live.receive(now as u64, bytes)?)
    }

    /// Due every 50 ms.
    ///
    /// # Errors    The bridge is gone.
    pub fn tick(&mut self, now: f64) -> Result<(), JsError> {
        Ok(self.live.tick(now as u64)?)
    }

    /// The next message to send; empty when there is none.
    #[must_use]
    pub fn outgoing(&mut self) -> Vec<u8> {
        if self.waiting.is_empty() {
            self.waiting.extend(self.live.take_outgoing());
        }
        self.waiting.pop_front().unwrap_or_default()
    }

    /// What a person should read: `info`, `warn` or `error`, and the text, pair by pair.
    #[must_use]
    pub fn notes(&mut self) -> Vec<String> {
        let flat = |Note { severity, text }| {
            let level = match severity {
                Severity::Info => "info",
                _ => "warn",
            };
            [level.to_owned(), text]
        };
        self.live.take_notes().into_iter().flat_map(flat).collect()
    }

    /// Whether the bridge let this page in.
    #[must_use]
    pub fn is_in(&self) -> bool {
        self.live.client().is_in()
    }

    /// How often estimate and map began anew.
    #[must_use]
    pub fn begun(&self) -> u32 {
        self.live.begun()
    }

    /// Asks for the right to drive, and arms.
    pub fn take_wheel(&mut self, now: f64, force: bool) {
        self.live.take_wheel(now as u64, force);
    }

    /// Gives the right to drive back; the robot stops.
    pub fn leave_wheel(&mut self, now: f64) {
        self.live.leave_wheel(now as u64);
    }

    /// Stops the robot and disarms it, whoever drives.
    pub fn stop(&mut self, now: f64) {
        self.live.stop(now as u64);
    }

    /// Cuts the motors off, whoever drives.
    pub fn emergency_stop(&mut self, now: f64) {
        self.live.emergency_stop(now as u64);
    }

    /// Unlatches the emergency stop.
    pub fn reset_emergency_stop(&mut self, now: f64) {
        self.live.reset_emergency_stop(now as u64);
    }

    /// Explore from here on.
    pub fn explore(&mut self) {
        self.live.set_mode(Mode::Explore);
    }

    /// Wait for the hand.
    pub fn manual(&mut self) {
        self.live.set_mode(Mode::Manual);
    }

    /// Go to a point of the map, m.
    pub fn go_to(&mut self, x: f64, y: f64) {
        self.live.set_mode(Mode::GoTo(Point2::new(x, y)));
    }

    /// Drive by hand; fractions of the robot's highest speeds in [-1, 1], forward and to the left.
    pub fn drive(&mut self, forward: f64, turn: f64) {
        self.live.drive(forward, turn);
    }

    /// What bridge and robot say of themselves.
    #[must_use]
    pub fn bridge(&self) -> BridgeStatus {
        let (live, client) = (&self.live, self.live.client());
        let (safety, delays) = (client.safety(), client.delays());
        let recording = live.recording();
        let devices = live.devices().iter().flat_map(|device| {
            let state = device.state.name();
            [&device.name, &device.model, state, &device.detail].map(|text| text.to_owned())
        });
        BridgeStatus {
            is_in: client.is_in(),
            may_drive: client.may_drive(),
            has_lease: client.has_lease(),
            armed: client.is_armed(),
            emergency: safety.is_some_and(|safety| safety.emergency),
            driver: safety
                .filter(|safety| safety.driver.is_some())
                .map(|safety| safety.driver_name.clone())
                .unwrap_or_default(),
            reason: safety
                .filter(|safety| !safety.armed)
                .map(|safety| safety.reason.name().to_owned())
                .unwrap_or_default(),
            battery: live.battery().map_or(f64::NAN, f64::from),
            round_trip: delays.map_or(f64::NAN, |delays| delays.round_trip),
            reading_age: delays.map_or(f64::NAN, |delays| delays.reading_age),
            dropped: live.dropped() as f64,
            watchers: u32::from(live.watchers()),
            recording: recording.map(|r| r.file.clone()).unwrap_or_default(),
            recorded: recording.map_or(f64::NAN, |r| r.acknowledged as f64),
            devices: devices.collect(),
        }
    }

    /// The numbers of the moment.
    #[must_use]
    pub fn status(&self) -> RunStatus {
        let live = &self.live;
        let goal = live.session().pilot().goal();
        RunStatus {
            time: live.session().stamp().seconds(),
            scans: live.session().scans() as u32,
            distance: live.session().distance(),
            goal_x: goal.map_or(f64::NAN, |goal| goal.x),
            goal_y: goal.map_or(f64::NAN, |goal| goal.y),
            finished: live.session().pilot().status().is_over(),
            ..RunStatus::of(live.session())
        }
    }

    /// `manual`, `goto` or `explore`.
    #[must_use]
    pub fn mode(&self) -> String {
        mode_name(self.live.session().pilot().mode()).to_owned()
    }

    /// What the pilot is doing, or how its errand ended, in words.
    #[must_use]
    pub fn activity(&self) -> String {
        activity_of(self.live.session().pilot())
    }

    /// What the drive so far tells of the robot.
    #[must_use]
    pub fn fit(&self) -> FitTable {
        FitTable::of(&self.live.session().fit())
    }

    /// Samples of the twin from number `from` on, see `TWIN` of www/src/protocol/figures.ts.
    #[must_use]
    pub fn twin_since(&self, from: u32) -> Vec<f64> {
        samples_since(self.live.session().twin(), from)
    }

    /// Settings that differ from the defaults from here on; those of a simulated sensor and body do not matter here.
    ///
    /// # Errors    A sentence on a setting that cannot be; then all stay as they were.
    #[allow(
        clippy::needless_pass_by_value,
        reason = "lists of text cross the border by value only"
    )]
    pub fn configure(&mut self, keys: Vec<String>, values: Vec<f64>) -> Result<(), JsError> {
        let changes = keys.into_iter().zip(values).collect();
        Ok(self.live.reconfigure(changes)?)
    }

    /// A twin with what these settings say of the odometry runs beside the robot from here on, or no longer.
    ///
    /// # Errors    A sentence on a setting that does not exist.
    #[allow(
        clippy::needless_pass_by_value,
        reason = "lists of text cross the border by value only"
    )]
    pub fn set_twin(
        &mut self,
        on: bool,
        keys: Vec<String>,
        values: Vec<f64>,
    ) -> Result<(), JsError> {
        let told = told(self.live.session().robot(), &keys, &values)?;
        self.live.set_twin(on.then_some(told));
        Ok(())
    }

    /// x y of each corner of the path.
    #[must_use]
    pub fn path(&self) -> Vec<f32> {
        let path = self.live.session().pilot().path();
        path.map(|path| view::polyline(&path.points))
            .unwrap_or_default()
    }

    /// Whether the filter is honest, and the likeliest cause if not: a name of `Diagnosis`.
    #[must_use]
    pub fn diagnosis(&self) -> String {
        self.live
            .session()
            .consistency()
            .diagnosis()
            .name()
            .to_owned()
    }

    /// Fingerprint of pose and map, 16 hexadecimal digits.
    #[must_use]
    pub fn state_hash(&self) -> String {
        let mut hash = slamlab_core::hash::StateHash::new();
        self.live.session().slam().add_to(&mut hash);
        format!("{:016x}", hash.finish())
    }
}

shows_slam!(WebLive);

impl WebLive {
    fn session(&self) -> &Session {
        self.live.session()
    }

    fn true_walls(&self) -> Option<(Vec<Segment>, Pose2)> {
        None
    }

    fn trajectory(&self) -> Vec<(f64, Pose2)> {
        trajectory_of(self.session().slam())
    }

    fn scan_log(&self) -> Result<Box<CarmenLog>, JsError> {
        Err(ExportError::Recorded.into())
    }
}
