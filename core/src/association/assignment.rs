//! In: the cost of giving each row each column. Out: the assignment with the least total cost.
//!
//! Rows are added one by one, each along the cheapest alternating path. Potentials keep all reduced
//! costs non-negative. O(rows² · columns).
//!
//! Source: Kuhn (1955), "The Hungarian method for the assignment problem"; the shortest-path form
//! of Jonker & Volgenant (1987).

/// Stands for a forbidden pairing: it is used only if a row has nothing else, and undone
/// afterwards.
const FORBIDDEN: f64 = 1e12;

/// The column of each row, no column twice, at the least total cost. A row goes without if there
/// are more rows than columns, or if all columns left for it have no finite cost. `costs` has one
/// row of costs for each row; missing ones count as not finite.
#[must_use]
pub fn assign(costs: &[Vec<f64>]) -> Vec<Option<usize>> {
    let cols = costs.iter().map(Vec::len).max().unwrap_or(0);
    // Columns for rows that go without.
    let width = cols.max(costs.len());
    let cost = |row: usize, col: usize| {
        let own = costs.get(row).and_then(|row| row.get(col));
        own.copied().filter(|c| c.is_finite()).unwrap_or(FORBIDDEN)
    };
    // Place 0 stands for none.
    let (mut row_price, mut col_price) = (vec![0.0; costs.len() + 1], vec![0.0; width + 1]);
    let mut row_of = vec![0; width + 1];
    for row in 1..=costs.len() {
        row_of[0] = row;
        let mut least = vec![f64::INFINITY; width + 1];
        let (mut from, mut is_done) = (vec![0; width + 1], vec![false; width + 1]);
        let mut at = 0;
        while row_of[at] != 0 {
            is_done[at] = true;
            let (here, mut step, mut next) = (row_of[at], f64::INFINITY, 0);
            for col in (1..=width).filter(|&col| !is_done[col]) {
                let reduced = cost(here - 1, col - 1) - row_price[here] - col_price[col];
                if reduced < least[col] {
                    (least[col], from[col]) = (reduced, at);
                }
                if least[col] < step {
                    (step, next) = (least[col], col);
                }
            }
            for col in 0..=width {
                if is_done[col] {
                    row_price[row_of[col]] += step;
                    col_price[col] -= step;
                } else {
                    least[col] -= step;
                }
            }
            at = next;
        }
        while at != 0 {
            row_of[at] = row_of[from[at]];
            at = from[at];
        }
    }
    let mut chosen = vec![None; costs.len()];
    for (col, &row) in row_of.iter().enumerate().skip(1) {
        if row > 0 && cost(row - 1, col - 1) < FORBIDDEN {
            chosen[row - 1] = Some(col - 1);
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The least sum over all assignments, by trying them all; each row without a column costs
    /// `none`.
    fn brute_force(costs: &[Vec<f64>], used: u32, none: f64) -> f64 {
        let Some((row, rest)) = costs.split_first() else {
            return 0.0;
        };
        let free = row
            .iter()
            .enumerate()
            .filter(|(col, c)| used >> col & 1 == 0 && c.is_finite());
        let taken = free.map(|(col, cost)| cost + brute_force(rest, used | 1 << col, none));
        taken.fold(none + brute_force(rest, used, none), f64::min)
    }

    fn total(costs: &[Vec<f64>], chosen: &[Option<usize>], none: f64) -> f64 {
        let each = costs.iter().zip(chosen);
        each.map(|(row, col)| col.map_or(none, |col| row[col]))
            .sum()
    }

    proptest! {
        #[test]
        fn nothing_is_cheaper(
            (rows, cols) in (0..6_usize, 1..6_usize), all in proptest::array::uniform32(-3.0..10.0_f64), gaps in any::<u32>(),
        ) {
            let cost = |place: usize| match gaps >> place & 1 == 1 && place.is_multiple_of(3) {
                true => f64::INFINITY,
                false => all[place],
            };
            let costs: Vec<Vec<f64>> = (0..rows)
                .map(|row| (0..cols).map(|col| cost(row * cols + col)).collect())
                .collect();
            let chosen = assign(&costs);
            let mut columns: Vec<usize> = chosen.iter().flatten().copied().collect();
            columns.sort_unstable();
            columns.dedup();
            prop_assert_eq!(columns.len(), chosen.iter().flatten().count());
            // Going without costs more than everything else together.
            let none = 1e6;
            let off = total(&costs, &chosen, none) - brute_force(&costs, 0, none);
            prop_assert!(off.abs() < 1e-6, "{off}: {chosen:?} of {costs:?}");
        }
    }

    #[test]
    fn nobody_and_nothing() {
        assert_eq!(assign(&[]), []);
        assert_eq!(assign(&[vec![], vec![]]), [None, None]);
        assert_eq!(
            assign(&[vec![f64::NAN, 2.0], vec![1.0]]),
            [Some(1), Some(0)]
        );
    }
}
