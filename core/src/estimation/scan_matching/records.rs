//! What became of each placement of one submap in another.
//!
//! In: what was found, and each decision on it. Out: a [`ClosureRecord`] that explains why a loop
//! was closed or not. Nothing is decided by these records.

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
    /// The prior uncertainty of `motion`.
    pub doubt: Doubt,
    /// Whether it had to be searched for.
    pub is_searched: bool,
    /// The part of the surfaces of one that lies on those of the other; the larger of the two
    /// parts.
    pub overlap: f64,
    /// The part of the compared surfaces that agrees.
    pub part: f64,
    /// What it proves by itself, in submaps that lie wholly on one another.
    pub worth: f64,
    /// Its evidence when it was last judged; `None` before that, and if it needed no search: then
    /// no proof is required.
    pub proof: Option<Proof>,
    /// How far off the path that it closes was, when it was accepted; `None` before.
    pub loop_error: Option<LoopError>,
    /// What became of it.
    pub fate: ClosureFate,
}

/// What became of a placement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClosureFate {
    /// Not accepted yet: later evidence may prove it.
    Waiting {
        /// What it waits for.
        why: Delay,
    },
    /// It is an edge of the pose graph.
    Accepted {
        /// Its name in the graph.
        edge: EdgeId,
    },
    /// Not accepted.
    Refused {
        /// Why not.
        why: Refusal,
    },
    /// It was accepted, and later removed because it tore the trajectory.
    Revoked {
        /// The trajectory was torn between this submap and the next.
        torn: usize,
    },
}

/// Why a placement waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Delay {
    /// It was only just found.
    NotJudged,
    /// In so wide a window, something fits somewhere by chance.
    TooLittleProof,
    /// It is farther from where the path predicts it than all assumed drift allows: no proof is
    /// enough.
    BeyondBelief,
    /// Another placement that contradicts it is nearly as well proved.
    Rivals,
    /// If accepted, it would tear the trajectory between consecutive submaps.
    Tears,
    /// If accepted, it would not be followed: the path and other closures hold the map elsewhere.
    Overruled,
}

/// Why a placement is not accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// Its submap was placed in others, with proof.
    PlacedElsewhere,
    /// It waited for proof until there was no more room for it.
    NeverProved,
}

/// The name of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct RecordId(usize);

/// Records of all waiting and accepted placements, and of the last that were refused or revoked.
#[derive(Clone, Debug, Default)]
pub(super) struct Records {
    list: BTreeMap<RecordId, ClosureRecord>,
    next: usize,
    changes: u64,
}

/// The most records of refused or revoked placements; the oldest are dropped first.
const MOST_REFUSED: usize = 400;

impl RecordId {
    /// The name of a record after it was taken over by a map with `by` records before it.
    pub(super) fn shifted(self, by: usize) -> Self {
        Self(self.0 + by)
    }
}

impl Records {
    /// Begins the record of a placement that was found.
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

    /// Restores a record that was removed with its submap.
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

    /// Increases whenever a record is added or changed.
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

    /// Takes over the records of another map whose submaps and edges are numbered from `submaps`
    /// and `edges` on; its records are numbered from the returned number on.
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

    /// Keeps the records whose two submaps both remain, under new `numbers`; records of edges that
    /// no longer exist are dropped too.
    pub(super) fn keep(
        &mut self,
        numbers: impl Fn((usize, usize)) -> Option<(usize, usize)>,
        has_edge: impl Fn(EdgeId) -> bool,
    ) {
        self.list.retain(|_, record| {
            let is_held = match record.fate {
                ClosureFate::Accepted { edge } => has_edge(edge),
                // The number that says where the trajectory was torn is no longer valid.
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
    /// The edge that it would be in a pose graph without robust kernels.
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
