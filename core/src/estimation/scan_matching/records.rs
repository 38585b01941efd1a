//! What became of each placement of one submap in another.
//!
//! In: what was found, and each judgement on it. Out: a [`ClosureRecord`] for whoever asks why a
//! loop was closed, or was not. Nothing is decided by these records.

use std::collections::BTreeMap;

use nalgebra::Matrix3;

use super::super::loop_error::LoopError;
use super::super::pose_graph::{Edge, EdgeId};
use super::super::submap::{Closure, Doubt};
use super::closures::{Candidate, Proof};
use crate::geom::Pose2;
use crate::snapshot::{Reader, Snapshot, SnapshotError, snapshot, snapshot_names};

/// A placement of one submap in another, and what became of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosureRecord {
    /// The earlier submap.
    pub old: usize,
    /// The later one.
    pub new: usize,
    /// `old_from_new`, as found.
    pub motion: Pose2,
    /// Inverse of the covariance of `motion`, as an edge of a pose graph takes it.
    pub information: Matrix3<f64>,
    /// What was known of `motion` before.
    pub doubt: Doubt,
    /// Whether it had to be searched for.
    pub is_searched: bool,
    /// The part of the surfaces of either that lies on those of the other, the larger one.
    pub overlap: f64,
    /// Of the surfaces that are compared, the part that agrees.
    pub part: f64,
    /// What it proves by itself, in submaps that lie wholly on one another.
    pub worth: f64,
    /// What it had for itself when it was judged last; `None` before, and where it needed no
    /// search: then nothing is asked for.
    pub proof: Option<Proof>,
    /// How far off the way was that it closes, when it was accepted; `None` before.
    pub loop_error: Option<LoopError>,
    /// What became of it.
    pub fate: ClosureFate,
}

/// What became of a placement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClosureFate {
    /// It is not believed yet: what comes may prove it.
    Waiting {
        /// What it waits for.
        why: Delay,
    },
    /// It is an edge of the pose graph.
    Accepted {
        /// Its name there.
        edge: EdgeId,
    },
    /// It is not believed.
    Refused {
        /// Why not.
        why: Refusal,
    },
    /// It was accepted, and is not believed any more: it tore the way.
    Revoked {
        /// The submap between which and the next one the way was torn.
        torn: usize,
    },
}

/// Why a placement waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Delay {
    /// It was found just now.
    NotJudged,
    /// Something fits somewhere by chance, in so wide a window.
    TooLittleProof,
    /// It is farther from where the way leads than all that is feared of the way: no proof is
    /// enough.
    BeyondBelief,
    /// Another that contradicts it is nearly as well proved.
    Rivals,
    /// Believed, it would tear the way between submaps that follow each other.
    Tears,
    /// Believed, it would not be followed: the way and other closures hold the map elsewhere.
    Overruled,
}

/// Why a placement is not believed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// Its submap was placed in others, and that was proved.
    PlacedElsewhere,
    /// It waited for proof until there was no room for it any more.
    NeverProved,
}

/// The name of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct RecordId(usize);

/// Records of all that wait and all that were accepted, and of the last that were refused or
/// revoked.
#[derive(Clone, Debug, Default)]
pub(super) struct Records {
    list: BTreeMap<RecordId, ClosureRecord>,
    next: usize,
    changes: u64,
}

/// Most records of placements that were refused or revoked; the oldest go first.
const MOST_REFUSED: usize = 400;

impl RecordId {
    /// The name of a record that was taken over by a map with so many before it.
    pub(super) fn shifted(self, by: usize) -> Self {
        Self(self.0 + by)
    }
}

impl Records {
    /// A placement was found.
    pub(super) fn begin(
        &mut self,
        (old, new): (usize, usize),
        found: &Closure,
        doubt: Doubt,
    ) -> RecordId {
        let id = RecordId(self.next);
        self.next += 1;
        let record = ClosureRecord {
            old,
            new,
            motion: found.motion,
            information: found.information,
            doubt,
            is_searched: found.is_searched,
            overlap: found.overlap,
            part: found.part,
            worth: found.proof(),
            proof: None,
            loop_error: None,
            fate: ClosureFate::Waiting {
                why: Delay::NotJudged,
            },
        };
        self.list.insert(id, record);
        self.changes += 1;
        id
    }

    /// Takes a record in again that had gone with its submap.
    pub(super) fn take_back(&mut self, record: ClosureRecord) {
        self.list.insert(RecordId(self.next), record);
        self.next += 1;
        self.changes += 1;
    }

    pub(super) fn judge(&mut self, id: RecordId, proof: Proof) {
        self.change(id, |record| {
            record.proof = Some(proof);
            if let (ClosureFate::Waiting { why }, Some(lacks)) = (&mut record.fate, proof.lacks()) {
                *why = lacks;
            }
        });
    }

    pub(super) fn decide(&mut self, id: RecordId, fate: ClosureFate) {
        self.change(id, |record| record.fate = fate);
        self.forget_oldest();
    }

