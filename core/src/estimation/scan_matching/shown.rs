//! The inside of the map, to look at: submaps, and how far joins and placements are from where
//! these lie.

use nalgebra::{Matrix3, Point2, Vector2};

use super::super::pose_graph::Edge;
use super::super::submap::{ClosedSubmap, Doubt};
use super::ScanMatcher;
use super::records::ClosureRecord;
use crate::geom::Pose2;

/// A submap, to look at.
#[derive(Clone, Copy, Debug)]
pub struct ShownSubmap<'a> {
    /// Where it lies, as known now.
    pub map_from_submap: Pose2,
    /// Number of its own keyframes.
    pub keyframes: usize,
    /// Whether it is joined to the one before by the motion alone, for the scan that began it did
    /// not belong to that.
    pub is_loose: bool,
    closed: &'a ClosedSubmap,
}

/// How far a placement or a join is from where its submaps lie now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// The motion from the place that was found to the present one, in the frame of the former.
    pub off: Pose2,
    /// χ² of it: of 3 degrees of freedom if the placement is right and its information honest.
    pub chi2: f64,
    /// Ω, the information of the motion: over x, y (m) and heading (rad) of `off`.
    pub information: Matrix3<f64>,
}

/// What joins a submap to the one before: the motion measured on the way through that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Join {
    /// How far the two lie apart from it.
    pub residual: Residual,
    /// How well it is known: standard deviations.
    pub doubt: Doubt,
}

impl ScanMatcher {
    /// The submaps, in the order in which they were begun; the last one is still being made.
    pub fn submaps(&self) -> impl ExactSizeIterator<Item = ShownSubmap<'_>> {
        self.submaps.iter().map(|submap| ShownSubmap {
            map_from_submap: submap.map_from_submap,
            keyframes: submap.own_keyframes,
            is_loose: submap.is_loose,
            closed: &submap.closed,
        })
    }

    /// What became of each placement of one submap in another, the oldest first. Of those that were
    /// refused, the last few hundred.
    pub fn closure_records(&self) -> impl Iterator<Item = &ClosureRecord> {
        self.records.iter()
    }

    /// Grows whenever [`Self::submaps`] or [`Self::closure_records`] change.
    #[must_use]
    pub fn submaps_version(&self) -> u64 {
        self.records.changes() + self.moves + self.submaps.len() as u64
    }

    /// How far a placement is from where its submaps lie now.
    #[must_use]
    pub fn residual(&self, record: &ClosureRecord) -> Residual {
        self.residual_of(&record.edge())
    }

    /// Where the robot was at each scan in a submap, in the frame of that, in the order of the
    /// drive; nothing where there is no such submap.
    pub fn way_in(&self, submap: usize) -> impl Iterator<Item = Point2<f64>> {
        let scans = self.scans_in_submaps();
        let own = scans.filter(move |(_, of, _)| *of == submap);
        own.map(|(_, _, pose)| pose.position())
    }

    /// What joins each submap to the one before; `None` where nothing does, as of the first.
    #[must_use]
    pub fn joins(&self) -> Vec<Option<Join>> {
        let mut joins = vec![None; self.submaps.len()];
        for edge in self.graph.edges() {
            let is_join = edge.cauchy.is_none() && edge.to == edge.from + 1;
            let (true, Some(join)) = (is_join, joins.get_mut(edge.to)) else {
                continue;
            };
            *join = edge.information.try_inverse().map(|cov| Join {
                residual: self.residual_of(edge),
                doubt: Doubt::of(&cov),
            });
        }
        joins
    }

    fn residual_of(&self, edge: &Edge) -> Residual {
        let poses = self.graph.poses();
        let present = poses[edge.from].delta_to(&poses[edge.to]);
        Residual {
            off: edge.motion.delta_to(&present),
            chi2: self.graph.chi2_of(edge),
            information: edge.information,
        }
    }
}

impl<'a> ShownSubmap<'a> {
    /// Where it saw surfaces, in its frame; none while it is being made.
    pub fn surfaces(&self) -> impl ExactSizeIterator<Item = Point2<f64>> + use<'a> {
        self.closed.surfaces()
    }

    /// How far its surfaces reach, along the x and the y axis of its frame, m; nothing while it is
    /// being made.
    #[must_use]
    pub fn extent(&self) -> Vector2<f64> {
        let places = || self.surfaces().map(|place| place.coords);
        let Some(first) = places().next() else {
            return Vector2::zeros();
        };
        let ends = places().fold((first, first), |(low, high), place| {
            (low.inf(&place), high.sup(&place))
        });
        ends.1 - ends.0
    }
}
