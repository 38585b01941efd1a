//! Coherent point drift: the moving cloud is treated as the centres of a mixture of Gaussians, from
//! which the fixed cloud was drawn.
//!
//! In: two clouds, and the kind of motion between them. Out: where the moving points end up.
//!
//! 1. Both clouds are **normalised**: moved to mean 0 and scaled by one number. σ² begins as the
//!    mean squared distance of all pairs (1.44).
//! 2. **E**: the probability that each fixed point belongs to each moving point, or to the
//!    outliers, which are a part w of all (1.45). Only sums of these are needed (`posterior`).
//! 3. **M**: the motion that minimises the squared distances weighted by these probabilities, and
//!    from it σ² ((1.46)-(1.53)).
//! 4. It ends when σ² is almost zero, when nothing changes for some iterations, or after the last
//!    iteration. If σ² is still wide after a given number of iterations, it has failed.
//! 5. The result is **de-normalised**.
//!
//! Source: Myronenko & Song (2010), "Point set registration: coherent point drift"; numbers as in
//! Pilch (2016).

mod displacement;
mod posterior;
mod rigid;
#[cfg(test)]
mod tests;

use nalgebra::{Matrix2, Point2, Vector2};

use self::posterior::{Posterior, Pulls};
use self::rigid::Sums;
use super::trace::{Correspondence, Iteration, Watch};
use super::{AffineMap, first_too_far};
use crate::bounds::config;
use crate::geom::Pose2;

config! {
    /// How clouds drift.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct CpdConfig {
        /// Part of the fixed points that are outliers, below 1. Default 0.1; larger listens less to
        /// what lies apart.
        pub outliers: f64 = 0.1,
        /// Whether a rigid motion may scale. Default false: scans do not.
        pub scales: bool = false,
        /// Most iterations. Default 100.
        pub max_iterations: usize = 100,
        /// σ² of normalised clouds below which it ends. Default 4e-5.
        pub least_variance: f64 = 4e-5,
        /// It ends after so many iterations in which σ² changes by less than a thousandth. Default
        /// 10.
        pub still_iterations: usize = 10,
        /// It has failed where σ² of normalised clouds is above the second figure after so many
        /// iterations. Default none: in noisy clouds σ² stays wide, and a map that is found late is
        /// found as well.
        pub fails: Option<(usize, f64)> = None,
        /// Error of the sums, in parts of the number of points. Default 1e-6; larger is quicker
        /// where there are many points.
        pub error: f64 = 1e-6,
        /// Of non-rigid motion: how far a point takes its neighbours along, in extents of the
        /// normalised cloud. Default 2; larger bends less.
        pub beta: f64 = 2.0,
        /// Of non-rigid motion: how much smoothness counts beside fit. Default 3; larger bends
        /// less.
        pub lambda: f64 = 3.0,
    }
}

impl CpdConfig {
    /// As in Pilch (2016): what is not found within 30 iterations has failed.
    #[must_use]
    pub fn pilch() -> Self {
        Self {
            fails: Some((30, 1e-4)),
            ..Self::default()
        }
    }
}

/// The kind of motion between two clouds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CpdKind {
    /// A rotation and a shift.
    #[default]
    Rigid,
    /// Any linear map and a shift.
    Affine,
    /// Any smooth motion.
    NonRigid,
}

impl CpdKind {
    /// All kinds, with their names.
    pub const ALL: [(&'static str, Self); 3] = [
        ("rigid", Self::Rigid),
        ("affine", Self::Affine),
        ("non-rigid", Self::NonRigid),
    ];
}

/// How two clouds drifted onto each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Drift {
    /// Where each moving point ended up, in the fixed frame, m.
    pub moved: Vec<Point2<f64>>,
    /// The map that took it there; `None` if the motion is not linear.
    pub map: Option<AffineMap>,
    /// σ of the mixture at the end, m.
    pub sigma: f64,
    /// Iterations taken.
    pub iterations: usize,
    /// Whether it ended because nothing changed any more, and σ² became small enough in time.
    pub is_settled: bool,
}

/// Why two clouds cannot be registered by drift.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CpdError {
    /// Fewer points do not fix a motion of this kind.
    #[error("the {cloud} cloud has {found} points, expected at least {least}")]
    TooFewPoints {
        /// Which of the two.
        cloud: &'static str,
        /// How many there are.
        found: usize,
        /// How many are needed.
        least: usize,
    },
    /// Every moving point of a non-rigid motion is an unknown of a dense system.
    #[error("{found} moving points, expected at most {most} for a non-rigid motion")]
    TooManyPoints {
        /// How many there are.
        found: usize,
        /// How many are allowed.
        most: usize,
    },
    /// A coordinate is not a number.
    #[error("the {cloud} cloud: point {index} is not finite")]
    NotFinite {
        /// Which of the two.
        cloud: &'static str,
        /// The point.
        index: usize,
    },
    /// All points of a cloud lie in one place.
    #[error("all points lie in one place")]
    NoExtent,
}

