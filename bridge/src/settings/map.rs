//! The settings of mapping.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use clap::ValueEnum;
use serde::{Deserialize, Serialize};
use slamlab_core::live::HomingConfig;
use slamlab_core::slam::Method;

use super::{Settings, SettingsError};
use crate::mapping::{HomeConfig, MapConfig};
use crate::rights::Name;

/// Least and greatest volts of a battery.
const VOLTS: (f32, f32) = (1.0, 100.0);
/// Longest interval at which the map is written, s: a day.
const LONGEST: u64 = 24 * 60 * 60;

/// What the robot does when something is lost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Failsafe {
    /// It stands where it is.
    #[default]
    Hold,
    /// It goes to where it was armed, along the known way; in any doubt it stands.
    Home,
}

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
    /// What the robot does when the link to its driver is lost. Default `hold`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on_link_loss: Option<Failsafe>,
    /// What it does when its battery gets low. Default `hold`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on_low_battery: Option<Failsafe>,
    /// Below so many volts the battery is low. Default 6.6, for six cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub low_volts: Option<f32>,
    /// The right by which it goes home: a driver's, made for that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failsafe_right: Option<Name>,
    /// Settings of the page, by their keys, that differ from their defaults.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub set: BTreeMap<String, f64>,
}

impl MapSettings {
    /// These settings, completed by those of `below`.
    #[must_use]
    pub fn over(self, below: Self) -> Self {
        let mut set = below.set;
        set.extend(self.set);
        Self {
            file: self.file.or(below.file),
            method: self.method.or(below.method),
            save_seconds: self.save_seconds.or(below.save_seconds),
            on_link_loss: self.on_link_loss.or(below.on_link_loss),
            on_low_battery: self.on_low_battery.or(below.on_low_battery),
            low_volts: self.low_volts.or(below.low_volts),
            failsafe_right: self.failsafe_right.or(below.failsafe_right),
            set,
        }
    }

    pub(super) fn complete(self) -> Result<Self, SettingsError> {
        let config = self.config()?;
        let low_volts = config.home.as_ref().map(|home| home.when.low_volts);
        Ok(Self {
            method: Some(config.method.name().to_owned()),
            save_seconds: self.file.as_ref().map(|_| config.save_every.as_secs()),
            on_link_loss: Some(self.on_link_loss.unwrap_or_default()),
            on_low_battery: Some(self.on_low_battery.unwrap_or_default()),
            low_volts,
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
            Some(_) if self.file.is_none() => {
                let why = "the map is kept in no file";
                let key = "save-seconds";
                return Err(SettingsError::Idle { key, why });
            }
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
            home: self.home()?,
        })
    }

    /// When the robot goes home by itself; none if it always holds.
    fn home(&self) -> Result<Option<HomeConfig>, SettingsError> {
        let goes = |what: Option<Failsafe>| what == Some(Failsafe::Home);
        let default = HomingConfig::default();
        let low_volts = self.low_volts.unwrap_or(default.low_volts);
        if !(VOLTS.0..=VOLTS.1).contains(&low_volts) {
            let (value, (least, most)) = (low_volts, VOLTS);
            return Err(SettingsError::LowVolts { value, least, most });
        }
        let when = HomingConfig {
            on_link_loss: goes(self.on_link_loss),
            on_low_battery: goes(self.on_low_battery),
            low_volts,
            ..default
        };
        if !when.on_link_loss && !when.on_low_battery {
            let given = [
                ("failsafe-right", self.failsafe_right.is_some()),
                ("low-volts", self.low_volts.is_some()),
            ];
            let why = "neither on-link-loss nor on-low-battery is home";
            return match given.into_iter().find(|(_, is_given)| *is_given) {
                Some((key, _)) => Err(SettingsError::Idle { key, why }),
                None => Ok(None),
            };
        }
        let right = self.failsafe_right.clone();
        let right = right.ok_or(SettingsError::NoFailsafeRight)?;
        Ok(Some(HomeConfig { right, when }))
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
