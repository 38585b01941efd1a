//! Rooms at their true place, beside it, and elsewhere.

use nalgebra::{Point2, Vector2};

use super::super::submap::Doubt;
use super::*;
use crate::estimation::free_space::FreeSpace;
use crate::geom::Length;
use crate::map::Surfel;

/// A room of 6 m x 4 m with a door in its upper wall; a niche makes its sides distinguishable.
const ROOM: [[f64; 4]; 7] = [
    [-3.0, -2.0, 3.0, -2.0],
    [3.0, -2.0, 3.0, 2.0],
    [3.0, 2.0, -1.0, 2.0],
    [-2.0, 2.0, -3.0, 2.0],
    [-3.0, 2.0, -3.0, 0.0],
    [-3.0, 0.0, -2.5, 0.0],
    [-2.5, 0.0, -2.5, -2.0],
];
/// Another room, 4.4 m x 8 m.
const OTHER: [[f64; 4]; 4] = [
    [-2.2, -4.0, 2.2, -4.0],
    [2.2, -4.0, 2.2, 4.0],
    [2.2, 4.0, -2.2, 4.0],
    [-2.2, 4.0, -2.2, -4.0],
];
/// The position from which they were seen.
const MIDDLE: Point2<f64> = Point2::new(0.3, 0.2);

/// A submap of walls seen from all around the middle, begun at `room_from_submap`.
fn seen(walls: &[[f64; 4]], room_from_submap: &Pose2) -> ClosedSubmap {
    let submap_from_room = room_from_submap.inverse();
    let (mut surfels, mut rays) = (vec![], vec![]);
    for &[ax, ay, bx, by] in walls {
        let (a, b) = (Point2::new(ax, ay), Point2::new(bx, by));
        let along = (b - a).normalize();
        let steps = ((b - a).length() / 0.05) as u32;
        for step in 0..steps {
            let position = a + along * (0.05 * f64::from(step));
            surfels.push(Surfel {
                position: submap_from_room * position,
                normal: submap_from_room.rotate(Vector2::new(-along.y, along.x)),
                weight: 5.0,
            });
            let from = MIDDLE + Vector2::new(0.1 * f64::from(step % 5), 0.0);
            rays.push([submap_from_room * from, submap_from_room * position]);
        }
    }
    let mut free = FreeSpace::default();
    free.mark(rays.into_iter());
    ClosedSubmap::new(surfels, free)
}

/// The judgement of submaps, each with its pose in the map; they were seen one after the other, a
/// minute each.
fn judged(submaps: &[(ClosedSubmap, Pose2)], untied: &[Untied]) -> MapQuality {
    judged_on_its_way(submaps, untied, &[])
}

/// The same, with the offsets of neighbours that share scans.
fn judged_on_its_way(
    submaps: &[(ClosedSubmap, Pose2)],
    untied: &[Untied],
    parted: &[Parted],
) -> MapQuality {
    let placed: Vec<Placed<'_>> = (0..)
        .zip(submaps)
        .map(|(minute, (submap, map_from_submap))| Placed {
            submap,
            map_from_submap: *map_from_submap,
            seen: [minute, minute + 1].map(|minute| Stamp(minute * 60_000_000)),
        })
        .collect();
    let (surfels, matching) = (SurfelConfig::default(), MatchConfig::default());
    let places = placed.iter().map(|p| (p.map_from_submap, p.seen));
    let (untied, parted) = (untied.to_vec(), parted.to_vec());
    let mut judgement = MapJudgement::new(places.collect(), untied, parted, vec![], None);
    assert_eq!(judgement.progress(), 0.0);
    while judgement.step(&placed, &surfels, &matching) {
        assert!(judgement.progress() < 1.0);
    }
    assert_eq!(judgement.progress(), 1.0);
    judgement.quality(&placed)
}

/// A good map whose loops were closed over paths that were off by these multiples of their
/// uncertainty.
fn with_loops(ratios: &[f64]) -> MapQuality {
    let error = |ratio| LoopError {
        doubt: Doubt {
            shift: 0.1,
            turn: 0.01,
        },
        shift: 0.1 * ratio,
        turn: 0.0,
        ratio,
    };
    let closed = |&ratio: &f64| ClosedLoop {
        earlier: [Stamp(0); 2],
        later: [Stamp(1); 2],
        error: error(ratio),
    };
    let loops = ratios.iter().map(closed).collect();
    let judgement = MapJudgement::new(vec![], vec![], vec![], loops, None);
    judgement.quality(&[])
}

