//! In: odometry, the points of each scan, and the walls of a prior map. Out: the robot's pose in
//! that map, with covariance.
//!
//! 1. **Predict**: pose and covariance move by the odometry, whose systematic errors are states
//!    like the pose (`ekf_slam::robot_state`; TDK 2016 eq. (3.1)-(3.4)).
//! 2. **Locate** the surfaces of the scan in the walls ([`locate`]), with the predicted pose as
//!    prior: matched, or searched for in a window that grows with each scan that finds nothing.
//! 3. **Update**: the matched pose is the mean given prior and points; what it says of the
//!    odometry's errors follows from their covariance with the pose.
//!
//! Unlike [`super::LineLocaliser`] it asks no line to be the line of the map: a map of cells, in
//! which furniture and doorposts are short and jagged, is used as it was drawn.

use std::borrow::Cow;

use nalgebra::{Matrix3, Point2, Vector3};

use super::OdometryErrors;
use super::ekf_slam::{EkfError, RobotState};
use crate::geom::{Pose2, PoseEstimate, Segment, symmetrize, wrap};
use crate::map::{LikelihoodPyramid, Surfel, SurfelConfig, SurfelMap};
use crate::points::OrientedPoint;
use crate::registration::{
    LocateConfig, Located, Prior, Registration, SearchConfig, Target, Verdict, locate,
};
use crate::robot::Odometry;

/// How a scan is found in a prior map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanLocaliserConfig {
    /// How scans are located in the walls. Default [`LocateConfig::in_prior_map`].
    pub locate: LocateConfig,
    /// Distance of the pieces into which walls are cut, m. Default 0.05.
    pub spacing: f64,
    /// Odometry and the map together are never believed better than this from scan to scan, m:
    /// neighbouring scans see the same errors of the map. Default 0.01.
    pub floor: f64,
    /// The same for the heading, rad. Default 0.003.
    pub turn_floor: f64,
}

impl Default for ScanLocaliserConfig {
    fn default() -> Self {
        Self {
            locate: LocateConfig::in_prior_map(),
            spacing: 0.05,
            floor: 0.01,
            turn_floor: 0.003,
        }
    }
}

/// Most pieces of walls, and how far from the origin they may lie, m: the map of them reaches no
/// farther.
const MOST_PIECES: f64 = 2e6;
const FARTHEST: f64 = 800.0;
/// Finds a robot in a prior map by whole scans.
#[derive(Clone, Debug)]
pub struct ScanLocaliser {
    config: ScanLocaliserConfig,
    walls: Walls,
    state: RobotState,
    /// Scans since one stood on the walls.
    lost_for: usize,
}

