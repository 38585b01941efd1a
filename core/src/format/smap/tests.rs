//! The paper's landmarks, errors reported with their lines, and laws of reading and writing.

use nalgebra::Matrix3;
use proptest::prelude::*;

use super::*;
use crate::estimation::ScanMatcherConfig;
use crate::geom::{Pose2, Segment};
use crate::map::GridConfig;
use crate::points::fixture::look;
use crate::points::{PointConfig, Points};
use crate::robot::{Odometry, Scan, Stamp};

/// The landmarks are those of (3.5).
const PAPER: &str = "#points\n2\n1000,500\n-20.5,0\n#robot\n1\n0,0\n#landmarks\n3\n\
    -2110.33, -2760.47, 5, 0\n563.693, 3974.48, 0, 0\n-5546.09, -3470.07, 0, 1\n";

#[test]
fn what_the_paper_prints_is_read_in_metres_with_left_on_the_left() {
    let map = parse(PAPER.as_bytes()).unwrap();
    // 1 m ahead and 0.5 m to the right.
    assert_eq!(map.points[0], Point2::new(1.0, -0.5));
    assert_eq!(map.path, [Point2::origin()]);
    let first = map.landmarks[0];
    let off = first.at - Point2::new(-2.11033, 2.76047);
    assert!(off.amax() < 1e-12, "{first:?}");
    assert_eq!((first.confidence, first.kind), (5, LandmarkKind::Point));
    assert_eq!(map.landmarks[2].kind, LandmarkKind::Edge);
    assert_eq!(
        map.write(),
        PAPER
            .replace("1000,500", "1000, 500")
            .replace("-20.5,0", "-20.5, 0")
            .replace("\n0,0", "\n0, 0")
    );
}

#[test]
fn blanks_line_ends_and_the_order_of_sections_are_free() {
    let [points, robot, landmarks] = sections();
    let other = format!("\u{feff}\n{landmarks}\n\n{points}{robot}").replace('\n', " \r\n\t");
    assert_eq!(parse(other.as_bytes()), parse(PAPER.as_bytes()));
}

fn sections() -> [&'static str; 3] {
    let (points, rest) = PAPER.split_at(PAPER.find("#robot").unwrap());
    let (robot, landmarks) = rest.split_at(rest.find("#landmarks").unwrap());
    [points, robot, landmarks]
}

#[test]
fn what_is_wrong_is_named_with_its_line() {
    let check = |text: &str, expected: &str| {
        let error = parse(text.as_bytes()).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}");
    };
    let with = |from: &str, to: &str| PAPER.replacen(from, to, 1);
    check(
        &with("2\n1000", "3\n1000"),
        "line 5: the number of lines of #points is `2`, expected 3 as line 2 says",
    );
    check(
        &with("2\n1000", "1\n1000"),
        "line 4: the line is `-20.5,0`, expected #robot or #landmarks, as",
    );
    check(
        &with("3\n-2110", "4\n-2110"),
        "line 12: the number of lines of #landmarks is `3`, expected 4 as line 9 says",
    );
    check(
        &with("3\n-2110", "2\n-2110"),
        "line 12: the line is `-5546.09, -3470.07, 0, 1`, expected the end of the file",
    );
    check(
        &with("2\n1000", "x\n1000"),
        "line 2: the count of #points is `x`",
    );
    check(
        &with("2\n1000", "-2\n1000"),
        "line 2: the count of #points is `-2`",
    );
    check(
        &with("2\n1000", "100001\n1000"),
        "line 2: 100001 points, expected at most 100000",
    );
    check(
        &with("1000,", "NaN,"),
        "line 3: x is `NaN`, expected millimetres",
    );
    check(&with("1000,500", "1000,inf"), "line 3: y is `inf`");
    check(&with("1000,500", "1000,2e9"), "line 3: y is `2e9`");
    check(
        &with("1000,500", "1000"),
        "line 3: the number of fields is `1`, expected 2: x, y",
    );
    check(
        &with("1000,500", "1000;500"),
        "line 3: the number of fields is `1`",
    );
    check(
        &with("5, 0", "5"),
        "line 10: the number of fields is `3`, expected 4",
    );
    check(&with("5, 0", "-1, 0"), "line 10: confidence is `-1`");
    check(&with("5, 0", "1.5, 0"), "line 10: confidence is `1.5`");
    check(
        &with("5, 0", "5, 2"),
        "line 10: type is `2`, expected 0 for a point",
    );
    let [points, robot, landmarks] = sections();
    check(
        &format!("{points}{landmarks}"),
        "the section `#robot` is missing; the file ends after line 9",
    );
    check(
        &format!("{points}{robot}"),
        "the section `#landmarks` is missing; the file ends after line 7",
    );
    check(
        "",
        "the section `#points` is missing; the file ends after line 0",
    );
    check(
        &format!("{points}{robot}{points}"),
        "line 8: the section is `#points`, expected each section once",
    );
    check(
        &with("#robot", "#robots"),
        "line 5: the line is `#robots`, expected #robot or",
    );
    check("#points", "line 1: the count of #points is ``");
    check("12 3\n", "line 1: the line is `12 3`");
}

