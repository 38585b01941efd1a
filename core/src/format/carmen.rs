//! CARMEN logs (`.log`, `.clf`): recorded laser scans with the odometry at which they were taken.
//!
//! In: bytes, in chunks of any size. Out: a [`CarmenLog`], scans sorted by `ipc_timestamp`.
//!
//! 1. Lines are cut from the chunks as they come; only an unfinished line and the numbers themselves are kept, so a
//!    large log is never held as text.
//! 2. `FLASER`, `RLASER` and `ROBOTLASER1` become scans, `PARAM` is kept, `ODOM` is counted (every laser message
//!    carries the odometry of its own moment, interpolated by the recorder), other messages are skipped.
//! 3. Structure is strict: the number of fields must be that announced and every number finite. Spaces, tabs, line
//!    ends, empty lines and comments are free.
//! 4. At the end the scans are sorted, since recorders write messages of several senders as they arrive, and the
//!    reading that stands for "nothing came back" is found (see [`CarmenLog::no_return_from`]).
//!
//! Source: CARMEN, Carnegie Mellon robot navigation toolkit, log format (the comment lines at the head of each log).
//! `FLASER n r_1 … r_n x y θ odom_x odom_y odom_θ ipc_timestamp host logger_timestamp`: the first pose is that of the
//! laser, the second that of the robot, and the place of the laser on the robot is their difference.

use crate::geom::Pose2;
use crate::robot::{Scan, Stamp};

/// A line longer than this is not a line of a log.
const MAX_LINE: usize = 1 << 20;
/// Readings at or above this say that nothing came back, m: the SICK's codes for it decode to 81.83 and 81.91.
const ALWAYS_NO_RETURN: f32 = 80.0;

/// Why bytes are not a CARMEN log that can be replayed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CarmenError {
    /// Not a single byte, or only empty lines.
    #[error("the file is empty; expected a CARMEN log with FLASER, RLASER or ROBOTLASER1 messages")]
    Empty,
    /// Bytes that are no text.
    #[error(
        "line {line}: byte {column} is 0x{byte:02x}, which is not text; expected a CARMEN log, one message per line"
    )]
    Binary {
        /// Line, from 1.
        line: usize,
        /// Byte in the line, from 1.
        column: usize,
        /// The byte.
        byte: u8,
    },
    /// A line without an end.
    #[error(
        "line {line} is longer than {limit} bytes; expected a CARMEN log, one message per line"
    )]
    LineTooLong {
        /// Line, from 1.
        line: usize,
        /// The limit.
        limit: usize,
    },
    /// The fields are not as many as the message announces.
    #[error("line {line}: {message} {announced} needs {expected} fields, found {found}")]
    Count {
        /// Line, from 1.
        line: usize,
        /// Name of the message.
        message: &'static str,
        /// What the message announces, in words.
        announced: String,
        /// Number of fields that this makes, the name included.
        expected: usize,
        /// Number of fields in the line.
        found: usize,
    },
    /// A field that is not what it should be.
    #[error("line {line}, field {field} of {message} is \"{found}\", expected {expected}")]
    Field {
        /// Line, from 1.
        line: usize,
        /// Field in the line, from 1; the name of the message is the first.
        field: usize,
        /// Name of the message.
        message: &'static str,
        /// What stands there, shortened.
        found: String,
        /// What may stand there.
        expected: &'static str,
    },
    /// The file ends within a message.
    #[error("line {line}: the file is cut off within its last message ({reason})")]
    CutOff {
        /// Line, from 1.
        line: usize,
        /// What is missing.
        reason: String,
    },
    /// Text, but no laser message.
    #[error(
        "no laser message in {lines} lines; expected a CARMEN log with FLASER, RLASER or ROBOTLASER1 messages"
    )]
    NoLaser {
        /// Number of lines read.
        lines: usize,
    },
}

