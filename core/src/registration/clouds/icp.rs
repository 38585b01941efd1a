//! Iterated closest points, in all its forms.
//!
//! In: two clouds and a start. Out: the pose at which pairs of nearest points lie best on each
//! other.
//!
//! 1. Points of the moving cloud are **selected**.
//! 2. Each is **paired** with a point of the fixed cloud.
//! 3. Pairs are **rejected**, or given less weight the farther they are apart. How far they may be
//!    shrinks from iteration to iteration: a bad start is pulled in, and outliers end without say.
//! 4. The motion that makes the **metric** of all pairs least is taken: for point to point in
//!    closed form (the SVD of the cross covariance, which in the plane is one angle), else by a
//!    Gauss-Newton step.
//!
//! Sources: Besl & McKay (1992), "A method for registration of 3-D shapes"; Censi (2008), "An ICP
//! variant using a point-to-line metric"; Segal, Haehnel & Thrun (2009), "Generalized-ICP"; the
//! stages as in Rusinkiewicz & Levoy (2001), "Efficient variants of the ICP algorithm".

use nalgebra::{Matrix2, Point2, Vector2, Vector3};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::super::gauss_newton::{MatchConfig, Sums, free_direction};
use super::super::trace::{Correspondence, Iteration, Watch};
use super::bearings::nearest_from;
use super::neighbours::Neighbours;
use super::{Cloud, Found};
use crate::bounds::config;
use crate::geom::{Length, Pose2};

/// What is made as small as possible.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Metric {
    /// Distances of points from points (Besl & McKay 1992).
    PointToPoint,
    /// Distances of points from the lines through the neighbours of points (Censi 2008).
    #[default]
    PointToLine,
    /// Distances of surfaces from surfaces: each point is sure across its surface and unsure along
    /// it (Segal et al. 2009).
    SurfaceToSurface,
}

/// Which points of the moving cloud are paired.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Selection {
    /// All of them.
    #[default]
    All,
    /// So many, drawn by a seed.
    Random {
        /// How many.
        count: usize,
        /// Of the random numbers.
        seed: u64,
    },
    /// So many, their surfaces facing all directions alike: little that faces where few do is
    /// lost.
    UniformNormals {
        /// How many.
        count: usize,
    },
    /// Those where the surface bends: neighbours face elsewhere by more than this, rad.
    KeyPoints {
        /// The least bend.
        bend: f64,
    },
}

/// How a point finds its partner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Association {
    /// The nearest among what the sensor saw in about the same direction; of clouds that no sensor
    /// saw, as `Nearest`.
    #[default]
    ByBearing,
    /// The nearest, by a k-d tree.
    Nearest,
    /// Of the nearest few that which lies nearest to the point's normal (Chen & Medioni 1992).
    AlongNormal,
}

/// What pairs weigh, besides what the kernel makes of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Weighting {
    /// All the same.
    #[default]
    Equal,
    /// Less the more their surfaces face different ways.
    ByNormals,
    /// Less the farther they are apart, down to nothing at the largest distance.
    ByDistance,
}

/// How the say of a pair falls with its distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RobustKernel {
    /// Not at all.
    None,
    /// In proportion, from the scale on (Huber 1964).
    Huber,
    /// Ever faster, so that far ones have none.
    #[default]
    Cauchy,
}

