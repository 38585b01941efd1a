use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::geom::Length;

fn point(x: f64, y: f64) -> Point2<f64> {
    Point2::new(x, y)
}

fn seen(a: (f64, f64), b: (f64, f64), from: (f64, f64)) -> Sighting {
    Sighting {
        seen: Segment::new(point(a.0, a.1), point(b.0, b.1)),
        sigma_direction: 0.01,
        sigma_across: 0.01,
        from: point(from.0, from.1),
    }
}

fn often(map: &mut VectorMap, sightings: &[Sighting], beams: &[[Point2<f64>; 2]], times: usize) {
    for _ in 0..times {
        map.observe(sightings, beams);
    }
}

fn lengths(map: &VectorMap) -> Vec<f64> {
    map.walls()
        .iter()
        .map(|wall| wall.segment.length())
        .collect()
}

/// Normal numbers by the sum of twelve uniform ones: exact in mean and variance.
fn normal(rng: &mut impl Rng) -> f64 {
    (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
}

#[test]
fn a_wall_seen_in_parts_becomes_one_and_needs_three_sightings() {
    let mut map = VectorMap::default();
    map.observe(&[seen((0.0, 0.0), (1.0, 0.0), (0.5, 1.0))], &[]);
    map.observe(&[seen((2.0, 0.01), (1.1, 0.0), (0.5, 1.0))], &[]);
    assert_eq!((map.entries.len(), map.walls().len()), (1, 0));
    map.observe(&[seen((1.9, 0.0), (3.0, 0.0), (0.5, 1.0))], &[]);
    let walls = map.walls();
    assert_eq!(walls.len(), 1);
    assert!((walls[0].segment.length() - 3.0).abs() < 0.01, "{walls:?}");
    assert_eq!(walls[0].sightings, 3);
}

#[test]
fn two_parts_with_a_door_between_stay_two_until_it_is_shut() {
    let mut map = VectorMap::default();
    let parts = [
        seen((0.0, 0.0), (2.0, 0.0), (1.0, 1.0)),
        seen((3.0, 0.0), (5.0, 0.0), (1.0, 1.0)),
    ];
    often(&mut map, &parts, &[], 5);
    assert_eq!(lengths(&map).len(), 2);
    often(
        &mut map,
        &[seen((1.8, 0.0), (3.2, 0.0), (2.5, 1.0))],
        &[],
        5,
    );
    let shut = lengths(&map);
    assert!(shut.len() == 1 && (shut[0] - 5.0).abs() < 0.05, "{shut:?}");
    // It opens: beams go through from 2 m to 3 m.
    let beams: Vec<_> = (0..40)
        .map(|i| {
            let x = 2.0125 + 0.025 * f64::from(i);
            [point(x, 1.0), point(x, -2.0)]
        })
        .collect();
    often(&mut map, &parts, &beams, 40);
    let open = lengths(&map);
    assert_eq!(open.len(), 2, "{open:?}");
    assert!(open.iter().all(|l| (l - 2.0).abs() < 0.11), "{open:?}");
}

#[test]
fn a_door_that_opens_and_shuts_for_ever_does_not_make_sightings_of_nothing() {
    let mut map = VectorMap::default();
    let parts = [
        seen((0.0, 0.0), (2.0, 0.0), (1.0, 1.0)),
        seen((3.0, 0.0), (5.0, 0.0), (1.0, 1.0)),
    ];
    let door = [seen((1.8, 0.0), (3.2, 0.0), (2.5, 1.0))];
    let beams: Vec<_> = (0..40)
        .map(|i| {
            let x = 2.0125 + 0.025 * f64::from(i);
            [point(x, 1.0), point(x, -2.0)]
        })
        .collect();
    let mut scans = 0;
    for _ in 0..40 {
        often(&mut map, &parts, &beams, 40);
        often(&mut map, &door, &[], 10);
        scans += 50;
        let most = map.walls().iter().map(|wall| wall.sightings).max();
        // While it is shut, a scan may show both parts of the same wall.
        let most = most.unwrap();
        assert!(most <= 2 * scans, "{most} in {scans} scans");
    }
}

#[test]
fn what_joins_two_walls_is_taken_into_the_longer_under_the_older_name() {
    let mut map = VectorMap::default();
    // The older one is short, and unsure of its direction.
    let mut short = seen((0.0, 0.0), (0.3, 0.04), (0.2, 1.0));
    short.sigma_direction = 0.1;
    often(&mut map, &[short], &[], 5);
    let name = map.walls()[0].id;
    often(
        &mut map,
        &[seen((0.6, 0.0), (6.0, 0.0), (3.0, 1.0))],
        &[],
        30,
    );
    often(
        &mut map,
        &[seen((0.2, 0.0), (1.0, 0.0), (0.5, 1.0))],
        &[],
        5,
    );
    let walls = map.walls();
    assert_eq!(walls.len(), 1, "{walls:?}");
    assert!(walls[0].segment.length() > 5.9, "{walls:?}");
    assert_eq!(walls[0].id, name);
}

#[test]
fn a_piece_as_long_as_a_town_is_no_wall() {
    let mut map = VectorMap::default();
    map.observe(&[seen((0.0, 0.0), (1e9, 0.0), (1.0, 1.0))], &[]);
    assert_eq!(map.entries.len(), 0);
}

#[test]
fn both_faces_of_a_partition_stay_two() {
    let mut map = VectorMap::default();
    let near = seen((0.0, 0.0), (2.0, 0.0), (1.0, 1.0));
    let far = seen((0.0, -0.05), (2.0, -0.05), (1.0, -1.0));
    often(&mut map, &[near, far], &[], 10);
    assert_eq!(map.walls().len(), 2);
    for wall in map.walls() {
        let (along, to) = (wall.segment.vector(), point(1.0, 1.0) - wall.segment.a);
        let is_near = wall.segment.a.y > -0.02;
        assert_eq!(along.perp(&to) > 0.0, is_near, "the side it was seen from");
    }
}

#[test]
fn a_wall_that_another_would_hide_goes_when_it_is_no_longer_seen() {
    let mut map = VectorMap::default();
    let wrong = seen((0.0, 0.05), (2.0, 0.05), (1.0, 1.0));
    let right = seen((0.0, 0.0), (3.0, 0.0), (1.0, 1.0));
    often(&mut map, &[wrong], &[], 30);
    often(&mut map, &[right], &[], 10);
    assert_eq!(map.walls().len(), 2, "it may be seen again");
    often(&mut map, &[right], &[], 50);
    let walls = map.walls();
    assert_eq!(walls.len(), 1);
    assert!(walls[0].segment.a.y.abs() < 0.01, "{walls:?}");
    // 10 cm apart there is room for a wall and a cupboard before it.
    let cupboard = seen((0.0, 0.1), (1.0, 0.1), (1.0, 1.0));
    often(&mut map, &[cupboard], &[], 5);
    often(&mut map, &[right], &[], 60);
    assert_eq!(map.walls().len(), 2);
}

#[test]
fn what_is_gone_is_erased_and_what_was_seen_once_is_forgotten() {
    let mut map = VectorMap::default();
    often(
        &mut map,
        &[seen((0.0, 0.0), (1.0, 0.0), (0.5, 1.0))],
        &[],
        20,
    );
    assert_eq!(map.walls().len(), 1);
    let beams: Vec<_> = (0..101)
        .map(|i| {
            let x = 0.01 * f64::from(i);
            [point(x, 1.0), point(x, -1.0)]
        })
        .collect();
    // Beams that end at the wall, or a hand's breadth behind it, leave it alone.
    let short: Vec<_> = beams.iter().map(|[a, b]| [*a, point(b.x, -0.1)]).collect();
    often(&mut map, &[], &short, 100);
    assert_eq!(map.walls().len(), 1);
    often(&mut map, &[], &beams, 31);
    assert!(map.entries.is_empty(), "{:?}", map.walls());
    map.observe(&[seen((5.0, 0.0), (6.0, 0.0), (5.5, 1.0))], &[]);
    often(&mut map, &[], &[], 51);
    assert!(map.entries.is_empty());
}

#[test]
fn nonsense_leaves_the_map_alone() {
    let mut map = VectorMap::default();
    let mut bad = seen((0.0, 0.0), (1.0, 0.0), (0.5, 1.0));
    bad.seen.a.x = f64::NAN;
    let mut wide = seen((0.0, 0.0), (1.0, 0.0), (0.5, 1.0));
    wide.sigma_across = f64::INFINITY;
    let point_like = seen((0.0, 0.0), (0.0, 0.0), (0.5, 1.0));
    map.observe(&[bad, wide, point_like], &[[point(0.0, 0.0); 2]]);
    assert!(map.entries.is_empty());
}

/// A thousand laps in a room with a desk: the parts that each scan shows begin and end anywhere,
/// with errors as stated.
#[test]
fn after_a_thousand_laps_there_are_as_many_walls_as_in_the_room() {
    let corners = [(0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0)];
    let desk = [(2.0, 1.5), (2.0, 2.5), (3.5, 2.5), (3.5, 1.5)];
    let sides = |corners: [(f64, f64); 4]| (0..4).map(move |i| (corners[i], corners[(i + 1) % 4]));
    let truth: Vec<Segment> = sides(corners)
        .chain(sides(desk))
        .map(|(a, b)| Segment::new(point(a.0, a.1), point(b.0, b.1)))
        .collect();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut map = VectorMap::default();
    for _ in 0..1000 {
        let scan: Vec<Sighting> = truth
            .iter()
            .map(|wall| {
                let (sigma_direction, sigma_across) = (0.01, 0.008);
                let along = wall.vector();
                let normal_of = nalgebra::Vector2::new(-along.y, along.x) / along.length();
                let (low, high) = (rng.random_range(0.0..0.4), rng.random_range(0.6..1.0));
                let shift = normal_of * (sigma_across * normal(&mut rng));
                let swing =
                    sigma_direction * normal(&mut rng) * along.length() * (high - low) * 0.5;
                Sighting {
                    seen: Segment::new(
                        wall.a + along * low + shift - normal_of * swing,
                        wall.a + along * high + shift + normal_of * swing,
                    ),
                    sigma_direction,
                    sigma_across,
                    from: wall.a + along * 0.5 + normal_of,
                }
            })
            .collect();
        map.observe(&scan, &[]);
        assert!(
            map.entries.len() <= truth.len(),
            "{} walls",
            map.entries.len()
        );
    }
    let walls = map.walls();
    assert_eq!(walls.len(), truth.len());
    for wall in walls {
        let off = |p: Point2<f64>| {
            truth
                .iter()
                .map(|t| t.distance(p))
                .fold(f64::INFINITY, f64::min)
        };
        for part in 0..=20 {
            let at = wall.segment.a + wall.segment.vector() * (f64::from(part) / 20.0);
            assert!(off(at) < 0.02, "{} m off at {at}", off(at));
        }
        // Its own uncertainty is about right: its error lies within three standard deviations.
        let middle = wall.segment.a + wall.segment.vector() * 0.5;
        assert!(off(middle) < 4.0 * wall.sigma_across, "{wall:?}");
    }
}
