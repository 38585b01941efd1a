//! Logs of a robot with four rangers (CSV): its pose by odometry and the range of each ranger.
//!
//! In: bytes, in chunks of any size. Out: a [`RangerLog`].
//!
//! The first line names the columns: `t_s`, `x_m`, `y_m`, `yaw_rad` and `range0` to `range3`, in
//! any order; others, such as a ranger that looks up, are ignored. Each further line is one reading
//! of all four rangers, which point right, ahead, left and back. Units are seconds, metres and
//! radians; an empty range, `nan`, 0 and negative values mean "not measured".
//!
//! An infinite range is not measured either, and a line without a time or a pose is left out; both
//! are reported ([`RangerLog::left_out`]).
//!
//! The order of the rangers was verified on a recorded log, by how ranges change as the robot
//! drives.

use std::f64::consts::{FRAC_PI_2, PI};

use super::field_error::read;
use super::text_log::{Lines, TextLog, TextLogError};
use super::{FieldError, LeftOut, Tally};
use crate::geom::Pose2;
use crate::robot::{Scan, Stamp};

/// Directions of the rangers, rad: right, ahead, left, back.
pub const BEARINGS: [f64; 4] = [-FRAC_PI_2, 0.0, FRAC_PI_2, PI];
/// σ of a range, m: a VL53L1X in normal light.
const SIGMA: f32 = 0.02;
/// σ of a direction, rad: an echo may come from anywhere in a cone 27° wide; half of it over √3.
const BEARING_SIGMA: f64 = 0.136;
const COLUMNS: [&str; 8] = [
    "t_s", "x_m", "y_m", "yaw_rad", "range0", "range1", "range2", "range3",
];
const EXPECTED: &str = "a log of four rangers, with the columns t_s, x_m, y_m, yaw_rad and range0 \
    to range3";
/// Times, coordinates and angles beyond this are refused: sums and squares of them stay finite.
const MOST: f64 = 1e9;

/// One line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangerScan {
    /// `t_s`, as it stands in the log, s.
    pub seconds: f64,
    /// Pose of the robot in the frame of the odometry.
    pub odom_from_robot: Pose2,
    /// Readings in the order of [`BEARINGS`], m; NaN where there is none.
    pub ranges: [f32; 4],
}

/// A log of four rangers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RangerLog {
    /// Its lines, in the order of time.
    pub scans: Vec<RangerScan>,
    /// What the reader left out.
    pub left_out: LeftOut,
}

/// Reads a log of four rangers from chunks of bytes.
#[derive(Clone, Debug)]
pub struct RangerLogReader {
    lines: Lines,
    table: Table,
}

#[derive(Clone, Debug, Default)]
struct Table {
    header: Option<Header>,
    log: RangerLog,
}

/// The positions of the columns, and how many there are.
#[derive(Clone, Copy, Debug)]
struct Header {
    places: [usize; COLUMNS.len()],
    columns: usize,
}

impl Default for RangerLogReader {
    fn default() -> Self {
        Self {
            lines: Lines::new(EXPECTED),
            table: Table::default(),
        }
    }
}

impl RangerLogReader {
    /// Takes the next bytes.
    ///
    /// # Errors   [`TextLogError`], with line and field; the reader cannot be used after one.
    pub fn push(&mut self, bytes: &[u8]) -> Result<(), TextLogError> {
        self.lines.push(bytes, &mut self.table)
    }

    /// Ends the log.
    ///
    /// # Errors   [`TextLogError`]: a last line that is cut off, or no usable line.
    pub fn finish(mut self) -> Result<RangerLog, TextLogError> {
        self.lines.finish(&mut self.table)?;
        Ok(self.table.log)
    }
}

impl RangerLog {
    /// Seconds from the first line to the last.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.scans.last().map_or(0.0, |last| self.since_first(last))
    }

    /// Whether the odometry ever moved.
    #[must_use]
    pub fn has_odometry(&self) -> bool {
        let poses = self.scans.iter().map(|scan| scan.odom_from_robot);
        poses.clone().zip(poses.skip(1)).any(|(a, b)| a != b)
    }

    /// Whether any range was measured.
    pub(crate) fn has_ranges(&self) -> bool {
        let mut ranges = self.scans.iter().flat_map(|scan| scan.ranges);
        ranges.any(|range| range > 0.0)
    }

    /// Stamp of a line: time since the first.
    #[must_use]
    pub fn stamp(&self, scan: &RangerScan) -> Stamp {
        Stamp::from_seconds(self.since_first(scan))
    }

    /// A line as a scan of four beams, robot frame. Readings of `reach` (m) and more mean that
    /// nothing nearer sent an echo.
    #[must_use]
    pub fn scan(&self, scan: &RangerScan, reach: f64) -> Scan {
        let range = |range: &f32| match *range {
            range if f64::from(range) >= reach => f32::INFINITY,
            range => range,
        };
        Scan {
            stamp: self.stamp(scan),
            robot_from_sensor: Pose2::identity(),
            bearings: BEARINGS.into(),
            ranges: scan.ranges.iter().map(range).collect(),
            sigmas: vec![SIGMA; BEARINGS.len()],
            bearing_sigma: BEARING_SIGMA,
            max_range: reach,
            sweep: 0.0,
            qualities: vec![],
        }
    }

    fn since_first(&self, scan: &RangerScan) -> f64 {
        let first = self.scans.first().map_or(0.0, |first| first.seconds);
        scan.seconds - first
    }
}

