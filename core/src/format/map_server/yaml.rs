//! The YAML file of a map: a flat mapping of keys to scalars, and a list of three numbers.
//!
//! In: bytes. Out: a [`MapInfo`]. The file is read event by event and not as a tree, so deep
//! nesting costs nothing, nor do aliases, with which a few lines can describe a tree of any size.

use std::collections::BTreeMap;

use saphyr_parser::{Event, Parser};

use super::{MapInfo, MapInfoError, MapMode};
use crate::format::FieldError;
use crate::geom::Pose2;

/// Longer files are not from map_server.
const LONGEST: usize = 1 << 16;

/// The value of a key: one word or the words of a list, and the line where it begins.
struct Value {
    line: usize,
    words: Vec<String>,
    is_list: bool,
}

pub(super) fn parse(bytes: &[u8]) -> Result<MapInfo, MapInfoError> {
    if bytes.len() > LONGEST {
        return Err(MapInfoError::TooLong {
            bytes: bytes.len(),
            most: LONGEST,
        });
    }
    let text = String::from_utf8_lossy(bytes);
    let fields = Fields(mapping(&text)?);
    let number = |key, expected, fits: fn(f64) -> bool| {
        fields.word(key, expected, |w| w.parse().ok().filter(|&n| fits(n)))
    };
    let part = |key| number(key, "from 0 to 1", |p| (0.0..=1.0).contains(&p));
    let mode = |word: &str| word.parse().ok();
    Ok(MapInfo {
        image: fields.word("image", "the path of an image", |path| {
            Some(path.to_owned()).filter(|path| !path.is_empty())
        })?,
        mode: match fields.0.contains_key("mode") {
            true => fields.word("mode", "trinary, scale or raw", mode)?,
            false => MapMode::default(),
        },
        resolution: number("resolution", "more than 0 and at most 1000 m", |r| {
            r > 0.0 && r <= 1000.0
        })?,
        origin: fields.origin()?,
        negate: fields.word("negate", "0 or 1", |word| match word {
            "0" | "false" | "False" | "no" => Some(false),
            "1" | "true" | "True" | "yes" => Some(true),
            _ => None,
        })?,
        occupied_thresh: part("occupied_thresh")?,
        free_thresh: part("free_thresh")?,
    })
}

/// The values, by key.
struct Fields(BTreeMap<String, Value>);

impl Fields {
    fn get(&self, key: &'static str) -> Result<&Value, MapInfoError> {
        self.0.get(key).ok_or(MapInfoError::Missing { key })
    }

    /// The value of one word.
    fn word<T>(
        &self,
        key: &'static str,
        expected: &str,
        read: impl Fn(&str) -> Option<T>,
    ) -> Result<T, MapInfoError> {
        let value = self.get(key)?;
        let found = match value.words.as_slice() {
            [word] if !value.is_list => read(word),
            _ => None,
        };
        found.ok_or_else(|| value.wrong(key, expected))
    }

    fn origin(&self) -> Result<Pose2, MapInfoError> {
        let value = self.get("origin")?;
        let numbers: Vec<f64> = value.words.iter().flat_map(|w| w.parse()).collect();
        match (numbers.as_slice(), value.words.len(), value.is_list) {
            (&[x, y, yaw], 3, true) if numbers.iter().all(|n| n.abs() <= 1e6) => {
                Ok(Pose2::new(x, y, yaw))
            }
            _ => Err(value.wrong("origin", "a list [x, y, yaw] of numbers within ±1e6")),
        }
    }
}

impl Value {
    fn wrong(&self, key: &str, expected: &str) -> MapInfoError {
        let words = self.words.join(", ");
        let list = format!("[{words}]");
        let found = if self.is_list { &list } else { &words };
        FieldError::new(self.line, key, found, expected).into()
    }
}

fn mapping(text: &str) -> Result<BTreeMap<String, Value>, MapInfoError> {
    let mut fields = BTreeMap::new();
    let mut key: Option<String> = None;
    let mut value: Option<Value> = None;
    let mut depth = 0_usize;
    for event in Parser::new_from_str(text) {
        let (event, span) = event.map_err(|error| MapInfoError::Syntax {
            line: error.marker().line(),
            what: error.info().to_owned(),
        })?;
        let line = span.start.line();
        let syntax = |what: &str| MapInfoError::Syntax {
            line,
            what: what.to_owned(),
        };
        let mut ended = None;
        match event {
            Event::MappingStart(..) if depth == 0 => depth = 1,
            Event::Scalar(..) | Event::SequenceStart(..) | Event::Alias(_) if depth == 0 => {
                return Err(syntax("expected keys with values, as `resolution: 0.05`"));
            }
            Event::MappingEnd | Event::SequenceEnd => {
                depth -= 1;
                if depth == 1 {
                    ended = value.take();
                }
            }
            // The map is the first document.
            Event::DocumentEnd => break,
            Event::Scalar(word, ..) if depth == 1 && key.is_none() => key = Some(word.into_owned()),
            Event::Scalar(word, ..) if depth == 1 => {
                ended = Some(Value {
                    line,
                    words: vec![word.into_owned()],
                    is_list: false,
                });
            }
            Event::Scalar(word, ..) if depth == 2 => {
                if let Some(value) = &mut value {
                    value.words.push(word.into_owned());
                }
            }
            Event::SequenceStart(..) | Event::MappingStart(..) => {
                if depth == 1 {
                    if key.is_none() {
                        return Err(syntax("expected a word as a key"));
                    }
                    value = Some(Value {
                        line,
                        words: vec![],
                        is_list: true,
                    });
                }
                depth += 1;
            }
            Event::Alias(_) => return Err(syntax("an alias, which no map needs")),
            _ => {}
        }
        if let Some(value) = ended
            && let Some(name) = key.take()
        {
            if fields.contains_key(&name) {
                return Err(FieldError::new(line, "the key", &name, "each key once").into());
            }
            fields.insert(name, value);
        }
    }
    Ok(fields)
}
