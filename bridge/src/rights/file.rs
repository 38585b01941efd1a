//! The file of the rights: TOML, one block for each.
//!
//! In: its text. Out: names, roles and verifiers; or what is wrong with it, and in which line. A
//! file that cannot be read is never overwritten, and concurrent commands wait for each other.

use std::fs::File;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use slamlab_core::wire::message::{PROOF_BYTES, Right, Role, Verifier};
use toml::{Spanned, value::Datetime};

use super::{Granted, Name};
use crate::replaced_file;
use crate::secret_file::{self, SecretFileError};
use crate::token::{Token, TokenError};

/// Most rights in a file. More need another program.
const MOST: usize = 200;

const HEAD: &str = "# Who may do what at this robot's bridge. `slamlab-bridge token add`, `list` and `revoke` work on this file.\n\
                    # No token stands here: a verifier says whether a proof was made with one, and makes none.\n";

/// Why rights cannot be read, given or taken away.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RightsError {
    /// The file cannot be read or written, or others can read it.
    #[error("rights {0}")]
    File(#[from] SecretFileError),
    /// The file does not hold rights.
    #[error("rights {}, line {line}: {said}; it is left as it is", path.display())]
    Text {
        /// The file.
        path: PathBuf,
        /// Where.
        line: usize,
        /// What is wrong there.
        said: String,
    },
    /// The rights cannot be serialised.
    #[error("rights {}: {source}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: toml::ser::Error,
    },
    /// Two rights have the same name.
    #[error("rights {}, line {line}: there are two of the name {name}", path.display())]
    Twice {
        /// The file.
        path: PathBuf,
        /// Of the second.
        line: usize,
        /// Which.
        name: Name,
    },
    /// There are too many rights.
    #[error("rights {}: {count}; expected at most {MOST}", path.display())]
    TooMany {
        /// The file.
        path: PathBuf,
        /// How many there are.
        count: usize,
    },
    /// There already is a right of this name.
    #[error("there is a right of the name {0} already: revoke it first, or take another name")]
    Taken(Name),
    /// There is no right of this name.
    #[error("there is no right of the name {name}; there are {known}")]
    Unknown {
        /// Which.
        name: Name,
        /// The existing ones.
        known: String,
    },
    /// No random token could be made.
    #[error(transparent)]
    Token(#[from] TokenError),
}

/// A file of rights.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RightsFile(PathBuf);

/// A right as shown to people.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listed {
    /// Its name.
    pub name: Name,
    /// Its role.
    pub role: Role,
    /// When it was made, as written in the file.
    pub made: String,
}

/// What the file holds.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Text {
    #[serde(default)]
    right: Vec<Entry>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: Spanned<Name>,
    role: Role,
    verifier: Hexadecimal,
    made: Datetime,
}

/// A verifier in hexadecimal.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
struct Hexadecimal(Verifier);

impl From<Hexadecimal> for String {
    fn from(Hexadecimal(verifier): Hexadecimal) -> Self {
        crate::hexadecimal::write(&verifier.to_bytes())
    }
}

impl TryFrom<String> for Hexadecimal {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let bytes: Option<[u8; PROOF_BYTES]> = crate::hexadecimal::read(&text);
        let verifier = bytes.map(Verifier::from_bytes).map(Self);
        verifier.ok_or_else(|| format!("a verifier is {} hexadecimal digits", 2 * PROOF_BYTES))
    }
}

