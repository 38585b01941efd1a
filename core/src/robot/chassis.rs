//! From a list of wheels to the motion they allow, and back.
//!
//! In: wheels, each by its place, its orientation and its radius. Out: wheel speeds to body twist, body twist to wheel
//! speeds, rank and mobility, and which wheel contradicts the others by how much. Moving a wheel is a change of a
//! number, not of a formula.
//!
//! 1. Each wheel that must not slip gives a row of J1, `rolling · ξ = r φ'`, and each that cannot move sideways a row of
//!    C1, `sliding · ξ = 0`. Both are speeds at the wheel in m/s, so they weigh alike.
//! 2. Stacked they are solved for the twist ξ = (vx, vy, ω) by least squares, which says the rank too: QR with column
//!    pivots. (nalgebra 0.35's SVD is wrong where two singular values nearly agree: of 100 000 differential drives that
//!    differ in width alone, 5 364 do not multiply back to their own matrix, by up to 0.36.)
//! 3. Where there are more rows than unknowns, each row is held against what all others say: the residual over
//!    1 - leverage is the difference to the solution without that row. A residual alone would not do: least squares
//!    spreads one wheel's error over all wheels.
//!
//! Source: TDK 2016 §2.1, eqs. (2.3) to (2.5), with the erratum of the specification (a second wheel with β = 0 turns the
//! other way round; it needs β = π); Siegwart & Nourbakhsh (2004), §3.2 and §3.3, for casters, Swedish wheels and mobility.

mod rows;
#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::RobotModel;

/// Pivots below this part of the largest one count as zero.
const RANK_TOLERANCE: f64 = 1e-9;
/// Below this a row is alone with what it says, and nothing can contradict it.
const LEAST_REDUNDANCY: f64 = 1e-9;

/// A wheel, and where it stands in the robot frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wheel {
    /// Distance l of the wheel (of a caster: of its joint) from the robot's origin, m.
    pub distance: f64,
    /// Direction α in which the wheel is seen from there, rad.
    pub bearing: f64,
    /// Angle β from that direction to the wheel's axle, rad: 0 and π are the two ways to stand across it. Of a steered
    /// wheel or a caster: as it stands now.
    pub orientation: f64,
    /// Radius r, m.
    pub radius: f64,
    /// What kind it is.
    pub kind: WheelKind,
}

/// What a wheel lets the body do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WheelKind {
    /// Fixed to the body: rolls, does not slide. A track is one such wheel.
    Fixed,
    /// The same, steered by a motor to its orientation.
    Steered,
    /// Turns by itself about a joint: follows any motion.
    Caster {
        /// Distance d from the joint to the wheel, m.
        offset: f64,
    },
    /// Swedish (mecanum) wheel: rollers around its rim let it slide.
    Swedish {
        /// Angle γ between the wheel's plane and the rollers' axes, rad: 0 for an omni wheel, ±π/4 for mecanum.
        rollers: f64,
    },
}

/// How the body moves, robot frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Forward speed, m/s.
    pub forward: f64,
    /// Speed to the left, m/s.
    pub left: f64,
    /// Turn rate, rad/s.
    pub turn: f64,
}

/// What the wheels say about the body's motion.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyMotion {
    /// The twist that fits all wheels best.
    pub twist: Twist,
    /// Root of the sum of squares of all residuals, m/s.
    pub residual: f64,
    /// What does not fit, worst first: each constraint that others can check, with its distance from what they say.
    pub contradictions: Vec<Contradiction>,
}

/// A constraint that the other wheels do not agree with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contradiction {
    /// Number of the wheel in the list, from 0.
    pub wheel: usize,
    /// Which of its constraints.
    pub constraint: Constraint,
    /// What it says less what all other constraints say, m/s at the wheel.
    pub by: f64,
    /// The same as a residual in units that compare between constraints: `by` times the root of the redundancy, m/s.
    pub weight: f64,
}

/// One of the two things that a wheel holds to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Constraint {
    /// It rolls as far as it turns.
    Rolling,
    /// It does not move along its axle.
    Sliding,
}

/// What a wheel does when the body moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelMotion {
    /// Turn rate φ' of the wheel, rad/s.
    pub speed: f64,
    /// Turn rate of a caster about its joint, rad/s; 0 for others.
    pub steering: f64,
    /// Speed with which the body drags the wheel along its axle, m/s; what a rolling wheel cannot do is not 0.
    pub skid: f64,
}

