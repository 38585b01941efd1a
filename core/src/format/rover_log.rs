//! Logs of a rover with an RPLIDAR: encoder counts and one revolution of the lidar per line.
//!
//! In: bytes, in chunks of any size. Out: a [`RoverLog`].
//!
//! A line is `left right t_ms d0 … d359`, whole numbers separated by blanks: the encoders' counts,
//! the milliseconds, and the range in each degree, mm, 0 where nothing was measured. All three
//! counters have 16 bits and wrap around: only their differences modulo 65 536 count, for the
//! encoders the one nearest to 0, for the time the non-negative one. So a pause of more than a
//! minute cannot be detected.
//!
//! A range that is negative or not a number counts as not measured, and a line with a counter that
//! is not a number is left out; both are reported (`RoverLog::left_out`).
//!
//! The file says nothing of the robot: counts per wheel revolution, wheel size and track width are
//! given beside it (settings `log.*`).
//!
//! Degrees run clockwise, as an RPLIDAR turns; d0 looks ahead. Source: SLAMTEC, "RPLIDAR A1
//! interface protocol", angles. The directions ahead and left were verified on recorded logs, by
//! how ranges change as the rover drives and turns.

use std::f64::consts::PI;

use super::field_error::read;
use super::left_out::{is_no_range, is_not_finite};
use super::text_log::{Lines, TextLog, TextLogError};
use super::{FieldError, LeftOut};
use crate::geom::Pose2;
use crate::robot::{Scan, Stamp};

/// Ranges in a line, one for each degree.
pub const BEAMS: usize = 360;
/// Fields before the ranges.
const COUNTERS: usize = 3;
/// Maximum range of an RPLIDAR A1 of the first series, m.
const MAX_RANGE: f64 = 6.0;
/// σ of a range, m: that of the A1 at short range, and how much it grows per metre. Logs of
/// revolutions are from the same sensor.
pub(super) const SIGMA: f64 = 0.01;
pub(super) const SIGMA_PER_METRE: f64 = 0.01;
/// σ of a direction rounded to a degree, rad: one degree over √12.
const BEARING_SIGMA: f64 = PI / 180.0 / 3.464_101_615_137_754_4;
const EXPECTED: &str = "a rover's log, `left right t_ms d0 … d359` in each line";

/// One line without its ranges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RoverScan {
    /// Counts since the first line, `[left, right]`.
    pub counts: [i64; 2],
    /// Milliseconds since the first line.
    pub millis: u64,
}

/// A rover's log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RoverLog {
    /// Its lines, in order.
    pub scans: Vec<RoverScan>,
    /// What the reader left out.
    pub left_out: LeftOut,
    /// Ranges, mm, [`BEAMS`] for each line.
    ranges: Vec<u16>,
    last: Option<[u16; COUNTERS]>,
}

/// Reads a rover's log from chunks of bytes.
#[derive(Clone, Debug)]
pub struct RoverLogReader {
    lines: Lines,
    log: RoverLog,
}

impl Default for RoverLogReader {
    fn default() -> Self {
        Self {
            lines: Lines::new(EXPECTED),
            log: RoverLog::default(),
        }
    }
}

impl RoverLogReader {
    /// Takes the next bytes.
    ///
    /// # Errors   [`TextLogError`], with line and field; the reader cannot be used after one.
    pub fn push(&mut self, bytes: &[u8]) -> Result<(), TextLogError> {
        self.lines.push(bytes, &mut self.log)
    }

    /// Ends the log.
    ///
    /// # Errors   [`TextLogError`]: a last line that is cut off, or no usable line.
    pub fn finish(mut self) -> Result<RoverLog, TextLogError> {
        self.lines.finish(&mut self.log)?;
        Ok(self.log)
    }
}

