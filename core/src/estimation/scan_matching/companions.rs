//! Who walks along: where the walls do not say how far the robot went, as down a bare corridor,
//! people who go with it say that it stands, and all of their points agree.
//!
//! In: what was seen, and a match that odometry speaks against. Out: the match of the rest, without
//! what stands alone, if the rest goes with odometry as well as it goes with that match.
//!
//! 1. A match is surprising that lies farther from where odometry of the last scans leads than a
//!    bias of wheels would take it. Scan by scan, people carry the robot along by little.
//! 2. What may walk is narrow, stands before what is seen on both sides of it, and faces the way
//!    in question. One thing that moves explains the whole surprise, however many points it has.
//!    Where several speak against odometry, all as one, the wheels have slipped.
//! 3. The rest decides: where it holds the robot in place, that is where it is. Where it leaves the
//!    way open and goes with odometry as well, what stands alone has moved, and is left out of pose
//!    and map.

use nalgebra::Vector2;

use super::ScanMatcher;
use super::guesses::Guess;
use super::odometry_watch::Believed;
use super::seen::Seen;
use super::tracking::{Tried, gain};
use crate::geom::{Length, Pose2};
use crate::points::{Beam, LINK, are_linked};
use crate::registration::{Verdict, register};

/// A match is surprising beyond this, m, ...
const SURPRISE: f64 = 0.06;
/// ... and this part of the way.
const SURPRISE_PART: f64 = 0.25;
/// What is wider, m, does not walk.
const WIDEST: f64 = 1.0;
/// Things of fewer points are not judged.
const FEWEST: usize = 3;
/// Cosine, squared, between a direction and a normal of what tells how far the robot went that way;
/// the mean of a thing.
const FACES: f64 = 0.3;
/// More than this many do not go along at one pace.
const MOST: usize = 2;
/// Cosine between the direction that the rest leaves open and the surprise, at least.
const ALONG: f64 = 0.7;
/// The rest goes with odometry as well as with the match if it loses no more than this part.
const AS_WELL: f64 = 0.03;

impl ScanMatcher {
    /// What was seen without those who walk along, and its match; `None` where nobody seems to.
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

/// Whether what was seen of a thing tells how far the robot went along this direction of its.
fn faces(seen: &Seen, thing: &[usize], along: Vector2<f64>) -> bool {
    let of_thing = seen.surfaces_of(thing);
    let squares = of_thing.map(|surface| {
        let cosine = surface.normal.dot(&along);
        cosine * cosine
    });
    let (sum, count) = squares.fold((0.0, 0), |(sum, count), square| (sum + square, count + 1));
    count >= FEWEST && sum > FACES * f64::from(count as u32)
}

/// The beams, by their places in the list, that end on things that stand alone (step 2).
fn things(beams: &[Beam]) -> Vec<Vec<usize>> {
    let is_linked = |&a: &usize, &b: &usize| {
        let (a, b) = (&beams[a], &beams[b]);
        a.is_hit == b.is_hit && (!a.is_hit || are_linked(a, b))
    };
    let all: Vec<usize> = (0..beams.len()).collect();
    let groups: Vec<&[usize]> = all.chunk_by(is_linked).collect();
    // Things stand before others by more than their own points are apart; what is not seen there
    // at all may be as near.
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