config! {
    /// A form of ICP.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct IcpConfig {
        /// Default: points to lines.
        pub metric: Metric = Metric::default(),
        /// Default: all.
        pub selection: Selection = Selection::default(),
        /// Default: by bearing.
        pub association: Association = Association::default(),
        /// Default: all the same.
        pub weighting: Weighting = Weighting::default(),
        /// Default: Cauchy's.
        pub kernel: RobustKernel = RobustKernel::default(),
        /// Scale of the kernel at the first iteration, m. Default 0.5; larger pulls in worse
        /// starts, and outliers with them.
        pub first_scale: f64 = 0.5,
        /// Scale of the kernel at the end, m: about twice the noise. Default 0.03.
        pub last_scale: f64 = 0.03,
        /// What is left of the scale after an iteration. Default 0.5; larger forgives worse starts
        /// and takes longer.
        pub shrink: f64 = 0.5,
        /// While the scale shrinks, one of so many points is paired: what is pulled in from afar
        /// needs no precision. Default 4; larger is quicker, and misled by less.
        pub coarse_stride: usize = 4,
        /// Pairs farther apart than so many scales of the kernel are rejected. Default 4.
        pub max_scales: f64 = 4.0,
        /// Part of the pairs that is kept, the nearest ones (trimmed ICP). Default 1: all.
        pub kept: f64 = 1.0,
        /// Whether only pairs are kept of which each is the nearest to the other. Default false.
        pub is_mutual: bool = false,
        /// Cosine of the largest angle between surfaces that may be the same. Default 0.5.
        pub min_cosine: f64 = 0.5,
        /// Most iterations. Default 50.
        pub max_iterations: usize = 50,
        /// A step smaller than this is nothing, m. Default 3e-4: a third of what noise leaves.
        pub shift_tolerance: f64 = 3e-4,
        /// A step smaller than this is nothing, rad. Default 1e-4.
        pub turn_tolerance: f64 = 1e-4,
    }
}

impl IcpConfig {
    /// As it is best for points to points: what is sampled at other places lies apart by the
    /// spacing of the points, which a narrow kernel would take for outliers.
    #[must_use]
    pub fn point_to_point() -> Self {
        Self {
            metric: Metric::PointToPoint,
            last_scale: 0.15,
            shrink: 0.7,
            coarse_stride: 1,
            ..Self::default()
        }
    }
}

/// Standard deviation of a point along its surface beside that across it, for surface to surface.
const ALONG: f64 = 30.0;
/// Nearest points among which one along the normal is looked for.
const ALONG_NORMAL_AMONG: usize = 8;
/// Directions that surfaces are sorted into, for uniform normals.
const DIRECTIONS: usize = 16;
/// The least pairs that say anything of a pose.
const FEWEST_PAIRS: usize = 3;

/// A point that had no partner yet.
const NO_HINT: usize = usize::MAX;

/// Two points that are taken for the same.
struct Pair {
    /// From the moving frame's origin to the point, in the axes of the fixed cloud, m.
    arm: Vector2<f64>,
    /// From the partner to the point, m.
    off: Vector2<f64>,
    /// The partner's normal, and the point's own in the fixed axes.
    normals: [Option<Vector2<f64>>; 2],
    square: f64,
}

impl Pair {
    /// From the line through the partner to the point, m.
    fn across(&self, normal: &Vector2<f64>) -> f64 {
        normal.dot(&self.off)
    }

    /// The information of the pair by both surfaces, and how far apart they are by it, m.
    fn between_surfaces(&self) -> Option<(Matrix2<f64>, f64)> {
        let [Some(normal), own] = self.normals else {
            return None;
        };
        let across = |n: &Vector2<f64>| n * n.transpose() * (1.0 / (ALONG * ALONG) - 1.0);
        let one = |n: &Vector2<f64>| Matrix2::identity() + across(n);
        let cov = one(&normal) + one(&own.unwrap_or(normal));
        let information = cov.try_inverse()?;
        let square = self.off.dot(&(information * self.off));
        Some((
            information,
            std::f64::consts::SQRT_2 / ALONG * square.sqrt(),
        ))
    }

    /// What the metric makes small.
    fn residual(&self, metric: Metric) -> Option<f64> {
        match metric {
            Metric::PointToPoint => Some(self.off.length()),
            Metric::PointToLine => self.normals[0].map(|normal| self.across(&normal)),
            Metric::SurfaceToSurface => self.between_surfaces().map(|(_, residual)| residual),
        }
    }
}