/// Which laser took a scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Laser {
    /// `FLASER`.
    Front,
    /// `RLASER`.
    Rear,
    /// `ROBOTLASER1`.
    Robot1,
}

/// Directions of a scan's beams: beam i looks to `first + i * step`, rad, in the frame of the laser.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeamFan {
    /// Direction of the first beam, rad.
    pub first: f64,
    /// From beam to beam, rad.
    pub step: f64,
}

impl BeamFan {
    /// The fan of `FLASER` and `RLASER`, which do not say it: a half circle, from the right to the left.
    ///
    /// An even number of beams leaves out the last direction (180 beams: -90° to 89° in steps of 1°; 360: in steps of
    /// 0.5°); an odd number has both ends (181: -90° to 90°).
    #[must_use]
    pub fn half_circle(beams: usize) -> Self {
        let gaps = if beams.is_multiple_of(2) {
            beams
        } else {
            beams - 1
        };
        Self {
            first: -std::f64::consts::FRAC_PI_2,
            step: std::f64::consts::PI / gaps.max(1) as f64,
        }
    }
}

/// One laser message without its readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CarmenScan {
    /// `ipc_timestamp`, s, as it stands in the log.
    pub ipc_seconds: f64,
    /// Pose of the robot in the frame of the odometry.
    pub odom_from_robot: Pose2,
    /// Where the laser sits.
    pub robot_from_sensor: Pose2,
    /// Directions of the beams.
    pub fan: BeamFan,
    /// Range at which the message itself says that the laser ends, m; infinite where it does not.
    pub max_range: f32,
    start: usize,
    beams: usize,
}

/// The scans of one laser, in the order of time.
#[derive(Clone, Debug)]
pub struct CarmenLog {
    /// The laser whose scans these are: the one with most messages.
    pub laser: Laser,
    /// The scans, sorted by `ipc_seconds`.
    pub scans: Vec<CarmenScan>,
    /// `PARAM` lines: name and value.
    pub params: Vec<(String, String)>,
    /// Number of `ODOM` messages.
    pub odometry_messages: usize,
    /// Number of scans that stood before an earlier one in the file.
    pub backward_stamps: usize,
    /// Readings from here on say that nothing came back, m: 80, or the log's largest reading where that is repeated so
    /// often that it must be a code.
    pub no_return_from: f32,
    readings: Vec<f32>,
}

/// Reads a log from chunks of bytes.
#[derive(Clone, Debug, Default)]
pub struct CarmenReader {
    unfinished: Vec<u8>,
    line: usize,
    lasers: [Vec<CarmenScan>; 3],
    readings: Vec<f32>,
    params: Vec<(String, String)>,
    odometry_messages: usize,
    anything: bool,
}

impl CarmenLog {
    /// Reads a log that is all in memory.
    ///
    /// # Errors   [`CarmenError`], with the line and field.
    pub fn parse(bytes: &[u8]) -> Result<Self, CarmenError> {
        let mut reader = CarmenReader::default();
        reader.push(bytes)?;
        reader.finish()
    }

    /// Readings of a scan as recorded, m.
    #[must_use]
    pub fn readings(&self, scan: &CarmenScan) -> &[f32] {
        self.readings
            .get(scan.start..scan.start + scan.beams)
            .unwrap_or(&[])
    }

    /// Seconds from the first scan to the last.
    #[must_use]
    pub fn duration(&self) -> f64 {
        match (self.scans.first(), self.scans.last()) {
            (Some(first), Some(last)) => last.ipc_seconds - first.ipc_seconds,
            _ => 0.0,
        }
    }

    /// Stamp of a scan: time since the first.
    #[must_use]
    pub fn stamp(&self, scan: &CarmenScan) -> Stamp {
        let start = self.scans.first().map_or(0.0, |first| first.ipc_seconds);
        Stamp::from_seconds(scan.ipc_seconds - start)
    }

