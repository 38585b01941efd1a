//! An LD06 that sees a world of `core::sim`: packets out, nothing in.

use std::f64::consts::TAU;

use slamlab_core::wire::ld06::{Packet, READINGS, Reading};

use super::{Device, View};

/// Revolutions per second.
const TURNS: u64 = 10;
/// Readings per revolution: 4500 a second.
const READINGS_OF_A_TURN: u64 = 450;

/// The simulated lidar.
#[derive(Clone, Debug)]
pub struct Ld06 {
    /// What it sees.
    pub view: View,
    /// Whether its head is blocked.
    pub is_blocked: bool,
    readings: u64,
    pending: f64,
}

impl Ld06 {
    /// A healthy one.
    #[must_use]
    pub fn new(view: View) -> Self {
        Self {
            view,
            is_blocked: false,
            readings: 0,
            pending: 0.0,
        }
    }

    /// Angle of a reading in 0.01°, clockwise.
    fn angle(&self, reading: u64) -> u16 {
        let reading = if self.is_blocked {
            40
        } else {
            reading % READINGS_OF_A_TURN
        };
        (reading * 36_000 / READINGS_OF_A_TURN) as u16
    }

    fn packet(&self) -> Packet {
        let at = |k: usize| self.readings + k as u64;
        Packet {
            speed: if self.is_blocked {
                0
            } else {
                (360 * TURNS) as u16
            },
            start_angle: self.angle(at(0)),
            readings: std::array::from_fn(|k| {
                let angle = f64::from(self.angle(at(k))) / 36_000.0 * TAU;
                let range = self.view.range(-angle);
                Reading {
                    distance: (range.unwrap_or(0.0) * 1e3).round() as u16,
                    intensity: if range.is_some() { 200 } else { 0 },
                }
            }),
            end_angle: self.angle(at(READINGS - 1)),
            millis: (self.readings * 1000 / (TURNS * READINGS_OF_A_TURN) % 30_000) as u16,
        }
    }
}

impl Device for Ld06 {
    fn baud_rate(&self) -> u32 {
        230_400
    }

    fn power_on(&mut self) {
        self.readings = 0;
        self.pending = 0.0;
    }

    fn receive(&mut self, _: &[u8]) {}

    fn advance(&mut self, seconds: f64) -> Vec<u8> {
        self.pending += seconds;
        let each = READINGS as f64 / (TURNS * READINGS_OF_A_TURN) as f64;
        let mut said = vec![];
        while self.pending >= each {
            self.pending -= each;
            said.extend(self.packet().encode());
            self.readings += READINGS as u64;
        }
        said
    }
}