impl RoverLog {
    /// Seconds from the first line to the last.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.scans.last().map_or(0.0, RoverScan::seconds)
    }

    /// Whether a wheel ever turned.
    #[must_use]
    pub fn has_odometry(&self) -> bool {
        self.scans.iter().any(|scan| scan.counts != [0, 0])
    }

    /// Whether any range was measured.
    pub(crate) fn has_ranges(&self) -> bool {
        self.ranges.iter().any(|mm| *mm > 0)
    }

    /// The scan of a line, robot frame: what was measured in the revolution that ended at its stamp
    /// and took as long as the time since the previous line.
    #[must_use]
    pub fn scan(&self, index: usize) -> Option<Scan> {
        let line = self.scans.get(index)?;
        let ranges = self.ranges.get(index * BEAMS..(index + 1) * BEAMS)?;
        let range = |mm: &u16| match mm {
            0 => f32::NAN,
            mm if f64::from(*mm) > 1e3 * MAX_RANGE => f32::INFINITY,
            mm => 1e-3 * f32::from(*mm),
        };
        let sigma = |mm: &u16| (SIGMA + SIGMA_PER_METRE * 1e-3 * f64::from(*mm)) as f32;
        Some(Scan {
            stamp: line.stamp(),
            robot_from_sensor: Pose2::identity(),
            bearings: (0..BEAMS)
                .map(|degree| -(degree as f64).to_radians())
                .collect(),
            ranges: ranges.iter().map(range).collect(),
            sigmas: ranges.iter().map(sigma).collect(),
            bearing_sigma: BEARING_SIGMA,
            max_range: MAX_RANGE,
            sweep: 0.0,
            qualities: vec![],
        })
    }

    /// The ranges of a line, given as its words with their numbers in the line, from 1.
    fn take_ranges<'a>(
        &mut self,
        line: usize,
        words: impl Iterator<Item = (usize, &'a str)>,
    ) -> Result<(), FieldError> {
        for (field, word) in words {
            let name = format_args!("d{}", field - COUNTERS - 1);
            let expected = "a range in whole millimetres, 0 to 65535";
            let range = match read(line, name, word, expected, |_: &u16| true) {
                Ok(range) => range,
                Err(error) if is_no_range(word) => {
                    self.left_out.ranges.add(|| error);
                    0
                }
                Err(error) => return Err(error),
            };
            self.ranges.push(range);
        }
        Ok(())
    }
}

impl TextLog for RoverLog {
    fn take(&mut self, line: usize, text: &str) -> Result<(), FieldError> {
        let found = text.split_ascii_whitespace().count();
        if found != COUNTERS + BEAMS {
            let expected = format_args!("{}: left right t_ms d0 … d359", COUNTERS + BEAMS);
            return Err(FieldError::count(line, found, expected));
        }
        let mut words = (1..).zip(text.split_ascii_whitespace());
        let mut counters = [0; COUNTERS];
        let names = ["left", "right", "t_ms"];
        for ((counter, name), (_, word)) in counters.iter_mut().zip(names).zip(&mut words) {
            let expected = "a counter of 16 bits: -32768 to 65535";
            let fits = |n: &i32| (-32_768..=65_535).contains(n);
            match read(line, name, word, expected, fits) {
                // Modulo 65 536, whether it was written as signed or unsigned.
                Ok(count) => *counter = count as u16,
                Err(error) if is_not_finite(word) => {
                    self.left_out.lines.add(|| error);
                    return Ok(());
                }
                Err(error) => return Err(error),
            }
        }
        let before = self.ranges.len();
        let taken = self.take_ranges(line, words);
        if taken.is_err() {
            self.ranges.truncate(before);
            return taken;
        }
        let scan = match (self.scans.last(), self.last) {
            (Some(scan), Some(last)) => scan.after(last, counters),
            _ => RoverScan {
                counts: [0, 0],
                millis: 0,
            },
        };
        self.scans.push(scan);
        self.last = Some(counters);
        Ok(())
    }

    fn has_scans(&self) -> bool {
        !self.scans.is_empty()
    }

    fn left_out(&self) -> &LeftOut {
        &self.left_out
    }
}

impl RoverScan {
    /// Stamp: time since the first line.
    #[must_use]
    pub fn stamp(&self) -> Stamp {
        Stamp(1000 * self.millis)
    }