/// A robot stands in a room, sees walls 2 m ahead and 1.2 m to the left, and saves it.
#[test]
fn what_a_run_has_mapped_comes_back_as_it_was() {
    let mut grid = Grid::new(GridConfig::default()).unwrap();
    let bearings: Vec<f64> = (0..400).map(|k| 0.004 * f64::from(k)).collect();
    let range = |bearing: &f64| {
        let (sin, cos) = crate::geom::sin_cos(*bearing);
        (2.0 / cos.max(1e-9)).min(1.2 / sin.max(1e-9)) as f32
    };
    let scan = Scan {
        stamp: Stamp(0),
        robot_from_sensor: Pose2::identity(),
        sigmas: vec![0.01; 400],
        ranges: bearings.iter().map(range).collect(),
        bearings,
        qualities: vec![],
        bearing_sigma: 0.0,
        max_range: 10.0,
        sweep: 0.0,
    };
    let points = Points::from_scan(&scan, &Pose2::identity(), &PointConfig::default());
    for _ in 0..5 {
        grid.insert(&points, &Pose2::identity());
    }
    let wall = Wall {
        id: 3,
        segment: Segment::new(Point2::new(2.0, 0.0), Point2::new(2.0, 1.2)),
        sigma_direction: 0.01,
        sigma_across: 0.01,
        sightings: 5,
    };
    let way = [Point2::origin(), Point2::new(0.1, 0.2)];
    let map = Smap::of_run(&grid, way, &[wall], [(Point2::new(2.0, 1.2), 2)]).unwrap();
    let occupied = grid.rect_where(|odds| grid.state_of(odds) == CellState::Occupied);
    assert!(
        occupied.is_some() && map.points.len() > 60,
        "{}",
        map.points.len()
    );
    for point in &map.points {
        assert_eq!(grid.state(grid.cell_at(*point)), CellState::Occupied);
        let off = (point.x - 2.0).abs().min((point.y - 1.2).abs());
        assert!(off < 0.06, "{point}");
    }
    let edge = SmapLandmark {
        at: Point2::new(2.0, 0.6),
        confidence: 4,
        kind: LandmarkKind::Edge,
    };
    let point = SmapLandmark {
        at: Point2::new(2.0, 1.2),
        confidence: 2,
        kind: LandmarkKind::Point,
    };
    assert_eq!(
        (&map.landmarks[..], map.path.len()),
        (&[edge, point][..], 2)
    );
    let again = parse(map.write().as_bytes()).unwrap();
    let cells = |map: &Smap| -> Vec<_> { map.points.iter().map(|p| grid.cell_at(*p)).collect() };
    assert_eq!(cells(&again), cells(&map));
    let empty = Grid::new(GridConfig::default()).unwrap();
    let error = Smap::of_run(&empty, way, &[], []).unwrap_err();
    assert_eq!(error, SmapError::Map(MapServerError::Empty));
}

/// A drive along a room, in submaps of four keyframes.
fn driven() -> ScanMatcher {
    let config = ScanMatcherConfig {
        submap_keyframes: 4,
        ..ScanMatcherConfig::default()
    };
    let mut matcher = ScanMatcher::new(config).unwrap();
    let corners = [
        [-2.0, -1.5],
        [9.0, -1.5],
        [9.0, 2.0],
        [4.0, 2.0],
        [4.0, 3.0],
        [-2.0, 3.0],
    ];
    let corner = |i: usize| Point2::from(corners[i % corners.len()]);
    let walls: Vec<_> = (0..corners.len())
        .map(|i| Segment::new(corner(i), corner(i + 1)))
        .collect();
    for step in 0_u32..16 {
        let stamp = Stamp(u64::from(step + 1) * 500_000);
        let moved = if step == 0 { 0.0 } else { 0.4 };
        matcher.odometry(&Odometry {
            from: Stamp(stamp.0 - 500_000),
            to: stamp,
            motion: Pose2::new(moved, 0.0, 0.0),
            cov: Matrix3::identity() * 1e-4,
        });
        let mut points = look(&walls, &Pose2::new(0.4 * f64::from(step), 0.0, 0.0), 8.0);
        points.stamp = stamp;
        let sigmas = vec![0.001; points.beams.len()];
        matcher.update(&points, &sigmas);
    }
    matcher
}

