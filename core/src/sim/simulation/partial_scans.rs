//! What a robot sees while it moves with a sensor that sweeps only when it stands.
//!
//! Partial scans draw their noise from numbers of their own, so that sweeps and motion are the same
//! to the bit with them and without.

use std::collections::VecDeque;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::{MOST_WAITING, Sensor, Simulation, Span, View};
use crate::robot::{Command, Scan};

/// Partial scans that wait to be taken, and where their noise comes from.
#[derive(Clone, Debug)]
pub(super) struct PartialScans {
    rng: ChaCha8Rng,
    waiting: VecDeque<Scan>,
}

impl PartialScans {
    pub(super) fn new(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(4);
        Self {
            rng,
            waiting: VecDeque::new(),
        }
    }

    pub(super) fn step(&mut self, sensor: &mut Sensor, span: &Span, view: &View) {
        let Some(scan) = sensor.partial_scan(span, view, &mut self.rng) else {
            return;
        };
        if self.waiting.len() == MOST_WAITING {
            self.waiting.pop_front();
        }
        self.waiting.push_back(scan);
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
