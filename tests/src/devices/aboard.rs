//! A lidar that a robot carries: it sees from the robot's pose, and it turns by the robot's time.
//!
//! In: bytes for the lidar. Out: the lidar's bytes.
//!
//! If the machine starves a robot of processor time, the robot's time lags behind. The world that
//! it moves in then lags too: a lidar turning in real time would see the robot creep, and their
//! measurements would not fit together.

use std::sync::Arc;

use slamlab_core::geom::Pose2;

use super::socket::MOST_AT_ONCE;
use super::{Device, Rplidar, Socket};

/// A robot that can carry something.
pub trait Carrier: Device {
    /// Where it is, in the world's frame.
    fn pose(&self) -> Pose2;

    /// The time that has passed for it, s; it never decreases.
    fn seconds(&self) -> f64;
}

/// An RPLIDAR in the middle of a simulated robot, each on a line of its own.
#[derive(Debug)]
pub struct Aboard<C> {
    lidar: Rplidar,
    robot: Arc<Socket<C>>,
    /// The robot's time up to which the lidar has turned, s.
    turned: f64,
}

impl<C: Carrier> Aboard<C> {
    /// This lidar on this robot.
    #[must_use]
    pub fn new(lidar: Rplidar, robot: Arc<Socket<C>>) -> Self {
        let turned = robot.with(|robot| robot.seconds());
        Self {
            lidar,
            robot,
            turned,
        }
    }
}

impl<C: Carrier> Device for Aboard<C> {
    fn baud_rate(&self) -> u32 {
        self.lidar.baud_rate()
    }

    fn power_on(&mut self) {
        self.lidar.power_on();
    }

    fn receive(&mut self, bytes: &[u8]) {
        self.lidar.receive(bytes);
    }

    fn advance(&mut self, _: f64) -> Vec<u8> {
        let (pose, now) = self.robot.with(|robot| (robot.pose(), robot.seconds()));
        self.lidar.view.pose = pose;
        // Without its cable, or without processor time, it did not turn.
        let seconds = (now - self.turned).min(MOST_AT_ONCE);
        self.turned = now;
        self.lidar.advance(seconds)
    }
}

#[cfg(test)]
mod tests {
    use slamlab_core::sim::worlds;
    use slamlab_core::wire::rplidar::request::Request;

    use super::*;
    use crate::devices::View;

    /// A robot whose time is set by the test.
    struct Told(f64);

    impl Carrier for Told {
        fn pose(&self) -> Pose2 {
            Pose2::new(1.5, 1.0, 0.0)
        }

        fn seconds(&self) -> f64 {
            self.0
        }
    }

    impl Device for Told {
        fn baud_rate(&self) -> u32 {
            38_400
        }

        fn power_on(&mut self) {}

        fn receive(&mut self, _: &[u8]) {}

        fn advance(&mut self, _: f64) -> Vec<u8> {
            vec![]
        }
    }

    #[test]
    fn the_lidar_turns_by_its_carriers_time() {
        let robot = Arc::new(Socket::unplugged(Told(3.0)).unwrap());
        let view = View::from_start(&worlds::builtin("arena").unwrap());
        let mut lidar = Aboard::new(Rplidar::new(view), Arc::clone(&robot));
        lidar.receive(&Request::Scan.encode());
        let mut said_at = |seconds: f64| {
            robot.with(|robot| robot.0 = seconds);
            // Only the robot's time counts: an hour passes outside.
            lidar.advance(3600.0).len()
        };
        assert_eq!(said_at(3.0), 7, "the descriptor");
        // 5 bytes every half millisecond.
        assert_eq!(said_at(3.0201), 40 * 5);
        assert_eq!(said_at(3.0201), 0);
        assert_eq!(said_at(9.0), 100 * 5, "what was missed is not made up for");
        assert_eq!(lidar.lidar.view.pose, Pose2::new(1.5, 1.0, 0.0));
    }
}
