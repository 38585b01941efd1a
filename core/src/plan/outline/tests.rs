use super::*;
use crate::plan::{Planner, RrtConfig, Sampler, Search as AnySearch, SegmentSpace};
use proptest::prelude::*;

const LENGTH: f64 = 0.5;
const WIDTH: f64 = 0.3;

fn robot() -> Footprint {
    Footprint::rectangle(LENGTH, WIDTH).unwrap()
}

fn wall(x0: f64, y0: f64, x1: f64, y1: f64) -> Segment {
    Segment::new(Point2::new(x0, y0), Point2::new(x1, y1))
}

fn space(walls: Vec<Segment>) -> SegmentSpace {
    let bounds = (Point2::origin(), Point2::new(4.0, 3.0));
    SegmentSpace::new(walls, 0.5 * WIDTH, bounds).unwrap()
}

/// Two rooms with a door of the given width between them.
fn two_rooms(door: f64) -> SegmentSpace {
    let (low, high) = (1.5 - 0.5 * door, 1.5 + 0.5 * door);
    space(vec![wall(2.0, 0.0, 2.0, low), wall(2.0, high, 2.0, 3.0)])
}

fn query(start: (f64, f64), goal: (f64, f64)) -> Query {
    Query {
        start: Point2::new(start.0, start.1),
        goal: Point2::new(goal.0, goal.1),
    }
}

/// How deep the walls get into the robot anywhere along the path: poses every 5 mm and every
/// degree, points of the walls every 5 mm.
fn deepest(path: &Path, heading: f64, walls: &[Segment]) -> f64 {
    let points: Vec<_> = walls
        .iter()
        .flat_map(|wall| {
            let count = (wall.length() / 0.005).ceil() as i32;
            (0..=count).map(move |i| wall.a + wall.vector() * (f64::from(i) / f64::from(count)))
        })
        .collect();
    let depth = |x: f64, y: f64, heading: f64| {
        let (sin, cos) = crate::geom::sin_cos(heading);
        let into = |p: &Point2<f64>| {
            let (dx, dy) = (p.x - x, p.y - y);
            let (ahead, left) = (cos * dx + sin * dy, cos * dy - sin * dx);
            (0.5 * LENGTH - ahead.abs()).min(0.5 * WIDTH - left.abs())
        };
        points.iter().map(into).fold(f64::NEG_INFINITY, f64::max)
    };
    let mut worst = f64::NEG_INFINITY;
    let mut heading = heading;
    for leg in path.legs() {
        let turn = wrap(leg.heading() - heading);
        let turns = (turn.abs().to_degrees()).ceil() as i32;
        for i in 0..=turns {
            let part = f64::from(i) / f64::from(turns.max(1));
            worst = worst.max(depth(leg.a.x, leg.a.y, heading + turn * part));
        }
        heading += turn;
        let steps = (leg.length() / 0.005).ceil() as i32;
        for i in 0..=steps {
            let at = leg.a + leg.vector() * (f64::from(i) / f64::from(steps));
            worst = worst.max(depth(at.x, at.y, heading));
        }
    }
    worst
}

/// Asks for one path.
fn plan_outline(
    space: &dyn ConfigSpace,
    outline: &Footprint,
    query: Query,
    heading: Option<f64>,
) -> Result<Path, NoPath> {
    let mut search = OutlineSearch::new(space, outline.clone(), query, heading)?;
    for _ in 0..200_000 {
        if !search.expand_next(space) {
            break;
        }
    }
    match search.path() {
        Some(path) => Ok(path),
        // Where the disc within cannot go, the outline cannot.
        None if space.are_apart(query.start, query.goal) => Err(NoPath::Unreachable(query.goal)),
        None if search.open.is_empty() => Err(NoPath::Exhausted {
            iterations: search.iterations,
        }),
        None => Err(NoPath::BudgetSpent {
            iterations: search.iterations,
        }),
    }
}

