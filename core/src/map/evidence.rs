//! In: the points of one scan, and how uncertain the direction of each beam is. Out: the certain
//! evidence for the grid: straight lines that are free, and points on surfaces.
//!
//! A beam that meets a wall at a flat angle runs along it for metres. Half a degree off, it ends
//! behind the wall, and a grid that takes beams as they are clears the wall away bit by bit: in a
//! corridor, most of both walls when seen from afar.
//!
//! 1. A beam without a return is believed to be free for a few metres only
//!    ([`EvidenceConfig::believed`]): glass, black walls and walls at a flat angle return nothing
//!    either.
//! 2. A point on a surface lies on the line of its neighbours ([`on_surfaces`]): otherwise far
//!    walls, whose ranges scatter by more than a cell, would become thick.
//! 3. A beam is not a line but as wide as its direction is uncertain, `sigmas` standard deviations
//!    to either side. It is certainly free up to the nearest surface in that width, not up to its
//!    own end.
//! 4. Cells have a size too: a wall's line crosses its cells anywhere, so a beam within a cell of
//!    the wall may cross the wall's own cells. The width grows by `margin_cells`.
//! 5. Between two beams the surface is taken as straight: 1/ρ is linear in the bearing, to first
//!    order, as on a line ρ cos(φ - α) = r.
//! 6. The end is a point on a surface if moving it within its width (step 3, without the width of
//!    step 4) moves it across the surface by less than [`BLUR_CELLS`]. With the distance d along
//!    the beam and the distance l across it, that is d l / √(d² + l²).
//!
//! Sonars hear the nearest thing in a cone: for them the whole cone up to it is free
//! ([`EvidenceConfig::cone`]).
//!
//! Thrun, Burgard & Fox (2005), "Probabilistic Robotics", §9.2 give beams a width for the same
//! reason; there it is the width of the sensor's cone.

#[cfg(test)]
mod tests;

use nalgebra::{Point2, Vector2};

use crate::bounds::config;
use crate::geom::Length;
use crate::points::{Beam, Points, WIDEST_GAP, on_surfaces};

/// How many cells a surface may be off at [`EvidenceConfig::sigmas`] standard deviations.
const BLUR_CELLS: f64 = 1.0;

config! {
    /// How sure a scan has to be of what it draws.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct EvidenceConfig {
        /// How many standard deviations of its direction a beam is wide, to either side. Default 2;
        /// growing: cleaner walls, less known from afar.
        pub sigmas: f64 = 2.0,
        /// By how many cells a beam is wider than that. Default 1: no beam clears the cells of a
        /// wall that it does not cross.
        pub margin_cells: f64 = 1.0,
        /// How far a beam without a return is believed to be free, m. Default 5. Growing: more is
        /// known to be free, and more walls are cleared that return nothing.
        pub no_return_clears: f64 = 5.0,
        /// Half the opening of the cones that the readings are of, rad. Default 0: beams. More than
        /// 0: nothing stands nearer in all of a cone than its reading, and the figures above do not
        /// matter.
        pub cone: f64 = 0.0,
    }
}

impl EvidenceConfig {
    /// For sonars whose cones have this half angle, rad.
    #[must_use]
    pub fn cones(half_angle: f64) -> Self {
        Self {
            cone: half_angle,
            ..Self::default()
        }
    }

    /// For a sensor that scans on command and sees each cell a few times at most: every beam counts
    /// up to its end.
    #[must_use]
    pub fn short_range() -> Self {
        Self {
            sigmas: 0.0,
            margin_cells: 0.0,
            ..Self::default()
        }
    }
}

impl EvidenceConfig {
    /// The beams as far as they are believed: those without a return only for a few metres.
    #[must_use]
    pub fn believed(&self, points: &Points) -> Points {
        let beams = points.beams.iter();
        Points {
            beams: beams.map(|beam| self.believed_beam(beam)).collect(),
            ..points.clone()
        }
    }

    fn believed_beam(&self, beam: &Beam) -> Beam {
        let part = (self.no_return_clears / beam.range).min(1.0);
        if beam.is_hit || part >= 1.0 {
            return *beam;
        }
        let way = (beam.end_in_robot - beam.origin_in_robot) * part;
        Beam {
            end_in_robot: beam.origin_in_robot + way,
            range: beam.range * part,
            ..*beam
        }
    }
}

/// The certain evidence of one scan, robot frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evidence {
    /// Straight lines that are free, from the sensor on.
    pub free: Vec<[Point2<f64>; 2]>,
    /// Points on surfaces.
    pub hits: Vec<Point2<f64>>,
}

impl Evidence {
    /// Believes every beam to its end.
    #[must_use]
    pub fn of(points: &Points) -> Self {
        let way = |beam: &Beam| [beam.origin_in_robot, beam.end_in_robot];
        Self {
            free: points.beams.iter().map(way).collect(),
            hits: points.hits().map(|beam| beam.end_in_robot).collect(),
        }
    }

