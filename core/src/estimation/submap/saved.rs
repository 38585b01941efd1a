//! Closed submaps, and closures found between them, as bytes.

use super::{ClosedSubmap, Closure, Doubt};
use crate::snapshot::{Reader, Snapshot, SnapshotError, snapshot};

snapshot!(Doubt { shift, turn });
snapshot!(Closure {
    motion,
    information,
    is_searched,
    overlap,
    part,
});

/// Centre, radius and directions follow from the surfels.
impl Snapshot for ClosedSubmap {
    fn write(&self, out: &mut Vec<u8>) {
        self.surfels.write(out);
        self.free.write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        Ok(Self::new(from.field("surfels")?, from.field("free")?))
    }
}
