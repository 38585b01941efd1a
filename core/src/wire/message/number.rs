//! Ranges in text: JSON has no infinity, and a beam without return is not the same as a failed one.

use serde::de::{Deserialize, Deserializer, Error};
use serde::ser::{Serialize, SerializeSeq, Serializer};

#[derive(serde::Serialize, serde::Deserialize)]
#[serde(untagged)]
enum Readable {
    Number(f32),
    Word(String),
}

/// Binary: as they are. Text: `"inf"` and `"nan"` stand for infinite and invalid ranges.
pub(super) fn serialize<S: Serializer>(ranges: &[f32], serializer: S) -> Result<S::Ok, S::Error> {
    if !serializer.is_human_readable() {
        return ranges.serialize(serializer);
    }
    let mut list = serializer.serialize_seq(Some(ranges.len()))?;
    for &range in ranges {
        if range.is_finite() {
            list.serialize_element(&range)?;
        } else {
            list.serialize_element(if range.is_nan() { "nan" } else { "inf" })?;
        }
    }
    list.end()
}

pub(super) fn deserialize<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<f32>, D::Error> {
    if !deserializer.is_human_readable() {
        return Vec::deserialize(deserializer);
    }
    let list = Vec::<Readable>::deserialize(deserializer)?;
    let number = |readable| match readable {
        Readable::Number(number) => Ok(number),
        Readable::Word(word) if word == "inf" => Ok(f32::INFINITY),
        Readable::Word(word) if word == "nan" => Ok(f32::NAN),
        Readable::Word(word) => Err(D::Error::custom(format!(
            "range {word:?}: expected a number, \"inf\" or \"nan\""
        ))),
    };
    list.into_iter().map(number).collect()
}
