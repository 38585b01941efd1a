//! Damage as in logs of others, applied to the recorded logs.

use std::f64::consts::PI;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use slamlab_core::format::carmen::{BeamFan, CarmenLog};
use slamlab_core::geom::{Length, Pose2};
use slamlab_core::robot::Scan;

/// Mean numbers of consecutive scans that are kept, and that are lost.
const KEPT: f64 = 90.0;
const LOST: f64 = 10.0;
/// Factor by which the reported distances are too long, and false turn per metre, rad.
const SCALE: f64 = 1.1;
const BEND: f64 = 5.0 * PI / 180.0;
/// Number of beams that are left, every how many-th, and their range, m.
const FEW_BEAMS: usize = 11;
const EVERY: usize = 18;
const REACH: f32 = 5.0;

/// The damage to a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Damage {
    /// Nothing.
    Whole,
    /// All poses are zero; the laser stays where it sits on the robot.
    WithoutOdometry,
    /// Only every third scan is left.
    Third,
    /// A tenth of the scans is lost, in bursts.
    Bursts,
    /// The wheels report distances a tenth too long, and a false turn of 5° per metre.
    Bent,
    /// Of 180 beams 11 are left, every 18th, with a range of 5 m.
    ElevenBeams,
}

impl Damage {
    /// The suffix of a row's name.
    pub(super) fn suffix(self) -> &'static str {
        match self {
            Self::Whole => "",
            Self::WithoutOdometry => "-without-odometry",
            Self::Third => "-third",
            Self::Bursts => "-bursts",
            Self::Bent => "-bent",
            Self::ElevenBeams => "-11-beams",
        }
    }

    /// Applies it.
    pub(super) fn apply(self, mut log: CarmenLog) -> CarmenLog {
        match self {
            Self::Whole => {}
            Self::WithoutOdometry => {
                for scan in &mut log.scans {
                    scan.odom_from_robot = Pose2::identity();
                }
            }
            Self::Third => log.scans = log.scans.into_iter().step_by(3).collect(),
            Self::Bursts => lose_bursts(&mut log),
            Self::Bent => bend(&mut log),
            Self::ElevenBeams => return with_few_beams(&log),
        }
        log
    }
}

/// The lost scans are the same in every run.
fn lose_bursts(log: &mut CarmenLog) {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut length = |mean: f64| (-mean * libm::log(1.0 - rng.random::<f64>())) as usize + 1;
    let (mut is_kept, mut left) = (true, length(KEPT));
    log.scans.retain(|_| {
        if left == 0 {
            is_kept = !is_kept;
            left = length(if is_kept { KEPT } else { LOST });
        }
        left -= 1;
        is_kept
    });
}

fn bend(log: &mut CarmenLog) {
    let mut bent = Pose2::identity();
    let mut last = None;
    for scan in &mut log.scans {
        let odom_from_robot = scan.odom_from_robot;
        let motion = last.map_or_else(Pose2::identity, |last: Pose2| {
            last.delta_to(&odom_from_robot)
        });
        let turn = motion.heading() + BEND * motion.position().coords.length();
        bent = bent * Pose2::new(SCALE * motion.x(), SCALE * motion.y(), turn);
        last = Some(odom_from_robot);
        scan.odom_from_robot = bent;
    }
}

/// The last of the 11, straight to the left, takes the reading 1° beside it, because 180 beams have
/// none there.
fn with_few_beams(log: &CarmenLog) -> CarmenLog {
    let fan = BeamFan::half_circle(FEW_BEAMS);
    let mut few = CarmenLog::empty();
    for scan in &log.scans {
        let whole = log.scan(scan);
        let last = whole.ranges.len().saturating_sub(1);
        let range = |beam: usize| match whole.ranges.get(last.min(beam * EVERY)) {
            Some(range) if *range >= REACH => f32::INFINITY,
            Some(range) => *range,
            None => f32::NAN,
        };
        let beams = 0..FEW_BEAMS;
        let bearing = |beam| fan.first + beam as f64 * fan.step;
        let scan_of_few = Scan {
            bearings: beams.clone().map(bearing).collect(),
            ranges: beams.map(range).collect(),
            sigmas: vec![],
            ..whole
        };
        few.push(scan.ipc_seconds, &scan.odom_from_robot, &scan_of_few);
    }
    few
}
