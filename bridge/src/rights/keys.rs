//! Where the rights come from, and how a running bridge notices that they change.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use tokio::sync::watch;

use super::{Rights, RightsError, RightsFile};
use crate::token::{Token, TokenError};

/// Interval between checks of the files.
const LOOK: Duration = Duration::from_millis(250);

/// Where the rights come from.
#[derive(Clone, Debug, Default)]
pub enum Keys {
    /// Nobody has a right.
    #[default]
    None,
    /// Whoever has this token is the owner, as long as the bridge runs.
    Token(Token),
    /// From files, which are checked while the bridge runs.
    Files(Files),
}

/// The files.
#[derive(Clone, Debug)]
pub struct Files {
    /// The owner's token, as [`Token::load_or_create`] makes it.
    pub token: PathBuf,
    /// All other rights.
    pub rights: RightsFile,
}

/// Why there are no rights.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum KeysError {
    /// There is no owner's token.
    #[error(transparent)]
    Token(#[from] TokenError),
    /// The other rights cannot be read.
    #[error(transparent)]
    Rights(#[from] RightsError),
}

impl Keys {
    /// The present rights.
    ///
    /// # Errors    [`KeysError`].
    pub fn read(&self) -> Result<Rights, KeysError> {
        match self {
            Self::None => Ok(Rights::default()),
            Self::Token(token) => Ok(Rights(vec![Rights::owner(token)])),
            Self::Files(files) => {
                let mut all = vec![Rights::owner(&Token::load(&files.token)?)];
                all.extend(files.rights.granted()?);
                Ok(Rights(all))
            }
        }
    }
}

impl Files {
    /// The rights that can be read, and what is wrong with the rest: a file that cannot be read
    /// grants no rights.
    fn look(&self) -> (Rights, Vec<String>) {
        let owner = Token::load(&self.token).map(|token| vec![Rights::owner(&token)]);
        let owner = owner.map_err(|error| error.to_string());
        let others = self.rights.granted().map_err(|error| error.to_string());
        let mut all = Rights::default();
        let mut faults = vec![];
        for part in [owner, others] {
            match part {
                Ok(part) => all.0.extend(part),
                Err(fault) => faults.push(fault),
            }
        }
        (all, faults)
    }
}

/// Reports every change of the rights, as long as somebody listens.
pub(crate) async fn keep_up(keys: Keys, rights: watch::Sender<Arc<Rights>>) {
    let Keys::Files(files) = keys else {
        return rights.closed().await;
    };
    let mut told = vec![];
    loop {
        tokio::select! {
            () = tokio::time::sleep(LOOK) => (),
            () = rights.closed() => return,
        }
        let files = files.clone();
        // The disk may be slow, and the robot must not wait for it.
        let Ok((now, faults)) = tokio::task::spawn_blocking(move || files.look()).await else {
            return;
        };
        if faults != told {
            for fault in &faults {
                tracing::error!("nobody has a right by this file any more: {fault}");
            }
            told = faults;
        }
        rights.send_if_modified(|before| {
            let has_changed = **before != now;
            if has_changed {
                tracing::info!("the rights have changed; there are {} now", now.count());
                *before = Arc::new(now);
            }
            has_changed
        });
    }
}
