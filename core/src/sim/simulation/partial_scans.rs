//! What a robot sees while it moves with a sensor that sweeps only when it stands.
//!
//! Partial scans draw their noise from numbers of their own, so that sweeps and motion are the same
//! to the bit with them and without.

use std::collections::VecDeque;

use rand_chacha::ChaCha8Rng;

use super::{Sensor, Simulation, Span, View, keep_newest};
use crate::robot::{Command, Scan};
use crate::sim::noise::stream;

/// Partial scans that wait to be taken, and where their noise comes from.
#[derive(Clone, Debug)]
pub(super) struct PartialScans {
    rng: ChaCha8Rng,
    waiting: VecDeque<Scan>,
}

impl PartialScans {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            rng: stream(seed, 4),
            waiting: VecDeque::new(),
        }
    }

    pub(super) fn step(&mut self, sensor: &mut Sensor, span: &Span, view: &View) {
        if let Some(scan) = sensor.partial_scan(span, view, &mut self.rng) {
            keep_newest(&mut self.waiting, scan);
        }
    }
}

/// Whether a command makes the robot move: who comes while it turns may stand before it then.
pub(super) fn moves(command: &Command) -> bool {
    match *command {
        Command::Forward(by) | Command::Turn(by) => by != 0.0,
        Command::Velocity { forward, turn } => (forward, turn) != (0.0, 0.0),
        Command::Stop | Command::Scan => false,
    }
}

impl Simulation {
    /// The oldest partial scan that nobody took yet: a few readings of a robot that moves, by a
    /// sensor that sweeps only when it stands. No picture of the room, and nothing to map.
    pub fn take_partial_scan(&mut self) -> Option<Scan> {
        self.partial_scans.waiting.pop_front()
    }
}
