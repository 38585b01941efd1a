//! Settings of the line filter.

use crate::association::AssociationConfig;

/// Where the Jacobians are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Consistency {
    /// At the newest estimate: the textbook filter.
    Plain,
    /// At the first estimate of each landmark and the predicted pose, so that what cannot be observed stays unobserved.
    FirstEstimates,
}

/// Settings of the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EkfConfig {
    /// How sightings are matched.
    pub association: AssociationConfig,
    /// Where the Jacobians are taken.
    pub consistency: Consistency,
    /// Sightings after which a line counts as a wall. Default 3.
    pub confirm_sightings: u32,
    /// Scans after which a line that is not confirmed is forgotten. Default 15.
    pub patience: u32,
    /// What the fit does not know about α (skew within a sweep, walls that are not flat), rad. Default 0.001. Added to each
    /// sighting; growing makes the filter more cautious.
    pub alpha_sigma: f64,
    /// What the fit does not know about r, m. Default 0.002.
    pub r_sigma: f64,
}

impl Default for EkfConfig {
    fn default() -> Self {
        Self {
            association: AssociationConfig::default(),
            consistency: Consistency::FirstEstimates,
            confirm_sightings: 3,
            patience: 15,
            alpha_sigma: 0.001,
            r_sigma: 0.002,
        }
    }
}
