//! A cloud of points to be registered, and the surface at each of them.
//!
//! In: points, in any order or in that of a sensor's beams. Out: the points with what every method
//! needs: the surface at each point, and the sensor's view, if there was one.

use nalgebra::Point2;

use super::super::first_too_far;
use super::bearings::Bearings;
use super::surfaces::{median, nearest_surfaces, scan_surfaces};
use crate::points::OrientedPoint;

/// Variance of a surface as a part of the variance of a point: the noise that remains in a line
/// through about five points, and how far a point draws that line towards itself.
pub(super) const OWN_SHARE: f64 = 0.2;

/// Why points do not make a cloud.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CloudError {
    /// A coordinate is not a number, or farther away than any sensor sees.
    #[error("point {index} is not finite, or farther away than 1e6 m")]
    NotFinite {
        /// The point, from 0.
        index: usize,
    },
    /// More points than a cloud may have.
    #[error("{found} points, expected at most {most}", most = Cloud::MOST_POINTS)]
    TooManyPoints {
        /// How many there are.
        found: usize,
    },
}

/// Points of one scan, or any others.
#[derive(Clone, Debug)]
pub struct Cloud {
    points: Vec<Point2<f64>>,
    surfaces: Vec<Option<OrientedPoint>>,
    view: Option<Bearings>,
    /// m.
    sigma: Option<f64>,
}

impl Cloud {
    /// Clouds with more points cannot be registered in a reasonable time.
    pub const MOST_POINTS: usize = 100_000;

    /// What a sensor at the origin saw, all round or in a part of the circle: `points` in its
    /// frame, m, in any order; they are sorted by bearing.
    ///
    /// # Errors    [`CloudError`]: an invalid point, or too many points.
    pub fn scan(points: Vec<Point2<f64>>) -> Result<Self, CloudError> {
        check(&points)?;
        let mut points = points;
        let view = Bearings::sort(&mut points);
        let surfaces = scan_surfaces(&points, view.columns());
        Ok(Self {
            sigma: noise(&points, &surfaces),
            points,
            surfaces,
            view: Some(view),
        })
    }

    /// Points in any order, m, with unknown viewpoint.
    ///
    /// # Errors    [`CloudError`]: an invalid point, or too many points.
    pub fn any(points: Vec<Point2<f64>>) -> Result<Self, CloudError> {
        check(&points)?;
        let surfaces = nearest_surfaces(&points);
        Ok(Self {
            sigma: noise(&points, &surfaces),
            points,
            surfaces,
            view: None,
        })
    }

    /// The points, m; those of a scan are sorted by bearing.
    #[must_use]
    pub fn points(&self) -> &[Point2<f64>] {
        &self.points
    }

    /// The surface at each point: its position, smoothed across the surface, and its unit normal,
    /// which points to the sensor for a scan. `None` where the neighbours do not form a line.
    #[must_use]
    pub fn surfaces(&self) -> &[Option<OrientedPoint>] {
        &self.surfaces
    }

    /// Standard deviation of the points across their own surfaces, m: the sensor's noise, whatever
    /// the pose; `None` if there is no surface.
    pub(super) fn sigma(&self) -> Option<f64> {
        self.sigma
    }

    /// The points by their bearings from the sensor; `None` if there was no sensor.
    pub(super) fn view(&self) -> Option<&Bearings> {
        self.view.as_ref()
    }
}

fn check(points: &[Point2<f64>]) -> Result<(), CloudError> {
    let found = points.len();
    if found > Cloud::MOST_POINTS {
        return Err(CloudError::TooManyPoints { found });
    }
    match first_too_far(points) {
        Some(index) => Err(CloudError::NotFinite { index }),
        None => Ok(()),
    }
}

/// Standard deviation of points across their surfaces, from the median.
fn noise(points: &[Point2<f64>], surfaces: &[Option<OrientedPoint>]) -> Option<f64> {
    let off = |(point, surface): (&Point2<f64>, &Option<OrientedPoint>)| {
        let surface = surface.as_ref()?;
        Some(surface.normal.dot(&(point - surface.position)).abs())
    };
    let off = points.iter().zip(surfaces).filter_map(off);
    Some(sigma_of(off)? / (1.0 - OWN_SHARE).sqrt())
}

/// Standard deviation of a normal distribution from the median of its absolute values.
pub(super) fn sigma_of(absolute: impl Iterator<Item = f64>) -> Option<f64> {
    const BY_MEDIAN: f64 = 1.4826;
    Some(BY_MEDIAN * median(absolute)?)
}
