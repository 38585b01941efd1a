//! In: options that several programs take. Out: what they say.

use std::path::Path;

use anyhow::{Context, Result};
use slamlab_core::format::preset;
use slamlab_core::settings::Settings;

/// Changes settings by a preset file, then by single ones.
pub(crate) fn change(
    settings: &mut Settings,
    preset: Option<&Path>,
    single: &[(String, f64)],
) -> Result<()> {
    if let Some(path) = preset {
        let name = || format!("preset {}", path.display());
        let preset = preset::read(&std::fs::read(path).with_context(name)?).with_context(name)?;
        let changes = (preset.settings.iter()).map(|(key, value)| (key.as_str(), *value));
        settings.set_all(changes).with_context(name)?;
    }
    for (key, value) in single {
        settings.set(key, *value).context("--set")?;
    }
    Ok(())
}

/// A setting as `KEY=NUMBER`.
pub(crate) fn setting(text: &str) -> Result<(String, f64), String> {
    let (key, number) = text.split_once('=').ok_or("expected KEY=NUMBER")?;
    let number = number
        .parse()
        .map_err(|error| format!("{number}: {error}"))?;
    Ok((key.to_owned(), number))
}
