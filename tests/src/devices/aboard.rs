//! A lidar that a robot carries: it sees from wherever the robot is.

use std::sync::Arc;

use super::{Device, Rp6, Rplidar, Socket};

/// An RPLIDAR in the middle of a simulated RP6, each on a line of its own.
#[derive(Debug)]
pub struct Aboard {
    lidar: Rplidar,
    robot: Arc<Socket<Rp6>>,
}

impl Aboard {
    /// This lidar on this robot.
    #[must_use]
    pub fn new(lidar: Rplidar, robot: Arc<Socket<Rp6>>) -> Self {
        Self { lidar, robot }
    }
}

impl Device for Aboard {
    fn baud_rate(&self) -> u32 {
        self.lidar.baud_rate()
    }

    fn power_on(&mut self) {
        self.lidar.power_on();
    }

    fn receive(&mut self, bytes: &[u8]) {
        self.lidar.receive(bytes);
    }

    fn advance(&mut self, seconds: f64) -> Vec<u8> {
        self.lidar.view.pose = self.robot.with(|robot| robot.simulation().truth());
        self.lidar.advance(seconds)
    }
}
