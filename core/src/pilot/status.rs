//! What the pilot is doing, and how its errand ended.

use nalgebra::Point2;

use crate::plan::NoPath;

/// A robot that stands no farther from its goal than this has reached it, m.
const AT_GOAL: f64 = 0.1;

/// What the pilot is to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mode {
    /// Drive as commanded by [`super::Pilot::drive`], in safe mode.
    Manual,
    /// Go to this point of the map, m.
    GoTo(Point2<f64>),
    /// See everything that can be reached.
    Explore,
}

/// What the pilot is doing.
#[derive(Clone, Debug, PartialEq)]
pub enum Status {
    /// Nothing: it stands and waits.
    Idle,
    /// On its way.
    Driving,
    /// Standing to scan: during a sweep, or until the map has settled.
    Scanning,
    /// Standing for a reason that may pass; then it goes on by itself.
    Waiting(Failure),
    /// Done.
    Finished(Finish),
    /// Given up.
    Failed(Failure),
}

impl Status {
    /// Whether the errand is over, successfully or not.
    #[must_use]
    pub fn is_over(&self) -> bool {
        matches!(self, Self::Finished(_) | Self::Failed(_))
    }
}

impl std::fmt::Display for Status {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Idle => f.write_str("idle"),
            Self::Driving => f.write_str("driving"),
            Self::Scanning => f.write_str("looking"),
            Self::Finished(finish) => finish.fmt(f),
            Self::Waiting(failure) | Self::Failed(failure) => failure.fmt(f),
        }
    }
}

/// How an errand ended successfully.
#[derive(Clone, Debug, PartialEq)]
pub enum Finish {
    /// The robot is at the goal, or at the nearest place to it where it fits.
    GoalReached {
        /// Remaining distance to the goal, m.
        off: f64,
    },
    /// No frontier is left that can be reached and promises anything new.
    Explored {
        /// Centres of the frontiers that no way leads to.
        unreached: Vec<Point2<f64>>,
        /// Centres of the frontiers that were still there after scans.
        fruitless: Vec<Point2<f64>>,
        /// Whether it came home.
        homecoming: Homecoming,
    },
}

impl Finish {
    /// Whether everything that was asked is done: the goal itself reached, or everything explored
    /// and the robot home again if that was asked.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        match self {
            Self::GoalReached { off } => *off < AT_GOAL,
            Self::Explored { homecoming, .. } => !matches!(homecoming, Homecoming::Failed(_)),
        }
    }
}

/// What became of the way home after an exploration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Homecoming {
    /// Nobody asked for it: the robot stands where it ended.
    NotAsked,
    /// The robot is where it began.
    Home,
    /// The robot stands on the way, for this reason.
    Failed(Failure),
}

impl std::fmt::Display for Finish {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::GoalReached { .. } if self.is_complete() => f.write_str("goal reached"),
            Self::GoalReached { off } => {
                write!(f, "as near to the goal as the robot fits: {off:.2} m away")
            }
            Self::Explored {
                unreached,
                fruitless,
                homecoming,
            } => {
                f.write_str("explored: ")?;
                if unreached.is_empty() && fruitless.is_empty() {
                    f.write_str("nothing unknown is left within reach")?;
                }
                write_places(f, unreached, "could not be reached")?;
                if !(unreached.is_empty() || fruitless.is_empty()) {
                    f.write_str("; ")?;
                }
                write_places(f, fruitless, "showed nothing new when looked at")?;
                match homecoming {
                    Homecoming::NotAsked => Ok(()),
                    Homecoming::Home => f.write_str("; home again"),
                    Homecoming::Failed(why) => write!(f, "; not home again: {why}"),
                }
            }
        }
    }
}

/// Writes how many places there are, and where the first is; nothing for none.
fn write_places(
    f: &mut std::fmt::Formatter<'_>,
    places: &[Point2<f64>],
    what: &str,
) -> std::fmt::Result {
    let Some(first) = places.first() else {
        return Ok(());
    };
    let (x, y) = (first.x, first.y);
    match places.len() {
        1 => write!(f, "1 unknown place, at ({x:.2}, {y:.2}) m, {what}"),
        n => write!(
            f,
            "{n} unknown places, the first at ({x:.2}, {y:.2}) m, {what}"
        ),
    }
}

/// Why an errand was given up.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Failure {
    /// There is no way.
    #[error(transparent)]
    NoPath(#[from] NoPath),
    /// The sensor has fallen silent, so nothing is known of obstacles. The robot waits for it.
    #[error("no scan for {seconds:.1} s")]
    NoScan {
        /// How old the newest scan may be, s.
        seconds: f64,
    },
    /// The robot no longer knows where it is: the map cannot guide it.
    #[error(
        "lost: for {seconds:.0} s it has known where it is to {sigma:.1} m only, for its sensor shows it nothing that it could find itself by"
    )]
    Lost {
        /// Standard deviation of its position in the worse direction, m.
        sigma: f64,
        /// For how long that was more than [`super::PilotConfig::lost_sigma`], s.
        seconds: f64,
    },
    /// The goal is outside the geofence.
    #[error("the goal at ({:.2}, {:.2}) m lies outside of the geofence", .0.x, .0.y)]
    GoalOutside(Point2<f64>),
    /// The robot is outside the geofence.
    #[error("the robot is outside of the geofence, at ({:.2}, {:.2}) m: drive it back by hand", .0.x, .0.y)]
    Outside(Point2<f64>),
    /// The robot does not move although it should, and backing off did not help.
    #[error("stuck at ({:.2}, {:.2}) m: backing off {attempts} times did not help", .at.x, .at.y)]
    Stuck {
        /// Where, m.
        at: Point2<f64>,
        /// How often it backed off.
        attempts: usize,
    },
}
