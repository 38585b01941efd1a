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

#[test]
fn columns_say_what_the_beams_say() {
    let beams = beams(11);
    let noise = Noise {
        bearing_sigma: 0.01,
        surface_sigma: 0.1,
    };
    let mut columns = Columns::default();
    columns.load(&beams, [2..11, 0..2], noise);
    for index in 0..11 {
        let beam = &beams[(index + 2) % 11];
        assert_eq!(columns.source(index), beam.beam_idx);
        assert_eq!(columns.number(index), beam.beam_idx);
        assert_eq!(columns.point(index), beam.end_in_robot);
        // σ along the beam 0.5, across it 0.01 ρ; the surface adds 0.1.
        let along = (beam.end_in_robot - beam.origin_in_robot) / beam.range;
        let across = Vector2::new(-along.y, along.x);
        let [of_range, of_bearing] = [along, across].map(|n| columns.variance(index, &n));
        assert!((of_range - 0.26).abs() < 1e-12);
        let expect = 1e-4 * beam.range * beam.range + 0.01;
        assert!((of_bearing - expect).abs() < 1e-12);
    }
    // Of the farthest beam.
    let expect = 0.5_f64.max(0.01 * beams[10].range) + 0.1;
    assert!((columns.largest_sigma() - expect).abs() < 1e-12);
    let sums = columns.moments(&(3..9));
    let y: f64 = (5..11).map(|i| 4.0 * beams[i].end_in_robot.y).sum();
    assert!((sums.w - 24.0).abs() < 1e-12 && (sums.y - y).abs() < 1e-9);
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