/// Most moving points of a non-rigid motion: each iteration solves a system with this many
/// unknowns.
pub const MOST_NON_RIGID: usize = 1000;
/// A relative change of σ² below this counts as none.
const STILL: f64 = 1e-3;

/// Lets `moving` drift onto `fixed`.
///
/// # Errors    [`CpdError`]: too few points, too many, or invalid ones.
pub fn drift(
    moving: &[Point2<f64>],
    fixed: &[Point2<f64>],
    kind: CpdKind,
    config: &CpdConfig,
) -> Result<Drift, CpdError> {
    drift_watched(moving, fixed, kind, config, &mut ())
}

/// [`drift`], with a [`Watch`] that sees each iteration.
pub(super) fn drift_watched<W: Watch>(
    moving: &[Point2<f64>],
    fixed: &[Point2<f64>],
    kind: CpdKind,
    config: &CpdConfig,
    watch: &mut W,
) -> Result<Drift, CpdError> {
    check(moving, "moving", kind)?;
    check(fixed, "fixed", kind)?;
    let normal = Normalised::of(moving, fixed)?;
    let (start, x) = (
        normal.take(moving, &normal.moving_mean),
        normal.take(fixed, &normal.fixed_mean),
    );
    let mut y = start.clone();
    let mut variance = mean_square(&y, &x);
    let mut motion = Motion::of(kind, &start, config);
    let mut near = None;
    let (mut still, mut iterations, mut is_settled, mut failed) = (0, 0, false, false);
    while iterations < config.max_iterations {
        iterations += 1;
        let owed = (W::LOOKS || kind == CpdKind::NonRigid)
            .then(|| Posterior::of(&y, &x, variance, config, &mut near));
        if let Some(owed) = &owed {
            watch.see(|| normal.iteration(&y, owed, variance, &motion));
        }
        let before = variance;
        let after = match &mut motion {
            Motion::Linear(linear) => {
                let pulls = Pulls::of(&y, &x, variance, config, &mut near);
                linear.go_on(&Sums::of(&y, &x, &pulls), config)
            }
            Motion::Smooth(smooth) => {
                owed.and_then(|owed| smooth.fit(&start, &x, &owed, variance, config.lambda))
            }
        };
        let Some(after) = after else {
            failed = true;
            break;
        };
        motion.apply(&start, &mut y);
        // A perfect fit has zero width; half of the least variance stands in for it.
        variance = after.max(0.5 * config.least_variance);
        still = if (variance - before).abs() < STILL * before {
            still + 1
        } else {
            0
        };
        if (config.fails).is_some_and(|(after, above)| iterations == after && variance >= above) {
            failed = true;
            break;
        }
        if variance < config.least_variance || still >= config.still_iterations {
            is_settled = true;
            break;
        }
    }
    let moved = y.iter().map(|p| normal.back(p)).collect();
    Ok(Drift {
        moved,
        map: normal.map(&motion),
        sigma: variance.sqrt() * normal.scale,
        iterations,
        is_settled: is_settled && !failed,
    })
}

fn check(points: &[Point2<f64>], cloud: &'static str, kind: CpdKind) -> Result<(), CpdError> {
    let least = match kind {
        CpdKind::Rigid => 2,
        CpdKind::Affine | CpdKind::NonRigid => 3,
    };
    let found = points.len();
    if found < least {
        return Err(CpdError::TooFewPoints {
            cloud,
            found,
            least,
        });
    }
    if kind == CpdKind::NonRigid && cloud == "moving" && found > MOST_NON_RIGID {
        return Err(CpdError::TooManyPoints {
            found,
            most: MOST_NON_RIGID,
        });
    }
    match first_too_far(points) {
        Some(index) => Err(CpdError::NotFinite { cloud, index }),
        None => Ok(()),
    }
}

/// How clouds are moved and scaled so that all numbers are about 1.
struct Normalised {
    moving_mean: Vector2<f64>,
    fixed_mean: Vector2<f64>,
    /// m.
    scale: f64,
}

