//! Settings by their keys, as the page and files name them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use slamlab_core::settings::{Scope, SettingError, Settings, Source};
use slamlab_core::slam::Method;
use tsify::Tsify;

/// Settings that differ from their defaults, by their keys.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, Tsify)]
#[tsify(hashmap_as_object)]
pub struct SettingValues(pub BTreeMap<String, f64>);

impl SettingValues {
    /// Applies those settings that have an effect on a run of this scope; see [`Settings::take`].
    ///
    /// # Errors    [`SettingError`] for an unknown key, and a number out of range.
    pub(crate) fn apply_to(
        &self,
        settings: &mut Settings,
        source: Source,
        method: Method,
    ) -> Result<(), SettingError> {
        settings
            .take(&Scope { source, method }, self.pairs())
            .map(drop)
    }

    pub(crate) fn pairs(&self) -> impl Iterator<Item = (&str, f64)> {
        self.0.iter().map(|(key, value)| (key.as_str(), *value))
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
