//! The result of a report: figures, and the requirements on them that do not hold.

use serde_json::{Map, Value, json};

/// Figures by name, and the requirements that were not met.
#[derive(Default)]
pub(crate) struct Outcome {
    figures: Map<String, Value>,
    failures: Vec<String>,
}

#[allow(
    dead_code,
    reason = "each report uses the kinds of requirement that it has"
)]
impl Outcome {
    /// Adds a figure; `key` says the quantity and its unit, as in `step_median_ms`.
    pub(crate) fn figure(&mut self, key: impl Into<String>, value: impl Into<Value>) {
        self.figures.insert(key.into(), value.into());
    }

    /// Adds a figure that must not be greater than `most`.
    pub(crate) fn at_most(&mut self, key: &str, value: f64, most: f64) {
        self.figure(key, value);
        self.require(value <= most, || {
            format!("{key} is {value}, expected at most {most}")
        });
    }

    /// Adds a figure that must not be less than `least`.
    pub(crate) fn at_least(&mut self, key: &str, value: f64, least: f64) {
        self.figure(key, value);
        self.require(value >= least, || {
            format!("{key} is {value}, expected at least {least}")
        });
    }

    /// Adds a figure that must lie in the band from `low` to `high`, which is given beside it.
    pub(crate) fn within(&mut self, key: &str, value: f64, [low, high]: [f64; 2]) {
        self.figure(key, value);
        self.figure(format!("{key}_band"), json!([low, high]));
        self.require((low..=high).contains(&value), || {
            format!("{key} is {value}, expected {low} to {high}")
        });
    }

    /// Records a requirement. If it does not hold, `failure` says what was found and what was
    /// expected. NaN never holds.
    pub(crate) fn require(&mut self, holds: bool, failure: impl FnOnce() -> String) {
        if !holds {
            self.failures.push(failure());
        }
    }

    pub(crate) fn failures(&self) -> &[String] {
        &self.failures
    }

    pub(crate) fn to_json(&self, name: &str) -> Value {
        let mut object = Map::new();
        object.insert("report".into(), name.into());
        object.insert("holds".into(), self.failures.is_empty().into());
        object.extend(self.figures.clone());
        object.insert("failures".into(), json!(self.failures));
        Value::Object(object)
    }
}