/// Why a chassis cannot be, or cannot say how it moves.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ChassisError {
    /// No wheel at all.
    #[error("the chassis has no wheels")]
    NoWheels,
    /// A figure outside of what it may be.
    #[error("wheel {wheel}: {field} is {value}, expected {expected}")]
    Wheel {
        /// Number of the wheel, from 0.
        wheel: usize,
        /// The figure.
        field: &'static str,
        /// What stands there.
        value: f64,
        /// What may stand there.
        expected: &'static str,
    },
    /// As many speeds as wheels are needed.
    #[error("{speeds} wheel speeds for {wheels} wheels")]
    Count {
        /// Speeds given.
        speeds: usize,
        /// Wheels there are.
        wheels: usize,
    },
    /// The wheels leave a motion open.
    #[error(
        "the wheels say nothing about one motion: rank {rank} of 3, free is (forward {:.3}, left {:.3}, turn {:.3})",
        free.forward, free.left, free.turn
    )]
    Underdetermined {
        /// Rank of all constraints.
        rank: usize,
        /// A motion that no wheel notices, of unit length.
        free: Twist,
    },
}

/// A body on wheels.
#[derive(Clone, Debug, PartialEq)]
pub struct Chassis {
    wheels: Vec<Wheel>,
    /// J1 over C1, 3 columns.
    stacked: DMatrix<f64>,
    /// Wheel and constraint of each row.
    owners: Vec<(usize, Constraint)>,
}

impl Chassis {
    /// A chassis on the given wheels.
    ///
    /// # Errors    [`ChassisError`]: no wheels, or a figure that is not finite or a radius that is not positive.
    pub fn new(wheels: Vec<Wheel>) -> Result<Self, ChassisError> {
        if wheels.is_empty() {
            return Err(ChassisError::NoWheels);
        }
        for (number, wheel) in wheels.iter().enumerate() {
            wheel.check(number)?;
        }
        let owners = rows::owners(&wheels);
        let stacked = rows::stack(&wheels, &owners);
        Ok(Self {
            wheels,
            stacked,
            owners,
        })
    }

    /// Two wheels or tracks on one axle, the left one first, `track_width` apart.
    ///
    /// # Errors    [`ChassisError::Wheel`] for a width or a radius that cannot be.
    pub fn differential(track_width: f64, radius: f64) -> Result<Self, ChassisError> {
        let wheel = |bearing, orientation| Wheel {
            distance: 0.5 * track_width,
            bearing,
            orientation,
            radius,
            kind: WheelKind::Fixed,
        };
        let quarter = std::f64::consts::FRAC_PI_2;
        Self::new(vec![
            wheel(quarter, 0.0),
            wheel(-quarter, std::f64::consts::PI),
        ])
    }

    /// The two tracks of a robot.
    ///
    /// # Errors    [`ChassisError::Wheel`] for figures that cannot be.
    pub fn of(model: &RobotModel) -> Result<Self, ChassisError> {
        Self::differential(model.track_width, model.drive.metres_per_radian)
    }

    /// The wheels.
    #[must_use]
    pub fn wheels(&self) -> &[Wheel] {
        &self.wheels
    }

    /// Rank of all constraints together; 3 where wheel speeds tell the whole motion.
    #[must_use]
    pub fn rank(&self) -> usize {
        rank(&self.stacked)
    }

    /// Degree of mobility δm = 3 - rank(C1): how many of the three speeds can be chosen at this instant by wheel speeds
    /// alone, as the steered wheels stand. 2 for a differential drive, 3 for an omnidirectional one.
    #[must_use]
    pub fn mobility(&self) -> usize {
        3 - rank(&self.sliding_rows())
    }

