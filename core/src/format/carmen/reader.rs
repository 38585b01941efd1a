//! Reads a log as its bytes arrive.

use super::fields::{Fields, check_text};
use super::order::in_order;
use super::{BeamFan, CarmenError, CarmenLog, CarmenScan, Laser, SWEEP};
use crate::format::LeftOut;
use crate::format::field_error::read;

/// A line longer than this is not a line of a log.
pub(super) const MAX_LINE: usize = 1 << 20;

/// Readings at or above this mean that nothing came back, m: the SICK's codes for it decode to
/// 81.83 and 81.91.
const ALWAYS_NO_RETURN: f32 = 80.0;

/// The messages that are read.
const MESSAGES: [&str; 5] = ["FLASER", "RLASER", "ROBOTLASER1", "ODOM", "PARAM"];

/// Reads a log from chunks of bytes.
#[derive(Clone, Debug, Default)]
pub struct CarmenReader {
    unfinished: Vec<u8>,
    line: usize,
    lasers: [Vec<CarmenScan>; 3],
    readings: Vec<f32>,
    params: Vec<(String, String)>,
    left_out: LeftOut,
    /// For the scans that follow, see [`CarmenScan::sweep`].
    sweep: f64,
    anything: bool,
}

impl CarmenReader {
    /// Takes the next bytes.
    ///
    /// # Errors   [`CarmenError`]; the reader cannot be used after one.
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
            let (line, limit) = (self.line + 1, MAX_LINE);
            check_text(&self.unfinished, line)?;
            return Err(CarmenError::LineTooLong { line, limit });
        }
        Ok(())
    }

    /// Puts what was read in order.
    ///
    /// # Errors   [`CarmenError`]: a last line cut off, no laser message, no usable one, or an
    /// empty file.
    pub fn finish(mut self) -> Result<CarmenLog, CarmenError> {
        let last = std::mem::take(&mut self.unfinished);
        if !last.is_empty() {
            self.check_name(&last)?;
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
        let kinds = [Laser::Front, Laser::Rear, Laser::Robot1];
        // Of lasers with equally many messages the first wins: the front laser.
        let lasers = kinds.into_iter().zip(self.lasers).rev();
        let most = lasers.max_by_key(|(_, scans)| scans.len());
        let (laser, scans) = most.unwrap_or((Laser::Front, vec![]));
        if scans.is_empty() {
            if let Some(first) = self.left_out.lines.first {
                return Err(first.into());
            }
            return Err(CarmenError::NoLaser { lines: self.line });
        }
        Ok(CarmenLog {
            laser,
            no_return_from: no_return_from(&self.readings),
            scans: in_order(scans, &self.readings),
            params: self.params,
            left_out: self.left_out,
            readings: self.readings,
        })
    }

    /// The last line has no line end, so it may be cut off within the name of its message. A line
    /// with any other name is ignored.
    fn check_name(&self, last: &[u8]) -> Result<(), CarmenError> {
        let is_cut = |name: &&str| name.len() > last.len() && name.as_bytes().starts_with(last);
        match MESSAGES.into_iter().find(is_cut) {
            None => Ok(()),
            Some(name) => Err(CarmenError::CutOff {
                line: self.line + 1,
                reason: format!("the line is \"{}\"", &name[..last.len()]),
            }),
        }
    }

    fn read_line(&mut self, bytes: &[u8]) -> Result<(), CarmenError> {
        self.line += 1;
        let text = check_text(bytes, self.line)?;
        let mut words = text.split_ascii_whitespace();
        let Some(name) = words.next() else {
            return Ok(());
        };
        self.anything = true;
        let fields = |message| Fields::of(self.line, text, message);
        match name {
            "FLASER" => self.read_plain_laser(fields("FLASER"), 0),
            "RLASER" => self.read_plain_laser(fields("RLASER"), 1),
            "ROBOTLASER1" => self.read_robot_laser(fields("ROBOTLASER1")),
            "ODOM" => self.read_odometry(fields("ODOM")),
            "PARAM" => {
                match (words.next(), words.next()) {
                    (Some(SWEEP), value) => self.sweep = sweep(self.line, value)?,
                    (Some(name), Some(value)) => {
                        self.params.push((name.to_owned(), value.to_owned()));
                    }
                    _ => {}
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// `ODOM x y θ tv rv acceleration ipc_timestamp host logger_timestamp`: not used.
    fn read_odometry(&mut self, mut fields: Fields) -> Result<(), CarmenError> {
        fields.pose()?;
        fields.skip(3)?;
        fields.seconds()?;
        fields.finish(&mut self.left_out);
        Ok(())
    }

    fn read_plain_laser(&mut self, mut fields: Fields, slot: usize) -> Result<(), CarmenError> {
        let beams = fields.count(1, "a number of readings from 1 to 100000")?;
        fields.expect_total(beams + 11, format_args!("of {beams} readings"))?;
        let start = self.read_ranges(&mut fields, beams)?;
        let map_from_laser = fields.pose()?;
        let odom_from_robot = fields.pose()?;
        let seconds = fields.seconds()?;
        if !fields.finish(&mut self.left_out) {
            self.readings.truncate(start);
            return Ok(());
        }
        self.lasers[slot].push(CarmenScan {
            ipc_seconds: seconds,
            seconds,
            odom_from_robot,
            robot_from_sensor: odom_from_robot.delta_to(&map_from_laser),
            fan: BeamFan::half_circle(beams),
            max_range: f32::INFINITY,
            sweep: self.sweep,
            start,
            beams,
        });
        Ok(())
    }

    /// `ROBOTLASER1 type start fov step max_range accuracy remission_mode n ranges… m remissions…
    /// laser_pose robot_pose tv rv forward_safety side_safety turn_axis ipc_timestamp host
    /// logger_timestamp`.
    fn read_robot_laser(&mut self, mut fields: Fields) -> Result<(), CarmenError> {
        fields.skip(1)?;
        let first = fields.angle()?;
        fields.skip(1)?;
        let step = fields.angle()?;
        let limit = Some(fields.number()? as f32).filter(|limit| *limit > 0.0);
        fields.skip(2)?;
        let beams = fields.count(1, "a number of readings from 1 to 100000")?;
        let start = self.read_ranges(&mut fields, beams)?;
        let remissions = fields.count(0, "a number of remissions from 0 to 100000")?;
        let announced = format_args!("of {beams} readings and {remissions} remissions");
        fields.expect_total(9 + beams + 1 + remissions + 14, announced)?;
        fields.skip(remissions)?;
        let map_from_laser = fields.pose()?;
        let odom_from_robot = fields.pose()?;
        fields.skip(5)?;
        let seconds = fields.seconds()?;
        if !fields.finish(&mut self.left_out) {
            self.readings.truncate(start);
            return Ok(());
        }
        self.lasers[2].push(CarmenScan {
            ipc_seconds: seconds,
            seconds,
            odom_from_robot,
            robot_from_sensor: odom_from_robot.delta_to(&map_from_laser),
            fan: BeamFan { first, step },
            max_range: limit.unwrap_or(f32::INFINITY),
            sweep: self.sweep,
            start,
            beams,
        });
        Ok(())
    }

    fn read_ranges(&mut self, fields: &mut Fields, beams: usize) -> Result<usize, CarmenError> {
        let start = self.readings.len();
        for _ in 0..beams {
            self.readings.push(fields.range()?);
        }
        Ok(start)
    }
}

/// The duration of the sweeps that follow, s.
fn sweep(line: usize, value: Option<&str>) -> Result<f64, CarmenError> {
    let field = format_args!("the value of PARAM {SWEEP}");
    let expected = "the seconds of a sweep, within ±1000";
    let fits = |n: &f64| n.abs() <= 1e3;
    Ok(read(
        line,
        field,
        value.unwrap_or_default(),
        expected,
        fits,
    )?)
}

/// The largest reading means "no return" where at least one reading in 500 has it (81.83 in Intel,
/// 81.91 in Freiburg; cheaper lasers report 8 or 30); readings of 80 m and above always do.
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
