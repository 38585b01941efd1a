//! What a row of the table says of a setting.

use super::{SettingError, Settings};
use crate::bounds::Bounds;
use crate::slam::Method;

/// One setting.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Its name in links, files and messages; unique and permanent.
    pub key: &'static str,
    /// The group that it belongs to.
    pub group: &'static str,
    /// Its name for people.
    pub name: &'static str,
    /// What it does, in one line, and what happens when it grows.
    pub meaning: &'static str,
    /// The kind of its number.
    pub kind: Kind,
    /// Smallest and largest number that is accepted, as stored.
    pub range: Bounds,
    /// Units of the number as stored and as people read it.
    pub unit: Unit,
    /// The sources that have it.
    pub sources: &'static [Source],
    /// The methods that use it; empty means all.
    pub methods: &'static [Method],
    /// What else it depends on.
    pub needs: Needs,
    /// Whether it is among the few that everybody sees first.
    pub is_basic: bool,
    /// When a change takes effect.
    pub acts: Acts,
    pub(super) field: Field,
}

/// The kind of a setting's number.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// Any number within the range.
    Real,
    /// A whole number.
    Whole,
    /// 0 or 1.
    Switch,
    /// An index into these names.
    Choice(fn() -> Vec<Named>),
}

/// One of the values of a choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Named {
    /// Its name in messages; permanent.
    pub name: &'static str,
    /// What a person calls it.
    pub title: &'static str,
}

/// Units of a number: shown = scale · stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// SI; empty for a pure number.
    pub stored: &'static str,
    /// The unit shown to people.
    pub shown: &'static str,
    /// Shown units per stored unit.
    pub scale: f64,
}

/// The source of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// A simulated robot.
    Simulation,
    /// A recording.
    Recording,
    /// A live robot.
    Live,
}

impl Source {
    /// All sources, with the names used by pages, and their titles for people.
    pub const ALL: [(&'static str, Self, &'static str); 3] = [
        ("sim", Self::Simulation, "a simulated robot"),
        ("replay", Self::Recording, "a recording"),
        ("bridge", Self::Live, "a live robot"),
    ];

    /// What a person calls it.
    #[must_use]
    pub fn title(self) -> &'static str {
        let row = Self::ALL.iter().find(|(_, source, _)| *source == self);
        row.map_or("", |(_, _, title)| title)
    }
}

/// What a setting depends on, besides source and method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Needs {
    /// Nothing.
    Nothing,
    /// A sensor of this kind.
    Sensor(&'static str),
    /// The choice of this key must have one of these names, or the switch of this key must be `on`.
    Choice {
        /// Key of the other setting.
        key: &'static str,
        /// Names of the values required.
        is: &'static [&'static str],
    },
    /// The number of this key must be greater than 0.
    MoreThanZero(&'static str),
}

/// When a change takes effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acts {
    /// At the next scan or tick.
    AtOnce,
    /// When the run starts again.
    OnRestart,
}

/// Where the number is stored in [`Settings`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Field {
    pub(super) get: fn(&Settings) -> Option<f64>,
    pub(super) set: fn(&mut Settings, f64),
}

/// What the settings of a group have in common, unless one says otherwise.
#[derive(Clone, Copy)]
pub(super) struct Group {
    pub(super) name: &'static str,
    pub(super) sources: &'static [Source],
    pub(super) methods: &'static [Method],
    pub(super) needs: Needs,
    pub(super) acts: Acts,
}

/// Kind, range and unit of a number.
type Figures = (Kind, Bounds, Unit);