#[test]
fn a_long_robot_passes_a_door_narrower_than_the_disc_around_it_and_touches_nothing() {
    let asked = query((0.6, 0.6), (3.3, 2.4));
    let rooms = two_rooms(0.4);
    // The disc around it, 58 cm wide, does not fit through.
    let disc = rooms.with_keep(robot().radius_around());
    assert!(disc.are_apart(asked.start, asked.goal));
    for heading in [0.0, 1.5, -2.8] {
        let path = plan_outline(&rooms, &robot(), asked, Some(heading)).unwrap();
        assert_eq!(path.points.first(), Some(&asked.start));
        assert_eq!(path.points.last(), Some(&asked.goal));
        let depth = deepest(&path, heading, rooms.segments());
        assert!(depth <= 0.0, "{depth} m into a wall");
        // Near the shortest way of the disc within, which may cut the corners.
        let disc = rooms.with_keep(robot().radius_within());
        let sampler = || Sampler::anywhere(&disc);
        let graph = Planner::Visibility;
        let mut shortest =
            AnySearch::new(graph, &disc, asked, RrtConfig::default(), sampler).unwrap();
        let mut rng = <rand_chacha::ChaCha8Rng as rand::SeedableRng>::seed_from_u64(1);
        shortest.step(&disc, &mut rng, usize::MAX);
        let least = shortest.path().unwrap().length();
        let length = path.length();
        assert!(
            least <= length + 1e-9 && length < 1.1 * least,
            "{length} {least}"
        );
    }
}

#[test]
fn doors_narrower_than_the_robot_and_bends_without_room_to_turn_are_refused() {
    let asked = query((0.6, 0.6), (3.3, 2.4));
    // 6 cm less than its width: proved by the disc within.
    let shut = plan_outline(&two_rooms(0.24), &robot(), asked, Some(0.0));
    assert!(matches!(shut, Err(NoPath::Unreachable { .. })), "{shut:?}");
    // A bent corridor, 36 cm wide: the disc within fits, but the robot cannot turn in the bend.
    let bend = space(vec![
        wall(0.0, 1.0, 2.36, 1.0),
        wall(2.36, 1.0, 2.36, 3.0),
        wall(0.0, 1.36, 2.0, 1.36),
        wall(2.0, 1.36, 2.0, 3.0),
    ]);
    let asked = query((0.4, 1.18), (2.18, 2.7));
    let stuck = plan_outline(&bend, &robot(), asked, Some(0.0));
    assert!(matches!(stuck, Err(NoPath::Exhausted { .. })), "{stuck:?}");
    let short = Footprint::rectangle(0.3, 0.18).unwrap();
    let bend = bend.with_keep(short.radius_within());
    assert!(plan_outline(&bend, &short, asked, Some(0.0)).is_ok());
    // The long robot drives straight along it, but does not even fit across it.
    let along = query((0.4, 1.18), (1.6, 1.18));
    assert!(plan_outline(&bend, &robot(), along, Some(0.0)).is_ok());
    let across = plan_outline(&bend, &robot(), along, Some(1.57));
    assert!(
        matches!(across, Err(NoPath::StartBlocked { .. })),
        "{across:?}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn among_random_walls_no_path_touches_any(
        ends in proptest::collection::vec((0.3..3.7_f64, 0.3..2.7_f64, -0.7..0.7_f64, -0.7..0.7_f64), 4..9),
        heading in -3.1..3.1_f64,
    ) {
        let walls = ends.iter().map(|&(x, y, dx, dy)| wall(x, y, x + dx, y + dy)).collect();
        let space = space(walls);
        let asked = query((0.3, 0.3), (3.7, 2.7));
        if let Ok(path) = plan_outline(&space, &robot(), asked, Some(heading)) {
            let depth = deepest(&path, heading, space.segments());
            prop_assert!(depth <= 1e-9, "{} m into a wall", depth);
        }
    }
}
