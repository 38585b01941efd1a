//! Which blocks of a symmetric matrix are nonzero, and in which order to eliminate them.

/// For each block, the blocks it is coupled with.
#[derive(Clone, Debug, Default)]
pub(super) struct Couplings {
    /// Ascending, block after block.
    others: Vec<usize>,
    /// Where the list of each block begins, and finally where the last one ends.
    starts: Vec<usize>,
}

impl Couplings {
    /// `pairs` may have repetitions, and contain both (a, b) and (b, a); pairs of a block with
    /// itself, or with one that does not exist, are ignored.
    pub(super) fn new(size: usize, pairs: impl Iterator<Item = (usize, usize)> + Clone) -> Self {
        let pairs = pairs.filter(|&(a, b)| a != b && a < size && b < size);
        let mut ends = vec![0; size + 1];
        for (a, b) in pairs.clone() {
            ends[a] += 1;
            ends[b] += 1;
        }
        let mut sum = 0;
        for end in &mut ends {
            sum += *end;
            *end = sum;
        }
        let mut all = vec![0; sum];
        for (a, b) in pairs {
            for (one, other) in [(a, b), (b, a)] {
                ends[one] -= 1;
                all[ends[one]] = other;
            }
        }
        // `starts` so far marks where each list begins; from here on, lists are sorted and have no
        // repetitions.
        let mut starts = Vec::with_capacity(size + 1);
        let mut kept = 0;
        for block in 0..size {
            let (from, to) = (ends[block], ends[block + 1]);
            starts.push(kept);
            all[from..to].sort_unstable();
            for at in from..to {
                if kept == starts[block] || all[kept - 1] != all[at] {
                    all[kept] = all[at];
                    kept += 1;
                }
            }
        }
        starts.push(kept);
        all.truncate(kept);
        Self {
            others: all,
            starts,
        }
    }

    /// The blocks that a block is coupled with, ascending.
    pub(super) fn of(&self, block: usize) -> &[usize] {
        &self.others[self.starts[block]..self.starts[block + 1]]
    }

    /// Number of blocks.
    pub(super) fn size(&self) -> usize {
        self.starts.len() - 1
    }

    /// An order with little fill-in: approximate minimum degree (Amestoy, Davis & Duff 1996).
    pub(super) fn least_fill(&self) -> Vec<usize> {
        // The diagonal is included although it has no effect: a check in the crate, in debug builds
        // only, subtracts the number of blocks from that of entries.
        let size = self.size();
        let mut entries: Vec<isize> = Vec::with_capacity(self.others.len() + size);
        let mut starts: Vec<isize> = vec![0];
        for block in 0..size {
            let others = self.of(block);
            let (before, after) = others.split_at(others.partition_point(|&other| other < block));
            entries.extend(before.iter().map(|&other| other as isize));
            entries.push(block as isize);
            entries.extend(after.iter().map(|&other| other as isize));
            starts.push(entries.len() as isize);
        }
        let ordered = amd::order(size as isize, &starts, &entries, &amd::Control::default());
        match ordered {
            Ok((order, _, _)) => order.into_iter().map(|block| block as usize).collect(),
            // Sorted lists of existing blocks are never refused; any order would be valid.
            Err(_) => (0..size).collect(),
        }
    }
}
