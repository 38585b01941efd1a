//! A recorded log, for the page.

use slamlab_core::format::{carmen::CarmenReader, map_server};
use slamlab_core::replay::Replay;
use slamlab_core::robot::RobotModel;
use slamlab_core::slam::{Method, SlamConfig};
use wasm_bindgen::prelude::{JsError, wasm_bindgen};

use crate::view::{self, GridBlocks};

/// The numbers of the moment; poses in the map frame, m and rad.
#[wasm_bindgen]
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    missing_docs,
    reason = "names and units as in `Status` of www/src/protocol.ts"
)]
pub struct ReplayStatus {
    pub time: f64,
    pub progress: f64,
    pub scans: u32,
    pub x: f64,
    pub y: f64,
    pub heading: f64,
    pub cov_xx: f64,
    pub cov_xy: f64,
    pub cov_yy: f64,
    pub cov_heading: f64,
    pub odometry_x: f64,
    pub odometry_y: f64,
    pub odometry_heading: f64,
    pub loop_closures: u32,
}

/// A CARMEN log that is being read.
#[wasm_bindgen]
#[derive(Debug)]
pub struct WebLogReader {
    reader: CarmenReader,
    method: Method,
}

#[wasm_bindgen]
impl WebLogReader {
    /// For a replay by the given method.
    ///
    /// # Errors    A sentence on a method that does not exist.
    #[wasm_bindgen(constructor)]
    pub fn new(method: &str) -> Result<Self, JsError> {
        Ok(Self {
            reader: CarmenReader::default(),
            method: method.parse()?,
        })
    }

    /// Takes the next bytes, as many as there are.
    ///
    /// # Errors    A sentence on what is wrong with the log, with its line.
    pub fn push(&mut self, bytes: &[u8]) -> Result<(), JsError> {
        Ok(self.reader.push(bytes)?)
    }

    /// The log is all there: it can be replayed.
    ///
    /// # Errors    A sentence on what is wrong with the log, with its line.
    pub fn finish(self) -> Result<WebReplay, JsError> {
        let log = self.reader.finish()?;
        let replay = Replay::new(log, self.method, SlamConfig::default())?;
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

    /// The numbers of the moment.
    #[must_use]
    pub fn status(&self) -> ReplayStatus {
        let (estimate, odometry) = (self.replay.slam().estimate(), self.replay.odometry_pose());
        let last = self.replay.last();
        ReplayStatus {
            time: last.map_or(0.0, |scan| self.replay.log().stamp(scan).seconds()),
            progress: self.replay.progress(),
            scans: self.replay.scans_done() as u32,
            x: estimate.pose.x(),
            y: estimate.pose.y(),
            heading: estimate.pose.heading(),
            cov_xx: estimate.cov[(0, 0)],
            cov_xy: estimate.cov[(0, 1)],
            cov_yy: estimate.cov[(1, 1)],
            cov_heading: estimate.cov[(2, 2)],
            odometry_x: odometry.x(),
            odometry_y: odometry.y(),
            odometry_heading: odometry.heading(),
            loop_closures: self.replay.slam().loop_closures() as u32,
        }
    }

    /// What the log holds, in words.
    #[must_use]
    pub fn summary(&self) -> String {
        let log = self.replay.log();
        let beams = log.scans.first().map_or(0, |scan| log.readings(scan).len());
        format!(
            "{} scans of {beams} beams in {:.0} s",
            log.scans.len(),
            log.duration()
        )
    }

    /// For each scan so far: NaN NaN (no truth), odometry x y, estimate x y.
    #[must_use]
    pub fn trail(&self) -> Vec<f32> {
        let scans = self.replay.log().scans.iter();
        let map_from_odom = self.replay.map_from_odom();
        scans
            .zip(self.replay.trajectory())
            .flat_map(|(scan, (_, pose))| {
                let odometry = map_from_odom * scan.odom_from_robot;
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

    /// Half length and half width of the robot, m. A log does not tell; most were recorded with a Pioneer.
    #[must_use]
    pub fn half_size(&self) -> Vec<f64> {
        let robot = RobotModel::pioneer();
        vec![0.5 * robot.length, 0.5 * robot.width]
    }

    /// x y of what the last scan hit.
    #[must_use]
    pub fn scan(&self) -> Vec<f32> {
        let slam = self.replay.slam();
        view::hits(slam.points(), &slam.estimate().pose)
    }

    /// The walls of the line map, see `LINE_STRIDE` of www/src/protocol.ts.
    #[must_use]
    pub fn lines(&self) -> Vec<f64> {
        view::lines(self.replay.slam())
    }

    /// Blocks of the grid that changed after a revision.
    #[must_use]
    pub fn grid_since(&self, revision: f64) -> GridBlocks {
        GridBlocks::since(self.replay.slam().grid(), revision)
    }

    /// Changes when the grid was drawn anew and old blocks are worth nothing.
    #[must_use]
    pub fn grid_generation(&self) -> u32 {
        self.replay.slam().grid_version() as u32
    }

    /// Side of a cell, m.
    #[must_use]
    pub fn grid_resolution(&self) -> f64 {
        self.replay.slam().grid().resolution()
    }

    /// Area known to be free, m². Costs more than a step.
    #[must_use]
    pub fn known_area(&self) -> f64 {
        view::free_area(self.replay.slam().grid())
    }

    /// Fingerprint of the whole trajectory, 16 hexadecimal digits.
    #[must_use]
    pub fn state_hash(&self) -> String {
        format!("{:016x}", self.replay.state_hash())
    }

    /// The grid as a PGM of map_server.
    ///
    /// # Errors    An empty map.
    pub fn map_pgm(&self) -> Result<Vec<u8>, JsError> {
        Ok(map_server::write(self.replay.slam().grid(), "")?.pgm)
    }

    /// The YAML of map_server that goes with the PGM of the given name.
    ///
    /// # Errors    An empty map.
    pub fn map_yaml(&self, image: &str) -> Result<String, JsError> {
        Ok(map_server::write(self.replay.slam().grid(), image)?.yaml)
    }
}