/// Runs ICP from `start`.
pub(super) fn run(
    moving: &Cloud,
    fixed: &Cloud,
    start: &Pose2,
    config: &IcpConfig,
    watch: &mut impl Watch,
) -> Found {
    let selected = select(moving, config.selection);
    let search = Search::of(moving, fixed, config);
    let mut found = Found::start(start);
    let mut scale = config.first_scale.max(config.last_scale);
    let mut pairs = Vec::with_capacity(selected.len());
    let mut hints = vec![NO_HINT; selected.len()];
    while found.iterations < config.max_iterations && !found.is_settled {
        found.iterations += 1;
        let stride = if scale > config.last_scale {
            config.coarse_stride.max(1)
        } else {
            1
        };
        search.pairs(
            (&selected, &mut hints),
            stride,
            &found.pose,
            scale,
            config,
            &mut pairs,
        );
        if config.kept < 1.0 {
            trim(&mut pairs, config.kept);
        }
        watch.see(|| iteration(&pairs, &found.pose, scale, config));
        if pairs.len() < FEWEST_PAIRS {
            break;
        }
        let Some(step) = step(&pairs, &found.pose, scale, config) else {
            break;
        };
        found.pose = found.pose.plus(&step);
        let is_small =
            step.xy().length() < config.shift_tolerance && step.z.abs() < config.turn_tolerance;
        found.is_settled = is_small && scale <= config.last_scale;
        scale = (config.shrink * scale).max(config.last_scale);
    }
    found
}

/// Who looks for partners.
struct Search<'a> {
    moving: &'a Cloud,
    fixed: &'a Cloud,
    /// Of the fixed cloud, where the association needs it.
    tree: Option<Neighbours>,
    /// Of the moving cloud, where pairs have to be mutual.
    back: Option<Neighbours>,
}

impl<'a> Search<'a> {
    fn of(moving: &'a Cloud, fixed: &'a Cloud, config: &IcpConfig) -> Self {
        let by_bearing = config.association == Association::ByBearing && fixed.view().is_some();
        Self {
            moving,
            fixed,
            tree: (!by_bearing).then(|| Neighbours::of(fixed.points())),
            back: config.is_mutual.then(|| Neighbours::of(moving.points())),
        }
    }

    fn pairs(
        &self,
        (selected, hints): (&[usize], &mut [usize]),
        stride: usize,
        pose: &Pose2,
        scale: f64,
        config: &IcpConfig,
        pairs: &mut Vec<Pair>,
    ) {
        pairs.clear();
        let farthest = config.max_scales * scale;
        let on_lines = config.metric != Metric::PointToPoint;
        let back = pose.inverse();
        for (&index, hint) in selected.iter().zip(hints).step_by(stride) {
            let (Some(point), Some(own)) = (
                self.moving.points().get(index),
                self.moving.surfaces().get(index),
            ) else {
                continue;
            };
            // Where a method knows surfaces, points lie on them, not where noise put them.
            let position = match own {
                Some(surface) if config.metric == Metric::SurfaceToSurface => surface.position,
                _ => *point,
            };
            let arm = pose.rotate(position.coords);
            let place = Point2::new(arm.x + pose.x(), arm.y + pose.y());
            let normal = own.map(|surface| pose.rotate(surface.normal));
            let association = config.association;
            let Some((partner, square)) = self.partner(&place, normal, *hint, association) else {
                continue;
            };
            *hint = partner;
            if square > farthest * farthest {
                continue;
            }
            let (Some(other), Some(surface)) = (
                self.fixed.points().get(partner),
                self.fixed.surfaces().get(partner),
            ) else {
                continue;
            };
            if on_lines && surface.is_none() {
                continue;
            }
            if let (Some(a), Some(b)) = (normal, surface) {
                let cosine = a.dot(&b.normal);
                // Surfaces of clouds that no sensor saw have no sides.
                let is_sided = self.fixed.view().is_some() && self.moving.view().is_some();
                let cosine = if is_sided { cosine } else { cosine.abs() };
                if cosine < config.min_cosine {
                    continue;
                }
            }
            if let Some(tree) = &self.back {
                let there = back * *other;
                if tree
                    .nearest(there)
                    .is_none_or(|(nearest, _)| nearest != index)
                {
                    continue;
                }
            }
            let other = match surface {
                Some(surface) if on_lines => surface.position,
                _ => *other,
            };
            pairs.push(Pair {
                arm,
                off: place - other,
                normals: [surface.map(|surface| surface.normal), normal],
                square,
            });
        }
    }