impl TextLog for Table {
    fn take(&mut self, line: usize, text: &str) -> Result<(), FieldError> {
        match self.header {
            None => self.header = Some(Header::of(line, text)?),
            Some(header) => {
                let Some(scan) = header.scan(line, text, &mut self.log.left_out)? else {
                    return Ok(());
                };
                let last = self.log.scans.last();
                if let Some(last) = last.filter(|last| scan.seconds < last.seconds) {
                    let found = scan.seconds.to_string();
                    let expected = format!("a time not before {}", last.seconds);
                    return Err(FieldError::new(line, "t_s", &found, expected));
                }
                self.log.scans.push(scan);
            }
        }
        Ok(())
    }

    fn has_scans(&self) -> bool {
        !self.log.scans.is_empty()
    }

    fn left_out(&self) -> &LeftOut {
        &self.log.left_out
    }
}

impl Header {
    fn of(line: usize, text: &str) -> Result<Self, FieldError> {
        let names: Vec<&str> = text.split(',').map(str::trim).collect();
        let mut places = [0; COLUMNS.len()];
        for (place, column) in places.iter_mut().zip(COLUMNS) {
            let Some(at) = names.iter().position(|name| *name == column) else {
                let expected = format!("the names of columns, `{column}` among them");
                return Err(FieldError::new(line, "the head", text.trim(), expected));
            };
            *place = at;
        }
        Ok(Self {
            places,
            columns: names.len(),
        })
    }

