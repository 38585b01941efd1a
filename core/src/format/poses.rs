//! Poses over time from a file of text: TUM trajectories, and tables with a header (CSV).
//!
//! In: bytes. Out: [`PosesFile`]: stamped poses in the order of time, m and rad.
//!
//! 1. The first line with content decides. Eight numbers are a line of TUM,
//!    `seconds x y z qx qy qz qw`. Names are a header, which may stand in a comment
//!    (`# time, x, y, yaw`).
//! 2. Columns are known by their names, in any order: a time, `x`, `y`, and either a heading or a
//!    quaternion. Others are ignored. Fields are separated by tabs, semicolons, commas or blanks,
//!    whichever the header uses; where the comma is not the separator, it is a decimal point.
//! 3. A unit is the end of a name: `time_ms`, `x [mm]`, `yaw (deg)`. Without one, times are
//!    seconds, lengths metres and angles radians.
//! 4. Heights, roll and pitch are dropped: the heading is where the robot's x axis points, seen
//!    from above.
//!
//! Times must not run backwards. Of several poses at one time the first counts; how many were left
//! out is reported.

use super::FieldError;
use super::field_error::{read, short};
use crate::geom::Pose2;

/// The columns of a file without a header: those of TUM.
const TUM: [Role; 8] = [
    Role::Time(1.0),
    Role::X(1.0),
    Role::Y(1.0),
    Role::Other,
    Role::Quaternion(0),
    Role::Quaternion(1),
    Role::Quaternion(2),
    Role::Quaternion(3),
];
const HEADER: &str = "a header that names a time, x, y and a heading (time,x,y,theta) or a quaternion \
    (qx,qy,qz,qw), or lines of 8 numbers (TUM: seconds x y z qx qy qz qw)";
/// Coordinates, m, and angles, rad, beyond this are refused: sums and squares of them stay finite.
const MOST: f64 = 1e9;
/// Times beyond this are refused, s: three thousand years. Nanoseconds taken for seconds are beyond
/// it.
const LATEST: f64 = 1e11;
/// The norm of a quaternion may deviate from 1 by this much, because it is written with few digits.
const ROUGH: f64 = 0.05;

/// What a file of poses holds.
#[derive(Clone, Debug, PartialEq)]
pub struct PosesFile {
    /// Seconds on the clock of the file, and the pose; times increase strictly.
    pub poses: Vec<(f64, Pose2)>,
    /// Poses that were left out because another one has the same time.
    pub repeated: usize,
}

/// Why a file is not a file of poses.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PosesError {
    /// A field that cannot be read, with its line.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// No line has content.
    #[error("no pose in {lines} lines; expected {HEADER}")]
    Empty {
        /// Number of lines read.
        lines: usize,
    },
}

/// What a column holds, with its unit in s, m or rad.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Role {
    Time(f64),
    X(f64),
    Y(f64),
    Heading(f64),
    /// x, y, z, w.
    Quaternion(usize),
    Other,
}

/// Reads poses.
///
/// # Errors   [`PosesError`], with line and field.
pub fn read_poses(bytes: &[u8]) -> Result<PosesFile, PosesError> {
    let text = String::from_utf8_lossy(bytes);
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let mut table: Option<Table> = None;
    let mut file = PosesFile {
        poses: vec![],
        repeated: 0,
    };
    let mut lines = 0;
    for (line, text) in (1..).zip(text.lines()) {
        lines = line;
        let (said, comment) = text.split_once('#').unwrap_or((text, ""));
        if said.trim().is_empty() {
            table = table.or_else(|| Table::named_by(comment));
            continue;
        }
        let table = match &mut table {
            Some(table) => table,
            none => match Table::named_by(said) {
                Some(named) => {
                    *none = Some(named);
                    continue;
                }
                None => none.insert(Table::without_header(line, said)?),
            },
        };
        let (seconds, pose) = table.row(line, said)?;
        match file.poses.last() {
            Some((last, _)) if seconds < *last => {
                let expected = format_args!("{last} or later: times must not run backwards");
                let field = "the time";
                return Err(FieldError::new(line, field, &seconds.to_string(), expected).into());
            }
            Some((last, _)) if seconds <= *last => file.repeated += 1,
            _ => file.poses.push((seconds, pose)),
        }
    }
    match file.poses.is_empty() {
        true => Err(PosesError::Empty { lines }),
        false => Ok(file),
    }
}