    /// The stamp in seconds.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.stamp().seconds()
    }

    fn after(&self, last: [u16; COUNTERS], now: [u16; COUNTERS]) -> Self {
        let [left, right, millis] = [0, 1, 2].map(|i| now[i].wrapping_sub(last[i]));
        // The nearest: a wheel may turn backwards, but time may not.
        let signed = |counts: u16| i64::from(counts as i16);
        Self {
            counts: [
                self.counts[0] + signed(left),
                self.counts[1] + signed(right),
            ],
            millis: self.millis + u64::from(millis),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(counters: [i32; 3], ranges: impl Fn(usize) -> u32) -> String {
        let [left, right, millis] = counters;
        let ranges: String = (0..BEAMS).map(|i| format!(" {}", ranges(i))).collect();
        format!("{left} {right} {millis}{ranges}\n")
    }

    fn parse(text: &str) -> Result<RoverLog, TextLogError> {
        let mut reader = RoverLogReader::default();
        reader.push(text.as_bytes())?;
        reader.finish()
    }

    #[test]
    fn counters_begin_anew_at_16_bits_with_a_sign_or_without() {
        let signed = [[32_760, -32_760, 65_500], [-32_766, 32_766, 146]];
        let unsigned = [[32_760, 32_776, 65_500], [32_770, 32_766, 146]];
        for [first, second] in [signed, unsigned] {
            let log = parse(&(line(first, |_| 500) + &line(second, |_| 500))).unwrap();
            assert_eq!(log.scans[0].counts, [0, 0]);
            assert_eq!(log.scans[1].counts, [10, -10]);
            assert_eq!(log.scans[1].millis, 182);
            assert!(log.has_odometry() && (log.duration() - 0.182).abs() < 1e-12);
        }
        let still = line([5, 5, 0], |_| 500) + &line([5, 5, 182], |_| 500);
        assert!(!parse(&still).unwrap().has_odometry());
    }

    #[test]
    fn degrees_run_clockwise_from_ahead_and_0_is_nothing() {
        let ranges = |degree| match degree {
            0 => 1000,
            90 => 2500,
            91 => 6001,
            _ => 0,
        };
        let scan = parse(&line([0, 0, 0], ranges)).unwrap().scan(0).unwrap();
        assert_eq!((scan.bearings[0], scan.ranges[0]), (0.0, 1.0));
        // To the right.
        assert!((scan.bearings[90] + 0.5 * PI).abs() < 1e-12);
        assert!((scan.ranges[90] - 2.5).abs() < 1e-6);
        assert_eq!(scan.ranges[91], f32::INFINITY);
        assert!(scan.ranges[92].is_nan());
        scan.validate().unwrap();
    }

    #[test]
    fn what_is_wrong_is_named_with_line_and_field() {
        let good = line([0, 0, 0], |_| 7);
        let check = |text: &str, expected: &str| {
            let error = parse(text).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
        };
        let broken = good.replacen("7", "x", 3).replacen('x', "7", 2);
        check(
            &(good.clone() + "# a comment\n\n" + &broken),
            "line 4: d2 is `x`",
        );
        check(
            &broken.replacen("0 0 0", "0 0 65536", 1),
            "line 1: t_ms is `65536`",
        );
        check(
            "1 2 3 4\n",
            "line 1: the number of fields is `4`, expected 363",
        );
        check(
            &good[..100],
            "line 1: the file is cut off within its last line",
        );
        check("", "no scan in 0 lines");
        check("# nothing\n", "no scan in 1 lines");
        check("1 2 3 \u{1}\n", "line 1: byte 7 is 0x01");
        check(&"1 ".repeat(1 << 20), "line 1 is longer than 1048576 bytes");
    }

    #[test]
    fn a_line_with_a_range_that_is_none_is_used_and_one_without_a_counter_is_not() {
        let good = |left: i32| line([left, 0, left], |_| 700);
        let ranges = good(10).replacen("700", "nan", 1).replacen("700", "-3", 1);
        let lost = good(20).replacen("20", "nan", 1);
        let log = parse(&[good(0), ranges, lost.clone(), good(30)].concat()).unwrap();
        let counts: Vec<i64> = log.scans.iter().map(|scan| scan.counts[0]).collect();
        assert_eq!(counts, [0, 10, 30]);
        let scan = log.scan(1).unwrap();
        let none = scan.ranges.iter().filter(|range| range.is_nan()).count();
        assert!(none == 2 && scan.ranges[0].is_nan() && scan.ranges[1].is_nan());
        let whole = log.scan(2).unwrap();
        assert!(whole.ranges.iter().all(|range| (range - 0.7).abs() < 1e-6));
        let told = log.left_out.sentences();
        assert!(
            told[0].starts_with("2 ranges are no measurements"),
            "{told:?}"
        );
        assert!(told[0].contains("line 2: d0 is `nan`"), "{told:?}");
        assert!(told[1].starts_with("1 line cannot be used"), "{told:?}");
        assert!(told[1].contains("line 3: left is `nan`"), "{told:?}");
        let error = parse(&("# begins\n".to_owned() + &lost))
            .unwrap_err()
            .to_string();
        assert!(error.starts_with("line 2: left is `nan`"), "{error}");
    }

    /// Two recorded logs. The expected values were computed independently of this reader: lines by
    /// `wc`, time and distance (the mean of both wheels) from the first three columns by a script.
    #[test]
    fn recorded_logs_are_read_whole() {
        for (name, lines, seconds, metres) in [
            ("data_24JUL14_14m", 237, 43.431, 4.035..4.036),
            ("data_6AUG14_16m", 3936, 839.732, 56.787..56.788),
        ] {
            let Some(bytes) = crate::format::recorded(&format!("rplidar/{name}.log")) else {
                return;
            };
            let mut reader = RoverLogReader::default();
            for piece in bytes.chunks(1000) {
                reader.push(piece).unwrap();
            }
            let log = reader.finish().unwrap();
            assert_eq!(log.scans.len(), lines);
            assert!(
                (log.duration() - seconds).abs() < 1e-9,
                "{}",
                log.duration()
            );
            let counted = |pair: &[RoverScan]| {
                let ways = [0, 1].map(|i| pair[1].counts[i] - pair[0].counts[i]);
                0.5 * (ways[0] + ways[1]).abs() as f64 * PI * 0.0582 / 333.3
            };
            let way: f64 = log.scans.windows(2).map(counted).sum();
            assert!(metres.contains(&way), "{name}: {way}");
        }
    }
}
