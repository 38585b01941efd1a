//! Which hits of a scan belong to one thing.

use crate::geom::Length;

use super::Beam;

/// Neighbouring hits of one thing are nearer together than this, m: two legs are, but two people
/// who pass each other are not.
pub(crate) const LINK: f64 = 0.3;

/// Whether two neighbouring hits belong to one thing.
pub(crate) fn are_linked(a: &Beam, b: &Beam) -> bool {
    (a.end_in_robot - b.end_in_robot).length() < LINK
}
