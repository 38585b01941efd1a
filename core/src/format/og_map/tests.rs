use proptest::prelude::*;

use super::*;
use crate::format::map_server::{MapMode, MapServerError, OccupancyMap};
use crate::geom::Pose2;
use crate::map::{Evidence, GridConfig};

#[test]
fn a_grid_is_written_from_its_lowest_row_on_with_what_is_known_only() {
    let mut grid = Grid::new(GridConfig {
        resolution: 0.5,
        ..GridConfig::default()
    })
    .unwrap();
    let evidence = Evidence {
        hits: vec![Point2::new(-0.25, 1.25)],
        free: vec![[Point2::new(-0.25, 0.25), Point2::new(-0.25, 1.25)]],
    };
    grid.draw(&evidence, &Pose2::identity());
    let map = of_grid(&grid).unwrap();
    assert_eq!((map.width, map.height, map.resolution), (1, 3, 0.5));
    assert_eq!(map.origin, Point2::new(-0.5, 0.0));
    let config = grid.config();
    let expected = [config.miss, config.miss, config.hit];
    for (p, expected) in map.probabilities.iter().zip(expected) {
        assert!((p - expected).abs() < 1e-6, "{p} for {expected}");
    }
    let text = write(&map);
    assert!(text.starts_with("1 3 0.5 -0.5 0\n"), "{text}");
    assert_eq!(text.lines().count(), 4);
}

/// A regression: all cells between two distant ones were visited, and 27 GB were to be allocated.
#[test]
fn a_map_of_two_cells_far_apart_is_refused_at_once() {
    let mut grid = Grid::new(GridConfig {
        resolution: 0.5,
        ..GridConfig::default()
    })
    .unwrap();
    let evidence = Evidence {
        hits: vec![Point2::new(0.25, 0.25), Point2::new(10_000.25, 10_000.25)],
        free: vec![],
    };
    grid.draw(&evidence, &Pose2::identity());
    let (width, height) = (20_001, 20_001);
    assert_eq!(
        of_grid(&grid),
        Err(MapServerError::TooLarge { width, height })
    );
    let error = OccupancyMap::of_grid(&grid, MapMode::Trinary).unwrap_err();
    assert_eq!(error, MapServerError::TooLarge { width, height });
}

proptest! {
    #[test]
    fn what_was_written_is_read(
        (width, probabilities) in (1..9_usize).prop_flat_map(|w| (Just(w), proptest::collection::vec(0.0..=1.0_f64, w..5 * w))),
        resolution in 0.01..2.0_f64, x in -1e3..1e3_f64, y in -1e3..1e3_f64,
    ) {
        let height = probabilities.len() / width;
        let probabilities = probabilities[..width * height].to_vec();
        let map = OgMap { width, height, resolution, origin: Point2::new(x, y), probabilities };
        let read = parse(write(&map).replace('\n', "\r\n").as_bytes()).unwrap();
        prop_assert_eq!((read.width, read.height, read.resolution, read.origin), (width, height, resolution, map.origin));
        for (a, b) in read.probabilities.iter().zip(&map.probabilities) {
            prop_assert!((a - b).abs() <= 5.1e-5);
        }
    }

    #[test]
    fn any_bytes_are_a_map_or_an_error(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let _ = parse(&bytes);
    }
}

#[test]
fn what_is_wrong_is_said_with_line_and_field() {
    let check = |text: &str, expected: &str| {
        let error = parse(text.as_bytes()).unwrap_err();
        assert_eq!(error.to_string(), expected, "{text:?}");
    };
    check(
        "",
        "line 1: the number of fields is `0`, expected 5: width height resolution origin_x origin_y",
    );
    check(
        "2 1 0 0 0\n0.5 0.5\n",
        "line 1: resolution is `0`, expected more than 0 m",
    );
    check(
        "2 1 nan 0 0\n",
        "line 1: resolution is `nan`, expected a finite number",
    );
    check(
        "-2 1 0.1 0 0\n",
        "line 1: width is `-2`, expected a whole number from 1 to 100000000",
    );
    check(
        "100000 100000 0.1 0 0\n",
        "line 1: height is `100000`, expected at most 100000000 cells together",
    );
    check(
        "2 1 0.1 0 0\n0.5\n",
        "line 2: the number of fields is `1`, expected 2 as line 1 says",
    );
    check(
        "2 1 0.1 0 0\n0.5 1.5\n",
        "line 2: field 2 is `1.5`, expected a number from 0 to 1",
    );
    check(
        "1 2 0.1 0 0\n0.5\n",
        "line 2: the number of rows is `1`, expected 2 as line 1 says",
    );
    check(
        "1 1 0.1 0 0\n0.5\n0.5\n",
        "line 3: the number of rows is `2`, expected 1 as line 1 says",
    );
    let empty = Grid::new(GridConfig::default()).unwrap();
    assert_eq!(of_grid(&empty), Err(MapServerError::Empty));
}
