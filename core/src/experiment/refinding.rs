//! How well the line filter finds again what it knows, scan by scan compared with the truth: true
//! and false positive rate over the gate.
//!
//! 1. The world knows what a line or a point of the scan shows ([`Things`]). A landmark shows what
//!    its first sighting showed. If the world does not know this for a sighting or for the landmark
//!    nearest to it, for example for a line across a gap, nothing is judged.
//! 2. A sighting has a partner if a landmark of the same thing was known before the scan. For a
//!    wall, the landmark's known part must overlap with what is seen, because parts of one wall are
//!    recognised as the same only where they meet.
//! 3. The decision of each gate follows from the nearest candidate: found if its d² is within the
//!    gate. The run goes on with the gate that is set, so its landmarks and covariances are those
//!    of that gate.

use std::collections::BTreeMap;

use nalgebra::Point2;

use crate::association::RefindingCurve;
use crate::estimation::{Explanation, LandmarkId};
use crate::features::PointFeature;
use crate::geom::Pose2;
use crate::sim::{Thing, Things, World};
use crate::slam::{SlamConfig, View};

/// Number of gates of the curve, from the least to the greatest, each larger by the same factor.
const GATES: i32 = 41;
const LEAST_GATE: f64 = 0.01;
const GREATEST_GATE: f64 = 100.0;

/// The counts of a run.
#[derive(Clone, Debug)]
pub(super) struct Refinding {
    things: Things,
    of_landmark: BTreeMap<LandmarkId, Thing>,
    curve: RefindingCurve,
}

impl Refinding {
    pub(super) fn new(world: &World) -> Self {
        let ratio = libm::log(GREATEST_GATE / LEAST_GATE) / f64::from(GATES - 1);
        let gate = |step: i32| LEAST_GATE * libm::exp(ratio * f64::from(step));
        Self {
            things: Things::of(world),
            of_landmark: BTreeMap::new(),
            curve: RefindingCurve::new((0..GATES).map(gate)),
        }
    }

    pub(super) fn curve(&self) -> &RefindingCurve {
        &self.curve
    }

    /// Counts the last scan. Its features are in the robot frame at `world_from_robot`, whose
    /// estimate is `map_from_robot`.
    pub(super) fn count(
        &mut self,
        view: &View,
        config: &SlamConfig,
        world_from_robot: &Pose2,
        map_from_robot: &Pose2,
    ) {
        let Some(report) = view.update else {
            return;
        };
        let max_gap = config.ekf.association.max_gap;
        for seen in report.explanations() {
            if let Some(line) = view.features.get(seen.feature) {
                let thing = self.things.of_line(world_from_robot, line.ends);
                let has_partner = thing.is_some_and(|thing| {
                    let ends = line.ends.map(|end| *map_from_robot * end);
                    self.knows_wall(view, &thing, ends)
                });
                self.count_one(&seen, thing, has_partner, max_gap);
            }
        }
        for seen in report.point_explanations() {
            if let Some(point) = view.points.get(seen.feature) {
                let thing = self.thing_of(world_from_robot, point);
                let has_partner = thing.is_some_and(|thing| self.knows(&thing));
                self.count_one(&seen, thing, has_partner, max_gap);
            }
        }
        let lines = report.added.iter().filter_map(|&(feature, id)| {
            let line = view.features.get(feature)?;
            Some((id, self.things.of_line(world_from_robot, line.ends)?))
        });
        let points = report.points_added.iter().filter_map(|&(feature, id)| {
            let point = view.points.get(feature)?;
            Some((id, self.thing_of(world_from_robot, point)?))
        });
        let added: Vec<_> = lines.chain(points).collect();
        self.of_landmark.extend(added);
        let merged = report.merged.iter().map(|merged| merged.gone);
        for gone in merged.chain(report.forgotten.iter().copied()) {
            self.of_landmark.remove(&gone);
        }
    }

    fn count_one(
        &mut self,
        seen: &Explanation,
        thing: Option<Thing>,
        has_partner: bool,
        max_gap: f64,
    ) {
        let Some(thing) = thing else {
            return;
        };
        let candidate = seen.candidates.iter().find(|c| c.gap <= max_gap);
        let nearest = match candidate {
            Some(candidate) => {
                let Some(known) = self.of_landmark.get(&candidate.landmark) else {
                    return;
                };
                Some((candidate.d2, known.is_same(&thing)))
            }
            None => None,
        };
        // The next part of a wall, across a gap, is that wall too.
        let is_known = has_partner || nearest.is_some_and(|(_, is_right)| is_right);
        self.curve.count(is_known, nearest);
    }

    fn thing_of(&self, world_from_robot: &Pose2, point: &PointFeature) -> Option<Thing> {
        let is_round = point.kind.is_round();
        (self.things).of_point_in_sweep(world_from_robot, point.position, is_round)
    }

    fn knows(&self, thing: &Thing) -> bool {
        let mut known = self.of_landmark.values();
        known.any(|known| known.is_same(thing))
    }

    /// Whether a part of a wall that overlaps with the seen part of it, map frame, was known
    /// before.
    fn knows_wall(&self, view: &View, thing: &Thing, seen: [Point2<f64>; 2]) -> bool {
        view.landmarks.iter().any(|wall| {
            let known = self.of_landmark.get(&wall.id);
            known.is_some_and(|known| known.is_same(thing)) && overlap(wall.ends, seen)
        })
    }
}

/// Whether two pieces of one line overlap.
fn overlap([a, b]: [Point2<f64>; 2], seen: [Point2<f64>; 2]) -> bool {
    let way = b - a;
    let [from, to] = seen.map(|end| way.dot(&(end - a)) / way.norm_squared());
    from.min(to) < 1.0 && from.max(to) > 0.0
}
