//! Which points of two clouds are taken to be the same, at a pose.

use nalgebra::{Point2, Vector2};

use super::super::neighbours::Neighbours;
use super::super::{Cloud, facing};
use super::{Association, IcpConfig, Metric};
use crate::geom::Pose2;
use crate::lanes::{Kernel, Lanes};

/// Among how many nearest points the one along the normal is looked for.
const ALONG_NORMAL_AMONG: usize = 8;

/// Two points that are taken to be the same.
pub(super) struct Pair {
    /// From the moving frame's origin to the point, in the axes of the fixed cloud, m.
    pub(super) arm: Vector2<f64>,
    /// From the partner to the point, m.
    pub(super) off: Vector2<f64>,
    /// The partner's normal, and the point's own in the fixed axes.
    pub(super) normals: [Option<Vector2<f64>>; 2],
    pub(super) square: f64,
}

/// A point of the moving cloud that looks for a partner.
pub(super) struct Seeker {
    pub(super) index: usize,
    /// Its previous partner: the next one will be near it.
    pub(super) partner: Option<usize>,
}

/// Where partners are looked for.
pub(super) struct Search<'a> {
    moving: &'a Cloud,
    fixed: &'a Cloud,
    config: &'a IcpConfig,
    /// Of the fixed cloud, if the association needs it.
    tree: Option<Neighbours>,
    /// Of the moving cloud, if pairs have to be mutual.
    back: Option<Neighbours>,
}

impl<'a> Search<'a> {
    pub(super) fn of(moving: &'a Cloud, fixed: &'a Cloud, config: &'a IcpConfig) -> Self {
        let by_bearing = config.association == Association::ByBearing && fixed.view().is_some();
        Self {
            moving,
            fixed,
            config,
            tree: (!by_bearing).then(|| Neighbours::of(fixed.points())),
            back: config.is_mutual.then(|| Neighbours::of(moving.points())),
        }
    }

    /// The partner of a point at `place`, and its squared distance.
    #[inline(always)]
    fn partner<L: Lanes>(
        &self,
        machine: L::Machine,
        place: &Point2<f64>,
        normal: Option<Vector2<f64>>,
        before: Option<usize>,
    ) -> Option<(usize, f64)> {
        match (&self.tree, self.fixed.view()) {
            (None, Some(view)) => match before {
                None => view.nearest::<L>(machine, place),
                Some(before) => view.nearest_from::<L>(machine, before, place),
            },
            (Some(tree), _) => match (self.config.association, normal) {
                (Association::AlongNormal, Some(normal)) => self.along_normal(tree, place, &normal),
                _ => tree.nearest(*place),
            },
            (None, None) => None,
        }
    }

    fn along_normal(
        &self,
        tree: &Neighbours,
        place: &Point2<f64>,
        normal: &Vector2<f64>,
    ) -> Option<(usize, f64)> {
        let among = tree.nearest_few(*place, ALONG_NORMAL_AMONG).into_iter();
        let off = |index: usize| {
            let off = self.fixed.points().get(index)? - place;
            Some((index, off.perp(normal).abs(), off.norm_squared()))
        };
        let best = among.filter_map(off).min_by(|a, b| a.1.total_cmp(&b.1))?;
        Some((best.0, best.2))
    }
}

/// Looks for the pairs at a pose.
pub(super) struct Pairing<'a, T> {
    pub(super) search: &'a Search<'a>,
    pub(super) points: &'a mut [Seeker],
    /// One point in this many is paired.
    pub(super) stride: usize,
    pub(super) pose: &'a Pose2,
    /// Of the kernel, m.
    pub(super) scale: f64,
    pub(super) taker: &'a mut T,
}

/// Takes pairs as they are found. Implementations must be `#[inline(always)]`, or they are not
/// compiled for the wider instructions.
pub(super) trait Taker {
    fn take(&mut self, pair: Pair);
}

/// Keeps all pairs.
impl Taker for Vec<Pair> {
    #[inline(always)]
    fn take(&mut self, pair: Pair) {
        self.push(pair);
    }
}

impl<T: Taker> Kernel for Pairing<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) {
        let Search {
            moving,
            fixed,
            config,
            back,
            ..
        } = self.search;
        let farthest = config.max_scales * self.scale;
        let on_lines = config.metric != Metric::PointToPoint;
        let moving_from_fixed = self.pose.inverse();
        let is_sided = fixed.view().is_some() && moving.view().is_some();
        for seeker in self.points.iter_mut().step_by(self.stride) {
            let own = moving.surfaces().get(seeker.index).and_then(Option::as_ref);
            let Some(point) = moving.points().get(seeker.index) else {
                continue;
            };
            // If a method knows surfaces, points are put onto them, not left where noise put them.
            let position = match own {
                Some(surface) if config.metric == Metric::SurfaceToSurface => &surface.position,
                _ => point,
            };
            let arm = self.pose.rotate(position.coords);
            let place = self.pose.position() + arm;
            let own = own.map(|surface| self.pose.rotate(surface.normal));
            let found = self
                .search
                .partner::<L>(machine, &place, own, seeker.partner);
            let Some((partner, square)) = found else {
                continue;
            };
            seeker.partner = Some(partner);
            if square > farthest * farthest {
                continue;
            }
            let surface = fixed.surfaces().get(partner).and_then(Option::as_ref);
            let Some(other) = fixed.points().get(partner) else {
                continue;
            };
            let normal = surface.map(|surface| surface.normal);
            if on_lines && normal.is_none() || facing(own, normal, is_sided) < config.min_cosine {
                continue;
            }
            if let Some(tree) = back
                && tree
                    .nearest(moving_from_fixed * *other)
                    .is_none_or(|(nearest, _)| nearest != seeker.index)
            {
                continue;
            }
            let other = match surface {
                Some(surface) if on_lines => &surface.position,
                _ => other,
            };
            self.taker.take(Pair {
                arm,
                off: place - other,
                normals: [normal, own],
                square,
            });
        }
    }
}

/// Keeps this part of the pairs, the nearest ones.
pub(super) fn trim(pairs: &mut Vec<Pair>, kept: f64) {
    let count = (kept * pairs.len() as f64).ceil() as usize;
    if count < pairs.len() {
        pairs.select_nth_unstable_by(count, |a, b| a.square.total_cmp(&b.square));
        pairs.truncate(count);
    }
}