    fn partner(
        &self,
        place: &Point2<f64>,
        normal: Option<Vector2<f64>>,
        hint: usize,
        association: Association,
    ) -> Option<(usize, f64)> {
        match (association, &self.tree, self.fixed.view()) {
            (Association::ByBearing, None, Some(view)) => match hint {
                NO_HINT => view.nearest(self.fixed.points(), place),
                hint => nearest_from(self.fixed.points(), hint, place),
            },
            (Association::AlongNormal, Some(tree), _) => {
                let among = tree.nearest_few(*place, ALONG_NORMAL_AMONG).into_iter();
                let Some(normal) = normal else {
                    return tree.nearest(*place);
                };
                let off = |index: usize| {
                    let off = self.fixed.points().get(index)? - place;
                    Some((index, off.perp(&normal).abs(), off.norm_squared()))
                };
                let best = among.filter_map(off).min_by(|a, b| a.1.total_cmp(&b.1))?;
                Some((best.0, best.2))
            }
            (_, Some(tree), _) => tree.nearest(*place),
            _ => None,
        }
    }
}

/// Keeps this part of the pairs, the nearest ones.
fn trim(pairs: &mut Vec<Pair>, kept: f64) {
    let count = (kept * pairs.len() as f64).ceil() as usize;
    if count < pairs.len() {
        pairs.select_nth_unstable_by(count, |a, b| a.square.total_cmp(&b.square));
        pairs.truncate(count);
    }
}

/// The pairs of an iteration, with what they weigh.
fn iteration(pairs: &[Pair], pose: &Pose2, scale: f64, config: &IcpConfig) -> Iteration {
    let correspondence = |pair: &Pair| {
        let residual = pair.residual(config.metric)?;
        let from = pose.position() + pair.arm;
        Some(Correspondence {
            from,
            to: from - pair.off,
            weight: weight(pair, residual, scale, config),
        })
    };
    Iteration::of(*pose, scale, pairs.iter().filter_map(correspondence))
}

/// What a pair weighs, so far apart, m.
fn weight(pair: &Pair, residual: f64, scale: f64, config: &IcpConfig) -> f64 {
    let parts = residual / scale;
    let by_kernel = match config.kernel {
        RobustKernel::None => 1.0,
        RobustKernel::Huber => 1.0 / parts.abs().max(1.0),
        RobustKernel::Cauchy => 1.0 / (1.0 + parts * parts),
    };
    let by_weighting = match config.weighting {
        Weighting::Equal => 1.0,
        Weighting::ByNormals => match pair.normals {
            [Some(a), Some(b)] => a.dot(&b).abs(),
            _ => 0.5,
        },
        Weighting::ByDistance => 1.0 - pair.square.sqrt() / (config.max_scales * scale),
    };
    by_kernel * by_weighting
}

/// The motion (x, y, θ) that makes the metric of the pairs least.
fn step(pairs: &[Pair], pose: &Pose2, scale: f64, config: &IcpConfig) -> Option<Vector3<f64>> {
    let weight = |pair: &Pair, residual: f64| weight(pair, residual, scale, config);
    // One row for each metric.
    match config.metric {
        Metric::PointToPoint => rigid_fit(pairs, pose, weight),
        Metric::PointToLine => gauss_newton(pairs, |pair, sums| {
            let [Some(normal), _] = pair.normals else {
                return;
            };
            let residual = pair.across(&normal);
            sums.add_across(&normal, &pair.arm, residual, weight(pair, residual));
        }),
        Metric::SurfaceToSurface => gauss_newton(pairs, |pair, sums| {
            let Some((information, residual)) = pair.between_surfaces() else {
                return;
            };
            sums.add_off(&information, &pair.arm, &pair.off, weight(pair, residual));
        }),
    }
}

