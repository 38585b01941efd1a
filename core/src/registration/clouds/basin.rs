//! From which starts a method finds the motion between two clouds: its basin of convergence.
//!
//! In: two clouds, the true pose, a method, and how far and how finely to look. Out: for each cell
//! of a map of starts, where the method ended and what verdict it gave.
//!
//! One call of [`Basin::step`] registers once, so the caller can show progress and stop at any
//! time. Cells come spread over the whole map, not row by row, so after a tenth of the time the
//! picture already looks like the whole.

use super::{Cloud, CloudMethod, JudgeConfig, register_clouds};
use crate::bounds::config;
use crate::geom::{Length, Pose2, unit_vector};
use crate::registration::Verdict;

/// What the axes of a map of starts are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BasinAxes {
    /// A shift in this direction of the fixed frame, rad, to the right; a turn, upwards.
    ShiftTurn {
        /// The direction.
        direction: f64,
    },
    /// x to the right and y upwards, in the fixed frame.
    Place,
}

config! {
    /// How a map of starts is laid out about the pose that is right.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct BasinConfig {
        /// Default: along x, and turned.
        pub axes: BasinAxes = BasinAxes::ShiftTurn { direction: 0.0 },
        /// The farthest start to either side, m. Default 2.
        pub shift: f64 = 2.0,
        /// The farthest turn to either side, rad. Default 1.6: a quarter of a turn.
        pub turn: f64 = 1.6,
        /// Cells along each side. Default 25; odd numbers have the right pose in the middle.
        pub cells: usize = 25,
        /// What ends nearer than this to the right pose has found it, m. Default 0.05.
        pub near_shift: f64 = 0.05,
        /// ... and is turned by less than this, rad. Default 0.0175: 1°.
        pub near_turn: f64 = 0.0175,
    }
}

/// How a registration from one start ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BasinOutcome {
    /// It reached the true pose.
    Found,
    /// It ended elsewhere, and does not claim to have converged.
    LostAndSaysSo,
    /// It ended elsewhere and claims to have converged.
    WronglySure,
}

/// One cell of a map of starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BasinCell {
    /// Its index: row by row from the lower left.
    pub index: usize,
    /// How the registration ended.
    pub outcome: BasinOutcome,
    /// How far from the true pose it ended, m.
    pub error: f64,
    /// Iterations taken.
    pub iterations: usize,
}

/// A map of starts that is being filled.
#[derive(Clone, Debug)]
pub struct Basin {
    moving: Cloud,
    fixed: Cloud,
    right: Pose2,
    method: CloudMethod,
    judge: JudgeConfig,
    config: BasinConfig,
    done: usize,
}

/// The most cells along a side.
const MOST_CELLS: usize = 201;

impl Basin {
    /// An empty map about `right`, the true `fixed_from_moving`.
    #[must_use]
    pub fn new(
        [moving, fixed]: [Cloud; 2],
        right: Pose2,
        method: CloudMethod,
        config: BasinConfig,
    ) -> Self {
        Self {
            moving,
            fixed,
            right,
            method,
            judge: JudgeConfig::default(),
            config: BasinConfig {
                cells: config.cells.clamp(1, MOST_CELLS),
                ..config
            },
            done: 0,
        }
    }

    /// Cells along each side.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.config.cells
    }

    /// The part that is done, 0 to 1.
    #[must_use]
    pub fn progress(&self) -> f64 {
        self.done as f64 / self.count() as f64
    }

    /// The next cell; `None` when all are done.
    pub fn step(&mut self) -> Option<BasinCell> {
        let index = self.next_index()?;
        self.done += 1;
        let start = self.start(index);
        let found = register_clouds(&self.moving, &self.fixed, &start, &self.method, &self.judge);
        let off = found.estimate.pose.minus(&self.right);
        // Along a corridor, every pose is equally right.
        let way = match found.verdict {
            Verdict::Degenerate { direction } => off.xy() - direction * direction.dot(&off.xy()),
            _ => off.xy(),
        };
        let error = way.length();
        let is_found = error < self.config.near_shift && off.z.abs() < self.config.near_turn;
        Some(BasinCell {
            index,
            outcome: match (is_found, found.verdict) {
                (true, _) => BasinOutcome::Found,
                (false, Verdict::Converged) => BasinOutcome::WronglySure,
                (false, _) => BasinOutcome::LostAndSaysSo,
            },
            error,
            iterations: found.iterations,
        })
    }

    /// The start of a cell.
    #[must_use]
    pub fn start(&self, index: usize) -> Pose2 {
        let cells = self.config.cells;
        let along = |at: usize| match cells {
            1 => 0.0,
            _ => 2.0 * at as f64 / (cells - 1) as f64 - 1.0,
        };
        let (right, up) = (along(index % cells), along(index / cells));
        let by = match self.config.axes {
            BasinAxes::ShiftTurn { direction } => {
                let way = unit_vector(direction) * (right * self.config.shift);
                way.push(up * self.config.turn)
            }
            BasinAxes::Place => {
                let way = nalgebra::Vector2::new(right, up) * self.config.shift;
                way.push(0.0)
            }
        };
        self.right.plus(&by)
    }

    fn count(&self) -> usize {
        self.config.cells * self.config.cells
    }

    /// The next index in steps that spread over rows and columns alike, by Roberts' (2018) R2
    /// sequence on a grid; the step is raised to the next number that leaves no cell out.
    fn next_index(&self) -> Option<usize> {
        const UP: f64 = 0.569_840;
        const RIGHT: f64 = 0.754_878;
        let (cells, count) = (self.config.cells, self.count());
        if self.done >= count {
            return None;
        }
        let part = |part: f64| (part * cells as f64) as usize;
        let from = (part(UP) * cells + part(RIGHT)).max(1);
        let stride = (from..).find(|stride| gcd(*stride, count) == 1)?;
        Some((self.done * stride) % count)
    }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}
