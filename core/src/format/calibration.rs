//! Calibration pairs of a ranger: lines of range and volts, as a spreadsheet writes them.
//!
//! ```
//! let text = "range_cm;volts\n# by ruler\n10;2.28\n20;1.30\n";
//! let pairs = slamlab_core::format::calibration::read(text.as_bytes())?;
//! assert_eq!((pairs.len(), pairs[1].range), (2, 0.2));
//! # Ok::<(), slamlab_core::format::calibration::CalibrationFileError>(())
//! ```
//!
//! Fields are parted by commas, semicolons, tabs or blanks; `#` begins a comment. A first line of words names the columns: the
//! first `range_m` (also without a header), `range_cm` or `range_mm`, the second `volts`. Whether the pairs make sense is
//! judged by [`crate::robot::Characteristic::fit`].

use crate::robot::CalibrationPair;

/// Most pairs that are read.
const MOST_PAIRS: usize = 10_000;
/// Longest piece of a line that an error repeats, characters.
const LONGEST_QUOTE: usize = 24;

/// Why a calibration cannot be read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CalibrationFileError {
    /// Bytes that are no text.
    #[error("calibration: byte {at} is not UTF-8 text")]
    Text {
        /// Number of the byte, from 0.
        at: usize,
    },
    /// A line without exactly two fields.
    #[error("calibration, line {line}: {found} fields, expected 2: range and volts")]
    Count {
        /// Line, from 1.
        line: usize,
        /// Number of fields.
        found: usize,
    },
    /// A field that is no finite number.
    #[error("calibration, line {line}: {field} is `{found}`, expected a finite number")]
    Number {
        /// Line, from 1.
        line: usize,
        /// Range or volts.
        field: &'static str,
        /// What stands there.
        found: String,
    },
    /// A header of other columns.
    #[error(
        "calibration, line {line}: columns `{found}`, expected range_m, range_cm or range_mm, and volts"
    )]
    Header {
        /// Line, from 1.
        line: usize,
        /// What stands there.
        found: String,
    },
    /// Absurdly many pairs.
    #[error("calibration, line {line}: more than {MOST_PAIRS} pairs")]
    TooMany {
        /// Line, from 1.
        line: usize,
    },
}

/// Reads pairs in the order of the file.
///
/// # Errors    [`CalibrationFileError`], with the line. Never panics, whatever the bytes.
pub fn read(bytes: &[u8]) -> Result<Vec<CalibrationPair>, CalibrationFileError> {
    let text = std::str::from_utf8(bytes).map_err(|e| CalibrationFileError::Text {
        at: e.valid_up_to(),
    })?;
    // Spreadsheets put a byte-order mark first.
    let text = text.trim_start_matches('\u{feff}');
    let (mut pairs, mut metres, mut is_first) = (Vec::new(), 1.0, true);
    for (index, content) in text.lines().enumerate() {
        let line = index + 1;
        let fields = fields(content);
        if fields.is_empty() {
            continue;
        }
        let &[range, volts] = fields.as_slice() else {
            let found = fields.len();
            return Err(CalibrationFileError::Count { line, found });
        };
        let is_header = std::mem::take(&mut is_first) && volts.starts_with(char::is_alphabetic);
        if is_header && number(line, "volts", volts).is_err() {
            metres = unit(line, range, volts)?;
            continue;
        }
        if pairs.len() == MOST_PAIRS {
            return Err(CalibrationFileError::TooMany { line });
        }
        pairs.push(CalibrationPair {
            range: metres * number(line, "range", range)?,
            volts: number(line, "volts", volts)?,
        });
    }
    Ok(pairs)
}

/// The fields of a line, comment left out.
fn fields(line: &str) -> Vec<&str> {
    let content = line.split('#').next().unwrap_or_default();
    let parted = content.split(|c: char| c == ',' || c == ';' || c.is_whitespace());
    parted.filter(|field| !field.is_empty()).collect()
}

/// Metres of the unit that the header names.
fn unit(line: usize, range: &str, volts: &str) -> Result<f64, CalibrationFileError> {
    match (range, volts) {
        ("range_m", "volts") => Ok(1.0),
        ("range_cm", "volts") => Ok(0.01),
        ("range_mm", "volts") => Ok(0.001),
        _ => Err(CalibrationFileError::Header {
            line,
            found: quote(&format!("{range}, {volts}")),
        }),
    }
}

fn number(line: usize, field: &'static str, text: &str) -> Result<f64, CalibrationFileError> {
    let number = text.parse().ok().filter(|n: &f64| n.is_finite());
    number.ok_or_else(|| CalibrationFileError::Number {
        line,
        field,
        found: quote(text),
    })
}

fn quote(text: &str) -> String {
    text.chars().take(LONGEST_QUOTE).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn columns_units_and_separators_are_understood() {
        let expect = |text: &str| {
            let pairs = read(text.as_bytes()).unwrap();
            let close = |p: &CalibrationPair, range: f64, volts: f64| {
                (p.range - range).abs() < 1e-12 && p.volts == volts
            };
            assert!(
                pairs.len() == 2 && close(&pairs[0], 0.1, 2.28) && close(&pairs[1], 0.2, 1.3),
                "{text:?}: {pairs:?}"
            );
        };
        expect("0.1,2.28\n0.2,1.30\n");
        expect("\u{feff}range_m,volts\r\n0.1,2.28\r\n0.2,1.30");
        expect("# by ruler\nrange_cm; volts\n\n10; 2.28 # dark board\n20;1.30\n");
        expect("range_mm\tvolts\n100\t2.28\n200\t1.30\n");
        assert_eq!(read(b""), Ok(vec![]));
    }

    #[test]
    fn bad_lines_are_named() {
        let message = |text: &[u8]| read(text).unwrap_err().to_string();
        assert!(message(b"0.1,2.28\n0.2").contains("line 2: 1 fields"));
        assert!(message(b"0.1,2.28,3").contains("line 1: 3 fields"));
        assert!(message(b"0.1,2.28\n0.2,NaN").contains("line 2: volts is `NaN`"));
        assert!(message(b"0.1,2.28\nx,1.3").contains("line 2: range is `x`"));
        assert!(message(b"range_ft,volts\n1,2").contains("columns `range_ft, volts`"));
        assert!(message(b"0.1,2.28\nrange_m,volts").contains("line 2: range is `range_m`"));
        assert!(message(b"0.1,\xff").contains("byte 4"));
        assert!(message("1 1\n".repeat(10_001).as_bytes()).contains("line 10001: more than"));
    }

    proptest! {
        #[test]
        fn noise_does_not_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let _ = read(&bytes);
        }
    }
}
