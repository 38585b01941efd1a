//! In: the state that odometry predicts, the points of each scan, and the walls of a prior map.
//! Out: the state corrected by that map.
//!
//! 1. **Predict**: pose and covariance move by the odometry, whose systematic errors are states
//!    like the pose ([`RobotState::predict`]; TDK 2016 eq. (3.1)-(3.4)).
//! 2. **Locate** the surfaces of the scan in the walls ([`locate`]), with the predicted pose as
//!    prior: matched, or searched for in a window that grows with each scan that is not found.
//! 3. **Update**: the matched pose is the mean given prior and points; the update of the odometry's
//!    errors follows from their covariance with the pose.
//!
//! Unlike [`super::LineLocaliser`], it does not assign lines of the scan to lines of the map: a map
//! of cells, in which furniture and doorposts are short and jagged, can be used as it was drawn.

use std::borrow::Cow;

use nalgebra::{Matrix2x3, Matrix3, Point2, Vector3};

use super::ekf_slam::{EkfError, RobotState};
use super::innovation::ScanFit;
use crate::geom::{Length, PoseEstimate, Segment, pose_cov, symmetrize};
use crate::map::{LikelihoodPyramid, Surfel, SurfelConfig, SurfelMap};
use crate::points::OrientedPoint;
use crate::registration::{
    LocateConfig, Located, Prior, Registration, SearchConfig, Target, Verdict, locate,
};

/// Spacing of the pieces into which walls are cut, m.
pub(super) const SPACING: f64 = 0.05;
/// Odometry and map together are never believed to be more accurate than this from scan to scan, m
/// and rad: neighbouring scans see the same errors of the map.
const FLOOR: [f64; 2] = [0.01, 0.003];
/// The most pieces of walls, and their largest distance from the origin, m: the surfel map reaches
/// no farther.
const MOST_PIECES: f64 = 2e6;
const FARTHEST: f64 = 800.0;

/// Localises a robot in a prior map by whole scans.
#[derive(Clone, Debug)]
pub struct ScanLocaliser {
    locate: LocateConfig,
    walls: Walls,
    /// Number of scans since one last agreed with the walls.
    lost_for: usize,
}

/// The walls, which never change: their likelihood field is built once.
#[derive(Clone, Debug)]
struct Walls {
    surfels: SurfelMap,
    likelihood: Option<LikelihoodPyramid>,
}

impl Target for Walls {
    #[inline]
    fn nearest(&self, place: Point2<f64>) -> Option<&Surfel> {
        self.surfels.nearest(place)
    }

    fn likelihood(&self, _: &SearchConfig) -> Option<Cow<'_, LikelihoodPyramid>> {
        self.likelihood.as_ref().map(Cow::Borrowed)
    }
}

impl ScanLocaliser {
    /// In a map whose `faces` have free space to the left of the direction from `a` to `b`.
    ///
    /// # Errors   [`EkfError::PriorMap`] if the walls are too long, or too far away, to be held.
    pub fn new(faces: &[Segment]) -> Result<Self, EkfError> {
        check_size(faces)?;
        let mut locate = LocateConfig::in_prior_map();
        locate.matching.two_sided = are_thin(faces);
        let pieces: Vec<Surfel> = faces
            .iter()
            .flat_map(|face| pieces(face, SPACING))
            .collect();
        let farthest = pieces.iter().map(|p| p.position.coords.amax());
        let surfels = SurfelConfig {
            half_side: farthest.fold(1.0, f64::max) + 1.0,
            ..SurfelConfig::default()
        };
        let places = pieces.iter().map(|piece| piece.position);
        Ok(Self {
            walls: Walls {
                likelihood: locate.search.likelihood_of(&places),
                surfels: SurfelMap::from_surfels(surfels, pieces),
            },
            locate,
            lost_for: 0,
        })
    }

    /// Continues from a pose found elsewhere, which says nothing about the odometry.
    pub fn restart(&mut self, state: &mut RobotState, found: &PoseEstimate) {
        self.lost_for = 0;
        state.pose = found.pose;
        set_pose_cov(state, &found.cov, &Matrix2x3::zeros());
    }

    /// Steps 2 and 3: corrects `state` by the surfaces of one scan, robot frame; `heading_variance`
    /// is the heading variance that odometry has accumulated since they were seen, on average,
    /// rad². Returns how well they fit; `None` if they do not.
    pub fn update(
        &mut self,
        state: &mut RobotState,
        surfaces: &[OrientedPoint],
        heading_variance: f64,
    ) -> Option<ScanFit> {
        let mut predicted = state.estimate();
        predicted.cov += pose_cov(FLOOR[0], FLOOR[1]);
        let prior = Prior {
            pose: predicted.pose,
            information: predicted.cov.try_inverse().unwrap_or_else(Matrix3::zeros),
        };
        let located = locate(surfaces, &self.walls, &prior, self.lost_for, &self.locate);
        match located {
            Located::Matched(_) | Located::Found(_) => self.lost_for = 0,
            // Nothing was seen, so this says nothing.
            Located::Lost(_) if surfaces.is_empty() => {}
            Located::Lost(_) => self.lost_for += 1,
        }
        let found = located.registration();
        match (located, found.verdict) {
            (Located::Found(_), _) => self.restart(state, &found.estimate),
            (_, Verdict::Converged | Verdict::Degenerate { .. }) => {
                correct(state, &predicted, found, heading_variance);
            }
            _ => {}
        }
        let is_located = !matches!(located, Located::Lost(_));
        is_located.then(|| ScanFit::of(found, surfaces.len()))
    }
}