/// The walls, which never change: their likelihood is made once.
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
    /// A robot at `start`, map frame, in a map whose `faces` have what is free to the left of the
    /// way from `a` to `b`; odometry is as good as `prior` says (standard deviations).
    ///
    /// # Errors   [`EkfError::Bounds`] where start or prior are no numbers or a figure is out of
    /// range, [`EkfError::PriorMap`] where the walls are longer or lie farther off than can be
    /// held.
    pub fn new(
        faces: impl IntoIterator<Item = Segment>,
        start: &PoseEstimate,
        prior: &OdometryErrors,
        mut config: ScanLocaliserConfig,
    ) -> Result<Self, EkfError> {
        let state = RobotState::starting(start, prior)?;
        config.locate.validate()?;
        let faces: Vec<Segment> = faces.into_iter().collect();
        check_size(&faces, config.spacing)?;
        config.locate.matching.two_sided |= are_thin(&faces);
        let cut = |face: &Segment| pieces(face, config.spacing);
        let pieces: Vec<Surfel> = faces.iter().flat_map(cut).collect();
        let farthest = pieces.iter().map(|p| p.position.coords.amax());
        let surfels = SurfelConfig {
            half_side: farthest.fold(1.0, f64::max) + 1.0,
            ..SurfelConfig::default()
        };
        let places = pieces.iter().map(|piece| piece.position);
        Ok(Self {
            walls: Walls {
                likelihood: config.locate.search.likelihood_of(&places),
                surfels: SurfelMap::from_surfels(surfels, pieces),
            },
            config,
            state,
            lost_for: 0,
        })
    }

    /// The pose in the map.
    #[must_use]
    pub fn estimate(&self) -> PoseEstimate {
        self.state.estimate()
    }

    /// Step 1.
    ///
    /// # Errors   [`EkfError::Odometry`]; then nothing has changed.
    pub fn predict(&mut self, odometry: &Odometry) -> Result<(), EkfError> {
        self.state.predict(odometry)
    }

    /// Steps 2 and 3: takes in the surfaces of one scan, robot frame, and the variance of the
    /// heading that odometry gathered since they were seen, in the mean, rad².
    pub fn update(&mut self, surfaces: &[OrientedPoint], heading_variance: f64) {
        let (way, turn) = (self.config.floor, self.config.turn_floor);
        let floor = Vector3::new(way * way, way * way, turn * turn);
        let mut predicted = self.state.estimate();
        predicted.cov += Matrix3::from_diagonal(&floor);
        let prior = Prior {
            pose: predicted.pose,
            information: predicted.cov.try_inverse().unwrap_or_else(Matrix3::zeros),
        };
        let located = locate(
            surfaces,
            &self.walls,
            &prior,
            self.lost_for,
            &self.config.locate,
        );
        match located {
            Located::Matched(_) | Located::Found(_) => self.lost_for = 0,
            // Nothing was seen, which says nothing.
            Located::Lost(_) if surfaces.is_empty() => {}
            Located::Lost(_) => self.lost_for += 1,
        }
        let found = *located.registration();
        let is_match = matches!(
            found.verdict,
            Verdict::Converged | Verdict::Degenerate { .. }
        );
        match located {
            Located::Found(_) => self.restart(&found),
            _ if is_match => self.correct(&predicted, &found, heading_variance),
            _ => {}
        }
    }

    /// Step 3. The match is the mean of prior and points, x = (P⁻¹ + I)⁻¹ (P⁻¹ x̂ + I z). But what
    /// the points say is worth less than I: the heading errs by Q from the middle of the sweep to
    /// now. With I' = (I⁻¹ + Q)⁻¹ = (1 + I Q)⁻¹ I, which asks for no inverse of I, the update is P'
    /// = (P⁻¹ + I')⁻¹ and x' = x̂ + P' (1 + I Q)⁻¹ (P⁻¹ + I) (x - x̂).
    fn correct(&mut self, predicted: &PoseEstimate, found: &Registration, heading_variance: f64) {
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
        let (before, matched) = (&predicted.pose, &found.estimate.pose);
        let matched = Vector3::new(
            matched.x() - before.x(),
            matched.y() - before.y(),
            wrap(matched.heading() - before.heading()),
        );
        let shift = cov * less * (information + said) * matched;
        let state = &mut self.state;
        // Regression of the odometry's errors on the pose.
        let by_pose = state.cov.fixed_view::<2, 3>(3, 0) * information;
        let errors = by_pose * shift;
        let less = by_pose * (predicted.cov - cov) * by_pose.transpose();
        let cross = by_pose * cov;
        state.pose = Pose2::new(
            before.x() + shift[0],
            before.y() + shift[1],
            before.heading() + shift[2],
        );
        state.errors.curvature += errors[0];
        state.errors.turn_scale += errors[1];
        state.cov.fixed_view_mut::<3, 3>(0, 0).copy_from(&cov);
        state.cov.fixed_view_mut::<2, 3>(3, 0).copy_from(&cross);
        state
            .cov
            .fixed_view_mut::<3, 2>(0, 3)
            .copy_from(&cross.transpose());
        let mut own = state.cov.fixed_view_mut::<2, 2>(3, 3);
        own -= less;
        symmetrize(&mut state.cov);
    }

    /// The pose comes from the scan alone, and says nothing of the odometry.
    fn restart(&mut self, found: &Registration) {
        let state = &mut self.state;
        state.pose = found.estimate.pose;
        let cov = &found.estimate.cov;
        state.cov.fixed_view_mut::<3, 3>(0, 0).copy_from(cov);
        state.cov.fixed_view_mut::<2, 3>(3, 0).fill(0.0);
        state.cov.fixed_view_mut::<3, 2>(0, 3).fill(0.0);
    }
}

/// Before there are any pieces: a plan of a few kilobytes may show walls of a thousand kilometres.
fn check_size(faces: &[Segment], spacing: f64) -> Result<(), EkfError> {
    let finite = faces.iter().filter(|face| face.length().is_finite());
    let count: f64 = finite.map(|face| (face.length() / spacing).ceil()).sum();
    let ends = faces.iter().flat_map(|face| [face.a, face.b]);
    let farthest = ends
        .map(|end| end.coords.amax())
        .filter(|far| far.is_finite());
    let farthest = farthest.fold(0.0, f64::max);
    for (what, value, most) in [
        (
            "number of pieces of the prior map's walls",
            count,
            MOST_PIECES,
        ),
        (
            "distance of the prior map's walls from its origin, m",
            farthest,
            FARTHEST,
        ),
    ] {
        if value > most {
            return Err(EkfError::PriorMap { what, value, most });
        }
    }
    Ok(())
}

/// Whether most walls have no thickness: one face after the other, they are there and back.
fn are_thin(faces: &[Segment]) -> bool {
    let is_back = |pair: &&[Segment]| pair[0].a == pair[1].b && pair[0].b == pair[1].a;
    2 * faces.chunks_exact(2).filter(is_back).count() > faces.len() / 2
}

/// A face cut into pieces, in their middles.
fn pieces(face: &Segment, spacing: f64) -> impl Iterator<Item = Surfel> + use<> {
    let (a, along) = (face.a, face.vector());
    let length = along.norm();
    let count = if length > 0.0 && length.is_finite() {
        (length / spacing).ceil().clamp(1.0, 1e5) as usize
    } else {
        0
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
