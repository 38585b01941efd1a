//! Histogram localisation: the probability of every pose of a small map, by brute force.
//!
//! In: odometry, scans and the walls of a prior map, as for particles. Out: the whole posterior
//! over cells of (x, y, θ). It is exact up to its cell size, draws no random numbers and forgets
//! nothing, and its cost grows with the map: good for a room, too much for a building.
//!
//! 1. **Predict**: the mass of each cell moves to where the odometry takes its centre, spread over
//!    the eight cells around that place (linear interpolation), once for each point of a small grid
//!    over the odometry's own uncertainty.
//! 2. **Correct**: each cell is multiplied by the likelihood of the scan at its centre.
//!
//! Source: Thrun, Burgard & Fox (2005), "Probabilistic Robotics", table 8.1 (grid localisation).

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Point2, Vector3};

use super::hypothesis::{Hypothesis, hypotheses};
use super::recent::{Ray, rays};
use super::wall_map::WallMap;
use super::{MonteCarloConfig, Particle};
use crate::bounds::config;
use crate::estimation::EkfError;
use crate::geom::{Length, Pose2, PoseEstimate, Segment, pose_cov, wrap};
use crate::points::Points;
use crate::robot::Odometry;

config! {
    /// How finely poses are told apart.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct HistogramConfig {
        /// Side of a cell, m. Default 0.1; smaller: finer, and slower with the square.
        pub cell: f64 = 0.1,
        /// Cells of the heading in a whole turn. Default 72, of 5° each.
        pub turns: usize = 72,
        /// Most cells of all. Default one million: 14000 places, a room of 12 x 12 m. Larger: a
        /// scan takes seconds while nothing is known.
        pub most: usize = 1_000_000,
        /// A scan is taken in after this way, m, or turn, rad: each move blurs what is known by a
        /// part of a cell. Default 0.1 and 0.0873, a cell.
        pub after: [f64; 2] = [0.1, 0.0873],
    }
}

/// A cell with less mass than this is ignored and not moved.
const NOTHING: f64 = 1e-12;
/// Nodes for the odometry's uncertainty, in standard deviations, with their weights: three-point
/// Gauss-Hermite quadrature, exact to the fifth moment.
const SPREAD: [(f64, f64); 3] = [
    (-1.732_050_807_568_877_2, 1.0 / 6.0),
    (0.0, 2.0 / 3.0),
    (1.732_050_807_568_877_2, 1.0 / 6.0),
];

/// The probability of every pose.
#[derive(Clone, Debug)]
pub struct HistogramLocaliser {
    config: MonteCarloConfig,
    cells: HistogramConfig,
    is_begun: bool,
    map: WallMap,
    low: Point2<f64>,
    cell: f64,
    cols: usize,
    rows: usize,
    turns: usize,
    /// Heading by heading, row by row; the sum is 1.
    mass: Vec<f64>,
    moved: PoseEstimate,
}

impl HistogramLocaliser {
    /// In a map of walls with standard deviation `map_sigma`, m; at first every pose in the
    /// rectangle around them is equally probable.
    ///
    /// # Errors   [`EkfError::PriorMap`] where the walls cannot be held, and
    /// [`EkfError::TooManyPoses`] where there are none, or they span more cells than may be.
    pub fn new(
        faces: &[Segment],
        map_sigma: f64,
        config: MonteCarloConfig,
        cells: HistogramConfig,
    ) -> Result<Self, EkfError> {
        let too_large = |poses: f64| EkfError::TooManyPoses {
            poses,
            most: cells.most as f64,
        };
        let map = WallMap::new(faces, map_sigma, &config)?;
        let corners = faces.iter().flat_map(|face| [face.a, face.b]);
        let bounds = crate::geom::bounds(corners);
        let ((low, high), map) = bounds.zip(map).ok_or_else(|| too_large(0.0))?;
        let [cols, rows] = [high.x - low.x, high.y - low.y].map(|m| (m / cells.cell).ceil() + 1.0);
        let count = cols * rows * cells.turns as f64;
        // NaN counts as too large as well.
        if !(count > 0.0 && count <= cells.most as f64) {
            return Err(too_large(count));
        }
        let (cols, rows) = (cols as usize, rows as usize);
        let count = cols * rows * cells.turns;
        Ok(Self {
            config,
            cells,
            is_begun: false,
            map,
            low,
            cell: cells.cell,
            cols,
            rows,
            turns: cells.turns,
            mass: vec![1.0 / count as f64; count],
            moved: PoseEstimate::exact(Pose2::identity()),
        })
    }