impl Normalised {
    fn of(moving: &[Point2<f64>], fixed: &[Point2<f64>]) -> Result<Self, CpdError> {
        let mean = |points: &[Point2<f64>]| {
            points.iter().map(|p| p.coords).sum::<Vector2<f64>>() / points.len() as f64
        };
        let (moving_mean, fixed_mean) = (mean(moving), mean(fixed));
        let square = |points: &[Point2<f64>], mean: &Vector2<f64>| {
            let squares = points.iter().map(|p| (p.coords - mean).norm_squared());
            squares.sum::<f64>() / points.len() as f64
        };
        // One scale for both: a rigid motion keeps lengths.
        let scale = square(moving, &moving_mean)
            .max(square(fixed, &fixed_mean))
            .sqrt();
        if scale <= 0.0 {
            return Err(CpdError::NoExtent);
        }
        Ok(Self {
            moving_mean,
            fixed_mean,
            scale,
        })
    }

    fn take(&self, points: &[Point2<f64>], mean: &Vector2<f64>) -> Vec<Point2<f64>> {
        let moved = |p: &Point2<f64>| Point2::from((p.coords - mean) / self.scale);
        points.iter().map(moved).collect()
    }

    /// The motion between the original clouds, if it is linear.
    fn map(&self, motion: &Motion) -> Option<AffineMap> {
        motion.linear().map(|(linear, shift)| {
            let to = self.fixed_mean + shift * self.scale;
            AffineMap {
                linear,
                shift: to - linear * self.moving_mean,
            }
        })
    }

    /// Each point, and the mean of the fixed points that belong to it.
    fn iteration(
        &self,
        y: &[Point2<f64>],
        owed: &Posterior,
        variance: f64,
        motion: &Motion,
    ) -> Iteration {
        let pairs = y.iter().zip(&owed.of_moving).filter(|(_, o)| o.part > 0.0);
        let pairs = pairs.map(|(y, owed)| Correspondence {
            from: self.back(y),
            to: self.back(&Point2::from(owed.place / owed.part)),
            weight: owed.part,
        });
        let pose = self
            .map(motion)
            .map_or_else(Pose2::identity, |map| map.rigid());
        Iteration::of(pose, variance.sqrt() * self.scale, pairs)
    }

    /// A point of the fixed frame, in original coordinates.
    fn back(&self, point: &Point2<f64>) -> Point2<f64> {
        Point2::from(point.coords * self.scale + self.fixed_mean)
    }
}

/// (1.44): the mean squared distance of all pairs, per direction.
fn mean_square(y: &[Point2<f64>], x: &[Point2<f64>]) -> f64 {
    let moments = |points: &[Point2<f64>]| {
        let count = points.len() as f64;
        let sum: Vector2<f64> = points.iter().map(|p| p.coords).sum();
        let squares: f64 = points.iter().map(|p| p.coords.norm_squared()).sum();
        (sum / count, squares / count)
    };
    let ((x_mean, x_square), (y_mean, y_square)) = (moments(x), moments(y));
    0.5 * (x_square + y_square - 2.0 * x_mean.dot(&y_mean))
}

/// Below this sum of probabilities, no point belongs to any other.
const NOTHING_OWED: f64 = 1e-9;

/// The motion so far.
enum Motion {
    Linear(Linear),
    /// y + G w.
    Smooth(displacement::Smooth),
}

/// x = B y + t; rigid where the flag says so.
struct Linear {
    linear: Matrix2<f64>,
    shift: Vector2<f64>,
    is_rigid: bool,
}

impl Linear {
    /// The M step. `sums` are of the points as moved by this motion, and one more linear motion is
    /// composed onto it. Returns the new σ².
    fn go_on(&mut self, sums: &Sums, config: &CpdConfig) -> Option<f64> {
        if sums.total < NOTHING_OWED {
            return None;
        }
        let (by, shift, after) = match self.is_rigid {
            true => sums.rigid(config.scales)?,
            false => sums.affine()?,
        };
        (self.linear, self.shift) = (by * self.linear, by * self.shift + shift);
        Some(after)
    }
}

impl Motion {
    fn of(kind: CpdKind, start: &[Point2<f64>], config: &CpdConfig) -> Self {
        match kind {
            CpdKind::Rigid | CpdKind::Affine => Self::Linear(Linear {
                linear: Matrix2::identity(),
                shift: Vector2::zeros(),
                is_rigid: kind == CpdKind::Rigid,
            }),
            CpdKind::NonRigid => Self::Smooth(displacement::Smooth::of(start, config.beta)),
        }
    }

    fn apply(&self, start: &[Point2<f64>], y: &mut [Point2<f64>]) {
        match self {
            Self::Linear(Linear { linear, shift, .. }) => {
                for (y, start) in y.iter_mut().zip(start) {
                    *y = Point2::from(linear * start.coords + shift);
                }
            }
            Self::Smooth(smooth) => smooth.apply(start, y),
        }
    }

    fn linear(&self) -> Option<(Matrix2<f64>, Vector2<f64>)> {
        match self {
            Self::Linear(motion) => Some((motion.linear, motion.shift)),
            Self::Smooth(_) => None,
        }
    }
}
