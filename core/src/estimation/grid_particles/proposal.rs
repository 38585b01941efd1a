//! The next pose and the weight of a particle: the improved proposal.
//!
//! In: the surfaces of a scan, a particle's map, and the pose predicted by the motion with its
//! covariance. Out: [`Proposal`].
//!
//! 1. The scan is matched to the particle's map from a pose drawn from the motion.
//! 2. Around the match, the target p(z|m,x) p(x|x',u) is summed over a small grid of poses, whose
//!    width follows from the curvature there: η is its integral, μ and Σ are its moments.
//! 3. The pose is drawn from N(μ, Σ), and η is the weight: how well the motion predicted what was
//!    seen, whichever pose is drawn.
//! 4. If the match fails, the pose is the one drawn from the motion, and the weight is the
//!    likelihood of the scan there.
//!
//! Source: Grisetti, Stachniss & Burgard (2007), "Improved techniques for grid mapping with
//! Rao-Blackwellized particle filters", eqs. (13) to (19). Their samples around the match lie at
//! random; a grid needs fewer.

use nalgebra::{Matrix3, Vector2, Vector3};
use rand_chacha::ChaCha8Rng;

use super::GridParticlesConfig;
use crate::estimation::free_space::FreeSpace;
use crate::estimation::particles::Gaussian;
use crate::geom::{Pose2, PoseEstimate, symmetrize};
use crate::map::SurfelTiles;
use crate::points::OrientedPoint;
use crate::registration::{Prior, register};

/// Poses on either side of the match, along each axis of its uncertainty, and their spacing in
/// standard deviations: the sum then has the moments of a Gaussian to 2 %.
const EACH_SIDE: i32 = 2;
const APART: f64 = 1.25;

/// Where a particle goes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Proposal {
    /// The drawn pose.
    pub(super) pose: Pose2,
    /// The covariance of the distribution from which it was drawn.
    pub(super) cov: Matrix3<f64>,
    /// Logarithm of the weight.
    pub(super) log_weight: f64,
    /// The part of the scan that lies on the map.
    pub(super) overlap: f64,
}

/// The map of a particle, for looking up a scan.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known<'a> {
    pub(super) walls: &'a SurfelTiles,
    pub(super) free: &'a FreeSpace,
}

/// A point with its assigned surface.
#[derive(Clone, Copy, Debug)]
struct Pair {
    point: Vector2<f64>,
    normal: Vector2<f64>,
    /// Distance of the surface from the origin of the map, along its normal.
    offset: f64,
}

/// log p(z|m,x) near a pose, at which points are assigned to surfaces.
///
/// Each point contributes -r²/2σ², where r is its distance from its surface, limited to a maximum
/// for outliers. Neighbours err in the same way, so all points together count as
/// `independent_points`.
#[derive(Clone, Debug)]
pub(super) struct Likelihood {
    pairs: Vec<Pair>,
    /// The contribution of the points without a surface, wherever they lie.
    unpaired: f64,
    /// 1 / 2σ².
    sharpness: f64,
    /// The penalty of an outlier.
    most: f64,
    /// The weight of one point.
    scale: f64,
}

impl Likelihood {
    pub(super) fn around(
        pose: &Pose2,
        surfaces: &[OrientedPoint],
        known: Known<'_>,
        config: &GridParticlesConfig,
    ) -> Self {
        let most = 0.5 * config.outlier_sigmas * config.outlier_sigmas;
        let (mut pairs, mut unpaired) = (Vec::with_capacity(surfaces.len()), 0.0);
        for surface in surfaces {
            let place = *pose * surface.position;
            let facing = |normal: &Vector2<f64>| normal.dot(&pose.rotate(surface.normal));
            let near = known.walls.nearest(place);
            match near.filter(|near| facing(&near.normal) >= config.matching.min_cosine) {
                Some(near) => pairs.push(Pair {
                    point: surface.position.coords,
                    normal: near.normal,
                    offset: near.normal.dot(&near.position.coords),
                }),
                // In space that beams passed through, a point contradicts the map.
                None => {
                    unpaired += match known.free.contains_around(place) {
                        true => most,
                        false => config.unknown_part * most,
                    };
                }
            }
        }
        let count = surfaces.len().max(1) as f64;
        Self {
            pairs,
            unpaired,
            sharpness: 0.5 / (config.sigma * config.sigma),
            most,
            scale: config.independent_points.min(count) / count,
        }
    }

