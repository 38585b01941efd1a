//! How the number of a setting is stored in a field: as it is, rounded, as a switch, or as an index
//! into a list of names.

use std::mem::discriminant;

use super::setting::Named;
use crate::association::AssociationMethod;
use crate::control::Avoidance;
use crate::estimation::{Consistency, LandmarkKinds};
use crate::features::{SpikeForm, SplitRule};
use crate::map::{FreeCells, Layer};
use crate::plan::{FrontierChoice, Planner, Shortening};
use crate::points::{BreakRule, SectorRange};
use crate::registration::RegistrationMethod;
use crate::robot::{BodyShape, Sharp};
use crate::slam::PriorMapMatching;
use crate::tracking::TrackAssociation;

/// A field that holds a number.
pub(super) trait Number {
    fn number(&self) -> f64;
    fn put(&mut self, number: f64);
}

/// A field with a fixed set of values, and the names of all of them.
pub(super) trait Choice: Copy {
    const COUNT: usize;
    fn all() -> Vec<(&'static str, Self, &'static str)>;
}

/// The names of all.
pub(super) fn names<T: Choice>() -> Vec<Named> {
    let named = |(name, _, title)| Named { name, title };
    T::all().into_iter().map(named).collect()
}

/// Where a number is stored: the path of a field; or a pattern, the field that must match it and
/// the place inside; or functions to get and set it.
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
            Setting::new(&$group, [$key, $name, $meaning], $figures, at!($($at)+))
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

/// The number of a choice is its index; setting the same choice again keeps the parameters inside
/// it.
impl<T: Choice> Number for T {
    fn number(&self) -> f64 {
        let kind = discriminant(self);
        let at = T::all()
            .iter()
            .position(|(_, one, _)| discriminant(one) == kind);
        at.map_or(f64::NAN, |at| at as f64)
    }

    fn put(&mut self, number: f64) {
        if let Some((_, one, _)) = T::all().get(number as usize)
            && discriminant(one) != discriminant(self)
        {
            *self = *one;
        }
    }
}

/// How many values of a type can be chosen, and all of them; by default those of its table `ALL`.
macro_rules! choices {
    ($($kind:ty = $count:expr, $all:expr;)+) => {$(
        impl Choice for $kind {
            const COUNT: usize = $count;

            fn all() -> Vec<(&'static str, Self, &'static str)> {
                $all.into_iter().take($count).collect()
            }
        }
    )+};
    ($($kind:ty),+) => {
        choices!($($kind = <$kind>::ALL.len(), <$kind>::ALL;)+);
    };
}

choices!(
    AssociationMethod,
    Avoidance,
    BodyShape,
    Consistency,
    LandmarkKinds,
    FreeCells,
    FrontierChoice,
    Layer
);
choices!(
    PriorMapMatching,
    RegistrationMethod,
    SectorRange,
    Sharp,
    Shortening,
    SpikeForm,
    TrackAssociation
);
choices! {
    BreakRule = 3, Self::all();
    Planner = Self::CHOOSABLE, Self::ALL;
    SplitRule = 5, Self::all();
}
