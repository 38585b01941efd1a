//! What a robot sees while it moves, with a sensor that sweeps only when it stands.
//!
//! Partial scans draw their noise from a random stream of their own, so sweeps and motion are the
//! same to the bit with and without them.

use std::collections::VecDeque;

use rand_chacha::ChaCha8Rng;

use super::{Sensor, Simulation, Span, View, keep_newest};
use crate::robot::{Command, Scan};
use crate::sim::noise::stream;

/// Partial scans that wait to be taken, and the source of their noise.
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

/// Whether a command makes the robot move. A turn counts: somebody who comes meanwhile may stand in
/// front of it afterwards.
pub(super) fn moves(command: &Command) -> bool {
    match *command {
        Command::Forward(by) | Command::Turn(by) => by != 0.0,
        Command::Velocity { forward, turn } => (forward, turn) != (0.0, 0.0),
        Command::Stop | Command::Scan => false,
    }
}

impl Simulation {
    /// The oldest partial scan that was not taken yet: a few readings of a moving robot, by a
    /// sensor that sweeps only when it stands. It is no picture of the room, and nothing to map.
    pub fn take_partial_scan(&mut self) -> Option<Scan> {
        self.partial_scans.waiting.pop_front()
    }
}
