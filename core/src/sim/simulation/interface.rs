//! The simulated robot answers as every robot does.

use super::Simulation;
use crate::robot::{Bumpers, Command, Odometry, Robot, RobotModel, Scan, Stamp};

impl Robot for Simulation {
    fn model(&self) -> &RobotModel {
        &self.robot
    }

    fn stamp(&self) -> Stamp {
        self.stamp()
    }

    fn command(&mut self, command: Command) {
        self.command(command);
    }

    fn is_busy(&self) -> bool {
        self.is_busy()
    }

    fn odometry(&mut self) -> Odometry {
        self.odometry.update(self.stamp(), self.ticks())
    }

    fn take_scan(&mut self) -> Option<Scan> {
        self.take_scan()
    }

    fn take_partial_scan(&mut self) -> Option<Scan> {
        self.take_partial_scan()
    }

    fn bumpers(&self) -> Bumpers {
        self.bumpers()
    }

    fn scans_on_command(&self) -> bool {
        self.on_command || self.sensor_model.scans_on_command()
    }
}
