//! A pose graph as bytes, including its pattern: an elimination order found earlier gives different
//! last bits from one that is computed anew.

use std::sync::Arc;

use super::{Edge, EdgeId, PoseGraph};
use crate::snapshot::{Reader, Snapshot, SnapshotError, snapshot};

snapshot!(Edge {
    from,
    to,
    motion,
    information,
    cauchy,
});

impl Snapshot for EdgeId {
    fn write(&self, out: &mut Vec<u8>) {
        self.0.write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        usize::read(from).map(Self)
    }
}

impl Snapshot for PoseGraph {
    fn write(&self, out: &mut Vec<u8>) {
        let Self {
            poses,
            edges,
            ids,
            next_id,
            pattern,
        } = self;
        poses.write(out);
        edges.write(out);
        ids.write(out);
        next_id.write(out);
        pattern.as_ref().write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        let read = Self {
            poses: from.field("poses")?,
            edges: from.field("edges")?,
            ids: from.field("ids")?,
            next_id: from.field("next_id")?,
            pattern: Arc::new(from.field("pattern")?),
        };
        let poses = read.poses.len();
        let joins_two = |edge: &Edge| edge.from != edge.to && edge.from.max(edge.to) < poses;
        from.rule(
            read.edges.iter().all(joins_two),
            "an edge does not join two poses that are there",
        )?;
        let rise = read.ids.windows(2).all(|pair| pair[0] < pair[1]);
        let last = read.ids.last().is_none_or(|id| id.0 < read.next_id);
        from.rule(
            rise && last && read.ids.len() == read.edges.len(),
            "the names of the edges do not rise",
        )?;
        from.rule(
            read.pattern.size() < poses.max(1),
            "the pattern has more places than there are poses",
        )?;
        Ok(read)
    }
}
