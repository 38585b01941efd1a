//! Rooms that are one place, rooms that only look alike, and a corridor.

use super::index::Index;
use super::*;
use crate::geom::{Length, wrap};

/// Surfels every 5 cm along walls, normals to the left of each wall's direction, and beams to them
/// from the middle.
fn submap(walls: &[[f64; 4]], middle: Point2<f64>) -> ClosedSubmap {
    let mut surfels = vec![];
    for &[ax, ay, bx, by] in walls {
        let (a, b) = (Point2::new(ax, ay), Point2::new(bx, by));
        let along = (b - a).normalize();
        let steps = ((b - a).length() / 0.05) as u32;
        surfels.extend((0..steps).map(|i| Surfel {
            position: a + along * (0.05 * f64::from(i)),
            normal: nalgebra::Vector2::new(-along.y, along.x),
            weight: 1.0,
        }));
    }
    let rays: Vec<_> = surfels.iter().map(|s| [middle, s.position]).collect();
    closed(surfels, &rays)
}

fn closed(surfels: Vec<Surfel>, rays: &[[Point2<f64>; 2]]) -> ClosedSubmap {
    let mut free = FreeSpace::default();
    free.mark(rays.iter().copied());
    ClosedSubmap::new(surfels, free)
}

/// The same submap, begun at another place, given by `old_from_new`.
fn begun_at(submap: &ClosedSubmap, middle: Point2<f64>, old_from_new: &Pose2) -> ClosedSubmap {
    let new_from_old = old_from_new.inverse();
    let surfels: Vec<_> = submap
        .surfels
        .iter()
        .map(|s| Surfel {
            position: new_from_old * s.position,
            normal: new_from_old.rotate(s.normal),
            weight: s.weight,
        })
        .collect();
    let middle = new_from_old * middle;
    let rays: Vec<_> = surfels.iter().map(|s| [middle, s.position]).collect();
    closed(surfels, &rays)
}

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
const MIDDLE: Point2<f64> = Point2::new(0.3, 0.2);

fn find(old: &ClosedSubmap, new: &ClosedSubmap, guess: &Pose2, doubt: Doubt) -> Option<Closure> {
    let (surfels, matching) = (SurfelConfig::default(), MatchConfig::default());
    let config = ClosureConfig::default();
    let indexes = [Index::default(), Index::default()];
    let (old, new) = (
        Indexed::new(old, &indexes[0], &surfels),
        Indexed::new(new, &indexes[1], &surfels),
    );
    old.find(&new, guess, &doubt, &matching, &config)
}

#[test]
fn the_same_room_is_found_where_it_is_from_near_and_from_far() {
    let old = submap(&ROOM, MIDDLE);
    let truth = Pose2::new(0.8, -0.5, 0.7);
    let new = begun_at(&old, MIDDLE, &truth);
    for (off, doubt) in [
        (
            Pose2::new(0.08, -0.05, 0.01),
            Doubt {
                shift: 0.1,
                turn: 0.01,
            },
        ),
        (
            Pose2::new(1.5, -1.1, 0.3),
            Doubt {
                shift: 0.8,
                turn: 0.15,
            },
        ),
    ] {
        let found = find(&old, &new, &(truth * off), doubt).unwrap();
        let error = truth.delta_to(&found.motion);
        assert!(error.position().coords.length() < 0.01, "{error:?}");
        assert!(wrap(error.heading()).abs() < 0.005, "{error:?}");
        // Never more certain than the configured figures.
        let cov = found.information.try_inverse().unwrap();
        assert!(
            cov[(0, 0)] >= 0.015 * 0.015 && cov[(2, 2)] >= 0.003 * 0.003,
            "{cov}"
        );
    }
}

#[test]
fn walls_where_the_other_looked_through_speak_against_it() {
    let old = submap(&ROOM, MIDDLE);
    // The same outline with three rows of shelves across it: what is there fits, but the old room
    // was empty.
    let mut furnished = ROOM.to_vec();
    for x in [-1.5, -0.5, 1.0] {
        furnished.push([x, -1.5, x, 1.5]);
    }
    let new = submap(&furnished, MIDDLE);
    let doubt = Doubt {
        shift: 0.05,
        turn: 0.01,
    };
    assert!(find(&old, &old.clone(), &Pose2::identity(), doubt).is_some());
    assert!(find(&old, &new, &Pose2::identity(), doubt).is_none());
    assert!(find(&new, &old, &Pose2::identity(), doubt).is_none());
}

#[test]
fn a_corridor_closes_no_loop_that_had_to_be_searched_for() {
    let corridor = submap(
        &[[-5.0, -1.0, 5.0, -1.0], [5.0, 1.0, -5.0, 1.0]],
        Point2::origin(),
    );
    let guess = Pose2::new(0.1, 0.02, 0.0);
    let searched = Doubt {
        shift: 0.8,
        turn: 0.1,
    };
    assert!(find(&corridor, &corridor, &guess, searched).is_none());
    // Known to centimetres it fits, and gives almost no information along the corridor.
    let near = Doubt {
        shift: 0.05,
        turn: 0.01,
    };
    let found = find(&corridor, &corridor, &guess, near).unwrap();
    assert!(found.motion.y().abs() < 0.005);
    let cov = found.information.try_inverse().unwrap();
    assert!(cov[(0, 0)] > 100.0 * cov[(1, 1)], "{cov}");
}

#[test]
fn beams_clear_the_floor_up_to_their_end_and_walls_are_never_free() {
    let room = submap(&ROOM, MIDDLE);
    assert!(room.free.contains(MIDDLE));
    assert!(room.free.contains(Point2::new(2.0, -1.0)));
    for wall in [(3.0, 0.1), (0.5, -2.0), (-2.5, -1.0)] {
        assert!(!room.free.contains(Point2::new(wall.0, wall.1)), "{wall:?}");
    }
    for never_seen in [(3.5, 0.0), (0.0, -2.5), (900.0, 0.0)] {
        assert!(
            !room.free.contains(Point2::new(never_seen.0, never_seen.1)),
            "{never_seen:?}"
        );
    }
}
