//! What a robot can be commanded to do.

/// A command to the robot; simulated and real robots take the same commands.
///
/// Source: TDK 2016 §1.2 (`Forward`, `Turn`, `Scan`), and `Velocity` for driving by hand and by the
/// pilot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Stand still. Cancels whatever is in progress.
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

impl Command {
    /// Whether it takes time and then ends by itself.
    #[must_use]
    pub fn is_manoeuvre(&self) -> bool {
        matches!(self, Self::Forward(_) | Self::Turn(_) | Self::Scan)
    }

    /// Whether every figure is a finite number.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        match self {
            Self::Stop | Self::Scan => true,
            Self::Velocity { forward, turn } => forward.is_finite() && turn.is_finite(),
            Self::Forward(by) | Self::Turn(by) => by.is_finite(),
        }
    }
}
