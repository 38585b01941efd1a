//! Scans of few beams, gathered over a stretch of motion until they show surfaces.
//!
//! In: scans whose neighbouring beams lie too far apart to hit one surface, and the odometry
//! between them. Out: one set of points for some distance or rotation, in the robot frame at its
//! end, to be matched like a scan.
//!
//! Source: Latif & Saarinen (2015), "SLAM with sparse sensing"; Zhang et al. (2021),
//! "Sparse-GSLAM": multiscans.

use std::collections::VecDeque;

use nalgebra::Point2;

use super::seen::Seen;
use crate::geom::{Length, Pose2};
use crate::points::Points;
use crate::robot::{Odometry, Stamp};
use crate::snapshot::snapshot;

/// Neighbouring beams farther apart than this, rad, seldom hit one surface.
const SPARSE: f64 = 0.08;
/// Scans are gathered over this distance, m, or this rotation, rad.
const WAY: f64 = 0.3;
const TURN: f64 = 0.4;
/// A scan taken nearer to the last one than this, m and rad, is left out.
const STILL: f64 = 0.01;
const STILL_TURN: f64 = 0.01;

/// The number of earlier points that help to detect surfaces.
const BEFORE: usize = 100;

/// Scans of few beams that wait for more.
#[derive(Clone, Debug, Default)]
pub(super) struct Gathering {
    is_sparse: bool,
    has_begun: bool,
    /// The motion since the last match.
    pub(super) moved: Option<Odometry>,
    way: f64,
    turn: f64,
    scans: Vec<Gathered>,
    last: Option<Pose2>,
    /// Points seen before, in the robot frame at the last match, the newest last.
    before: VecDeque<Point2<f64>>,
    /// When and where scans were taken, in the robot frame at the last match.
    places: Vec<(Stamp, Pose2)>,
}

#[derive(Clone, Debug)]
struct Gathered {
    start_from_robot: Pose2,
    points: Points,
    sigmas: Vec<f64>,
    /// The motion up to it, as a fraction of what is enough.
    gone: f64,
}

/// What was gathered, in the robot frame at its end.
pub(super) struct Complete {
    pub(super) seen: Seen,
    pub(super) moved: Option<Odometry>,
    /// When and where the scans before the last were taken, in the same frame.
    pub(super) places: Vec<(Stamp, Pose2)>,
}

impl Gathering {
    /// Whether the sensor has so few beams that its scans are to be gathered.
    pub(super) fn is_sparse(&mut self, points: &Points) -> bool {
        if let Some(spacing) = points.beam_spacing() {
            self.is_sparse = spacing > SPARSE;
        }
        self.is_sparse
    }

    /// Whether the last scan was gathered.
    pub(super) fn is_at_work(&self) -> bool {
        self.is_sparse
    }

    /// Takes a scan and the motion since the previous one.
    pub(super) fn push(&mut self, points: &Points, sigmas: &[f64], moved: Option<Odometry>) {
        if let Some(moved) = moved {
            self.way += moved.motion.position().coords.length();
            self.turn += moved.motion.heading().abs();
            self.moved = Some(match self.moved {
                Some(so_far) => so_far.then(&moved),
                None => moved,
            });
        }
        let here = self.here();
        let is_still = self.last.is_some_and(|last| {
            let off = last.delta_to(&here);
            off.position().coords.length() < STILL && off.heading().abs() < STILL_TURN
        });
        if !is_still {
            self.last = Some(here);
            self.scans.push(Gathered {
                start_from_robot: here,
                points: points.clone(),
                sigmas: sigmas.to_vec(),
                gone: self.gone(),
            });
        }
        self.places.push((points.stamp, here));
    }

    /// The current pose in the robot frame at the last match.
    pub(super) fn here(&self) -> Pose2 {
        self.moved
            .map_or_else(Pose2::identity, |moved| moved.motion)
    }

    /// Whether enough was gathered. The very first scan is enough: the robot needs a map before it
    /// moves.
    pub(super) fn is_enough(&self) -> bool {
        !self.has_begun || self.moved.is_none() || self.way >= WAY || self.turn >= TURN
    }

    /// The distance and rotation since the last match, as a fraction of what is enough.
    fn gone(&self) -> f64 {
        self.way / WAY + self.turn / TURN
    }

    /// Returns what was gathered, and starts anew.
    pub(super) fn take(&mut self) -> Option<Complete> {
        let (stamp, _) = *self.places.last()?;
        let end_from_start = self.here().inverse();
        let gone = self.gone();
        let begun = Self {
            is_sparse: self.is_sparse,
            has_begun: true,
            ..Self::default()
        };
        let before: Vec<Point2<f64>> = (self.before.iter())
            .map(|place| end_from_start * *place)
            .collect();
        let Self {
            moved,
            scans,
            mut places,
            ..
        } = std::mem::replace(self, begun);
        let mut gathered = Points {
            stamp,
            beams: vec![],
            ..scans.last()?.points
        };
        let (mut sigmas, mut left) = (vec![], vec![]);
        for scan in &scans {
            let end_from_robot = end_from_start * scan.start_from_robot;
            gathered.sensor_in_robot = end_from_robot * scan.points.sensor_in_robot;
            gathered.beams.extend(
                scan.points
                    .beams
                    .iter()
                    .map(|beam| beam.moved(&end_from_robot)),
            );
            sigmas.extend(&scan.sigmas);
            if gone > 0.0 {
                left.extend(scan.points.beams.iter().map(|_| 1.0 - scan.gone / gone));
            }
        }
        self.before.extend(&before);
        self.before
            .extend(gathered.hits().map(|beam| beam.end_in_robot));
        self.before
            .drain(..self.before.len().saturating_sub(BEFORE));
        places.pop();
        for (_, place) in &mut places {
            *place = end_from_start * *place;
        }
        Some(Complete {
            seen: Seen::gathered(gathered, sigmas, end_from_start.inverse(), left, &before),
            moved,
            places,
        })
    }
}

snapshot!(Gathering {
    is_sparse,
    has_begun,
    moved,
    way,
    turn,
    scans,
    last,
    before,
    places,
});
snapshot!(
    Gathered {
        start_from_robot,
        points,
        sigmas,
        gone
    },
    |scan| scan.sigmas.len() == scan.points.beams.len(),
    "there are not as many standard deviations as beams"
);
