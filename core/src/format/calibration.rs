//! Calibration pairs of a ranger: lines of range and volts, as a spreadsheet writes them.
//!
//! ```
//! let text = "range_cm;volts\n# by ruler\n10;2.28\n20;1.30\n";
//! let pairs = slamlab_core::format::calibration::read(text.as_bytes())?;
//! assert_eq!((pairs.len(), pairs[1].range), (2, 0.2));
//! # Ok::<(), slamlab_core::format::calibration::CalibrationFileError>(())
//! ```
//!
//! Fields are separated by commas, semicolons, tabs or blanks; `#` begins a comment. A header line
//! names the columns: the first is `range_m` (the default without a header), `range_cm` or
//! `range_mm`, the second `volts`, `millivolts` or `adc` (counts of the RP6's converter). Whether
//! the pairs make sense is judged by [`crate::robot::Characteristic::fit`]; [`fit`] names the line
//! of a pair that does not.

use super::FieldError;
use super::field_error::number;
use crate::robot::{Adc, CalibrationPair, Characteristic, CharacteristicError, Fit, Variable};

/// Most pairs that are read.
const MOST_PAIRS: usize = 10_000;

/// Why a calibration cannot be read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CalibrationFileError {
    /// Bytes that are not text.
    #[error("calibration: byte {at} is not UTF-8 text")]
    Text {
        /// Number of the byte, from 0.
        at: usize,
    },
    /// A field that is not a number, columns of other names, or a line without exactly two fields.
    #[error("calibration, {0}")]
    Field(#[from] FieldError),
    /// An invalid pair, or one that contradicts the one before.
    #[error("calibration, line {line}: {source}")]
    Pair {
        /// Line, from 1.
        line: usize,
        /// What is wrong with it.
        source: CharacteristicError,
    },
    /// Pairs that do not determine a characteristic.
    #[error(transparent)]
    Characteristic(CharacteristicError),
    /// Too many pairs.
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
    let lines = read_lines(bytes)?.into_iter();
    Ok(lines.map(|(_, pair)| pair).collect())
}

/// Reads pairs and fits a characteristic to them.
///
/// # Errors    [`CalibrationFileError`], with the line if a single line is at fault.
pub fn fit(
    bytes: &[u8],
    variable: Variable,
) -> Result<(Vec<CalibrationPair>, Fit), CalibrationFileError> {
    let (lines, pairs): (Vec<usize>, Vec<CalibrationPair>) = read_lines(bytes)?.into_iter().unzip();
    match Characteristic::fit(&pairs, variable) {
        Ok(fit) => Ok((pairs, fit)),
        Err(source) => Err(match &source {
            CharacteristicError::Value { pair, .. }
            | CharacteristicError::OutOfOrder { pair, .. } => {
                let line = lines.get(pair.saturating_sub(1)).copied().unwrap_or(1);
                CalibrationFileError::Pair { line, source }
            }
            _ => CalibrationFileError::Characteristic(source),
        }),
    }
}

/// The pairs, each with its line.
fn read_lines(bytes: &[u8]) -> Result<Vec<(usize, CalibrationPair)>, CalibrationFileError> {
    let text = std::str::from_utf8(bytes).map_err(|e| CalibrationFileError::Text {
        at: e.valid_up_to(),
    })?;
    // Spreadsheets put a byte-order mark first.
    let text = text.trim_start_matches('\u{feff}');
    let (mut pairs, mut columns, mut is_first) = (Vec::new(), Columns::default(), true);
    for (index, content) in text.lines().enumerate() {
        let line = index + 1;
        let fields = fields(content);
        if fields.is_empty() {
            continue;
        }
        let &[range, volts] = fields.as_slice() else {
            return Err(FieldError::count(line, fields.len(), "2: range and volts").into());
        };
        let is_header = std::mem::take(&mut is_first) && volts.starts_with(char::is_alphabetic);
        if is_header && number(line, "volts", volts).is_err() {
            columns = Columns::named(line, range, volts)?;
            continue;
        }
        if pairs.len() == MOST_PAIRS {
            return Err(CalibrationFileError::TooMany { line });
        }
        let pair = CalibrationPair {
            range: columns.metres * number(line, "range", range)?,
            volts: columns.volts(number(line, columns.second, volts)?),
        };
        pairs.push((line, pair));
    }
    Ok(pairs)
}

