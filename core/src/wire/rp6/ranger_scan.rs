//! From single readings of the rangers to a scan.
//!
//! In: [`Ranger`] readings as they arrive. Out: a [`Scan`] for each movement of the servo, a sweep
//! or a partial scan.
//!
//! 1. Counts become volts, and volts a range with its σ ([`RangerInverse`]), as for the simulated
//!    rangers.
//! 2. The bearing is the servo's angle plus the ranger's own. Readings are passed on in the order
//!    of their bearings, with `sweep` 0, because the robot stands while it sweeps.
//!
//! A scan ends with the first reading of the next, or when its owner ends it: telemetry tells when
//! the servo rests.

use super::{Hello, Ranger};
use crate::geom::wrap;
use crate::robot::{CharacteristicError, RangerInverse, RangerModel, Scan, Stamp};

/// Assembles readings into scans.
#[derive(Clone, Debug)]
pub struct RangerScans {
    model: RangerModel,
    inverse: RangerInverse,
    /// Directions of the rangers on the servo, rad.
    mounts: Vec<f64>,
    sweep: u8,
    /// (bearing, range, σ) so far.
    readings: Vec<(f64, f32, f32)>,
    /// When the last reading was taken, ms of the robot.
    last_ms: u32,
    /// Number of a sweep of which no scan can be made.
    spoilt: Option<u8>,
}

impl RangerScans {
    /// For the rangers that the robot reports.
    ///
    /// # Errors    [`CharacteristicError`] for a calibration that does not determine a
    /// characteristic.
    pub fn new(hello: &Hello, model: RangerModel) -> Result<Self, CharacteristicError> {
        let mount = |mrad: &i16| 1e-3 * f64::from(*mrad);
        Ok(Self {
            inverse: model.inverse()?,
            model,
            mounts: hello.ranger_angles_mrad.iter().map(mount).collect(),
            sweep: 0,
            readings: Vec::new(),
            last_ms: 0,
            spoilt: None,
        })
    }

    /// Takes a reading, unless the robot did not report its ranger; returns the previous sweep if
    /// this reading begins another.
    pub fn take(&mut self, reading: &Ranger) -> Option<Scan> {
        let mount = self.mounts.get(usize::from(reading.index))?;
        if self.spoilt == Some(reading.sweep) {
            return None;
        }
        self.spoilt = None;
        let bearing = wrap(reading.servo_angle() + mount);
        let complete = match reading.sweep == self.sweep {
            true => None,
            false => self.finish(),
        };
        let (range, sigma) = self.inverse.read(reading.volts());
        self.readings.push((bearing, range, sigma));
        self.sweep = reading.sweep;
        self.last_ms = reading.time_ms;
        complete
    }

    /// The robot moved: neither earlier nor later readings of this sweep count.
    pub fn spoil(&mut self) {
        if !self.readings.is_empty() {
            self.readings.clear();
            self.spoilt = Some(self.sweep);
        }
    }

    /// The sweep is over: returns its scan, if there is any reading. Its stamp is that of the last
    /// reading, in the robot's own time, as in [`super::Odometer`] until the robot's clock wraps,
    /// after 49 days.
    pub fn finish(&mut self) -> Option<Scan> {
        let mut readings = std::mem::take(&mut self.readings);
        if readings.is_empty() {
            return None;
        }
        readings.sort_by(|a, b| a.0.total_cmp(&b.0));
        Some(Scan {
            stamp: Stamp(1_000 * u64::from(self.last_ms)),
            robot_from_sensor: self.model.robot_from_sensor,
            bearings: readings.iter().map(|r| r.0).collect(),
            ranges: readings.iter().map(|r| r.1).collect(),
            sigmas: readings.iter().map(|r| r.2).collect(),
            bearing_sigma: self.model.bearing_sigma,
            max_range: self.model.max_range,
            sweep: 0.0,
            qualities: vec![],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{Adc, Sharp};
    use crate::wire::rp6::fixture::hello;

    fn reader() -> RangerScans {
        RangerScans::new(&hello(1), RangerModel::long()).unwrap()
    }

    fn reading(sweep: u8, servo_mrad: i16, index: u8, range: f64) -> Ranger {
        Ranger {
            time_ms: 5_000 + u32::from(index),
            servo_mrad,
            index,
            adc: Adc::rp6().counts(Sharp::Long.volts_at(range)) as u16,
            sweep,
        }
    }

    #[test]
    fn a_sweep_becomes_a_scan_by_bearing_with_the_ranges_that_were_there() {
        let mut reader = reader();
        let ranges = [0.3, 0.6, 0.9, 1.3];
        for (index, range) in (0..4).zip(ranges) {
            for servo in [100, 0, -100] {
                assert_eq!(reader.take(&reading(1, servo, index, range)), None);
            }
        }
        let scan = reader
            .take(&reading(2, 0, 0, 0.5))
            .expect("a second sweep begins");
        assert_eq!(scan.validate(), Ok(()));
        assert_eq!((scan.len(), scan.stamp), (12, Stamp(5_003_000)));
        assert!(scan.bearings.is_sorted());
        // -1.671, -1.571, -1.471: right; around 0: ahead; and so on; back appears at both ends of
        // the circle.
        let seen = |bearing: f64, range: f64| {
            let at = scan
                .bearings
                .iter()
                .position(|b| (b - bearing).abs() < 1e-3);
            let at = at.unwrap_or_else(|| panic!("nothing at {bearing}: {:?}", scan.bearings));
            let error = f64::from(scan.ranges[at]) - range;
            assert!(
                error.abs() < 3.0 * f64::from(scan.sigmas[at]),
                "{bearing}: {error}"
            );
        };
        seen(-1.571, 1.3);
        seen(0.1, 0.3);
        seen(1.471, 0.6);
        seen(3.042, 0.9);
        seen(wrap(3.242), 0.9);
        // σ grows with the range.
        let sigma_at = |bearing: f64| {
            let at = scan
                .bearings
                .iter()
                .position(|b| (b - bearing).abs() < 1e-3)
                .unwrap();
            scan.sigmas[at]
        };
        assert!(sigma_at(-1.571) > 1.5 * sigma_at(0.0));
    }

    #[test]
    fn a_sweep_on_the_move_is_no_scan_and_the_next_one_is() {
        let mut reader = reader();
        let _ = reader.take(&reading(1, 100, 0, 0.5));
        reader.spoil();
        assert_eq!(reader.take(&reading(1, 0, 0, 0.5)), None);
        assert_eq!(reader.finish(), None);
        let _ = reader.take(&reading(2, 100, 0, 0.5));
        assert_eq!(reader.finish().map(|scan| scan.len()), Some(1));
    }

    #[test]
    fn beyond_its_reach_a_ranger_sees_nothing_and_an_unknown_one_is_left_out() {
        let mut reader = reader();
        assert_eq!(reader.finish(), None);
        let _ = reader.take(&reading(1, 0, 0, 3.0));
        let _ = reader.take(&reading(1, 0, 4, 0.5));
        let scan = reader.finish().expect("one reading");
        assert_eq!(scan.ranges, [f32::INFINITY]);
        assert_eq!(reader.finish(), None);
    }
}
