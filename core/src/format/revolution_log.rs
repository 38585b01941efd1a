//! Revolution logs (`.txt`): one revolution of an RPLIDAR per line, sample by sample, as Pilch's
//! program reads them.
//!
//! In: bytes, in chunks of any size. Out: a [`RevolutionLog`]. And back: scans become a log
//! ([`RevolutionLog::push`]), and a log becomes lines of text ([`RevolutionLog::lines`]).
//!
//! A line is samples `__t:1.34_d:01495.75_q:29|` and then `-END-`:
//!
//! | part | meaning |
//! |---|---|
//! | first `_` | `S` in its place: the sample that begins a turn, by the sensor's own flag |
//! | `t` | angle, degrees, 0 to 360, clockwise from ahead |
//! | `d` | distance, mm, less than 100 000; 0 where nothing was measured |
//! | `q` | quality of the echo, 0 to 63; 0 where nothing was measured |
//!
//! The file holds neither time nor anything about a robot. Lines are taken to follow each other
//! without a pause, at a rate that is given beside the file (setting `log.revolutions`); the
//! samples of a line are taken to be evenly spaced in time, with gaps for those that were lost. The
//! flag does not divide the log, because a bit may be damaged: each line is one revolution. No
//! reading means that a beam met nothing. A distance that is negative or not a number counts as not
//! measured, and a sample whose angle is not a number as lost; both are reported
//! (`RevolutionLog::left_out`).
//!
//! Source: Pilch 2016 §3.4.1, (3.3). It does not say which way angles run: they are taken to be
//! those of the sensor, as its program `ultra_simple` prints them; degrees, mm and quality too
//! (SLAMTEC interface protocol; `wire::rplidar` reads the same from the wire).

use std::f64::consts::TAU;

use super::carmen::CarmenLog;
use super::field_error::read;
use super::left_out::{is_no_range, is_not_finite};
use super::rover_log::{SIGMA, SIGMA_PER_METRE};
use super::text_log::{Lines, TextLog, TextLogError};
use super::{FieldError, LeftOut, Tally};
use crate::geom::{Pose2, wrap};
use crate::robot::{Place, Scan, Stamp, places_of_revolution};

/// Revolutions per second of the source's sensor as delivered, Hz (Pilch 2016 §2.1).
pub const NOMINAL_RATE: f64 = 5.5;
/// The highest quality.
pub const MOST_QUALITY: u8 = 63;
/// Lines with more samples are refused: no lidar of this kind takes as many. The limit ensures that
/// whatever was read can be written in a line that is read again.
pub const MOST_SAMPLES: usize = 8192;
/// Distances must be less than this, mm: five digits.
const DISTANCE_END: f32 = 100_000.0;
/// σ of a direction, rad: that of the sensor; the file resolves a sixth of it.
const BEARING_SIGMA: f64 = 0.001;
/// A line whose first angle is above this began a little before the revolution did, rad.
const BEFORE_AHEAD: f64 = 350.0 * TAU / 360.0;
/// How a line begins, depending on the flag of its first sample.
const BEGINNINGS: [&[u8]; 2] = [b"__t:", b"S_t:"];
const END: &str = "-END-";
const EXPECTED: &str = "a log of revolutions, `__t:DEGREES_d:MILLIMETRES_q:QUALITY|` for each \
    sample and `-END-` at the end of each line";

/// One reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Whether the sensor says that a revolution begins with this sample.
    pub starts: bool,
    /// Angle, degrees, clockwise from ahead, 0 to 360.
    pub degrees: f32,
    /// Distance, mm, at least 0 and less than 100 000; 0 where nothing was measured.
    pub millimetres: f32,
    /// Quality, 0 to [`MOST_QUALITY`]; 0 where nothing was measured.
    pub quality: u8,
}

/// A log of revolutions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RevolutionLog {
    /// What the reader left out.
    pub left_out: LeftOut,
    samples: Vec<Sample>,
    /// For each revolution, the end of its samples.
    ends: Vec<usize>,
}

