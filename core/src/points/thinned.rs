//! An even selection of a list.

/// At most `most` entries, evenly spaced. `turn` selects the offset of the first one, modulo the
/// spacing.
pub(crate) fn thinned<T: Copy>(all: &[T], most: usize, turn: usize) -> Vec<T> {
    let step = all.len().div_ceil(most.max(1)).max(1);
    all.iter()
        .skip(turn % step)
        .step_by(step)
        .copied()
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn evenly_and_in_turn() {
        let all: Vec<usize> = (0..10).collect();
        assert_eq!(thinned(&all, 4, 0), [0, 3, 6, 9]);
        assert_eq!(thinned(&all, 4, 1), [1, 4, 7]);
        assert_eq!(thinned(&all, 4, 5), [2, 5, 8]);
        assert_eq!(thinned(&all, 20, 7), all);
        assert_eq!(thinned(&all, 1, 0), [0]);
        assert!(thinned(&all[..0], 4, 3).is_empty());
    }
}
