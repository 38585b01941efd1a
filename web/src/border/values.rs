//! Settings by their keys, as page and files name them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use slamlab_core::settings::{SettingError, Settings};
use tsify::Tsify;

/// Settings that differ from their defaults, by their keys.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, Tsify)]
#[tsify(hashmap_as_object)]
pub struct SettingValues(pub BTreeMap<String, f64>);

impl SettingValues {
    /// Sets all of them, choices before the settings that come with them.
    ///
    /// # Errors    [`SettingError`] for the first that cannot be.
    pub(crate) fn apply_to(&self, settings: &mut Settings) -> Result<(), SettingError> {
        let pairs = self.0.iter();
        settings.set_all(pairs.map(|(key, value)| (key.as_str(), *value)))
    }
}

impl SettingValues {
    /// The same of a robot that may have another sensor than they were made for; see [`Settings::set_present`].
    ///
    /// # Errors    [`SettingError`] for the first that cannot be.
    pub(crate) fn apply_present(&self, settings: &mut Settings) -> Result<(), SettingError> {
        let pairs = self.0.iter();
        settings.set_present(pairs.map(|(key, value)| (key.as_str(), *value)))
    }
}

impl<K: Into<String>> FromIterator<(K, f64)> for SettingValues {
    fn from_iter<I: IntoIterator<Item = (K, f64)>>(pairs: I) -> Self {
        Self(
            pairs
                .into_iter()
                .map(|(key, value)| (key.into(), value))
                .collect(),
        )
    }
}