/// Reads a log of revolutions from chunks of bytes.
#[derive(Clone, Debug)]
pub struct RevolutionLogReader {
    lines: Lines,
    log: RevolutionLog,
}

impl Default for RevolutionLogReader {
    fn default() -> Self {
        Self {
            lines: Lines::new(EXPECTED),
            log: RevolutionLog::default(),
        }
    }
}

impl RevolutionLogReader {
    /// Takes the next bytes.
    ///
    /// # Errors   [`TextLogError`], with line, sample and field; the reader cannot be used after
    /// one.
    pub fn push(&mut self, bytes: &[u8]) -> Result<(), TextLogError> {
        self.lines.push(bytes, &mut self.log)
    }

    /// Ends the log.
    ///
    /// # Errors   [`TextLogError`]: a last line that is cut off, or no usable line.
    pub fn finish(mut self) -> Result<RevolutionLog, TextLogError> {
        self.lines.finish(&mut self.log)?;
        Ok(self.log)
    }
}

/// Whether a line that begins with `word` belongs to a log of revolutions.
pub(crate) fn is_beginning(word: &[u8]) -> bool {
    BEGINNINGS.iter().any(|begins| word.starts_with(begins))
}

impl RevolutionLog {
    /// Number of revolutions.
    #[must_use]
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there is no revolution.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The samples of a revolution, in the order in which they were taken.
    #[must_use]
    pub fn samples(&self, index: usize) -> Option<&[Sample]> {
        let start = match index.checked_sub(1) {
            Some(before) => *self.ends.get(before)?,
            None => 0,
        };
        self.samples.get(start..*self.ends.get(index)?)
    }

    /// Seconds from the beginning of the first revolution to the end of the last, at `rate`
    /// revolutions per second.
    #[must_use]
    pub fn duration(&self, rate: f64) -> f64 {
        self.len() as f64 / rate
    }

    /// Whether any range was measured.
    pub(crate) fn has_ranges(&self) -> bool {
        self.samples.iter().any(|sample| !sample.range().is_nan())
    }

    /// A revolution as a scan, robot frame, with the sensor at the robot's centre; `rate` is the
    /// number of revolutions per second, Hz, more than 0. The revolution ends at its stamp, which
    /// counts from the beginning of the log.
    #[must_use]
    pub fn scan(&self, index: usize, rate: f64) -> Option<Scan> {
        let samples = self.samples(index)?;
        let turned = turned_of(samples);
        let places = places_of_revolution(&turned);
        let period = 1.0 / rate;
        let mut scan = Scan {
            stamp: Stamp::from_seconds((index + 1) as f64 * period),
            robot_from_sensor: Pose2::identity(),
            bearings: Vec::with_capacity(places.len()),
            ranges: Vec::with_capacity(places.len()),
            sigmas: Vec::with_capacity(places.len()),
            qualities: Vec::with_capacity(places.len()),
            bearing_sigma: BEARING_SIGMA,
            max_range: 1e-3 * f64::from(DISTANCE_END),
            sweep: period * (places.len() - 1) as f64 / places.len() as f64,
        };
        for place in places {
            let (turned, sample) = match place {
                Place::Taken(i) => (turned.get(i).copied()?, samples.get(i)),
                Place::Lost(turned) => (turned, None),
            };
            let range = sample.map_or(f32::NAN, Sample::range);
            let seen = if range.is_nan() { 0.0 } else { range };
            scan.bearings.push(wrap(-turned));
            scan.ranges.push(range);
            let sigma = SIGMA + SIGMA_PER_METRE * f64::from(seen);
            scan.sigmas.push(sigma as f32);
            let quality = sample.filter(|_| !range.is_nan()).map_or(0, |s| s.quality);
            scan.qualities.push(quality);
        }
        Some(scan)
    }

