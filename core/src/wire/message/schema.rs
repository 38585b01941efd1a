//! The schema in text. JavaScript's numbers hold only 53 bits, so a script that read the schema as
//! a number could not send the same one back, and was rejected as one of another version.

use serde::de::{Deserialize, Deserializer, Error};
use serde::ser::{Serialize, Serializer};

#[derive(serde::Deserialize)]
#[serde(untagged)]
enum Readable {
    Number(u64),
    Word(String),
}

/// Binary: as it is. Text: sixteen hexadecimal digits, as in [`super::About`].
pub(super) fn serialize<S: Serializer>(schema: &u64, serializer: S) -> Result<S::Ok, S::Error> {
    if !serializer.is_human_readable() {
        return schema.serialize(serializer);
    }
    serializer.serialize_str(&format!("{schema:016x}"))
}

/// Text: a number is accepted too, because older clients knew no other form.
pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u64, D::Error> {
    if !deserializer.is_human_readable() {
        return u64::deserialize(deserializer);
    }
    match Readable::deserialize(deserializer)? {
        Readable::Number(schema) => Ok(schema),
        Readable::Word(word) => u64::from_str_radix(&word, 16).map_err(|_| {
            D::Error::custom(format!(
                "schema {word:?}: expected up to sixteen hexadecimal figures, or a number"
            ))
        }),
    }
}