    pub(super) fn note_loop_error(&mut self, id: RecordId, error: LoopError) {
        self.change(id, |record| record.loop_error = Some(error));
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &ClosureRecord> {
        self.list.values()
    }

    /// Grows whenever a record does or changes.
    pub(super) fn changes(&self) -> u64 {
        self.changes
    }

    /// The accepted ones, with their edges.
    pub(super) fn accepted(&self) -> impl Iterator<Item = (RecordId, EdgeId, &ClosureRecord)> {
        self.list
            .iter()
            .filter_map(|(id, record)| match record.fate {
                ClosureFate::Accepted { edge } => Some((*id, edge, record)),
                _ => None,
            })
    }

    /// Takes over the records of another map, of which the submaps and edges are numbered from
    /// `submaps` and `edges` on; its records are from the number on that is returned.
    pub(super) fn append(&mut self, other: Self, submaps: usize, edges: usize) -> usize {
        let first = self.next;
        for (id, mut record) in other.list {
            record.old += submaps;
            record.new += submaps;
            match &mut record.fate {
                ClosureFate::Accepted { edge } => *edge = edge.shifted(edges),
                ClosureFate::Revoked { torn } => *torn += submaps,
                ClosureFate::Waiting { .. } | ClosureFate::Refused { .. } => {}
            }
            self.list.insert(RecordId(first + id.0), record);
        }
        self.next += other.next;
        self.changes += 1;
        first
    }

    /// Keeps the records of which both submaps are left, under new `numbers`; those of edges that
    /// are no longer there go too.
    pub(super) fn keep(
        &mut self,
        numbers: impl Fn((usize, usize)) -> Option<(usize, usize)>,
        has_edge: impl Fn(EdgeId) -> bool,
    ) {
        self.list.retain(|_, record| {
            let is_held = match record.fate {
                ClosureFate::Accepted { edge } => has_edge(edge),
                // Where the way was torn is named by a number that is no more.
                ClosureFate::Revoked { .. } => false,
                ClosureFate::Waiting { .. } | ClosureFate::Refused { .. } => true,
            };
            let Some((old, new)) = numbers((record.old, record.new)).filter(|_| is_held) else {
                return false;
            };
            (record.old, record.new) = (old, new);
            true
        });
        self.changes += 1;
    }

    fn change(&mut self, id: RecordId, change: impl FnOnce(&mut ClosureRecord)) {
        if let Some(record) = self.list.get_mut(&id) {
            change(record);
            self.changes += 1;
        }
    }

    fn forget_oldest(&mut self) {
        let is_out = |fate: &ClosureFate| {
            matches!(
                fate,
                ClosureFate::Refused { .. } | ClosureFate::Revoked { .. }
            )
        };
        let out = self.list.iter().filter(|(_, record)| is_out(&record.fate));
        let out: Vec<RecordId> = out.map(|(id, _)| *id).collect();
        let too_many = out.len().saturating_sub(MOST_REFUSED);
        for id in &out[..too_many] {
            self.list.remove(id);
        }
    }
}

impl ClosureRecord {
    /// The edge that it would be, in a pose graph that believes all errors.
    pub(super) fn edge(&self) -> Edge {
        Edge {
            from: self.old,
            to: self.new,
            motion: self.motion,
            information: self.information,
            cauchy: None,
        }
    }

    /// The placement, to wait for proof again.
    pub(super) fn candidate(&self, record: RecordId) -> Candidate {
        Candidate {
            old: self.old,
            new: self.new,
            closure: Closure {
                motion: self.motion,
                information: self.information,
                is_searched: self.is_searched,
                overlap: self.overlap,
                part: self.part,
            },
            doubt: self.doubt,
            record,
        }
    }
}

impl Snapshot for RecordId {
    fn write(&self, out: &mut Vec<u8>) {
        self.0.write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        usize::read(from).map(Self)
    }
}

snapshot!(Records {
    list,
    next,
    changes,
});
snapshot!(ClosureRecord {
    old,
    new,
    motion,
    information,
    doubt,
    is_searched,
    overlap,
    part,
    worth,
    proof,
    loop_error,
    fate,
});
snapshot_names!(Delay {
    NotJudged = 0,
    TooLittleProof = 1,
    Rivals = 2,
    Tears = 3,
    Overruled = 4,
    BeyondBelief = 5,
});
snapshot_names!(Refusal {
    PlacedElsewhere = 0,
    NeverProved = 1,
});

impl Snapshot for ClosureFate {
    fn write(&self, out: &mut Vec<u8>) {
        match self {
            Self::Waiting { why } => (0_u64, *why).write(out),
            Self::Accepted { edge } => (1_u64, *edge).write(out),
            Self::Refused { why } => (2_u64, *why).write(out),
            Self::Revoked { torn } => (3_u64, *torn).write(out),
        }
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        Ok(match u64::read(from)? {
            0 => Self::Waiting {
                why: from.field("why")?,
            },
            1 => Self::Accepted {
                edge: from.field("edge")?,
            },
            2 => Self::Refused {
                why: from.field("why")?,
            },
            3 => Self::Revoked {
                torn: from.field("torn")?,
            },
            other => return Err(from.no_variant(other)),
        })
    }
}
