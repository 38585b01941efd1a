//! Turns changes of the safety state into entries of the audit.

use std::time::Duration;

use slamlab_core::wire::message::{SafetyBody, ToBridge};

use super::{What, Who};

/// The last safety state, and who drove in it.
#[derive(Debug, Default)]
pub(crate) struct Story {
    state: SafetyBody,
    driver: Option<Who>,
    armed_at: Duration,
}

impl Story {
    /// Whether this stop changes nothing.
    pub(crate) fn stands(&self, message: &ToBridge) -> bool {
        let cuts_off = matches!(message, ToBridge::EmergencyStop);
        !self.state.armed && (self.state.emergency || !cuts_off)
    }

    /// Takes the new state and returns its entries. `by` sent the message that led to it, `driver`
    /// has the lease in it.
    pub(crate) fn goes_on(
        &mut self,
        now: Duration,
        state: &SafetyBody,
        by: Option<&Who>,
        driver: Option<Who>,
    ) -> Vec<What> {
        let before = std::mem::replace(&mut self.state, state.clone());
        let drove = std::mem::replace(&mut self.driver, driver);
        let cause = state.reason;
        let mut all = vec![];
        if before.armed && !(state.armed && before.driver == state.driver) {
            all.push(What::Stops {
                who: drove.clone(),
                cause,
                by: by.cloned(),
                after_seconds: rounded(now.saturating_sub(self.armed_at)),
            });
        }
        if state.emergency && !before.emergency {
            let by = by.cloned();
            all.push(What::EmergencyStop { cause, by });
        }
        if before.emergency && !state.emergency {
            all.push(What::EmergencyReset { by: by.cloned() });
        }
        if before.driver != state.driver {
            all.extend(drove.map(|who| What::LeaseEnds { who }));
            all.extend(self.driver.clone().map(|who| What::Lease { who }));
        }
        if state.armed && !(before.armed && before.driver == state.driver) {
            self.armed_at = now;
            all.extend(self.driver.clone().map(|who| What::Drives { who }));
        }
        all
    }
}

/// In seconds, rounded to milliseconds.
fn rounded(duration: Duration) -> f64 {
    (1e3 * duration.as_secs_f64()).round() / 1e3
}
