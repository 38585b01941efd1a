//! Which beams of a scan end on one thing, and how large it is.

use crate::geom::Length;

use super::Beam;

/// Neighbouring hits of one thing are nearer together, m: two legs are, and two people who pass
/// each other are not.
pub(crate) const LINK: f64 = 0.3;

/// Whether two neighbouring hits are of one thing.
pub(crate) fn are_linked(a: &Beam, b: &Beam) -> bool {
    (a.end_in_robot - b.end_in_robot).length() < LINK
}
