//! The second step of the distance transform: along a row.
//!
//! In: for each column the number g of cells to the nearest source in it. Out: √ of the least (c -
//! q)² + g(q)² over all columns q.
//!
//! 1. Near sources are tried one by one, many columns at a time: a column q farther away than the
//!    least distance found so far cannot improve it. Most cells of a map lie within a few metres of
//!    a wall.
//! 2. A row with a cell that has no source within [`NEAR`] is measured by the lower envelope of its
//!    parabolas: built in one sweep over the columns and read in a second one, however far the
//!    sources are. Both are linear in the number of cells.

/// How far step 1 looks, cells.
const NEAR: usize = 128;
/// A squared distance beyond the reach of step 1; with `NEAR`² added it still fits 16 bits.
const FAR: u16 = 40_000;
/// Columns worked on at a time.
const CHUNK: usize = 64;
/// This many columns to either side are tried before checking whether more are needed.
const STRIDE: usize = 4;

/// Measures rows.
pub(super) struct RowPass {
    resolution: f64,
    /// g² of each column, with `NEAR` columns without sources added on either side.
    squared: Vec<u16>,
    /// The least squared distance of each column.
    nearest: Vec<u16>,
    envelope: Envelope,
}

impl RowPass {
    pub(super) fn new(width: usize, resolution: f64) -> Self {
        let padded = width.next_multiple_of(CHUNK);
        Self {
            resolution,
            squared: vec![FAR; padded + 2 * NEAR],
            nearest: vec![FAR; padded],
            envelope: Envelope::default(),
        }
    }

    /// Writes distances in metres; `out` does not change if the row has no source.
    #[inline(always)]
    pub(super) fn measure(&mut self, gaps: &[u32], out: &mut [f32]) {
        if !self.measure_near(gaps, out) {
            self.envelope.measure(gaps, out, self.resolution);
        }
    }

    /// Step 1. Returns whether it found the nearest source of every column.
    #[inline(always)]
    fn measure_near(&mut self, gaps: &[u32], out: &mut [f32]) -> bool {
        let inner = self.squared.iter_mut().skip(NEAR);
        for (squared, gap) in inner.zip(gaps) {
            let gap = (*gap).min(1 + NEAR as u32);
            *squared = (gap * gap) as u16;
        }
        for (chunk, nearest) in self.nearest.as_chunks_mut().0.iter_mut().enumerate() {
            let first = chunk * CHUNK;
            let columns = gaps.len() - first.min(gaps.len());
            let Some(found) = nearest_of(&self.squared, first, columns) else {
                return false;
            };
            *nearest = found;
        }
        for (out, squared) in out.iter_mut().zip(&self.nearest) {
            *out = (f64::from(*squared).sqrt() * self.resolution) as f32;
        }
        true
    }
}

/// The least squared distances of the columns from `first` on, of which `columns` count; `None` if
/// one of these has no source nearby.
#[inline(always)]
fn nearest_of(squared: &[u16], first: usize, columns: usize) -> Option<[u16; CHUNK]> {
    let from = |at: usize| squared.get(at..)?.first_chunk::<CHUNK>();
    let counts: [u16; CHUNK] = std::array::from_fn(|at| if at < columns { u16::MAX } else { 0 });
    let mut nearest = *from(first + NEAR)?;
    let mut tried = 0;
    loop {
        let mut worst = 0;
        for at in 0..CHUNK {
            worst = worst.max(nearest[at] & counts[at]);
        }
        if tried * tried >= usize::from(worst) {
            return Some(nearest);
        }
        if tried == NEAR {
            return None;
        }
        for off in tried + 1..=tried + STRIDE {
            let (left, right) = (from(first + NEAR - off)?, from(first + NEAR + off)?);
            for at in 0..CHUNK {
                let other = left[at].min(right[at]) + (off * off) as u16;
                nearest[at] = nearest[at].min(other);
            }
        }
        tried += STRIDE;
    }
}

/// Step 2: the lower envelope of the parabolas of one row.
#[derive(Default)]
struct Envelope {
    /// The parabolas that are lowest somewhere, from left to right.
    parabolas: Vec<Parabola>,
}

/// The parabola (c - `col`)² + `height`; from column `from` on it is lower than the one before.
#[derive(Clone, Copy)]
struct Parabola {
    col: f64,
    height: f64,
    from: f64,
}

impl Envelope {
    #[inline(always)]
    fn measure(&mut self, gaps: &[u32], out: &mut [f32], resolution: f64) {
        self.parabolas.clear();
        for (col, &gap) in gaps.iter().enumerate().filter(|(_, gap)| **gap != u32::MAX) {
            self.push(col as f64, f64::from(gap) * f64::from(gap));
        }
        let mut lowest = self.parabolas.iter().peekable();
        let Some(mut current) = lowest.next() else {
            return;
        };
        for (col, out) in out.iter_mut().enumerate() {
            let col = col as f64;
            while let Some(next) = lowest.next_if(|next| next.from < col) {
                current = next;
            }
            let along = col - current.col;
            *out = ((along * along + current.height).sqrt() * resolution) as f32;
        }
    }

    fn push(&mut self, col: f64, height: f64) {
        let mut from = f64::NEG_INFINITY;
        while let Some(last) = self.parabolas.last() {
            // The column where the parabola at `col` falls below the last one.
            let rise = (height + col * col) - (last.height + last.col * last.col);
            let meet = rise / (2.0 * (col - last.col));
            if meet > last.from {
                from = meet;
                break;
            }
            self.parabolas.pop();
        }
        self.parabolas.push(Parabola { col, height, from });
    }
}
