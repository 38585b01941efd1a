//! Names of rights: they appear in commands, in logs and on the page.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

const LONGEST: usize = 32;

/// The name of a right: 1 to 32 letters, digits, and `.`, `-` or `_` between them.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Name(String);

/// The text is not a valid name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{given:?} is no name; expected 1 to {LONGEST} letters and digits, and `.`, `-` or `_` between them"
)]
pub struct NameError {
    given: String,
}

impl FromStr for Name {
    type Err = NameError;

    fn from_str(text: &str) -> Result<Self, NameError> {
        let is_inside = |c: char| c.is_alphanumeric() || ".-_".contains(c);
        let is_edge = |c: Option<char>| c.is_some_and(char::is_alphanumeric);
        let is_name = text.chars().count() <= LONGEST
            && text.chars().all(is_inside)
            && is_edge(text.chars().next())
            && is_edge(text.chars().next_back());
        match is_name {
            true => Ok(Self(text.to_owned())),
            false => Err(NameError {
                given: text.to_owned(),
            }),
        }
    }
}

impl TryFrom<String> for Name {
    type Error = NameError;

    fn try_from(text: String) -> Result<Self, NameError> {
        text.parse()
    }
}

impl From<Name> for String {
    fn from(name: Name) -> Self {
        name.0
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_plain_words() {
        for good in [
            "a",
            "anna",
            "Anna-2",
            "lab.tablet_1",
            "Jürgen",
            &"n".repeat(32),
        ] {
            assert_eq!(good.parse::<Name>().unwrap().to_string(), good);
        }
        for bad in [
            "",
            " ",
            "-",
            "-a",
            "a-",
            "a b",
            "a\nb",
            "a\"b",
            "--role",
            "\u{202e}x",
            "a/b",
            &"n".repeat(33),
        ] {
            assert!(bad.parse::<Name>().is_err(), "{bad:?}");
        }
    }
}
