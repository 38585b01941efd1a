//! Whether the robot still stands where it was left: compares what it sees first in a run with what
//! it saw there.
//!
//! In: the first scan and where it was matched, and what was seen last before it. Out: whether the
//! robot stands there.
//!
//! 1. The scan is compared with the map: what now stands in space that was seen free has come
//!    since. Conversely, the last keyframe is compared with the scan: what stood in space that the
//!    scan sees through has gone. People come or go, and contradict in one of the two comparisons;
//!    all that differs because the robot was carried contradicts in both. Together, as much must
//!    agree as for any scan that surely lies where it was matched.
//! 2. The match finds a pose near by, and surfaces parallel to the motion support it: the walls of
//!    an aisle agree wherever along it the robot is. So the whole remembered map is searched for a
//!    place where the scan fits better: that is where the robot was carried.
//! 3. If no part of the scan constrains the position along the walls, nothing in it shows that the
//!    robot stood still.
//!
//! Few beams gathered over a stretch of motion show too little for this test; they only have to lie
//! on the map.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Point2};

use super::super::agreement::Agreement;
use super::super::free_space::FreeSpace;
use super::ScanMatcher;
use super::seen::Seen;
use super::tracking::{CONTRADICTION, FULL_SCAN, LIKELIER, SURE_PART, Tracked};
use crate::map::SurfelMap;
use crate::points::OrientedPoint;
use crate::registration::{Prior, SearchWindow, Verdict, search_and_match};

/// At least this part of the first scan has to lie on what was seen there.
const LEFT_OVERLAP: f64 = 0.3;

impl ScanMatcher {
    /// Whether the first scan of a run shows that the robot stands where it was left.
    pub(super) fn begins_here(&self, seen: &Seen, tracked: &Tracked) -> bool {
        let lies_there = !tracked.is_loose && tracked.agreement.overlap() >= LEFT_OVERLAP;
        if !lies_there || self.gathering.is_at_work() {
            return lies_there;
        }
        let is_open = |verdict| matches!(verdict, Verdict::Degenerate { .. });
        tracked.found.is_some_and(|found| !is_open(found.verdict))
            && self.agrees_both_ways(seen, tracked)
            && !self.fits_better_elsewhere(seen, tracked)
    }

    fn agrees_both_ways(&self, seen: &Seen, tracked: &Tracked) -> bool {
        let Some(last) = self.recent.back() else {
            return false;
        };
        let at = tracked.estimate.pose;
        let mut map = SurfelMap::new(self.config.surfels);
        map.insert(seen.surfaces.iter().map(|surface| OrientedPoint {
            position: at * surface.position,
            normal: at.rotate(surface.normal),
        }));
        let mut free = FreeSpace::default();
        free.mark(self.keyframe_of(&seen.points, &seen.sigmas).rays_from(&at));
        let back = Agreement::of(&last.surfaces, &last.submap_from_robot, &map, &free);
        let both = Agreement {
            agree: tracked.agreement.agree + back.agree,
            contradict: tracked.agreement.contradict + back.contradict,
            total: tracked.agreement.total + back.total,
        };
        both.part() >= SURE_PART
    }

    /// Whether the scan fits better at another place that the running submap may show.
    fn fits_better_elsewhere(&self, seen: &Seen, tracked: &Tracked) -> bool {
        let window = SearchWindow {
            shift: self.config.submap_reach,
            turn: PI,
        };
        let anywhere = Prior {
            pose: self.local.pose,
            information: Matrix3::zeros(),
        };
        let (surfaces, pivot, target) = (&seen.surfaces, Point2::origin(), &self.running);
        let (search, matching) = (&self.config.search, &self.config.matching);
        let found = search_and_match(
            surfaces, pivot, target, &anywhere, &window, search, matching,
        );
        let worth = |agreement: &Agreement| {
            let [agree, contradict] = [agreement.agree, agreement.contradict].map(|n| n as f64);
            agree - CONTRADICTION * contradict
        };
        let least = LIKELIER * (surfaces.len() as f64).max(FULL_SCAN);
        found.is_some_and(|found| {
            let pose = found.estimate.pose;
            let there = Agreement::of(surfaces, &pose, target, &self.running_free);
            worth(&there) > worth(&tracked.agreement) + least
        })
    }
}