/// The columns of a file.
#[derive(Debug)]
struct Table {
    separator: Option<char>,
    /// Name and role of each.
    columns: Vec<(String, Role)>,
}

impl Table {
    /// From a header; `None` if its names do not include all that a pose needs.
    fn named_by(text: &str) -> Option<Self> {
        let separator = ['\t', ';', ','].into_iter().find(|c| text.contains(*c));
        let names = fields(text, separator);
        let columns: Vec<(String, Role)> = names
            .iter()
            .map(|name| ((*name).to_owned(), role(name)))
            .collect();
        let has = |of: fn(&Role) -> bool| columns.iter().any(|(_, role)| of(role));
        let has_heading = has(|role| matches!(role, Role::Heading(_)));
        let is_whole = has(|role| matches!(role, Role::Time(_)))
            && has(|role| matches!(role, Role::X(_)))
            && has(|role| matches!(role, Role::Y(_)))
            && (has_heading || (0..4).all(|i| columns.iter().any(|c| c.1 == Role::Quaternion(i))));
        is_whole.then_some(Self { separator, columns })
    }

    /// For a first line that is not a header: eight numbers separated by blanks.
    fn without_header(line: usize, text: &str) -> Result<Self, FieldError> {
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        let is_tum = words.len() == TUM.len() && words.iter().all(|w| w.parse::<f64>().is_ok());
        if !is_tum {
            return Err(FieldError::new(line, "the line", text.trim(), HEADER));
        }
        let names = ["seconds", "x", "y", "z", "qx", "qy", "qz", "qw"];
        let named = names.iter().zip(TUM);
        Ok(Self {
            separator: None,
            columns: named
                .map(|(name, role)| ((*name).to_owned(), role))
                .collect(),
        })
    }

    fn row(&self, line: usize, text: &str) -> Result<(f64, Pose2), FieldError> {
        let fields = fields(text, self.separator);
        if fields.len() != self.columns.len() {
            let names: Vec<&str> = self.columns.iter().map(|(name, _)| &**name).collect();
            let expected = format_args!("{}: {}", names.len(), short_list(&names));
            return Err(FieldError::count(line, fields.len(), expected));
        }
        let (mut seconds, mut x, mut y, mut heading) = (None, None, None, None);
        let mut quaternion = [None; 4];
        for (number, (word, (name, role))) in (1..).zip(fields.into_iter().zip(&self.columns)) {
            let field = format_args!("field {number} ({})", short(name));
            let value = |unit: f64, most: f64| self.number(line, &field, word, unit, most);
            // Of two columns with the same meaning the first counts.
            let (to, value) = match *role {
                Role::Time(unit) => (&mut seconds, value(unit, LATEST)?),
                Role::X(unit) => (&mut x, value(unit, MOST)?),
                Role::Y(unit) => (&mut y, value(unit, MOST)?),
                Role::Heading(unit) => (&mut heading, value(unit, MOST)?),
                Role::Quaternion(axis) => match quaternion.get_mut(axis) {
                    Some(to) => (to, value(1.0, MOST)?),
                    None => continue,
                },
                Role::Other => continue,
            };
            to.get_or_insert(value);
        }
        let heading = match (heading, quaternion) {
            (Some(heading), _) => heading,
            (None, [Some(x), Some(y), Some(z), Some(w)]) => of_quaternion(line, [x, y, z, w])?,
            (None, _) => 0.0,
        };
        let place = |value: Option<f64>| value.unwrap_or(0.0);
        let pose = Pose2::new(place(x), place(y), heading);
        Ok((place(seconds), pose))
    }

