//! The space over segments compared with every wall tried one by one.

use nalgebra::Point2;
use proptest::prelude::*;

use super::*;

const BOUNDS: (Point2<f64>, Point2<f64>) = (Point2::new(-1.0, 0.0), Point2::new(9.0, 6.0));

fn point() -> impl Strategy<Value = Point2<f64>> {
    (-1.5..9.5_f64, -0.5..6.5_f64).prop_map(|(x, y)| Point2::new(x, y))
}

/// Random walls, and walls along the axes on a lattice, whose ends meet.
fn wall() -> impl Strategy<Value = Segment> {
    let lattice = (0..9_i32, 0..6_i32, 0..4_i32, any::<bool>()).prop_map(|(x, y, length, flat)| {
        let a = Point2::new(f64::from(x), f64::from(y));
        let b = if flat {
            Point2::new(f64::from(x + length), a.y)
        } else {
            Point2::new(a.x, f64::from(y + length))
        };
        Segment::new(a, b)
    });
    prop_oneof![
        (point(), point()).prop_map(|(a, b)| Segment::new(a, b)),
        lattice
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn raster_changes_nothing(
        walls in proptest::collection::vec(wall(), 0..12), keep in 0.0..0.6_f64,
        points in proptest::collection::vec(point(), 12),
    ) {
        let space = SegmentSpace::new(walls.clone(), keep, BOUNDS).unwrap();
        let inside = |p: Point2<f64>| (p - BOUNDS.0).min() >= 0.0 && (BOUNDS.1 - p).min() >= 0.0;
        for &p in &points {
            let nearest = walls.iter().map(|w| w.distance(p)).fold(f64::INFINITY, f64::min);
            let border = (p - BOUNDS.0).min().min((BOUNDS.1 - p).min());
            let room = if border < 0.0 { border } else { border.min(nearest - keep) };
            prop_assert!((space.room(p) - room).abs() < 1e-12, "{} against {room}", space.room(p));
            prop_assert_eq!(space.is_free(p), inside(p) && nearest >= keep);
        }
        for pair in points.windows(2) {
            let leg = Segment::new(pair[0], pair[1]);
            let nearest = walls.iter().map(|w| w.distance_to(&leg)).fold(f64::INFINITY, f64::min);
            let is_inside = inside(leg.a) && inside(leg.b);
            // On the border itself rounding decides.
            if (nearest - keep).abs() > 1e-9 {
                prop_assert_eq!(space.leg_is_free(&leg), is_inside && nearest > keep);
            }
            let free = space.free_length(&leg);
            if free > 0.0 {
                let part = Segment::new(leg.a, leg.a + leg.vector() * (free / leg.length()));
                prop_assert!(walls.iter().all(|w| w.distance_to(&part) > keep - 1e-9) && inside(part.b));
            }
            if free < leg.length() {
                let longer = Segment::new(leg.a, leg.a + leg.vector() * ((free + 1e-4) / leg.length()));
                let hits = walls.iter().any(|w| w.distance_to(&longer) < keep + 1e-7);
                prop_assert!(hits || !inside(leg.a) || !inside(longer.b), "stopped at {free} of {} for nothing", leg.length());
            }
        }
    }
}

#[test]
fn nonsense_is_refused_by_name() {
    let wall = Segment::new(Point2::origin(), Point2::new(1.0, f64::NAN));
    let new = |walls: Vec<Segment>, keep, bounds| SegmentSpace::new(walls, keep, bounds).err();
    assert_eq!(
        new(vec![wall], 0.1, BOUNDS),
        Some(SpaceError::Wall { index: 0 })
    );
    assert_eq!(
        new(vec![], -0.1, BOUNDS),
        Some(SpaceError::Keep { keep: -0.1 })
    );
    let turned = (BOUNDS.1, BOUNDS.0);
    assert!(matches!(
        new(vec![], 0.1, turned),
        Some(SpaceError::Bounds { .. })
    ));
    let space = SegmentSpace::new(vec![], 0.1, BOUNDS).unwrap();
    let nowhere = Point2::new(f64::NAN, 1.0);
    assert!(!space.is_free(nowhere) && space.room(nowhere) < 0.0);
}

/// The picture of a map as configuration space equals the space of the planners.
#[test]
fn the_room_that_is_shown_is_that_of_the_space() {
    use crate::geom::Pose2;
    use crate::map::{BLOCK_CELLS, CellIndex, Evidence, Field, Grid, GridConfig};
    let mut grid = Grid::new(GridConfig::default()).unwrap();
    let wall = |at: f64| [Point2::new(0.52, 0.53), Point2::new(at, 3.0 - at)];
    let ways: Vec<_> = (-60..60).map(|at| wall(f64::from(at) * 0.05)).collect();
    let evidence = Evidence {
        hits: ways.iter().map(|[_, end]| *end).collect(),
        free: ways,
    };
    (0..4).for_each(|_| grid.draw(&evidence, &Pose2::identity()));
    let (keep, size) = (0.2, BLOCK_CELLS as i32);
    let space = GridSpace::new(&grid, grid.bounds().unwrap(), keep, Unknown::Free);
    let shown = Field::Room { keep }.since(&grid, 0);
    let mut counts = [0, 0];
    for (block, bytes) in shown
        .blocks
        .iter()
        .zip(shown.bytes.chunks(BLOCK_CELLS * BLOCK_CELLS))
    {
        for (at, byte) in bytes
            .iter()
            .enumerate()
            .filter(|(_, byte)| (1..255).contains(*byte))
        {
            let cell = CellIndex::new(
                block.col * size + at as i32 % size,
                block.row * size + at as i32 / size,
            );
            let room = space.room_of(space.index_of(cell).unwrap());
            let found = f64::from(byte - 1) * shown.step;
            assert_eq!(*byte > 1, room > 0.0, "{cell:?}");
            assert!(
                (found - room.max(0.0)).abs() < shown.step + 1e-9,
                "{cell:?}: {found}, {room}"
            );
            counts[usize::from(*byte > 1)] += 1;
        }
    }
    assert!(counts.iter().all(|cells| *cells > 100), "{counts:?}");
}
