//! What the tracks counted between the scans of a drive.

use crate::estimation::odometry_fit::OdometryFitError;
use crate::geom::{Length, Pose2};
use crate::robot::Odometry;

/// Motions are combined up to this distance, m, and rotation, rad: small enough that an arc stays
/// the same motion.
const STEP: [f64; 2] = [0.02, 0.03];
/// A leg ends at the first scan after this distance, m, or rotation, rad.
const LEG: [f64; 2] = [0.25, 0.35];
/// A turn counts from this angle on, rad: below it a heading only wavers.
const TURN: f64 = 0.02;

/// What was counted between two scans, in small motions.
#[derive(Clone, Debug, Default)]
struct Interval {
    steps: Vec<Odometry>,
    /// Whether time was missed, or the robot may have been carried.
    is_broken: bool,
}

/// What the tracks of a robot counted in a drive, scan by scan.
#[derive(Clone, Debug, Default)]
pub struct Drive {
    /// What was counted before each scan.
    scans: Vec<Interval>,
    /// Since the last scan.
    now: Interval,
    extent: DriveExtent,
}

/// How much was driven.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DriveExtent {
    /// Distance, forwards and backwards, m.
    pub way: f64,
    /// Turned to the left, rad.
    pub left: f64,
    /// Turned to the right, rad.
    pub right: f64,
}

impl DriveExtent {
    /// Rotation in both directions, rad.
    #[must_use]
    pub fn turned(&self) -> f64 {
        self.left + self.right
    }
}

/// The motion from one reference pose to a later one.
#[derive(Clone, Debug)]
pub(super) struct Leg {
    pub(super) steps: Vec<Odometry>,
    /// The motion by the reference poses.
    pub(super) by_poses: Pose2,
}

impl Drive {
    /// Takes the next motion.
    pub fn odometry(&mut self, motion: &Odometry) {
        self.extent.take(&motion.motion);
        match self.now.steps.last_mut() {
            Some(last) if is_small(&(last.motion * motion.motion)) => *last = last.then(motion),
            _ => self.now.steps.push(*motion),
        }
    }

    /// The recording has a gap: the robot may be elsewhere now.
    pub fn gap(&mut self) {
        self.now.is_broken = true;
    }

    /// A scan was taken here: its pose will be known.
    pub fn scan(&mut self) {
        self.scans.push(std::mem::take(&mut self.now));
    }

    /// Scans so far.
    #[must_use]
    pub fn scans(&self) -> usize {
        self.scans.len()
    }

    /// How much was driven.
    #[must_use]
    pub fn extent(&self) -> DriveExtent {
        self.extent
    }

    /// Legs between poses that lie far enough apart; none where the drive was interrupted.
    pub(super) fn legs(&self, poses: &[Pose2]) -> Result<Vec<Option<Leg>>, OdometryFitError> {
        if poses.len() != self.scans.len() {
            return Err(OdometryFitError::Poses {
                poses: poses.len(),
                scans: self.scans.len(),
            });
        }
        if let Some(scan) = poses.iter().position(|pose| !pose.is_finite()) {
            return Err(OdometryFitError::NotFinite { scan });
        }
        let mut legs = vec![];
        let mut begin: Option<Pose2> = None;
        let (mut steps, mut run) = (vec![], DriveExtent::default());
        for (interval, pose) in self.scans.iter().zip(poses) {
            let Some(from) = begin.filter(|_| !interval.is_broken) else {
                // The first scan, or the first after a gap: start a leg.
                legs.extend(begin.map(|_| None));
                begin = Some(*pose);
                (steps, run) = (vec![], DriveExtent::default());
                continue;
            };
            for step in &interval.steps {
                run.take(&step.motion);
                steps.push(*step);
            }
            if run.way >= LEG[0] || run.turned() >= LEG[1] {
                legs.push(Some(Leg {
                    steps: std::mem::take(&mut steps),
                    by_poses: from.delta_to(pose),
                }));
                run = DriveExtent::default();
                begin = Some(*pose);
            }
        }
        Ok(legs)
    }
}

impl DriveExtent {
    fn take(&mut self, motion: &Pose2) {
        self.way += motion.position().coords.length();
        let turn = motion.heading();
        if turn > 0.0 {
            self.left += turn;
        } else {
            self.right -= turn;
        }
    }

    /// Whether there was a noticeable turn.
    pub(super) fn has_turned(&self) -> bool {
        self.turned() > TURN
    }
}

fn is_small(motion: &Pose2) -> bool {
    motion.position().coords.length() <= STEP[0] && motion.heading().abs() <= STEP[1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Stamp;
    use nalgebra::Matrix3;

    fn motion(x: f64, turn: f64) -> Odometry {
        Odometry {
            from: Stamp(0),
            to: Stamp(1),
            motion: Pose2::new(x, 0.0, turn),
            cov: Matrix3::zeros(),
        }
    }

    /// Scans every 0.1 m along a line.
    fn straight(scans: usize) -> (Drive, Vec<Pose2>) {
        let mut drive = Drive::default();
        for _ in 0..scans {
            for _ in 0..10 {
                drive.odometry(&motion(0.01, 0.0));
            }
            drive.scan();
        }
        let poses = (0..scans).map(|i| Pose2::new(0.1 * i as f64, 0.0, 0.0));
        (drive, poses.collect())
    }

    #[test]
    fn legs_end_at_scans_and_hold_all_that_was_counted() {
        let (drive, poses) = straight(10);
        let legs: Vec<Leg> = drive.legs(&poses).unwrap().into_iter().flatten().collect();
        assert_eq!(legs.len(), 3);
        for leg in &legs {
            let counted: f64 = leg.steps.iter().map(|step| step.motion.x()).sum();
            assert!((counted - 0.3).abs() < 1e-12 && (leg.by_poses.x() - 0.3).abs() < 1e-12);
        }
        // Two centimetres per step.
        assert_eq!(legs[0].steps.len(), 15);
        assert!((drive.extent().way - 1.0).abs() < 1e-12);
    }

    #[test]
    fn no_leg_crosses_a_gap() {
        let (mut drive, mut poses) = straight(5);
        drive.gap();
        for _ in 0..4 {
            drive.odometry(&motion(0.1, 0.0));
            drive.scan();
        }
        poses.extend((0..4).map(|i| Pose2::new(7.0 + 0.1 * f64::from(i), 0.0, 0.0)));
        let legs = drive.legs(&poses).unwrap();
        let lengths: Vec<_> = legs
            .iter()
            .map(|leg| leg.as_ref().map(|leg| (10.0 * leg.by_poses.x()).round()))
            .collect();
        assert_eq!(lengths, [Some(3.0), None, Some(3.0)]);
    }

    #[test]
    fn poses_that_are_none_are_told() {
        let (drive, mut poses) = straight(3);
        poses[1] = Pose2::new(f64::NAN, 0.0, 0.0);
        assert!(matches!(
            drive.legs(&poses),
            Err(OdometryFitError::NotFinite { scan: 1 })
        ));
        assert!(matches!(
            drive.legs(&poses[1..]),
            Err(OdometryFitError::Poses { poses: 2, scans: 3 })
        ));
    }
}
