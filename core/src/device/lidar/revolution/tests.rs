//! Turns against closed forms: angles, instants, gaps, and damage that must not spread.

use super::*;
use crate::device::lidar::LidarProtocol as _;
use crate::device::rplidar::Rplidar;
use crate::format::revolution_log::RevolutionLogReader;
use crate::wire::rplidar::node::Node;

const BEAMS: usize = 360;
const INTERVAL: f64 = 0.0005;

/// Reading `k` of a sensor in a round room: 1 m ahead, growing a little on the way round,
/// clockwise.
fn sample(k: usize) -> Sample {
    let part = (k % BEAMS) as f64 / BEAMS as f64;
    Sample {
        angle: TAU * (part + 0.5 / BEAMS as f64),
        range: 1.0 + part,
        quality: Some(10),
        interval: INTERVAL,
        stamp: Stamp::from_seconds(1.0 + k as f64 * INTERVAL),
    }
}

fn collect(samples: impl IntoIterator<Item = Sample>) -> Vec<Scan> {
    let mut revolutions = Revolutions::new(Rplidar::FIGURES, Pose2::identity());
    let scans: Vec<Scan> = samples
        .into_iter()
        .filter_map(|sample| revolutions.push(sample))
        .collect();
    for scan in &scans {
        scan.validate().unwrap();
    }
    scans
}

#[test]
fn clockwise_readings_become_counter_clockwise_bearings_in_order_of_time() {
    let scans = collect((0..3 * BEAMS).map(sample));
    assert_eq!(scans.len(), 2);
    let scan = &scans[0];
    assert_eq!(scan.len(), BEAMS);
    for (beam, pair) in scan.bearings.windows(2).enumerate() {
        assert!(pair[0] > pair[1], "bearing rises at beam {beam}");
    }
    // The first beam lies just beyond the seam: clockwise past straight behind is the left side.
    let half = PI / BEAMS as f64;
    assert!((scan.bearings[0] - (PI - half)).abs() < 1e-12);
    // The range at a quarter turn clockwise, which is to the right: 1.25 m.
    let right = scan
        .bearings
        .iter()
        .position(|b| (b + PI / 2.0).abs() < 1.1 * half);
    assert!((scan.ranges[right.unwrap()] - 1.25).abs() < 0.003);
}

#[test]
fn beams_are_as_old_as_they_are() {
    let scans = collect((0..3 * BEAMS).map(sample));
    let scan = &scans[1];
    assert!((scan.sweep - (BEAMS - 1) as f64 * INTERVAL).abs() < 1e-12);
    // The last beam before the second seam behind, half a turn into the third turn.
    let last = sample(2 * BEAMS + BEAMS / 2 - 1);
    assert_eq!(scan.stamp, last.stamp);
}

#[test]
fn lost_readings_leave_the_others_in_their_places() {
    let whole = collect((0..4 * BEAMS).map(sample));
    let lost = |k: usize| !(k / BEAMS == 1 && (20..52).contains(&(k % BEAMS)));
    let scans = collect((0..4 * BEAMS).filter(|&k| lost(k)).map(sample));
    assert_eq!(scans.len(), 3);
    let nans = scans[0]
        .ranges
        .iter()
        .filter(|range| range.is_nan())
        .count();
    assert_eq!(nans, 32);
    for (beam, (mine, whole_range)) in scans[0].ranges.iter().zip(&whole[0].ranges).enumerate() {
        assert!(mine.is_nan() || mine == whole_range, "beam {beam}");
        assert!((scans[0].bearings[beam] - whole[0].bearings[beam]).abs() < 1e-9);
    }
    assert!((scans[0].sweep - whole[0].sweep).abs() < 1e-12);
}

#[test]
fn one_wrong_angle_costs_one_reading() {
    for wrong in [0.3, 2.0, 3.0, 5.9] {
        let spoil = |k: usize| {
            let mut sample = sample(k);
            if k == BEAMS + 77 {
                sample.angle += wrong;
            }
            sample
        };
        let scans = collect((0..4 * BEAMS).map(spoil));
        assert_eq!(scans.len(), 3, "off by {wrong}");
        assert_eq!(scans[0].len(), BEAMS - 1);
        assert_eq!(scans[1].len(), BEAMS);
    }
}

#[test]
fn a_turn_that_lost_most_is_not_handed_on() {
    let is_lost = |k: &usize| match (k / BEAMS, k % BEAMS) {
        (0, beam) => beam > 200,
        (1, beam) => (6..170).contains(&beam),
        _ => false,
    };
    let scans = collect((0..4 * BEAMS).filter(|k| !is_lost(k)).map(sample));
    assert_eq!(scans.len(), 2);
}

