//! Odometry that fails: it hangs, catches up, or jumps.
//!
//! In: the motions that odometry counts, and where the scans were matched. Out: how much of it to
//! believe as the motion since the last match.
//!
//! 1. A driver that is late or lost repeats its last figures, to the last digit. So does the driver
//!    of a robot that stands still; the matches tell which it is. Odometry that hangs says nothing:
//!    to believe that the robot stands would hold each match back a little, and in a corridor
//!    altogether.
//! 2. What odometry counts when it catches up began where it began to hang.
//! 3. No robot is suddenly many times as fast as before, nor goes farther from where it stood than
//!    a robot can in that time. Such a jump is an error of the counter, or a motion that the
//!    matches already include: the robot is assumed to go on as before. In case it does not, the
//!    jump is still tried.

use std::collections::VecDeque;

use super::motion::Past;
use crate::geom::{Length, Pose2};
use crate::robot::{Odometry, Stamp};
use crate::snapshot::snapshot;

/// A robot that was matched farther than this, m and rad, from where its odometry says it stands is
/// in fact moving.
const HANGS_SHIFT: f64 = 0.25;
const HANGS_TURN: f64 = 0.2;
/// A motion is a jump if it is longer than this, m, ...
const JUMP: f64 = 0.2;
/// ... plus the longest of: this many times the distance at the previous speed, ...
const FASTER: f64 = 1.5;
/// ... the distance at the speed of a robot that starts, m/s, ...
const START: f64 = 1.5;
/// ... and this many times the longest of the previous motions.
const LONGER: f64 = 2.0;

/// How odometry behaved recently.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OdometryWatch {
    /// When odometry began to report no motion at all, to the last digit, and where the robot was
    /// last matched before that, in the running submap.
    stands_since: Option<(Stamp, Pose2)>,
    /// Whether the robot has been matched clearly elsewhere since.
    hangs: bool,
}

/// What to believe of odometry as a motion since the last match.
#[derive(Clone, Copy, Debug)]
pub(super) enum Believed {
    /// It is this motion.
    Counted(Odometry),
    /// Nothing. It may still be this motion, if odometry counted any.
    Failed(Option<Odometry>),
}

impl Believed {
    /// The motion, if it is believed.
    pub(super) fn counted(&self) -> Option<&Odometry> {
        match self {
            Self::Counted(odometry) => Some(odometry),
            Self::Failed(_) => None,
        }
    }
}

impl From<Option<Odometry>> for Believed {
    fn from(counted: Option<Odometry>) -> Self {
        counted.map_or(Self::Failed(None), Self::Counted)
    }
}

impl OdometryWatch {
    /// Takes bias-free odometry, where the robot was last matched, the previous scans, and the
    /// stamp of this one.
    pub(super) fn moved(
        &mut self,
        odometry: Odometry,
        here: &Pose2,
        pasts: &VecDeque<Past>,
        stamp: Stamp,
    ) -> Believed {
        if odometry.motion == Pose2::identity() {
            let last = pasts.back().map_or(stamp, |past| past.stamp);
            self.stands_since.get_or_insert((last, *here));
            return match self.hangs {
                true => Believed::Failed(None),
                false => Believed::Counted(odometry),
            };
        }
        let Self {
            stands_since,
            hangs,
        } = std::mem::take(self);
        match stands_since {
            Some((_, begin)) if hangs => Believed::Counted(counted_from(&begin, odometry, here)),
            Some((since, _)) if is_too_far(&odometry.motion, START * stamp.since(since)) => {
                Believed::Failed(Some(odometry))
            }
            // It may have hung where no match could tell.
            Some(_) => Believed::Counted(odometry),
            None if jumps(&odometry.motion, pasts, stamp) => Believed::Failed(Some(odometry)),
            None => Believed::Counted(odometry),
        }
    }

