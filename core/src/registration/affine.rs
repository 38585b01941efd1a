//! From two clouds of points to the affine map between them, without a start and without pairs.
//!
//! In: two clouds that show the same points, in any order. Out: the map x ↦ A x + t from the first
//! to the second, and how much the clouds still disagree under it.
//!
//! 1. Each cloud is whitened (`whitened`). What remains between the two is a rotation, or a
//!    rotation after a reflection.
//! 2. The rotation follows from moments of higher order, with and without a reflection: from all
//!    third moments together ([`AffineMethod::Moments`]), or from one power sum, whose roots are
//!    tried ([`AffineMethod::PowerSums`]).
//! 3. Of all candidates, the one is taken under which the moments up to the sixth order agree best.
//!
//! Both methods compare the clouds as wholes. They are exact if one cloud is a copy of the other,
//! and misled if one shows what the other does not. Scans that overlap in part are matched by
//! [`super::register`].
//!
//! Sources: Heikkilä (2004), "Pattern matching with affine moment descriptors"; Ho, Yang, Ikenaga
//! and Gotoh (2009), "Affine registration with symmetric polynomials". Both whiten by other roots
//! of the covariance; the rotation absorbs the difference.

mod moments;
mod power_sums;
mod signature;
#[cfg(test)]
mod tests;
mod whitened;

use nalgebra::{Matrix2, Point2, Vector2};

use self::signature::Signature;
use self::whitened::Whitened;
use crate::geom::Pose2;

/// x ↦ A x + t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AffineMap {
    /// A; its determinant is negative if it reflects.
    pub linear: Matrix2<f64>,
    /// t, m.
    pub shift: Vector2<f64>,
}

impl AffineMap {
    /// Where the map takes a point.
    #[must_use]
    pub fn apply(&self, point: &Point2<f64>) -> Point2<f64> {
        Point2::from(self.linear * point.coords + self.shift)
    }

    /// The pose of a map that is a rotation and a shift.
    pub(super) fn rigid(&self) -> Pose2 {
        let (cos, sin) = (self.linear[(0, 0)], self.linear[(1, 0)]);
        Pose2::from_cos_sin(self.shift.x, self.shift.y, cos, sin)
    }
}

/// How the rotation between whitened clouds is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AffineMethod {
    /// From all third central moments (Heikkilä 2004).
    #[default]
    Moments,
    /// From the first power sum of at least third order that is not zero (Ho et al. 2009).
    PowerSums,
}

impl AffineMethod {
    /// All methods, with their names.
    pub const ALL: [(&'static str, Self); 2] =
        [("moments", Self::Moments), ("power-sums", Self::PowerSums)];
}

/// The affine map between two clouds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AffineFit {
    /// From the first cloud to the second.
    pub map: AffineMap,
    /// How far the moments of the clouds differ after the map, from the third order to the sixth,
    /// as a part of their size: 0 for copies; 0.1 and more if one cloud shows other things.
    pub disagreement: f64,
}

/// Why two clouds have no affine map between them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AffineError {
    /// An affine map is fixed by at least three points that are not on one line.
    #[error("the {cloud} cloud has {found} points, expected at least 3")]
    TooFewPoints {
        /// Which of the two.
        cloud: &'static str,
        /// How many there are.
        found: usize,
    },
    /// A coordinate is not a number, or so large that its moments overflow.
    #[error("the {cloud} cloud: point {index} is not finite, or farther away than 1e6 m")]
    NotFinite {
        /// Which of the two.
        cloud: &'static str,
        /// The point.
        index: usize,
    },
    /// All points lie on a line, or in one place.
    #[error("the {cloud} cloud lies on a line: an affine map across it is not fixed")]
    OnALine {
        /// Which of the two.
        cloud: &'static str,
    },
    /// The moments that determine the rotation are zero.
    #[error("the clouds are too symmetric: their moments do not tell how one is turned")]
    Symmetric,
}

/// A rotation, maybe after a reflection y ↦ -y.
#[derive(Clone, Copy, Debug)]
struct Turn {
    /// rad.
    angle: f64,
    is_reflected: bool,
}

/// The affine map from one cloud to another.
///
/// # Errors    [`AffineError`]: too few points, or points that do not fix the map.
pub fn register_affine(
    from: &[Point2<f64>],
    to: &[Point2<f64>],
    method: AffineMethod,
) -> Result<AffineFit, AffineError> {
    let from = Whitened::of(from, "first")?;
    let to = Whitened::of(to, "second")?;
    let (p, q) = (Signature::of(&from.points), Signature::of(&to.points));
    // One row for each method.
    let turns = match method {
        AffineMethod::Moments => moments::turns(&p, &q),
        AffineMethod::PowerSums => power_sums::turns(&from.points, &to.points),
    };
    let judged = turns
        .into_iter()
        .map(|turn| (p.disagreement(&q, &turn), turn));
    let best = judged.min_by(|a, b| a.0.total_cmp(&b.0));
    let (disagreement, turn) = best.ok_or(AffineError::Symmetric)?;
    let (sin, cos) = crate::geom::sin_cos(turn.angle);
    let side = if turn.is_reflected { -1.0 } else { 1.0 };
    let turned = Matrix2::new(cos, -sin * side, sin, cos * side);
    let linear = to.factor * turned * from.inverse_factor;
    Ok(AffineFit {
        map: AffineMap {
            linear,
            shift: to.mean - linear * from.mean,
        },
        disagreement,
    })
}
