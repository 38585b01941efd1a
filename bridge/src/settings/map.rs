//! What the settings say of mapping.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use slamlab_core::slam::Method;

use super::{Settings, SettingsError};
use crate::mapping::MapConfig;

/// Longest time between two times that the map is written, s: a day.
const LONGEST: u64 = 24 * 60 * 60;

/// `[map]`: where it stands, the bridge maps.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct MapSettings {
    /// Where the map is kept (`.slamlab`); without it, it is gone with the program.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Name of the method. Default `scan-matching`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<String>,
    /// Between two times that it is written, s. Default 30.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub save_seconds: Option<u64>,
    /// Settings of the page, by their keys, that differ from their defaults.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub set: BTreeMap<String, f64>,
}

impl MapSettings {
    /// These, and those of `below` where these say nothing.
    #[must_use]
    pub fn over(self, below: Self) -> Self {
        let mut set = below.set;
        set.extend(self.set);
        Self {
            file: self.file.or(below.file),
            method: self.method.or(below.method),
            save_seconds: self.save_seconds.or(below.save_seconds),
            set,
        }
    }

    pub(super) fn complete(self) -> Result<Self, SettingsError> {
        let config = self.config()?;
        Ok(Self {
            method: Some(config.method.name().to_owned()),
            save_seconds: Some(config.save_every.as_secs()),
            ..self
        })
    }

    /// How the bridge maps.
    ///
    /// # Errors    [`SettingsError::MapMethod`], [`SettingsError::MapSave`].
    pub fn config(&self) -> Result<MapConfig, SettingsError> {
        let default = MapConfig::default();
        let method = self.method.as_deref().map(str::parse::<Method>);
        let save_every = match self.save_seconds {
            None => default.save_every,
            Some(value @ 1..=LONGEST) => Duration::from_secs(value),
            Some(value) => {
                let most = LONGEST;
                return Err(SettingsError::MapSave { value, most });
            }
        };
        Ok(MapConfig {
            file: self.file.clone(),
            method: method.transpose()?.unwrap_or(default.method),
            settings: self.set.clone().into_iter().collect(),
            save_every,
        })
    }
}

impl Settings {
    /// Whether and how the bridge maps.
    ///
    /// # Errors    [`SettingsError`].
    pub fn map(&self) -> Result<Option<MapConfig>, SettingsError> {
        self.map.as_ref().map(MapSettings::config).transpose()
    }
}
