//! An LDROBOT LD06 or LD19: it only speaks, so there is nothing to bring up.
//!
//! 1. A packet's last reading was taken when the packet came; those before it each as much earlier
//!    as its spacing takes at the speed that it tells.
//! 2. Silence, bytes that are no packets, and a head that stands still (speed 0, or no whole turn)
//!    are faults; they end by themselves with the next whole turn.

use crate::device::lidar::revolution::Figures;
use crate::device::lidar::{LidarProtocol, Output};
use crate::robot::Stamp;
use crate::wire::Tally;
use crate::wire::ld06::{Decoder, Packet, READINGS};
use crate::wire::message::DeviceState;

/// Why the sensor does not work.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Ld06Fault {
    /// Not a byte came.
    #[error(
        "the LD06 is silent: no power, or its data line (TX) is loose; check the plug and the 5 V supply"
    )]
    Silent,
    /// Bytes came, but no packet.
    #[error(
        "{bytes} bytes came, but no packet of an LD06: wrong baud rate or another device; it speaks at {} baud",
        Ld06::BAUD_RATE
    )]
    NotUnderstood {
        /// How many bytes came.
        bytes: u64,
    },
    /// Packets come, but no whole turn.
    #[error(
        "the LD06 sends packets but no whole turn: its motor stands still; check its PWM line and that the head is free"
    )]
    DoesNotTurn,
}

/// What is peculiar to an LD06. Its motor runs while it has power.
#[derive(Debug, Default)]
pub struct Ld06 {
    decoder: Decoder,
    /// What had come when a whole turn was begun to be waited for.
    before: Tally,
}

impl Ld06 {
    /// Tells in which way it does not turn.
    fn fault(&self, is_silent: bool) -> Ld06Fault {
        let (tally, before) = (self.decoder.tally(), self.before);
        if is_silent {
            Ld06Fault::Silent
        } else if tally.frames > before.frames {
            Ld06Fault::DoesNotTurn
        } else {
            let bytes = tally.bytes - before.bytes;
            Ld06Fault::NotUnderstood { bytes }
        }
    }
}

impl LidarProtocol for Ld06 {
    const BAUD_RATE: u32 = 230_400;

    /// LD06 and LD19: 0.02 to 12 m, σ 10 mm near, ±45 mm at most (development manual v2.3).
    const FIGURES: Figures = Figures {
        min_range: 0.02,
        max_range: 12.0,
        sigma: 0.01,
        sigma_per_metre: 0.003,
    };

    fn opened(&mut self, _: &mut Output, _: Stamp) {
        *self = Self::default();
    }

    fn receive(&mut self, bytes: &[u8], output: &mut Output, now: Stamp) {
        if !bytes.is_empty() {
            output.heard(now);
        }
        self.decoder.extend(bytes);
        let packets: Vec<Packet> = self.decoder.by_ref().collect();
        if !packets.is_empty() && output.state() == DeviceState::Waiting {
            output.report.model = "LD06 or LD19".into();
            output.enter(DeviceState::Connected);
        }
        let mut end = now.seconds() - packets.iter().map(duration).sum::<f64>();
        for packet in &packets {
            end += duration(packet);
            let readings = packet
                .polar()
                .map(|(angle, range, quality)| (angle, range, Some(quality)));
            if output.take(readings, interval(packet), end, now) {
                self.before = self.decoder.tally();
            }
        }
    }

    fn tick(&mut self, output: &mut Output, now: Stamp) {
        if output.does_not_turn(now) {
            output.fail(&self.fault(output.is_silent(now)));
            output.watch(now);
            self.before = self.decoder.tally();
        }
    }

    fn tally(&self) -> Tally {
        self.decoder.tally()
    }
}

/// Seconds from one reading to the next; 0 where the head stands still.
fn interval(packet: &Packet) -> f64 {
    if packet.speed == 0 {
        0.0
    } else {
        packet.spacing() / f64::from(packet.speed).to_radians()
    }
}

/// Seconds of a packet's readings.
fn duration(packet: &Packet) -> f64 {
    interval(packet) * READINGS as f64
}

#[cfg(test)]
mod tests;
