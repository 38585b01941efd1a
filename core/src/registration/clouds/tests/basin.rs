//! Maps of starts: every cell once, each with the result of a plain call.

use super::*;

fn map(method: &str, config: BasinConfig) -> Vec<(Pose2, BasinCell)> {
    let truth = Pose2::new(0.25, -0.15, 0.12);
    let fixed = look(&room(), &Pose2::identity(), 0.01, 50);
    let moving = look(&room(), &truth, 0.01, 51);
    let methods = CloudMethod::all();
    let (_, method) = methods.iter().find(|(name, _)| *name == method).unwrap();
    let mut basin = Basin::new([moving, fixed], truth, *method, config);
    assert_eq!(basin.progress(), 0.0);
    let mut cells = vec![];
    while let Some(cell) = basin.step() {
        cells.push((basin.start(cell.index), cell));
        let done = cells.len() as f64 / (basin.cells() * basin.cells()) as f64;
        assert!((basin.progress() - done).abs() < 1e-12);
    }
    assert_eq!(basin.progress(), 1.0);
    cells
}

#[test]
fn every_cell_comes_once_and_is_what_a_plain_call_says() {
    let truth = Pose2::new(0.25, -0.15, 0.12);
    let fixed = look(&room(), &Pose2::identity(), 0.01, 50);
    let moving = look(&room(), &truth, 0.01, 51);
    let config = BasinConfig {
        cells: 9,
        ..BasinConfig::default()
    };
    let cells = map("point-to-line", config);
    let mut places: Vec<_> = cells.iter().map(|(_, cell)| cell.index).collect();
    places.sort_unstable();
    assert_eq!(places, (0..81).collect::<Vec<_>>());
    let method = CloudMethod::Icp(IcpConfig::default());
    for (start, cell) in &cells {
        let judge = JudgeConfig::default();
        let plain = register_clouds(&moving, &fixed, start, &method, &judge);
        let off = plain.estimate.pose.minus(&truth);
        let is_found = off.xy().length() < 0.05 && off.z.abs() < 0.0175;
        assert_eq!(cell.outcome == BasinOutcome::Found, is_found, "{start:?}");
        assert_eq!(cell.iterations, plain.iterations, "{start:?}");
    }
    let found = |(_, cell): &&(Pose2, BasinCell)| cell.outcome == BasinOutcome::Found;
    let count = cells.iter().filter(found).count();
    assert!(count > 5 && count < 81, "{count} of 81 found");
    // The true pose is in the middle, and is found from itself.
    let (start, cell) = cells.iter().find(|(_, cell)| cell.index == 40).unwrap();
    assert!(start.minus(&truth).length() < 1e-12);
    assert_eq!(cell.outcome, BasinOutcome::Found);
}

#[test]
fn a_tenth_of_the_cells_shows_the_whole() {
    let config = BasinConfig {
        cells: 25,
        ..BasinConfig::default()
    };
    let empty = || Cloud::any(vec![]).unwrap();
    let method = CloudMethod::Icp(IcpConfig::default());
    let mut basin = Basin::new([empty(), empty()], Pose2::identity(), method, config);
    // In each of 16 parts of the map, which have 36 to 49 cells, some are known.
    let mut known = [0; 16];
    for _ in 0..63 {
        let cell = basin.step().unwrap();
        let (column, row) = (cell.index % 25, cell.index / 25);
        known[4 * (4 * row / 25) + 4 * column / 25] += 1;
    }
    assert!(
        known.iter().all(|count| (2..=6).contains(count)),
        "{known:?}"
    );
}

#[test]
fn axes_are_a_shift_and_a_turn_or_a_place() {
    let corner = |axes| {
        let config = BasinConfig {
            axes,
            cells: 3,
            shift: 0.5,
            turn: 0.3,
            ..BasinConfig::default()
        };
        let cells = map("point-to-line", config);
        let at = |index| {
            cells
                .iter()
                .find(|(_, cell)| cell.index == index)
                .unwrap()
                .0
        };
        let truth = at(4);
        [5, 7].map(|index| at(index).minus(&truth))
    };
    let [right, up] = corner(BasinAxes::ShiftTurn {
        direction: std::f64::consts::FRAC_PI_2,
    });
    assert!((right - nalgebra::Vector3::new(0.0, 0.5, 0.0)).length() < 1e-12);
    assert!((up - nalgebra::Vector3::new(0.0, 0.0, 0.3)).length() < 1e-12);
    let [right, up] = corner(BasinAxes::Place);
    assert!((right - nalgebra::Vector3::new(0.5, 0.0, 0.0)).length() < 1e-12);
    assert!((up - nalgebra::Vector3::new(0.0, 0.5, 0.0)).length() < 1e-12);
}

#[test]
fn a_search_finds_all_starts_of_its_window() {
    let config = BasinConfig {
        cells: 3,
        shift: 1.0,
        turn: 0.7,
        ..BasinConfig::default()
    };
    for (start, cell) in map("correlation", config) {
        assert_eq!(cell.outcome, BasinOutcome::Found, "{start:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn no_size_leaves_a_cell_out(cells in 0_usize..30) {
        let empty = || Cloud::any(vec![]).unwrap();
        let method = CloudMethod::Icp(IcpConfig::default());
        let config = BasinConfig { cells, ..BasinConfig::default() };
        let mut basin = Basin::new([empty(), empty()], Pose2::identity(), method, config);
        let mut places = vec![];
        while let Some(cell) = basin.step() {
            places.push(cell.index);
        }
        places.sort_unstable();
        let side = cells.max(1);
        prop_assert_eq!(places, (0..side * side).collect::<Vec<_>>());
    }
}
