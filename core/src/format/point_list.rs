//! Lists of points: a line of x and y for each, m, as a spreadsheet writes them.
//!
//! ```
//! let text = "x,y\n# a wall\n1.0,2\n1.1;2.0\n";
//! let points = slamlab_core::format::point_list::read(text.as_bytes())?;
//! assert_eq!((points.len(), points[1].x), (2, 1.1));
//! # Ok::<(), slamlab_core::format::point_list::PointListError>(())
//! ```
//!
//! Fields are separated by commas, semicolons, tabs or blanks; `#` begins a comment. A first line
//! `x y` names the columns.

use nalgebra::Point2;

use super::FieldError;
use super::calibration::fields;
use super::field_error::number;
use crate::registration::Cloud;

/// Why a list of points cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PointListError {
    /// Bytes that are not text.
    #[error("list of points: byte {at} is not UTF-8 text")]
    Text {
        /// Number of the byte, from 0.
        at: usize,
    },
    /// A field that is not a number, or a line without exactly two fields.
    #[error("list of points, {0}")]
    Field(#[from] FieldError),
    /// Nothing but comments.
    #[error("list of points: no line has a point, expected x and y in each")]
    Empty,
    /// More points than a cloud may have.
    #[error("list of points, line {line}: more than {most} points", most = Cloud::MOST_POINTS)]
    TooMany {
        /// Line, from 1.
        line: usize,
    },
}

/// Reads points in the order of the file.
///
/// # Errors    [`PointListError`], with line and field. Never panics, whatever the bytes.
pub fn read(bytes: &[u8]) -> Result<Vec<Point2<f64>>, PointListError> {
    let text = std::str::from_utf8(bytes).map_err(|e| PointListError::Text {
        at: e.valid_up_to(),
    })?;
    // Spreadsheets put a byte-order mark first.
    let text = text.trim_start_matches('\u{feff}');
    let (mut points, mut is_first) = (vec![], true);
    for (index, content) in text.lines().enumerate() {
        let line = index + 1;
        let fields = fields(content);
        if fields.is_empty() {
            continue;
        }
        let &[x, y] = fields.as_slice() else {
            return Err(FieldError::count(line, fields.len(), "2: x and y").into());
        };
        let is_header = x.eq_ignore_ascii_case("x") && y.eq_ignore_ascii_case("y");
        if std::mem::take(&mut is_first) && is_header {
            continue;
        }
        if points.len() == Cloud::MOST_POINTS {
            return Err(PointListError::TooMany { line });
        }
        points.push(Point2::new(number(line, "x", x)?, number(line, "y", y)?));
    }
    if points.is_empty() {
        return Err(PointListError::Empty);
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn check(text: &str, expected: &str) {
        let said = match read(text.as_bytes()) {
            Ok(points) => format!("{points:?}"),
            Err(error) => error.to_string(),
        };
        assert_eq!(said, expected, "{text:?}");
    }

    #[test]
    fn lists_are_read_or_refused_by_line_and_field() {
        check("1,2", "[[1.0, 2.0]]");
        check(
            "\u{feff}X;Y\r\n1\t2\r\n\r\n-3e-1 4 # no more\r\n",
            "[[1.0, 2.0], [-0.3, 4.0]]",
        );
        check(
            "1,2\nx,y",
            "list of points, line 2: x is `x`, expected a finite number",
        );
        check(
            "1,nan",
            "list of points, line 1: y is `nan`, expected a finite number",
        );
        check(
            "1,2\n1,2,3",
            "list of points, line 2: the number of fields is `3`, expected 2: x and y",
        );
        check(
            "# nothing\n",
            "list of points: no line has a point, expected x and y in each",
        );
        assert_eq!(read(b"1,2\n\xff"), Err(PointListError::Text { at: 4 }));
        let many = "0 0\n".repeat(Cloud::MOST_POINTS + 1);
        let line = Cloud::MOST_POINTS + 1;
        assert_eq!(read(many.as_bytes()), Err(PointListError::TooMany { line }));
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(points in prop::collection::vec((-1e3..1e3_f64, -1e3..1e3_f64), 1..50)) {
            let lines: String = points.iter().map(|(x, y)| format!("{x},{y}\n")).collect();
            let expected: Vec<_> = points.iter().map(|(x, y)| Point2::new(*x, *y)).collect();
            prop_assert_eq!(read(lines.as_bytes()), Ok(expected));
        }

        #[test]
        fn no_bytes_make_it_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = read(&bytes);
        }
    }
}
