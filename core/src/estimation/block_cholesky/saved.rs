//! A pattern as bytes: its order, what was coupled when it was made, and how dense it was.
//! Everything else follows from these.

use super::{BlockPattern, Couplings, Tree};
use crate::snapshot::{Reader, Snapshot, SnapshotError};

impl Snapshot for BlockPattern {
    fn write(&self, out: &mut Vec<u8>) {
        let order = &self.tree.order;
        order.write(out);
        self.density.write(out);
        let columns = (self.starts.windows(2)).map(|ends| &self.entries[ends[0]..ends[1]]);
        let pairs: Vec<(usize, usize)> = (columns.zip(order))
            .flat_map(|(entries, column)| {
                // The first entry is that of the diagonal.
                let below = entries.iter().skip(1);
                below.map(|entry| (*column, order[entry.row]))
            })
            .collect();
        pairs.write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        let order: Vec<usize> = from.field("order")?;
        let mut sorted = order.clone();
        sorted.sort_unstable();
        let is_order = sorted.into_iter().eq(0..order.len());
        from.rule(is_order, "an order does not hold each block once")?;
        let density: f64 = from.field("density")?;
        let pairs: Vec<(usize, usize)> = from.field("pairs")?;
        if order.is_empty() {
            return Ok(Self::default());
        }
        let couplings = Couplings::new(order.len(), pairs.into_iter());
        let tree = Tree::new(&order, &couplings);
        Ok(Self {
            density,
            ..Self::of(tree, &couplings)
        })
    }
}
