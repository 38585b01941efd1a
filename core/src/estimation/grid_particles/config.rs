//! Settings of grid mapping by particles, and why it may refuse to start.

use super::super::scan_matching::ScanMatcherError;
use crate::bounds::{Bounds, OutOfBounds, check, config};
use crate::map::{GridError, SurfelConfig};
use crate::registration::MatchConfig;

config! {
    /// How grid mapping by particles works.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct GridParticlesConfig {
        /// Of the random numbers. Default 1.
        pub seed: u64 = 1,
        /// How many particles there are. Default 40; larger: longer loops close well, slower.
        pub count: usize = 40,
        /// A scan is taken in after this way, m. Default 1; larger: faster, and less noise gathers,
        /// until scans no longer overlap.
        pub way: f64 = 1.0,
        /// And after this turn, rad. Default 0.5.
        pub turn: f64 = 0.5,
        /// How far the motion between two such scans may be off: along the way as a part of it; the
        /// heading as a part of the turn, and per metre, rad. Default 0.04, 0.03 and 0.03; larger:
        /// particles spread more where the map says little, as along a corridor.
        pub motion_noise: [f64; 3] = [0.04, 0.03, 0.03],
        /// The motion is never believed better than this, m and rad. Default 0.01 and 0.02.
        pub least_noise: [f64; 2] = [0.01, 0.02],
        /// How a scan is matched to the map of a particle.
        pub matching: MatchConfig = MatchConfig::default(),
        /// A match counts where it puts this part of a scan on the map. Default 0.3; below that the
        /// pose is drawn from the motion alone.
        pub matched_above: f64 = 0.3,
        /// Standard deviation of a point from its surface, m: of beam and map. Default 0.05;
        /// smaller: weights say more.
        pub sigma: f64 = 0.05,
        /// So many points of a scan say something of their own; neighbours err alike. Default 40;
        /// larger: poses are drawn nearer to the match.
        pub independent_points: f64 = 40.0,
        /// The part of a scan that says something which the scans before did not: the weight counts
        /// with this power, while the pose is drawn from all of it. Default 0.1; larger: fewer
        /// particles survive until a loop closes.
        pub news: f64 = 0.1,
        /// A point farther from its surface than so many standard deviations is an outlier, and how
        /// far it is does not matter. Default 3.
        pub outlier_sigmas: f64 = 3.0,
        /// What a point where nothing was seen before speaks against a pose, as a part of what an
        /// outlier does. Default 0.6; larger: particles that fit into the old map are preferred.
        pub unknown_part: f64 = 0.6,
        /// Particles are drawn anew where the effective number falls below this part of them.
        /// Default 0.5.
        pub resample_below: f64 = 0.5,
        /// How the surfaces of each map are kept.
        pub surfels: SurfelConfig = SurfelConfig::default(),
    }
}

impl GridParticlesConfig {
    /// What [`Self::count`] may be.
    pub const COUNT: Bounds = [1.0, 500.0];
    /// What [`Self::way`] may be, m.
    pub const WAY: Bounds = [0.02, 5.0];
    /// What [`Self::turn`] may be, rad.
    pub const TURN: Bounds = [0.02, 3.0];
    /// What [`Self::sigma`] may be, m.
    pub const SIGMA: Bounds = [0.005, 0.5];
    /// What [`Self::independent_points`] may be.
    pub const INDEPENDENT_POINTS: Bounds = [1.0, 1000.0];
    /// What [`Self::news`] may be.
    pub const NEWS: Bounds = [0.001, 1.0];
    /// What [`Self::resample_below`] may be.
    pub const RESAMPLE_BELOW: Bounds = [0.0, 1.0];

    /// Checks all values.
    ///
    /// # Errors   [`GridParticlesError`], naming the first one out of its bounds.
    pub fn validate(&self) -> Result<(), GridParticlesError> {
        Ok(check(&[
            ("count", self.count as f64, Self::COUNT),
            ("way", self.way, Self::WAY),
            ("turn", self.turn, Self::TURN),
            ("sigma", self.sigma, Self::SIGMA),
            (
                "independent_points",
                self.independent_points,
                Self::INDEPENDENT_POINTS,
            ),
            ("news", self.news, Self::NEWS),
            ("resample_below", self.resample_below, Self::RESAMPLE_BELOW),
        ])?)
    }
}

/// Why grid mapping by particles cannot start.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridParticlesError {
    /// A grid setting that is not allowed.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// A setting of the scan matcher, which gives the motion from scan to scan.
    #[error(transparent)]
    Matcher(#[from] ScanMatcherError),
    /// A value of [`GridParticlesConfig`] that is out of its bounds.
    #[error("grid particles: {0}")]
    Bounds(#[from] OutOfBounds),
}
