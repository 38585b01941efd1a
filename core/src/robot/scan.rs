//! One revolution, sweep or flash of a range sensor.

use super::Stamp;
use crate::bounds::{FINITE, NOT_NEGATIVE, OutOfBounds, POSITIVE, check};
use crate::geom::Pose2;

/// Polar readings of one sweep, in the order in which they were taken.
///
/// The columns have the same length, except `qualities`, which may be empty. Beam `i` of `n` was
/// taken `sweep * (n - 1 - i) / (n - 1)` seconds before `stamp`: the stamp is that of the last
/// beam.
#[derive(Clone, Debug, PartialEq)]
pub struct Scan {
    /// When the last beam was taken.
    pub stamp: Stamp,
    /// Where the sensor sits on the robot.
    pub robot_from_sensor: Pose2,
    /// Direction of each beam in the sensor frame, rad.
    pub bearings: Vec<f64>,
    /// Range of each beam, m; `INFINITY` if nothing came back, `NAN` if the reading is invalid.
    pub ranges: Vec<f32>,
    /// Standard deviation of each range, m.
    pub sigmas: Vec<f32>,
    /// Strength of each echo in the sensor's own unit (RPLIDAR 0 to 63, LD06 0 to 255); 0 if
    /// nothing valid came back. Empty if the sensor reports none.
    pub qualities: Vec<u8>,
    /// Standard deviation of each bearing, rad.
    pub bearing_sigma: f64,
    /// The farthest range that the sensor reports, m: a beam without a return may be free this far.
    pub max_range: f64,
    /// Duration from the first beam to the last, s; 0 if all were taken at once or the robot stood
    /// still.
    pub sweep: f64,
}

/// Why a [`Scan`] cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ScanError {
    /// No beam at all.
    #[error("scan at {seconds:.3} s has no beams")]
    Empty {
        /// Stamp of the scan, s.
        seconds: f64,
    },
    /// The columns differ in length.
    #[error(
        "scan has {bearings} bearings, {ranges} ranges and {sigmas} sigmas; expected the same number of each"
    )]
    Uneven {
        /// Number of bearings.
        bearings: usize,
        /// Number of ranges.
        ranges: usize,
        /// Number of sigmas.
        sigmas: usize,
    },
    /// Some beams have a quality and some have none.
    #[error(
        "scan has {ranges} ranges and {qualities} qualities; expected one for each, or none at all"
    )]
    Qualities {
        /// Number of ranges.
        ranges: usize,
        /// Number of qualities.
        qualities: usize,
    },
    /// A field of the whole scan is out of its range.
    #[error("scan at {seconds:.3} s: {figure}")]
    Whole {
        /// When the scan was taken, s.
        seconds: f64,
        /// The figure at fault.
        figure: OutOfBounds,
    },
    /// A value is out of its range.
    #[error("beam {beam}: {field} is {value}, expected {expected}")]
    Value {
        /// Index of the beam, from 0.
        beam: usize,
        /// The column.
        field: &'static str,
        /// The value found.
        value: f64,
        /// The values allowed.
        expected: &'static str,
    },
}

impl Scan {
    /// Number of beams.
    #[must_use]
    pub fn len(&self) -> usize {
        self.ranges.len()
    }