pub(super) const NUMBER: Unit = si("");
pub(super) const METRES: Unit = si("m");
pub(super) const SQUARE_METRES: Unit = si("m²");
pub(super) const SECONDS: Unit = si("s");
pub(super) const VOLTS: Unit = si("V");
/// Standard deviations of a distribution.
pub(super) const SIGMAS: Unit = si("σ");
/// Squared Mahalanobis distance.
pub(super) const D2: Unit = si("d²");
pub(super) const CENTIMETRES: Unit = unit("m", "cm", 100.0);
pub(super) const CENTIMETRES_PER_METRE: Unit = unit("m/m", "cm/m", 100.0);
pub(super) const MILLISECONDS: Unit = unit("s", "ms", 1000.0);
pub(super) const PERCENT: Unit = unit("", "%", 100.0);
const PER_RADIAN: f64 = 180.0 / std::f64::consts::PI;
pub(super) const DEGREES: Unit = unit("rad", "°", PER_RADIAN);
pub(super) const DEGREES_PER_METRE: Unit = unit("rad/m", "°/m", PER_RADIAN);

/// A unit that is shown as it is stored.
pub(super) const fn si(stored: &'static str) -> Unit {
    unit(stored, stored, 1.0)
}

const fn unit(stored: &'static str, shown: &'static str, scale: f64) -> Unit {
    Unit {
        stored,
        shown,
        scale,
    }
}

pub(super) const fn real(range: Bounds, unit: Unit) -> Figures {
    (Kind::Real, range, unit)
}

pub(super) const fn whole(range: Bounds, unit: Unit) -> Figures {
    (Kind::Whole, range, unit)
}

pub(super) const fn switch() -> Figures {
    (Kind::Switch, [0.0, 1.0], NUMBER)
}

pub(super) const fn one_of<T: super::field::Choice>() -> Figures {
    named(T::COUNT, super::field::names::<T>)
}

/// A choice whose names stand in the table.
pub(super) const fn named(count: usize, names: fn() -> Vec<Named>) -> Figures {
    (Kind::Choice(names), [0.0, count as f64 - 1.0], NUMBER)
}

impl Named {
    /// All values, each with its name and its title for people.
    pub(super) fn all(words: &[(&'static str, &'static str)]) -> Vec<Self> {
        let named = |&(name, title)| Self { name, title };
        words.iter().map(named).collect()
    }
}

impl Setting {
    pub(super) const fn new(
        group: &Group,
        [key, name, meaning]: [&'static str; 3],
        (kind, range, unit): Figures,
        field: Field,
    ) -> Self {
        Self {
            key,
            group: group.name,
            name,
            meaning,
            kind,
            range,
            unit,
            sources: group.sources,
            methods: group.methods,
            needs: group.needs,
            is_basic: false,
            acts: group.acts,
            field,
        }
    }

    pub(super) const fn basic(mut self) -> Self {
        self.is_basic = true;
        self
    }

    pub(super) const fn at_once(mut self) -> Self {
        self.acts = Acts::AtOnce;
        self
    }

    pub(super) const fn on_restart(mut self) -> Self {
        self.acts = Acts::OnRestart;
        self
    }

    pub(super) const fn methods(mut self, methods: &'static [Method]) -> Self {
        self.methods = methods;
        self
    }

    pub(super) const fn needs(mut self, key: &'static str, is: &'static [&'static str]) -> Self {
        self.needs = Needs::Choice { key, is };
        self
    }

    pub(super) const fn needs_more_than_zero(mut self, key: &'static str) -> Self {
        self.needs = Needs::MoreThanZero(key);
        self
    }

    /// The values of a choice, `off` and `on` for a switch; empty for a number.
    #[must_use]
    pub fn names(&self) -> Vec<Named> {
        match self.kind {
            Kind::Choice(names) => names(),
            Kind::Switch => Named::all(&[("off", "off"), ("on", "on")]),
            Kind::Real | Kind::Whole => vec![],
        }
    }

    pub(super) fn check(&self, value: f64) -> Result<(), SettingError> {
        let [low, high] = self.range;
        let is_whole = matches!(self.kind, Kind::Real) || value.fract() == 0.0;
        if (low..=high).contains(&value) && is_whole {
            return Ok(());
        }
        let unit = match self.unit.stored {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        let whole = match self.kind {
            Kind::Real => "",
            _ => "a whole number from ",
        };
        let expected = format!("{whole}{low} to {high}{unit}");
        Err(SettingError::Range {
            name: self.name,
            value,
            unit,
            expected,
        })
    }
}