#[test]
fn only_what_is_so_on_the_median_of_several_loops_is_called_systematic() {
    let check = |ratios: &[f64], median: Option<f64>, is_overconfident: bool| {
        let quality = with_loops(ratios);
        assert_eq!(quality.loop_ratio(), median, "{ratios:?}");
        assert_eq!(quality.is_overconfident(), is_overconfident, "{ratios:?}");
        assert_eq!(quality.verdict, MapVerdict::Good);
        assert_eq!(quality.loops.len(), ratios.len());
    };
    check(&[], None, false);
    check(&[9.0; 4], None, false);
    check(&[9.0; 5], Some(9.0), true);
    check(&[50.0, 0.5, 40.0, 0.7, 0.2], Some(0.7), false);
    check(&[3.1, 0.5, 4.0, 3.2, 0.2], Some(3.1), true);
    check(&[3.0, 0.5, 4.0, 3.2, 0.2], Some(3.0), false);
}

/// The room seen four times: two submaps at their true place, two placed `off` from it.
fn room_seen_again(off: &Pose2) -> MapQuality {
    let begun = [
        Pose2::new(0.8, -0.5, 0.7),
        Pose2::new(-1.0, 0.3, -2.0),
        Pose2::new(0.2, 0.9, 3.0),
        Pose2::new(1.1, 0.4, 0.1),
    ];
    let submaps: Vec<_> = (0..)
        .zip(begun)
        .map(|(at, begun)| {
            let map_from_room = if at < 2 { Pose2::identity() } else { *off };
            (seen(&ROOM, &begun), map_from_room * begun)
        })
        .collect();
    judged(&submaps, &[])
}

#[test]
fn a_room_seen_again_where_it_stands_is_good() {
    for off in [Pose2::identity(), Pose2::new(0.03, -0.04, 0.004)] {
        let quality = room_seen_again(&off);
        assert_eq!(quality.verdict, MapVerdict::Good, "{:?}", quality.tears);
        assert!(quality.agreement.unwrap() > 0.95, "{:?}", quality.agreement);
        assert_eq!(quality.stretches.len(), 4);
        assert!(quality.stretches.iter().all(|s| s.agreement > Some(0.9)));
    }
}

#[test]
fn walls_that_stand_twice_are_a_tear_as_wide_as_they_are_apart() {
    for (x, y, turn) in [(0.5, 0.0, 0.0), (-0.3, 0.3, 0.03), (0.1, -0.8, -0.05)] {
        let quality = room_seen_again(&Pose2::new(x, y, turn));
        assert_eq!(quality.verdict, MapVerdict::Torn);
        let tear = &quality.tears[0];
        assert_eq!(tear.kind, TearKind::Doubled);
        let off = tear.off.unwrap();
        assert!((off - libm::hypot(x, y)).abs() < 0.1, "{off} {x} {y}");
        assert!(tear.place.coords.length() < 1.5, "{:?}", tear.place);
        // The first two submaps were seen in the first two minutes.
        let [earlier, later] = [tear.earlier, tear.later].map(|[from, _]| from.seconds());
        assert!(earlier < 120.0 && later >= 120.0, "{earlier} {later}");
        assert!(quality.agreement.unwrap() < 0.8);
    }
}

#[test]
fn one_room_in_another_contradicts_it() {
    let begun = Pose2::new(0.8, -0.5, 0.7);
    let of = |walls| (seen(walls, &begun), begun);
    let submaps = [of(&ROOM), of(&ROOM), of(&OTHER), of(&OTHER)];
    let quality = judged(&submaps, &[]);
    assert_eq!(quality.verdict, MapVerdict::Torn);
    let tear = &quality.tears[0];
    assert_eq!((tear.kind, tear.off), (TearKind::Contradicted, None));
    assert!(tear.place.coords.length() < 3.0, "{:?}", tear.place);
}