/// The rigid motion between paired points in closed form: the angle is that of the cross
/// covariance's rotation, which is what its SVD gives in the plane (Umeyama 1991).
fn rigid_fit(
    pairs: &[Pair],
    pose: &Pose2,
    weight: impl Fn(&Pair, f64) -> f64,
) -> Option<Vector3<f64>> {
    let weighted = || {
        pairs
            .iter()
            .map(|pair| (pair, weight(pair, pair.off.length())))
    };
    let to = |pair: &Pair| pose.position().coords + pair.arm - pair.off;
    let (mut total, mut from_mean, mut to_mean) = (0.0, Vector2::zeros(), Vector2::zeros());
    for (pair, weight) in weighted() {
        total += weight;
        from_mean += pair.arm * weight;
        to_mean += to(pair) * weight;
    }
    if total <= 0.0 {
        return None;
    }
    (from_mean, to_mean) = (from_mean / total, to_mean / total);
    let (mut along, mut across) = (0.0, 0.0);
    for (pair, weight) in weighted() {
        let (a, b) = (pair.arm - from_mean, to(pair) - to_mean);
        along += weight * a.dot(&b);
        across += weight * a.perp(&b);
    }
    let turn = libm::atan2(across, along);
    let turned = Pose2::new(0.0, 0.0, turn).rotate(from_mean);
    Some((to_mean - turned - pose.position().coords).push(turn))
}

fn gauss_newton(pairs: &[Pair], mut add: impl FnMut(&Pair, &mut Sums)) -> Option<Vector3<f64>> {
    let mut sums = Sums::default();
    for pair in pairs {
        add(pair, &mut sums);
    }
    // A direction of which the pairs say next to nothing is left as it is.
    let free = free_direction(&sums.hessian, MatchConfig::default().min_share);
    sums.step(free.as_ref())
}

/// The places of the points to be paired.
fn select(cloud: &Cloud, selection: Selection) -> Vec<usize> {
    let count = cloud.points().len();
    let all = || (0..count).collect::<Vec<_>>();
    let normal = |index: usize| Some(cloud.surfaces().get(index)?.as_ref()?.normal);
    match selection {
        Selection::All => all(),
        Selection::Random { count, seed } => {
            let mut drawn = all();
            drawn.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
            drawn.truncate(count);
            drawn
        }
        Selection::UniformNormals { count } => uniform_normals(&all(), count, normal),
        Selection::KeyPoints { bend } => {
            let least = libm::cos(bend);
            let is_bent = |&index: &usize| {
                let beside = [index.checked_sub(2), Some(index + 2)];
                let [Some(before), Some(after)] = beside.map(|at| at.and_then(normal)) else {
                    return false;
                };
                before.dot(&after) < least
            };
            all().into_iter().filter(is_bent).collect()
        }
    }
}

/// Points in turn from each of the directions that their surfaces face.
fn uniform_normals(
    all: &[usize],
    count: usize,
    normal: impl Fn(usize) -> Option<Vector2<f64>>,
) -> Vec<usize> {
    let mut by_direction: [Vec<usize>; DIRECTIONS] = Default::default();
    for &index in all {
        let Some(normal) = normal(index) else {
            continue;
        };
        let part = libm::atan2(normal.y, normal.x) / std::f64::consts::TAU + 0.5;
        let direction = ((part * DIRECTIONS as f64) as usize).min(DIRECTIONS - 1);
        if let Some(those) = by_direction.get_mut(direction) {
            those.push(index);
        }
    }
    // Of each direction in an even spread along the scan: every k-th first.
    for those in &mut by_direction {
        let share = (count / DIRECTIONS).max(1);
        let stride = those.len().div_ceil(share).max(1);
        let spread = (0..stride).flat_map(|first| those.iter().skip(first).step_by(stride));
        *those = spread.copied().collect();
    }
    let most = by_direction.iter().map(Vec::len).max().unwrap_or(0);
    let in_turn = (0..most).flat_map(|at| by_direction.iter().filter_map(move |d| d.get(at)));
    in_turn.copied().take(count).collect()
}
