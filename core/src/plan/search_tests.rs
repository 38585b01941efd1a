//! All planners on the same small floors, compared with closed forms, floods and each other.

use nalgebra::Point2;
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::geom::{Length, Segment};

const BOUNDS: (Point2<f64>, Point2<f64>) = (Point2::new(0.0, 0.0), Point2::new(4.0, 3.0));
const QUERY: Query = Query {
    start: Point2::new(0.3, 0.4),
    goal: Point2::new(3.7, 2.6),
};
const KEEP: f64 = 0.15;

fn space_of(walls: &[Segment]) -> SegmentSpace {
    SegmentSpace::new(walls.to_vec(), KEEP, BOUNDS).unwrap()
}

struct Answer {
    path: Result<Path, NoPath>,
    iterations: usize,
}

fn ask(planner: Planner, space: &SegmentSpace, query: Query, iterations: usize) -> Answer {
    let config = RrtConfig {
        range: 1.0,
        ..RrtConfig::default()
    };
    let mut search = match Search::new(planner, space, query, config, || Sampler::anywhere(space)) {
        Ok(search) => search,
        Err(reason) => {
            return Answer {
                path: Err(reason),
                iterations: 0,
            };
        }
    };
    let progress = search.step(space, &mut ChaCha8Rng::seed_from_u64(5), iterations);
    let iterations = search.iterations();
    let path = search.path().ok_or_else(|| match progress {
        _ if space.are_apart(query.start, query.goal) => NoPath::Unreachable(query.goal),
        Progress::Failed(reason) => reason,
        _ => NoPath::BudgetSpent { iterations },
    });
    Answer { path, iterations }
}

/// Least distance from the walls of points 2 mm apart, computed without rasters, capsules and
/// tangents.
fn nearest(path: &Path, walls: &[Segment]) -> f64 {
    let mut least = f64::INFINITY;
    for leg in path.legs() {
        let pieces = (leg.length() / 0.002).ceil().max(1.0) as usize;
        for i in 0..=pieces {
            let at = leg.a + leg.vector() * (i as f64 / pieces as f64);
            least = walls.iter().map(|w| w.distance(at)).fold(least, f64::min);
        }
    }
    least
}

/// Flood over squares of 1 cm whose centres are `keep` away from walls.
fn floods(walls: &[Segment], keep: f64) -> bool {
    const SIDE: f64 = 0.01;
    let (cols, rows) = (400_i32, 300_i32);
    let cell = |p: Point2<f64>| ((p.x / SIDE) as i32, (p.y / SIDE) as i32);
    let is_free = |(c, r): (i32, i32)| {
        let at = Point2::new((f64::from(c) + 0.5) * SIDE, (f64::from(r) + 0.5) * SIDE);
        (0..cols).contains(&c)
            && (0..rows).contains(&r)
            && walls.iter().all(|w| w.distance(at) >= keep)
    };
    let mut seen = vec![false; (cols * rows) as usize];
    let mut todo = vec![cell(QUERY.start)];
    while let Some((c, r)) = todo.pop() {
        if (c, r) == cell(QUERY.goal) {
            return true;
        }
        for next in [(c + 1, r), (c - 1, r), (c, r + 1), (c, r - 1)] {
            if is_free(next)
                && !std::mem::replace(&mut seen[(next.1 * cols + next.0) as usize], true)
            {
                todo.push(next);
            }
        }
    }
    false
}

/// Random walls, and walls from side to side with a gap.
fn walls() -> impl Strategy<Value = Vec<Segment>> {
    let anyhow = proptest::array::uniform4(0.0..1.0_f64).prop_map(|w| {
        let at = |x: f64, y: f64| Point2::new(4.0 * x, 3.0 * y);
        vec![Segment::new(at(w[0], w[1]), at(w[2], w[3]))]
    });
    let gap = (0.8..3.2_f64, 0.0..3.0_f64, 0.0..0.9_f64).prop_map(|(x, y, width)| {
        let at = |y: f64| Point2::new(x, y);
        vec![
            Segment::new(at(0.0), at(y)),
            Segment::new(at(y + width), at(4.0)),
        ]
    });
    proptest::collection::vec(prop_oneof![anyhow, gap], 0..5).prop_map(|walls| walls.concat())
}

