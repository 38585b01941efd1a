//! `ekf_step`: 300 steps of EKF-SLAM over N point landmarks, ten of them seen in each step, all
//! with known correspondence.
//!
//! The filter's covariance is the core's [`Covariance`]. The model of points is the one of the
//! comparison, so both do the same steps and end in the same place. The core's own filter maps
//! lines and finds its matches by itself: `report -- ekf-cost` measures that.
//!
//! 1. Predict: x by the odometry; P by F and the odometry's noise, rotated into the map frame.
//! 2. Each observation corrects the state by P Hᵀ L⁻ᵀ with Z = L Lᵀ, relinearised each time; the
//!    subtraction from P is deferred.
//! 3. At the end of the step all subtractions are applied in one pass.

use std::f64::consts::PI;

use anyhow::{Context, Result, ensure};
use nalgebra::{Matrix2, Matrix3, Matrix5, SMatrix, Vector2};
use slamlab_core::estimation::{Column, Covariance};
use slamlab_core::geom::{Length, sin_cos, wrap};

use crate::inputs::Inputs;
use crate::timing::{cpu_ms, emit, median};

const SIZES: [usize; 3] = [100, 200, 500];
const REPEATS: usize = 3;
/// σ of the odometry's dx, dy (m) and dθ (rad), as in the inputs.
const ODOMETRY: [f64; 3] = [0.02, 0.01, 0.005];
/// σ of range (m) and bearing (rad).
const SEEN: [f64; 2] = [0.05, 0.5 * PI / 180.0];
/// The core's robot has five states; this one has no states for systematic errors.
const ROBOT: usize = 5;

pub(crate) fn run(inputs: &Inputs) -> Result<()> {
    SIZES.into_iter().try_for_each(|n| measure(inputs, n))
}

fn measure(inputs: &Inputs, n: usize) -> Result<()> {
    let walk = Walk::read(inputs, n)?;
    let mut steps = vec![];
    let mut off = f64::NAN;
    for repeat in 0..=REPEATS {
        let mut slam = PointSlam::new(walk.truth[0]);
        walk.seen[0].iter().for_each(|seen| slam.augment(seen));
        for (step, motion) in walk.motions.iter().enumerate() {
            let begin = cpu_ms();
            slam.advance(motion);
            for seen in &walk.seen[step + 1] {
                ensure!(slam.correct(seen), "step {step}: Z is singular");
            }
            slam.cov.settle();
            if repeat > 0 {
                steps.push(cpu_ms() - begin);
            }
        }
        let end = walk.truth[walk.motions.len()];
        off = Vector2::new(slam.pose[0] - end[0], slam.pose[1] - end[1]).length();
    }
    let extra = format!("pose_err_m={off:.4} ({} steps)", walk.motions.len());
    let (peer, workload) = ("slamlab(point-landmarks)", format!("ekfslam_step_N{n}"));
    emit(peer, &workload, median(&mut steps), &extra);
    Ok(())
}

/// The robot's motion and observations.
struct Walk {
    motions: Vec<[f64; 3]>,
    /// By step; the first shows all landmarks.
    seen: Vec<Vec<Seen>>,
    truth: Vec<[f64; 3]>,
}

/// A landmark by its number, range (m) and bearing (rad).
struct Seen {
    landmark: usize,
    range: f64,
    bearing: f64,
}

impl Walk {
    fn read(inputs: &Inputs, n: usize) -> Result<Self> {
        let motions = inputs.table::<4>(&format!("ekf_{n}_controls.csv"))?;
        let motions = motions.into_iter().map(|[_, x, y, turn]| [x, y, turn]);
        let motions: Vec<_> = motions.collect();
        let truth = inputs.table::<3>(&format!("ekf_{n}_truth.csv"))?;
        let fits = truth.len() == motions.len() + 1;
        ensure!(fits, "truth and controls differ in length");
        let mut seen: Vec<Vec<Seen>> = truth.iter().map(|_| vec![]).collect();
        for [step, landmark, range, bearing] in inputs.table::<4>(&format!("ekf_{n}_obs.csv"))? {
            let at = seen.get_mut(step as usize);
            at.with_context(|| format!("no step {step}"))?.push(Seen {
                landmark: landmark as usize,
                range,
                bearing,
            });
        }
        let in_order = (seen[0].iter().map(|s| s.landmark)).eq(0..n);
        ensure!(in_order, "step 0 does not see all landmarks in order");
        Ok(Self {
            motions,
            seen,
            truth,
        })
    }
}

