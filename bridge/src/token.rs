//! Tokens: whoever has one has the right that belongs to it ([`crate::rights`]); the bridge's first
//! token is its owner's.
//!
//! A token is 256 random bits in hexadecimal, in a file that only its owner can read. People get it
//! in the page's address, after `#`, a part that browsers send to no server; only a proof made with
//! it crosses the network ([`slamlab_core::wire::message::proof`]).

use std::fmt;
use std::path::{Path, PathBuf};

use crate::secret_file::{self, SecretFileError};

const BYTES: usize = 32;
/// 128 bits in hexadecimal; shorter tokens could be guessed some day.
const FEWEST_CHARS: usize = 32;

/// A token. It prints as dots.
#[derive(Clone)]
pub struct Token(String);

/// Why there is no token.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TokenError {
    /// The file cannot be read or written, or others can read it.
    #[error("token file {0}")]
    File(#[from] SecretFileError),
    /// The file holds no token.
    #[error(
        "token file {} holds no token, and is left as it is: {chars} characters; expected at least {FEWEST_CHARS}, letters and \
         digits only", path.display()
    )]
    Weak {
        /// The file.
        path: PathBuf,
        /// Number of characters in it.
        chars: usize,
    },
    /// The system has no random numbers.
    #[error("the system gives no random numbers: {0}")]
    Random(getrandom::Error),
    /// There is no default folder for it.
    #[error("neither XDG_CONFIG_HOME nor HOME is set; name a file with --token-file")]
    NoHome,
}

impl TokenError {
    /// Whether there is no such file.
    #[must_use]
    pub fn is_not_found(&self) -> bool {
        matches!(self, Self::File(error) if error.is_not_found())
    }
}

impl fmt::Debug for Token {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("Token(…)")
    }
}

impl Token {
    /// Makes a new random token.
    ///
    /// # Errors    [`TokenError::Random`].
    pub fn random() -> Result<Self, TokenError> {
        let mut bytes = [0; BYTES];
        getrandom::fill(&mut bytes).map_err(TokenError::Random)?;
        Ok(Self(bytes.map(|byte| format!("{byte:02x}")).concat()))
    }

    /// Reads the file, or makes it with a new token if there is none.
    ///
    /// # Errors    [`TokenError`]: the file cannot be read or made, others can read it, or its
    /// token could be guessed.
    pub fn load_or_create(path: &Path) -> Result<Self, TokenError> {
        match secret_file::read(path) {
            Ok(text) => Self::checked(path, text.trim()),
            Err(error) if error.is_not_found() => Self::create(path),
            Err(error) => Err(error.into()),
        }
    }

    /// Reads the file.
    ///
    /// # Errors    [`TokenError`]: the file cannot be read, others can read it, or its token could
    /// be guessed.
    pub fn load(path: &Path) -> Result<Self, TokenError> {
        Self::checked(path, secret_file::read(path)?.trim())
    }

    /// Replaces the token in the file by a new one; a file that holds anything else is left alone.
    ///
    /// # Errors    [`TokenError`]: the file cannot be written, or holds something else.
    pub fn renew(path: &Path) -> Result<Self, TokenError> {
        match secret_file::read(path) {
            Ok(text) => drop(Self::checked(path, text.trim())?),
            Err(error) if error.is_not_found() => (),
            Err(error) => return Err(error.into()),
        }
        Self::create(path)
    }

    /// Writes a new token to the file.
    fn create(path: &Path) -> Result<Self, TokenError> {
        let token = Self::random()?;
        secret_file::write(path, &token.0)?;
        Ok(token)
    }

    fn checked(path: &Path, text: &str) -> Result<Self, TokenError> {
        let is_plain = text.bytes().all(|byte| byte.is_ascii_alphanumeric());
        if text.len() < FEWEST_CHARS || !is_plain {
            return Err(TokenError::Weak {
                path: path.to_owned(),
                chars: text.len(),
            });
        }
        Ok(Self(text.to_owned()))
    }

    /// The token itself: for the address that a person opens, and for nothing else.
    #[must_use]
    pub fn reveal(&self) -> &str {
        &self.0
    }
}

/// The default path of the token's file.
///
/// # Errors    [`TokenError::NoHome`].
pub fn default_path() -> Result<PathBuf, TokenError> {
    let set = |name| std::env::var_os(name).filter(|value| !value.is_empty());
    let config = set("XDG_CONFIG_HOME").map(PathBuf::from);
    let config = config.or_else(|| set("HOME").map(|home| Path::new(&home).join(".config")));
    Ok(config.ok_or(TokenError::NoHome)?.join("slamlab/token"))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_token_is_made_once_and_is_private() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("deep/token");
        let made = Token::load_or_create(&path).unwrap();
        let read = Token::load_or_create(&path).unwrap();
        assert_eq!(made.reveal(), read.reveal());
        assert_eq!(made.reveal().len(), 64);
        assert_ne!(Token::renew(&path).unwrap().reveal(), made.reveal());
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = fs::metadata(&path).unwrap().permissions().mode();
            assert_eq!(mode & 0o777, 0o600);
            fs::set_permissions(&path, fs::Permissions::from_mode(0o644)).unwrap();
            let error = Token::load_or_create(&path).unwrap_err().to_string();
            assert!(error.contains("mode 644"), "{error}");
        }
    }

    #[test]
    fn a_token_that_can_be_guessed_is_refused() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("token");
        for weak in [
            "",
            "secret",
            "0123456789abcdef0123456789abcde",
            "a b c d e f g h i j k l m n o p q",
        ] {
            secret_file::write(&path, weak).unwrap();
            let error = Token::load_or_create(&path).unwrap_err();
            assert!(matches!(error, TokenError::Weak { .. }), "{weak}: {error}");
        }
    }

    /// Regression: `token --new --token-file notes.txt` overwrote the notes.
    #[test]
    fn what_is_no_token_is_never_overwritten() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("notes");
        for notes in [
            "",
            "buy batteries",
            "-----BEGIN PRIVATE KEY-----\nMIGHAgEAMBMGByqGSM49AgEG",
        ] {
            secret_file::write(&path, notes).unwrap();
            let error = Token::renew(&path).unwrap_err();
            assert!(matches!(error, TokenError::Weak { .. }), "{error}");
            assert_eq!(fs::read_to_string(&path).unwrap().trim_end(), notes);
        }
        fs::write(&path, [0xFF; 64]).unwrap();
        assert!(Token::renew(&path).is_err(), "it is no text");
        assert_eq!(fs::read(&path).unwrap(), [0xFF; 64]);
        let new = folder.path().join("new");
        assert_eq!(Token::renew(&new).unwrap().reveal().len(), 64);
    }

    #[test]
    fn it_never_prints() {
        let token = Token::random().unwrap();
        assert_eq!(format!("{token:?}"), "Token(…)");
    }
}
