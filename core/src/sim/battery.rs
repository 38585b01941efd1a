//! The battery: volts that sag with the load and fall with time.
//!
//! In: how fast the tracks run in each step. Out: volts, as the robot's converter counts them.
//!
//! 1. The motors draw a current for turning at all and one that grows with their speed and with its change; the
//!    electronics draw theirs always.
//! 2. Charge is current times time; the open-circuit voltage of a cell follows from the charge that is left.
//! 3. The terminals show less by current times inner resistance.
//!
//! Source: the RP6 manual (six NiMH cells, 2.5 Ah, analogue reading of the battery); discharge curve rounded from cell data
//! sheets (Panasonic HHR): quick from 1.40 V, flat near 1.24 V, and a cliff below a tenth of the charge.

use crate::robot::{Adc, Tracks};

/// Figures of a battery and of what it feeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatteryModel {
    /// Cells in series. Default 6.
    pub cells: f64,
    /// Charge of a full battery, A s. Default 9000: 2.5 Ah.
    pub capacity: f64,
    /// Inner resistance of all cells and leads, Ω. Default 0.25.
    pub resistance: f64,
    /// What the electronics draw, A. Default 0.25.
    pub idle: f64,
    /// What a motor draws for each m/s of its track, A s/m. Default 2.
    pub per_speed: f64,
    /// What a motor draws for each m/s² of its track, A s²/m. Default 0.8.
    pub per_acceleration: f64,
    /// What the volts are counted by. Default: 10 bits over 15 V, behind the robot's divider.
    pub adc: Adc,
}

impl Default for BatteryModel {
    fn default() -> Self {
        Self {
            cells: 6.0,
            capacity: 9000.0,
            resistance: 0.25,
            idle: 0.25,
            per_speed: 2.0,
            per_acceleration: 0.8,
            adc: Adc {
                bits: 10,
                reference: 15.0,
            },
        }
    }
}

/// Charge left (as a part) and open-circuit volts of a cell, from full to empty.
const CELL: [(f64, f64); 6] = [
    (1.0, 1.40),
    (0.9, 1.30),
    (0.5, 1.24),
    (0.1, 1.18),
    (0.03, 1.10),
    (0.0, 0.90),
];

/// A battery at work.
#[derive(Clone, Debug)]
pub(super) struct Battery {
    model: BatteryModel,
    /// What was drawn since it was full, A s.
    drawn: f64,
    /// Current of the last step, A.
    current: f64,
    /// Speeds of the tracks in the last step, m/s.
    speeds: Tracks,
}

impl Battery {
    pub(super) fn new(model: BatteryModel) -> Self {
        Self {
            model,
            drawn: 0.0,
            current: model.idle,
            speeds: Tracks::default(),
        }
    }

    /// Takes what the tracks ran (m) in `dt` seconds.
    pub(super) fn step(&mut self, dt: f64, run: &Tracks) {
        let speeds = Tracks {
            left: run.left / dt,
            right: run.right / dt,
        };
        let of_motor = |before: f64, now: f64| {
            // Braking feeds nothing back.
            let quicker = (now.abs() - before.abs()).max(0.0) / dt;
            self.model.per_speed * now.abs() + self.model.per_acceleration * quicker
        };
        let left = of_motor(self.speeds.left, speeds.left);
        let right = of_motor(self.speeds.right, speeds.right);
        self.current = self.model.idle + left + right;
        self.drawn += self.current * dt;
        self.speeds = speeds;
    }

    /// Volts at the terminals, as the converter counts them.
    pub(super) fn volts(&self) -> f64 {
        let left = 1.0 - self.drawn / self.model.capacity;
        let open = self.model.cells * cell_volts(left);
        let sagged = open - self.model.resistance * self.current;
        self.model.adc.volts(self.model.adc.counts(sagged))
    }
}

/// Open-circuit volts of a cell with this part of its charge left.
fn cell_volts(left: f64) -> f64 {
    let stretches = CELL.iter().zip(CELL.iter().skip(1));
    for (full, empty) in stretches {
        if left >= empty.0 {
            let part = ((left - empty.0) / (full.0 - empty.0)).min(1.0);
            return empty.1 + part * (full.1 - empty.1);
        }
    }
    CELL.last().map_or(0.0, |c| c.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 0.005;

    fn after(seconds: f64, speed: f64) -> Battery {
        let mut battery = Battery::new(BatteryModel::default());
        let run = Tracks {
            left: speed * DT,
            right: -speed * DT,
        };
        for _ in 0..(seconds / DT).round() as usize {
            battery.step(DT, &run);
        }
        battery
    }

    #[test]
    fn volts_sag_with_the_load_by_current_times_resistance() {
        // 0.25 A against 0.25 + 2 · 2 · 0.3 A: 1.2 A and 0.25 Ω more.
        let sag = after(1.0, 0.0).volts() - after(1.0, 0.3).volts();
        assert!((sag - 0.30).abs() < 0.03, "{sag}");
        // Gathering speed costs more than keeping it.
        let mut battery = after(1.0, 0.0);
        let run = |speed: f64| Tracks {
            left: speed * DT,
            right: speed * DT,
        };
        battery.step(DT, &run(0.003));
        let quickening = battery.current;
        battery.step(DT, &run(0.003));
        assert!((quickening - battery.current - 2.0 * 0.8 * 0.6).abs() < 1e-9);
    }

    #[test]
    fn volts_fall_with_time_until_the_battery_is_empty() {
        let volts: Vec<f64> = (0..8)
            .map(|i| after(1200.0 * f64::from(i), 0.3).volts())
            .collect();
        assert!(volts.windows(2).all(|w| w[1] <= w[0]), "{volts:?}");
        // 9000 A s at 1.45 A last 6207 s; at the cliff a cell has 0.9 V.
        let last = after(6300.0, 0.3).volts();
        assert!((last - (6.0 * 0.9 - 0.25 * 1.45)).abs() < 0.02, "{last}");
        assert!((cell_volts(0.7) - 1.27).abs() < 1e-12);
        assert_eq!((cell_volts(2.0), cell_volts(-1.0)), (1.40, 0.90));
    }
}
