//! What a pose between two clouds is worth, by whichever method it was found.
//!
//! In: both clouds and a pose. Out: a [`Registration`] with covariance and verdict.
//!
//! 1. Each point is paired with the surface nearest to it. How far pairs lie apart across their
//!    surfaces, by the median, is the noise of both clouds.
//! 2. Points within three times the noise lie on their surface; of them the information of the pose
//!    follows, as of points matched to lines.
//! 3. What these pairs still want to be moved by is what the method left: it is added to the
//!    covariance. A method that stops early, or that pulls walls towards where they were sampled,
//!    is so told from one that does not.
//! 4. A point on a surface agrees with the other cloud where it lies on the same surface. Where it
//!    lies beside one that faces the same way, or clearly before what the other sensor saw in its
//!    direction, it contradicts it. A pose where too many do is another minimum than the right one.
//!    What lies behind is hidden, and says nothing; nor does a point that is alone: it may be
//!    anything. Clouds that no sensor saw have no before: there all that is far contradicts.
//! 5. How far the points of each cloud lie from their own surfaces is their noise, whatever the
//!    pose. Where pairs lie apart by much more than both noises, they are not of the same surfaces:
//!    it is another minimum, too, however well it looks with a wide tolerance.
//!
//! Source of 2 and 4: Censi (2007), "An accurate closed-form estimate of ICP's covariance";
//! Bosse & Zlot (2008), on free space as evidence.

use nalgebra::{Matrix3, Point2, Vector2};

use super::super::gauss_newton::{MatchConfig, Sums, free_direction, outcome};
use super::super::{Registration, Verdict};
use super::cloud::{OWN_SHARE, sigma_of};
use super::neighbours::Neighbours;
use super::{Cloud, Found, facing};
use crate::bounds::config;
use crate::geom::{Length, Pose2};
use crate::lanes::{self, Kernel, Lanes};

config! {
    /// When a pose between two clouds is believed.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct JudgeConfig {
        /// The least noise of a distance, m: pairs that agree better than any sensor do so by
        /// chance. Default 0.002.
        pub least_sigma: f64 = 0.002,
        /// The most noise that is believed, m. Default 0.05; larger calls more poses right.
        pub most_sigma: f64 = 0.05,
        /// Pairs may lie so many times as far apart as the noise of both clouds lets them, ...
        /// Default 2; larger calls more poses right.
        pub max_excess: f64 = 2.0,
        /// ... and farther by this, m: bends and corners, and what moved while it was seen.
        /// Default 0.01.
        pub unevenness: f64 = 0.01,
        /// Pairs within so many standard deviations lie on one surface. Default 3.
        pub inlier_sigmas: f64 = 3.0,
        /// What lies before what was seen by more than this, and by more than `inlier_sigmas`,
        /// contradicts it, m. Default 0.1.
        pub clearly_before: f64 = 0.1,
        /// What lies as near as this to a surface that faces the same way is on it, or contradicts
        /// it, m. Default 0.3.
        pub beside: f64 = 0.3,
        /// Least part of the points that could agree and do. Default 0.9; larger calls more poses
        /// wrong, good ones among people as well.
        pub min_agreement: f64 = 0.9,
        /// Least part of the points that lie on a surface. Default 0.2.
        pub min_overlap: f64 = 0.2,
        /// Pairs that say one thing. Default 2: both clouds err, and the residuals show one of
        /// them, for the other's surfaces are smoothed.
        pub redundancy: f64 = 2.0,
        /// Cosine of the largest angle between surfaces that may be the same. Default 0.7.
        pub min_cosine: f64 = 0.7,
    }
}