    /// A scan as the rest of core takes it: no-returns infinite, readings of 0 invalid, σ 1 cm as the SICK's.
    #[must_use]
    pub fn scan(&self, scan: &CarmenScan) -> Scan {
        let no_return = self.no_return_from.min(scan.max_range);
        let readings = self.readings(scan);
        let ranges = readings
            .iter()
            .map(|&range| {
                if range >= no_return {
                    f32::INFINITY
                } else if range > 0.0 {
                    range
                } else {
                    f32::NAN
                }
            })
            .collect();
        let bearings = (0..readings.len())
            .map(|i| scan.fan.first + i as f64 * scan.fan.step)
            .collect();
        Scan {
            stamp: self.stamp(scan),
            robot_from_sensor: scan.robot_from_sensor,
            bearings,
            ranges,
            sigmas: vec![0.01; readings.len()],
            bearing_sigma: 0.25 * scan.fan.step.abs(),
            max_range: f64::from(no_return),
            sweep: 0.0,
        }
    }
}

impl CarmenReader {
    /// Takes the next bytes.
    ///
    /// # Errors   [`CarmenError`]; the reader is of no further use then.
    pub fn push(&mut self, mut bytes: &[u8]) -> Result<(), CarmenError> {
        while let Some(end) = bytes.iter().position(|&b| b == b'\n') {
            let (line, rest) = bytes.split_at(end);
            bytes = rest.get(1..).unwrap_or(&[]);
            if self.unfinished.is_empty() {
                self.read_line(line)?;
            } else {
                let mut whole = std::mem::take(&mut self.unfinished);
                whole.extend_from_slice(line);
                self.read_line(&whole)?;
            }
        }
        self.unfinished.extend_from_slice(bytes);
        if self.unfinished.len() > MAX_LINE {
            let line = self.line + 1;
            check_text(&self.unfinished, line)?;
            return Err(CarmenError::LineTooLong {
                line,
                limit: MAX_LINE,
            });
        }
        Ok(())
    }

    /// Sorts what was read.
    ///
    /// # Errors   [`CarmenError`]: a last line cut off, no laser message, nothing at all.
    pub fn finish(mut self) -> Result<CarmenLog, CarmenError> {
        let last = std::mem::take(&mut self.unfinished);
        if !last.is_empty() {
            self.read_line(&last).map_err(|error| match error {
                CarmenError::Binary { .. } => error,
                other => CarmenError::CutOff {
                    line: self.line,
                    reason: other.to_string(),
                },
            })?;
        }
        if !self.anything {
            return Err(CarmenError::Empty);
        }
        // The first of equals: the front laser.
        let mut best = (Laser::Front, &mut vec![]);
        let kinds = [Laser::Front, Laser::Rear, Laser::Robot1];
        for (laser, scans) in kinds.into_iter().zip(&mut self.lasers) {
            if scans.len() > best.1.len() {
                best = (laser, scans);
            }
        }
        let laser = best.0;
        let mut scans = std::mem::take(best.1);
        if scans.is_empty() {
            return Err(CarmenError::NoLaser { lines: self.line });
        }
        let backward_stamps = scans
            .windows(2)
            .filter(|w| w[1].ipc_seconds < w[0].ipc_seconds)
            .count();
        // A stable sort: scans of the same stamp keep the order of the file.
        scans.sort_by(|a, b| a.ipc_seconds.total_cmp(&b.ipc_seconds));
        Ok(CarmenLog {
            laser,
            no_return_from: no_return_from(&self.readings),
            scans,
            params: self.params,
            odometry_messages: self.odometry_messages,
            backward_stamps,
            readings: self.readings,
        })
    }