#[test]
fn a_door_that_was_shut_tears_nothing() {
    let begun = Pose2::new(0.8, -0.5, 0.7);
    let mut shut = ROOM.to_vec();
    shut.push([-1.0, 2.0, -2.0, 2.0]);
    let of = |walls: &[[f64; 4]]| (seen(walls, &begun), begun);
    let quality = judged(&[of(&ROOM), of(&ROOM), of(&shut), of(&shut)], &[]);
    assert_eq!(quality.verdict, MapVerdict::Good, "{:?}", quality.tears);
}

#[test]
fn what_was_seen_only_once_says_nothing() {
    let apart = |minute: f64| {
        (
            seen(&ROOM, &Pose2::identity()),
            Pose2::new(20.0 * minute, 0.0, 0.0),
        )
    };
    let submaps = [apart(0.0), apart(1.0), apart(2.0), apart(3.0)];
    let quality = judged(&submaps, &[]);
    assert_eq!(quality.verdict, MapVerdict::Good);
    assert_eq!(quality.agreement, None);
    assert!(quality.stretches.iter().all(|s| s.agreement.is_none()));
    // Unless the path between is poorly known, and nothing else ties it down.
    let untied = |doubt, is_lost| Untied {
        between: [0, 3],
        doubt,
        is_lost,
    };
    let verdict = |untied| judged(&submaps, &[untied]).verdict;
    assert_eq!(verdict(untied(0.1, true)), MapVerdict::Good);
    assert_eq!(verdict(untied(0.8, false)), MapVerdict::Good);
    assert_eq!(verdict(untied(2.0, false)), MapVerdict::Doubtful);
    assert_eq!(verdict(untied(0.8, true)), MapVerdict::Torn);
}

#[test]
fn scans_that_lie_in_two_places_tear_a_map_that_agrees_with_itself() {
    let along = |minute: f64| {
        let begun = Pose2::new(20.0 * minute, 0.0, 0.0);
        (seen(&ROOM, &Pose2::identity()), begun)
    };
    let submaps = [along(0.0), along(1.0), along(2.0), along(3.0)];
    let parted = |earlier, shift, turn| Parted {
        earlier,
        shift,
        turn,
    };
    let of = |parted: &[Parted]| judged_on_its_way(&submaps, &[], parted);
    let whole = of(&[parted(0, 0.1, 0.02), parted(1, 0.2, 0.04)]);
    assert_eq!(whole.verdict, MapVerdict::Good, "{:?}", whole.tears);
    let torn = of(&[parted(1, 0.4, 0.0)]);
    assert_eq!(torn.verdict, MapVerdict::Torn);
    let tear = &torn.tears[0];
    assert_eq!((tear.kind, tear.off), (TearKind::Doubled, Some(0.4)));
    assert!((tear.place - Point2::new(30.0, 0.0)).length() < 1e-9);
    // A rotation alone may have been corrected at once.
    let turned = of(&[parted(1, 0.1, 0.2)]);
    assert_eq!(turned.verdict, MapVerdict::Good, "{:?}", turned.tears);
}

#[test]
fn what_a_submap_took_over_wrong_is_not_held_against_the_map() {
    let (begun, off) = (Pose2::new(0.8, -0.5, 0.7), Pose2::new(0.5, 0.0, 0.0));
    let right = || (seen(&ROOM, &begun), begun);
    let submaps = [right(), right(), right(), (right().0, off * begun)];
    let of = |parted: &[Parted]| judged_on_its_way(&submaps, &[], parted).verdict;
    assert_eq!(of(&[]), MapVerdict::Torn);
    let parted = Parted {
        earlier: 2,
        shift: 0.2,
        turn: 0.1,
    };
    assert_eq!(of(&[parted]), MapVerdict::Good);
}

#[test]
fn witnesses_that_would_move_the_map_elsewhere_are_not_put_together() {
    let begun = Pose2::new(0.8, -0.5, 0.7);
    let at = |x: f64, y: f64| (seen(&ROOM, &begun), Pose2::new(x, y, 0.0) * begun);
    // Two visits that each disagree in a different way; neither counts.
    let one = judged(&[at(0.0, 0.0), at(0.0, 0.0), at(0.6, 0.0)], &[]);
    assert_eq!(one.verdict, MapVerdict::Good, "{:?}", one.tears);
    let same = [at(0.0, 0.0), at(0.0, 0.0), at(0.6, 0.0), at(0.6, 0.0)];
    assert_eq!(judged(&same, &[]).verdict, MapVerdict::Torn);
}
