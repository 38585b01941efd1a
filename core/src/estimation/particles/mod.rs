//! In: odometry, scans and the walls of a prior map. Out: where in it the robot may be, as weighted
//! hypotheses, and whether one of them is to be believed.
//!
//! 1. **Predict**: each particle moves by the odometry, sampled from its covariance. The motion
//!    between two scans is corrected by matching them: wheels slip, and logs lag.
//! 2. **Weigh**: by the distances of the hits from the nearest wall (likelihood field).
//! 3. **Search**, while the robot is not found: the whole map is searched for places that fit what
//!    was seen over the last metres ([`modes`](crate::registration::modes)), and some particles are
//!    drawn there. Drawn at random places, as in augmented Monte Carlo localisation, hardly one in
//!    a million would be near enough in a large building.
//! 4. **Resample** if few particles have most of the weight; their number follows from their spread
//!    ([`KldConfig`]).
//! 5. **Judge**: neighbouring particles form a hypothesis. It is believed if it has nearly all
//!    weight, beams agree with the map there, and nowhere else nearly as well; it is doubted if
//!    they no longer agree, or agree better elsewhere.
//!
//! Source: Thrun, Burgard & Fox (2005), "Probabilistic Robotics", tables 6.3 and 8.3; Fox (2003),
//! "Adapting the sample size in particle filters through KLD-sampling"; step 3 is sensor resetting
//! (Lenser & Veloso 2000) with the whole map as the sensor's range.

mod config;
mod histogram;
mod hypothesis;
mod recent;
mod sampling;
#[cfg(test)]
mod tests;
mod wall_map;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub use self::config::{JudgementConfig, MonteCarloConfig};
pub use self::histogram::{HistogramConfig, HistogramLocaliser};
pub use self::hypothesis::Hypothesis;
pub(super) use self::hypothesis::{covariance_about, hypotheses};
pub use self::recent::RecentConfig;
use self::recent::{Ray, Recent, rays};
pub(super) use self::sampling::Gaussian;
use self::sampling::draw;
pub use self::sampling::{Bin, KldConfig};
use self::wall_map::{Place, Places, WallMap};
use super::EkfError;
use crate::geom::{Length, Pose2, PoseEstimate, Segment, pose_cov, symmetrize, wrap};
use crate::points::Points;
use crate::robot::Odometry;

/// A pose that the robot may have, with its share of the total weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle {
    /// The pose, map frame.
    pub pose: Pose2,
    /// Its weight; all weights sum to 1.
    pub weight: f64,
}

/// Whether the estimate of a localisation is to be believed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Localisation {
    /// One hypothesis has nearly all weight, what is seen agrees with the map there, and at no
    /// other place nearly as well.
    Localised,
    /// What is seen fits the map, but in several places, or not for long enough to tell.
    Ambiguous,
    /// What is seen fits nowhere in the map, as far as is known so far.
    #[default]
    Lost,
}

impl Localisation {
    /// The name in messages.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Localised => "localised",
            Self::Ambiguous => "ambiguous",
            Self::Lost => "lost",
        }
    }
}

/// How well the pose is known, with the figures behind this judgement.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoseQuality {
    /// The judgement.
    pub localisation: Localisation,
    /// How well what is seen now agrees with the map at the first hypothesis, 0 to 1.
    pub agreement: f64,
    /// The same for the last metres, at the last search for places.
    pub recent_agreement: f64,
    /// The best agreement of the last metres at any other place, at that search.
    pub rival_agreement: f64,
}

/// Monte Carlo localisation in a prior map.
#[derive(Clone, Debug)]
pub struct MonteCarlo {
    config: MonteCarloConfig,
    map: WallMap,
    rng: ChaCha8Rng,
    particles: Vec<Particle>,
    hypotheses: Vec<Hypothesis>,
    quality: PoseQuality,
    recent: Recent,
    /// Motion since the particles were moved: by matching up to the last scan, then by odometry.
    moved: PoseEstimate,
    /// [`Recent::matched`] when they were moved.
    moved_at: Pose2,
    /// Short-term and long-term mean agreement; none before the first scan.
    agreements: Option<[f64; 2]>,
    /// While the robot is not found: where it was last believed to be, plus odometry since then.
    reckoned: Pose2,
    is_found: bool,
    /// How often in a row a hypothesis passed, and how often another place did better.
    passed: u32,
    outdone: u32,
    /// Distance since the last search for places, m.
    unsearched: f64,
}

