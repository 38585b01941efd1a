//! Keyframes, and the submaps that they form.
//!
//! In: a scan with its pose. Out: the running submap extended and the grid drawn; a new submap
//! after some keyframes, or if a scan does not belong to the running one.

use nalgebra::{Matrix3, Vector2};

use super::super::submap::ClosedSubmap;
use super::seen::Seen;
use super::tracking::Tracked;
use super::{Recent, ScanMatcher, Submap};
use crate::geom::{Length, Pose2};
use crate::map::SurfelMap;
use crate::points::OrientedPoint;
use crate::registration::Verdict;

/// A direction is observed if the cosine between it and a degenerate one is below this.
const SEES: f64 = 0.3;
/// The part of a firm match's covariance that a keyframe adds to that of the motion through its
/// submap. All scans are matched to the same submap, so their errors do not add up, except for what
/// the submap takes over from them: simulated joins err by a tenth of the standard deviation that
/// the sum of all would give; a third of it is claimed. Motions that odometry did not count depend
/// on the match before, and scans of few beams on little more: those add all of it.
const ADDED: f64 = 0.1;
/// The same for a scan whose beams were taken one after the other. Its covariance is that of the
/// robot after the last beam; the points are known better than that, and the submap takes over the
/// points. Simulated joins in `loop` and `parallel` were claimed to 0.02 rad and err by 0.003.
const ADDED_BY_SWEEP: f64 = 0.03;
/// A scan that contradicts the submap is not drawn while this part of it agrees, ...
const WAITING_OVERLAP: f64 = 0.4;
/// ... scans follow each other within these multiples of the keyframe distance and turn, ...
pub(super) const CLOSE: [f64; 2] = [0.5, 1.0];
/// ... and the last keyframe is within these.
const LONGEST_WAIT: [f64; 2] = [8.0, 3.0];

impl ScanMatcher {
    /// If little of the scan is known already, as behind a door, the map must grow sooner.
    pub(super) fn is_new_place(&self, overlap: f64) -> bool {
        let part = if overlap < self.config.new_below {
            self.config.new_part
        } else {
            1.0
        };
        !self.is_keyframe_within([part; 2])
    }

    /// Whether the last keyframe is within these multiples of the keyframe distance and turn.
    pub(super) fn is_keyframe_within(&self, parts: [f64; 2]) -> bool {
        let here = self.local.pose;
        self.last_keyframe
            .is_some_and(|last| self.is_within(&last.delta_to(&here), parts))
    }

    /// Whether a motion is within these multiples of the keyframe distance and turn.
    pub(super) fn is_within(&self, motion: &Pose2, [distances, turns]: [f64; 2]) -> bool {
        motion.position().coords.length() <= distances * self.config.keyframe_distance
            && motion.heading().abs() <= turns * self.config.keyframe_turn
    }

    /// Whether a scan need not be drawn. If a person walks by or a door opens, the scan is matched
    /// askew, and once drawn it would hold the next scans there. One of the next scans will do as
    /// well, if they follow each other closely.
    pub(super) fn can_wait(&self, seen: &Seen, tracked: &Tracked) -> bool {
        // What misleads a scan makes it jump: odometry knows the spacing better.
        let step = match tracked.is_counted {
            true => Some(seen.motion),
            false => self.motion.speed.map(|(_, motion)| motion),
        };
        tracked.contradicts()
            && tracked.agreement.overlap() > WAITING_OVERLAP
            && step.is_some_and(|step| self.is_within(&step, CLOSE))
            && self.is_keyframe_within(LONGEST_WAIT)
    }

    /// Draws a scan into submap and grid. If it does not belong to the running submap, it begins
    /// another.
    pub(super) fn add_keyframe(&mut self, seen: Seen, tracked: &Tracked) {
        self.learn_odometry(tracked);
        let part = if seen.is_rolling() {
            ADDED_BY_SWEEP
        } else {
            ADDED
        };
        if tracked.is_loose || self.is_submap_full() {
            self.begin_submap(tracked.is_loose);
        }
        let at = self.local.pose;
        self.running.insert(moved(&seen.surfaces, at));
        let mut keyframe = self.keyframe_of(&seen.points, &seen.sigmas);
        keyframe.settle(&self.running);
        self.recent.push_back(Recent {
            submap_from_robot: at,
            surfaces: seen.surfaces,
        });
        while self.is_overlap_too_large() {
            self.recent.pop_front();
        }
        self.running_free.mark(keyframe.rays());
        let map_from_robot = self.map_from_running() * at;
        keyframe.draw(&mut self.grid, &map_from_robot);
        self.keyframes.push(keyframe);
        self.lay_walls();
        self.last_keyframe = Some(at);
        // While only odometry carries the pose on, the local covariance already covers the whole
        // motion since the last match.
        if !self.is_blind {
            let cov = std::mem::take(&mut self.local.cov);
            let is_firm = tracked.is_sure && tracked.is_counted && !self.gathering.is_at_work();
            self.way_cov += match tracked.found {
                Some(found) if is_firm => added(&cov, part, &found.verdict),
                _ => cov,
            };
        }
        if let Some(submap) = self.submaps.last_mut() {
            submap.own_keyframes += 1;
        }
    }

