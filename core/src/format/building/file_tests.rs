//! One building in every format: recognised by the name, the same walls in each.

use super::*;
use crate::format::map_server::{self, MapImage, MapMode};
use crate::format::smap::{LandmarkKind, Smap, SmapLandmark};
use crate::format::{og_map, world};
use crate::sim::{Caster, worlds};

/// `doors` in each format: names and bytes.
fn formats() -> Vec<Vec<(&'static str, Vec<u8>)>> {
    let doors = worlds::builtin("doors").unwrap();
    let map = super::tests::drawn(&doors, 0.05, Pose2::new(-0.4, -0.3, 0.0));
    let ros = map_server::write(&map, MapMode::Trinary, MapImage::Pgm, "doors.pgm").unwrap();
    let text = og_map::write(&og_map::OgMap {
        width: map.width,
        height: map.height,
        resolution: map.resolution,
        origin: map.origin.position(),
        probabilities: map.cells.iter().map(|&c| f64::from(c) / 100.0).collect(),
    });
    let submap = submap_of(&map, doors.start.position());
    let walls: Vec<_> = doors.walls().iter().map(|wall| wall.segment).collect();
    let svg = walls.iter().fold(String::new(), |all, w| {
        let [a, b] = [w.a, w.b];
        let line = format!(
            r#"<line x1="{}" y1="{}" x2="{}" y2="{}" stroke="black"/>"#,
            a.x, -a.y, b.x, -b.y
        );
        all + &line
    });
    let svg =
        format!(r#"<svg xmlns="http://www.w3.org/2000/svg" data-metres-per-unit="1">{svg}</svg>"#);
    vec![
        vec![
            ("maps/doors.pgm", ros.image),
            ("doors.YAML", ros.yaml.into()),
        ],
        vec![("OGmap.txt", text.into())],
        vec![("doors.svg", svg.into())],
        vec![("doors.json", world::write(&doors).into())],
        vec![("doors.smap", submap.write().into())],
    ]
}

/// The occupied cells as points.
fn submap_of(map: &OccupancyMap, start: Point2<f64>) -> Smap {
    let place = |at: usize| {
        let (col, row) = (at % map.width, at / map.width);
        let middle = Point2::new(col as f64 + 0.5, row as f64 + 0.5);
        map.origin * (middle * map.resolution)
    };
    let occupied = (0..map.cells.len()).filter(|at| map.cells[*at] > 65);
    Smap {
        points: occupied.map(place).collect(),
        path: vec![start],
        landmarks: vec![],
    }
}

fn read(files: &[(&'static str, Vec<u8>)]) -> Result<BuildingFile, BuildingFileError> {
    let files: Vec<(&str, &[u8])> = files.iter().map(|(n, b)| (*n, b.as_slice())).collect();
    BuildingFile::read(&files, None)
}

#[test]
fn every_format_shows_the_same_walls_to_drive_in_and_to_be_found_by() {
    let doors = worlds::builtin("doors").unwrap();
    let truth = Caster::new(doors.walls());
    for files in formats() {
        let (name, _) = files[0];
        let building = read(&files).unwrap();
        let known = building.prior_walls().unwrap();
        let length: f64 = known.faces.iter().map(Segment::length).sum();
        let whole: f64 = doors.walls().iter().map(|w| w.segment.length()).sum();
        // A submap knows what the robot could reach: the walls of `doors`, two-sided partitions and
        // boxes, are all seen from one side, if at all. In the other formats everything but walls
        // is free.
        let sides = match name {
            "doors.smap" => 0.8..1.0,
            _ => 1.2..2.2,
        };
        assert!(
            sides.contains(&(length / whole)),
            "{name}: {length} of {whole}"
        );
        for face in &known.faces {
            // Along the face; the borders of cells lie beside the walls.
            for k in 0..=4 {
                let at = face.a + face.vector() * f64::from(k) / 4.0;
                assert!(truth.clearance(at, 1.0) < 0.1, "{name}: {at}");
            }
        }
        assert!(truth.clearance(known.start.position(), 1.0) > 0.1, "{name}");
        let world = building.into_world("again").unwrap().world;
        assert!(world.validate(world.robot.model().radius()).is_ok());
    }
}

#[test]
fn the_fence_around_a_plan_is_no_wall_to_be_found_by() {
    let [_, _, svg, _, _] = &formats()[..] else {
        panic!("five formats")
    };
    let plan = read(svg).unwrap();
    let known = plan.prior_walls().unwrap().faces.len();
    let walls = plan.into_world("").unwrap().world.walls().len();
    assert_eq!(known, 2 * (walls - FENCE_SIDES));
}

#[test]
fn what_shows_no_building_is_named() {
    let error = |files: &[(&'static str, Vec<u8>)]| read(files).unwrap_err().to_string();
    let all = formats();
    assert!(error(&all[0][..1]).starts_with("`maps/doors.pgm` is one half of a map"));
    assert!(error(&all[0][1..]).starts_with("`doors.YAML` is one half of a map"));
    assert!(error(&[("drive.clf", vec![])]).starts_with("`drive.clf` is no building; expected"));
    assert!(error(&[]).starts_with("`` is no building"));
    let cut = vec![("OGmap.txt", all[1][0].1[..2000].to_vec())];
    assert!(error(&cut).starts_with("line "), "{}", error(&cut));
    let nothing = vec![("OGmap.txt", b"2 2 0.05 0 0\n0.1 0.1\n0.1 0.1\n".to_vec())];
    let error = read(&nothing).unwrap().prior_walls().unwrap_err();
    assert_eq!(error, BuildingError::NoWalls);
}

/// What the robot reached is free, what lies behind walls is unknown, and a submap far larger than
/// a building is refused before memory is allocated.
#[test]
fn a_submap_is_free_where_the_robot_could_go() {
    let side = |k: i32| 0.05 * (f64::from(k) + 0.5);
    let wall = (0..=20).flat_map(|k| {
        [
            (side(k), side(0)),
            (side(k), side(20)),
            (side(0), side(k)),
            (side(20), side(k)),
        ]
    });
    let mut submap = Smap {
        points: wall.map(|(x, y)| Point2::new(x, y)).collect(),
        path: vec![Point2::new(0.5, 0.5)],
        landmarks: vec![SmapLandmark {
            at: Point2::new(90.0, 0.0),
            confidence: 3,
            kind: LandmarkKind::Edge,
        }],
    };
    let map = |submap: &Smap| {
        let text = submap.write();
        match read(&[("a.smap", text.into_bytes())]) {
            Ok(BuildingFile::Map(map)) => Ok(map),
            Ok(other) => panic!("{other:?}"),
            Err(error) => Err(error.to_string()),
        }
    };
    let count = |map: &OccupancyMap, cell: i8| map.cells.iter().filter(|c| **c == cell).count();
    let closed = map(&submap).unwrap();
    // A row of cells around it all.
    assert_eq!((closed.width, closed.height), (23, 23));
    assert_eq!(
        [100, 0, -1].map(|cell| count(&closed, cell)),
        [80, 19 * 19, 88]
    );
    // From the gap in a wall it goes around it.
    submap
        .points
        .retain(|point| (point.x, point.y) != (side(20), side(7)));
    assert_eq!(
        [100, 0, -1].map(|cell| count(&map(&submap).unwrap(), cell)),
        [79, 450, 0]
    );
    submap.path.clear();
    assert_eq!(count(&map(&submap).unwrap(), 0), 450);
    submap.points.push(Point2::new(1e6, 1e6));
    assert!(
        map(&submap)
            .unwrap_err()
            .contains("expected at most 64000000 for a building")
    );
    submap.points.clear();
    assert_eq!(
        map(&submap).unwrap_err(),
        BuildingError::NoWalls.to_string()
    );
    let error = read(&[("a.smap", b"#points\n1\n1,x\n".to_vec())]).unwrap_err();
    assert!(error.to_string().starts_with("line 3: y is `x`"), "{error}");
}