    /// Whether there is no beam.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ranges.is_empty()
    }

    /// Checks what the columns promise. A source calls it once where data enters; afterwards the
    /// scan is trusted.
    ///
    /// # Errors    [`ScanError`], naming the first beam and column that break the promise.
    pub fn validate(&self) -> Result<(), ScanError> {
        let seconds = self.stamp.seconds();
        let (bearings, ranges, sigmas) = (self.bearings.len(), self.len(), self.sigmas.len());
        let qualities = self.qualities.len();
        if ranges == 0 {
            return Err(ScanError::Empty { seconds });
        }
        if bearings != ranges || sigmas != ranges {
            return Err(ScanError::Uneven {
                bearings,
                ranges,
                sigmas,
            });
        }
        if qualities != 0 && qualities != ranges {
            return Err(ScanError::Qualities { ranges, qualities });
        }
        let sensor = &self.robot_from_sensor;
        let place = sensor.x() + sensor.y() + sensor.heading();
        check(&[
            ("sweep", self.sweep, NOT_NEGATIVE),
            ("bearing_sigma", self.bearing_sigma, NOT_NEGATIVE),
            ("max_range", self.max_range, POSITIVE),
            ("place of the sensor", place, FINITE),
        ])
        .map_err(|figure| ScanError::Whole { seconds, figure })?;
        let columns = self.bearings.iter().zip(&self.ranges).zip(&self.sigmas);
        for (beam, ((&bearing, &range), &sigma)) in columns.enumerate() {
            let value = |field, value, expected| {
                Err(ScanError::Value {
                    beam,
                    field,
                    value,
                    expected,
                })
            };
            if !bearing.is_finite() {
                return value("bearing", bearing, "a finite angle");
            }
            if range < 0.0 {
                return value(
                    "range",
                    f64::from(range),
                    "at least 0, infinite for no return, or NaN for invalid",
                );
            }
            if range.is_finite() && !(sigma > 0.0 && sigma.is_finite()) {
                return value("sigma", f64::from(sigma), "greater than 0 and finite");
            }
        }
        Ok(())
    }

    /// Strength of the echo of a beam; `None` if the sensor reports none.
    #[must_use]
    pub fn quality(&self, beam: usize) -> Option<u8> {
        self.qualities.get(beam).copied()
    }

    /// How far before the last beam the given one was taken, as a fraction of the sweep: 1 for the
    /// first, 0 for the last.
    #[must_use]
    pub fn age_fraction(&self, beam: usize) -> f64 {
        let last = self.len().saturating_sub(1);
        if last == 0 {
            0.0
        } else {
            (last - beam.min(last)) as f64 / last as f64
        }
    }

    /// When a beam was taken.
    #[must_use]
    pub fn taken_at(&self, beam: usize) -> Stamp {
        Stamp::from_seconds(self.stamp.seconds() - self.sweep * self.age_fraction(beam))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan(ranges: &[f32]) -> Scan {
        Scan {
            stamp: Stamp(1_000_000),
            robot_from_sensor: Pose2::identity(),
            bearings: (0..ranges.len()).map(|i| i as f64 * 0.1).collect(),
            ranges: ranges.to_vec(),
            sigmas: vec![0.01; ranges.len()],
            qualities: vec![],
            bearing_sigma: 0.0,
            max_range: 6.0,
            sweep: 0.1,
        }
    }

    #[test]
    fn no_return_and_invalid_are_valid_readings() {
        assert_eq!(scan(&[1.0, f32::INFINITY, f32::NAN]).validate(), Ok(()));
    }

    #[test]
    fn bad_values_are_named_with_their_beam() {
        let message = |s: &Scan| s.validate().unwrap_err().to_string();
        assert!(message(&scan(&[])).contains("no beams"));
        assert!(message(&scan(&[1.0, -2.0])).starts_with("beam 1: range is -2"));
        let mut uneven = scan(&[1.0, 2.0]);
        uneven.sigmas.pop();
        assert!(message(&uneven).contains("2 bearings, 2 ranges and 1 sigmas"));
        let mut sigma = scan(&[1.0]);
        sigma.sigmas[0] = 0.0;
        assert!(message(&sigma).starts_with("beam 0: sigma is 0"));
    }

    #[test]
    fn all_beams_have_a_quality_or_none_has() {
        let mut scored = scan(&[1.0, 2.0]);
        assert_eq!(scored.quality(1), None);
        scored.qualities = vec![47, 0];
        assert_eq!((scored.validate(), scored.quality(1)), (Ok(()), Some(0)));
        scored.qualities.pop();
        let message = scored.validate().unwrap_err().to_string();
        assert!(message.contains("2 ranges and 1 qualities"), "{message}");
    }

    #[test]
    fn bad_values_of_the_whole_scan_are_named_with_its_stamp() {
        let check = |spoil: fn(&mut Scan), expected: &str| {
            let mut spoilt = scan(&[1.0]);
            spoil(&mut spoilt);
            let message = spoilt.validate().unwrap_err().to_string();
            assert!(message.starts_with("scan at 1.000 s: "), "{message}");
            assert!(message.contains(expected), "{message}");
        };
        check(
            |s| s.sweep = -0.1,
            "sweep is -0.1, expected a finite number, at least 0",
        );
        check(|s| s.bearing_sigma = f64::NAN, "bearing_sigma is NaN");
        check(|s| s.max_range = f64::INFINITY, "max_range is inf");
        check(|s| s.max_range = 0.0, "greater than 0");
        let lost = |s: &mut Scan| s.robot_from_sensor = Pose2::new(0.0, f64::INFINITY, 0.0);
        check(lost, "place of the sensor is inf");
    }

    #[test]
    fn first_beam_is_one_sweep_old() {
        let s = scan(&[1.0, 1.0, 1.0]);
        assert_eq!(
            (s.age_fraction(0), s.age_fraction(1), s.age_fraction(2)),
            (1.0, 0.5, 0.0)
        );
    }
}
