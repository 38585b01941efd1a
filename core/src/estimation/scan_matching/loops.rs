//! The submaps in the pose graph: each is joined to the next when it is closed, and to earlier ones
//! where they show the same place.
//!
//! In: closed submaps. Out: edges and, after each edge that closes a loop, new poses of all
//! submaps. The comparisons to be made are listed when a submap is closed; the matcher does one of
//! them at each scan.

use nalgebra::Matrix3;

use super::super::loop_error::LoopError;
use super::super::pose_graph::{Edge, EdgeId, information_at_end};
use super::super::submap::Indexed;
use super::closures::Candidate;
use super::drift::KnownWays;
use super::records::{ClosureFate, Delay, RecordId};
use super::revocation::{Believed, Contradicted, contradicted, is_overruled};
use super::{ScanMatcher, carried};
use crate::geom::{Length, Pose2, pose_cov};

/// The most times that closures are taken out after one optimisation.
const MOST_REVOCATIONS: usize = 8;

impl ScanMatcher {
    /// Adds the edge from a submap to the one that follows it.
    pub(super) fn join_to_next(&mut self, old: usize, old_from_new: &Pose2, map_from_new: Pose2) {
        let floor = pose_cov(self.config.submap_sigma, self.config.submap_turn_sigma);
        let cov = self.way_cov + floor;
        let information = cov.try_inverse().unwrap_or_else(Matrix3::identity);
        let new = self.graph.add_pose(map_from_new);
        // Both ends exist, and a match that is not finite was never accepted.
        self.graph.add_edge(Edge {
            from: old,
            to: new,
            motion: *old_from_new,
            information: information_at_end(old_from_new, &information),
            cauchy: None,
        });
        let map_from_old = self.map_from_running();
        let turned = map_from_old.rotation();
        let ahead = map_from_new.position() - map_from_old.position();
        let way = turned * cov * turned.transpose();
        self.submap_cov = carried(&self.submap_cov, ahead, way);
        self.way_cov = Matrix3::zeros();
    }

    /// Lists the earlier submaps that may show the same place as submap `new`, nearest first.
    pub(super) fn plan_comparisons(&mut self, new: usize) {
        let doubts = self.doubts(new);
        let this = &self.submaps[new];
        let centre = this.map_from_submap * this.closed.centre;
        let mut near: Vec<(f64, usize)> = self
            .submaps
            .iter()
            .zip(&doubts)
            .enumerate()
            .take(new)
            .filter_map(|(old, (submap, doubt))| {
                let distance = (submap.map_from_submap * submap.closed.centre - centre).length();
                let reach = submap.closed.radius.max(this.closed.radius)
                    + self.config.closure.window(doubt).shift;
                let compared = self.compared.get(&(old, new)).copied();
                let is_new = compared.is_none_or(|before| doubt.shift < 0.5 * before);
                (distance < reach && is_new && !self.are_joined(old, new))
                    .then_some((distance, old))
            })
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        // If the path is very uncertain, neighbouring submaps show the same: one of them is enough.
        let mut chosen: Vec<usize> = vec![];
        for (_, old) in near {
            let is_wide = doubts[old].shift > self.config.closure.wide;
            let middle = |i: usize| self.submaps[i].map_from_submap * self.submaps[i].closed.centre;
            let is_covered = |&other: &usize| {
                doubts[other].shift > self.config.closure.wide
                    && (middle(other) - middle(old)).length() < self.config.closure.apart
            };
            if is_wide && chosen.iter().any(is_covered) {
                continue;
            }
            chosen.push(old);
            let is_anywhere = self.unplaced.is_some();
            if chosen.len() >= self.config.closure.candidates && !is_anywhere {
                break;
            }
        }
        self.jobs.extend(chosen.into_iter().map(|old| (old, new)));
    }

    pub(super) fn compare(&mut self, old: usize, new: usize) {
        let doubts = self.doubts(new);
        self.compared.insert((old, new), doubts[old].shift);
        let (a, b) = (&self.submaps[old], &self.submaps[new]);
        let guess = a.map_from_submap.delta_to(&b.map_from_submap);
        let surfels = &self.config.surfels;
        let indexes = [new, old].map(|submap| self.indexes.of(submap, new));
        let b = Indexed::new(&b.closed, &indexes[0], surfels);
        let a = Indexed::new(&a.closed, &indexes[1], surfels);
        let (matching, closure) = (&self.config.matching, &self.config.closure);
        let found = a.find(&b, &guess, &doubts[old], matching, closure);
        let Some(closure) = found else { return };
        let doubt = doubts[old];
        let candidate = Candidate {
            old,
            new,
            closure,
            doubt,
            record: self.records.begin((old, new), &closure, doubt),
        };
        if closure.is_searched {
            self.waiting.push(candidate, &mut self.records);
        } else {
            self.believe(&candidate);
        }
    }

