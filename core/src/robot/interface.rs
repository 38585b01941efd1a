//! What every robot answers: the simulated one, a real one behind its bridge.

use super::{Bumpers, Command, Odometry, RobotModel, Scan, Stamp};

/// A robot, as its driver sees it.
///
/// Commands are taken at once and run by themselves; the last one holds. What the robot did and saw is asked for. Time is
/// the robot's own and passes outside of this trait. A link that breaks is a matter of its owner: here it looks like a
/// robot that stands and is silent.
///
/// Source: TDK 2016 §1.2: forward, turn left, turn right, odometry.
pub trait Robot {
    /// Its figures.
    fn model(&self) -> &RobotModel;

    /// Its clock.
    fn stamp(&self) -> Stamp;

    /// Tells it what to do; whatever was under way is given up. Figures that are not finite stop it.
    fn command(&mut self, command: Command);

    /// Whether a `Forward`, `Turn` or `Scan` is under way.
    fn is_busy(&self) -> bool;

    /// Its own estimate of its motion since it was last asked (at first: since it started), with covariance.
    fn odometry(&mut self) -> Odometry;

    /// The oldest scan that nobody took yet.
    fn take_scan(&mut self) -> Option<Scan>;

    /// The oldest partial scan that nobody took yet, of a sensor that sweeps only when the robot stands. Other sensors scan
    /// all the time and give none.
    fn take_partial_scan(&mut self) -> Option<Scan> {
        None
    }

    /// Which bumpers are pressed now; a robot without any presses none.
    fn bumpers(&self) -> Bumpers {
        Bumpers::default()
    }

    /// Whether it scans only on [`Command::Scan`], standing; others scan all the time.
    fn scans_on_command(&self) -> bool;
}
