//! The figures of Monte Carlo localisation.

use super::recent::RecentConfig;
use super::sampling::KldConfig;
use crate::bounds::config;
use crate::registration::ModesConfig;

config! {
    /// How particles find a robot.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct MonteCarloConfig {
        /// Of the random numbers. Default 1.
        pub seed: u64 = 1,
        /// How many particles there are.
        pub kld: KldConfig = KldConfig::default(),
        /// What is kept of the last metres.
        pub recent: RecentConfig = RecentConfig::default(),
        /// How places are searched for.
        pub modes: ModesConfig = ModesConfig::default(),
        /// Most beams of a scan that particles are weighed by. Default 60; larger is slower.
        pub most_beams: usize = 60,
        /// Fewer hits than this say nothing. Default 12.
        pub fewest_beams: usize = 12,
        /// Standard deviation of what was hit from the nearest wall, m: of the beam, of the map and
        /// of half a cell. Default 0.1; smaller is more precise, until no particle is near enough.
        pub sigma: f64 = 0.1,
        /// Part of the beams that hit what is not in the map. Default 0.1; larger: slower to
        /// believe, and to be deceived.
        pub random_part: f64 = 0.1,
        /// So many beams say something of their own; neighbours err alike. Default 12; larger:
        /// hypotheses die sooner, the true one too.
        pub independent_beams: f64 = 12.0,
        /// Particles are weighed after this way, m, or turn, rad: a robot that stands learns
        /// nothing new. Default 0.05 and 0.05.
        pub weighed_after: [f64; 2] = [0.05, 0.05],
        /// Standard deviations that are added to what odometry says of itself: along a way, as a
        /// part of it; of a turn, as a part of it; of the heading, rad/m. Default 0.05, 0.05 and
        /// 0.03; larger follows worse odometry and is less precise.
        pub odometry_noise: [f64; 3] = [0.05, 0.05, 0.03],
        /// Part of the particles that is drawn afresh at places where what was seen fits, while
        /// the robot is not found. Default 0.3.
        pub fresh_part: f64 = 0.3,
        /// How far fresh particles are drawn from those places, m and rad: standard deviations.
        /// Default 0.1 and 0.05.
        pub fresh_sigmas: [f64; 2] = [0.1, 0.05],
        /// When a robot counts as found, and when as lost.
        pub judgement: JudgementConfig = JudgementConfig::default(),
    }
}

config! {
    /// When a robot counts as found, and when as lost. Agreement is that of beams with the map: the
    /// mean of exp(-d²/2σ²) of their distances from the nearest wall, 0 where a wall lies between.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct JudgementConfig {
        /// Weight of the one hypothesis. Default 0.9; larger: surer, later.
        pub weight: f64 = 0.9,
        /// Least agreement. Default 0.5; larger: surer, and never where much has changed.
        pub agreement: f64 = 0.5,
        /// By how much less anything apart from it agrees. Default 0.15; larger: surer, later.
        pub margin: f64 = 0.15,
        /// Way of which that is asked, m, where no more than `misfit` disagrees; in proportion more
        /// where more does. Default 1.5; larger: surer, later.
        pub way: f64 = 1.5,
        /// What agreement may lack for that way to be enough. Default 0.2; smaller: a place that
        /// has changed since is believed later.
        pub misfit: f64 = 0.2,
        /// Times in a row. Default 2.
        pub times: u32 = 2,
        /// Lost below this agreement. Default 0.3.
        pub lost_below: f64 = 0.3,
        /// Lost below this part of what agreed before. Default 0.6; larger: sooner, and sometimes
        /// where only somebody stands around.
        pub lost_part: f64 = 0.6,
        /// Part that a scan has in the agreement of now, and in that of before (α of table 8.3).
        /// Default 0.2 and 0.005.
        pub rates: [f64; 2] = [0.2, 0.005],
        /// One that was found is compared with all other places again after this way, m. Default 3;
        /// larger: less work, and an error is found out later.
        pub audit_way: f64 = 3.0,
    }
}
