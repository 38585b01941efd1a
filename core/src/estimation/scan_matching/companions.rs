//! People who walk along with the robot: where the walls do not tell how far the robot went, as in
//! a bare corridor, people moving with it suggest that it stands still, and all of their points
//! agree.
//!
//! In: what was seen, and a match that contradicts odometry. Out: the match of the rest, without
//! isolated objects, if the rest agrees with odometry as well as with that match.
//!
//! 1. A match is surprising if it lies farther from where the odometry of the last scans leads than
//!    a wheel bias could take it. From scan to scan, people pull the robot along only by little.
//! 2. What may walk is narrow, stands in front of what is seen on both sides of it, and faces the
//!    direction in question. A single moving object explains the whole surprise, however many
//!    points it has. If several contradict odometry in unison, the wheels have slipped.
//! 3. The rest decides: if it holds the robot in place, that is where the robot is. If it leaves
//!    the direction of travel open and agrees with odometry as well, the isolated objects have
//!    moved, and are left out of pose and map.

use nalgebra::Vector2;

use super::ScanMatcher;
use super::guesses::Guess;
use super::odometry_watch::Believed;
use super::seen::Seen;
use super::tracking::{Tried, gain};
use crate::geom::{Length, Pose2};
use crate::points::{Beam, LINK, are_linked};
use crate::registration::{Verdict, register};

/// A match is surprising if it is off by more than this, m, ...
const SURPRISE: f64 = 0.06;
/// ... plus this part of the distance travelled.
const SURPRISE_PART: f64 = 0.25;
/// An object wider than this, m, does not walk.
const WIDEST: f64 = 1.0;
/// Objects of fewer points are not judged.
const FEWEST: usize = 3;
/// Squared cosine between a direction and surface normals, averaged over an object: above this, the
/// object tells how far the robot moved in that direction.
const FACES: f64 = 0.3;
/// More objects than this do not move along at one pace.
const MOST: usize = 2;
/// The least cosine between the direction that the rest leaves open and the surprise.
const ALONG: f64 = 0.7;
/// The rest agrees with odometry as well as with the match if it loses no more than this part.
const AS_WELL: f64 = 0.03;

impl ScanMatcher {
    /// What was seen without people walking along, and its match; `None` if nobody seems to.
    pub(super) fn without_companions(
        &self,
        seen: &Seen,
        best: &Tried,
        guesses: &[Guess],
        moved: &Believed,
    ) -> Option<(Seen, Tried)> {
        let moved = moved.counted()?;
        let first = self.motion.pasts.front()?;
        let way = first.odom_from_robot.delta_to(&self.motion.odom_from_robot);
        let by_odometry = first.submap_from_robot * way;
        let found = &best.found.estimate.pose;
        let off = |pose: &Pose2| pose.position() - by_odometry.position();
        let surprise = off(found).length();
        let stands = moved.motion == Pose2::identity();
        let usual = SURPRISE + SURPRISE_PART * way.position().coords.length();
        if stands || surprise < usual || self.gathering.is_at_work() {
            return None;
        }
        let along = found.inverse().rotate(off(found) / surprise);
        let alone: Vec<Vec<usize>> = (things(&seen.points.beams).into_iter())
            .filter(|thing| faces(seen, thing, along))
            .collect();
        if alone.is_empty() || alone.len() > MOST {
            return None;
        }
        let rest = seen.without(&alone.concat());
        let turned = by_odometry.rotation();
        let scans = self.motion.pasts.len() as f64;
        let prior = self.prior_of(&Guess {
            pose: by_odometry,
            cov: turned * moved.cov * turned.transpose() * scans,
            penalty: 0.0,
        });
        let matching = &self.config.matching;
        let matched = register(&rest.surfaces, &self.running, &prior.pose, &prior, matching);
        let Verdict::Degenerate { direction } = matched.verdict else {
            return None;
        };
        if direction.dot(&found.rotate(along)).abs() < ALONG {
            return None;
        }
        let by_match = self.weighed(&rest.surfaces, best.found, guesses, true);
        let other = self.weighed(&rest.surfaces, matched, guesses, true);
        let goes_along = off(&matched.estimate.pose).length() < 0.5 * surprise;
        let gain = gain(&rest.surfaces, &by_match, &other);
        if !goes_along || gain < -AS_WELL * rest.surfaces.len() as f64 {
            return None;
        }
        Some((rest, other))
    }
}

/// Whether what was seen of an object tells how far the robot moved in direction `along`.
fn faces(seen: &Seen, thing: &[usize], along: Vector2<f64>) -> bool {
    let of_thing = seen.surfaces_of(thing);
    let squares = of_thing.map(|surface| {
        let cosine = surface.normal.dot(&along);
        cosine * cosine
    });
    let (sum, count) = squares.fold((0.0, 0), |(sum, count), square| (sum + square, count + 1));
    count >= FEWEST && sum > FACES * f64::from(count as u32)
}

/// The beams, as indices into the list, that end on isolated objects (step 2).
fn things(beams: &[Beam]) -> Vec<Vec<usize>> {
    let is_linked = |&a: &usize, &b: &usize| {
        let (a, b) = (&beams[a], &beams[b]);
        a.is_hit == b.is_hit && (!a.is_hit || are_linked(a, b))
    };
    let all: Vec<usize> = (0..beams.len()).collect();
    let groups: Vec<&[usize]> = all.chunk_by(is_linked).collect();
    // Objects stand in front of others by more than the spacing of their own points; where nothing
    // is seen, something may be just as near.
    let stands_before = |beam: &Beam, other: Option<&Beam>| {
        other.is_some_and(|other| !other.is_hit || beam.range + LINK < other.range)
    };
    let before = |group: &[usize]| group[0].checked_sub(1).and_then(|at| beams.get(at));
    let after = |group: &[usize]| beams.get(group[group.len() - 1] + 1);
    (groups.iter())
        .filter(|group| {
            let ends = [&beams[group[0]], &beams[group[group.len() - 1]]];
            group.len() >= FEWEST
                && ends[0].is_hit
                && (ends[0].end_in_robot - ends[1].end_in_robot).length() < WIDEST
                && stands_before(ends[0], before(group))
                && stands_before(ends[1], after(group))
        })
        .map(|group| group.to_vec())
        .collect()
}