    fn read_line(&mut self, bytes: &[u8]) -> Result<(), CarmenError> {
        self.line += 1;
        let text = check_text(bytes, self.line)?;
        let line = Line {
            number: self.line,
            text,
        };
        let Some(name) = text.split_ascii_whitespace().next() else {
            return Ok(());
        };
        self.anything = true;
        match name {
            "FLASER" => self.read_plain_laser(&line, "FLASER", 0),
            "RLASER" => self.read_plain_laser(&line, "RLASER", 1),
            "ROBOTLASER1" => self.read_robot_laser(&line),
            "ODOM" => {
                let mut fields = line.fields("ODOM");
                for _ in 0..7 {
                    fields.number()?;
                }
                self.odometry_messages += 1;
                Ok(())
            }
            "PARAM" => {
                let mut words = text.split_ascii_whitespace().skip(1);
                if let (Some(name), Some(value)) = (words.next(), words.next()) {
                    self.params.push((name.to_owned(), value.to_owned()));
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn read_plain_laser(
        &mut self,
        line: &Line<'_>,
        message: &'static str,
        slot: usize,
    ) -> Result<(), CarmenError> {
        let mut fields = line.fields(message);
        let beams = fields.count("a number of readings from 1 to 100000")?;
        fields.expect_total(beams + 11, || format!("of {beams} readings"))?;
        let start = self.read_ranges(&mut fields, beams)?;
        let map_from_laser = fields.pose()?;
        let odom_from_robot = fields.pose()?;
        let ipc_seconds = fields.number()?;
        self.lasers[slot].push(CarmenScan {
            ipc_seconds,
            odom_from_robot,
            robot_from_sensor: odom_from_robot.delta_to(&map_from_laser),
            fan: BeamFan::half_circle(beams),
            max_range: f32::INFINITY,
            start,
            beams,
        });
        Ok(())
    }

    /// `ROBOTLASER1 type start fov step max_range accuracy remission_mode n ranges… m remissions… laser_pose robot_pose
    /// tv rv forward_safety side_safety turn_axis ipc_timestamp host logger_timestamp`.
    fn read_robot_laser(&mut self, line: &Line<'_>) -> Result<(), CarmenError> {
        let mut fields = line.fields("ROBOTLASER1");
        fields.number()?;
        let first = fields.number()?;
        fields.number()?;
        let step = fields.number()?;
        let max_range = fields.number()?;
        fields.number()?;
        fields.number()?;
        let beams = fields.count("a number of readings from 1 to 100000")?;
        let start = self.read_ranges(&mut fields, beams)?;
        let remissions = fields.count_or_none("a number of remissions from 0 to 100000")?;
        fields.expect_total(9 + beams + 1 + remissions + 14, || {
            format!("of {beams} readings and {remissions} remissions")
        })?;
        for _ in 0..remissions {
            fields.number()?;
        }
        let map_from_laser = fields.pose()?;
        let odom_from_robot = fields.pose()?;
        for _ in 0..5 {
            fields.number()?;
        }
        let ipc_seconds = fields.number()?;
        self.lasers[2].push(CarmenScan {
            ipc_seconds,
            odom_from_robot,
            robot_from_sensor: odom_from_robot.delta_to(&map_from_laser),
            fan: BeamFan { first, step },
            max_range: if max_range > 0.0 {
                max_range as f32
            } else {
                f32::INFINITY
            },
            start,
            beams,
        });
        Ok(())
    }

    fn read_ranges(&mut self, fields: &mut Fields<'_>, beams: usize) -> Result<usize, CarmenError> {
        let start = self.readings.len();
        for _ in 0..beams {
            let range = fields.range()?;
            self.readings.push(range);
        }
        Ok(start)
    }
}

/// The largest reading stands for "no return" where at least one reading in 500 says it (81.83 in Intel, 81.91 in
/// Freiburg; cheaper lasers say 8 or 30); readings of 80 m and above always do.
fn no_return_from(readings: &[f32]) -> f32 {
    let largest = readings.iter().copied().fold(0.0_f32, f32::max);
    let near = largest * 0.999;
    let count = readings.iter().filter(|&&range| range >= near).count();
    if largest > 0.0 && count >= 3 && count * 500 >= readings.len() {
        near.min(ALWAYS_NO_RETURN)
    } else {
        ALWAYS_NO_RETURN
    }
}

fn check_text(bytes: &[u8], line: usize) -> Result<&str, CarmenError> {
    let is_comment = bytes.iter().find(|b| !b.is_ascii_whitespace()) == Some(&b'#');
    let bad = bytes.iter().enumerate().find(|&(_, &b)| {
        (b.is_ascii_control() && !matches!(b, b'\t' | b'\r' | 0x0c | 0x1a))
            || (!b.is_ascii() && !is_comment)
    });
    if let Some((at, &byte)) = bad {
        return Err(CarmenError::Binary {
            line,
            column: at + 1,
            byte,
        });
    }
    // A comment may be in any encoding, and nobody reads it.
    Ok(if is_comment {
        ""
    } else {
        std::str::from_utf8(bytes).unwrap_or("")
    })
}

struct Line<'a> {
    number: usize,
    text: &'a str,
}

impl<'a> Line<'a> {
    fn fields(&self, message: &'static str) -> Fields<'a> {
        let mut words = self.text.split_ascii_whitespace();
        words.next();
        Fields {
            line: self.number,
            text: self.text,
            message,
            field: 1,
            words,
        }
    }
}

/// The fields of one message, counted for the error message.
struct Fields<'a> {
    line: usize,
    text: &'a str,
    message: &'static str,
    field: usize,
    words: std::str::SplitAsciiWhitespace<'a>,
}

impl Fields<'_> {
    fn next(&mut self) -> Result<&str, CarmenError> {
        self.field += 1;
        self.words.next().ok_or_else(|| CarmenError::Count {
            line: self.line,
            message: self.message,
            announced: "as written".into(),
            expected: self.field,
            found: self.field - 1,
        })
    }

    fn expect_total(
        &self,
        expected: usize,
        announced: impl Fn() -> String,
    ) -> Result<(), CarmenError> {
        let found = self.text.split_ascii_whitespace().count();
        if found == expected {
            return Ok(());
        }
        Err(CarmenError::Count {
            line: self.line,
            message: self.message,
            announced: announced(),
            expected,
            found,
        })
    }

    fn bad(&self, found: &str, expected: &'static str) -> CarmenError {
        let shown: String = found.chars().take(24).collect();
        CarmenError::Field {
            line: self.line,
            field: self.field,
            message: self.message,
            found: shown,
            expected,
        }
    }

    fn number(&mut self) -> Result<f64, CarmenError> {
        let word = self.next()?.to_owned();
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(self.bad(&word, "a finite number")),
        }
    }

    fn range(&mut self) -> Result<f32, CarmenError> {
        self.field += 1;
        let Some(word) = self.words.next() else {
            self.field -= 1;
            return self.next().map(|_| 0.0);
        };
        match word.parse::<f32>() {
            Ok(range) if range.is_finite() && range >= 0.0 => Ok(range),
            _ => Err(self.bad(word, "a range in metres, finite and at least 0")),
        }
    }

    fn count_or_none(&mut self, expected: &'static str) -> Result<usize, CarmenError> {
        let word = self.next()?.to_owned();
        match word.parse::<usize>() {
            Ok(count) if count <= 100_000 => Ok(count),
            _ => Err(self.bad(&word, expected)),
        }
    }

    fn count(&mut self, expected: &'static str) -> Result<usize, CarmenError> {
        match self.count_or_none(expected)? {
            0 => Err(self.bad("0", expected)),
            count => Ok(count),
        }
    }

    fn pose(&mut self) -> Result<Pose2, CarmenError> {
        Ok(Pose2::new(self.number()?, self.number()?, self.number()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn flaser(ranges: &[f64], pose: (f64, f64, f64), seconds: f64) -> String {
        let words: Vec<_> = ranges.iter().map(|r| format!("{r:.2}")).collect();
        let (x, y, t) = pose;
        format!(
            "FLASER {} {} {x:.6} {y:.6} {t:.6} {x:.6} {y:.6} {t:.6} {seconds:.6} nohost {seconds:.6}\n",
            ranges.len(),
            words.join(" ")
        )
    }

    fn small_log() -> String {
        let mut text =
            String::from("# comment \u{e9}\nPARAM robot_frontlaser_offset 0.0 nohost 0\n");
        for i in 0..6 {
            let x = f64::from(i);
            text += &format!("ODOM {x} 0 0 0 0 0 {x}.5 nohost {x}.5\n");
            text += &flaser(&[1.0, 2.0, 81.83, 0.0], (x, 0.0, 0.1), 100.0 - x);
        }
        text
    }

    fn message(bytes: &[u8]) -> String {
        CarmenLog::parse(bytes).unwrap_err().to_string()
    }

    #[test]
    fn scans_come_sorted_by_ipc_time_with_their_odometry() {
        let log = CarmenLog::parse(small_log().as_bytes()).unwrap();
        assert_eq!(
            (log.scans.len(), log.odometry_messages, log.backward_stamps),
            (6, 6, 5)
        );
        assert!(
            log.scans
                .windows(2)
                .all(|w| w[0].ipc_seconds < w[1].ipc_seconds)
        );
        assert!((log.scans[0].odom_from_robot.x() - 5.0).abs() < 1e-12);
        assert!((log.duration() - 5.0).abs() < 1e-9);
        let scan = log.scan(&log.scans[1]);
        assert_eq!(scan.validate(), Ok(()));
        assert_eq!(scan.stamp, Stamp(1_000_000));
        assert_eq!(scan.ranges[1], 2.0);
        assert!(scan.ranges[2].is_infinite() && scan.ranges[3].is_nan());
        assert_eq!(
            log.params,
            [("robot_frontlaser_offset".to_owned(), "0.0".to_owned())]
        );
    }

    #[test]
    fn any_cut_into_chunks_gives_the_same_log() {
        let text = small_log().replace('\n', "\r\n");
        let whole = CarmenLog::parse(text.as_bytes()).unwrap();
        for size in [1, 2, 7, 100] {
            let mut reader = CarmenReader::default();
            for chunk in text.as_bytes().chunks(size) {
                reader.push(chunk).unwrap();
            }
            let log = reader.finish().unwrap();
            assert_eq!(
                (log.scans, log.readings),
                (whole.scans.clone(), whole.readings.clone())
            );
        }
    }

    #[test]
    fn half_circles_run_from_right_to_left() {
        for (beams, step, last) in [
            (180, 1.0, 89.0),
            (181, 1.0, 90.0),
            (360, 0.5, 89.5),
            (361, 0.5, 90.0),
            (1, 180.0, -90.0),
        ] {
            let fan = BeamFan::half_circle(beams);
            let degrees = |i: usize| (fan.first + i as f64 * fan.step).to_degrees();
            assert!((degrees(0) + 90.0).abs() < 1e-9);
            assert!((fan.step.to_degrees() - step).abs() < 1e-9, "{beams}");
            assert!((degrees(beams - 1) - last).abs() < 1e-9, "{beams}");
        }
    }

    #[test]
    fn laser_offset_is_the_difference_of_the_two_poses() {
        let line = "FLASER 1 2.0 -2.994295 8.292039 -3.120965 -3.034287 8.291214 -3.120965 1211.52 magnum 0.01\n";
        let log = CarmenLog::parse(line.as_bytes()).unwrap();
        let offset = log.scans[0].robot_from_sensor;
        assert!((offset.x() + 0.04).abs() < 1e-4 && offset.y().abs() < 1e-4);
        assert!(offset.heading().abs() < 1e-9);
    }

    #[test]
    fn robotlaser_says_its_own_fan_and_limit() {
        let line = "ROBOTLASER1 0 -1.5 3.0 1.5 30.0 0.01 0 3 1.0 2.0 30.0 0 0.1 0 0 0 0 0 0.2 0.1 1 1 0 7.5 host 0.1";
        let log = CarmenLog::parse(line.as_bytes()).unwrap();
        assert_eq!(log.laser, Laser::Robot1);
        let scan = log.scan(&log.scans[0]);
        assert_eq!(scan.bearings, [-1.5, 0.0, 1.5]);
        assert!(scan.ranges[2].is_infinite());
        assert!((scan.robot_from_sensor.x() - 0.1).abs() < 1e-12);
        assert!((log.scans[0].ipc_seconds - 7.5).abs() < 1e-12);
    }

    #[test]
    fn the_largest_reading_is_a_code_when_it_is_repeated() {
        let mut text = String::new();
        for i in 0..50 {
            text += &flaser(&[1.0, 2.0, 7.99, 8.0], (0.0, 0.0, 0.0), f64::from(i));
        }
        let log = CarmenLog::parse(text.as_bytes()).unwrap();
        assert!(log.no_return_from > 7.98 && log.no_return_from <= 8.0);
    }

    #[test]
    fn bad_files_are_told_what_where_and_what_was_expected() {
        let good = flaser(&[1.0, 2.0], (0.0, 0.0, 0.0), 1.0);
        assert!(message(b"").starts_with("the file is empty"));
        assert!(message(b" \n\n").starts_with("the file is empty"));
        let jpeg = message(b"\xff\xd8\xff\xe0\x00\x10JFIF\x00\x01");
        assert_eq!(
            jpeg,
            "line 1: byte 1 is 0xff, which is not text; expected a CARMEN log, one message per line"
        );
        assert!(message(b"hello\nworld\n").starts_with("no laser message in 2 lines"));
        let nan = message((good.clone() + &good.replace("2.00", "nan")).as_bytes());
        assert_eq!(
            nan,
            "line 2, field 4 of FLASER is \"nan\", expected a range in metres, finite and at least 0"
        );
        let short = message((good.replace("FLASER 2", "FLASER 3") + &good).as_bytes());
        assert_eq!(
            short,
            "line 1: FLASER of 3 readings needs 14 fields, found 13"
        );
        let cut = format!("{good}{}", &good[..good.len() / 2]);
        let cut = message(cut.as_bytes());
        assert!(
            cut.starts_with("line 2: the file is cut off within its last message"),
            "{cut}"
        );
        assert!(message(good.replace("2.00", "-2.00").as_bytes()).contains("at least 0"));
        let endless = vec![b'a'; MAX_LINE + 2];
        assert!(message(&endless).contains("longer than"));
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 1000, ..ProptestConfig::default() })]
        #[test]
        fn damaged_logs_never_panic(
            edits in proptest::collection::vec((0.0..1.0_f64, 0_u8..5, any::<u8>()), 1..12),
        ) {
            let mut bytes = small_log().into_bytes();
            for (place, kind, byte) in edits {
                let at = ((bytes.len() as f64 * place) as usize).min(bytes.len().saturating_sub(1));
                match kind {
                    0 => { bytes.truncate(at); }
                    1 => { if let Some(b) = bytes.get_mut(at) { *b = byte; } }
                    2 => { bytes.insert(at.min(bytes.len()), byte); }
                    3 => { if !bytes.is_empty() { bytes.remove(at); } }
                    _ => { let tail = bytes[at..].to_vec(); bytes.extend(tail); }
                }
            }
            match CarmenLog::parse(&bytes) {
                Ok(log) => for scan in &log.scans { prop_assert_eq!(log.scan(scan).validate(), Ok(())); },
                Err(error) => prop_assert!(!error.to_string().is_empty()),
            }
        }
    }
}
