//! Closed rings of corners, and bounding rectangles.

use nalgebra::Point2;

/// The lower left and the upper right corner of the bounding rectangle of points; `None` without
/// points.
pub fn bounds(places: impl IntoIterator<Item = Point2<f64>>) -> Option<(Point2<f64>, Point2<f64>)> {
    let corners = places.into_iter().map(|at| (at, at));
    corners.reduce(|(low, high), (at, _)| (low.inf(&at), high.sup(&at)))
}

/// Each corner with the next one, the last with the first: the sides of a polygon.
pub fn sides_of<T>(ring: &[T]) -> impl Iterator<Item = (&T, &T)> {
    ring.iter().zip(ring.iter().cycle().skip(1))
}

/// Whether a point lies within a polygon, in whichever direction its corners go round: a ray from
/// it crosses the sides an odd number of times.
#[must_use]
pub fn ring_holds(corners: &[Point2<f64>], place: Point2<f64>) -> bool {
    let crosses = |(a, b): &(&Point2<f64>, &Point2<f64>)| {
        (a.y > place.y) != (b.y > place.y)
            && place.x < a.x + (place.y - a.y) / (b.y - a.y) * (b.x - a.x)
    };
    sides_of(corners).filter(crosses).count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_in_the_notch_of_an_l_lies_outside() {
        let corner = |(x, y): (f64, f64)| Point2::new(x, y);
        let mut ring = [
            (0.0, 0.0),
            (4.0, 0.0),
            (4.0, 1.0),
            (1.0, 1.0),
            (1.0, 4.0),
            (0.0, 4.0),
        ]
        .map(corner);
        for _ in 0..2 {
            for (place, inside) in [
                ((0.5, 0.5), true),
                ((3.5, 0.5), true),
                ((0.5, 3.5), true),
                ((2.0, 2.0), false),
                ((-0.5, 0.5), false),
                ((5.0, 0.5), false),
            ] {
                assert_eq!(ring_holds(&ring, corner(place)), inside, "{place:?}");
            }
            ring.reverse();
        }
        assert!(!ring_holds(&[], Point2::origin()));
    }

    #[test]
    fn the_last_side_closes_the_ring() {
        let sides: Vec<_> = sides_of(&[1, 2, 3]).map(|(a, b)| [*a, *b]).collect();
        assert_eq!(sides, [[1, 2], [2, 3], [3, 1]]);
        assert_eq!(sides_of::<u8>(&[]).count(), 0);
    }
}
