//! A cloud of points to be registered, and the surface at each of them.
//!
//! In: points, in any order or in that of a sensor's beams. Out: the points with what every method
//! asks of them: the line through a point's neighbours, and the sensor's view, if there was one.
//!
//! - Of a scan, neighbours are the beams beside, as far as the steps between them are no longer
//!   than those that a wall at this range makes.
//! - Of points in any order they are the nearest ones.
//!
//! A place where the neighbours are no line has no surface: a direction that means nothing would
//! pull a match any way.

use nalgebra::Point2;

use super::super::first_too_far;
use super::bearings::Bearings;
use super::neighbours::Neighbours;
use crate::points::{OrientedPoint, Scatter};

/// Neighbours on either side that make the line of a scan's point.
const BESIDE: usize = 4;
/// Nearest points that make the line of a point in a cloud without order, itself among them.
const NEAREST: usize = 7;
/// A step between beams is one along a wall up to this length, m, ...
const SHORTEST_GAP: f64 = 0.1;
/// ... and up to so many times the spacing of the beams at this range.
const GAP: f64 = 4.0;

/// Why points are no cloud.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CloudError {
    /// A coordinate is not a number, or farther away than anything that a sensor sees.
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
}

impl Cloud {
    /// More points than this are no cloud that can be registered in a reasonable time.
    pub const MOST_POINTS: usize = 100_000;

    /// What a sensor at the origin saw all round or in a part of it: `points` in its frame, m, in
    /// any order; they are sorted by their bearings.
    ///
    /// # Errors    [`CloudError`]: a point that is none, or too many.
    pub fn scan(points: Vec<Point2<f64>>) -> Result<Self, CloudError> {
        check(&points)?;
        let mut points = points;
        let view = Bearings::sort(&mut points);
        let surfaces = scan_surfaces(&points);
        Ok(Self {
            points,
            surfaces,
            view: Some(view),
        })
    }

    /// Points in any order, m, of which nobody says from where they were seen.
    ///
    /// # Errors    [`CloudError`]: a point that is none, or too many.
    pub fn any(points: Vec<Point2<f64>>) -> Result<Self, CloudError> {
        check(&points)?;
        let surfaces = nearest_surfaces(&points);
        Ok(Self {
            points,
            surfaces,
            view: None,
        })
    }

    /// The points, m; those of a scan sorted by their bearings.
    #[must_use]
    pub fn points(&self) -> &[Point2<f64>] {
        &self.points
    }

    /// The surface at each point: where it lies, smoothed across, and its unit normal, for a scan
    /// towards the sensor. `None` where the neighbours are no line.
    #[must_use]
    pub fn surfaces(&self) -> &[Option<OrientedPoint>] {
        &self.surfaces
    }

    /// The points by their bearings from the sensor; `None` where there was none.
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

/// The line of each point and its neighbours, by sums from the first point on: what lies between
/// two places is the difference of theirs.
fn scan_surfaces(points: &[Point2<f64>]) -> Vec<Option<OrientedPoint>> {
    let count = points.len();
    let limits = gaps(points);
    // All round: the last ones stand before the first, and the first ones behind the last.
    let beside = BESIDE.min(count.saturating_sub(1) / 2);
    let round = points.iter().cycle().skip(count - beside);
    let mut sum = Scatter::default();
    let mut sums = Vec::with_capacity(count + 2 * beside + 1);
    sums.push(sum);
    for point in round.take(count + 2 * beside) {
        sum.add(point.coords);
        sums.push(sum);
    }
    let is_gap = |at: usize| limits.get(at % count).copied().unwrap_or(true);
    // How many neighbours of each point, before it, are on its surface.
    let mut before = (1..=beside)
        .take_while(|back| !is_gap(count - back))
        .count();
    let mut after = (0..beside).take_while(|next| !is_gap(*next)).count();
    let mut surfaces = Vec::with_capacity(count);
    for (index, point) in points.iter().enumerate() {
        let from = sums.get(index + beside - before);
        let to = sums.get(index + beside + after + 1);
        let surface = from.zip(to).and_then(|(from, to)| {
            let surface = on_line(point, &to.minus(from).about(&point.coords))?;
            let is_behind = surface.normal.dot(&point.coords) > 0.0;
            Some(OrientedPoint {
                normal: if is_behind {
                    -surface.normal
                } else {
                    surface.normal
                },
                ..surface
            })
        });
        surfaces.push(surface);
        // For the next one.
        before = if is_gap(index) {
            0
        } else {
            (before + 1).min(beside)
        };
        after = match after {
            0 => (1..=beside)
                .take_while(|next| !is_gap(index + next))
                .count(),
            _ if after < beside => after - 1,
            _ if is_gap(index + beside) => after - 1,
            _ => after,
        };
    }
    surfaces
}

/// Of each point of a scan, whether the step from it to the next one is none along a wall.
fn gaps(points: &[Point2<f64>]) -> Vec<bool> {
    let next = || points.iter().zip(points.iter().cycle().skip(1));
    // The angle between neighbours by its sine: gaps come out too small, and do not matter.
    let mut angles: Vec<f64> = next()
        .map(|(a, b)| {
            let squares = a.coords.norm_squared() * b.coords.norm_squared();
            a.coords.perp(&b.coords).abs() / squares.sqrt()
        })
        .filter(|angle| angle.is_finite())
        .collect();
    let middle = angles.len() / 2;
    let spacing = match angles.is_empty() {
        true => 0.0,
        false => *angles.select_nth_unstable_by(middle, f64::total_cmp).1,
    };
    let shortest = SHORTEST_GAP * SHORTEST_GAP;
    let scale = GAP * GAP * spacing * spacing;
    next()
        .map(|(a, b)| (b - a).norm_squared() > shortest.max(scale * a.coords.norm_squared()))
        .collect()
}

fn nearest_surfaces(points: &[Point2<f64>]) -> Vec<Option<OrientedPoint>> {
    let neighbours = Neighbours::of(points);
    let surface = |point: &Point2<f64>| {
        let mut scatter = Scatter::default();
        for near in neighbours.nearest_few(*point, NEAREST) {
            scatter.add(points.get(near)? - point);
        }
        on_line(point, &scatter)
    };
    points.iter().map(surface).collect()
}

/// The point on the line of its neighbours.
fn on_line(point: &Point2<f64>, scatter: &Scatter) -> Option<OrientedPoint> {
    let normal = scatter.normal()?;
    Some(OrientedPoint {
        position: point + normal * normal.dot(&scatter.mean()),
        normal,
    })
}