    /// Takes the next matched pose. Returns whether it shows that odometry hangs.
    pub(super) fn matched(&mut self, last: &Pose2, here: &Pose2) -> bool {
        let Some((since, begin)) = self.stands_since.filter(|_| !self.hangs) else {
            return false;
        };
        let is_beyond = |from: &Pose2| {
            let off = from.delta_to(here);
            off.position().coords.length() > HANGS_SHIFT || off.heading().abs() > HANGS_TURN
        };
        if is_beyond(last) {
            // A jump within one scan: the robot was carried off.
            self.stands_since = Some((since, *here));
        } else {
            self.hangs = is_beyond(&begin);
        }
        self.hangs
    }

    /// Another submap is the running one from here on.
    pub(super) fn rebase(&mut self, new_from_old: &Pose2) {
        let rebased = |(since, begin)| (since, *new_from_old * begin);
        self.stands_since = self.stands_since.map(rebased);
    }
}

/// The motion counted from `begin`, as a motion from `here`.
fn counted_from(begin: &Pose2, odometry: Odometry, here: &Pose2) -> Odometry {
    let here_from_begin = here.delta_to(begin);
    let turned = here_from_begin.rotation();
    Odometry {
        motion: here_from_begin * odometry.motion,
        cov: turned * odometry.cov * turned.transpose(),
        ..odometry
    }
}

/// Whether a robot with this motion would suddenly be many times as fast as before. Stamps jitter,
/// and several scans may have the same stamp, so the motion is also compared with those between
/// other scans.
fn jumps(motion: &Pose2, pasts: &VecDeque<Past>, stamp: Stamp) -> bool {
    let (Some(first), Some(last)) = (pasts.front(), pasts.back()) else {
        return false;
    };
    let steps = pasts.iter().zip(pasts.iter().skip(1));
    let ways = steps.map(|(a, b)| {
        let step = a.odom_from_robot.delta_to(&b.odom_from_robot);
        step.position().coords.length()
    });
    let (sum, longest) = ways.fold((0.0, 0.0), |(sum, longest), way| {
        (sum + way, f64::max(longest, way))
    });
    let seconds = last.stamp.since(first.stamp);
    let speed = if seconds > 0.0 { sum / seconds } else { 0.0 };
    let usual = seconds / (pasts.len() as f64 - 1.0).max(1.0);
    let most = (FASTER * speed).max(START) * stamp.since(last.stamp).max(usual);
    is_too_far(motion, most.max(LONGER * longest))
}

/// Whether a robot that can go `most` metres cannot have made this motion.
fn is_too_far(motion: &Pose2, most: f64) -> bool {
    motion.position().coords.length() > JUMP + most
}

