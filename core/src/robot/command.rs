//! What a robot can be commanded to do.

/// A command to the robot; the simulated and the real one take the very same.
///
/// Source: TDK 2016 §1.2 (`Forward`, `Turn`, `Scan`), and `Velocity` for driving by hand and by the
/// pilot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Stand still. Cancels whatever is under way.
    Stop,
    /// Drive with these speeds until the next command.
    Velocity {
        /// Forward speed, m/s.
        forward: f64,
        /// Turn rate, rad/s, counter-clockwise.
        turn: f64,
    },
    /// Drive straight by this distance, m; negative drives back.
    Forward(f64),
    /// Turn on the spot by this angle, rad, counter-clockwise.
    Turn(f64),
    /// Stand still and take one sweep (sensors on a servo; others scan all the time).
    Scan,
}