#[test]
fn a_submap_of_a_run_lies_in_its_own_frame_with_the_way_through_it() {
    let matcher = driven();
    let count = matcher.submaps().len();
    assert!(count > 2, "{count}");
    let smap = Smap::of_submap(&matcher, 1).unwrap();
    let pose = matcher.submaps().nth(1).unwrap().map_from_submap;
    assert!(pose.x() > 0.5, "it begins on the way: {pose:?}");
    // Walls of the room and positions of the drive, placed by the submap's pose.
    assert!(smap.points.len() > 50);
    for point in &smap.points {
        let Point2 { coords: at } = pose * *point;
        let near = |value: f64, walls: &[f64]| walls.iter().any(|wall| (value - wall).abs() < 0.05);
        let is_wall = near(at.x, &[-2.0, 4.0, 9.0]) || near(at.y, &[-1.5, 2.0, 3.0]);
        assert!(is_wall, "{at}");
    }
    assert!(!smap.path.is_empty() && !smap.landmarks.is_empty());
    for landmark in &smap.landmarks {
        let Point2 { coords: at } = pose * landmark.at;
        let near = |value: f64, walls: &[f64]| walls.iter().any(|wall| (value - wall).abs() < 0.15);
        let is_corner = near(at.x, &[-2.0, 4.0, 9.0]) && near(at.y, &[-1.5, 2.0, 3.0]);
        assert!(is_corner && landmark.confidence > 0, "{landmark:?} {at}");
        assert_eq!(landmark.kind, LandmarkKind::Point);
    }
    for place in &smap.path {
        assert!((pose * *place).y.abs() < 0.03, "{place}");
    }
    let back = parse(smap.write().as_bytes()).unwrap();
    assert_eq!(back.map_points().walls.len(), smap.points.len());
    let extent = matcher.submaps().nth(1).unwrap().extent();
    assert!((extent.y - 4.5).abs() < 0.1, "{extent}");

    let making = count - 1;
    assert_eq!(
        Smap::of_submap(&matcher, making),
        Err(SmapError::Unfinished { submap: making })
    );
    assert_eq!(
        Smap::of_submap(&matcher, count),
        Err(SmapError::NoSubmap {
            submap: count,
            count
        })
    );
}

#[test]
fn an_edge_is_no_landmark_to_be_found_again() {
    let at = |x: f64, kind| SmapLandmark {
        at: Point2::new(x, 1.0),
        confidence: 3,
        kind,
    };
    let smap = Smap {
        landmarks: vec![at(1.0, LandmarkKind::Edge), at(2.0, LandmarkKind::Point)],
        ..Smap::default()
    };
    assert_eq!(smap.map_points().landmarks, [Point2::new(2.0, 1.0)]);
}

fn place() -> impl Strategy<Value = Point2<f64>> {
    let along = || prop_oneof![-100.0..100.0_f64, Just(0.0), Just(-0.0), -1e6..1e6_f64];
    (along(), along()).prop_map(|(x, y)| Point2::new(x, y))
}

fn smap() -> impl Strategy<Value = Smap> {
    let places = || proptest::collection::vec(place(), 0..30);
    let kind = prop_oneof![Just(LandmarkKind::Point), Just(LandmarkKind::Edge)];
    let landmark = (place(), any::<u32>(), kind);
    let landmark = landmark.prop_map(|(at, confidence, kind)| SmapLandmark {
        at,
        confidence,
        kind,
    });
    let landmarks = proptest::collection::vec(landmark, 0..10);
    let all = (places(), places(), landmarks);
    all.prop_map(|(points, path, landmarks)| Smap {
        points,
        path,
        landmarks,
    })
}

proptest! {
    #[test]
    fn what_is_written_reads_the_same_to_a_micrometre(map in smap()) {
        let text = map.write();
        let again = parse(text.as_bytes()).unwrap();
        prop_assert_eq!(again.write(), text);
        let pairs = map.points.iter().chain(&map.path).zip(again.points.iter().chain(&again.path));
        for (a, b) in pairs {
            prop_assert!((a - b).amax() < 0.501e-6, "{} {}", a, b);
        }
        prop_assert_eq!(map.points.len(), again.points.len());
        prop_assert_eq!(map.path.len(), again.path.len());
        prop_assert_eq!(map.landmarks.len(), again.landmarks.len());
        for (a, b) in map.landmarks.iter().zip(&again.landmarks) {
            prop_assert_eq!((a.confidence, a.kind), (b.confidence, b.kind));
        }
    }

    #[test]
    fn any_bytes_are_a_submap_or_an_error(
        edits in proptest::collection::vec((0.0..1.0_f64, 0_u8..3, any::<u8>()), 0..6),
    ) {
        let mut bytes = PAPER.as_bytes().to_vec();
        for (place, kind, byte) in edits {
            let at = (bytes.len() as f64 * place) as usize;
            match (kind, bytes.get_mut(at)) {
                (0, _) => bytes.truncate(at),
                (1, Some(old)) => *old = byte,
                _ => bytes.insert(at, byte),
            }
        }
        if let Ok(map) = parse(&bytes) {
            prop_assert_eq!(parse(map.write().as_bytes()).unwrap().write(), map.write());
        }
    }
}
