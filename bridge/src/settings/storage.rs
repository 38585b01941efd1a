//! What the settings say of object storage.

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

impl Settings {
    /// Where finished recordings are kept, too.
    ///
    /// # Errors    [`SettingsError::StoragePart`].
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
        Ok(Some(StorageConfig {
            options: storage.options.clone(),
            part_mib,
            verify: storage.verify.unwrap_or(default.verify),
            ..default
        }))
    }
}
