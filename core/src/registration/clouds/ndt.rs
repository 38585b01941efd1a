//! The fixed cloud as normal distributions, one in each cell, and the pose at which the moving
//! points are the likeliest.
//!
//! 1. The plane is cut into cells four times, each time shifted by half a cell, so cell borders do
//!    not matter. Each cell with enough points has their mean and covariance.
//! 2. A point's likelihood is the sum of exp(-½ dᵀ C⁻¹ d) over its four cells. Gauss-Newton steps
//!    maximise it, in which each cell is weighted by its likelihood.
//! 3. The cell size is halved from wide cells, which attract from afar, to narrow ones.
//!
//! Source: Biber & Straßer (2003), "The normal distributions transform".

use std::collections::BTreeMap;

use nalgebra::{Matrix2, Point2, SymmetricEigen, Vector2, Vector3};

use super::super::gauss_newton::{Sums, free_direction};
use super::super::trace::{Correspondence, Iteration, Watch};
use super::{Cloud, Found};
use crate::bounds::config;
use crate::geom::{Length, Pose2};

config! {
    /// How the normal distributions are laid out.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct NdtConfig {
        /// Side of the widest cells, m. Default 2; larger pulls in worse starts.
        pub first_cell: f64 = 2.0,
        /// Side of the narrowest cells, m. Default 0.5; larger smooths noise and corners.
        pub last_cell: f64 = 0.5,
        /// Fewest points of a cell. Default 3.
        pub min_points: usize = 3,
        /// Least variance of a cell in parts of its greatest. Default 0.001: walls are no thinner,
        /// or no point would lie on them.
        pub min_flatness: f64 = 0.001,
        /// Least standard deviation of a cell, m. Default 0.03.
        pub min_sigma: f64 = 0.03,
        /// Most steps with cells of one side. Default 30.
        pub max_iterations: usize = 30,
        /// A step smaller than this is nothing, m. Default 2e-4.
        pub shift_tolerance: f64 = 2e-4,
        /// A step smaller than this is nothing, rad. Default 1e-4.
        pub turn_tolerance: f64 = 1e-4,
        /// A direction of which the cells say less than this part is left as it is. Default 0.02.
        pub min_share: f64 = 0.02,
    }
}

/// One cell.
struct Normal {
    mean: Vector2<f64>,
    information: Matrix2<f64>,
}

/// Cells of one side, in four layers.
struct Layers {
    side: f64,
    cells: BTreeMap<(u8, i64, i64), Normal>,
}

/// Runs the normal distributions transform from `start`.
pub(super) fn run(
    moving: &Cloud,
    fixed: &Cloud,
    start: &Pose2,
    config: &NdtConfig,
    watch: &mut impl Watch,
) -> Found {
    let mut found = Found::start(start);
    let mut side = config.first_cell.max(config.last_cell);
    loop {
        let layers = Layers::of(fixed.points(), side, config);
        found.is_settled = false;
        for _ in 0..config.max_iterations {
            found.iterations += 1;
            watch.see(|| layers.iteration(moving.points(), &found.pose));
            let Some(step) = layers.step(moving.points(), &found.pose, config) else {
                return found;
            };
            found.pose = found.pose.plus(&step);
            if step.xy().length() < config.shift_tolerance && step.z.abs() < config.turn_tolerance {
                found.is_settled = true;
                break;
            }
        }
        if side <= config.last_cell {
            return found;
        }
        side = (0.5 * side).max(config.last_cell);
    }
}

impl Layers {
    fn of(points: &[Point2<f64>], side: f64, config: &NdtConfig) -> Self {
        let mut sums: BTreeMap<_, (f64, Vector2<f64>, Matrix2<f64>)> = BTreeMap::new();
        for point in points {
            for place in places(point, side) {
                let sum = sums.entry(place).or_default();
                sum.0 += 1.0;
                sum.1 += point.coords;
                sum.2 += point.coords * point.coords.transpose();
            }
        }
        let normal = |(count, sum, squares): (f64, Vector2<f64>, Matrix2<f64>)| {
            if count < config.min_points as f64 {
                return None;
            }
            let mean = sum / count;
            let cov = squares / count - mean * mean.transpose();
            let eigen = SymmetricEigen::new(cov);
            let least = (config.min_flatness * eigen.eigenvalues.max())
                .max(config.min_sigma * config.min_sigma);
            let inverse = eigen.eigenvalues.map(|variance| 1.0 / variance.max(least));
            let axes = eigen.eigenvectors;
            Some(Normal {
                mean,
                information: axes * Matrix2::from_diagonal(&inverse) * axes.transpose(),
            })
        };
        let cells = sums
            .into_iter()
            .filter_map(|(place, sum)| Some((place, normal(sum)?)));
        Self {
            side,
            cells: cells.collect(),
        }
    }

    /// Each point with the mean of the cell in which it is most likely.
    fn iteration(&self, points: &[Point2<f64>], pose: &Pose2) -> Iteration {
        let likeliest = |point: &Point2<f64>| {
            let from = *pose * *point;
            let cells = places(&from, self.side);
            let pairs = cells.iter().filter_map(|place| {
                let cell = self.cells.get(place)?;
                Some(Correspondence {
                    from,
                    to: Point2::from(cell.mean),
                    weight: cell.off(&from).1,
                })
            });
            pairs.max_by(|a, b| a.weight.total_cmp(&b.weight))
        };
        Iteration::of(*pose, self.side, points.iter().filter_map(likeliest))
    }

    fn step(
        &self,
        points: &[Point2<f64>],
        pose: &Pose2,
        config: &NdtConfig,
    ) -> Option<Vector3<f64>> {
        let mut sums = Sums::default();
        for point in points {
            let arm = pose.rotate(point.coords);
            let place = pose.position() + arm;
            for cell in places(&place, self.side) {
                let Some(cell) = self.cells.get(&cell) else {
                    continue;
                };
                let (off, weight) = cell.off(&place);
                sums.add_off(&cell.information, &arm, &off, weight);
                sums.matched += 1;
            }
        }
        if sums.matched < config.min_points {
            return None;
        }
        let free = free_direction(&sums.hessian, config.min_share);
        sums.step(free.as_ref())
    }
}

impl Normal {
    /// The offset from the mean to a place, and its likelihood relative to that at the mean.
    fn off(&self, place: &Point2<f64>) -> (Vector2<f64>, f64) {
        let off = place.coords - self.mean;
        let weight = libm::exp(-0.5 * off.dot(&(self.information * off)));
        (off, weight)
    }
}

/// The cells of the four layers that a place lies in.
fn places(point: &Point2<f64>, side: f64) -> [(u8, i64, i64); 4] {
    let along = |x: f64, is_moved: bool| {
        let by = if is_moved { 0.5 } else { 0.0 };
        (x / side + by).floor() as i64
    };
    [0, 1, 2, 3].map(|layer: u8| {
        let (x, y) = (layer & 1 == 1, layer & 2 == 2);
        (layer, along(point.x, x), along(point.y, y))
    })
}