/// One wall that reaches in from below, and the length of the shortest way over its end.
fn tip() -> (Vec<Segment>, Query, f64) {
    let wall = Segment::new(Point2::new(2.0, 0.0), Point2::new(2.0, 1.5));
    let query = Query {
        start: Point2::new(1.0, 1.0),
        goal: Point2::new(3.0, 1.0),
    };
    let d = (query.start - wall.b).length();
    let under = 2.0 * libm::atan2(1.0, 0.5);
    let arc = std::f64::consts::TAU - under - 2.0 * libm::acos(KEEP / d);
    (
        vec![wall],
        query,
        2.0 * (d * d - KEEP * KEEP).sqrt() + KEEP * arc,
    )
}

#[test]
fn every_planner_comes_as_near_to_the_closed_form_as_it_can() {
    let (walls, query, shortest) = tip();
    let space = space_of(&walls);
    // Octile paths are longer by up to 8 %, first paths of trees by any amount.
    let most = [9.0, 9.0, 1.01, 1.01, 1.09, 1.02, 1.0003];
    for (planner, most) in CONTESTANTS.into_iter().zip(most) {
        let answer = ask(planner, &space, query, 20_000);
        let path = answer.path.unwrap();
        assert!(nearest(&path, &walls) > KEEP - 1e-9, "{planner:?}");
        let ratio = path.length() / shortest;
        assert!((1.0 - 1e-9..most).contains(&ratio), "{planner:?}: {ratio}");
        let tight = pull_tight(&shorten(&path, &space), &space);
        let ratio = tight.length() / shortest;
        assert!(
            (1.0 - 1e-9..1.001).contains(&ratio),
            "{planner:?} pulled tight: {ratio}"
        );
        assert!(
            nearest(&tight, &walls) > KEEP - 1e-9,
            "{planner:?} pulled tight"
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn no_path_collides_none_beats_the_visibility_graph_and_proofs_are_true(walls in walls()) {
        let space = space_of(&walls);
        prop_assume!(QUERY.check(&space).is_ok());
        let graph = ask(Planner::Visibility, &space, QUERY, usize::MAX);
        match &graph.path {
            Ok(_) => prop_assert!(floods(&walls, KEEP - 0.01), "a way through a wall"),
            Err(reason) => {
                prop_assert!(matches!(reason, NoPath::Unreachable { .. }), "{reason}");
                prop_assert!(!floods(&walls, KEEP + 0.01), "a false proof");
            }
        }
        prop_assert!(graph.path.is_ok() || !space.are_apart(QUERY.start, QUERY.goal) || !floods(&walls, KEEP + 0.01));
        prop_assert!(graph.path.is_err() || !space.are_apart(QUERY.start, QUERY.goal), "the flood shuts what is open");
        for planner in CONTESTANTS {
            let answer = ask(planner, &space, QUERY, 3000);
            let Ok(path) = answer.path else {
                let is_proof = matches!(answer.path, Err(NoPath::Unreachable { .. }));
                prop_assert!(!is_proof || graph.path.is_err(), "{:?}", planner);
                continue;
            };
            let tight = pull_tight(&path, &space);
            for path in [&path, &tight] {
                prop_assert_eq!(path.points.first().zip(path.points.last()), Some((&QUERY.start, &QUERY.goal)));
                prop_assert!(nearest(path, &walls) > KEEP - 1e-4, "{:?}: {}", planner, nearest(path, &walls));
                // Corners around arcs make the graph's own path longer by 0.03 %.
                let shortest = graph.path.as_ref().map_or(f64::INFINITY, Path::length);
                prop_assert!(path.length() > shortest * 0.9996 - 1e-9, "{:?}: {} < {}", planner, path.length(), shortest);
            }
            prop_assert!(tight.length() <= path.length() + 1e-9);
        }
    }

    #[test]
    fn steps_of_any_size_make_the_same_search(walls in walls(), size in 1_usize..40) {
        let space = space_of(&walls);
        prop_assume!(QUERY.check(&space).is_ok());
        for planner in CONTESTANTS {
            let begin = || {
                let sampler = || Sampler::anywhere(&space);
                Search::new(planner, &space, QUERY, RrtConfig::default(), sampler).unwrap()
            };
            let (mut once, mut often) = (begin(), begin());
            once.step(&space, &mut ChaCha8Rng::seed_from_u64(3), 400);
            let (mut rng, mut left, mut length) = (ChaCha8Rng::seed_from_u64(3), 400, f64::INFINITY);
            while left > 0 {
                let now = size.min(left);
                often.step(&space, &mut rng, now);
                left -= now;
                // Anytime: the path never gets longer.
                let path = often.path().map_or(f64::INFINITY, |path| path.length());
                prop_assert!(path <= length + 1e-9);
                length = path;
            }
            prop_assert_eq!(once.path(), often.path());
            prop_assert_eq!(once.iterations(), often.iterations());
            prop_assert_eq!(once.tree(), often.tree());
            prop_assert_eq!(once.tried(), once.tree().len());
        }
    }

    #[test]
    fn a_star_finds_the_cost_that_relaxing_all_cells_finds(
        shut in proptest::collection::vec(0_u8..3, 12 * 12), start in 0_usize..144, goal in 0_usize..144,
    ) {
        let open: Vec<bool> = shut.iter().map(|&s| s > 0).collect();
        prop_assume!(open[start] && open[goal] && start != goal);
        let centre = |cell: usize| Point2::new((cell % 12) as f64 + 0.5, (cell / 12) as f64 + 0.5);
        let query = Query { start: centre(start), goal: centre(goal) };
        let space = SegmentSpace::new(vec![], 0.0, (Point2::origin(), Point2::new(12.0, 12.0))).unwrap();
        let mut search = AStar::new(Lattice::from_cells(Point2::origin(), 1.0, 12, &open), &query);
        while search.iterate(&space) {}
        let mut ways = vec![f64::INFINITY; 144];
        ways[start] = 0.0;
        for _ in 0..144 {
            for cell in (0..144).filter(|&c| open[c]) {
                let (col, row) = ((cell % 12) as i32, (cell / 12) as i32);
                for (dc, dr) in [(1, 0), (0, 1), (1, 1), (-1, 1), (-1, 0), (0, -1), (-1, -1), (1, -1)] {
                    let at = |c: i32, r: i32| {
                        ((0..12).contains(&c) && (0..12).contains(&r)).then_some((r * 12 + c) as usize)
                    };
                    let beside = [at(col + dc, row), at(col, row + dr)];
                    let Some(from) = at(col + dc, row + dr) else { continue };
                    if open[from] && beside.iter().flatten().all(|&c| open[c]) {
                        let step = f64::from(dc * dc + dr * dr).sqrt();
                        ways[cell] = ways[cell].min(ways[from] + step);
                    }
                }
            }
        }
        let found = search.path().map_or(f64::INFINITY, |path| path.length());
        prop_assert!(found == ways[goal] || (found - ways[goal]).abs() < 1e-3, "{found} against {}", ways[goal]);
    }
}

#[test]
fn reasons_are_typed_and_budgets_kept() {
    let wall = Segment::new(Point2::new(2.0, 0.0), Point2::new(2.0, 3.0));
    let space = space_of(&[wall]);
    for planner in CONTESTANTS {
        let answer = ask(planner, &space, QUERY, 300);
        assert!(answer.iterations <= 300, "{planner:?}");
        assert!(
            matches!(answer.path, Err(NoPath::Unreachable { .. })),
            "{planner:?}"
        );
        let at_wall = Point2::new(2.0, 1.0);
        let inside = Query {
            start: at_wall,
            ..QUERY
        };
        let reason = ask(planner, &space, inside, 300).path.unwrap_err();
        assert!(matches!(reason, NoPath::StartBlocked { .. }), "{planner:?}");
        let nowhere = Query {
            goal: Point2::new(f64::NAN, 0.0),
            ..QUERY
        };
        let reason = ask(planner, &space, nowhere, 300).path.unwrap_err();
        assert!(matches!(reason, NoPath::GoalBlocked { .. }), "{planner:?}");
    }
    let wave = ask(Planner::Wavefront, &space, QUERY, 300)
        .path
        .unwrap_err();
    assert!(matches!(wave, NoPath::NotOffered { .. }), "{wave}");
    // A gap of a hair, which no iteration of a tree will meet.
    let halves = [(0.0, 1.5 - 0.1501), (1.5 + 0.1501, 3.0)];
    let door = halves.map(|(y0, y1)| Segment::new(Point2::new(2.0, y0), Point2::new(2.0, y1)));
    let answer = ask(Planner::Rrt, &space_of(&door), QUERY, 50);
    let spent = NoPath::BudgetSpent { iterations: 50 };
    assert_eq!(answer.path, Err(spent));
    assert!(
        ask(Planner::Visibility, &space_of(&door), QUERY, 300)
            .path
            .is_ok()
    );
}
