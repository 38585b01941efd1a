//! The schema in text: JavaScript's numbers hold 53 bits, so that a script that read a number there
//! could not send the same one back, and was taken for one of another age.

use serde::de::{Deserialize, Deserializer, Error};
use serde::ser::{Serialize, Serializer};

#[derive(serde::Deserialize)]
#[serde(untagged)]
enum Readable {
    Number(u64),
    Word(String),
}

/// Binary: as it is. Text: sixteen hexadecimal figures, as in [`super::About`].
pub(super) fn serialize<S: Serializer>(schema: &u64, serializer: S) -> Result<S::Ok, S::Error> {
    if !serializer.is_human_readable() {
        return schema.serialize(serializer);
    }
    serializer.serialize_str(&format!("{schema:016x}"))
}

/// Text: a number too, which clients wrote that knew no other form.
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