/// Step 3. The match is the mean of prior and points, x = (P⁻¹ + I)⁻¹ (P⁻¹ x̂ + I z). But the
/// points are less informative than I: the heading errs by Q from the middle of the sweep to now.
/// With I' = (I⁻¹ + Q)⁻¹ = (1 + I Q)⁻¹ I, which needs no inverse of I, the update is P' = (P⁻¹ +
/// I')⁻¹ and x' = x̂ + P' (1 + I Q)⁻¹ (P⁻¹ + I) (x - x̂).
fn correct(
    state: &mut RobotState,
    predicted: &PoseEstimate,
    found: &Registration,
    heading_variance: f64,
) {
    let swept = Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, heading_variance));
    let said = found.information;
    let Some(information) = predicted.cov.try_inverse() else {
        return;
    };
    let Some(less) = (Matrix3::identity() + said * swept).try_inverse() else {
        return;
    };
    let Some(mut cov) = (information + less * said).try_inverse() else {
        return;
    };
    symmetrize(&mut cov);
    let matched = found.estimate.pose.minus(&predicted.pose);
    let shift = cov * less * (information + said) * matched;
    // Regression of the odometry's errors on the pose.
    let by_pose = state.cov.fixed_view::<2, 3>(3, 0) * information;
    let errors = by_pose * shift;
    let less = by_pose * (predicted.cov - cov) * by_pose.transpose();
    let cross = by_pose * cov;
    state.pose = predicted.pose.plus(&shift);
    state.errors.curvature += errors[0];
    state.errors.turn_scale += errors[1];
    set_pose_cov(state, &cov, &cross);
    let mut own = state.cov.fixed_view_mut::<2, 2>(3, 3);
    own -= less;
    symmetrize(&mut state.cov);
}

/// `cross` is the covariance of the odometry's errors with the pose.
fn set_pose_cov(state: &mut RobotState, cov: &Matrix3<f64>, cross: &Matrix2x3<f64>) {
    let mut view = state.cov.fixed_view_mut::<3, 3>(0, 0);
    view.copy_from(cov);
    let mut view = state.cov.fixed_view_mut::<2, 3>(3, 0);
    view.copy_from(cross);
    let mut view = state.cov.fixed_view_mut::<3, 2>(0, 3);
    view.copy_from(&cross.transpose());
}

/// Checked before any pieces are made: a plan of a few kilobytes may have walls of a thousand
/// kilometres.
pub(super) fn check_size(faces: &[Segment]) -> Result<(), EkfError> {
    let finite = faces.iter().filter(|face| face.length().is_finite());
    let count: f64 = finite.map(|face| (face.length() / SPACING).ceil()).sum();
    let ends = faces.iter().flat_map(|face| [face.a, face.b]);
    let farthest = ends
        .map(|end| end.coords.amax())
        .filter(|far| far.is_finite());
    let farthest = farthest.fold(0.0, f64::max);
    let pieces = "number of pieces of the prior map's walls";
    let distance = "distance of the prior map's walls from its origin, m";
    for (what, value, most) in [(pieces, count, MOST_PIECES), (distance, farthest, FARTHEST)] {
        if value > most {
            return Err(EkfError::PriorMap { what, value, most });
        }
    }
    Ok(())
}

/// Whether most walls have no thickness: their faces come in pairs, there and back.
fn are_thin(faces: &[Segment]) -> bool {
    let is_back = |pair: &&[Segment]| pair[0].a == pair[1].b && pair[0].b == pair[1].a;
    2 * faces.chunks_exact(2).filter(is_back).count() > faces.len() / 2
}

/// A face cut into pieces, each given by its centre.
pub(super) fn pieces(face: &Segment, spacing: f64) -> impl Iterator<Item = Surfel> + use<> {
    let (a, along) = (face.a, face.vector());
    let length = along.length();
    let count = match length > 0.0 && length.is_finite() {
        true => (length / spacing).ceil().clamp(1.0, 1e5) as usize,
        false => 0,
    };
    let normal = nalgebra::Vector2::new(-along.y, along.x) / length;
    (0..count).map(move |i| Surfel {
        position: a + along * ((i as f64 + 0.5) / count as f64),
        normal,
        weight: 1.0,
    })
}

#[cfg(test)]
mod tests;