snapshot!(OdometryWatch {
    stands_since,
    hangs,
});

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;

    const SCAN: u64 = 200_000;

    fn counted(motion: Pose2) -> Odometry {
        Odometry {
            motion,
            cov: Matrix3::from_diagonal(&nalgebra::Vector3::new(4e-4, 1e-4, 1e-4)),
            ..Odometry::standing(Stamp(0))
        }
    }

    /// A robot whose odometry is reported scan by scan.
    #[derive(Default)]
    struct Robot {
        watch: OdometryWatch,
        here: Pose2,
        odom: Pose2,
        pasts: VecDeque<Past>,
    }

    impl Robot {
        /// It moves, and odometry counts something; returns what is believed of that.
        fn moves(&mut self, motion: Pose2, odometry: Pose2) -> Believed {
            let stamp = Stamp(SCAN * (self.pasts.len() as u64 + 1));
            let last = self.here;
            let believed = (self.watch).moved(counted(odometry), &last, &self.pasts, stamp);
            (self.here, self.odom) = (self.here * motion, self.odom * odometry);
            self.watch.matched(&last, &self.here);
            self.pasts.push_back(Past {
                stamp,
                submap_from_robot: self.here,
                odom_from_robot: self.odom,
            });
            believed
        }
    }

    const STEP: f64 = 0.1;

    fn ahead(way: f64) -> Pose2 {
        Pose2::new(way, 0.0, 0.1 * way)
    }

    #[test]
    fn a_robot_that_stands_is_believed_to() {
        let mut robot = Robot::default();
        for number in 0..50 {
            // Scatter like that of matches.
            let jitter = Pose2::new(0.05, -0.05, 0.02);
            let moved = if number % 2 == 0 {
                jitter
            } else {
                jitter.inverse()
            };
            let believed = robot.moves(moved, Pose2::identity());
            assert!(believed.counted().is_some());
        }
        let believed = robot.moves(ahead(STEP), ahead(STEP));
        assert_eq!(believed.counted().unwrap().motion, ahead(STEP));
    }

    #[test]
    fn odometry_that_hangs_counts_nothing_and_then_from_where_it_began() {
        let mut robot = Robot::default();
        for _ in 0..5 {
            robot.moves(ahead(STEP), ahead(STEP));
        }
        let (begin, mut held) = (robot.here, Pose2::identity());
        let mut failed = 0;
        for _ in 0..20 {
            held = held * ahead(STEP);
            let believed = robot.moves(ahead(STEP), Pose2::identity());
            failed += usize::from(matches!(believed, Believed::Failed(None)));
        }
        // All but the first 0.25 m.
        assert_eq!(failed, 17);
        let here = robot.here;
        let believed = robot.moves(ahead(STEP), held * ahead(STEP));
        let moved = believed.counted().unwrap();
        // To where it is, with the uncertainty of the whole motion, as seen along its direction at
        // the end.
        let off = (here * moved.motion).minus(&robot.here);
        assert!(off.amax() < 1e-12, "{off}");
        let (at_begin, at_end) = (begin.rotation(), here.rotation());
        let of_begin = at_begin * counted(held).cov * at_begin.transpose();
        let of_end = at_end * moved.cov * at_end.transpose();
        assert!((of_begin - of_end).amax() < 1e-15);
        let believed = robot.moves(ahead(STEP), ahead(STEP));
        assert_eq!(believed.counted().unwrap().motion, ahead(STEP));
    }

    #[test]
    fn who_is_carried_off_while_standing_begins_anew() {
        let mut robot = Robot::default();
        robot.moves(Pose2::identity(), Pose2::identity());
        robot.moves(Pose2::new(3.0, 1.0, 2.0), Pose2::identity());
        for _ in 0..3 {
            let believed = robot.moves(Pose2::identity(), Pose2::identity());
            assert!(believed.counted().is_some());
        }
        let believed = robot.moves(ahead(STEP), ahead(STEP));
        assert_eq!(believed.counted().unwrap().motion, ahead(STEP));
    }

    #[test]
    fn who_stood_is_believed_to_have_gone_as_far_as_a_robot_goes_meanwhile() {
        for (way, is_believed) in [(5.0, true), (7.0, false), (100.0, false)] {
            let mut robot = Robot::default();
            // For four seconds.
            for _ in 0..20 {
                robot.moves(Pose2::identity(), Pose2::identity());
            }
            let believed = robot.moves(Pose2::identity(), Pose2::new(way, 0.0, 0.0));
            assert_eq!(believed.counted().is_some(), is_believed, "{way} m");
        }
    }

    #[test]
    fn a_jump_is_not_believed_but_the_start_of_a_robot_and_lost_scans_are() {
        let mut robot = Robot::default();
        // It starts.
        assert!(robot.moves(ahead(0.25), ahead(0.25)).counted().is_some());
        for _ in 0..8 {
            robot.moves(ahead(STEP), ahead(STEP));
        }
        let jumped = robot.moves(ahead(STEP), ahead(STEP + 0.6));
        let Believed::Failed(Some(odometry)) = jumped else {
            panic!("{jumped:?}");
        };
        assert_eq!(odometry.motion, ahead(STEP + 0.6));
        // Seven scans are lost.
        let stamp = robot.pasts.back().unwrap().stamp.0 + 8 * SCAN;
        let far = counted(ahead(8.0 * STEP));
        let (watch, pasts) = (&mut robot.watch, &robot.pasts);
        let believed = watch.moved(far, &robot.here, pasts, Stamp(stamp));
        assert!(believed.counted().is_some());
    }
}
