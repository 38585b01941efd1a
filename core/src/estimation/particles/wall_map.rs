//! The walls of a prior map, ready for particles: how far to them, and where all that was seen
//! fits.

use nalgebra::Point2;

use super::MonteCarloConfig;
use super::recent::Ray;
use crate::estimation::EkfError;
use crate::estimation::scan_localisation::{SPACING, check_size, pieces};
use crate::geom::{Pose2, Segment};
use crate::map::{LikelihoodPyramid, WallDistance};
use crate::registration::{Candidate, SearchWindow, modes, search};

/// Cells of the distance, m.
const CELL: f64 = 0.05;
/// Cells in which the whole map is searched, and in which what was found is made finer, m.
const CELLS: [f64; 2] = [0.2, 0.1];
/// Levels of the one, and of the other.
const LEVELS: [usize; 2] = [6, 1];
/// Times that cells are doubled where a map spans more.
const DOUBLINGS: u32 = 4;
/// Points that the whole map is searched with.
const SEARCHED_POINTS: usize = 100;
/// How far a pose found in the first cells may be off, m and rad.
const FINER: SearchWindow = SearchWindow {
    shift: 0.2,
    turn: 0.03,
};

/// Walls.
#[derive(Clone, Debug)]
pub(super) struct WallMap {
    distance: WallDistance,
    pyramids: Option<[LikelihoodPyramid; 2]>,
    /// By steps of the distance: exp(-d²/2σ²), and the logarithm of what a beam says.
    likelihood: Vec<f64>,
    logarithm: Vec<f64>,
}

/// A place where what was seen fits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub(super) pose: Pose2,
    /// Of the beams of the last metres with the map ([`WallMap::agreement`]).
    pub(super) agreement: f64,
    /// Of the search in coarse cells, which any beam passes that is near a wall.
    pub(super) score: f64,
}

/// Where what was seen fits.
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

    /// The rectangle around the walls.
    pub(super) fn extent(&self) -> (Point2<f64>, Point2<f64>) {
        self.distance.extent()
    }

    /// Mean logarithm of what beams say of a pose: log(z exp(-d²/2σ²) + 1 - z).
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
            // A beam that fits nowhere needs no second look.
            if likelihood > 0.01 && !self.distance.is_between(from, to) {
                sum += likelihood;
            }
        }
        sum / f64::max(count, 1.0)
    }

    /// All places of the map where the beams fit.
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