    fn number(
        &self,
        line: usize,
        field: &std::fmt::Arguments<'_>,
        word: &str,
        unit: f64,
        most: f64,
    ) -> Result<f64, FieldError> {
        let decimal = match self.separator {
            Some(',') => word.to_owned(),
            _ => word.replace(',', "."),
        };
        let fits = |n: &f64| (n * unit).abs() <= most;
        let expected = format!("a number of at most {:e}", most / unit);
        let number: Result<f64, _> = read(line, field, &decimal, &expected, fits);
        number.map(|number| number * unit)
    }
}

/// The fields of a line, without blanks and quotation marks.
fn fields(text: &str, separator: Option<char>) -> Vec<&str> {
    match separator {
        Some(separator) => text
            .split(separator)
            .map(|field| field.trim().trim_matches('"').trim())
            .collect(),
        None => text
            .split_ascii_whitespace()
            .map(|field| field.trim_matches('"'))
            .collect(),
    }
}

fn short_list(names: &[&str]) -> String {
    let names: Vec<String> = names.iter().map(|name| short(name)).collect();
    names.join(", ")
}

/// What a column holds by its name.
fn role(name: &str) -> Role {
    let name = name.to_lowercase();
    let (base, unit) = unit_of(name.trim());
    match base {
        "time" | "t" | "timestamp" | "stamp" | "sec" | "secs" | "seconds" | "s" => {
            time_unit(unit).map_or(Role::Other, Role::Time)
        }
        "x" | "tx" | "px" | "pos_x" | "position_x" | "pose_x" => {
            length_unit(unit).map_or(Role::Other, Role::X)
        }
        "y" | "ty" | "py" | "pos_y" | "position_y" | "pose_y" => {
            length_unit(unit).map_or(Role::Other, Role::Y)
        }
        "theta" | "th" | "yaw" | "heading" | "phi" | "psi" | "angle" | "θ" | "φ" | "ψ" => {
            angle_unit(unit).map_or(Role::Other, Role::Heading)
        }
        "qx" => Role::Quaternion(0),
        "qy" => Role::Quaternion(1),
        "qz" => Role::Quaternion(2),
        "qw" => Role::Quaternion(3),
        _ => Role::Other,
    }
}

/// Splits a unit from a name: `x [mm]`, `x(mm)` or `x_mm`; the unit is empty if there is none.
fn unit_of(name: &str) -> (&str, &str) {
    if let Some((base, unit)) = name.split_once(['[', '(']) {
        return (base.trim_end(), unit.trim_end_matches([']', ')']).trim());
    }
    match name.rsplit_once('_') {
        Some((base, unit)) if is_unit(unit) => (base, unit),
        _ => (name, ""),
    }
}

fn is_unit(unit: &str) -> bool {
    !unit.is_empty()
        && (time_unit(unit).is_some() || length_unit(unit).is_some() || angle_unit(unit).is_some())
}

fn time_unit(unit: &str) -> Option<f64> {
    Some(match unit {
        "" | "s" | "sec" | "secs" | "seconds" => 1.0,
        "ms" | "msec" | "millis" => 1e-3,
        "us" | "µs" | "μs" | "usec" | "micros" => 1e-6,
        "ns" | "nsec" | "nanos" => 1e-9,
        _ => return None,
    })
}

fn length_unit(unit: &str) -> Option<f64> {
    Some(match unit {
        "" | "m" | "metres" | "meters" => 1.0,
        "cm" => 1e-2,
        "mm" => 1e-3,
        _ => return None,
    })
}

fn angle_unit(unit: &str) -> Option<f64> {
    Some(match unit {
        "" | "rad" | "radians" => 1.0,
        "deg" | "degree" | "degrees" | "°" => 1.0_f64.to_radians(),
        _ => return None,
    })
}

fn of_quaternion(line: usize, [x, y, z, w]: [f64; 4]) -> Result<f64, FieldError> {
    let length = (x * x + y * y + z * z + w * w).sqrt();
    if (length - 1.0).abs() > ROUGH {
        let field = "the length of the quaternion";
        return Err(FieldError::new(line, field, &format!("{length:.3}"), "1"));
    }
    let [x, y, z, w] = [x, y, z, w].map(|part| part / length);
    Ok(libm::atan2(
        2.0 * (w * z + x * y),
        1.0 - 2.0 * (y * y + z * z),
    ))
}

#[cfg(test)]
mod tests;
