//! SLAM by particles, each with a grid map of its own (Rao-Blackwellised particle filter).
//!
//! In: odometry and scans. Out: the pose with its covariance, and map and trajectory of the best
//! particle. A loop closes by selection: of all possible maps, the one survives that the scans fit
//! when the robot comes back.
//!
//! 1. The motion from scan to scan is that of odometry, corrected by matching each scan to the last
//!    ones ([`ScanMatcher`] without loop closures): wheels slip, and particles can only be where
//!    the motion may have led. The remaining uncertainty spreads the particles.
//! 2. After some distance or rotation a scan is taken in. Each particle matches it to its own map,
//!    draws its pose around the match, and is weighted by how well the motion predicted the scan
//!    (`proposal`).
//! 3. If few particles have most of the weight, a new set is drawn by weight (`resampling`),
//!    otherwise not, because each drawing loses maps.
//! 4. The scan is added to the map of each particle: its surfaces, and the space that its beams
//!    passed through. Maps of particles with common ancestors share memory until they are written
//!    ([`SurfelTiles`]), and their trajectories are one tree (`ancestry`).
//! 5. The grid that is shown is that of the best particle; it is redrawn from its trajectory when
//!    another particle becomes the best.
//!
//! Source: Grisetti, Stachniss & Burgard (2007), "Improved techniques for grid mapping with
//! Rao-Blackwellized particle filters" (gmapping); for step 1 Hähnel, Burgard, Fox & Thrun (2003),
//! "An efficient FastSLAM algorithm for generating maps of large-scale cyclic environments from raw
//! laser range measurements".

mod ancestry;
mod config;
mod proposal;
mod resampling;
#[cfg(test)]
mod tests;

use nalgebra::Matrix3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use self::ancestry::{Ancestry, NodeId};
pub use self::config::{GridParticlesConfig, GridParticlesError};
use self::proposal::{Known, propose};
use self::resampling::{effective_number, normalised, systematic};
use super::free_space::FreeSpace;
use super::particles::{Localisation, Particle, PoseQuality, covariance_about, hypotheses};
use super::{KldConfig, ScanMatcher, ScanMatcherConfig};
use crate::geom::{Length, Pose2, PoseEstimate, pose_cov, symmetrize};
use crate::map::{Evidence, Grid, GridConfig, SurfelTiles};
use crate::points::{OrientedPoint, Points, oriented_points};
use crate::robot::{Odometry, Stamp};

/// Another particle's map is shown only if its log-likelihood exceeds that of the particle shown by
/// this.
const BETTER: f64 = 1.0;
/// If the particles of the heaviest hypothesis have less than this part of all weight, the robot's
/// place is ambiguous.
const SURE_WEIGHT: f64 = 0.9;

/// SLAM by particles with maps.
#[derive(Clone, Debug)]
pub struct GridParticles {
    config: GridParticlesConfig,
    rng: ChaCha8Rng,
    /// The motion from scan to scan.
    front: ScanMatcher,
    /// The pose of `front` when a scan was last taken in.
    front_at: Pose2,
    particles: Vec<Mapper>,
    /// The one whose map is shown.
    best: usize,
    /// The number of its map, and how many numbers were given.
    best_map: u64,
    maps: u64,
    ancestry: Ancestry,
    scans: Vec<TakenScan>,
    /// For each scan that was taken into the maps, the motion from the one before.
    motions: Vec<Pose2>,
    /// The effective number of particles before the last resampling.
    effective: f64,
    /// What is drawn of each scan that was taken into the maps, robot frame.
    evidences: Vec<Evidence>,
    /// The map of the best particle.
    grid: Grid,
    /// Increases whenever another map is shown.
    map_changes: u64,
    shown: Vec<Particle>,
    quality: PoseQuality,
}

/// A particle: a possible trajectory of the robot, and the map that belongs to it.
#[derive(Clone, Debug)]
struct Mapper {
    pose: Pose2,
    /// The covariance of the distribution from which its pose was last drawn.
    cov: Matrix3<f64>,
    /// Logarithms of its weight since the last resampling, and of the likelihood of its whole
    /// trajectory.
    log_weight: f64,
    log_likelihood: f64,
    overlap: f64,
    /// Of the particles drawn from one, the first keeps its number and each other gets a new one.
    map: u64,
    /// Where its trajectory ends in the tree.
    node: Option<NodeId>,
    walls: SurfelTiles,
    free: FreeSpace,
}

/// A scan, at or after one that was taken into the maps.
#[derive(Clone, Copy, Debug)]
struct TakenScan {
    stamp: Stamp,
    /// The number of the last scan that was taken into the maps; it may be this one.
    keyframe: usize,
    /// The motion since that scan.
    moved: Pose2,
}