    /// Accepts the placements that are proved by now.
    pub(super) fn believe_proved(&mut self, new: usize) {
        let mut waiting = std::mem::take(&mut self.waiting);
        let mut records = std::mem::take(&mut self.records);
        let ways = KnownWays::of(self);
        let proved = waiting.take_proved(new, &ways, self.config.closure.proof, &mut records);
        self.drift = ways.drift_after(&proved);
        self.waiting = waiting;
        self.records = records;
        self.place_piece(&proved);
        for candidate in &proved {
            self.believe(candidate);
        }
        if !proved.is_empty() {
            // The path since the last closure is known better now.
            self.optimize();
            for between in std::mem::replace(&mut self.last_closed, new)..new {
                self.plan_comparisons(between);
            }
        }
    }

    fn believe(&mut self, candidate: &Candidate) {
        let added = self.graph.add_edge(Edge {
            from: candidate.old,
            to: candidate.new,
            motion: candidate.closure.motion,
            information: candidate.closure.information,
            cauchy: Some(self.config.closure.kernel),
        });
        if let Some(edge) = added {
            let accepted = ClosureFate::Accepted { edge };
            self.records.decide(candidate.record, accepted);
            self.newest.push((edge, *candidate));
            self.graph_changed = true;
        }
    }

    pub(super) fn optimize(&mut self) {
        self.graph_changed = false;
        self.note_loop_errors();
        self.graph.optimize(self.config.closure.max_iterations);
        self.revoke();
        self.moves += 1;
        for (submap, pose) in self.submaps.iter_mut().zip(self.graph.poses()) {
            submap.map_from_submap = *pose;
        }
        let origin = self.unplaced.as_ref().map_or(0, |piece| piece.first);
        if let Some(cov) = self.cov_of_running(origin) {
            self.submap_cov = cov;
        }
        self.count_loops();
    }

    /// Records how far off the paths that the newest closures close were, before the graph follows
    /// the closures.
    fn note_loop_errors(&mut self) {
        if self.newest.is_empty() {
            return;
        }
        let mut before = self.graph.clone();
        for (edge, _) in &self.newest {
            before.remove_edge(*edge);
        }
        let Some(known) = before.marginals() else {
            return;
        };
        for (edge, placed) in &self.newest {
            let closure = self.graph.edge(*edge);
            if let Some(error) = closure.and_then(|edge| LoopError::of(edge, &before, &known)) {
                self.records.note_loop_error(placed.record, error);
            }
        }
    }

    /// Takes out closures that tear the trajectory between neighbours.
    fn revoke(&mut self) {
        for _ in 0..MOST_REVOCATIONS {
            let closures = self.records.accepted().map(|(_, edge, record)| Believed {
                edge,
                proof: record.worth,
            });
            let newest: Vec<EdgeId> = self.newest.iter().map(|(edge, _)| *edge).collect();
            let is_loose = |submap: usize| self.submaps[submap].is_loose;
            let iterations = self.config.closure.max_iterations;
            let found = contradicted(&self.graph, closures, &newest, is_loose, iterations);
            let Some((Contradicted { edges, torn }, without)) = found else {
                break;
            };
            self.graph = without;
            if edges == newest {
                // They may still be proved better than what contradicts them.
                for (_, candidate) in std::mem::take(&mut self.newest) {
                    let why = Delay::Tears;
                    self.records
                        .decide(candidate.record, ClosureFate::Waiting { why });
                    self.waiting.push(candidate, &mut self.records);
                }
                continue;
            }
            let accepted = self.records.accepted();
            let revoked: Vec<RecordId> = accepted
                .filter(|(_, edge, _)| edges.contains(edge))
                .map(|(id, ..)| id)
                .collect();
            for id in revoked {
                self.records.decide(id, ClosureFate::Revoked { torn });
            }
        }
        self.put_off_overruled();
        let newest = std::mem::take(&mut self.newest);
        let placed: Vec<usize> = newest
            .iter()
            .filter(|(edge, c)| c.closure.is_searched && self.graph.edge(*edge).is_some())
            .map(|(_, c)| c.new)
            .collect();
        if !placed.is_empty() {
            self.waiting.refuse_others(&placed, &mut self.records);
        }
    }

    /// Takes out closures that the optimised graph does not follow: they would be called closures,
    /// and close nothing. Later evidence may prove them better.
    fn put_off_overruled(&mut self) {
        let overruled: Vec<(EdgeId, Candidate)> = (self.records.accepted())
            .filter(|(_, edge, _)| is_overruled(&self.graph, *edge))
            .map(|(id, edge, record)| (edge, record.candidate(id)))
            .collect();
        if overruled.is_empty() {
            return;
        }
        for (edge, candidate) in overruled {
            self.graph.remove_edge(edge);
            let why = Delay::Overruled;
            self.records
                .decide(candidate.record, ClosureFate::Waiting { why });
            self.waiting.push(candidate, &mut self.records);
        }
        self.graph.optimize(self.config.closure.max_iterations);
    }

    fn are_joined(&self, a: usize, b: usize) -> bool {
        self.graph.edges().iter().any(|e| {
            let joins = (e.from == a && e.to == b) || (e.from == b && e.to == a);
            // A loose join says little: what both sides show says more.
            joins && !(e.cauchy.is_none() && self.submaps[a.max(b)].is_loose)
        })
    }
}