impl RightsFile {
    /// The file at this path, whether it exists or not.
    #[must_use]
    pub fn at(path: PathBuf) -> Self {
        Self(path)
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// The rights; none if there is no file.
    ///
    /// # Errors    [`RightsError`], with the line if the error is in one.
    pub(crate) fn granted(&self) -> Result<Vec<Granted>, RightsError> {
        let granted = |entry: Entry| Granted {
            right: Right {
                role: entry.role,
                name: entry.name.into_inner().into(),
            },
            verifier: entry.verifier.0,
        };
        Ok(self.read()?.right.into_iter().map(granted).collect())
    }

    /// The rights, to show to people.
    ///
    /// # Errors    [`RightsError`], with the line if the error is in one.
    pub fn list(&self) -> Result<Vec<Listed>, RightsError> {
        let listed = |entry: Entry| Listed {
            name: entry.name.into_inner(),
            role: entry.role,
            made: entry.made.to_string(),
        };
        Ok(self.read()?.right.into_iter().map(listed).collect())
    }

    /// Makes a right, and returns its token, which can be shown only now. `made` is the time of
    /// day.
    ///
    /// # Errors    [`RightsError`]; then the file is unchanged.
    pub fn add(&self, name: Name, role: Role, made: Datetime) -> Result<Token, RightsError> {
        let _alone = self.lock()?;
        let mut text = self.read()?;
        if text.right.iter().any(|entry| *entry.name.get_ref() == name) {
            return Err(RightsError::Taken(name));
        }
        let token = Token::random()?;
        text.right.push(Entry {
            name: Spanned::new(0..0, name),
            role,
            verifier: Hexadecimal(Verifier::of(token.reveal())),
            made,
        });
        self.write(&text)?;
        Ok(token)
    }

    /// Takes a right away, and returns its role.
    ///
    /// # Errors    [`RightsError`]; then the file is unchanged.
    pub fn revoke(&self, name: &Name) -> Result<Role, RightsError> {
        let _alone = self.lock()?;
        let mut text = self.read()?;
        let at = text
            .right
            .iter()
            .position(|entry| entry.name.get_ref() == name);
        let Some(at) = at else {
            let known: Vec<String> = (text.right.iter())
                .map(|entry| entry.name.get_ref().to_string())
                .collect();
            return Err(RightsError::Unknown {
                name: name.clone(),
                known: match known.is_empty() {
                    true => "none".to_owned(),
                    false => known.join(", "),
                },
            });
        };
        let entry = text.right.remove(at);
        self.write(&text)?;
        Ok(entry.role)
    }

    fn read(&self) -> Result<Text, RightsError> {
        match secret_file::read(&self.0) {
            Ok(text) => self.parse(&text),
            Err(error) if error.is_not_found() => Ok(Text::default()),
            Err(error) => Err(error.into()),
        }
    }

    fn parse(&self, text: &str) -> Result<Text, RightsError> {
        let path = || self.0.clone();
        let parsed: Text = toml::from_str(text).map_err(|error| RightsError::Text {
            path: path(),
            line: error.span().map_or(1, |span| line_of(text, &span)),
            said: error.message().to_owned(),
        })?;
        let count = parsed.right.len();
        if count > MOST {
            let path = path();
            return Err(RightsError::TooMany { path, count });
        }
        for (at, entry) in parsed.right.iter().enumerate() {
            let mut before = parsed.right.iter().take(at);
            if before.any(|other| other.name.get_ref() == entry.name.get_ref()) {
                return Err(RightsError::Twice {
                    path: path(),
                    line: line_of(text, &entry.name.span()),
                    name: entry.name.get_ref().clone(),
                });
            }
        }
        Ok(parsed)
    }

    fn write(&self, text: &Text) -> Result<(), RightsError> {
        let count = text.right.len();
        if count > MOST {
            let path = self.0.clone();
            return Err(RightsError::TooMany { path, count });
        }
        let blocks = toml::to_string(text).map_err(|source| RightsError::Unwritable {
            path: self.0.clone(),
            source,
        })?;
        Ok(secret_file::write(
            &self.0,
            &format!("{HEAD}\n{}", blocks.trim_end()),
        )?)
    }

    /// Waits until no other command uses the file, and locks it until the returned file is dropped.
    fn lock(&self) -> Result<File, RightsError> {
        let path = self.0.with_extension("lock");
        let made = self.0.parent().map_or(Ok(()), std::fs::create_dir_all);
        let locked = made.and_then(|()| {
            let file = File::options()
                .create(true)
                .truncate(false)
                .write(true)
                .open(&path)?;
            replaced_file::hand_over(&file, &path)?;
            file.lock()?;
            Ok(file)
        });
        locked.map_err(|source| SecretFileError::of(&path, source).into())
    }
}

/// Lines count from 1.
fn line_of(text: &str, at: &Range<usize>) -> usize {
    let before = text.as_bytes().iter().take(at.start);
    1 + before.filter(|byte| **byte == b'\n').count()
}

#[cfg(test)]
mod tests;
