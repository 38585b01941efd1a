//! One reading for each sector of a scan, and when a sector without a return counts as free.
//!
//! In: a scan, and how wide a sector is. Out: a scan of as many beams as there are sectors with a
//! beam in them.
//!
//! 1. A beam belongs to the sector ⌊(bearing + π) / width⌋ of those that divide the circle evenly.
//! 2. Missing returns count: if more than [`SectorConfig::no_returns`] of a sector's beams came
//!    back with nothing, nothing is there. Fewer are errors, and do not count. Celej's sensor
//!    reported 20 000 mm now and then where a wall was, and the map had free cells behind it.
//! 3. Otherwise the sector's range is the least of its valid ones, or their mean, with the
//!    corresponding σ; without a valid one the sector is invalid.
//!
//! The new beam points along the middle of its sector, and its direction is as uncertain as a
//! uniform distribution over the width.
//!
//! Source: Celej §4 (`measurement`: sectors of at least 10°) and §7 (`errcount`).

use std::f64::consts::{PI, TAU};

use crate::bounds::config;
use crate::robot::Scan;

/// Which range represents a sector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SectorRange {
    /// The least: nothing is nearer.
    Least,
    /// The mean: less noise, but details that stand out are smoothed away.
    Mean,
}

impl SectorRange {
    /// All variants, with their names in settings and their names for people.
    pub const ALL: [(&'static str, Self, &'static str); 2] = [
        ("least", Self::Least, "the least range"),
        ("mean", Self::Mean, "the mean range"),
    ];
}

config! {
    /// How a scan is reduced to sectors.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct SectorConfig {
        /// Width of a sector, rad; it is made a little less, so that a whole number goes round.
        /// Default 10°, Celej's least. Larger: fewer, surer readings.
        pub width: f64 = 10.0_f64.to_radians(),
        /// So many no-returns in a sector are errors; more say that nothing is there. Default 3.
        pub no_returns: usize = 3,
        /// Which range stands for the sector. Default the least.
        pub range: SectorRange = SectorRange::Least,
    }
}

/// What is gathered of the beams of a sector.
#[derive(Clone, Copy, Default)]
struct Sector {
    /// Its first beam, if it has any.
    first: Option<usize>,
    no_returns: usize,
    valid: usize,
    least: (f64, f64),
    /// Sums of range and of σ².
    sums: (f64, f64),
}

impl Sector {
    fn add(&mut self, beam: usize, range: f64, sigma: f64) {
        self.first = self.first.or(Some(beam));
        if range == f64::INFINITY {
            self.no_returns += 1;
        } else if range.is_finite() {
            if self.valid == 0 || range < self.least.0 {
                self.least = (range, sigma);
            }
            self.valid += 1;
            self.sums.0 += range;
            self.sums.1 += sigma * sigma;
        }
    }

    /// Range and σ: steps 2 and 3.
    fn reading(&self, config: &SectorConfig) -> (f64, f64) {
        let n = self.valid as f64;
        match config.range {
            _ if self.no_returns > config.no_returns => (f64::INFINITY, 0.0),
            _ if self.valid == 0 => (f64::NAN, 0.0),
            SectorRange::Least => self.least,
            SectorRange::Mean => (self.sums.0 / n, self.sums.1.sqrt() / n),
        }
    }
}