    /// From wheel speeds, rad/s, to the motion of the body that fits them best.
    ///
    /// # Errors    [`ChassisError::Count`]; [`ChassisError::Wheel`] for a speed that is not finite;
    /// [`ChassisError::Underdetermined`] where a motion is left open.
    pub fn motion(&self, speeds: &[f64]) -> Result<BodyMotion, ChassisError> {
        self.check_speeds(speeds)?;
        let said = self.said(speeds);
        let qr = self.stacked.clone().col_piv_qr();
        let rank = rank_of(&qr.r());
        if rank < 3 {
            return Err(self.left_open(rank));
        }
        // A P = Q R, so R Pᵀ ξ = Qᵀ b; the leverage of row i is the squared length of row i of Q.
        let q = qr.q();
        let Some(mut twist) = qr.r().solve_upper_triangular(&(q.transpose() * &said)) else {
            return Err(self.left_open(rank));
        };
        qr.p().inv_permute_rows(&mut twist);
        let residuals = &said - &self.stacked * &twist;
        let leverages: Vec<f64> = q.row_iter().map(|row| row.norm_squared()).collect();
        Ok(BodyMotion {
            twist: Twist::from_vector(&Vector3::new(twist[0], twist[1], twist[2])),
            residual: residuals.norm(),
            contradictions: self.contradictions(&residuals, &leverages),
        })
    }

    /// From the motion of the body to what each wheel does; what a wheel cannot do stands in its `skid`.
    #[must_use]
    pub fn wheel_motions(&self, twist: &Twist) -> Vec<WheelMotion> {
        let twist = twist.to_vector();
        self.wheels
            .iter()
            .map(|wheel| wheel.under(&twist))
            .collect()
    }

    fn sliding_rows(&self) -> DMatrix<f64> {
        let rows: Vec<usize> = (0..self.owners.len())
            .filter(|&row| self.owners[row].1 == Constraint::Sliding)
            .collect();
        self.stacked.select_rows(&rows)
    }

    /// The right-hand side: r φ' for rolling, 0 for sliding.
    fn said(&self, speeds: &[f64]) -> DVector<f64> {
        let entries = self
            .owners
            .iter()
            .map(|&(wheel, constraint)| match constraint {
                Constraint::Rolling => self.wheels[wheel].rim_speed() * speeds[wheel],
                Constraint::Sliding => 0.0,
            });
        DVector::from_iterator(self.owners.len(), entries)
    }

    fn contradictions(&self, residuals: &DVector<f64>, leverages: &[f64]) -> Vec<Contradiction> {
        let rows = self.owners.iter().zip(residuals.iter().zip(leverages));
        let mut found: Vec<Contradiction> = rows
            .filter_map(|(&(wheel, constraint), (&residual, &leverage))| {
                let redundancy = 1.0 - leverage;
                (redundancy > LEAST_REDUNDANCY).then(|| Contradiction {
                    wheel,
                    constraint,
                    by: residual / redundancy,
                    weight: residual.abs() / redundancy.sqrt(),
                })
            })
            .collect();
        found.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        found
    }

    fn check_speeds(&self, speeds: &[f64]) -> Result<(), ChassisError> {
        if speeds.len() != self.wheels.len() {
            return Err(ChassisError::Count {
                speeds: speeds.len(),
                wheels: self.wheels.len(),
            });
        }
        match speeds.iter().position(|speed| !speed.is_finite()) {
            None => Ok(()),
            Some(wheel) => Err(ChassisError::Wheel {
                wheel,
                field: "speed",
                value: speeds[wheel],
                expected: "a finite turn rate",
            }),
        }
    }

    /// The direction of the smallest eigenvalue of AᵀA is what no wheel notices.
    fn left_open(&self, rank: usize) -> ChassisError {
        let normal: Matrix3<f64> = (self.stacked.transpose() * &self.stacked)
            .fixed_view::<3, 3>(0, 0)
            .into();
        let eigen = normal.symmetric_eigen();
        let free = eigen
            .eigenvectors
            .column(eigen.eigenvalues.imin())
            .into_owned();
        ChassisError::Underdetermined {
            rank,
            free: Twist::from_vector(&free),
        }
    }
}

impl Twist {
    fn from_vector(v: &Vector3<f64>) -> Self {
        Self {
            forward: v.x,
            left: v.y,
            turn: v.z,
        }
    }

    fn to_vector(self) -> Vector3<f64> {
        Vector3::new(self.forward, self.left, self.turn)
    }
}

fn rank(rows: &DMatrix<f64>) -> usize {
    match rows.nrows() {
        0 => 0,
        _ => rank_of(&rows.clone().col_piv_qr().r()),
    }
}

/// Pivots of R that count; they fall in size.
fn rank_of(r: &DMatrix<f64>) -> usize {
    let pivots = || (0..r.nrows().min(r.ncols())).map(|i| r[(i, i)].abs());
    let largest = pivots().fold(0.0, f64::max);
    pivots()
        .filter(|pivot| *pivot > RANK_TOLERANCE * largest)
        .count()
}