/// What `found` is worth.
pub(super) fn judge(
    moving: &Cloud,
    fixed: &Cloud,
    found: &Found,
    config: &JudgeConfig,
) -> Registration {
    let pose = &found.pose;
    let there = partners(moving, fixed, pose, &[]);
    let sigma = sigma(&there, config);
    let mut sums = sums(&there, sigma, config);
    let matching = MatchConfig::default();
    let free = free_direction(&sums.hessian, matching.min_share);
    if let Some(free) = &free {
        sums.silence(free);
    }
    let per_pair = 1.0 / (sigma * sigma * config.redundancy);
    let information = sums.hessian * per_pair;
    let mut cov = information.try_inverse();
    if let (Some(cov), None) = (&mut cov, &free) {
        let left = *cov * (sums.gradient * per_pair);
        *cov += left * left.transpose();
    }
    let limit = config.inlier_sigmas * sigma;
    let (mut agree, mut all) = (0, 0);
    let mut is_met = vec![false; fixed.points().len()];
    for pair in &there {
        let Some(agrees) = pair.compare(fixed, limit, config) else {
            continue;
        };
        all += 1;
        agree += usize::from(agrees);
        if let (true, Some(met)) = (agrees, is_met.get_mut(pair.partner)) {
            *met = true;
        }
    }
    // A surface that a point lies on agrees; the others have to be asked.
    let met = is_met.iter().filter(|is_met| **is_met).count();
    (agree, all) = (agree + met, all + met);
    let back = partners(fixed, moving, &pose.inverse(), &is_met);
    for agrees in back
        .iter()
        .filter_map(|pair| pair.compare(moving, limit, config))
    {
        all += 1;
        agree += usize::from(agrees);
    }
    let agreement = agree as f64 / all.max(1) as f64;
    let count = moving.points().len();
    let overlap = sums.inliers as f64 / count.max(1) as f64;
    let verdict = if sums.inliers < matching.min_points.min(count.max(3)) {
        Verdict::TooFewPoints {
            found: sums.inliers,
        }
    } else if agreement < config.min_agreement
        || overlap < config.min_overlap
        || sigma > most_scatter(moving, fixed, config)
    {
        Verdict::LocalMinimum { agreement }
    } else if let Some(free) = &free {
        Verdict::Degenerate {
            direction: unit(free.xy()),
        }
    } else if found.is_settled {
        Verdict::Converged
    } else {
        Verdict::NotConverged
    };
    let counted = (&sums, count);
    outcome(*pose, cov, information, counted, found.iterations, verdict)
}

fn unit(v: Vector2<f64>) -> Vector2<f64> {
    v / v.length()
}

/// A point at the pose that is judged, and what of the other cloud is nearest to it.
struct Pair {
    /// The nearest point.
    partner: usize,
    /// From the moving frame's origin to the point, in the axes of the other cloud, m.
    arm: Vector2<f64>,
    /// Where the point lies in the other cloud, m.
    place: Point2<f64>,
    /// From the nearest point to it, squared, m².
    square: f64,
    /// The normal of the surface there, and the distance across it.
    across: Option<(Vector2<f64>, f64)>,
    /// Cosine of the angle between the surface and the point's own; 1 where one is unknown.
    cosine: f64,
    /// Whether the point itself lies on a surface.
    is_on_surface: bool,
}

/// Pairs each point with what of the other cloud is nearest to it, but for those `left_out`.
fn partners(moving: &Cloud, fixed: &Cloud, pose: &Pose2, left_out: &[bool]) -> Vec<Pair> {
    lanes::run(Partners {
        moving,
        fixed,
        pose,
        left_out,
    })
}

/// See [`partners`].
struct Partners<'a> {
    moving: &'a Cloud,
    fixed: &'a Cloud,
    pose: &'a Pose2,
    /// Points that need no partner; none where it is empty.
    left_out: &'a [bool],
}

impl Kernel for Partners<'_> {
    type Output = Vec<Pair>;

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) -> Vec<Pair> {
        let (moving, fixed, pose) = (self.moving, self.fixed, self.pose);
        let tree = fixed
            .view()
            .is_none()
            .then(|| Neighbours::of(fixed.points()));
        let is_sided = moving.view().is_some() && fixed.view().is_some();
        let mut pairs = Vec::with_capacity(moving.points().len());
        let all = moving.points().iter().zip(moving.surfaces());
        for (at, (point, own)) in all.enumerate() {
            if self.left_out.get(at).is_some_and(|is_out| *is_out) {
                continue;
            }
            let arm = pose.rotate(point.coords);
            let place = pose.position() + arm;
            let nearest = match (fixed.view(), &tree) {
                (Some(view), _) => view.nearest::<L>(machine, &place),
                (None, Some(tree)) => tree.nearest(place),
                (None, None) => None,
            };
            let Some((index, square)) = nearest else {
                continue;
            };
            let surface = fixed.surfaces().get(index).and_then(Option::as_ref);
            let own = own.map(|own| pose.rotate(own.normal));
            pairs.push(Pair {
                partner: index,
                arm,
                place,
                square,
                across: surface.map(|s| (s.normal, s.normal.dot(&(place - s.position)))),
                cosine: facing(own, surface.map(|s| s.normal), is_sided),
                is_on_surface: own.is_some(),
            });
        }
        pairs
    }
}

