//! From text to a submap.
//!
//! The text is read line by line: a line that begins with `#` begins a section, the next states how
//! many lines follow, and then they follow. Memory grows with what the file holds, not with what it
//! promises.

use std::iter::Peekable;

use nalgebra::Point2;

use super::{
    LANDMARKS, LandmarkKind, MOST_POINTS, POINTS, ROBOT, Smap, SmapError, SmapLandmark, from_file,
};
use crate::format::FieldError;
use crate::format::field_error::read;

/// Coordinates beyond this are refused, mm: a thousand kilometres. Squares of them stay exact
/// enough.
const MOST: f64 = 1e9;

/// Reads a submap.
///
/// # Errors    [`SmapError`], with the line: a section that is missing or appears twice, a
/// different number of lines than stated, or an invalid number.
pub fn parse(bytes: &[u8]) -> Result<Smap, SmapError> {
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    let all = text.lines().count();
    let lines = (1..).zip(text.lines().map(str::trim));
    let mut lines = Lines {
        rest: lines.filter(|(_, line)| !line.is_empty()).peekable(),
        end: all,
    };
    let (mut points, mut path, mut landmarks) = (None, None, None);
    while let Some((line, name)) = lines.rest.next() {
        match name {
            POINTS if points.is_none() => points = Some(lines.section(POINTS, place)?),
            ROBOT if path.is_none() => path = Some(lines.section(ROBOT, place)?),
            LANDMARKS if landmarks.is_none() => {
                landmarks = Some(lines.section(LANDMARKS, landmark)?);
            }
            POINTS | ROBOT | LANDMARKS => {
                let expected = "each section once";
                return Err(FieldError::new(line, "the section", name, expected).into());
            }
            other => {
                let left = [
                    (POINTS, points.is_none()),
                    (ROBOT, path.is_none()),
                    (LANDMARKS, landmarks.is_none()),
                ];
                let left: Vec<&str> = left.iter().filter(|s| s.1).map(|s| s.0).collect();
                let expected = match left.is_empty() {
                    true => "the end of the file, as all sections are complete".to_owned(),
                    false => format!("{}, as what stands before is complete", left.join(" or ")),
                };
                return Err(FieldError::new(line, "the line", other, expected).into());
            }
        }
    }
    let missing = |section| SmapError::Missing {
        section,
        lines: all,
    };
    Ok(Smap {
        points: points.ok_or(missing(POINTS))?,
        path: path.ok_or(missing(ROBOT))?,
        landmarks: landmarks.ok_or(missing(LANDMARKS))?,
    })
}

struct Lines<'a, I: Iterator<Item = (usize, &'a str)>> {
    rest: Peekable<I>,
    /// The last line of the file.
    end: usize,
}

impl<'a, I: Iterator<Item = (usize, &'a str)>> Lines<'a, I> {
    /// The rows of a section whose name was just read.
    fn section<T>(
        &mut self,
        name: &'static str,
        row: impl Fn(usize, &str) -> Result<T, FieldError>,
    ) -> Result<Vec<T>, SmapError> {
        let (at, count) = self.count(name)?;
        let mut rows = vec![];
        while rows.len() < count {
            let is_row = |(_, line): &(usize, &str)| !line.starts_with('#');
            let Some((line, text)) = self.rest.next_if(is_row) else {
                let line = self.rest.peek().map_or(self.end, |(line, _)| *line);
                let field = format_args!("the number of lines of {name}");
                let (found, expected) =
                    (rows.len().to_string(), format!("{count} as line {at} says"));
                return Err(FieldError::new(line, field, &found, expected).into());
            };
            rows.push(row(line, text)?);
        }
        Ok(rows)
    }

    /// The line on which a section states its number of rows, and that number.
    fn count(&mut self, name: &'static str) -> Result<(usize, usize), SmapError> {
        let (line, word) = self.rest.next().unwrap_or((self.end, ""));
        let expected = "a whole number, at least 0, in the line behind the name";
        let field = format_args!("the count of {name}");
        let found = read(line, field, word, expected, |_: &usize| true)?;
        match name {
            POINTS if found > MOST_POINTS => Err(SmapError::TooManyPoints { line, found }),
            _ => Ok((line, found)),
        }
    }
}

fn place(line: usize, text: &str) -> Result<Point2<f64>, FieldError> {
    coordinates(line, words(line, text, "2: x, y")?)
}

fn landmark(line: usize, text: &str) -> Result<SmapLandmark, FieldError> {
    let [x, y, confidence, kind] = words(line, text, "4: x, y, confidence, type")?;
    let expected = "a whole number, at least 0";
    let confidence = read(line, "confidence", confidence, expected, |_: &u32| true)?;
    let kind = match kind {
        "0" => LandmarkKind::Point,
        "1" => LandmarkKind::Edge,
        other => {
            let expected = "0 for a point or corner, or 1 for an edge";
            return Err(FieldError::new(line, "type", other, expected));
        }
    };
    Ok(SmapLandmark {
        at: coordinates(line, [x, y])?,
        confidence,
        kind,
    })
}

fn words<'a, const N: usize>(
    line: usize,
    text: &'a str,
    expected: &str,
) -> Result<[&'a str; N], FieldError> {
    let words: Vec<&str> = text.split(',').map(str::trim).collect();
    let found = words.len();
    let words = words.try_into();
    words.map_err(|_| FieldError::count(line, found, expected))
}

fn coordinates(line: usize, [x, y]: [&str; 2]) -> Result<Point2<f64>, FieldError> {
    let number = |name: &str, word: &str| {
        let expected = "millimetres, within ±1e9";
        read(line, name, word, expected, |n: &f64| n.abs() <= MOST)
    };
    Ok(from_file([number("x", x)?, number("y", y)?]))
}
