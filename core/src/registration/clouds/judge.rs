//! How good a pose between two clouds is, whichever method found it.
//!
//! In: both clouds and a pose. Out: a [`Registration`] with covariance and verdict.
//!
//! 1. Each point is paired with the surface nearest to it. The median distance of the pairs across
//!    their surfaces gives the noise of both clouds.
//! 2. Points within three times the noise lie on their surface. They give the information of the
//!    pose, as in matching points to lines. Where an equation has a normal twice, one is taken from
//!    the moving cloud and one from the fixed cloud. Their errors are independent, so what noise
//!    alone says about the direction along a corridor is zero in the mean. With the squares of one
//!    cloud's normals it would grow with their variance, and noisy scans of a corridor would look
//!    well constrained.
//! 3. The motion by which these pairs still want to move the pose is what the method left undone:
//!    it is added to the covariance. This shows whether a method stopped early, or pulled walls
//!    towards where they were sampled.
//! 4. A point agrees with the other cloud if it lies on the same surface. It contradicts the other
//!    cloud if it lies beside a surface that faces the same way, or clearly in front of what the
//!    other sensor saw in its direction. A pose where too many points contradict is a wrong
//!    minimum. A point behind a surface is hidden, and says nothing; nor does an isolated point,
//!    which may be anything. Clouds without a sensor have no front: there every distant point
//!    contradicts.
//! 5. Along a corridor almost all points agree, however far along it the pose is. So the points
//!    whose surfaces constrain the least known direction are checked by themselves.
//! 6. The distance of the points of each cloud from their own surfaces is their noise, whatever the
//!    pose. If pairs lie apart by much more than both noises, they are not of the same surfaces:
//!    that too is a wrong minimum, however well it looks with a wide tolerance.
//!
//! 7. Scans that show partly different things have points without a true partner, which are still
//!    paired with whatever is nearest. A method is pulled only by such points of the moving cloud.
//!    So in this case the points of the fixed cloud are matched as well: the step by which they
//!    would move the pose is added to the covariance, and a direction that they hardly constrain
//!    counts as unknown.
//! 8. A pose far from the start may be right, or one of several that look alike: scans of a square
//!    room also match when turned by a quarter. Scans that show partly different things may match
//!    in several ways too (`rival`).
//!
//! Source of 2 and 4: Censi (2007), "An accurate closed-form estimate of ICP's covariance";
//! Bosse & Zlot (2008), on free space as evidence. The second cloud's normals in 2 are what
//! statistics call instrumental variables: Fuller (1987), "Measurement error models", section 1.4.

use nalgebra::{Matrix3, Point2, Vector2, Vector3};

use super::super::gauss_newton::{MatchConfig, Sums, UNKNOWN, Weakest, outcome};
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
        /// The same of the points whose surfaces tell of the way of which least is told, ...
        /// Default 0.75.
        pub min_agreement_along: f64 = 0.75,
        /// ... which are those whose normals lie nearer to it than an angle of this cosine, ...
        /// Default 0.35; smaller asks noisy ones as well.
        pub min_cosine_along: f64 = 0.35,
        /// ... where there are so many of them. Default 4.
        pub fewest_along: usize = 4,
        /// Least part of the points that lie on a surface, and of the surfaces that agree. Default
        /// 0.2.
        pub min_overlap: f64 = 0.2,
        /// Clouds of whose surfaces a smaller part than this can be compared show partly different
        /// things. Default 0.7; larger asks more pairs both ways, and looks for a rival of more.
        pub min_compared: f64 = 0.7,
        /// Of such clouds, another pose is as good on which so large a part as many points agree.
        /// Default 0.9; smaller calls more poses ambiguous.
        pub as_good: f64 = 0.9,
        /// Pairs that say one thing. Default 2.5: both clouds err, and the residuals show one of
        /// them, for the other's surfaces are smoothed; at bends they are smoothed too much.
        pub redundancy: f64 = 2.5,
        /// Cosine of the largest angle between surfaces that may be the same. Default 0.7.
        pub min_cosine: f64 = 0.7,
        /// A pose farther from the start than this, ...  Default 1 m.
        pub far_shift: f64 = 1.0,
        /// ... or turned by more than this, is believed only where a search about the start finds
        /// no other that is as good. Default 0.79 rad: 45°.
        pub far_turn: f64 = 0.79,
    }
}

/// Most steps from the pose that a method found to where the pairs fit best.
const MOST_STEPS_LEFT: usize = 5;

/// How good a pose is, and the basis for that.
pub(super) struct Judged {
    pub(super) registration: Registration,
    /// Points of both clouds that agree.
    pub(super) agree: usize,
    /// Whether the clouds show partly different things.
    pub(super) is_partial: bool,
}

