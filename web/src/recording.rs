//! Reads a log of any kind, piece by piece, and starts the run that maps it.

use std::iter::repeat;

use serde::{Deserialize, Serialize};
use slamlab_core::estimation::ScanMatcher;
use slamlab_core::format::poses::read_poses;
use slamlab_core::replay::{Log, LogReader, PoseError, PoseTrack, PosedLog, Replay};
use slamlab_core::robot::RobotModel;
use slamlab_core::settings::{self, Settings};
use slamlab_core::sim::SensorModel;
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{
    Float32Array, MethodName, PosesAs, SettingValues, TrailRow, Uint8Array, WebError, flat, typed,
};
use crate::building::PriorMapSetup;
use crate::run::{Source, WebRun};

/// How a log is to be mapped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
#[tsify(missing_as_null)]
pub struct ReplaySetup {
    /// The SLAM method.
    pub method: MethodName,
    /// Settings that differ from their defaults; those of a sensor and of driving do not affect a
    /// log.
    pub settings: SettingValues,
    /// Whether a twin with the odometry's settings runs beside the robot.
    pub twin: bool,
    /// The map for the method `prior-map`.
    pub prior_map: Option<PriorMapSetup>,
    /// Poses over time from another file, on the clock of the log.
    pub poses: Option<GivenPoses>,
}

/// A file of poses, and how they relate to a log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct GivenPoses {
    /// Name of the file.
    pub name: String,
    /// Its content.
    pub bytes: Uint8Array,
    /// What they are.
    pub are: PosesAs,
}

/// Errors of a run compared with true poses, after alignment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct TruthCurve {
    /// Seconds since the first scan.
    pub times: Float32Array,
    /// Distance of the positions, m.
    pub position: Float32Array,
    /// Heading error: estimate minus truth, rad.
    pub heading: Float32Array,
    /// A summary, one sentence.
    pub words: String,
}

/// A log that is being read.
#[wasm_bindgen]
#[derive(Debug)]
pub struct WebLogReader {
    reader: LogReader,
    setup: ReplaySetup,
    /// Poses of another file, read before the log, which may be long.
    poses: Option<Poses>,
}

#[derive(Debug)]
struct Poses {
    track: PoseTrack,
    are: PosesAs,
    notes: Vec<String>,
}

#[wasm_bindgen]
impl WebLogReader {
    /// A reader for a run with this setup.
    ///
    /// # Errors    A sentence on an invalid setting.
    #[wasm_bindgen(constructor)]
    pub fn new(setup: &Ts<ReplaySetup>) -> Result<Self, WebError> {
        let setup = setup.to_rust()?;
        // An invalid setting is reported before a long log is read.
        let mut settings = Settings::of(SensorModel::lidar(), &RobotModel::pioneer());
        setup
            .settings
            .apply_to(&mut settings, settings::Source::Recording, setup.method.0)?;
        let poses = setup.poses.as_ref().map(Poses::read).transpose()?;
        Ok(Self {
            reader: LogReader::default(),
            setup,
            poses,
        })
    }

    /// Takes the next bytes, as many as there are.
    ///
    /// # Errors    A sentence on what is wrong with the log, with its line or byte.
    pub fn push(&mut self, bytes: &[u8]) -> Result<(), WebError> {
        Ok(self.reader.push(bytes)?)
    }

    /// Ends the log and starts the run that maps it.
    ///
    /// # Errors    A sentence on what is wrong with the log, with its line or byte.
    pub fn finish(self) -> Result<WebRun, WebError> {
        let (mut log, setup, mut poses) = (self.reader.finish()?, self.setup, self.poses);
        let mut settings = log.settings();
        if let Some(Poses { track, .. }) = poses.take_if(|poses| poses.are == PosesAs::Odometry) {
            log = PosedLog::new(log, track, &settings.log)?.into();
        }
        let method = log.method(setup.method.0);
        setup
            .settings
            .apply_to(&mut settings, settings::Source::Recording, method)?;
        let calibration = settings.odometry.calibration(&log.robot(&settings.log));
        if let Some(map) = &setup.prior_map {
            settings.slam.prior_map = map.into();
        }
        let mut replay = Replay::new(log, setup.method.0, &settings)?;
        if let Some(Poses { track, notes, .. }) = poses {
            let untold = replay.set_truth(track)?;
            replay.add_notes(notes.into_iter().chain(untold));
        }
        replay.set_twin(setup.twin.then_some(calibration));
        let source = Source::Recording(Box::new(replay));
        Ok(WebRun::of(source))
    }
}

