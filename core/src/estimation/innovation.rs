//! In: what a scan did to a line map, or the match of a whole scan. Out: how far what was seen lay
//! from where it was expected, with the claimed bounds, and how much of what was seen was known.
//!
//! 1. A filter takes in the sightings of a scan one after the other, and compares each with the
//!    state after the previous ones. So the innovations of an honest filter are independent of each
//!    other, with zero mean and the variance S that it claims (Bar-Shalom, Li & Kirubarajan 2001,
//!    §5.4).
//! 2. For one number of all sightings, such as α, the mean weighted by 1 / S has an information
//!    equal to the sum of the weights, and lies within two standard deviations in 95 of 100 scans.
//!    NIS has lost the sign: an error that is always in the same direction shows here, but hardly
//!    there.
//! 3. A match of whole scans claims no such variance. It has the residual of its points.

use super::ekf_slam::{Decision, Explanation, UpdateReport};
use crate::registration::Registration;

/// One number of all sightings of a scan, seen minus expected: their mean weighted by 1 / σ².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanInnovation {
    /// The mean, rad or m.
    pub mean: f64,
    /// Its standard deviation, as the filter claims it.
    pub sigma: f64,
}

/// The innovations of a scan, by kind; `None` if nothing of that kind was recognised.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Innovations {
    /// Direction of lines, rad.
    pub alpha: Option<MeanInnovation>,
    /// Distance of lines, m.
    pub r: Option<MeanInnovation>,
    /// Points, ahead of the robot, m.
    pub x: Option<MeanInnovation>,
    /// Points, to its left, m.
    pub y: Option<MeanInnovation>,
}

/// How much a scan showed, and what became of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FeatureCounts {
    /// Features found in the scan; for scan matching, points on surfaces.
    pub seen: usize,
    /// Those recognised as a landmark, or lying on a surface of the map.
    pub matched: usize,
    /// Those that became a landmark; `None` for points of surfaces, which do not one by one.
    pub new: Option<usize>,
}

/// How the match of a whole scan fits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanFit {
    /// The number of points that were matched, and of those that lie on a surface.
    pub counts: FeatureCounts,
    /// Root mean square distance of the latter from their surfaces, m.
    pub residual: f64,
}

impl MeanInnovation {
    /// From pairs of an innovation and its σ; `None` if there are none.
    fn of(each: impl Iterator<Item = [f64; 2]>) -> Option<Self> {
        let (sum, weights) = each.fold((0.0, 0.0), |(sum, weights), [innovation, sigma]| {
            let weight = 1.0 / (sigma * sigma);
            (sum + weight * innovation, weights + weight)
        });
        (weights > 0.0 && weights.is_finite()).then(|| Self {
            mean: sum / weights,
            sigma: weights.sqrt().recip(),
        })
    }
}

impl ScanFit {
    /// The fit of a match of this many points.
    #[must_use]
    pub fn of(found: &Registration, points: usize) -> Self {
        Self {
            counts: FeatureCounts {
                seen: points,
                matched: found.inliers,
                new: None,
            },
            residual: found.residual,
        }
    }
}

impl UpdateReport {
    /// How far what was recognised in the scan lay from where it was expected.
    #[must_use]
    pub fn innovations(&self) -> Innovations {
        let lines = || self.explanations().filter_map(|e| recognised(&e));
        let points = || self.point_explanations().filter_map(|e| recognised(&e));
        Innovations {
            alpha: MeanInnovation::of(lines().map(|[alpha, _]| alpha)),
            r: MeanInnovation::of(lines().map(|[_, r]| r)),
            x: MeanInnovation::of(points().map(|[x, _]| x)),
            y: MeanInnovation::of(points().map(|[_, y]| y)),
        }
    }

    /// Lines and points of the scan together.
    #[must_use]
    pub fn feature_counts(&self) -> FeatureCounts {
        FeatureCounts {
            seen: self.explanations().count() + self.point_explanations().count(),
            matched: self.matches.len() + self.point_matches.len(),
            new: Some(self.added.len() + self.points_added.len()),
        }
    }
}

/// Innovation and σ of both numbers of what was recognised.
fn recognised(explanation: &Explanation<'_>) -> Option<[[f64; 2]; 2]> {
    let Decision::Matched(id) = explanation.decision else {
        return None;
    };
    let own = explanation.candidates.iter().find(|c| c.landmark == id)?;
    let ([a, b], [sigma_a, sigma_b]) = (own.innovation, own.sigmas);
    Some([[a, sigma_a], [b, sigma_b]])
}