/// Judges the pose `found`.
pub(super) fn judge(moving: &Cloud, fixed: &Cloud, found: &Found, config: &JudgeConfig) -> Judged {
    let pose = &found.pose;
    let there = partners(moving, fixed, pose, &[]);
    let sigma = sigma(&there, config);
    let (mut sums, told) = sums(&there, sigma, config);
    let matching = MatchConfig::default();
    let weakest = Weakest::of(&sums.hessian);
    let limit = config.inlier_sigmas * sigma;
    let Agreement { all, along } = agreement(
        moving,
        fixed,
        pose,
        &there,
        &weakest.motion.xy(),
        limit,
        config,
    );
    let surfaces = (moving.surfaces().iter().chain(fixed.surfaces()).flatten()).count();
    let part = |count: usize| count as f64 / surfaces.max(1) as f64;
    let is_partial = part(all.of) < config.min_compared;
    let back = is_partial.then(|| Back::of(moving, fixed, pose, config));
    let free = weakest.if_free(matching.min_share);
    let free = free.or_else(|| back.as_ref()?.free);
    if let Some(free) = &free {
        sums.silence(free);
    }
    let per_pair = 1.0 / (sigma * sigma * config.redundancy);
    let information = sums.hessian * per_pair;
    // Along a free motion next to nothing is known, but not zero: zero has no inverse.
    let known = free.map_or(information, |free| {
        information + free * free.transpose() / UNKNOWN
    });
    let mut cov = known.try_inverse();
    if let (Some(cov), None) = (&mut cov, &free) {
        let step = -(*cov * (sums.gradient * per_pair));
        let left = way_left(moving, fixed, pose, step, cov, config);
        *cov += left * left.transpose();
        if let Some(step) = back.and_then(|back| back.step) {
            *cov += step * step.transpose();
        }
    }
    let count = moving.points().len();
    let overlap = sums.inliers as f64 / count.max(1) as f64;
    let verdict = if told < matching.min_points.min(count.max(3)) {
        Verdict::TooFewPoints { found: told }
    } else if all.part() < config.min_agreement
        || overlap.min(part(all.agree)) < config.min_overlap
        || sigma > most_scatter(moving, fixed, config)
    {
        Verdict::LocalMinimum {
            agreement: all.part(),
        }
    } else if let Some(free) = &free {
        Verdict::Degenerate {
            direction: unit(free.xy()),
        }
    } else if along.of >= config.fewest_along && along.part() < config.min_agreement_along {
        Verdict::LocalMinimum {
            agreement: along.part(),
        }
    } else if found.is_settled {
        Verdict::Converged
    } else {
        Verdict::NotConverged
    };
    let counted = (&sums, count);
    Judged {
        registration: outcome(*pose, cov, information, counted, found.iterations, verdict),
        agree: all.agree,
        is_partial,
    }
}

/// How far it is from `pose` to where the pairs fit best, with `step` as the first step there: what
/// the method left undone. If that is more than noise explains, the pairs are looked for again,
/// because other points are nearest there.
fn way_left(
    moving: &Cloud,
    fixed: &Cloud,
    pose: &Pose2,
    step: Vector3<f64>,
    cov: &Matrix3<f64>,
    config: &JudgeConfig,
) -> Vector3<f64> {
    let Some(information) = cov.try_inverse() else {
        return step;
    };
    let (mut left, mut step) = (step, step);
    for _ in 1..MOST_STEPS_LEFT {
        if step.dot(&(information * step)) < 1.0 || left.xy().length() > config.beside {
            break;
        }
        let pairs = partners(moving, fixed, &pose.plus(&left), &[]);
        let (sums, _) = sums(&pairs, sigma(&pairs, config), config);
        let Some(next) = sums.step(None) else {
            break;
        };
        step = next;
        left += step;
    }
    left
}

/// What the points of the fixed cloud say about a pose, matched to the surfaces of the moving
/// cloud.
pub(super) struct Back {
    /// The motion (x, y, θ; its shift of length 1) that they hardly constrain.
    pub(super) free: Option<Vector3<f64>>,
    /// By how much they would move the pose; `None` if they do not fix it.
    pub(super) step: Option<Vector3<f64>>,
}

impl Back {
    pub(super) fn of(moving: &Cloud, fixed: &Cloud, pose: &Pose2, config: &JudgeConfig) -> Self {
        let pairs = partners(fixed, moving, &pose.inverse(), &[]);
        let (sums, _) = sums(&pairs, sigma(&pairs, config), config);
        let free = Weakest::of(&sums.hessian).if_free(MatchConfig::default().min_share);
        let free = free.map(|motion| seen_from_other(&motion, pose));
        let step = sums.hessian.try_inverse().map(|cov| -(cov * sums.gradient));
        Self {
            free: free.map(|motion| motion / motion.xy().length()),
            step: step.map(|step| seen_from_other(&step, pose)),
        }
    }
}

