//! Preset files: settings by their keys, as JSON, with a name and how well each value is known.
//!
//! ```
//! let text = r#"{ "slamlab_preset": 1, "name": "my robot", "settings": { "odometry.left": 0.012 } }"#;
//! let preset = slamlab_core::format::preset::read(text.as_bytes())?;
//! assert_eq!(preset.settings, [("odometry.left".to_owned(), 0.012)]);
//! # Ok::<(), slamlab_core::format::preset::PresetFileError>(())
//! ```
//!
//! | field | meaning |
//! |---|---|
//! | `slamlab_preset` | version of the format: 1 |
//! | `name` | for people |
//! | `settings` | numbers by the keys of `core::settings`; who applies them says which keys there are |
//! | `fitted` | optional, for people: parameters with value and standard error, as `evaluate --fit` writes them; not read |

use std::collections::BTreeMap;

use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

/// Longest file that is read, bytes.
const LONGEST: usize = 1 << 20;

/// What a preset file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct PresetFile {
    /// For people.
    pub name: String,
    /// Keys and numbers, in the order of the keys.
    pub settings: Vec<(String, f64)>,
}

/// A parameter as it is shown to people.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FittedLine {
    /// Its name.
    pub name: String,
    /// Its unit; empty for a pure number.
    pub unit: String,
    /// The fitted value.
    pub value: f64,
    /// Its standard error, if known.
    pub sigma: Option<f64>,
    /// Why it could not be determined; empty if it was.
    pub unknown: String,
}

/// Why a preset file cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PresetFileError {
    /// The file is too long.
    #[error("preset file: {bytes} bytes, expected at most {LONGEST}")]
    TooLong {
        /// Length of the file.
        bytes: usize,
    },
    /// The file has another version.
    #[error("preset file: version {found}, expected 1")]
    Version {
        /// The version found.
        found: u32,
    },
    /// Not valid JSON, or fields other than expected.
    #[error("preset file: {field}: {source}")]
    Json {
        /// Where.
        field: String,
        /// What, with line and column.
        source: serde_json::Error,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Read {
    slamlab_preset: u32,
    name: String,
    settings: BTreeMap<String, f64>,
    #[serde(default, rename = "fitted")]
    _for_people: IgnoredAny,
}

#[derive(Serialize)]
struct Written<'a> {
    slamlab_preset: u32,
    name: &'a str,
    settings: BTreeMap<&'a str, f64>,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    fitted: &'a [FittedLine],
}

/// Reads a preset file.
///
/// # Errors    [`PresetFileError`], with field, line and column.
pub fn read(bytes: &[u8]) -> Result<PresetFile, PresetFileError> {
    if bytes.len() > LONGEST {
        let bytes = bytes.len();
        return Err(PresetFileError::TooLong { bytes });
    }
    let mut json = serde_json::Deserializer::from_slice(bytes);
    let file: Read =
        serde_path_to_error::deserialize(&mut json).map_err(|error| PresetFileError::Json {
            field: error.path().to_string(),
            source: error.into_inner(),
        })?;
    json.end().map_err(|source| PresetFileError::Json {
        field: "end".to_owned(),
        source,
    })?;
    match file.slamlab_preset {
        1 => Ok(PresetFile {
            name: file.name,
            settings: file.settings.into_iter().collect(),
        }),
        found => Err(PresetFileError::Version { found }),
    }
}

/// Writes a preset file; `fitted` tells people how well its numbers are known. JSON cannot hold
/// numbers that are not finite: a setting like that is an error of the caller and is left out.
#[must_use]
pub fn write(preset: &PresetFile, fitted: &[FittedLine]) -> String {
    let settings = preset.settings.iter();
    let settings = settings.map(|(key, value)| (key.as_str(), *value));
    let json = Written {
        slamlab_preset: 1,
        name: &preset.name,
        settings: settings.filter(|(_, value)| value.is_finite()).collect(),
        fitted,
    };
    // Strings and finite numbers can always be written.
    let mut text = serde_json::to_string_pretty(&json).unwrap_or_default();
    text.push('\n');
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_is_read_and_the_doubts_stand_beside_it() {
        let preset = PresetFile {
            name: "kitchen".to_owned(),
            settings: vec![
                ("odometry.left".to_owned(), -0.0123),
                ("odometry.track".to_owned(), 1.0 / 3.0),
            ],
        };
        let line = FittedLine {
            name: "Left".to_owned(),
            unit: "m".to_owned(),
            value: -0.0123,
            sigma: None,
            unknown: String::new(),
        };
        let text = write(&preset, &[line]);
        assert_eq!(read(text.as_bytes()).unwrap(), preset);
        assert!(text.contains("\"unknown\": \"\""), "{text}");
        let by_hand = text.replace("\"unknown\": \"\"", "\"note\": 1");
        assert_eq!(read(by_hand.as_bytes()).unwrap(), preset);
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        let said = |text: &str| read(text.as_bytes()).unwrap_err().to_string();
        let wrong = said(r#"{"slamlab_preset": 1, "name": "a", "settings": {"ekf.gate": "9"}}"#);
        assert!(
            wrong.contains("settings.ekf.gate") && wrong.contains("line 1"),
            "{wrong}"
        );
        assert!(
            said(r#"{"slamlab_preset": 2, "name": "a", "settings": {}}"#).contains("version 2")
        );
        assert!(said("").contains("line 1"));
        assert!(said(r#"{"slamlab_preset": 1, "name": "a", "settings": {}} x"#).contains("end"));
    }
}
