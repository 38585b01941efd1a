//! Replaces the module in a program built without Zenoh, and says so.

use std::sync::Arc;

use tokio::sync::watch;

use super::{ZenohConfig, ZenohError};
use crate::rights::Rights;
use crate::shared::Shared;

/// Never exists.
pub(crate) enum Ready {}

/// # Errors    [`ZenohError::NotBuilt`], always.
#[allow(
    clippy::needless_pass_by_value,
    reason = "as where the program was built with it"
)]
pub(crate) fn ready(_: ZenohConfig) -> Result<Ready, ZenohError> {
    Err(ZenohError::NotBuilt)
}

impl Ready {
    pub(crate) fn check_rights(&self, _: &Rights) -> Result<(), ZenohError> {
        match *self {}
    }

    pub(crate) fn start(self, _: Arc<Shared>, _: watch::Receiver<bool>) {
        match self {}
    }
}
