//! How the number of a setting stands in a field: as it is, rounded, as a switch, or as the place
//! in a list of names.

use super::setting::Named;
use crate::association::AssociationMethod;
use crate::control::Avoidance;
use crate::estimation::Consistency;
use crate::features::SplitRule;
use crate::map::{FreeCells, Layer};
use crate::plan::{FrontierChoice, Planner, Shortening};
use crate::points::{BreakRule, SectorRange};
use crate::registration::RegistrationMethod;
use crate::robot::{BodyShape, Sharp};
use crate::slam::PriorMapMatching;

/// A field that holds a number.
pub(super) trait Number {
    fn number(&self) -> f64;
    fn put(&mut self, number: f64);
}

/// A field that holds one of few, with the names of all of them.
pub(super) trait Choice: Sized {
    const COUNT: usize;
    fn all() -> Vec<(&'static str, Self, &'static str)>;
}

/// The names of all.
pub(super) fn names<T: Choice>() -> Vec<Named> {
    let named = |(name, _, title)| Named { name, title };
    T::all().into_iter().map(named).collect()
}

/// Where a number stands: the path of a field; a pattern, the field that must match it and the
/// place within; or how to get and set it.
macro_rules! at {
    (get $get:expr, set $set:expr) => {
        Field { get: $get, set: $set }
    };
    ($pattern:pat = $($field:ident).+ => $place:expr) => {
        Field {
            get: |settings| match &settings.$($field).+ {
                $pattern => Some(($place).number()),
                #[allow(unreachable_patterns, reason = "some patterns hold always")]
                _ => None,
            },
            set: |settings, number| {
                if let $pattern = &mut settings.$($field).+ {
                    ($place).put(number);
                }
            },
        }
    };
    ($($field:ident).+) => {
        Field {
            get: |settings| Some(settings.$($field).+.number()),
            set: |settings, number| settings.$($field).+.put(number),
        }
    };
}

/// A part of the table: for each setting its key, name, figures, field, attributes and meaning.
macro_rules! rows {
    ($table:ident = $group:expr; $($key:literal, $name:literal, $figures:expr, [$($at:tt)+]
        $(.$attribute:ident($($value:expr),*))*, $meaning:literal;)+) => {
        pub(super) const $table: &[Setting] = &[$(
            Setting::new(&$group, [$key, $name, $meaning], &$figures, at!($($at)+))
                $(.$attribute($($value),*))*,
        )+];
    };
}

pub(super) use {at, rows};

impl Number for f64 {
    fn number(&self) -> f64 {
        *self
    }

    fn put(&mut self, number: f64) {
        *self = number;
    }
}

impl Number for usize {
    fn number(&self) -> f64 {
        *self as f64
    }

    fn put(&mut self, number: f64) {
        *self = number as Self;
    }
}

impl Number for u32 {
    fn number(&self) -> f64 {
        f64::from(*self)
    }

    fn put(&mut self, number: f64) {
        *self = number as Self;
    }
}

impl Number for bool {
    fn number(&self) -> f64 {
        f64::from(u8::from(*self))
    }

    fn put(&mut self, number: f64) {
        *self = number > 0.5;
    }
}

/// A choice whose table is a constant of the type.
macro_rules! choices {
    ($($kind:ty),+) => {$(
        impl Choice for $kind {
            const COUNT: usize = <$kind>::ALL.len();

            fn all() -> Vec<(&'static str, Self, &'static str)> {
                <$kind>::ALL.to_vec()
            }
        }

        numbers!($kind);
    )+};
}

/// The number of a choice is its place; figures of a rule stay while the rule does.
macro_rules! numbers {
    ($($kind:ty),+) => {$(
        impl Number for $kind {
            fn number(&self) -> f64 {
                let kind = std::mem::discriminant(self);
                let all = <$kind as Choice>::all();
                let at = all.iter().position(|(_, one, _)| std::mem::discriminant(one) == kind);
                at.map_or(f64::NAN, |at| at as f64)
            }

            fn put(&mut self, number: f64) {
                let all = <$kind as Choice>::all();
                let Some((_, one, _)) = all.get(number as usize) else {
                    return;
                };
                if std::mem::discriminant(one) != std::mem::discriminant(self) {
                    *self = *one;
                }
            }
        }
    )+};
}

choices!(
    AssociationMethod,
    Avoidance,
    BodyShape,
    Consistency,
    FreeCells,
    FrontierChoice,
    Layer,
    PriorMapMatching,
    RegistrationMethod,
    SectorRange,
    Sharp,
    Shortening
);
numbers!(BreakRule, Planner, SplitRule);

impl Choice for Planner {
    const COUNT: usize = Self::CHOOSABLE;

    fn all() -> Vec<(&'static str, Self, &'static str)> {
        Self::ALL.into_iter().take(Self::CHOOSABLE).collect()
    }
}

impl Choice for SplitRule {
    const COUNT: usize = 3;

    fn all() -> Vec<(&'static str, Self, &'static str)> {
        Self::all().to_vec()
    }
}

impl Choice for BreakRule {
    const COUNT: usize = 3;

    fn all() -> Vec<(&'static str, Self, &'static str)> {
        Self::all().to_vec()
    }
}
