//! What a method does, iteration by iteration, for callers that want to show it at work.
//!
//! Every method that iterates reports each iteration to a [`Watch`], from the one place where it is
//! computed. `()` ignores them, and then nothing is built: a plain call costs no more than without.

use nalgebra::Point2;

use crate::geom::{Length, Pose2};

/// A point of the moving cloud, and where one iteration pulls it; fixed frame, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correspondence {
    /// Where the point lies before the iteration's step.
    pub from: Point2<f64>,
    /// Its partner: a point, the foot on a surface, the mean of a cell, or, if every point counts a
    /// little, the mean of all points weighted by their probability.
    pub to: Point2<f64>,
    /// Its weight relative to the largest weight in this iteration, up to 1.
    pub weight: f64,
}

/// One iteration of a method.
#[derive(Clone, Debug, PartialEq)]
pub struct Iteration {
    /// `fixed_from_moving` before its step.
    pub pose: Pose2,
    /// How far it looks, m: the scale of the kernel (ICP), the side of a cell (NDT), σ of the
    /// mixture (CPD, GMM), half of the window (correlation).
    pub width: f64,
    /// Root of the mean squared distance of its correspondences by their weights, m; 0 if there are
    /// none.
    pub residual: f64,
    /// Which points are pulled where. Those with less than a hundredth of the largest weight are
    /// left out.
    pub correspondences: Vec<Correspondence>,
}

/// Correspondences with less than this part of the largest weight are left out.
const LEAST_WEIGHT: f64 = 0.01;

impl Iteration {
    /// From correspondences with weights of any scale.
    pub(super) fn of(
        pose: Pose2,
        width: f64,
        pairs: impl IntoIterator<Item = Correspondence>,
    ) -> Self {
        let mut correspondences: Vec<_> = pairs.into_iter().collect();
        let most = correspondences.iter().map(|c| c.weight).fold(0.0, f64::max);
        correspondences.retain_mut(|pair| {
            pair.weight /= most;
            pair.weight >= LEAST_WEIGHT
        });
        let (mut total, mut squares) = (0.0, 0.0);
        for pair in &correspondences {
            let distance = (pair.to - pair.from).length();
            total += pair.weight;
            squares += pair.weight * distance * distance;
        }
        let residual = if total > 0.0 {
            (squares / total).sqrt()
        } else {
            0.0
        };
        Self {
            pose,
            width,
            residual,
            correspondences,
        }
    }
}

/// An observer of the iterations of a method.
pub(super) trait Watch {
    /// Whether it observes anything; if not, nothing needs to be kept for it.
    const LOOKS: bool;

    /// Called once for each iteration, before its step; the iteration is built only if it is
    /// observed.
    fn see(&mut self, iteration: impl FnOnce() -> Iteration);
}

/// Observes nothing.
impl Watch for () {
    const LOOKS: bool = false;

    #[inline]
    fn see(&mut self, _: impl FnOnce() -> Iteration) {}
}

/// Keeps all iterations.
impl Watch for Vec<Iteration> {
    const LOOKS: bool = true;

    fn see(&mut self, iteration: impl FnOnce() -> Iteration) {
        self.push(iteration());
    }
}

/// Observes a method that moves a cloud from where it lies at a start: its poses are relative to
/// it.
pub(super) struct FromStart<'a, W> {
    pub(super) start: Pose2,
    pub(super) watch: &'a mut W,
}

impl<W: Watch> Watch for FromStart<'_, W> {
    const LOOKS: bool = W::LOOKS;

    #[inline]
    fn see(&mut self, iteration: impl FnOnce() -> Iteration) {
        let start = self.start;
        self.watch.see(|| {
            let iteration = iteration();
            Iteration {
                pose: iteration.pose * start,
                ..iteration
            }
        });
    }
}