/// The fields of a line, without its comment.
pub(super) fn fields(line: &str) -> Vec<&str> {
    let content = line.split('#').next().unwrap_or_default();
    let parted = content.split(|c: char| c == ',' || c == ';' || c.is_whitespace());
    parted.filter(|field| !field.is_empty()).collect()
}

/// What the columns hold.
#[derive(Clone, Copy)]
struct Columns {
    /// Metres per unit of the first column.
    metres: f64,
    /// Name of the second column.
    second: &'static str,
}

impl Default for Columns {
    fn default() -> Self {
        Self {
            metres: 1.0,
            second: "volts",
        }
    }
}

impl Columns {
    fn named(line: usize, range: &str, volts: &str) -> Result<Self, FieldError> {
        let metres = match range {
            "range_m" => Some(1.0),
            "range_cm" => Some(0.01),
            "range_mm" => Some(0.001),
            _ => None,
        };
        let second = ["volts", "millivolts", "adc"];
        let second = second.into_iter().find(|name| *name == volts);
        let (Some(metres), Some(second)) = (metres, second) else {
            let (found, expected) = (
                format!("{range}, {volts}"),
                "range_m, range_cm or range_mm, and volts, millivolts or adc",
            );
            return Err(FieldError::new(line, "the header", &found, expected));
        };
        Ok(Self { metres, second })
    }

    /// Volts for a value of the second column.
    fn volts(&self, number: f64) -> f64 {
        match self.second {
            "millivolts" => 1e-3 * number,
            // The middle of the voltages that give this count, as in `Adc::volts`; here a mean of
            // several counts may have a fraction.
            "adc" => (number + 0.5) * Adc::rp6().step(),
            _ => number,
        }
    }
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
    fn counts_of_the_converter_become_volts() {
        let pairs = read(b"range_cm adc\n10 466\n20 266.5").unwrap();
        assert!((pairs[0].volts - Adc::rp6().volts(466)).abs() < 1e-12);
        assert!((pairs[1].volts - 267.0 * 5.0 / 1024.0).abs() < 1e-12);
        let pairs = read(b"range_mm,millivolts\n100,2280\n200,1300").unwrap();
        assert!((pairs[0].volts - 2.28).abs() < 1e-12);
    }

    #[test]
    fn a_pair_that_cannot_be_is_named_by_its_line() {
        let good = "range_cm;volts\n# ruler\n10;2.28\n20;1.30\n30;0.90\n40;0.75\n50;0.60\n60;0.50\n70;0.45\n80;0.40\n";
        let (pairs, fitted) = fit(good.as_bytes(), Variable::PerVolt).unwrap();
        assert_eq!(pairs.len(), 8);
        assert!(fitted.sigma < 0.02, "{}", fitted.sigma);
        let message = |from: &str, to: &str| {
            let text = good.replace(from, to);
            fit(text.as_bytes(), Variable::PerVolt)
                .unwrap_err()
                .to_string()
        };
        let turned = message("40;0.75", "40;0.95");
        assert!(turned.starts_with("calibration, line 6: "), "{turned}");
        assert!(turned.contains("fewer volts"), "{turned}");
        assert!(message("20;1.30", "20;-1").contains("line 4: calibration pair 2: volts is -1"));
        let few = fit(b"10 2\n20 1", Variable::Volts).unwrap_err().to_string();
        assert!(few.contains("2 pairs, expected at least 7"), "{few}");
    }

    #[test]
    fn bad_lines_are_named() {
        let message = |text: &[u8]| read(text).unwrap_err().to_string();
        assert!(message(b"0.1,2.28\n0.2").contains("line 2: the number of fields is `1`"));
        assert!(message(b"0.1,2.28,3").contains("line 1: the number of fields is `3`"));
        assert!(message(b"0.1,2.28\n0.2,NaN").contains("line 2: volts is `NaN`"));
        assert!(message(b"0.1,2.28\nx,1.3").contains("line 2: range is `x`"));
        assert!(message(b"range_ft,volts\n1,2").contains("the header is `range_ft, volts`"));
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