    /// Resets to equal probability of every pose.
    pub fn forget(&mut self) {
        let count = self.mass.len();
        self.mass.fill(1.0 / count as f64);
        self.is_begun = false;
    }

    /// Starts from a Gaussian instead.
    pub fn begin_at(&mut self, start: &PoseEstimate) {
        let Some(information) = start.cov.try_inverse() else {
            return;
        };
        for index in 0..self.mass.len() {
            let mut off = self.pose(index).minus(&start.pose);
            off.z = wrap(off.z);
            self.mass[index] = libm::exp(-0.5 * off.dot(&(information * off)));
        }
        self.normalise();
    }

    /// Step 1, postponed until there is a scan: takes the motion since the last call.
    pub fn predict(&mut self, odometry: &Odometry) {
        self.moved = odometry.after(&self.moved);
    }

    /// Steps 1 and 2: takes a scan, in the current robot frame. Returns whether the scan was used:
    /// it is not if the robot has hardly moved since the last one.
    pub fn update(&mut self, points: &Points) -> bool {
        let [way, turn] = self.cells.after;
        let moved = &self.moved.pose;
        let has_moved = moved.position().coords.length() >= way || moved.heading().abs() >= turn;
        if self.is_begun && !has_moved {
            return false;
        }
        self.is_begun = true;
        self.shift();
        let rays = rays(points, self.config.most_beams);
        if rays.len() >= self.config.fewest_beams {
            self.correct(&rays);
        }
        true
    }

    /// How well a scan agrees with the map at a pose, 0 to 1; `None` if it has too few
    /// beams.
    #[must_use]
    pub fn agreement(&self, pose: &Pose2, points: &Points) -> Option<f64> {
        let rays = rays(points, self.config.most_beams);
        let says = rays.len() >= self.config.fewest_beams;
        says.then(|| self.map.agreement(pose, rays.into_iter()))
    }

    /// Where the robot may be, the likeliest first: cells that touch are one hypothesis. None while
    /// more cells than [`Self::SHOWN`] are likely.
    #[must_use]
    pub fn hypotheses(&self) -> Vec<Hypothesis> {
        let mut found = hypotheses(&self.likely(), &self.config.kld);
        for hypothesis in &mut found {
            hypothesis.estimate.cov += self.within_a_cell();
        }
        found
    }

    /// The uncertainty of a pose within its cell: it may lie anywhere in it.
    fn within_a_cell(&self) -> Matrix3<f64> {
        let sides = Vector3::new(self.cell, self.cell, TAU / self.turns as f64);
        Matrix3::from_diagonal(&sides.map(|side| side * side / 12.0))
    }

    /// The cells that have at least a hundredth of the probability of the likeliest, with their
    /// probabilities; none while these are more than [`Self::SHOWN`].
    #[must_use]
    pub fn likely(&self) -> Vec<Particle> {
        let least = 0.01 * self.mass.iter().copied().fold(0.0, f64::max);
        let likely = self.weighted().filter(|cell| cell.weight >= least);
        let likely: Vec<Particle> = likely.take(Self::SHOWN + 1).collect();
        match likely.len() > Self::SHOWN {
            true => vec![],
            false => likely,
        }
    }

    /// The most cells that are shown.
    pub const SHOWN: usize = 20_000;