/// How a small change of a pose's inverse changes the pose: the derivative of t = -R(-θ') t', θ =
/// -θ' by (t', θ').
pub(super) fn seen_from_other(change: &Vector3<f64>, pose: &Pose2) -> Vector3<f64> {
    let by_turn = Vector2::new(pose.y(), -pose.x()) * change.z;
    (by_turn - pose.rotate(change.xy())).push(-change.z)
}

/// How many points agree, out of how many that could.
#[derive(Clone, Copy, Default)]
struct Count {
    agree: usize,
    of: usize,
}

impl Count {
    fn add(&mut self, agrees: bool) {
        self.agree += usize::from(agrees);
        self.of += 1;
    }

    fn part(&self) -> f64 {
        self.agree as f64 / self.of.max(1) as f64
    }
}

/// How far two clouds agree.
#[derive(Default)]
struct Agreement {
    /// All their points.
    all: Count,
    /// Those whose surfaces constrain one direction.
    along: Count,
}

impl Agreement {
    fn add(&mut self, agrees: bool, tells: bool) {
        self.all.add(agrees);
        if tells {
            self.along.add(agrees);
        }
    }
}

/// Checks for the points of both clouds whether they agree with the other cloud; `there` are the
/// pairs of the moving one. `way` is a direction of the fixed cloud's frame.
fn agreement(
    moving: &Cloud,
    fixed: &Cloud,
    pose: &Pose2,
    there: &[Pair],
    way: &Vector2<f64>,
    limit: f64,
    config: &JudgeConfig,
) -> Agreement {
    let tells =
        |normal: &Vector2<f64>, way: &Vector2<f64>| normal.dot(way).abs() > config.min_cosine_along;
    let mut agreement = Agreement::default();
    let mut is_met = vec![false; fixed.points().len()];
    for pair in there {
        let Some((normal, agrees)) = pair.compare(fixed, limit, config) else {
            continue;
        };
        agreement.add(agrees, tells(&normal, way));
        if let (true, Some(met)) = (agrees, is_met.get_mut(pair.partner)) {
            *met = true;
        }
    }
    // A surface that a point lies on agrees; the others have to be checked.
    let all = is_met.iter().zip(fixed.surfaces());
    for surface in all.filter_map(|(is_met, surface)| is_met.then_some(surface)) {
        let normal = surface.as_ref().map(|surface| &surface.normal);
        agreement.add(true, normal.is_some_and(|normal| tells(normal, way)));
    }
    let back = pose.inverse();
    let way = back.rotate(*way);
    for pair in &partners(fixed, moving, &back, &is_met) {
        if let Some((normal, agrees)) = pair.compare(moving, limit, config) {
            agreement.add(agrees, tells(&normal, &way));
        }
    }
    agreement
}

fn unit(v: Vector2<f64>) -> Vector2<f64> {
    v / v.length()
}

/// A point at the pose that is judged, and its nearest point of the other cloud.
struct Pair {
    /// The nearest point.
    partner: usize,
    /// From the moving frame's origin to the point, in the axes of the other cloud, m.
    arm: Vector2<f64>,
    /// Where the point lies in the other cloud, m.
    place: Point2<f64>,
    /// Squared distance from the nearest point to it, m².
    square: f64,
    /// The normal of the surface there, and the distance across it.
    across: Option<(Vector2<f64>, f64)>,
    /// Cosine of the angle between that surface and the point's own; 1 where one is unknown.
    cosine: f64,
    /// The normal of the surface that the point itself lies on, in the axes of the other cloud.
    own: Option<Vector2<f64>>,
}

/// Pairs each point with its nearest point of the other cloud, except those `left_out`.
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
    /// Points that need no partner; if empty, all points need one.
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
                own,
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
    /// Part of the points of both clouds that lie on no surface: isolated, or in no order.
    pub scatter: f64,
}