    /// log p(z|m,x), up to a constant.
    pub(super) fn log_at(&self, pose: &Pose2) -> f64 {
        let (cos, sin) = pose.cos_sin();
        let mut against = self.unpaired;
        for Pair {
            point,
            normal,
            offset,
        } in &self.pairs
        {
            let x = cos * point.x - sin * point.y + pose.x();
            let y = sin * point.x + cos * point.y + pose.y();
            let r = normal.x * x + normal.y * y - offset;
            against += (self.sharpness * r * r).min(self.most);
        }
        -self.scale * against
    }

    /// The information of the inliers about the pose: minus the curvature of the logarithm.
    fn information_at(&self, pose: &Pose2) -> Matrix3<f64> {
        let mut information = Matrix3::zeros();
        for pair in &self.pairs {
            let arm = pose.rotate(pair.point);
            let r = pair.normal.dot(&(arm + pose.position().coords)) - pair.offset;
            if self.sharpness * r * r < self.most {
                let by_turn = pair.normal.y * arm.x - pair.normal.x * arm.y;
                let row = Vector3::new(pair.normal.x, pair.normal.y, by_turn);
                information += row * row.transpose();
            }
        }
        information * (2.0 * self.sharpness * self.scale)
    }
}

/// Draws the next pose of a particle, whose motion leads to `moved`, map frame.
pub(super) fn propose(
    surfaces: &[OrientedPoint],
    known: Known<'_>,
    moved: &PoseEstimate,
    config: &GridParticlesConfig,
    rng: &mut ChaCha8Rng,
) -> Proposal {
    let start = Gaussian::new(moved.pose, &moved.cov).draw(rng);
    let information = moved.cov.try_inverse().unwrap_or_else(Matrix3::zeros);
    let prior = Prior {
        pose: moved.pose,
        information,
    };
    let found = register(surfaces, known.walls, &start, &prior, &config.matching);
    if found.overlap < config.matched_above || found.inliers < config.matching.min_points {
        let likelihood = Likelihood::around(&start, surfaces, known, config);
        return Proposal {
            pose: start,
            cov: moved.cov,
            log_weight: likelihood.log_at(&start),
            overlap: found.overlap,
        };
    }
    let peak = found.estimate.pose;
    let likelihood = Likelihood::around(&peak, surfaces, known, config);
    let (estimate, log_weight) = moments(&likelihood, &peak, &prior);
    Proposal {
        pose: Gaussian::new(estimate.pose, &estimate.cov).draw(rng),
        cov: estimate.cov,
        log_weight,
        overlap: found.overlap,
    }
}

/// Step 2: mean and covariance of likelihood times prior near a pose, and the logarithm of the
/// integral.
pub(super) fn moments(likelihood: &Likelihood, peak: &Pose2, prior: &Prior) -> (PoseEstimate, f64) {
    let information = likelihood.information_at(peak) + prior.information;
    let eigen = information.symmetric_eigen();
    // 1/√λ is the standard deviation along an axis; an uninformative prior would have none.
    let axes: [Vector3<f64>; 3] = [0, 1, 2].map(|axis| {
        let sigma = 1.0 / eigen.eigenvalues[axis].max(1e-6).sqrt();
        eigen.eigenvectors.column(axis) * (APART * sigma)
    });
    let volume = Matrix3::from_columns(&axes).determinant().abs();
    let steps = || -EACH_SIDE..=EACH_SIDE;
    let mut at = vec![];
    for a in steps() {
        for b in steps() {
            for c in steps() {
                let off = axes[0] * f64::from(a) + axes[1] * f64::from(b) + axes[2] * f64::from(c);
                let pose = peak.plus(&off);
                let from_prior = pose.minus(&prior.pose);
                let log_prior = -0.5 * from_prior.dot(&(prior.information * from_prior));
                at.push((off, likelihood.log_at(&pose) + log_prior));
            }
        }
    }
    let most = at
        .iter()
        .map(|(_, log)| *log)
        .fold(f64::NEG_INFINITY, f64::max);
    let weighted = |(off, log): &(Vector3<f64>, f64)| (*off, libm::exp(log - most));
    let at: Vec<_> = at.iter().map(weighted).collect();
    let sum: f64 = at.iter().map(|(_, weight)| weight).sum();
    let mean: Vector3<f64> = at
        .iter()
        .map(|(off, weight)| off * *weight)
        .sum::<Vector3<f64>>()
        / sum;
    let mut cov = Matrix3::zeros();
    for (off, weight) in &at {
        cov += (off - mean) * (off - mean).transpose() * (weight / sum);
    }
    symmetrize(&mut cov);
    let pose = peak.plus(&mean);
    (PoseEstimate { pose, cov }, most + libm::log(sum * volume))
}
