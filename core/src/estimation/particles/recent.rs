//! What was seen over the last metres, as one picture.
//!
//! In: scans, and the motion between them by odometry. Out: their beams in the current robot frame.
//! A single view of a corridor fits many places; what was seen on the way there fits few.
//!
//! The scans are joined by matching each to the previous ones ([`locate`], as in scan matching),
//! because odometry alone bends a picture of some metres until it fits nowhere. If a scan does not
//! fit after the motion that odometry reports, two others are tried: the robot stood still, or went
//! on as before.

use std::collections::VecDeque;

use nalgebra::{Matrix3, Point2};

use crate::bounds::config;
use crate::geom::{Length, Pose2, PoseEstimate, pose_cov};
use crate::map::{SurfelConfig, SurfelMap};
use crate::points::{OrientedPoint, Points, oriented_points};
use crate::registration::{LocateConfig, Prior, Registration, Verdict, locate};
use crate::robot::Odometry;

config! {
    /// What is kept of the last metres.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct RecentConfig {
        /// A scan is kept after this way, m. Default 0.3.
        pub way: f64 = 0.3,
        /// And after this turn, rad. Default 0.3.
        pub turn: f64 = 0.3,
        /// Scans from farther back than this are forgotten, m. Default 5; larger: surer where much
        /// looks alike, until odometry bends the picture.
        pub length: f64 = 5.0,
        /// Most scans. Default 24.
        pub most_scans: usize = 24,
        /// Most beams of a scan. Default 60.
        pub most_beams: usize = 60,
        /// How scans are matched to those before. Default [`LocateConfig::in_recent_scans`].
        pub locate: LocateConfig = LocateConfig::in_recent_scans(),
        /// Odometry is doubted where a smaller part of a scan than this lies among those before, 0
        /// to 1: the robot may have stood still, or gone on as before, and odometry come late.
        /// Default 0.7; larger is slower.
        pub doubted_below: f64 = 0.7,
        /// Points that have to lie among those before where odometry is not believed. Default 40:
        /// few points fit in many places.
        pub uncounted_points: usize = 40,
        /// How well a motion is known that nobody counted, m and rad: standard deviations. Default
        /// 0.15 and 0.15.
        pub uncounted_sigmas: [f64; 2] = [0.15, 0.15],
        /// Odometry is never believed better than this between two scans, m and rad: standard
        /// deviations. Default 0.02 and 0.02.
        pub odometry_sigmas: [f64; 2] = [0.02, 0.02],
    }
}

/// The start and the hit of a beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ray {
    pub(super) from: Point2<f64>,
    pub(super) to: Point2<f64>,
}

impl Ray {
    fn moved(&self, by: &Pose2) -> Self {
        Self {
            from: *by * self.from,
            to: *by * self.to,
        }
    }
}

/// Some beams with hits, evenly selected, robot frame.
pub(super) fn rays(points: &Points, most: usize) -> Vec<Ray> {
    let hits = points.beams.iter().filter(|beam| beam.is_hit);
    let every = hits.clone().count().div_ceil(most.max(1)).max(1);
    let ray = |beam: &crate::points::Beam| Ray {
        from: beam.origin_in_robot,
        to: beam.end_in_robot,
    };
    hits.step_by(every).map(ray).collect()
}

/// Scans of the last metres.
#[derive(Clone, Debug)]
pub(super) struct Recent {
    config: RecentConfig,
    scans: VecDeque<Kept>,
    /// Surfaces of the scans, in a local frame that is replaced from time to time.
    surfels: SurfelMap,
    /// Scans in `surfels` that are no longer kept.
    outdated: usize,
    /// The pose in that frame at the last scan, and odometry since then.
    local_from_robot: Pose2,
    moved: PoseEstimate,
    /// The motion between the last two scans, by matching.
    last_motion: Pose2,
    /// The pose at the last scan by matching alone, relative to the first one.
    matched: Pose2,
    /// Distance travelled, m, and rotation in either direction, rad, accumulated.
    gone: [f64; 2],
}

#[derive(Clone, Debug)]
struct Kept {
    local_from_robot: Pose2,
    gone: [f64; 2],
    rays: Vec<Ray>,
    surfaces: Vec<OrientedPoint>,
}

impl Kept {
    fn placed_surfaces(&self) -> impl Iterator<Item = OrientedPoint> + '_ {
        let at = self.local_from_robot;
        self.surfaces.iter().map(move |surface| OrientedPoint {
            position: at * surface.position,
            normal: at.rotate(surface.normal),
        })
    }
}