/// How two clouds lie on each other at `pose`, which should be the true one.
#[must_use]
pub fn likeness(moving: &Cloud, fixed: &Cloud, pose: &Pose2, config: &JudgeConfig) -> Likeness {
    let pairs = partners(moving, fixed, pose, &[]);
    let sigma = sigma(&pairs, config);
    let on_surface = sums(&pairs, sigma, config).0.inliers;
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

/// Standard deviation of the pairs, from their median, m.
fn sigma(pairs: &[Pair], config: &JudgeConfig) -> f64 {
    let farthest = config.inlier_sigmas * config.most_sigma;
    let facing = pairs.iter().filter(|pair| pair.cosine >= config.min_cosine);
    let all = facing
        .filter_map(|pair| Some(pair.across?.1.abs()))
        .filter(|residual| *residual < farthest);
    let sigma = sigma_of(all).unwrap_or(config.most_sigma);
    sigma.clamp(config.least_sigma, config.most_sigma)
}

/// The largest scatter of pairs that the true pose can have, from how the points of each cloud
/// scatter about their own surfaces, which does not depend on the pose.
fn most_scatter(moving: &Cloud, fixed: &Cloud, config: &JudgeConfig) -> f64 {
    let [moving, fixed] = [moving, fixed].map(|cloud| cloud.sigma().unwrap_or(config.most_sigma));
    let both = (moving * moving + OWN_SHARE * fixed * fixed).sqrt();
    config.max_excess * both + config.unevenness
}

/// What the pairs say about the pose, with the information by the normals of both clouds; and how
/// many pairs have two normals.
fn sums(pairs: &[Pair], sigma: f64, config: &JudgeConfig) -> (Sums, usize) {
    let limit = config.inlier_sigmas * sigma;
    let (mut xx, mut xy, mut yy, mut xt, mut yt, mut tt) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    let (mut gx, mut gy, mut gt) = (0.0, 0.0, 0.0);
    let (mut matched, mut inliers, mut told, mut squares) = (0, 0, 0, 0.0);
    for pair in pairs {
        let Some((normal, residual)) = pair.across else {
            continue;
        };
        matched += 1;
        if residual.abs() >= limit || pair.cosine < config.min_cosine {
            continue;
        }
        inliers += 1;
        squares += residual * residual;
        let by_turn = |normal: &Vector2<f64>| normal.y * pair.arm.x - normal.x * pair.arm.y;
        let turn = by_turn(&normal);
        gx += normal.x * residual;
        gy += normal.y * residual;
        gt += turn * residual;
        let Some(own) = pair.own else {
            continue;
        };
        told += 1;
        // Surfaces of clouds without a sensor have no sides.
        let own = if own.dot(&normal) < 0.0 { -own } else { own };
        let own_turn = by_turn(&own);
        xx += normal.x * own.x;
        xy += 0.5 * (normal.x * own.y + normal.y * own.x);
        yy += normal.y * own.y;
        xt += 0.5 * (normal.x * own_turn + turn * own.x);
        yt += 0.5 * (normal.y * own_turn + turn * own.y);
        tt += turn * own_turn;
    }
    let sums = Sums {
        hessian: Matrix3::new(xx, xy, xt, xy, yy, yt, xt, yt, tt),
        gradient: Vector3::new(gx, gy, gt),
        matched,
        inliers,
        squares,
    };
    (sums, told)
}

impl Pair {
    /// Whether a point on a surface agrees with what the other cloud saw, with the normal of its
    /// own surface. It agrees if it lies on the same surface, to within `limit`; it does not if it
    /// lies beside it, or where the other sensor saw through. `None` if it is hidden, if nothing
    /// was seen in its direction, or if it lies on no surface: an isolated point may be anything.
    #[inline(always)]
    fn compare(
        &self,
        cloud: &Cloud,
        limit: f64,
        config: &JudgeConfig,
    ) -> Option<(Vector2<f64>, bool)> {
        let own = self.own?;
        let beside = config.beside.max(limit);
        if let Some((_, across)) = self.across
            && self.cosine >= config.min_cosine
            && self.square < beside * beside
        {
            return Some((own, across.abs() < limit));
        }
        let Some(view) = cloud.view() else {
            return Some((own, false));
        };
        let [before, after] = view.about(&self.place).map(|at| cloud.points().get(at));
        let (before, after) = before.zip(after)?;
        // Outside the sensor's field of view nothing was seen.
        let is_ahead = |seen: &Point2<f64>| seen.coords.dot(&self.place.coords) > 0.0;
        let least = before
            .coords
            .norm_squared()
            .min(after.coords.norm_squared());
        let range = self.place.coords.length() + config.clearly_before.max(limit);
        let is_through = is_ahead(before) && is_ahead(after) && range * range < least;
        is_through.then_some((own, false))
    }
}

/// The result if no pose was found: nothing is known.
pub(super) fn nothing(found: &Found, points: usize) -> Registration {
    let sums = Sums::default();
    let verdict = Verdict::TooFewPoints { found: 0 };
    let counted = (&sums, points);
    let zero = Matrix3::zeros();
    outcome(found.pose, None, zero, counted, found.iterations, verdict)
}

/// xx of the information between two clouds at their present pose, with pairs of weight 1.
#[cfg(test)]
pub(super) fn information_along_x(moving: &Cloud, fixed: &Cloud, config: &JudgeConfig) -> f64 {
    let pairs = partners(moving, fixed, &Pose2::identity(), &[]);
    sums(&pairs, sigma(&pairs, config), config).0.hessian[(0, 0)]
}