/// Reduces a scan to sectors, in the order in which the scan reaches them; sectors without a beam
/// are skipped.
#[must_use]
pub fn sectors(scan: &Scan, config: &SectorConfig) -> Scan {
    let count = (TAU / config.width.clamp(1e-3, TAU)).ceil() as usize;
    let width = TAU / count as f64;
    let mut all = vec![Sector::default(); count];
    let readings = scan.ranges.iter().zip(&scan.sigmas);
    for (beam, (bearing, (range, sigma))) in scan.bearings.iter().zip(readings).enumerate() {
        let turns = (bearing + PI) / TAU;
        let at = ((turns - turns.floor()) * count as f64) as usize;
        if let Some(sector) = all.get_mut(at.min(count - 1)) {
            sector.add(beam, f64::from(*range), f64::from(*sigma));
        }
    }
    let mut reduced = Scan {
        bearings: vec![],
        ranges: vec![],
        sigmas: vec![],
        qualities: vec![],
        bearing_sigma: scan.bearing_sigma.max(width / 12.0_f64.sqrt()),
        ..scan.clone()
    };
    let mut seen: Vec<_> = all
        .iter()
        .enumerate()
        .filter(|(_, s)| s.first.is_some())
        .collect();
    seen.sort_by_key(|(_, sector)| sector.first);
    for (at, sector) in seen {
        let (range, sigma) = sector.reading(config);
        reduced.bearings.push((at as f64 + 0.5) * width - PI);
        reduced.ranges.push(range as f32);
        reduced.sigmas.push(sigma as f32);
    }
    reduced
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::geom::{Pose2, wrap};
    use crate::robot::Stamp;

    fn scan(ranges: Vec<f32>) -> Scan {
        let n = ranges.len();
        Scan {
            stamp: Stamp(5),
            robot_from_sensor: Pose2::new(0.1, 0.0, 0.2),
            bearings: (0..n).map(|i| wrap(TAU * i as f64 / n as f64)).collect(),
            sigmas: vec![0.02; n],
            ranges,
            qualities: vec![],
            bearing_sigma: 0.001,
            max_range: 12.0,
            sweep: 0.0,
        }
    }

    /// Of 36 sectors, the one that holds bearing 0.05.
    fn ahead(scan: &Scan, config: &SectorConfig) -> (f64, f32, f32) {
        let reduced = sectors(scan, config);
        let at = reduced
            .bearings
            .iter()
            .position(|b| (b - 0.05).abs() < 0.0873)
            .unwrap();
        (reduced.bearings[at], reduced.ranges[at], reduced.sigmas[at])
    }

    #[test]
    fn few_no_returns_are_errors_and_many_are_free() {
        let mut ranges = vec![2.0; 360];
        ranges[4] = 1.5;
        for (no_returns, expected) in [(0, 1.5), (3, 1.5), (4, f32::INFINITY), (9, f32::INFINITY)] {
            let mut ranges = ranges.clone();
            ranges
                .iter_mut()
                .skip(5)
                .take(no_returns)
                .for_each(|r| *r = f32::INFINITY);
            let (bearing, range, _) = ahead(&scan(ranges), &SectorConfig::default());
            assert_eq!(range, expected, "{no_returns}");
            assert!((bearing - 5.0_f64.to_radians()).abs() < 1e-12);
        }
    }

    #[test]
    fn invalid_readings_count_for_nothing() {
        let mut ranges = vec![f32::NAN; 360];
        let (_, range, _) = ahead(&scan(ranges.clone()), &SectorConfig::default());
        assert!(range.is_nan());
        ranges[3] = 4.0;
        let (_, range, _) = ahead(&scan(ranges), &SectorConfig::default());
        assert_eq!(range, 4.0);
    }

    #[test]
    fn a_mean_is_as_sure_as_a_mean_of_so_many() {
        let config = SectorConfig {
            range: SectorRange::Mean,
            ..SectorConfig::default()
        };
        let ranges = (0..360).map(|i| 1.0 + (i % 10) as f32 * 0.1).collect();
        let (_, range, sigma) = ahead(&scan(ranges), &config);
        assert!((range - 1.45).abs() < 1e-6);
        assert!((f64::from(sigma) - 0.02 / 10.0_f64.sqrt()).abs() < 1e-6);
    }

    proptest! {
        #[test]
        fn every_sector_is_that_of_its_own_beams(
            ranges in proptest::collection::vec(
                prop_oneof![4 => 0.1_f32..9.0, 1 => Just(f32::INFINITY), 1 => Just(f32::NAN)], 1..200,
            ),
            degrees in 10.0..120.0_f64, no_returns in 0_usize..5,
        ) {
            let config = SectorConfig { width: degrees.to_radians(), no_returns, range: SectorRange::Least };
            let scan = scan(ranges);
            let reduced = sectors(&scan, &config);
            prop_assert!(reduced.validate().is_ok());
            let half = PI / (360.0 / degrees).ceil();
            let mut beams = 0;
            for (middle, range) in reduced.bearings.iter().zip(&reduced.ranges) {
                let own: Vec<f32> = scan.bearings.iter().zip(&scan.ranges)
                    .filter(|(b, _)| (-half..half - 1e-9).contains(&wrap(**b - middle)))
                    .map(|(_, r)| *r)
                    .collect();
                beams += own.len();
                let silent = own.iter().filter(|r| **r == f32::INFINITY).count();
                let least = own.iter().copied().filter(|r| r.is_finite()).min_by(f32::total_cmp);
                let expected = if silent > no_returns { f32::INFINITY } else { least.unwrap_or(f32::NAN) };
                // A beam on the border of two sectors may be in either.
                let is_on_border = scan.bearings.iter().any(|b| (wrap(*b - middle).abs() - half).abs() < 1e-9);
                prop_assert!(is_on_border || range.to_bits() == expected.to_bits(), "{range} {expected}");
            }
            prop_assert!(beams <= scan.ranges.len());
        }
    }
}
