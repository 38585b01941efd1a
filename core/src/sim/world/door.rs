//! Doors that open and shut.

use std::ops::Bound;

use super::WorldError;
use super::check::{check_count, check_point, check_value};
use crate::geom::Segment;

/// A sliding door: a wall while it is shut, nothing while it is open.
#[derive(Clone, Debug, PartialEq)]
pub struct Door {
    /// Where it is when it is shut, world frame, m.
    pub leaf: Segment,
    /// Whether it is open at time 0.
    pub is_open: bool,
    /// When it changes, s, in rising order: the first shuts a door that is open at time 0.
    pub switches: Vec<f64>,
}

impl Door {
    /// Whether it is open at some time, without orders from outside.
    #[must_use]
    pub fn ever_opens(&self) -> bool {
        self.is_open || !self.switches.is_empty()
    }

    pub(super) fn check(&self, part: &str) -> Result<(), WorldError> {
        check_point(part, &self.leaf.a)?;
        check_point(part, &self.leaf.b)?;
        let width = self.leaf.length();
        check_value(part, "width", width, 0.001..=1000.0, "0.001 to 1000 m")?;
        let count = self.switches.len();
        check_count(part, "switches", count, ..=10_000, "at most 10000")?;
        let expected = "rising times, above 0 and at most 1000000 s";
        let mut before = 0.0;
        for &at in &self.switches {
            let later = (Bound::Excluded(before), Bound::Included(1e6));
            check_value(part, "switch", at, later, expected)?;
            before = at;
        }
        Ok(())
    }
}