    /// Mean and covariance of all poses, about the most probable one.
    #[must_use]
    pub fn estimate(&self) -> PoseEstimate {
        let all: Vec<Particle> = self.weighted().collect();
        let found = super::hypothesis::moments(&all);
        found.map_or_else(
            || PoseEstimate {
                pose: Pose2::identity(),
                cov: pose_cov(1e3, TAU),
            },
            |found| PoseEstimate {
                cov: found.estimate.cov + self.within_a_cell(),
                ..found.estimate
            },
        )
    }

    /// Poses with their probabilities, without those of negligible probability.
    pub fn weighted(&self) -> impl Iterator<Item = Particle> + '_ {
        let some = self.mass.iter().enumerate();
        let some = some.filter(|(_, mass)| **mass > NOTHING);
        some.map(|(index, &weight)| Particle {
            pose: self.pose(index),
            weight,
        })
    }

    fn pose(&self, index: usize) -> Pose2 {
        let (turn, at) = (
            index / (self.cols * self.rows),
            index % (self.cols * self.rows),
        );
        let (row, col) = (at / self.cols, at % self.cols);
        Pose2::new(
            self.low.x + col as f64 * self.cell,
            self.low.y + row as f64 * self.cell,
            wrap(TAU * turn as f64 / self.turns as f64),
        )
    }

    fn shift(&mut self) {
        let moved = std::mem::replace(&mut self.moved, PoseEstimate::exact(Pose2::identity()));
        if moved.pose == Pose2::identity() && moved.cov == Matrix3::zeros() {
            return;
        }
        let eigen = moved.cov.symmetric_eigen();
        let sigmas = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
        let mut motions = vec![];
        for (a, weight_a) in SPREAD {
            for (b, weight_b) in SPREAD {
                for (c, weight_c) in SPREAD {
                    let along = Vector3::new(a, b, c).component_mul(&sigmas);
                    let motion = moved.pose.plus(&(eigen.eigenvectors * along));
                    motions.push((motion, weight_a * weight_b * weight_c));
                }
            }
        }
        let before = std::mem::replace(
            &mut self.mass,
            vec![0.0; self.cols * self.rows * self.turns],
        );
        for (index, mass) in before.into_iter().enumerate().filter(|(_, m)| *m > NOTHING) {
            let pose = self.pose(index);
            for (motion, weight) in &motions {
                self.add(&(pose * *motion), mass * weight);
            }
        }
        self.normalise();
    }

    /// Spreads mass over the cells around a pose; mass that leaves the map is lost.
    fn add(&mut self, pose: &Pose2, mass: f64) {
        let x = (pose.x() - self.low.x) / self.cell;
        let y = (pose.y() - self.low.y) / self.cell;
        let turn = pose.heading() / TAU * self.turns as f64;
        let parts = |at: f64| {
            [
                (at.floor(), 1.0 - (at - at.floor())),
                (at.floor() + 1.0, at - at.floor()),
            ]
        };
        for (turn, of_turn) in parts(turn) {
            let turn = (turn as i64).rem_euclid(self.turns as i64) as usize;
            for (row, of_row) in parts(y) {
                for (col, of_col) in parts(x) {
                    let is_inside = row >= 0.0
                        && col >= 0.0
                        && row < self.rows as f64
                        && col < self.cols as f64;
                    if is_inside {
                        let at = (turn * self.rows + row as usize) * self.cols + col as usize;
                        self.mass[at] += mass * of_turn * of_row * of_col;
                    }
                }
            }
        }
    }

    fn correct(&mut self, rays: &[Ray]) {
        let power = self.config.independent_beams.min(rays.len() as f64);
        for index in 0..self.mass.len() {
            if self.mass[index] > NOTHING {
                let pose = self.pose(index);
                self.mass[index] *= libm::exp(power * self.map.log_likelihood(&pose, rays));
            }
        }
        self.normalise();
    }

    fn normalise(&mut self) {
        let sum: f64 = self.mass.iter().sum();
        if sum > 0.0 {
            self.mass.iter_mut().for_each(|mass| *mass /= sum);
        }
    }
}