impl Recent {
    pub(super) fn new(config: RecentConfig) -> Self {
        Self {
            config,
            scans: VecDeque::new(),
            surfels: SurfelMap::new(SurfelConfig::default()),
            outdated: 0,
            local_from_robot: Pose2::identity(),
            moved: PoseEstimate::exact(Pose2::identity()),
            last_motion: Pose2::identity(),
            matched: Pose2::identity(),
            gone: [0.0; 2],
        }
    }

    pub(super) fn predict(&mut self, odometry: &Odometry) {
        self.moved = odometry.after(&self.moved);
        self.gone[0] += odometry.motion.position().coords.length();
        self.gone[1] += odometry.motion.heading().abs();
    }

    /// Takes a scan; returns whether it is kept, because it is far enough from the last.
    pub(super) fn push(&mut self, points: &Points) -> bool {
        let surfaces = oriented_points(points);
        let before = self.local_from_robot;
        self.place(&surfaces);
        self.matched = self.matched * before.delta_to(&self.local_from_robot);
        let [way, turn] = [self.config.way, self.config.turn];
        let is_due = self.scans.back().is_none_or(|last| {
            self.gone[0] - last.gone[0] >= way || self.gone[1] - last.gone[1] >= turn
        });
        if is_due {
            let kept = Kept {
                local_from_robot: self.local_from_robot,
                gone: self.gone,
                rays: rays(points, self.config.most_beams),
                surfaces,
            };
            self.surfels.insert(kept.placed_surfaces());
            self.scans.push_back(kept);
        }
        self.drop_old();
        is_due
    }

    /// Localises the robot among the surfels.
    fn place(&mut self, surfaces: &[OrientedPoint]) {
        let moved = std::mem::replace(&mut self.moved, PoseEstimate::exact(Pose2::identity()));
        let before = self.local_from_robot;
        self.local_from_robot = before * moved.pose;
        if self.surfels.surfels().is_empty() {
            return;
        }
        let [way, turn] = self.config.odometry_sigmas;
        let by_odometry = moved.cov + pose_cov(way, turn);
        let mut found = self.located(surfaces, &(before * moved.pose), &by_odometry);
        let overlap = |found: &Option<Registration>| found.map_or(0.0, |found| found.overlap);
        let locate = &self.config.locate;
        if overlap(&found) < self.config.doubted_below {
            let [way, turn] = self.config.uncounted_sigmas;
            for motion in [Pose2::identity(), self.last_motion] {
                let without = self.located(surfaces, &(before * motion), &pose_cov(way, turn));
                let is_seen = without.is_some_and(|w| w.inliers >= self.config.uncounted_points);
                if is_seen && overlap(&without) > overlap(&found) + locate.min_gain {
                    found = without;
                }
            }
        }
        if let Some(found) = found {
            self.local_from_robot = found.estimate.pose;
        }
        self.last_motion = before.delta_to(&self.local_from_robot);
    }

    /// Where surfaces match best near `pose`, whose covariance is `cov` in its own frame; `None` if
    /// there are too few.
    fn located(
        &self,
        surfaces: &[OrientedPoint],
        pose: &Pose2,
        cov: &Matrix3<f64>,
    ) -> Option<Registration> {
        let turned = pose.rotation();
        let cov = turned * cov * turned.transpose();
        let prior = Prior {
            pose: *pose,
            information: cov.try_inverse().unwrap_or_else(Matrix3::zeros),
        };
        let located = locate(surfaces, &self.surfels, &prior, 0, &self.config.locate);
        let found = *located.registration();
        (!matches!(found.verdict, Verdict::TooFewPoints { .. })).then_some(found)
    }

    fn drop_old(&mut self) {
        let (gone, config) = (self.gone[0], &self.config);
        let is_old = |kept: &Kept| gone - kept.gone[0] > config.length;
        while self.scans.len() > config.most_scans || self.scans.front().is_some_and(is_old) {
            self.scans.pop_front();
            self.outdated += 1;
        }
        if self.outdated > config.most_scans {
            self.begin_new_frame();
        }
    }

    /// Starts a new local frame at the robot, with the scans that are kept.
    fn begin_new_frame(&mut self) {
        let to = self.local_from_robot.inverse();
        self.local_from_robot = Pose2::identity();
        self.outdated = 0;
        self.surfels = SurfelMap::new(SurfelConfig::default());
        for kept in &mut self.scans {
            kept.local_from_robot = to * kept.local_from_robot;
            self.surfels.insert(kept.placed_surfaces());
        }
    }

    /// The pose at the last scan, relative to the start: odometry, corrected by matching each scan
    /// to the previous ones. It drifts too, but does not slip.
    pub(super) fn matched(&self) -> Pose2 {
        self.matched
    }

    /// Forgets earlier scans, because they say nothing about where the robot is now.
    pub(super) fn forget(&mut self) {
        self.scans.clear();
        self.begin_new_frame();
    }

