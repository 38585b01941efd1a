//! Reads a log of any kind, piece by piece, and begins the run that maps it.

use std::iter::repeat;

use serde::{Deserialize, Serialize};
use slamlab_core::estimation::ScanMatcher;
use slamlab_core::replay::{Log, LogReader, Replay};
use slamlab_core::robot::RobotModel;
use slamlab_core::settings::{self, Settings};
use slamlab_core::sim::SensorModel;
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{MethodName, SettingValues, TrailRow, WebError, flat};
use crate::building::PriorMapSetup;
use crate::run::{Source, WebRun};

/// How a log is to be mapped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
#[tsify(missing_as_null)]
pub struct ReplaySetup {
    /// How it maps and finds itself.
    pub method: MethodName,
    /// Settings that differ from their defaults; those of a sensor and of driving do not matter to
    /// a log.
    pub settings: SettingValues,
    /// A twin with the odometry's settings runs beside the robot.
    pub twin: bool,
    /// The map that the method `prior-map` finds the robot in.
    pub prior_map: Option<PriorMapSetup>,
}

/// A log that is being read.
#[wasm_bindgen]
#[derive(Debug)]
pub struct WebLogReader {
    reader: LogReader,
    setup: ReplaySetup,
}

#[wasm_bindgen]
impl WebLogReader {
    /// For a run with this setup.
    ///
    /// # Errors    A sentence on a setting that cannot be.
    #[wasm_bindgen(constructor)]
    pub fn new(setup: &Ts<ReplaySetup>) -> Result<Self, WebError> {
        let setup = setup.to_rust()?;
        // A setting that cannot be is reported before a long log is read.
        let mut settings = Settings::of(SensorModel::lidar(), &RobotModel::pioneer());
        setup
            .settings
            .apply_to(&mut settings, settings::Source::Recording, setup.method.0)?;
        Ok(Self {
            reader: LogReader::default(),
            setup,
        })
    }

    /// Takes the next bytes, as many as there are.
    ///
    /// # Errors    A sentence on what is wrong with the log, with its line or byte.
    pub fn push(&mut self, bytes: &[u8]) -> Result<(), WebError> {
        Ok(self.reader.push(bytes)?)
    }

    /// The log is all there: it can be mapped.
    ///
    /// # Errors    A sentence on what is wrong with the log, with its line or byte.
    pub fn finish(self) -> Result<WebRun, WebError> {
        let (log, setup) = (self.reader.finish()?, self.setup);
        let mut settings = log.settings();
        let method = log.method(setup.method.0);
        setup
            .settings
            .apply_to(&mut settings, settings::Source::Recording, method)?;
        let calibration = settings.odometry.calibration(&log.robot(&settings.log));
        if let Some(map) = &setup.prior_map {
            settings.slam.prior_map = map.into();
        }
        let mut replay = Replay::new(log, setup.method.0, &settings)?;
        replay.set_twin(setup.twin.then_some(calibration));
        let source = Source::Recording(Box::new(replay));
        Ok(WebRun::of(source))
    }
}

#[wasm_bindgen]
impl WebRun {
    /// For each scan of a recording so far, see `TRAIL`; there is no truth. Of others the page
    /// follows the poses.
    #[must_use]
    pub fn trail(&self) -> Vec<f32> {
        let Source::Recording(replay) = &self.source else {
            return vec![];
        };
        let odometry = replay.odometry_trajectory();
        // Of earlier runs in the same map no odometry is known.
        let earlier = self.slam().earlier_scans();
        let poses = odometry.zip(replay.trajectory().into_iter().skip(earlier));
        let map = self.slam().view().map;
        let submaps = map.into_iter().flat_map(ScanMatcher::scans_in_submaps);
        let submaps = submaps.skip(earlier).map(|(_, submap, _)| submap);
        let submaps = submaps.chain(repeat(0));
        let mut begin = None;
        flat(
            poses
                .zip(submaps)
                .map(|((odometry, (seconds, pose)), submap)| TrailRow {
                    truth_x: f32::NAN,
                    truth_y: f32::NAN,
                    odometry_x: odometry.x() as f32,
                    odometry_y: odometry.y() as f32,
                    x: pose.x() as f32,
                    y: pose.y() as f32,
                    submap: submap as f32,
                    time: (seconds - *begin.get_or_insert(seconds)) as f32,
                }),
        )
    }

    /// The method that maps the log: without odometry it may be another than was asked for.
    #[must_use]
    #[wasm_bindgen(unchecked_return_type = "MethodName")]
    pub fn method(&self) -> String {
        self.slam().method().name().to_owned()
    }

    /// What the log holds, in words; empty without one.
    #[must_use]
    pub fn summary(&self) -> String {
        match &self.source {
            Source::Recording(replay) => summary(replay.log(), replay.duration()),
            _ => String::new(),
        }
    }
}

fn summary(log: &Log, seconds: f64) -> String {
    let scans = log.scans();
    match log {
        Log::Posed(posed) => {
            let own = summary(posed.log(), seconds);
            format!("{own}; how the robot moved is told by the poses of another file")
        }
        Log::Carmen(carmen) => {
            let beams = carmen.scans.first();
            let beams = beams.map_or(0, |scan| carmen.readings(scan).len());
            format!("{scans} scans of {beams} beams in {seconds:.0} s")
        }
        Log::Rover(_) => {
            format!("{scans} scans of 360 directions in {seconds:.0} s, with counts of wheels")
        }
        Log::Rangers(_) => format!("{scans} readings of four rangers in {seconds:.0} s"),
        Log::Revolutions(_) => format!(
            "{scans} revolutions of a lidar without wheels, {seconds:.0} s at the rate that is set"
        ),
        Log::Recording(recording) => {
            let messages = recording.len();
            format!("{scans} scans and {messages} messages in {seconds:.0} s")
        }
    }
}