#[wasm_bindgen]
impl WebRun {
    /// For each scan of a recording so far, see `TRAIL`; without truth, unless another file gives
    /// it. For other sources the page collects the poses itself.
    #[must_use]
    pub fn trail(&self) -> Vec<f32> {
        let Source::Recording(replay) = &self.source else {
            return vec![];
        };
        let odometry = replay.odometry_trajectory();
        // Odometry of earlier runs in the same map is unknown.
        let earlier = self.slam().earlier_scans();
        let poses = odometry.zip(replay.trajectory().into_iter().skip(earlier));
        let map = self.slam().view().map;
        let submaps = map.into_iter().flat_map(ScanMatcher::scans_in_submaps);
        let submaps = submaps.skip(earlier).map(|(_, submap, _)| submap);
        let submaps = submaps.chain(repeat(0));
        let truths = replay.truths().map(|truth| match truth {
            Some(pose) => [pose.x() as f32, pose.y() as f32],
            None => [f32::NAN; 2],
        });
        let mut begin = None;
        flat(poses.zip(submaps).zip(truths).map(
            |(((odometry, (seconds, pose)), submap), truth)| TrailRow {
                truth_x: truth[0],
                truth_y: truth[1],
                odometry_x: odometry.x() as f32,
                odometry_y: odometry.y() as f32,
                x: pose.x() as f32,
                y: pose.y() as f32,
                submap: submap as f32,
                time: (seconds - *begin.get_or_insert(seconds)) as f32,
            },
        ))
    }

    /// Errors of the whole recording so far compared with true poses; `null` if there are none.
    ///
    /// # Errors    None that a page can cause.
    pub fn truth_curve(&self) -> Result<Option<Ts<TruthCurve>>, WebError> {
        let Source::Recording(replay) = &self.source else {
            return Ok(None);
        };
        let Some(errors) = replay.truth_errors() else {
            return Ok(None);
        };
        let begin = replay.first_seconds();
        let each = |value: fn(&PoseError) -> f64| -> Float32Array {
            errors
                .poses
                .iter()
                .map(|error| value(error) as f32)
                .collect()
        };
        let times = errors.poses.iter();
        let curve = TruthCurve {
            times: times.map(|error| (error.seconds - begin) as f32).collect(),
            position: each(|error| error.position),
            heading: each(|error| error.heading),
            words: errors.words(),
        };
        typed(&curve).map(Some)
    }

    /// The method that maps the log; without odometry it may differ from the requested one.
    #[must_use]
    #[wasm_bindgen(unchecked_return_type = "MethodName")]
    pub fn method(&self) -> String {
        self.slam().method().name().to_owned()
    }

    /// What the log holds, in words; empty if the run is not from a log.
    #[must_use]
    pub fn summary(&self) -> String {
        match &self.source {
            Source::Recording(replay) => summary(replay.log(), replay.duration()),
            _ => String::new(),
        }
    }
}

impl Poses {
    fn read(given: &GivenPoses) -> Result<Self, WebError> {
        let file = read_poses(&given.bytes)?;
        let repeated = file.repeated;
        let note = format!(
            "{}: {repeated} poses were left out, for another one has the same time",
            given.name
        );
        Ok(Self {
            track: file.into(),
            are: given.are,
            notes: (repeated > 0).then_some(note).into_iter().collect(),
        })
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
