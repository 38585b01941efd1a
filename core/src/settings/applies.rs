//! Which settings have an effect on a run, and why the others have none.

use super::setting::{Needs, Setting, Source};
use super::{SettingError, Settings, table};
use crate::slam::Method;

/// What decides which settings apply to a run, besides its sensor, which stands in [`Settings`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scope {
    /// What feeds it.
    pub source: Source,
    /// The SLAM method.
    pub method: Method,
}

/// Why a setting has no effect on a run, in words.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Idle(String);

impl Settings {
    /// Why a setting has no effect on a run of this scope; none if it has one.
    #[must_use]
    pub fn idle(&self, setting: &Setting, scope: &Scope) -> Option<Idle> {
        let name = setting.name;
        let (sources, methods) = (setting.sources, setting.methods);
        if !sources.contains(&scope.source) {
            let of = listed(sources.iter().map(|source| source.title()));
            let here = scope.source.title();
            return Some(Idle(format!(
                "{name} has no effect on {here}: it is a setting of {of}"
            )));
        }
        if !methods.is_empty() && !methods.contains(&scope.method) {
            let of = listed(methods.iter().map(|method| method.title()));
            let here = scope.method.title();
            return Some(Idle(format!(
                "{name} has no effect with the method {here}: it is a setting of {of}"
            )));
        }
        self.unmet(setting)
    }

    /// Why what a setting depends on, a sensor or another choice, is not given; none if it is.
    pub(super) fn unmet(&self, setting: &Setting) -> Option<Idle> {
        let name = setting.name;
        let unless = |choice: &str, of: &str| {
            Idle(format!("{name} has no effect unless \"{choice}\" is {of}"))
        };
        match setting.needs {
            Needs::Choice { key, is } if !self.chosen(key, is) => {
                let other = super::find(key).ok()?;
                let titles = other.names().into_iter();
                let titles = titles.filter(|named| is.contains(&named.name));
                let of = listed(titles.map(|named| named.title));
                Some(unless(other.name, &of))
            }
            Needs::MoreThanZero(key) if self.number(key).is_none_or(|number| number <= 0.0) => {
                Some(unless(super::find(key).ok()?.name, "more than 0"))
            }
            Needs::Sensor(sensor) if self.get(setting).is_none() => Some(Idle(format!(
                "{name} is a setting of {sensor}, and the run has another sensor"
            ))),
            _ => None,
        }
    }

    fn number(&self, key: &str) -> Option<f64> {
        super::find(key).ok().and_then(|setting| self.get(setting))
    }

    /// Whether the setting of `key` has an effect itself, and its value is one of `is`.
    fn chosen(&self, key: &str, is: &[&str]) -> bool {
        let Ok(other) = super::find(key) else {
            return false;
        };
        let at = self.get(other).map(|number| number as usize);
        let named = at.and_then(|at| other.names().get(at).copied());
        named.is_some_and(|named| is.contains(&named.name)) && self.unmet(other).is_none()
    }

    /// Sets all settings that have an effect on such a run, choices before the settings that depend
    /// on them, and returns why the others have none.
    ///
    /// # Errors    [`SettingError`] for an unknown key or a number out of range; then nothing is
    /// changed.
    pub fn take(
        &mut self,
        scope: &Scope,
        changes: impl IntoIterator<Item = (impl AsRef<str>, f64)>,
    ) -> Result<Vec<Idle>, SettingError> {
        let find = |(key, value): (_, f64)| Ok((super::find(AsRef::as_ref(&key))?, value));
        let mut changes: Vec<_> = changes.into_iter().map(find).collect::<Result<_, _>>()?;
        changes.sort_by_key(|(setting, _)| table().position(|other| other.key == setting.key));
        let mut next = self.clone();
        let mut idle = vec![];
        for (setting, value) in changes {
            setting.check(value)?;
            match next.idle(setting, scope) {
                Some(why) => idle.push(why),
                None => (setting.field.set)(&mut next, value),
            }
        }
        *self = next;
        Ok(idle)
    }
}

/// "a", "a or b", "a, b or c".
fn listed<'a>(words: impl Iterator<Item = &'a str>) -> String {
    let words: Vec<&str> = words.collect();
    match words.as_slice() {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [most @ .., last] => format!("{} or {last}", most.join(", ")),
    }
}