    fn take_samples(
        &mut self,
        line: usize,
        text: &str,
        none: &mut Tally,
    ) -> Result<(), FieldError> {
        let (mut rest, mut count) = (text, 0);
        while let Some((sample, behind)) = rest.split_once('|') {
            count += 1;
            if count > MOST_SAMPLES {
                break;
            }
            self.samples
                .extend(Sample::read(line, count, sample, none)?);
            rest = behind;
        }
        if !(1..=MOST_SAMPLES).contains(&count) {
            let found = match count {
                0 => "0".to_owned(),
                _ => format!("more than {MOST_SAMPLES}"),
            };
            let expected =
                format_args!("1 to {MOST_SAMPLES}, each `__t:DEGREES_d:MILLIMETRES_q:QUALITY|`");
            return Err(FieldError::new(
                line,
                "the number of samples",
                &found,
                expected,
            ));
        }
        match rest.trim() {
            END => Ok(()),
            other => {
                let field = format_args!("what follows sample {count}");
                let expected = format_args!("`{END}`, or one more sample that ends with `|`");
                Err(FieldError::new(line, field, other, expected))
            }
        }
    }
}

impl TextLog for RevolutionLog {
    fn take(&mut self, line: usize, text: &str) -> Result<(), FieldError> {
        let before = self.samples.len();
        let mut none = Tally::default();
        if let Err(error) = self.take_samples(line, text, &mut none) {
            self.samples.truncate(before);
            return Err(error);
        }
        if self.samples.len() == before {
            // No angle of the whole revolution is known.
            self.left_out.lines.append(Tally { count: 1, ..none });
            return Ok(());
        }
        self.left_out.ranges.append(none);
        self.ends.push(self.samples.len());
        Ok(())
    }

    fn has_scans(&self) -> bool {
        !self.is_empty()
    }

    fn left_out(&self) -> &LeftOut {
        &self.left_out
    }
}

impl Sample {
    /// `None` if the angle is not a number.
    fn read(
        line: usize,
        number: usize,
        text: &str,
        none: &mut Tally,
    ) -> Result<Option<Self>, FieldError> {
        let text = text.trim();
        let Some([starts, t, d, q]) = parts(text) else {
            let expected = "`__t:DEGREES_d:MILLIMETRES_q:QUALITY`, or S for the first `_`";
            let field = format_args!("sample {number}");
            return Err(FieldError::new(line, field, text, expected));
        };
        let field = |name| format!("{name} of sample {number}");
        let is_angle = |t: &f32| (0.0..=360.0).contains(t);
        let is_distance = |d: &f32| (0.0..DISTANCE_END).contains(d);
        let is_quality = |q: &u8| *q <= MOST_QUALITY;
        let angle = read(line, field("t"), t, "degrees, 0 to 360", is_angle);
        let degrees = match angle {
            Err(error) if is_not_finite(t) => {
                none.add(|| error);
                return Ok(None);
            }
            other => other?,
        };
        let expected = "millimetres, at least 0 and less than 100000";
        let distance = read(line, field("d"), d, expected, is_distance);
        let quality = read(line, field("q"), q, "a whole number, 0 to 63", is_quality)?;
        let (millimetres, quality) = match distance {
            Err(error) if is_no_range(d) => {
                none.add(|| error);
                (0.0, 0)
            }
            other => (other?, quality),
        };
        Ok(Some(Self {
            starts: starts == "S",
            // Removes the sign of a negative zero.
            degrees: degrees.abs(),
            millimetres: millimetres.abs(),
            quality,
        }))
    }

    /// Range, m; NaN where nothing was measured.
    fn range(&self) -> f32 {
        match self.millimetres > 0.0 && self.quality > 0 {
            true => 1e-3 * self.millimetres,
            false => f32::NAN,
        }
    }
}

