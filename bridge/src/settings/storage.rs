//! The settings of object storage.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{Settings, SettingsError};
use crate::storage::{PART_MIB, StorageConfig};

/// `[storage]`: where it stands, finished recordings are kept there, too.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct StorageSettings {
    /// `s3://bucket/folder`, `az://container/folder`, `gs://bucket/folder`, `file:///folder`.
    pub url: String,
    /// MiB of a part, which is what is lost when the link breaks. Default 8.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part_mib: Option<u64>,
    /// Whether each recording is read back and compared. Default true.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verify: Option<bool>,
    /// Of the store: `aws_endpoint`, `aws_region`. Keys and secrets belong into the environment.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub options: BTreeMap<String, String>,
}

/// Shown in place of a secret.
const NOT_SHOWN: &str = "(not shown)";

/// Parts of the names of secrets, for every store; also of ids, which belong to them.
const SECRETS: [&str; 8] = [
    "key",
    "secret",
    "token",
    "password",
    "sas",
    "credential",
    "signature",
    "header",
];

fn is_secret(key: &str, value: &str) -> bool {
    let key = key.to_ascii_lowercase();
    // A proxy's address may contain a password.
    SECRETS.iter().any(|word| key.contains(word)) || value.contains('@')
}

impl Settings {
    /// The object storage for finished recordings, if set.
    ///
    /// # Errors    [`SettingsError::StoragePart`], [`SettingsError::Storage`].
    pub fn storage(&self) -> Result<Option<StorageConfig>, SettingsError> {
        let Some(storage) = &self.storage else {
            return Ok(None);
        };
        let default = StorageConfig::new(storage.url.clone());
        let part_mib = storage.part_mib.unwrap_or(default.part_mib);
        let (least, most) = PART_MIB;
        if !(least..=most).contains(&part_mib) {
            let value = part_mib;
            return Err(SettingsError::StoragePart { value, least, most });
        }
        let config = StorageConfig {
            options: storage.options.clone(),
            part_mib,
            verify: storage.verify.unwrap_or(default.verify),
            ..default
        };
        config.check(self.record.as_deref())?;
        Ok(Some(config))
    }

    /// The settings as they may be shown: without the store's secrets.
    #[must_use]
    pub fn without_secrets(mut self) -> Self {
        let options = self
            .storage
            .iter_mut()
            .flat_map(|storage| &mut storage.options);
        for (key, value) in options {
            if is_secret(key, value) {
                *value = NOT_SHOWN.to_owned();
            }
        }
        self
    }
}