impl MonteCarlo {
    /// In a map of walls whose positions have standard deviation `map_sigma`, m. The robot starts
    /// at `start`, or anywhere.
    ///
    /// # Errors   [`EkfError::PriorMap`] where the walls are longer or lie farther off than can be
    /// held, or there are none.
    pub fn new(
        faces: &[Segment],
        map_sigma: f64,
        start: Option<&PoseEstimate>,
        config: MonteCarloConfig,
    ) -> Result<Self, EkfError> {
        let map = WallMap::new(faces, map_sigma, &config)?;
        let map = map.ok_or(EkfError::PriorMap {
            what: "extent of the prior map's walls, m",
            value: f64::INFINITY,
            most: 0.0,
        })?;
        let mut localiser = Self {
            rng: ChaCha8Rng::seed_from_u64(config.seed),
            particles: vec![],
            hypotheses: vec![],
            quality: PoseQuality::default(),
            recent: Recent::new(config.recent),
            moved: PoseEstimate::exact(Pose2::identity()),
            moved_at: Pose2::identity(),
            agreements: None,
            reckoned: Pose2::identity(),
            is_found: start.is_some(),
            passed: 0,
            outdone: 0,
            unsearched: f64::INFINITY,
            map,
            config,
        };
        if let Some(start) = start {
            let start = Gaussian::new(start.pose, &start.cov);
            let drawn = draw(
                &[],
                1.0,
                |rng| start.draw(rng),
                &config.kld,
                &mut localiser.rng,
            );
            localiser.particles = drawn;
            localiser.unsearched = 0.0;
            localiser.conclude();
            localiser.quality.localisation = Localisation::Localised;
        }
        Ok(localiser)
    }

    /// Forgets the pose: the robot may be anywhere.
    pub fn forget(&mut self) {
        self.lose();
        self.particles.clear();
        self.hypotheses.clear();
    }

    /// Step 1, postponed until there is a scan: takes the motion since the last call.
    pub fn predict(&mut self, odometry: &Odometry) {
        self.recent.predict(odometry);
        self.unsearched += odometry.motion.position().coords.length();
        self.moved = odometry.after(&self.moved);
        self.reckoned = self.reckoned * odometry.motion;
    }

    /// Steps 2 to 5: takes a scan, in the current robot frame.
    pub fn update(&mut self, points: &Points) {
        let rays = rays(points, self.config.most_beams);
        if rays.len() < self.config.fewest_beams {
            return;
        }
        let mut is_kept = self.recent.push(points);
        self.moved.pose = self.moved_at.delta_to(&self.recent.matched());
        if !self.is_still_there(&rays) {
            self.lose();
            is_kept = self.recent.push(points);
        }
        let is_audit = self.is_found && self.unsearched >= self.config.judgement.audit_way;
        let searches = is_kept && (!self.is_found || is_audit);
        if !searches && !self.has_moved() {
            return;
        }
        self.move_particles();
        let places = searches.then(|| self.search());
        self.weigh(&rays);
        self.conclude();
        if let Some(places) = places {
            self.judge(&places);
        }
        self.resample();
    }

    /// Where the robot is now: the first hypothesis. While the robot is not found, it is odometry
    /// alone from where it was last believed to be, or from the origin: this does not jump from
    /// hypothesis to hypothesis, so it can be used for driving. Its covariance then covers all of
    /// them.
    #[must_use]
    pub fn estimate(&self) -> PoseEstimate {
        let mut now = match self.hypotheses.first() {
            Some(first) if self.is_found => self.after(&first.estimate),
            _ => self.unfound(),
        };
        symmetrize(&mut now.cov);
        now
    }

