//! The inside of the map, for display: submaps, and the residuals of joins and placements.

use nalgebra::{Matrix3, Point2, Vector2};

use super::super::pose_graph::Edge;
use super::super::submap::{ClosedSubmap, Doubt};
use super::ScanMatcher;
use super::records::ClosureRecord;
use crate::geom::Pose2;

/// A submap, for display.
#[derive(Clone, Copy, Debug)]
pub struct ShownSubmap<'a> {
    /// Its pose, as known now.
    pub map_from_submap: Pose2,
    /// Number of its own keyframes.
    pub keyframes: usize,
    /// Whether only the motion joins it to the one before, because the scan that began it did not
    /// belong to that.
    pub is_loose: bool,
    closed: &'a ClosedSubmap,
}

/// How far a placement or a join is from the current poses of its submaps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// The motion from the pose that was found to the present one, in the frame of the former.
    pub off: Pose2,
    /// Its χ², with 3 degrees of freedom if the placement is right and its information honest.
    pub chi2: f64,
    /// Ω, the information of the motion: over x, y (m) and heading (rad) of `off`.
    pub information: Matrix3<f64>,
}

/// What joins a submap to the one before: the motion measured through that one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Join {
    /// How far it is from the current poses of the two.
    pub residual: Residual,
    /// Its uncertainty: standard deviations.
    pub doubt: Doubt,
}

impl ScanMatcher {
    /// The submaps in the order in which they were begun; the last one is still being made.
    pub fn submaps(&self) -> impl ExactSizeIterator<Item = ShownSubmap<'_>> {
        self.submaps.iter().map(|submap| ShownSubmap {
            map_from_submap: submap.map_from_submap,
            keyframes: submap.own_keyframes,
            is_loose: submap.is_loose,
            closed: &submap.closed,
        })
    }

    /// What became of each placement of one submap in another, the oldest first. Of refused ones,
    /// only the last few hundred are kept.
    pub fn closure_records(&self) -> impl Iterator<Item = &ClosureRecord> {
        self.records.iter()
    }

    /// Increases whenever [`Self::submaps`] or [`Self::closure_records`] change.
    #[must_use]
    pub fn submaps_version(&self) -> u64 {
        self.records.changes() + self.moves + self.submaps.len() as u64
    }

    /// How far a placement is from the current poses of its submaps.
    #[must_use]
    pub fn residual(&self, record: &ClosureRecord) -> Residual {
        self.residual_of(&record.edge())
    }

    /// The robot's positions at the scans in a submap, in its frame, in the order of the drive;
    /// none if there is no such submap.
    pub fn way_in(&self, submap: usize) -> impl Iterator<Item = Point2<f64>> {
        let scans = self.scans_in_submaps();
        let own = scans.filter(move |(_, of, _)| *of == submap);
        own.map(|(_, _, pose)| pose.position())
    }

    /// What joins each submap to the one before; `None` if nothing does, as for the first.
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
    /// The positions of its surfaces, in its frame; none while it is being made.
    pub fn surfaces(&self) -> impl ExactSizeIterator<Item = Point2<f64>> + use<'a> {
        self.closed.surfaces()
    }

    /// The extent of its surfaces along the x and y axes of its frame, m; zero while it is being
    /// made.
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