#[test]
fn jitter_at_the_seam_ends_one_turn_only() {
    let jitter = |k: usize| {
        let mut sample = sample(k);
        sample.angle += if k.is_multiple_of(2) { 0.03 } else { -0.03 };
        sample
    };
    let scans = collect((0..5 * BEAMS).map(jitter));
    assert_eq!(scans.len(), 4);
    assert!(scans.iter().all(|scan| scan.len().abs_diff(BEAMS) <= 2));
}

#[test]
fn readings_that_say_nothing_are_invalid_and_far_ones_are_free() {
    let with = |range: f64, quality: u8| {
        let change = |k: usize| Sample {
            range,
            quality: Some(quality),
            ..sample(k)
        };
        collect((0..2 * BEAMS).map(change))[0].ranges[7]
    };
    assert!(with(0.0, 10).is_nan());
    assert!(with(0.1, 10).is_nan());
    assert!(with(3.0, 0).is_nan());
    assert_eq!(with(12.5, 10), f32::INFINITY);
    assert_eq!(with(3.0, 1), 3.0);
}

#[test]
fn qualities_are_those_of_the_readings_and_0_where_nothing_came_back() {
    let told = |k: usize| Sample {
        range: if k.is_multiple_of(9) { 0.0 } else { 2.0 },
        quality: Some((k % 60) as u8 + 2),
        ..sample(k)
    };
    let scans = collect((0..2 * BEAMS).filter(|k| !(400..420).contains(k)).map(told));
    // The scan begins at the seam, half a turn on; readings 400 to 419 were lost.
    for (beam, &quality) in scans[0].qualities.iter().enumerate() {
        let k = beam + BEAMS / 2;
        let is_there = !k.is_multiple_of(9) && !(400..420).contains(&k);
        assert_eq!(
            quality,
            if is_there { (k % 60) as u8 + 2 } else { 0 },
            "{k}"
        );
    }
    assert_eq!(scans[0].qualities.len(), BEAMS);
    let untold = |k: usize| Sample {
        quality: None,
        ..sample(k)
    };
    assert!(collect((0..2 * BEAMS).map(untold))[0].qualities.is_empty());
}

#[test]
fn a_sensor_that_does_not_turn_gives_no_scan() {
    let stuck = |k: usize| Sample {
        angle: 1.0,
        ..sample(k)
    };
    assert!(collect((0..10_000).map(stuck)).is_empty());
}

#[test]
fn numbers_that_are_none_are_counted_and_dropped() {
    let spoil = |k: usize| Sample {
        angle: if k == 500 { f64::NAN } else { sample(k).angle },
        ..sample(k)
    };
    let scans = collect((0..3 * BEAMS).map(spoil));
    assert_eq!(scans.len(), 2);
}

/// Readings from Pilch's server are those that his program writes into its log.
#[test]
fn a_log_of_revolutions_shows_what_the_wire_shows() {
    let reading = |k: usize| {
        let part = (k % BEAMS) as f64 / BEAMS as f64;
        let seen = if k % 9 == 4 { 0.0 } else { 1.0 + part };
        Node::new(TAU * part, seen, 29)
    };
    let on_wire = |k: usize| {
        let node = reading(k);
        let (angle, range) = (node.radians(), node.metres());
        let quality = Some(node.quality);
        Sample {
            angle,
            range,
            quality,
            ..sample(k)
        }
    };
    let live = &collect((0..3 * BEAMS).map(on_wire))[1];
    let written = |k: usize| {
        let (node, first) = (reading(k), if k == 0 { 'S' } else { '_' });
        let (degrees, millimetres) = (node.radians().to_degrees(), 1e3 * node.metres());
        let quality = node.quality;
        format!("{first}_t:{degrees:.2}_d:{millimetres:08.2}_q:{quality}|")
    };
    let line: String = (0..BEAMS).map(written).collect();
    let mut reader = RevolutionLogReader::default();
    reader.push((line + "-END-\n").as_bytes()).unwrap();
    let logged = reader.finish().unwrap().scan(0, 5.5).unwrap();
    assert_eq!((logged.len(), live.len()), (BEAMS, BEAMS));
    let half = BEAMS / 2;
    for beam in 0..BEAMS {
        // A line of the log begins ahead, a revolution from the wire behind.
        let other = (beam + half) % BEAMS;
        let off = wrap(logged.bearings[beam] - live.bearings[other]);
        assert!(off.abs() < 1e-4, "{beam}: {off}");
        let [a, b] = [logged.ranges[beam], live.ranges[other]];
        assert!(a.is_nan() == b.is_nan() && (a.is_nan() || (a - b).abs() < 1e-5));
        assert_eq!(logged.qualities[beam], live.qualities[other]);
    }
}