    fn unfound(&self) -> PoseEstimate {
        let (low, high) = self.map.extent();
        let cov = match self.particles.is_empty() {
            true => pose_cov((high - low).length() / 2.0, std::f64::consts::PI),
            false => covariance_about(
                &(self.reckoned * self.moved.pose.inverse()),
                &self.particles,
            ),
        };
        PoseEstimate {
            pose: self.reckoned,
            cov,
        }
    }

    /// Where the robot may be now, the heaviest hypothesis first.
    pub fn hypotheses(&self) -> impl Iterator<Item = Hypothesis> + '_ {
        self.hypotheses.iter().map(|hypothesis| Hypothesis {
            estimate: self.after(&hypothesis.estimate),
            weight: hypothesis.weight,
        })
    }

    /// The particles, where they were when a scan was last processed.
    #[must_use]
    pub fn particles(&self) -> &[Particle] {
        &self.particles
    }

    /// Whether the estimate is to be believed.
    #[must_use]
    pub fn quality(&self) -> PoseQuality {
        self.quality
    }

    /// A pose from when the particles were moved, carried forward to now.
    fn after(&self, then: &PoseEstimate) -> PoseEstimate {
        let moved = Odometry {
            motion: self.moved.pose,
            cov: self.moved.cov,
            ..Odometry::standing(crate::robot::Stamp(0))
        };
        moved.after(then)
    }

    fn has_moved(&self) -> bool {
        let [way, turn] = self.config.weighed_after;
        let moved = &self.moved.pose;
        moved.position().coords.length() >= way || moved.heading().abs() >= turn
    }

    /// Whether what is seen from the believed pose still agrees with the map. Every scan is
    /// checked, because a robot may be carried off while it stands.
    fn is_still_there(&mut self, rays: &[Ray]) -> bool {
        let Some(first) = self.hypotheses.first() else {
            return true;
        };
        let pose = first.estimate.pose * self.moved.pose;
        let agreement = self.map.agreement(&pose, rays.iter().copied());
        let [fast, slow] = self.agreements.get_or_insert([agreement; 2]);
        let [quickly, slowly] = self.config.judgement.rates;
        *fast += quickly * (agreement - *fast);
        *slow = match self.is_found {
            true => *slow + slowly * (agreement - *slow),
            false => *fast,
        };
        self.quality.agreement = *fast;
        let judgement = &self.config.judgement;
        let fits = *fast >= judgement.lost_below && *fast >= judgement.lost_part * *slow;
        if !self.is_found {
            self.quality.localisation = match fits {
                true => Localisation::Ambiguous,
                false => Localisation::Lost,
            };
        }
        fits || !self.is_found
    }

    fn lose(&mut self) {
        self.reckoned = self.estimate().pose;
        self.is_found = false;
        (self.passed, self.outdone) = (0, 0);
        self.quality.localisation = Localisation::Lost;
        self.recent.forget();
    }

    /// Step 1. To the noise that the odometry reports, the noise that it does not report is added.
    fn move_particles(&mut self) {
        let [way, turn, bend] = self.config.odometry_noise;
        let moved = self.moved.pose;
        let gone = moved.position().coords.length();
        let turned = libm::hypot(turn * moved.heading(), bend * gone);
        let cov = self.moved.cov + pose_cov(way * gone + 1e-3, turned + 1e-3);
        let motion = Gaussian::new(moved, &cov);
        for particle in &mut self.particles {
            particle.pose = particle.pose * motion.draw(&mut self.rng);
        }
        self.moved = PoseEstimate::exact(Pose2::identity());
        self.moved_at = self.recent.matched();
    }

    /// Step 2.
    fn weigh(&mut self, rays: &[Ray]) {
        let power = self.config.independent_beams.min(rays.len() as f64);
        let log =
            |p: &Particle| libm::log(p.weight) + power * self.map.log_likelihood(&p.pose, rays);
        let logs: Vec<f64> = self.particles.iter().map(log).collect();
        // Scale the largest to 1: numbers like e^-1000 would vanish.
        let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let weights: Vec<f64> = logs.iter().map(|log| libm::exp(log - most)).collect();
        let sum: f64 = weights.iter().sum();
        for (particle, weight) in self.particles.iter_mut().zip(weights) {
            particle.weight = weight / sum;
        }
    }

    /// Step 3. If the robot is found, places are only compared, and no particles are drawn.
    fn search(&mut self) -> Places {
        self.unsearched = 0.0;
        let recent: Vec<Ray> = self.recent.rays().collect();
        let places = self.map.places(&recent, &self.config);
        if !self.is_found && !places.found.is_empty() {
            self.draw_at(&places.found, &recent);
        }
        places
    }

    fn draw_at(&mut self, places: &[Place], recent: &[Ray]) {
        let power = self.config.independent_beams;
        let logs = places
            .iter()
            .map(|place| power * self.map.log_likelihood(&place.pose, recent));
        let logs: Vec<f64> = logs.collect();
        let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut sum = 0.0;
        let sums: Vec<f64> = logs
            .iter()
            .map(|log| {
                sum += libm::exp(log - most);
                sum
            })
            .collect();
        let [way, turn] = self.config.fresh_sigmas;
        let cov = pose_cov(way, turn);
        let around: Vec<Gaussian> = places.iter().map(|p| Gaussian::new(p.pose, &cov)).collect();
        let fresh = |rng: &mut ChaCha8Rng| {
            let at = rng.random::<f64>() * sum;
            let place = around.get(sums.partition_point(|&sum| sum <= at));
            place.map_or_else(Pose2::identity, |place| place.draw(rng))
        };
        let part = match self.particles.is_empty() {
            true => 1.0,
            false => self.config.fresh_part,
        };
        let (kld, rng) = (&self.config.kld, &mut self.rng);
        self.particles = draw(&self.particles, part, fresh, kld, rng);
    }

    /// Step 4.
    fn resample(&mut self) {
        let squares: f64 = self.particles.iter().map(|p| p.weight * p.weight).sum();
        if self.particles.is_empty() || 1.0 / squares >= 0.5 * self.particles.len() as f64 {
            return;
        }
        let none = |_: &mut ChaCha8Rng| Pose2::identity();
        let (kld, rng) = (&self.config.kld, &mut self.rng);
        self.particles = draw(&self.particles, 0.0, none, kld, rng);
    }

    fn conclude(&mut self) {
        self.hypotheses = hypotheses(&self.particles, &self.config.kld);
    }

    /// Step 5: compares the first hypothesis with all other places.
    fn judge(&mut self, places: &Places) {
        let Some(first) = self.hypotheses.first() else {
            return;
        };
        let modes = &self.config.modes;
        let is_near = |place: &&Place| {
            let off = place.pose.minus(&first.estimate.pose);
            off.xy().length() < modes.apart && wrap(off.z).abs() < modes.apart_turn
        };
        let (near, apart): (Vec<&Place>, Vec<&Place>) = places.found.iter().partition(is_near);
        let most = |of: fn(&Place) -> f64, places: &[&Place]| {
            places.iter().map(|place| of(place)).fold(0.0, f64::max)
        };
        let here = self.map.agreement(&first.estimate.pose, self.recent.rays());
        let own = here.max(most(|place| place.agreement, &near));
        let rival = most(|place| place.agreement, &apart);
        // A search that was cut off has found nothing better elsewhere, but there may be something.
        let score = most(|place| place.score, &near);
        let judgement = &self.config.judgement;
        let is_searched = score >= places.left + judgement.margin;
        self.quality.recent_agreement = own;
        self.quality.rival_agreement = rival;
        if self.is_found {
            self.outdone = match rival > own + judgement.margin {
                true => self.outdone + 1,
                false => 0,
            };
            if self.outdone >= judgement.times {
                self.lose();
                self.quality.localisation = Localisation::Ambiguous;
            }
            return;
        }
        let passes = first.weight >= judgement.weight
            && own >= judgement.agreement
            && own >= rival + judgement.margin
            && is_searched
            && self.recent.way() >= judgement.way * f64::max(1.0, (1.0 - own) / judgement.misfit);
        self.passed = if passes { self.passed + 1 } else { 0 };
        if self.passed >= judgement.times {
            self.is_found = true;
            self.passed = 0;
            self.agreements = Some([own; 2]);
            self.quality.localisation = Localisation::Localised;
        }
    }
}
