//! Bounds of the values in a configuration, each defined once: the configuration's `validate` and
//! the table of settings use the same constant. The `config!` macro puts each default beside its
//! field.

use std::fmt;

/// Smallest and largest allowed value, both inclusive.
pub type Bounds = [f64; 2];

/// Any finite number that is not negative.
pub const NOT_NEGATIVE: Bounds = [0.0, f64::MAX];
/// Any finite number above 0.
pub const POSITIVE: Bounds = [f64::MIN_POSITIVE, f64::MAX];
/// Any finite number.
pub const FINITE: Bounds = [f64::MIN, f64::MAX];
/// A fraction of a whole, or a probability.
pub const PART: Bounds = [0.0, 1.0];

/// A configuration whose fields are written with their defaults, as `name: type = value`.
macro_rules! config {
    (
        $(#[$attribute:meta])*
        pub struct $name:ident {
            $($(#[$doc:meta])* pub $field:ident: $kind:ty = $default:expr,)*
        }
    ) => {
        $(#[$attribute])*
        pub struct $name {
            $($(#[$doc])* pub $field: $kind,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }
    };
}
pub(crate) use config;

/// A value outside its bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutOfBounds {
    /// Its name in the configuration.
    pub figure: &'static str,
    /// The value.
    pub value: f64,
    /// The bounds.
    pub bounds: Bounds,
}

impl fmt::Display for OutOfBounds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is {}, expected ", self.figure, self.value)?;
        match self.bounds {
            FINITE => write!(f, "a finite number"),
            NOT_NEGATIVE => write!(f, "a finite number, at least 0"),
            POSITIVE => write!(f, "a finite number, greater than 0"),
            [least, most] => write!(f, "{least} to {most}"),
        }
    }
}

impl std::error::Error for OutOfBounds {}

/// Checks values, each with its name and bounds.
///
/// # Errors    [`OutOfBounds`] for the first value outside its bounds, or NaN.
pub fn check(figures: &[(&'static str, f64, Bounds)]) -> Result<(), OutOfBounds> {
    let outside = |(_, value, [least, most]): &&(_, f64, Bounds)| !(least..=most).contains(&value);
    match figures.iter().find(outside) {
        Some(&(figure, value, bounds)) => Err(OutOfBounds {
            figure,
            value,
            bounds,
        }),
        None => Ok(()),
    }
}

/// A limit that may be infinite, which stands for no limit: then the largest allowed finite value.
#[must_use]
pub fn or_no_limit(value: f64, bounds: Bounds) -> f64 {
    if value == f64::INFINITY {
        bounds[1]
    } else {
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_bounds_are_allowed_and_what_lies_beyond_is_named() {
        let said = |value, bounds| match check(&[("gate", value, bounds)]) {
            Ok(()) => String::new(),
            Err(error) => error.to_string(),
        };
        assert_eq!(said(1.0, PART) + &said(0.0, PART), "");
        assert_eq!(said(1.5, PART), "gate is 1.5, expected 0 to 1");
        assert_eq!(said(f64::NAN, PART), "gate is NaN, expected 0 to 1");
        assert!(said(f64::INFINITY, NOT_NEGATIVE).ends_with("at least 0"));
        assert!(said(0.0, POSITIVE).ends_with("greater than 0"));
        assert_eq!(or_no_limit(f64::INFINITY, PART), 1.0);
        assert_eq!(or_no_limit(0.5, PART), 0.5);
    }
}
