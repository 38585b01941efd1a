use proptest::prelude::*;

use super::*;
use crate::points::fixture;

fn beams(n: usize) -> Vec<Beam> {
    let (from, to) = (Point2::new(0.5, -0.25), |i| {
        Point2::new(2.5, i as f64 - 0.25)
    });
    let beam = |i: usize| Beam {
        sigma: 0.5,
        ..fixture::beam(i, from, to(i), true)
    };
    (0..n).map(beam).collect()
}

/// Beams on a wall with 2 cm of noise, seen from beside the robot's middle; and some of them to be
/// skipped.
pub(in crate::features) fn wall_in_noise() -> impl Strategy<Value = (Vec<Beam>, Vec<usize>)> {
    let noise = prop::collection::vec((-0.02..0.02_f64, 0.005..0.05_f64), 8..40);
    let wall = (-3.0..3.0_f64, 0.5..6.0_f64, -2.0..1.0_f64, noise);
    let beams = wall.prop_map(|(alpha, r, from, noise)| {
        let (sin, cos) = crate::geom::sin_cos(alpha);
        let (normal, tangent) = (Vector2::new(cos, sin), Vector2::new(-sin, cos));
        let beam = |(i, &(off, sigma)): (usize, &(f64, f64))| {
            let end = Point2::from(normal * (r + off) + tangent * (from + 0.07 * i as f64));
            Beam {
                sigma,
                ..fixture::beam(3 + i, Point2::new(0.1, -0.05), end, true)
            }
        };
        noise.iter().enumerate().map(beam).collect::<Vec<_>>()
    });
    (beams, prop::collection::vec(0..8_usize, 0..4))
}

/// Sums of the kept numbers and y of a range.
struct Seen<'a>(&'a Columns, Range<usize>);

impl Kernel for Seen<'_> {
    type Output = [f64; 3];

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) -> [f64; 3] {
        let zero = L::splat(machine, 0.0);
        let (mut count, mut numbers, mut y) = (zero, zero, zero);
        let blocks = self.0.blocks(&self.1);
        for i in 0..blocks.len() {
            let block = blocks.at(machine, i);
            count += block.keep;
            numbers += block.keep * block.number;
            y += block.keep * block.y;
        }
        [count, numbers, y].map(crate::lanes::total)
    }
}

#[test]
fn blocks_hold_the_points_of_their_range_and_no_others() {
    let beams = beams(23);
    let mut columns = Columns::default();
    // Around the end of the scan: beams 17 to 22, then 0 to 12.
    columns.load(&beams, [17..23, 0..13], Noise::default());
    assert_eq!(columns.len(), 19);
    let dropped = [3, 4, 11];
    for index in dropped {
        columns.drop_point(index);
    }
    for start in 0..=19 {
        for end in start..=19 {
            let kept = || (start..end).filter(|i| !dropped.contains(i));
            let beam = |i: usize| ((i + 17) % 23) as f64;
            let expect = [
                kept().count() as f64,
                kept().map(beam).sum(),
                kept().map(|i| beam(i) - 0.25).sum(),
            ];
            let seen = run(Seen(&columns, start..end));
            assert_eq!(seen, expect, "{start}..{end}");
            assert!(columns.kept(start..end).eq(kept()));
        }
    }
}

proptest! {
    #[test]
    fn columns_hold_the_plain_form_of_each_beam(
        ends in prop::collection::vec((-9.0..9.0_f64, -9.0..9.0_f64, 0.001..0.5_f64), 3..40),
        first in 0..40_usize, bearing_sigma in 0.0..0.02_f64, angle in -3.0..3.0_f64,
    ) {
        let origin = Point2::new(0.31, -0.17);
        let beam = |(i, &(x, y, sigma)): (usize, &(f64, f64, f64))| Beam {
            sigma,
            ..fixture::beam(i, origin, Point2::new(x, y), true)
        };
        let beams: Vec<_> = ends.iter().enumerate().map(beam).collect();
        let (n, first) = (beams.len(), first % beams.len());
        let noise = Noise { bearing_sigma, surface_sigma: 0.1 };
        let mut columns = Columns::default();
        columns.load(&beams, [first..n, 0..first], noise);
        let (sin, cos) = crate::geom::sin_cos(angle);
        let normal = Vector2::new(cos, sin);
        let is_close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs();
        let mut sum = Moments::default();
        for index in 0..n {
            let beam = &beams[(first + index) % n];
            let plain = Sample::of(beam, bearing_sigma);
            prop_assert_eq!(columns.source(index), beam.beam_idx);
            prop_assert_eq!(columns.number(index) as f64, plain.number);
            prop_assert_eq!(columns.point(index).coords, plain.end);
            let (four, lane) = columns.four(index);
            prop_assert!(is_close(four.weight[lane], plain.weight));
            prop_assert!(is_close(four.ux[lane], plain.along.x));
            prop_assert!(is_close(four.uy[lane], plain.along.y));
            let variance = plain.variance(&normal) + 0.01;
            prop_assert!(is_close(columns.variance(index, &normal), variance));
            sum = sum.plus(&Moments::of(plain.weight, plain.end.x, plain.end.y));
        }
        let sums = columns.moments(&(0..n));
        prop_assert!(is_close(sums.w, sum.w) && is_close(sums.xx, sum.xx) && is_close(sums.yy, sum.yy));
        let largest = |of: fn(&Beam) -> f64| beams.iter().map(of).fold(0.0, f64::max);
        let expect = largest(|b| b.sigma).max(bearing_sigma * largest(|b| b.range)) + 0.1;
        prop_assert!(is_close(columns.largest_sigma(), expect));
    }
}

#[test]
fn numbers_that_sums_cannot_take_are_seen() {
    let load = |spoil: fn(&mut Beam)| {
        let mut beams = beams(9);
        spoil(&mut beams[8]);
        let mut columns = Columns::default();
        columns.load(&beams, std::iter::once(0..9), Noise::default());
        columns.is_usable()
    };
    assert!(load(|_| {}));
    assert!(!load(|b| b.range = 0.0));
    assert!(!load(|b| b.range = f64::NAN));
    assert!(!load(|b| b.sigma = -1.0));
    assert!(!load(|b| b.sigma = f64::INFINITY));
    assert!(!load(|b| b.end_in_robot.x = f64::INFINITY));
    assert!(!load(|b| b.end_in_robot.y = f64::NAN));
    let mut none = Columns::default();
    none.load(&[], [], Noise::default());
    assert_eq!(none.len(), 0);
}
