//! The battery: its voltage sags with the load and falls with time.
//!
//! In: the power that the motors take in each step. Out: volts, as the robot's converter reads
//! them.
//!
//! 1. The motors are chopped: a motor at voltage u is connected to the battery's voltage U for the
//!    part u/U of the time, and its current i flows through the battery for that part. A motor that
//!    pushes against a wall induces no voltage against its current: it draws the most. A braking
//!    motor feeds nothing back. The electronics always draw their current.
//! 2. Charge is current times time; the open-circuit voltage of a cell follows from the charge that
//!    remains.
//! 3. The voltage at the terminals is lower by current times internal resistance.
//!
//! Source: the RP6 manual (six NiMH cells, 2.5 Ah, analogue reading of the battery); discharge
//! curve rounded from cell data sheets (Panasonic HHR): quick from 1.40 V, flat near 1.24 V, and a
//! cliff below a tenth of the charge.

use crate::bounds::config;
use crate::robot::Adc;

config! {
    /// Figures of a battery and of what it feeds.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct BatteryModel {
        /// Cells in series. Default 6.
        pub cells: f64 = 6.0,
        /// Charge of a full battery, A s. Default 9000: 2.5 Ah.
        pub capacity: f64 = 9000.0,
        /// Inner resistance of all cells and leads, Ω. Default 0.25.
        pub resistance: f64 = 0.25,
        /// What the electronics draw, A. Default 0.25.
        pub idle: f64 = 0.25,
        /// What the volts are counted by. Default: 10 bits over 15 V, behind the robot's divider.
        pub adc: Adc = Adc {
            bits: 10,
            reference: 15.0,
        },
    }
}

impl BatteryModel {
    /// Enough cells for motors of `volts`: 1.2 V each. The default is for 7.2 V; resistance and
    /// converter grow with the number of cells.
    #[must_use]
    pub fn for_motors(volts: f64) -> Self {
        let default = Self::default();
        let cells = volts / NOMINAL;
        let part = cells / default.cells;
        Self {
            cells,
            resistance: part * default.resistance,
            adc: Adc {
                reference: part * default.adc.reference,
                ..default.adc
            },
            ..default
        }
    }
}

/// Nominal voltage of a cell, V.
const NOMINAL: f64 = 1.2;

/// Charge left (as a part) and open-circuit volts of a cell, from full to empty.
const CELL: [(f64, f64); 6] = [
    (1.0, 1.40),
    (0.9, 1.30),
    (0.5, 1.24),
    (0.1, 1.18),
    (0.03, 1.10),
    (0.0, 0.90),
];

/// A battery in use.
#[derive(Clone, Debug)]
pub(super) struct Battery {
    model: BatteryModel,
    /// Charge drawn since it was full, A s.
    drawn: f64,
    /// Current of the last step, A.
    current: f64,
}

impl Battery {
    pub(super) fn new(model: BatteryModel) -> Self {
        Self {
            model,
            drawn: 0.0,
            current: model.idle,
        }
    }

    /// Draws what the motors took in `dt` seconds, W on average.
    pub(super) fn step(&mut self, dt: f64, watts: f64) {
        // The voltage of the previous step: it hardly changes in one step.
        let volts = self.terminals().max(LEAST_VOLTS);
        self.current = self.model.idle + watts.max(0.0) / volts;
        self.drawn += self.current * dt;
    }

    fn terminals(&self) -> f64 {
        let left = 1.0 - self.drawn / self.model.capacity;
        self.model.cells * cell_volts(left) - self.model.resistance * self.current
    }

    /// Volts at the terminals, as the converter reads them.
    pub(super) fn volts(&self) -> f64 {
        let sagged = self.terminals();
        self.model.adc.volts(self.model.adc.counts(sagged))
    }
}

/// Below this voltage the current no longer rises to keep the power, V: electronics switch off
/// sooner.
const LEAST_VOLTS: f64 = 1.0;

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

    fn after(seconds: f64, watts: f64) -> Battery {
        let mut battery = Battery::new(BatteryModel::default());
        for _ in 0..(seconds / DT).round() as usize {
            battery.step(DT, watts);
        }
        battery
    }

    #[test]
    fn volts_sag_with_the_load_by_current_times_resistance() {
        // 8.4 V open: at 9.6 W the current i solves i = 0.25 + 9.6 / (8.4 - 0.25 i), 1.44 A.
        let loaded = after(0.5, 9.6);
        assert!((loaded.current - 1.44).abs() < 0.01, "{}", loaded.current);
        let sag = after(0.5, 0.0).volts() - loaded.volts();
        assert!((sag - 0.25 * 1.19).abs() < 0.02, "{sag}");
        // A braking motor feeds nothing back.
        assert_eq!(after(0.5, -3.0).current, 0.25);
    }

    #[test]
    fn volts_fall_with_time_until_the_battery_is_empty() {
        let volts: Vec<f64> = (0..8)
            .map(|i| after(1200.0 * f64::from(i), 8.0).volts())
            .collect();
        assert!(volts.windows(2).all(|w| w[1] <= w[0]), "{volts:?}");
        // 2.5 A h at 0.25 A last ten hours.
        assert!(after(0.9 * 36_000.0, 0.0).volts() > 7.0);
        assert!(after(1.01 * 36_000.0, 0.0).volts() < 5.5);
        assert!((cell_volts(0.7) - 1.27).abs() < 1e-12);
        assert_eq!((cell_volts(2.0), cell_volts(-1.0)), (1.40, 0.90));
    }

    #[test]
    fn motors_of_12_volts_get_ten_cells() {
        assert_eq!(BatteryModel::for_motors(7.2).cells.round(), 6.0);
        let model = BatteryModel::for_motors(12.0);
        assert!((model.cells - 10.0).abs() < 1e-12);
        let volts = Battery::new(model).volts();
        assert!((13.8..14.0).contains(&volts), "{volts}");
    }
}
