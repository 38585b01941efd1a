//! A run that was saved and restored on the way ends like one without a pause, to the bit.

use super::super::tests::course::{LAP, Step, drive, feed};
use super::*;
use crate::geom::Pose2;

fn bytes_of(matcher: &ScanMatcher) -> Vec<u8> {
    let mut bytes = vec![];
    matcher.save(&mut bytes);
    bytes
}

fn restored(bytes: &[u8], config: ScanMatcherConfig) -> Result<ScanMatcher, RestoreError> {
    let mut from = Reader::new(bytes);
    let matcher = ScanMatcher::restore(&mut from, config)?;
    assert!(from.is_at_end());
    Ok(matcher)
}

fn two_laps() -> Vec<Step> {
    let corners = [LAP, LAP].concat();
    drive(&corners, Pose2::new(-5.0, -4.0, 0.0), 3)
}

#[test]
fn a_run_that_was_paused_ends_with_the_same_bits() {
    let config = ScanMatcherConfig::default();
    let steps = two_laps();
    let mut whole = ScanMatcher::new(config).unwrap();
    feed(&mut whole, &steps);
    let mut paused = ScanMatcher::new(config).unwrap();
    let mut rest = &steps[..];
    // Also just after the middle, while loops are being closed and the grid is being redrawn.
    while !rest.is_empty() {
        let (now, later) = rest.split_at(rest.len().min(37));
        feed(&mut paused, now);
        let bytes = bytes_of(&paused);
        paused = restored(&bytes, config).unwrap();
        assert_eq!(bytes_of(&paused), bytes, "{} left", later.len());
        rest = later;
    }
    assert_eq!(bytes_of(&paused), bytes_of(&whole));
    whole.finish();
    paused.finish();
    assert!(whole.loop_closures() > 0 && whole.grid_version() > 0);
    assert_eq!(bytes_of(&paused), bytes_of(&whole));
}

#[test]
fn another_resolution_draws_the_grid_anew() {
    let config = ScanMatcherConfig::default();
    let mut matcher = ScanMatcher::new(config).unwrap();
    feed(&mut matcher, &two_laps()[..100]);
    let mut coarse = config;
    coarse.grid.resolution = 0.1;
    let again = restored(&bytes_of(&matcher), coarse).unwrap();
    assert_eq!(again.grid().resolution(), 0.1);
    let occupied = |matcher: &ScanMatcher| {
        let blocks = matcher.grid().blocks_since(0);
        blocks
            .map(|(_, cells)| cells.iter().filter(|odds| **odds > 0.7).count())
            .sum::<usize>()
    };
    let (fine, coarse) = (occupied(&matcher), occupied(&again));
    assert!(
        fine > 500 && coarse * 4 > fine && coarse < fine,
        "{fine} {coarse}"
    );
}

#[test]
fn damaged_bytes_are_refused_or_give_a_matcher_that_runs() {
    let config = ScanMatcherConfig::default();
    let mut matcher = ScanMatcher::new(config).unwrap();
    let steps = two_laps();
    feed(&mut matcher, &steps[..60]);
    let bytes = bytes_of(&matcher);
    let (mut refused, mut taken) = (0, 0);
    for at in (0..bytes.len()).step_by(bytes.len() / 150) {
        for value in [0, 0x7f, 0xff] {
            let mut damaged = bytes.clone();
            damaged[at] = value;
            let mut from = Reader::new(&damaged);
            match ScanMatcher::restore(&mut from, config) {
                Err(_) => refused += 1,
                Ok(mut matcher) => {
                    taken += 1;
                    if taken % 20 == 0 {
                        feed(&mut matcher, &steps[60..64]);
                        matcher.finish();
                    }
                }
            }
        }
        assert!(restored(&bytes[..at], config).is_err(), "cut at {at}");
    }
    assert!(refused > 20 && taken > 20, "{refused} {taken}");
}
