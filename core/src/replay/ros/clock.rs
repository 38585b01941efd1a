//! Puts all stamps on one clock.
//!
//! In: the stamps of scans and poses, and when each was recorded. Out: one time for each, ns, in
//! rising order.
//!
//! 1. A stamp says when something was measured, so it has priority. If it was not filled in, the
//!    time of recording is used.
//! 2. A lidar on a computer of its own may have another clock. Messages are recorded soon after
//!    they were stamped, so the least delay of each topic is the offset of its clock. If two
//!    offsets differ by more than delays do, the scans are shifted.
//! 3. A clock that goes back was set, or a simulation was restarted. Then the times of recording
//!    are used for all messages; if these go back as well, the rest is left out: it is another
//!    drive.

use super::choice::Chosen;
use crate::format::ros::RosLog;

/// A smaller step back is a delay, or messages in another order; ns.
const BACK: u64 = 1_000_000_000;
/// Two clocks that differ by less count as one; ns.
const SAME_CLOCK: i64 = 500_000_000;

/// Times of the chosen messages, each with its index in the log, rising.
#[derive(Debug, Default)]
pub(super) struct Times<'a> {
    /// When the first beam was taken, ns.
    pub(super) scans: Vec<(u64, usize)>,
    /// The time of the pose, ns.
    pub(super) poses: Vec<(u64, &'a crate::format::ros::RosPose)>,
}

/// Both times of a message, ns.
#[derive(Clone, Copy, Debug)]
struct Both {
    stamp: u64,
    recorded: u64,
}

pub(super) fn times<'a>(log: &RosLog, chosen: &Chosen<'a>, notes: &mut Vec<String>) -> Times<'a> {
    let numbers = chosen.scan_numbers(log);
    let scans = numbers.iter().filter_map(|&index| log.scans().get(index));
    let scans = scans.map(|scan| Both {
        stamp: scan.stamp,
        recorded: scan.recorded,
    });
    let poses = chosen.poses.iter().map(|pose| Both {
        stamp: pose.stamp,
        recorded: pose.recorded,
    });
    let (mut scans, mut poses): (Vec<Both>, Vec<Both>) = (scans.collect(), poses.collect());
    for (list, what) in [(&mut scans, "scans"), (&mut poses, "odometry")] {
        use_recorded_where_unset(list, what, notes);
    }
    align(&mut scans, &poses, notes);
    let back = goes_back(scans.iter().map(|both| both.stamp))
        .or_else(|| goes_back(poses.iter().map(|both| both.stamp)));
    if let Some(seconds) = back {
        notes.push(format!(
            "A clock goes back by {seconds:.1} s in the middle of the file: the times of recording are used instead of the stamps"
        ));
        for both in scans.iter_mut().chain(&mut poses) {
            both.stamp = both.recorded;
        }
        let end = [&scans, &poses]
            .into_iter()
            .filter_map(|list| first_back(list))
            .min();
        if let Some((at, count)) = end {
            notes.push(format!(
                "These go back as well, after {count} messages: another drive begins there, which is left out"
            ));
            for list in [&mut scans, &mut poses] {
                let keep = first_back(list).map_or(list.len(), |(_, count)| count);
                list.truncate(keep);
                // The last scan needs the motion up to its end.
                list.retain(|both| both.stamp <= at.saturating_add(BACK));
            }
        }
    }
    let mut times = Times {
        scans: scans.iter().map(|both| both.stamp).zip(numbers).collect(),
        poses: poses
            .iter()
            .map(|both| both.stamp)
            .zip(chosen.poses.iter().copied())
            .collect(),
    };
    times.scans.sort_by_key(|(time, _)| *time);
    times.poses.sort_by_key(|(time, _)| *time);
    times
}

fn use_recorded_where_unset(list: &mut [Both], what: &str, notes: &mut Vec<String>) {
    let unset = list.iter().filter(|both| both.stamp == 0).count();
    if unset == 0 {
        return;
    }
    for both in list.iter_mut().filter(|both| both.stamp == 0) {
        both.stamp = both.recorded;
    }
    notes.push(format!(
        "{unset} of the {what} have no stamp: the time when they were recorded is used"
    ));
}

/// Shifts the scans onto the clock of the poses.
fn align(scans: &mut [Both], poses: &[Both], notes: &mut Vec<String>) {
    let (Some(of_scans), Some(of_poses)) = (offset(scans), offset(poses)) else {
        return;
    };
    let ahead = of_scans.saturating_sub(of_poses);
    if ahead.abs() < SAME_CLOCK {
        return;
    }
    for both in scans {
        both.stamp = both.stamp.saturating_add_signed(ahead);
    }
    let seconds = ahead as f64 * 1e-9;
    notes.push(format!(
        "The clock of the lidar differs from that of the odometry by {seconds:.1} s: the scans are moved by as much"
    ));
}

/// The least delay from stamp to recording, ns.
fn offset(list: &[Both]) -> Option<i64> {
    let delays = list
        .iter()
        .map(|both| both.recorded.wrapping_sub(both.stamp) as i64);
    delays.min()
}

/// How far a time falls behind an earlier one at most, s; `None` if it is no more than reordering
/// explains.
fn goes_back(times: impl Iterator<Item = u64>) -> Option<f64> {
    let (mut newest, mut most) = (0, 0);
    for time in times {
        newest = time.max(newest);
        most = (newest - time).max(most);
    }
    (most > BACK).then_some(most as f64 * 1e-9)
}

/// The newest time before the first step back, and how many messages come before that step.
fn first_back(list: &[Both]) -> Option<(u64, usize)> {
    let mut newest = 0;
    for (index, both) in list.iter().enumerate() {
        if newest > both.stamp.saturating_add(BACK) {
            return Some((newest, index));
        }
        newest = both.stamp.max(newest);
    }
    None
}