    /// Believes each beam as far as its direction is certain.
    ///
    /// # Units    `bearing_sigmas`: standard deviation of each beam's direction, rad, in the order
    /// of `points.beams`; `resolution`: side of a cell, m.
    #[must_use]
    pub fn certain(
        points: &Points,
        bearing_sigmas: &[f64],
        resolution: f64,
        config: &EvidenceConfig,
    ) -> Self {
        let points = &config.believed(points);
        if config.cone > 0.0 {
            return Self::of_cones(points, resolution, config.cone);
        }
        let surfaces = on_surfaces(points);
        let mut evidence = Self {
            free: Vec::with_capacity(points.beams.len()),
            hits: Vec::with_capacity(points.beams.len()),
        };
        for (index, (beam, sigma)) in points.beams.iter().zip(bearing_sigmas).enumerate() {
            let unsure = config.sigmas * sigma;
            let margin = config.margin_cells * resolution / beam.range;
            let widths = [unsure, unsure + margin];
            let [nearest, free] = nearest_within(&points.beams, index, widths);
            let way = beam.end_in_robot - beam.origin_in_robot;
            let end = beam.origin_in_robot + way * (free / beam.range).min(1.0);
            evidence.free.push([beam.origin_in_robot, end]);
            if beam.is_hit {
                let along = beam.range - nearest;
                let across = beam.range * unsure;
                let blur =
                    along * across / Vector2::new(along, across).length().max(f64::MIN_POSITIVE);
                if blur <= BLUR_CELLS * resolution {
                    evidence.hits.push(surfaces.beams[index].end_in_robot);
                }
            }
        }
        evidence
    }

    /// Cones are free up to the nearest thing in them, which was heard. Where on the arc it stands
    /// is unknown, and the axis is the best guess. The last cell before the arc is not changed.
    ///
    /// Source: Thrun, Burgard & Fox (2005), §9.2, the inverse model of a sonar.
    fn of_cones(points: &Points, resolution: f64, half_angle: f64) -> Self {
        let mut evidence = Self::default();
        // If no free space is believed for beams without a return, there is no cone.
        for beam in points.beams.iter().filter(|beam| beam.range > 0.0) {
            let reach = (beam.range - resolution).max(0.0);
            let way = beam.end_in_robot - beam.origin_in_robot;
            // Rays so dense that no cell of the arc lies between two of them.
            let rays = (half_angle * beam.range / resolution).ceil() as i32;
            for ray in -rays..=rays {
                let angle = half_angle * f64::from(ray) / f64::from(rays.max(1));
                let (sin, cos) = crate::geom::sin_cos(angle);
                let turned = Vector2::new(cos * way.x - sin * way.y, sin * way.x + cos * way.y);
                let end = beam.origin_in_robot + turned * (reach / beam.range);
                evidence.free.push([beam.origin_in_robot, end]);
            }
            if beam.is_hit {
                evidence.hits.push(beam.end_in_robot);
            }
        }
        evidence
    }
}

/// The least range of all beams, and of the surface between them, within each of two `widths` on
/// either side of a beam, rad; the narrower one first.
fn nearest_within(beams: &[Beam], index: usize, widths: [f64; 2]) -> [f64; 2] {
    let Some(beam) = beams.get(index) else {
        return [0.0; 2];
    };
    let (before, from_here) = beams.split_at(index);
    let after = from_here.get(1..).unwrap_or_default();
    let ahead = after.iter().chain(before);
    let behind = before.iter().rev().chain(after.iter().rev());
    let ahead = nearest_on_one_side(beam, ahead, widths);
    let behind = nearest_on_one_side(beam, behind, widths);
    std::array::from_fn(|width| ahead[width].min(behind[width]))
}

fn nearest_on_one_side<'a>(
    beam: &Beam,
    neighbours: impl Iterator<Item = &'a Beam>,
    widths: [f64; 2],
) -> [f64; 2] {
    let mut nearest = [None; 2];
    let mut least = beam.range;
    let mut last = (0.0, beam.range);
    for neighbour in neighbours {
        let angle = angle_between(beam, neighbour);
        // Bearings increase; where they jump back, or beams are far apart, there is no surface
        // between.
        if angle <= last.0 || angle - last.0 > WIDEST_GAP {
            break;
        }
        for (nearest, width) in nearest.iter_mut().zip(widths) {
            if nearest.is_none() && angle >= width {
                let part = (width - last.0) / (angle - last.0);
                let between = (1.0 - part) / last.1 + part / neighbour.range;
                *nearest = Some(least.min(1.0 / between));
            }
        }
        if nearest[1].is_some() {
            break;
        }
        least = least.min(neighbour.range);
        last = (angle, neighbour.range);
    }
    nearest.map(|nearest| nearest.unwrap_or(least))
}

fn angle_between(a: &Beam, b: &Beam) -> f64 {
    let (a, b) = (
        a.end_in_robot - a.origin_in_robot,
        b.end_in_robot - b.origin_in_robot,
    );
    libm::atan2(a.perp(&b).abs(), a.dot(&b))
}
