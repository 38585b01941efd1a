//! A recorded log, for the page.

use slamlab_core::format::carmen::CarmenLog;
use slamlab_core::geom::{Pose2, Segment};
use slamlab_core::replay::{Log, LogReader, Replay};
use slamlab_core::robot::{RobotModel, Scan};
use slamlab_core::session::Session;
use slamlab_core::settings::Settings;
use slamlab_core::sim::SensorModel;
use slamlab_core::slam::Method;
use wasm_bindgen::prelude::{JsError, wasm_bindgen};

use crate::building::Known;
use crate::drive_fit::{FitTable, samples_since};
use crate::settings::{apply, apply_present};
use crate::shows_slam::shows_slam;
use crate::sigma::SigmaCurve;
use crate::status::RunStatus;

/// A log that is being read: of CARMEN, or a recording of the bridge.
#[wasm_bindgen]
#[derive(Debug)]
pub struct WebLogReader {
    reader: LogReader,
    method: Method,
    keys: Vec<String>,
    values: Vec<f64>,
    twin: bool,
    known: Option<Known>,
}

#[wasm_bindgen]
impl WebLogReader {
    /// For a replay by the given method, with the settings that differ from their defaults; those of a sensor and of driving do
    /// not matter to a log.
    ///
    /// # Errors    A sentence on a method or a setting that does not exist.
    #[wasm_bindgen(constructor)]
    pub fn new(method: &str, keys: Vec<String>, values: Vec<f64>) -> Result<Self, JsError> {
        // What cannot be set is told before a long log is read.
        let mut settings = Settings::of(SensorModel::lidar(), &RobotModel::pioneer());
        apply(&mut settings, &keys, &values)?;
        Ok(Self {
            reader: LogReader::default(),
            method: method.parse()?,
            keys,
            values,
            twin: false,
            known: None,
        })
    }

    /// A twin with the odometry's settings is to run beside the robot.
    pub fn with_twin(&mut self) {
        self.twin = true;
    }

    /// The map that the method `known-map` finds the robot in.
    pub fn find_in(&mut self, known: Known) {
        self.known = Some(known);
    }

    /// Takes the next bytes, as many as there are.
    ///
    /// # Errors    A sentence on what is wrong with the log, with its line or byte.
    pub fn push(&mut self, bytes: &[u8]) -> Result<(), JsError> {
        Ok(self.reader.push(bytes)?)
    }

    /// The log is all there: it can be replayed.
    ///
    /// # Errors    A sentence on what is wrong with the log, with its line or byte.
    pub fn finish(self) -> Result<WebReplay, JsError> {
        let log = self.reader.finish()?;
        let mut settings = log.settings();
        apply_present(&mut settings, &self.keys, &self.values)?;
        let calibration = settings.odometry.calibration(&log.robot());
        if let Some(known) = &self.known {
            settings.slam.prior_map = known.into();
        }
        let mut replay = Replay::new(log, self.method, &settings)?;
        if self.twin {
            replay.set_twin(Some(calibration));
        }
        Ok(WebReplay { replay })
    }
}

/// A log that is being mapped.
#[wasm_bindgen]
#[derive(Debug)]
pub struct WebReplay {
    replay: Replay,
}

#[wasm_bindgen]
impl WebReplay {
    /// Takes the next scan; false when there was none left.
    ///
    /// # Errors    A sentence on a scan that cannot be used.
    pub fn step(&mut self) -> Result<bool, JsError> {
        Ok(self.replay.step()?)
    }

    /// Settings that differ from the defaults, from the next scan on; those of a simulated sensor and body and of driving do not
    /// matter to a log.
    ///
    /// # Errors    A sentence on a setting that cannot be; then all stay as they were.
    #[allow(
        clippy::needless_pass_by_value,
        reason = "lists of text cross the border by value only"
    )]
    pub fn configure(&mut self, keys: Vec<String>, values: Vec<f64>) -> Result<(), JsError> {
        let mut settings = self.replay.log().settings();
        apply_present(&mut settings, &keys, &values)?;
        Ok(self.replay.reconfigure(&settings)?)
    }

    /// The numbers of the moment.
    #[must_use]
    pub fn status(&self) -> RunStatus {
        let replay = &self.replay;
        RunStatus {
            time: replay.time(),
            progress: replay.progress(),
            scans: replay.session().scans() as u32,
            ..RunStatus::of(replay.session())
        }
    }

    /// σ(ρ) of the sensor, from the stretches of the log in which the robot stood.
    ///
    /// # Errors    A sentence on why it cannot be told.
    pub fn estimate_sigma(&self, growth: &str) -> Result<SigmaCurve, JsError> {
        let stretches = self.replay.standing_stretches();
        let stretches: Vec<&[Scan]> = stretches.iter().map(Vec::as_slice).collect();
        SigmaCurve::of(&stretches, growth, None)
    }

    /// What the drive so far tells of the robot.
    #[must_use]
    pub fn fit(&self) -> FitTable {
        FitTable::of(&self.replay.fit())
    }

    /// Samples of the twin from number `from` on, see `TWIN` of www/src/protocol/figures.ts.
    #[must_use]
    pub fn twin_since(&self, from: u32) -> Vec<f64> {
        samples_since(self.replay.session().twin(), from)
    }

    /// What the log holds, in words.
    #[must_use]
    pub fn summary(&self) -> String {
        let log = self.replay.log();
        let (scans, seconds) = (log.scans(), log.duration());
        match log {
            Log::Carmen(carmen) => {
                let beams = carmen.scans.first();
                let beams = beams.map_or(0, |scan| carmen.readings(scan).len());
                format!("{scans} scans of {beams} beams in {seconds:.0} s")
            }
            Log::Recording(recording) => {
                let messages = recording.len();
                format!("{scans} scans and {messages} messages in {seconds:.0} s")
            }
        }
    }

    /// What a person should read: damage of the file, and time that was missed.
    #[must_use]
    pub fn notes(&mut self) -> Vec<String> {
        self.replay.take_notes()
    }

    /// For each scan so far: NaN NaN (no truth), odometry x y, estimate x y.
    #[must_use]
    pub fn trail(&self) -> Vec<f32> {
        let odometry = self.replay.odometry_trajectory();
        odometry
            .zip(self.replay.trajectory())
            .flat_map(|(odometry, (_, pose))| {
                [
                    f64::NAN,
                    f64::NAN,
                    odometry.x(),
                    odometry.y(),
                    pose.x(),
                    pose.y(),
                ]
                .map(|number| number as f32)
            })
            .collect()
    }

    /// Whether the filter is honest, and the likeliest cause if not: a name of `Diagnosis`.
    #[must_use]
    pub fn diagnosis(&self) -> String {
        self.replay
            .session()
            .consistency()
            .diagnosis()
            .name()
            .to_owned()
    }

    /// Fingerprint of the whole trajectory, 16 hexadecimal digits.
    #[must_use]
    pub fn state_hash(&self) -> String {
        format!("{:016x}", self.replay.state_hash())
    }
}

shows_slam!(WebReplay);

impl WebReplay {
    fn session(&self) -> &Session {
        self.replay.session()
    }

    fn true_walls(&self) -> Option<(Vec<Segment>, Pose2)> {
        None
    }

    fn trajectory(&self) -> Vec<(f64, Pose2)> {
        self.replay.trajectory()
    }

    fn scan_log(&self) -> Result<Box<CarmenLog>, JsError> {
        Ok(Box::new(self.replay.carmen_log()))
    }
}
