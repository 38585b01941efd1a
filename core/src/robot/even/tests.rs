//! Every reading stays in its direction, wherever the sensor looks and whatever it skipped.

use proptest::prelude::*;

use super::*;

/// Direction and reading of every beam that was kept.
fn kept(bearings: &[f64], ranges: &[f32]) -> Vec<(f64, f32)> {
    let even = EvenBeams::of(bearings, ranges);
    assert_eq!(even.beams.len(), bearings.len());
    let read = even.pick(ranges, f32::NAN).into_iter().enumerate();
    let placed = read.map(|(i, range)| (even.first + even.step * i as f64, range));
    placed.filter(|(_, range)| !range.is_nan()).collect()
}

#[test]
fn even_beams_stay_and_are_turned_into_rising_order() {
    let rising = EvenBeams::of(&[3.0, 3.1, 3.2 - TAU], &[1.0; 3]);
    assert_eq!(
        (rising.first, &rising.beams),
        (3.0, &vec![Some(0), Some(1), Some(2)])
    );
    let falling = EvenBeams::of(&[0.2, 0.1, 0.0], &[3.0, 2.0, 1.0]);
    assert!(falling.first == 0.0 && (falling.step - 0.1).abs() < 1e-12);
    assert_eq!(falling.pick(&[7, 8, 9], 0), [9, 8, 7]);
    for none in [EvenBeams::of(&[], &[]), EvenBeams::of(&[1.0], &[2.0])] {
        assert_eq!(none.step, 0.0);
    }
    let same = EvenBeams::of(&[1.0, 1.0], &[f32::INFINITY, 2.0]);
    assert_eq!((same.first, same.step, same.beams.len()), (1.0, 0.0, 2));
}

#[test]
fn of_two_in_one_direction_the_nearer_counts_and_a_number_before_none() {
    let even = |ranges: [f32; 4]| EvenBeams::of(&[0.0, 0.01, 0.02, 0.3], &ranges);
    assert_eq!(
        even([1.0, 0.5, f32::NAN, 2.0]).beams,
        [Some(1), None, None, Some(3)]
    );
    assert_eq!(
        even([f32::NAN, f32::INFINITY, f32::NAN, 2.0]).pick(&[5, 6, 7, 8], 0),
        [6, 0, 0, 8]
    );
}

#[test]
fn all_round_the_fan_begins_at_the_back() {
    // 360 bearings, each off by up to a tenth of a step, as from a lidar that turns clockwise
    // starting ahead.
    let off = |i: usize| 0.1 * libm::sin(12.9 * i as f64);
    let bearings: Vec<f64> = (0..360)
        .map(|i| wrap(-(i as f64 + off(i)).to_radians()))
        .collect();
    let even = EvenBeams::of(&bearings, &[1.0; 360]);
    assert!(even.first < -3.12, "{}", even.first);
    assert!((even.step - TAU / 360.0).abs() < 1e-4);
    assert_eq!(even.beams.iter().flatten().count(), 360);
}

proptest! {
    /// A beam that a sensor skipped costs at most one other its place, and none is off by more than
    /// half a step, for a fan that does not cover the full circle.
    #[test]
    fn a_fan_with_a_hole_keeps_its_beams_in_their_directions(
        middle in -3.2..3.2_f64, part in 0.02..1.0_f64, count in 8..200_usize, hole in 0.0..1.0_f64, is_falling: bool,
    ) {
        let width = part * TAU * (1.0 - 4.0 / (count - 1) as f64);
        let hole = 1 + (hole * (count - 3) as f64) as usize;
        let bearing = |i: usize| wrap(middle - 0.5 * width + width * i as f64 / (count - 1) as f64);
        let mut beams: Vec<(f64, f32)> = (0..count).filter(|i| *i != hole).map(|i| (bearing(i), 1.0 + i as f32)).collect();
        if is_falling {
            beams.reverse();
        }
        let (bearings, ranges): (Vec<f64>, Vec<f32>) = beams.iter().copied().unzip();
        let kept = kept(&bearings, &ranges);
        prop_assert!(kept.len() + 1 >= beams.len(), "{} of {}", kept.len(), beams.len());
        let half_step = 0.5 * width / (beams.len() - 1) as f64;
        for (direction, range) in kept {
            let truth = bearing((range - 1.0) as usize);
            prop_assert!(wrap(direction - truth).abs() < half_step + 1e-9, "{direction}, not {truth}");
        }
    }
}
