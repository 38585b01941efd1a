//! The walls of a prior map, prepared for particles: the distance to them, and all places where
//! recent beams fit.

use nalgebra::Point2;

use super::MonteCarloConfig;
use super::recent::Ray;
use crate::estimation::EkfError;
use crate::estimation::scan_localisation::{SPACING, check_size, pieces};
use crate::geom::{Pose2, Segment};
use crate::map::{LikelihoodPyramid, WallDistance};
use crate::registration::{Candidate, SearchWindow, modes, search};

/// Cell size of the distance field, m.
const CELL: f64 = 0.05;
/// Cell sizes for searching the whole map, and for refining what was found, m.
const CELLS: [f64; 2] = [0.2, 0.1];
/// Pyramid levels for these two.
const LEVELS: [usize; 2] = [6, 1];
/// How often the cell size may be doubled if a map is too large.
const DOUBLINGS: u32 = 4;
/// Number of points with which the whole map is searched.
const SEARCHED_POINTS: usize = 100;
/// How far a pose found with the coarse cells may be off, m and rad.
const FINER: SearchWindow = SearchWindow {
    shift: 0.2,
    turn: 0.03,
};

/// Walls.
#[derive(Clone, Debug)]
pub(super) struct WallMap {
    distance: WallDistance,
    pyramids: Option<[LikelihoodPyramid; 2]>,
    /// By steps of the distance: exp(-d²/2σ²), and the log-likelihood of a beam.
    likelihood: Vec<f64>,
    logarithm: Vec<f64>,
}

/// A place that fits what was seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub(super) pose: Pose2,
    /// Agreement of the beams of the last metres with the map ([`WallMap::agreement`]).
    pub(super) agreement: f64,
    /// Score of the search in coarse cells, to which any beam near a wall contributes.
    pub(super) score: f64,
}

/// All places that fit what was seen.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Places {
    /// The places that were found.
    pub(super) found: Vec<Place>,
    /// No other place has a higher score.
    pub(super) left: f64,
}

impl WallMap {
    /// # Errors   [`EkfError::PriorMap`] where the walls are longer or lie farther off than can be
    /// held.
    pub(super) fn new(
        faces: &[Segment],
        map_sigma: f64,
        config: &MonteCarloConfig,
    ) -> Result<Option<Self>, EkfError> {
        check_size(faces)?;
        let Some(distance) = WallDistance::new(faces, CELL) else {
            return Ok(None);
        };
        let pieces = faces.iter().flat_map(|face| pieces(face, SPACING));
        let places: Vec<_> = pieces.map(|piece| piece.position).collect();
        let pyramid = |cell: f64, levels: usize| {
            (0..=DOUBLINGS).find_map(|times| {
                let cell = cell * f64::from(1 << times);
                LikelihoodPyramid::new(places.iter().copied(), cell, cell, levels)
            })
        };
        let pyramids = pyramid(CELLS[0], LEVELS[0]).zip(pyramid(CELLS[1], LEVELS[1]));
        let variance = config.sigma * config.sigma + map_sigma * map_sigma;
        let step = WallDistance::REACH / 255.0;
        let likelihood = (0..=255).map(|steps| {
            let distance = f64::from(steps) * step;
            libm::exp(-0.5 * distance * distance / variance)
        });
        let likelihood: Vec<f64> = likelihood.collect();
        let random = config.random_part;
        let of_beam = |hit: &f64| libm::log((1.0 - random) * hit + random);
        Ok(Some(Self {
            distance,
            pyramids: pyramids.map(|(coarse, fine)| [coarse, fine]),
            logarithm: likelihood.iter().map(of_beam).collect(),
            likelihood,
        }))
    }

    /// The bounding rectangle of the walls.
    pub(super) fn extent(&self) -> (Point2<f64>, Point2<f64>) {
        self.distance.extent()
    }

    /// Mean log-likelihood of the beams at a pose: log(z exp(-d²/2σ²) + 1 - z).
    ///
    /// Source: Thrun, Burgard & Fox (2005), table 6.3 (likelihood field).
    pub(super) fn log_likelihood(&self, pose: &Pose2, rays: &[Ray]) -> f64 {
        let steps = |ray: &Ray| self.distance.step_at(*pose * ray.to);
        let sum: f64 = rays
            .iter()
            .map(|ray| self.logarithm[usize::from(steps(ray))])
            .sum();
        sum / rays.len().max(1) as f64
    }

    /// Mean of exp(-d²/2σ²) over beams, 0 for those that would have passed through a wall.
    pub(super) fn agreement(&self, pose: &Pose2, rays: impl Iterator<Item = Ray>) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for ray in rays {
            count += 1.0;
            let (from, to) = (*pose * ray.from, *pose * ray.to);
            let likelihood = self.likelihood[usize::from(self.distance.step_at(to))];
            // A beam that does not fit needs no further check.
            if likelihood > 0.01 && !self.distance.is_between(from, to) {
                sum += likelihood;
            }
        }
        sum / f64::max(count, 1.0)
    }

    /// All places of the map that the beams fit.
    pub(super) fn places(&self, rays: &[Ray], config: &MonteCarloConfig) -> Places {
        let Some([coarse, fine]) = &self.pyramids else {
            return Places {
                found: vec![],
                left: 1.0,
            };
        };
        let every = rays.len().div_ceil(SEARCHED_POINTS).max(1);
        let points: Vec<_> = rays.iter().step_by(every).map(|ray| ray.to).collect();
        let finer = |found: Candidate| {
            let finer = search(&points, fine, &found.pose, &FINER, 0.0);
            let pose = finer.map_or(found.pose, |finer| finer.pose);
            let agreement = self.agreement(&pose, rays.iter().copied());
            Place {
                pose,
                agreement,
                score: found.score,
            }
        };
        let modes = modes(&points, coarse, &config.modes);
        Places {
            found: modes.found.into_iter().map(finer).collect(),
            left: modes.left,
        }
    }
}
