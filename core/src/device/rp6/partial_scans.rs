//! Partial scans of an RP6 that moves: its servo turns to and fro meanwhile.
//!
//! 1. While the tracks run on an order, the servo gets one sweep of a single position after another
//!    ([`RangerModel::PARTIAL_SCAN`]), each when telemetry says that it rests. All rangers are read
//!    there; their readings are a partial scan.
//! 2. From the first of them until a whole sweep is acknowledged, all readings of the rangers
//!    belong to partial scans.
//!
//! The simulated rangers point to the same positions.

use crate::robot::{RangerModel, Stamp};
use crate::wire::rp6::{Command, Telemetry};

use super::Rp6;

/// If it does not show in the telemetry within this time after its order, it is ordered again, s.
const UNHEARD: f64 = 0.3;

/// How far the partial scans have come.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PartialScans {
    /// The robot was commanded to move.
    pub(super) moves: bool,
    /// Index into [`RangerModel::PARTIAL_SCAN`].
    number: usize,
    /// When the one was ordered that has not yet shown in the telemetry.
    ordered: Option<Stamp>,
}

impl PartialScans {
    /// The next one to order, if it is time.
    fn next(&mut self, telemetry: &Telemetry, now: Stamp) -> Option<Command> {
        if telemetry.state.sweeping() {
            self.ordered = None;
            return None;
        }
        let waits = self.ordered.is_some_and(|at| now.since(at) < UNHEARD);
        if !self.moves || !telemetry.state.moving() || waits {
            return None;
        }
        self.ordered = Some(now);
        let servo = RangerModel::PARTIAL_SCAN[self.number % RangerModel::PARTIAL_SCAN.len()];
        self.number = (self.number + 1) % RangerModel::PARTIAL_SCAN.len();
        let mrad = (1e3 * servo).round() as i16;
        Some(Command::Sweep {
            from_mrad: mrad,
            to_mrad: mrad,
            step_mrad: 1,
        })
    }
}

impl Rp6 {
    /// Orders the next partial scan of a robot that moves.
    pub(super) fn continue_partial_scan(&mut self, telemetry: &Telemetry, now: Stamp) {
        let Some(robot) = self.robot.as_mut() else {
            return;
        };
        let Some(sweeps) = &mut robot.sweeps else {
            return;
        };
        let Some(command) = robot.partial_scans.next(telemetry, now) else {
            return;
        };
        sweeps.begin_partial();
        // Not `give`: nothing waits for its acknowledgement.
        if let Err(error) = self.link.command(command, now) {
            let text = format!("{command:?} not taken: {error}");
            self.report.note(super::Weight::Detail, text);
        }
    }
}
