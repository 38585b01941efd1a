//! Closed rings of corners.

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
