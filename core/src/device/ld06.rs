//! An LDROBOT LD06 or LD19: it only sends, so it needs no start sequence.
//!
//! 1. The last reading of a packet counts as taken when the packet arrived. Each one before it was
//!    taken earlier by the time that its spacing takes at the speed given in the packet.
//! 2. Silence, bytes that are no packets, and a head that stands still (speed 0, or no whole turn)
//!    are faults. They end by themselves with the next whole turn.

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
    /// No byte arrived.
    #[error(
        "the LD06 is silent: no power, or its data line (TX) is loose; check the plug and the 5 V supply"
    )]
    Silent,
    /// Bytes arrived, but no packet.
    #[error(
        "{bytes} bytes came, but no packet of an LD06: wrong baud rate or another device; it speaks at {} baud",
        Ld06::BAUD_RATE
    )]
    NotUnderstood {
        /// Number of bytes that arrived.
        bytes: u64,
    },
    /// Packets arrive, but no whole turn.
    #[error(
        "the LD06 sends packets but no whole turn: its motor stands still; check its PWM line and that the head is free"
    )]
    DoesNotTurn,
}

/// What is specific to an LD06. Its motor runs as long as it has power.
#[derive(Debug, Default)]
pub struct Ld06 {
    decoder: Decoder,
    /// The byte counts when waiting for a whole turn began.
    before: Tally,
}

impl Ld06 {
    /// Says why no whole turn arrives.
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

    /// LD06 and LD19: 0.02 to 12 m, σ 10 mm near, at most ±45 mm (development manual v2.3).
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

/// Seconds from one reading to the next; 0 if the head stands still.
fn interval(packet: &Packet) -> f64 {
    if packet.speed == 0 {
        0.0
    } else {
        packet.spacing() / f64::from(packet.speed).to_radians()
    }
}

/// Seconds that the readings of a packet take.
fn duration(packet: &Packet) -> f64 {
    interval(packet) * READINGS as f64
}

#[cfg(test)]
mod tests;
