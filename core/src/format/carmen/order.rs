//! The order in which scans were taken, where their stamps run backwards.
//!
//! In: scans in the order of the file. Out: the same in the order in which they were taken, with
//! times that never run backwards.
//!
//! 1. If a recorder hears several senders, it writes messages as they arrive: then the stamps are
//!    right and the order of the file is not. If a sender's clock jitters, the stamps are wrong and
//!    the order of the file is right. Consecutive scans look alike, so the order with smaller
//!    differences between neighbours is taken; if both are equal, that of the stamps.
//! 2. Where the order of the file is right, the longest non-decreasing run of stamps is kept, and
//!    the others are spread between their neighbours in it.

use super::CarmenScan;

/// How many readings of each scan are compared.
const COMPARED: usize = 60;
/// Differences of readings are cut off at this, m: an open door says no more than that scans
/// differ.
const MOST_DIFFERENCE: f32 = 1.0;

/// Puts scans in the order in which they were taken and gives each its time, s.
pub(super) fn in_order(mut scans: Vec<CarmenScan>, readings: &[f32]) -> Vec<CarmenScan> {
    if scans.is_sorted_by(|a, b| a.ipc_seconds <= b.ipc_seconds) {
        return scans;
    }
    let mut sorted = scans.clone();
    // A stable sort: scans of the same stamp keep the order of the file.
    sorted.sort_by(|a, b| a.ipc_seconds.total_cmp(&b.ipc_seconds));
    if roughness(&sorted, readings) <= roughness(&scans, readings) {
        return sorted;
    }
    let stamps: Vec<f64> = scans.iter().map(|scan| scan.ipc_seconds).collect();
    for (scan, seconds) in scans.iter_mut().zip(not_falling(&stamps)) {
        scan.seconds = seconds;
    }
    scans
}

/// Sum of the differences between consecutive scans, m.
fn roughness(scans: &[CarmenScan], readings: &[f32]) -> f64 {
    let of = |scan: &CarmenScan| readings.get(scan.start..scan.start + scan.beams);
    scans
        .windows(2)
        .filter_map(|pair| Some((of(&pair[0])?, of(&pair[1])?)))
        .map(|(a, b)| {
            let every = a.len() / COMPARED + 1;
            let pairs = a.iter().zip(b).step_by(every);
            pairs
                .map(|(a, b)| f64::from((a - b).abs().min(MOST_DIFFERENCE)))
                .sum::<f64>()
        })
        .sum()
}

/// The stamps, where those outside the longest non-decreasing run are spread evenly between their
/// neighbours in the run.
fn not_falling(stamps: &[f64]) -> Vec<f64> {
    // Patience sorting: the last stamp of the best run of each length, and for each stamp its
    // predecessor.
    let mut ends: Vec<usize> = vec![];
    let mut before: Vec<Option<usize>> = Vec::with_capacity(stamps.len());
    for (at, &stamp) in stamps.iter().enumerate() {
        let length = ends.partition_point(|&end| stamps[end] <= stamp);
        before.push(length.checked_sub(1).map(|l| ends[l]));
        if length == ends.len() {
            ends.push(at);
        } else {
            ends[length] = at;
        }
    }
    let mut run = vec![];
    let mut next = ends.last().copied();
    while let Some(at) = next {
        run.push(at);
        next = before[at];
    }
    run.reverse();
    let mut times = stamps.to_vec();
    if let (Some(&first), Some(&last)) = (run.first(), run.last()) {
        times[..first].fill(stamps[first]);
        times[last..].fill(stamps[last]);
    }
    for pair in run.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        for (step, time) in times[from..to].iter_mut().enumerate().skip(1) {
            let part = step as f64 / (to - from) as f64;
            *time = stamps[from] + part * (stamps[to] - stamps[from]);
        }
    }
    times
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn times_never_fall_and_a_good_run_stays(
            stamps in proptest::collection::vec(0.0..100.0_f64, 1..60),
        ) {
            let times = not_falling(&stamps);
            prop_assert!(times.is_sorted());
            let mut rising = stamps.clone();
            rising.sort_by(f64::total_cmp);
            prop_assert_eq!(not_falling(&rising), rising);
        }

        #[test]
        fn the_run_that_is_kept_is_the_longest(
            stamps in proptest::collection::vec(0.0..9.0_f64, 1..11),
        ) {
            let longest = (0_u32..1 << stamps.len())
                .filter(|chosen| {
                    let of = |i: &usize| chosen >> i & 1 == 1;
                    let run: Vec<f64> = (0..stamps.len()).filter(of).map(|i| stamps[i]).collect();
                    run.is_sorted()
                })
                .map(u32::count_ones)
                .max();
            let times = not_falling(&stamps);
            let kept = stamps.iter().zip(&times).filter(|(a, b)| a == b).count();
            prop_assert!(kept as u32 >= longest.unwrap());
        }
    }
}