    /// The distance that the scans span, m.
    pub(super) fn way(&self) -> f64 {
        let first = self.scans.front();
        first.map_or(0.0, |first| self.gone[0] - first.gone[0])
    }

    /// All beams, in the frame of the robot at the last scan; the newest scan first.
    pub(super) fn rays(&self) -> impl Iterator<Item = Ray> + '_ {
        let robot_from_local = self.local_from_robot.inverse();
        self.scans.iter().rev().flat_map(move |kept| {
            let robot_from_then = robot_from_local * kept.local_from_robot;
            kept.rays.iter().map(move |ray| ray.moved(&robot_from_then))
        })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;
    use crate::geom::Segment;
    use crate::points::fixture::look;
    use crate::robot::Stamp;

    /// A room of 6 x 4 m, seen all round.
    fn seen_from(at: &Pose2) -> Points {
        let corners = [[-2.0, -1.5], [4.0, -1.5], [4.0, 2.5], [-2.0, 2.5]].map(Point2::from);
        let walls = [0, 1, 2, 3].map(|i| Segment::new(corners[i], corners[(i + 1) % 4]));
        look(&walls, at, 20.0)
    }

    fn moved(motion: Pose2, sigma: f64) -> Odometry {
        Odometry {
            motion,
            cov: Matrix3::from_diagonal_element(sigma * sigma),
            ..Odometry::standing(Stamp(0))
        }
    }

    #[test]
    fn the_picture_is_straight_where_odometry_is_bent() {
        let mut recent = Recent::new(RecentConfig::default());
        let mut pose = Pose2::new(-1.0, -0.5, 0.0);
        let step = Pose2::new(0.1, 0.0, 0.05);
        for _ in 0..40 {
            // Bent by 0.15 rad/m: after 4 m it is off by more than a metre.
            recent.predict(&moved(Pose2::new(0.1, 0.0, 0.065), 0.02));
            pose = pose * step;
            recent.push(&seen_from(&pose));
        }
        assert!(recent.scans.len() > 5);
        let on_wall = |p: Vector2<f64>| {
            let off = [
                (p.x + 2.0).abs(),
                (p.x - 4.0).abs(),
                (p.y + 1.5).abs(),
                (p.y - 2.5).abs(),
            ];
            off.into_iter().fold(f64::INFINITY, f64::min)
        };
        for ray in recent.rays() {
            let off = on_wall((pose * ray.to).coords);
            assert!(off < 0.05, "{off}");
        }
        assert!(recent.way() > 2.0);
        recent.forget();
        assert_eq!((recent.rays().count(), recent.way()), (0, 0.0));
    }

    /// For five scans odometry says that the robot stands, then it reports the whole motion at
    /// once.
    #[test]
    fn odometry_that_comes_late_is_not_counted_twice() {
        let mut recent = Recent::new(RecentConfig::default());
        let begin = Pose2::new(-1.0, -0.5, 0.0);
        let mut pose = begin;
        let step = Pose2::new(0.15, 0.02, 0.1);
        let mut behind = Pose2::identity();
        for scan in 0..14 {
            if scan > 0 {
                pose = pose * step;
                behind = behind * step;
            }
            let is_late = (5..10).contains(&scan);
            let counted = match is_late {
                true => Pose2::identity(),
                false => std::mem::replace(&mut behind, Pose2::identity()),
            };
            recent.predict(&moved(counted, 0.02));
            recent.push(&seen_from(&pose));
            let off = begin.delta_to(&pose).delta_to(&recent.matched());
            assert!(off.position().coords.length() < 0.02, "{scan}: {off:?}");
            assert!(off.heading().abs() < 0.02, "{scan}: {off:?}");
        }
    }

    #[test]
    fn only_the_last_metres_are_kept_and_of_a_standing_robot_one_scan() {
        let mut recent = Recent::new(RecentConfig::default());
        for _ in 0..10 {
            recent.push(&seen_from(&Pose2::identity()));
        }
        assert_eq!(recent.scans.len(), 1);
        // Back and forth over a metre.
        let way = |i: i32| 0.1 * f64::from(10 - (i % 20 - 10).abs());
        for i in 0..200 {
            let by = way(i + 1) - way(i);
            recent.predict(&moved(Pose2::new(by, 0.0, 0.0), 0.01));
            recent.push(&seen_from(&Pose2::new(way(i + 1), 0.0, 0.0)));
        }
        let config = recent.config;
        assert!(recent.way() <= config.length && recent.way() > config.length - 0.5);
        assert!(recent.scans.len() <= config.most_scans);
        assert!(recent.outdated <= config.most_scans);
    }
}