impl GridParticles {
    /// Starts at the origin of the map. `front` says how scans are matched to previous ones, `grid`
    /// how the map is drawn.
    ///
    /// # Errors   [`GridParticlesError`], naming the first figure out of its bounds.
    pub fn new(
        config: GridParticlesConfig,
        front: ScanMatcherConfig,
        grid: GridConfig,
    ) -> Result<Self, GridParticlesError> {
        config.validate()?;
        let front = ScanMatcherConfig {
            close_loops: false,
            ..front
        };
        let first = Mapper {
            pose: Pose2::identity(),
            cov: Matrix3::zeros(),
            log_weight: 0.0,
            log_likelihood: 0.0,
            overlap: 1.0,
            map: 0,
            node: None,
            walls: SurfelTiles::new(config.surfels),
            free: FreeSpace::default(),
        };
        Ok(Self {
            rng: ChaCha8Rng::seed_from_u64(config.seed),
            front: ScanMatcher::new(front)?,
            front_at: Pose2::identity(),
            particles: vec![first; config.count],
            best: 0,
            best_map: 0,
            maps: 0,
            ancestry: Ancestry::default(),
            scans: vec![],
            motions: vec![],
            effective: config.count as f64,
            evidences: vec![],
            grid: Grid::new(grid)?,
            map_changes: 0,
            shown: vec![],
            quality: PoseQuality {
                localisation: Localisation::Localised,
                ..PoseQuality::default()
            },
            config,
        })
    }

    /// Takes the motion since the last call. Readings must come in order of time.
    pub fn odometry(&mut self, odometry: &Odometry) {
        self.front.odometry(odometry);
    }

    /// Takes the points of a scan, in the robot frame at the end of the newest odometry; `sigmas`
    /// as in [`ScanMatcher::update`]; `evidence` returns what is drawn of the scan, if it is drawn.
    pub fn update(&mut self, points: &Points, sigmas: &[f64], evidence: impl FnOnce() -> Evidence) {
        self.front.update(points, sigmas);
        let front_at = self.front.estimate().pose;
        let moved = self.front_at.delta_to(&front_at);
        let is_first = self.scans.is_empty();
        if is_first || self.is_far(&moved) {
            let surfaces = oriented_points(points);
            self.motions.push(moved);
            if !is_first {
                self.move_particles(&surfaces, &moved);
                self.resample();
            }
            self.map(&surfaces, evidence());
            self.front_at = front_at;
        }
        self.scans.push(TakenScan {
            stamp: points.stamp,
            keyframe: self.motions.len() - 1,
            moved: self.front_at.delta_to(&front_at),
        });
        self.conclude();
    }

    fn is_far(&self, moved: &Pose2) -> bool {
        moved.position().coords.length() >= self.config.way
            || moved.heading().abs() >= self.config.turn
    }

    /// The covariance of a motion, in the frame where it began.
    fn motion_cov(&self, moved: &Pose2) -> Matrix3<f64> {
        let [along, of_turn, bend] = self.config.motion_noise;
        let [least, least_turn] = self.config.least_noise;
        let gone = moved.position().coords.length();
        let turned = libm::hypot(of_turn * moved.heading(), bend * gone);
        pose_cov(least + along * gone, least_turn + turned)
    }

    /// Step 2.
    fn move_particles(&mut self, surfaces: &[OrientedPoint], moved: &Pose2) {
        let cov = self.motion_cov(moved);
        for particle in &mut self.particles {
            // The shift covariance is isotropic, so rotating it would not change it.
            let prior = PoseEstimate {
                pose: particle.pose * *moved,
                cov,
            };
            let known = Known {
                walls: &particle.walls,
                free: &particle.free,
            };
            let found = propose(surfaces, known, &prior, &self.config, &mut self.rng);
            particle.pose = found.pose;
            particle.cov = found.cov;
            particle.overlap = found.overlap;
            let says = found.log_weight * self.config.news;
            particle.log_weight += says;
            particle.log_likelihood += says;
        }
    }

    fn weights(&self) -> Vec<f64> {
        let logs: Vec<f64> = self.particles.iter().map(|p| p.log_weight).collect();
        normalised(&logs)
    }

    /// Step 3.
    fn resample(&mut self) {
        let weights = self.weights();
        self.effective = effective_number(&weights);
        if self.effective >= self.config.resample_below * weights.len() as f64 {
            return;
        }
        let drawn = systematic(&weights, self.rng.random::<f64>());
        let mut next: Vec<Mapper> = Vec::with_capacity(drawn.len());
        let mut last = None;
        for index in drawn {
            let Some(particle) = self.particles.get(index) else {
                continue;
            };
            let is_copy = last.replace(index) == Some(index);
            self.maps += u64::from(is_copy);
            next.push(Mapper {
                log_weight: 0.0,
                map: if is_copy { self.maps } else { particle.map },
                ..particle.clone()
            });
        }
        self.particles = next;
        let nodes = self.particles.iter_mut().filter_map(|p| p.node.as_mut());
        self.ancestry.prune(nodes);
    }

    /// Step 4.
    fn map(&mut self, surfaces: &[OrientedPoint], evidence: Evidence) {
        for particle in &mut self.particles {
            let at = particle.pose;
            particle.node = Some(self.ancestry.push(particle.node, at));
            particle
                .walls
                .insert(surfaces.iter().map(|surface| OrientedPoint {
                    position: at * surface.position,
                    normal: at.rotate(surface.normal),
                }));
            let rays = evidence.free.iter();
            particle.free.mark(rays.map(|way| way.map(|end| at * end)));
        }
        self.evidences.push(evidence);
        self.choose_best();
        self.draw();
    }