    /// Averages a sweep that is no keyframe into the walls that it hits. Its few beams, less
    /// certain the earlier they were taken, tell little alone, and only some sweeps are keyframes.
    /// With scans taken at one instant this was tried too: among people they bend walls more than
    /// they sharpen them.
    pub(super) fn sharpen_walls(&mut self, seen: &Seen) {
        self.running.sharpen(moved(&seen.surfaces, self.local.pose));
    }

    fn is_submap_full(&self) -> bool {
        let own = self.submaps.last().map_or(0, |s| s.own_keyframes);
        let way = self.local.pose.position().coords.length();
        own >= self.config.submap_keyframes || (own > 0 && way > self.config.submap_reach)
    }

    /// Whether the next submap would take over more than it may. It always takes over the last two:
    /// they tie it to the one before.
    fn is_overlap_too_large(&self) -> bool {
        let Some(first) = self.recent.front() else {
            return false;
        };
        let way = first.submap_from_robot.delta_to(&self.local.pose);
        let is_far = way.position().coords.length() > self.config.submap_reach;
        let kept = self.recent.len();
        kept > self.config.overlap_keyframes || (kept > 2 && is_far)
    }

    /// Whether the match constrains the motion forwards and sideways.
    fn sees(&self, tracked: &Tracked) -> [bool; 2] {
        [Vector2::x(), Vector2::y()].map(|axis| {
            let axis = self.local.pose.rotate(axis);
            tracked.found.is_some_and(|found| match found.verdict {
                Verdict::Degenerate { direction } => direction.dot(&axis).abs() < SEES,
                _ => true,
            })
        })
    }

    fn learn_odometry(&mut self, tracked: &Tracked) {
        let to_here = |last: Pose2| last.delta_to(&self.local.pose);
        let matched = self.last_keyframe.map(to_here);
        let is_sure = tracked.is_sure && !tracked.is_loose;
        let sees = self.sees(tracked);
        self.motion.keyframe(matched, is_sure, sees);
    }

    /// Begins a submap at the present pose; if `is_loose`, it takes nothing over from the last.
    pub(super) fn begin_submap(&mut self, is_loose: bool) {
        self.keep_for_refinement();
        if is_loose {
            self.recent.clear();
        }
        let old_from_new = self.local.pose;
        let map_from_submap = self.map_from_running() * old_from_new;
        let new_from_old = old_from_new.inverse();
        let begun = SurfelMap::new(self.config.surfels);
        let old = self.submaps.len() - 1;
        let [first, behind] = self.keyframes_of(old);
        for keyframe in &mut self.keyframes[first..behind] {
            keyframe.settle(&self.running);
        }
        let surfels = std::mem::replace(&mut self.running, begun).into_surfels();
        for recent in &mut self.recent {
            recent.submap_from_robot = new_from_old * recent.submap_from_robot;
            self.running
                .insert(moved(&recent.surfaces, recent.submap_from_robot));
        }
        self.motion.rebase(&new_from_old);
        let free = std::mem::take(&mut self.running_free);
        // Some of these may be keyframes of the submap before.
        for (keyframe, recent) in self.keyframes.iter().rev().zip(self.recent.iter().rev()) {
            let rays = keyframe.rays_from(&recent.submap_from_robot);
            self.running_free.mark(rays);
        }
        let closed = ClosedSubmap::new(surfels, free);
        if let Some(submap) = self.submaps.last_mut() {
            submap.closed = closed;
        }
        if self.is_blind || is_loose {
            self.way_cov += std::mem::take(&mut self.local.cov);
        }
        self.join_to_next(old, &old_from_new, map_from_submap);
        self.submaps
            .push(Submap::begun_at(map_from_submap, is_loose));
        self.local.pose = Pose2::identity();
        if self.config.close_loops {
            self.plan_comparisons(old);
        }
    }
}

/// What a match with this covariance adds to that of the motion through its submap: this part of
/// it, and all of it along the direction that the match does not observe.
fn added(cov: &Matrix3<f64>, part: f64, verdict: &Verdict) -> Matrix3<f64> {
    let Verdict::Degenerate { direction } = verdict else {
        return cov * part;
    };
    let free = direction.push(0.0);
    let along = free * free.transpose() * free.dot(&(cov * free));
    along + (cov - along) * part
}

fn moved(
    surfaces: &[OrientedPoint],
    to_from_robot: Pose2,
) -> impl Iterator<Item = OrientedPoint> + '_ {
    surfaces.iter().map(move |s| OrientedPoint {
        position: to_from_robot * s.position,
        normal: to_from_robot.rotate(s.normal),
    })
}
