//! Closed rings of corners, and the room that places take.

use nalgebra::Point2;

/// The lower left and the upper right corner of the least rectangle around places; `None` around
/// none.
pub fn bounds(places: impl IntoIterator<Item = Point2<f64>>) -> Option<(Point2<f64>, Point2<f64>)> {
    let corners = places.into_iter().map(|at| (at, at));
    corners.reduce(|(low, high), (at, _)| (low.inf(&at), high.sup(&at)))
}

/// Each corner with the next one, the last with the first: the sides of a polygon.
pub fn sides_of<T>(ring: &[T]) -> impl Iterator<Item = (&T, &T)> {
    ring.iter().zip(ring.iter().cycle().skip(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_side_closes_the_ring() {
        let sides: Vec<_> = sides_of(&[1, 2, 3]).map(|(a, b)| [*a, *b]).collect();
        assert_eq!(sides, [[1, 2], [2, 3], [3, 1]]);
        assert_eq!(sides_of::<u8>(&[]).count(), 0);
    }
}