    /// `None` where the line was left out.
    fn scan(
        &self,
        line: usize,
        text: &str,
        left_out: &mut LeftOut,
    ) -> Result<Option<RangerScan>, FieldError> {
        let words: Vec<&str> = text.split(',').map(str::trim).collect();
        if words.len() != self.columns {
            let expected = format_args!("{}, as in the head", self.columns);
            return Err(FieldError::count(line, words.len(), expected));
        }
        let word = |column: usize| words.get(self.places[column]).copied().unwrap_or_default();
        let expected = [
            "a time in seconds",
            "metres",
            "metres",
            "an angle in radians",
        ];
        let mut numbers = [0.0_f64; 4];
        let mut none = Tally::default();
        for (column, (number, expected)) in numbers.iter_mut().zip(expected).enumerate() {
            let (name, word) = (COLUMNS[column], word(column));
            *number = read(line, name, word, expected, |_| true)?;
            // NaN fails the comparison.
            if number.is_nan() || number.abs() > 10.0 * MOST {
                none.add(|| {
                    FieldError::new(line, name, word, format_args!("{expected}, within ±1e10"))
                });
            }
        }
        let mut ranges = [f32::NAN; 4];
        let mut infinite = Tally::default();
        for (column, range) in (4..).zip(&mut ranges) {
            let (name, word) = (COLUMNS[column], word(column));
            if word.is_empty() {
                continue;
            }
            let expected = "a range in metres, or nan";
            let read: f32 = read(line, name, word, expected, |_| true)?;
            match read.is_infinite() {
                true => infinite.add(|| FieldError::new(line, name, word, expected)),
                false if read > 0.0 => *range = read,
                false => {}
            }
        }
        if none.count > 0 {
            left_out.lines.append(Tally { count: 1, ..none });
            return Ok(None);
        }
        left_out.ranges.append(infinite);
        let [seconds, x, y, yaw] = numbers;
        Ok(Some(RangerScan {
            seconds,
            odom_from_robot: Pose2::new(x, y, yaw),
            ranges,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Length;

    fn parse(text: &str) -> Result<RangerLog, TextLogError> {
        let mut reader = RangerLogReader::default();
        reader.push(text.as_bytes())?;
        reader.finish()
    }

    #[test]
    fn columns_stand_in_any_order_and_others_are_passed_over() {
        let log = parse(
            "# drive\nrange3,up,t_s, x_m ,y_m,yaw_rad,range0,range1,range2\r\n\
             4.0,9,10.5,1,2,0.5,1.0,2.0,nan\n2.5,,10.75,1,2,0.75,,0,-1",
        )
        .unwrap();
        assert_eq!(log.scans[0].seconds, 10.5);
        assert_eq!(log.scans[0].odom_from_robot, Pose2::new(1.0, 2.0, 0.5));
        assert!((log.duration() - 0.25).abs() < 1e-12 && log.has_odometry());
        let scan = log.scan(&log.scans[0], 2.0);
        scan.validate().unwrap();
        assert_eq!(scan.ranges[0], 1.0);
        // Readings beyond the rangers' reach are not believed, nor are missing ones.
        assert_eq!(scan.ranges[1], f32::INFINITY);
        assert!(scan.ranges[2].is_nan());
        assert_eq!(scan.ranges[3], f32::INFINITY);
        let farther = log.scan(&log.scans[0], 5.0);
        assert_eq!((farther.ranges[1], farther.ranges[3]), (2.0, 4.0));
        let second = log.scan(&log.scans[1], 5.0);
        assert!(second.ranges[..3].iter().all(|range| range.is_nan()));
        assert_eq!(second.stamp, Stamp(250_000));
    }

    #[test]
    fn what_is_wrong_is_named_with_line_and_field() {
        let head = "t_s,x_m,y_m,yaw_rad,range0,range1,range2,range3\n";
        let check = |text: &str, expected: &str| {
            let error = parse(text).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
        };
        check(
            "t_s,x_m,y_m\n",
            "line 1: the head is `t_s,x_m,y_m`, expected the names",
        );
        check(
            &format!("{head}1,2\n"),
            "line 2: the number of fields is `2`, expected 8",
        );
        let log = |row: &str| format!("{head}\n5,0,0,0,1,1,1,1\n{row}\n");
        check(
            &log("6,0,x,0,1,1,1,1"),
            "line 4: y_m is `x`, expected metres",
        );
        check(&log("6,0,0,0,1,far,1,1"), "line 4: range1 is `far`");
        check(
            &log("4,0,0,0,1,1,1,1"),
            "line 4: t_s is `4`, expected a time not before 5",
        );
        check(&format!("{head}1,2,3"), "line 2: the file is cut off");
        check(head, "no scan in 1 lines");
        check(
            &format!("{head}1,2,inf,0,1,1,1,1\n"),
            "line 2: y_m is `inf`, expected metres, within ±1e10",
        );
    }

    #[test]
    fn what_is_left_out_costs_only_itself() {
        let head = "t_s,x_m,y_m,yaw_rad,range0,range1,range2,range3\n";
        let log = |rows: &str| parse(&format!("{head}5,0,0,0,1,1,1,1\n{rows}")).unwrap();
        let damaged = log("6,0,nan,inf,1,1,inf,1\nnan,0,0,0,1,1,1,1\n7,0,1,0,1,-inf,inf,-1\n");
        let told = damaged.left_out.sentences();
        assert!(told[0].starts_with("2 ranges are no"), "{told:?}");
        assert!(told[0].contains("line 5: range1 is `-inf`"), "{told:?}");
        assert!(told[1].starts_with("2 lines cannot"), "{told:?}");
        assert!(told[1].contains("line 3: y_m is `nan`"), "{told:?}");
        let last = damaged.scan(&damaged.scans[1], 3.0);
        assert_eq!(last.ranges[0], 1.0);
        assert!(last.ranges[1..].iter().all(|range| range.is_nan()));
        assert_eq!(damaged.scans.len(), 2);
        assert_eq!(log("").left_out, LeftOut::default());
    }

    #[test]
    fn a_recorded_log_is_read_whole() {
        let Some(bytes) = crate::format::recorded("tof/olsson-3loop.csv") else {
            return;
        };
        let mut reader = RangerLogReader::default();
        for piece in bytes.chunks(1000) {
            reader.push(piece).unwrap();
        }
        let log = reader.finish().unwrap();
        assert_eq!(log.scans.len(), 3818);
        assert!(
            (log.duration() - 381.4457).abs() < 1e-3,
            "{}",
            log.duration()
        );
        let steps = log.scans.windows(2);
        let way: f64 = steps
            .map(|pair| {
                let [a, b] = [pair[0], pair[1]].map(|scan| scan.odom_from_robot.position());
                (b - a).length()
            })
            .sum();
        assert!((way - 295.2427).abs() < 1e-3, "{way}");
    }
}