/// Flag, angle, distance and quality of a sample's text.
fn parts(text: &str) -> Option<[&str; 4]> {
    let (starts, rest) = text.split_at_checked(1)?;
    let rest = rest.strip_prefix("_t:")?;
    let (t, rest) = rest.split_once("_d:")?;
    let (d, q) = rest.split_once("_q:")?;
    matches!(starts, "_" | "S").then(|| [starts, t.trim(), d.trim(), q.trim()])
}

/// How far the sensor had turned at each sample of a line, rad, from ahead.
fn turned_of(samples: &[Sample]) -> Vec<f64> {
    let mut last: Option<f64> = None;
    let turned = samples.iter().map(|sample| {
        let angle = f64::from(sample.degrees).to_radians();
        let turned = match last {
            Some(last) => last + wrap(angle - last),
            None if angle > BEFORE_AHEAD => angle - TAU,
            None => angle,
        };
        last = Some(turned);
        turned
    });
    turned.collect()
}

// Writing.

impl RevolutionLog {
    /// The scans of a CARMEN log; its odometry and stamps are lost, because the format has no place
    /// for them.
    #[must_use]
    pub fn of_carmen(log: &CarmenLog) -> Self {
        let mut revolutions = Self::default();
        for scan in &log.scans {
            revolutions.push(&log.scan(scan));
        }
        revolutions
    }

    /// Adds a scan as the next revolution. A scan without beams is ignored, and so are beams beyond
    /// the first [`MOST_SAMPLES`].
    ///
    /// Angles are rounded to 0.01° and distances to 0.01 mm. Beams that met nothing, or ended
    /// farther away than the format can express, are written as not measured. The quality is
    /// limited to [`MOST_QUALITY`]; it is also that value if the sensor reports none.
    pub fn push(&mut self, scan: &Scan) {
        let columns = scan.bearings.iter().zip(&scan.ranges).enumerate();
        let samples = columns.take(MOST_SAMPLES).map(|(beam, (bearing, range))| {
            let degrees = (-bearing.to_degrees()).rem_euclid(360.0);
            let millimetres = hundredths(1e3 * f64::from(*range));
            let is_seen = millimetres > 0.0 && millimetres < DISTANCE_END;
            let quality = scan.quality(beam).unwrap_or(MOST_QUALITY);
            Sample {
                starts: beam == 0,
                degrees: match hundredths(degrees) {
                    degrees if degrees < 360.0 => degrees,
                    _ => 0.0,
                },
                millimetres: if is_seen { millimetres } else { 0.0 },
                quality: if is_seen {
                    quality.clamp(1, MOST_QUALITY)
                } else {
                    0
                },
            }
        });
        self.samples.extend(samples);
        if self.ends.last().copied().unwrap_or(0) < self.samples.len() {
            self.ends.push(self.samples.len());
        }
    }

    /// The lines of the file, each with its line end. Numbers have two decimals, or as many as they
    /// need to be read back to the bit.
    pub fn lines(&self) -> impl Iterator<Item = String> {
        let revolutions = (0..self.len()).filter_map(|index| self.samples(index));
        revolutions.map(|samples| {
            let samples: String = samples.iter().map(Sample::text).collect();
            format!("{samples}{END}\n")
        })
    }

    /// The text of the file.
    #[must_use]
    pub fn write(&self) -> String {
        self.lines().collect()
    }
}

impl Sample {
    fn text(&self) -> String {
        let first = if self.starts { 'S' } else { '_' };
        let (degrees, millimetres) = (text(self.degrees), text(self.millimetres));
        format!(
            "{first}_t:{degrees}_d:{millimetres:0>8}_q:{}|",
            self.quality
        )
    }
}

fn hundredths(value: f64) -> f32 {
    ((100.0 * value).round() / 100.0) as f32
}

fn text(value: f32) -> String {
    let shortest = value.to_string();
    match shortest.split_once('.') {
        Some((_, behind)) if behind.len() >= 2 => shortest,
        _ => format!("{value:.2}"),
    }
}

#[cfg(test)]
mod tests;