/// How two clouds lie on each other at a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Likeness {
    /// Part of the moving points that lie on a surface of the fixed cloud, 0 to 1.
    pub overlap: f64,
    /// Standard deviation of their distances across it, m: the noise of both.
    pub sigma: f64,
    /// Part of the points of both clouds that lie on no surface at all: alone, or in no order.
    pub scatter: f64,
}

/// What two clouds are like at `pose`, which should be right.
#[must_use]
pub fn likeness(moving: &Cloud, fixed: &Cloud, pose: &Pose2, config: &JudgeConfig) -> Likeness {
    let pairs = partners(moving, fixed, pose, &[]);
    let sigma = sigma(&pairs, config);
    let on_surface = sums(&pairs, sigma, config).inliers;
    let surfaces = || moving.surfaces().iter().chain(fixed.surfaces());
    let part = |some: usize, all: usize| some as f64 / all.max(1) as f64;
    Likeness {
        overlap: part(on_surface, moving.points().len()),
        sigma,
        scatter: part(
            surfaces().filter(|s| s.is_none()).count(),
            surfaces().count(),
        ),
    }
}

/// Standard deviation of the pairs, by their median, m.
fn sigma(pairs: &[Pair], config: &JudgeConfig) -> f64 {
    let farthest = config.inlier_sigmas * config.most_sigma;
    let facing = pairs.iter().filter(|pair| pair.cosine >= config.min_cosine);
    let all = facing
        .filter_map(|pair| Some(pair.across?.1.abs()))
        .filter(|residual| *residual < farthest);
    let sigma = sigma_of(all.collect()).unwrap_or(config.most_sigma);
    sigma.clamp(config.least_sigma, config.most_sigma)
}

/// The most that pairs scatter at the right pose, by what the points of each cloud scatter about
/// their own surfaces, which no pose changes.
fn most_scatter(moving: &Cloud, fixed: &Cloud, config: &JudgeConfig) -> f64 {
    let [moving, fixed] = [moving, fixed].map(|cloud| cloud.sigma().unwrap_or(config.most_sigma));
    let both = (moving * moving + OWN_SHARE * fixed * fixed).sqrt();
    config.max_excess * both + config.unevenness
}

fn sums(pairs: &[Pair], sigma: f64, config: &JudgeConfig) -> Sums {
    let mut sums = Sums::default();
    let limit = config.inlier_sigmas * sigma;
    for pair in pairs {
        let Some((normal, residual)) = pair.across else {
            continue;
        };
        sums.matched += 1;
        if residual.abs() < limit && pair.cosine >= config.min_cosine {
            sums.add_across(&normal, &pair.arm, residual, 1.0);
            sums.inliers += 1;
            sums.squares += residual * residual;
        }
    }
    sums
}

impl Pair {
    /// Whether a point on a surface agrees with what the other cloud saw: it lies on the same
    /// surface, to within `limit`; or it does not, for it lies beside it, or where the other sensor
    /// saw through. `None` where it is hidden, where nothing was seen in its direction, and of
    /// points that are no surface: what is alone may be anything.
    fn compare(&self, cloud: &Cloud, limit: f64, config: &JudgeConfig) -> Option<bool> {
        if !self.is_on_surface {
            return None;
        }
        let beside = config.beside.max(limit);
        if let Some((_, across)) = self.across
            && self.cosine >= config.min_cosine
            && self.square < beside * beside
        {
            return Some(across.abs() < limit);
        }
        let Some(view) = cloud.view() else {
            return Some(false);
        };
        let [before, after] = view.about(&self.place).map(|at| cloud.points().get(at));
        let (before, after) = before.zip(after)?;
        // Beyond the arc of the sensor nothing was seen.
        let is_ahead = |seen: &Point2<f64>| seen.coords.dot(&self.place.coords) > 0.0;
        let least = before
            .coords
            .norm_squared()
            .min(after.coords.norm_squared());
        let range = self.place.coords.length() + config.clearly_before.max(limit);
        (is_ahead(before) && is_ahead(after) && range * range < least).then_some(false)
    }
}

/// Nothing is known of a pose that was not found.
pub(super) fn nothing(found: &Found, points: usize) -> Registration {
    let sums = Sums::default();
    let verdict = Verdict::TooFewPoints { found: 0 };
    let counted = (&sums, points);
    let zero = Matrix3::zeros();
    outcome(found.pose, None, zero, counted, found.iterations, verdict)
}
