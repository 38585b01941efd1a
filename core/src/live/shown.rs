//! What a session shows of the robot and of the bridge.

use super::Live;
use crate::estimation::{ConsistencyWindow, DriveFit, OdometryFit};
use crate::geom::Pose2;
use crate::pilot::Pilot;
use crate::robot::{RobotModel, Stamp};
use crate::slam::Slam;
use crate::twin::Twin;
use crate::wire::client::Client;
use crate::wire::message::{Device, RecordingBody};

impl Live {
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