    /// Step 5.
    fn draw(&mut self) {
        let map = self.best().map;
        let is_same = std::mem::replace(&mut self.best_map, map) == map;
        if let (true, Some(newest)) = (is_same, self.evidences.last()) {
            let at = self.best().pose;
            self.grid.draw(newest, &at);
            return;
        }
        // The configuration was valid before.
        if let (Ok(grid), Some(node)) = (Grid::new(*self.grid.config()), self.best().node) {
            self.grid = grid;
            for (evidence, pose) in self.evidences.iter().zip(self.ancestry.line(node)) {
                self.grid.draw(evidence, &pose);
            }
            self.map_changes += 1;
        }
    }

    /// Chooses the trajectory that best explains everything seen. One that is only slightly better
    /// than the one shown is not chosen, because each change draws another map.
    fn choose_best(&mut self) {
        let all = || self.particles.iter().enumerate();
        let likelihood = |index: usize| self.particles[index].log_likelihood;
        let mut best = 0;
        for (index, _) in all() {
            if likelihood(index) > likelihood(best) {
                best = index;
            }
        }
        let shown = all().find(|(_, particle)| particle.map == self.best_map);
        if let Some((shown, _)) = shown
            && likelihood(best) < likelihood(shown) + BETTER
        {
            best = shown;
        }
        self.best = best;
    }

    /// Computes what is shown of the particles.
    fn conclude(&mut self) {
        let moved = self.front_at.delta_to(&self.front.estimate().pose);
        let weights = self.weights();
        let particles = self.particles.iter().zip(weights);
        self.shown = particles
            .map(|(particle, weight)| Particle {
                pose: particle.pose * moved,
                weight,
            })
            .collect();
        let apart = hypotheses(&self.shown, &KldConfig::default());
        let agreement = self.best().overlap;
        self.quality = PoseQuality {
            localisation: match apart.first() {
                Some(first) if first.weight < SURE_WEIGHT => Localisation::Ambiguous,
                _ => Localisation::Localised,
            },
            agreement,
            recent_agreement: agreement,
            rival_agreement: 0.0,
        };
    }

    fn best(&self) -> &Mapper {
        &self.particles[self.best]
    }

    /// The pose in the map of the best particle, including the odometry since the last scan. The
    /// covariance includes the uncertainty of this particle and the spread of all.
    #[must_use]
    pub fn estimate(&self) -> PoseEstimate {
        let best = self.best();
        let moved = self.front_at.delta_to(&self.front.estimate().pose);
        let pose = best.pose * moved;
        let turned = best.pose.rotation();
        let since = turned * self.motion_cov(&moved) * turned.transpose();
        let apart = match self.shown.is_empty() {
            true => Matrix3::zeros(),
            false => {
                let at_scan = self.shown[self.best].pose;
                covariance_about(&at_scan, &self.shown)
            }
        };
        let mut cov = best.cov + apart + since;
        symmetrize(&mut cov);
        PoseEstimate { pose, cov }
    }

    /// The map of the best particle.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Increases whenever [`Self::grid`] becomes that of another particle.
    #[must_use]
    pub fn grid_version(&self) -> u64 {
        self.map_changes
    }

    /// The trajectory of the best particle: its pose at each scan. Between two scans that were
    /// taken into the maps it follows the motion, bent slightly so that it ends where the second
    /// one lies.
    #[must_use]
    pub fn trajectory(&self) -> Vec<(Stamp, Pose2)> {
        let Some(node) = self.best().node else {
            return vec![];
        };
        let line = self.ancestry.line(node);
        let mut trajectory = Vec::with_capacity(self.scans.len());
        let mut legs = self
            .scans
            .chunk_by(|a, b| a.keyframe == b.keyframe)
            .peekable();
        while let Some(leg) = legs.next() {
            let Some(begin) = line.get(leg[0].keyframe) else {
                break;
            };
            let next = legs.peek().map(|next| next[0]);
            let end = next.and_then(|end| {
                let moved = self.motions.get(end.keyframe)?;
                let bend = (*begin * *moved).delta_to(line.get(end.keyframe)?);
                Some((bend, end.stamp.since(leg[0].stamp)))
            });
            trajectory.extend(leg.iter().map(|scan| {
                let bend = end.map_or_else(Pose2::identity, |(bend, seconds)| {
                    let since = scan.stamp.since(leg[0].stamp);
                    bend.fraction((since / seconds.max(1e-6)).clamp(0.0, 1.0))
                });
                (scan.stamp, *begin * scan.moved * bend)
            }));
        }
        trajectory
    }

    /// All particles, where they are at the last scan.
    #[must_use]
    pub fn particles(&self) -> &[Particle] {
        &self.shown
    }

    /// The effective number of particles before the last resampling.
    #[must_use]
    pub fn effective_particles(&self) -> f64 {
        self.effective
    }

    /// Whether nearly all particles are in one place, and how much of the last scan lies on the
    /// map.
    #[must_use]
    pub fn quality(&self) -> PoseQuality {
        self.quality
    }
}