/// EKF-SLAM with point landmarks.
struct PointSlam {
    pose: [f64; 3],
    landmarks: Vec<[f64; 2]>,
    cov: Covariance,
    gain: [Vec<f64>; 2],
}

impl PointSlam {
    /// A robot with a known pose.
    fn new(pose: [f64; 3]) -> Self {
        Self {
            pose,
            landmarks: vec![],
            cov: Covariance::new(&Matrix5::zeros()),
            gain: Default::default(),
        }
    }

    /// A new landmark, seen from a known pose: it has no correlation with the robot.
    fn augment(&mut self, seen: &Seen) {
        let [x, y, heading] = self.pose;
        let (sin, cos) = sin_cos(heading + seen.bearing);
        self.landmarks
            .push([x + seen.range * cos, y + seen.range * sin]);
        let g = Matrix2::new(cos, -seen.range * sin, sin, seen.range * cos);
        let cov = g * Matrix2::from_diagonal(&Vector2::from(SEEN.map(|s| s * s))) * g.transpose();
        let n = self.cov.n();
        let row = |own: &[f64]| [vec![0.0; n], own.to_vec()].concat();
        self.cov
            .push_pair([row(&[cov[(0, 0)]]), row(&[cov[(1, 0)], cov[(1, 1)]])]);
    }

    /// Step 1.
    fn advance(&mut self, [dx, dy, turn]: &[f64; 3]) {
        let [x, y, heading] = self.pose;
        let (sin, cos) = sin_cos(heading);
        self.pose = [
            x + cos * dx - sin * dy,
            y + sin * dx + cos * dy,
            wrap(heading + turn),
        ];
        let mut f = SMatrix::<f64, 3, 5>::identity();
        (f[(0, 2)], f[(1, 2)]) = (-sin * dx - cos * dy, cos * dx - sin * dy);
        let to_map = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        let noise = Matrix3::from_diagonal(&ODOMETRY.map(|s| s * s).into());
        let noise = to_map * noise * to_map.transpose();
        self.cov.advance(&f, |own| {
            let moved = f * own * f.transpose() + noise;
            let mut own = *own;
            own.fixed_view_mut::<3, 3>(0, 0).copy_from(&moved);
            own
        });
    }

    /// Step 2. Returns whether Z was positive definite.
    fn correct(&mut self, seen: &Seen) -> bool {
        let [lx, ly] = self.landmarks[seen.landmark];
        let (ex, ey) = (lx - self.pose[0], ly - self.pose[1]);
        let squared = ex * ex + ey * ey;
        let range = squared.sqrt();
        let (by_range, by_bearing) = ([ex / range, ey / range], [-ey / squared, ex / squared]);
        let first = ROBOT + 2 * seen.landmark;
        let columns: [Column; 5] = [
            (0, [-by_range[0], -by_bearing[0]]),
            (1, [-by_range[1], -by_bearing[1]]),
            (2, [0.0, -1.0]),
            (first, [by_range[0], by_bearing[0]]),
            (first + 1, [by_range[1], by_bearing[1]]),
        ];
        let expected = libm::atan2(ey, ex) - self.pose[2];
        let v = Vector2::new(seen.range - range, wrap(seen.bearing - expected));
        let [a, b] = &mut self.gain;
        self.cov.product(&columns, a, b);
        let mut z = Matrix2::from_diagonal(&Vector2::from(SEEN.map(|s| s * s)));
        for (state, h) in columns {
            let (a, b) = (a[state], b[state]);
            z += Matrix2::new(h[0] * a, h[0] * b, h[1] * a, h[1] * b);
        }
        let Some(l) = z.cholesky().map(|c| c.unpack()) else {
            return false;
        };
        let (l00, l10, l11) = (l[(0, 0)], l[(1, 0)], l[(1, 1)]);
        let whitened = [v.x / l00, (v.y - l10 * v.x / l00) / l11];
        for (a, b) in a.iter_mut().zip(b.iter_mut()) {
            (*a, *b) = (*a / l00, (*b - l10 * *a / l00) / l11);
        }
        let shift = |a: &f64, b: &f64| a * whitened[0] + b * whitened[1];
        for (state, (a, b)) in self.pose.iter_mut().zip(a.iter().zip(b.iter())) {
            *state += shift(a, b);
        }
        self.pose[2] = wrap(self.pose[2]);
        let coordinates = self.landmarks.as_flattened_mut().iter_mut();
        for (coordinate, (a, b)) in coordinates.zip(a[ROBOT..].iter().zip(&b[ROBOT..])) {
            *coordinate += shift(a, b);
        }
        self.cov.subtract(a, b);
        true
    }
}
