//! World files: errors with their lines, round trips, damaged files.

use proptest::prelude::*;

use nalgebra::{Point2, Vector2};

use super::*;
use crate::geom::{Pose2, Segment};
use crate::sim::{Door, Material, Mover, Obstacle, RobotKind, SensorKind, Shape, worlds};

const ROOM: &str = r#"{
  "slamlab_world": 1,
  "name": "room",
  "start": { "x": 1.0, "y": 1.0 },
  "obstacles": [
    { "shape": "polyline", "closed": true, "points": [[0, 0], [4, 0], [4, 3], [0, 3]] },
    { "shape": "circle", "centre": [3, 1], "radius": 0.2 }
  ]
}"#;

fn check(from: &str, to: &str, expect: &[&str]) {
    assert!(ROOM.contains(from), "{from}");
    let error = read(ROOM.replace(from, to).as_bytes())
        .unwrap_err()
        .to_string();
    for part in expect {
        assert!(error.contains(part), "{part:?} is not in {error:?}");
    }
}

#[test]
fn errors_say_line_field_and_what_was_expected() {
    assert!(read(ROOM.as_bytes()).is_ok());
    check(
        r#""name": "room","#,
        "",
        &["line 9, column 1", "missing field `name`"],
    );
    check(
        r#""x": 1.0"#,
        r#""x": 3.0"#,
        &[
            "line 4",
            "radius 0.1101 m at (3, 1)",
            "obstacle 1 (a circle)",
        ],
    );
    check(
        r#""x": 1.0"#,
        r#""x": 0.05"#,
        &["line 4", "obstacle 0 (a polyline), 0.050 m"],
    );
    check(
        r#""x": 1.0"#,
        r#""x": 1e999"#,
        &["line 4", "number out of range"],
    );
    check(r#""x": 1.0"#, r#""x": NaN"#, &["line 4", "expected"]);
    check(
        r#""x": 1.0"#,
        r#""x": 1e6"#,
        &["line 4", "start: x is 1000000", "within ±10000"],
    );
    check(
        r#""x": 1.0"#,
        r#""x": "one""#,
        &[
            "line 4",
            "start.x: invalid type: string \"one\", expected a number",
        ],
    );
    check(
        "0.2 }",
        "-0.2 }",
        &["line 7", "obstacle 1: radius is -0.2", "0.001 to 10000 m"],
    );
    check(
        "0.2 }",
        r#"0.2, "material": "wood" }"#,
        &[
            "line 7",
            "obstacles[1].material: unknown variant `wood`, expected one of",
            "`opaque`, `glass`, `dark`",
        ],
    );
    check(
        "0.2 }",
        r#"0.2, "angle": 1 }"#,
        &[
            "line 7",
            "circle has the field `angle`",
            "`centre`, `radius`",
        ],
    );
    check(
        r#", "radius": 0.2"#,
        "",
        &["line 7", "circle lacks the field `radius`"],
    );
    check(
        r#""radius": 0.2"#,
        r#""radios": 0.2"#,
        &[
            "line 7",
            "obstacles[1].radios: unknown field `radios`, expected one of",
        ],
    );
    check(
        r#""circle""#,
        r#""ring""#,
        &["line 7", "obstacles[1].shape: unknown variant `ring`"],
    );
    check(
        "[4, 0], ",
        "[4, 0, 1], ",
        &["line 6", "obstacles[0].points[1]"],
    );
    check(
        "[4, 0], ",
        "[4], ",
        &[
            "line 6",
            "obstacles[0].points[1]",
            "a pair of numbers [x, y]",
        ],
    );
    check(
        "[3, 1]",
        "3",
        &[
            "line 7",
            "obstacles[1].centre: invalid type: integer `3`, expected a pair of numbers [x, y]",
        ],
    );
    check(r#""y": 1.0 }"#, r#""y": 1.0 } }"#, &["line 4"]);
    check(
        r#""name": "room","#,
        r#""name": "room""#,
        &["line 4", "expected `,` or `}`"],
    );
    check(
        "[[0, 0], [4, 0], [4, 3], [0, 3]]",
        "[[0, 0]]",
        &["line 6", "obstacle 0: has 1 points"],
    );
    check(
        r#""slamlab_world": 1"#,
        r#""slamlab_world": 2"#,
        &["line 2", "slamlab_world is 2, expected 1"],
    );
    check("  ]\n}", "  ]", &["line 8", "EOF while parsing an object"]);
    check("room", &"r".repeat(300), &["line 3", "name has 300 bytes"]);
}

#[test]
fn what_is_no_world_file_is_refused() {
    let error = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
    assert!(error(b"").contains("empty"));
    assert!(error(b" \n").contains("empty"));
    assert!(error(b"\xff\xd8\xff\xe0\0\x10JFIF").contains("line 1, column 1"));
    assert!(error(b"[]").contains("line 1"));
    assert!(error("[".repeat(100_000).as_bytes()).contains("line 1"));
    let walls = "[0,0],".repeat(200_001);
    let many = ROOM.replace(
        "[[0, 0], [4, 0], [4, 3], [0, 3]]",
        &format!("[{walls}[1,1]]"),
    );
    let many = error(many.as_bytes());
    assert!(
        many.contains("has 200003 walls") || many.contains("walls, expected at most 200000"),
        "{many}"
    );
}

#[test]
fn a_fault_names_the_part_of_the_drawing() {
    let fault = |text: &str| WorldFault::from(&read(text.as_bytes()).unwrap_err());
    let with = |parts: &str| {
        fault(&format!(
            r#"{{ "slamlab_world": 1, "name": "x", "start": {{ "x": 0, "y": 0 }}, {parts} }}"#
        ))
    };
    let inside = with(
        r#""obstacles": [ { "shape": "circle", "centre": [3, 0], "radius": 1 },
                          { "shape": "circle", "centre": [0, 0], "radius": 1 } ]"#,
    );
    assert_eq!((inside.part.as_str(), inside.index), ("start", None));
    assert!(inside.text.contains("stands in obstacle 1 (a circle)"));
    let thin = with(
        r#""obstacles": [], "doors": [ { "from": [1, 0], "to": [2, 0] },
                                       { "from": [1, 1], "to": [1, 1] } ]"#,
    );
    assert_eq!((thin.part.as_str(), thin.index), ("door", Some(1)));
    assert!(thin.text.starts_with("door 1: width is 0"), "{}", thin.text);
    let shapeless = with(r#""obstacles": [ { "shape": "circle", "centre": [0, 0] } ]"#);
    assert_eq!((shapeless.part.as_str(), shapeless.index), ("file", None));
    assert_eq!(fault("[").part, "file");
    assert_eq!(fault("").part, "file");
}

#[test]
fn built_in_worlds_survive_being_written_and_read() {
    for name in worlds::NAMES {
        let world = worlds::builtin(name).unwrap();
        let again = read(write(&world).as_bytes()).unwrap();
        assert_eq!(again, world, "{name}");
    }
}

#[test]
fn schema_is_json_and_names_every_field_of_a_written_world() {
    let schema: serde_json::Value = serde_json::from_str(SCHEMA).unwrap();
    let names = &schema["properties"]["sensor"]["enum"];
    assert_eq!(
        *names,
        serde_json::json!(SensorKind::ALL.map(|(name, ..)| name))
    );
    let mut world = worlds::builtin("arena").unwrap();
    world.movers.push(Mover {
        waypoints: vec![Point2::new(4.0, 1.0)],
        closed: true,
        speed: 0.3,
        radius: 0.2,
        pause: 1.5,
    });
    let written: serde_json::Value = serde_json::from_str(&write(&world)).unwrap();
    for (key, _) in written.as_object().unwrap() {
        assert!(schema["properties"].get(key).is_some(), "{key}");
    }
    for key in schema["required"].as_array().unwrap() {
        assert!(written.get(key.as_str().unwrap()).is_some(), "{key}");
    }
    for (key, _) in written["movers"][0].as_object().unwrap() {
        assert!(
            schema["properties"]["movers"]["items"]["properties"]
                .get(key)
                .is_some(),
            "{key}"
        );
    }
}

fn coordinate() -> impl Strategy<Value = f64> {
    -100.0..100.0_f64
}

fn point() -> impl Strategy<Value = Point2<f64>> {
    (coordinate(), coordinate()).prop_map(|(x, y)| Point2::new(x, y))
}

fn obstacle() -> impl Strategy<Value = Obstacle> {
    let many = |least| proptest::collection::vec(point(), least..8);
    let shape = prop_oneof![
        (many(3), any::<bool>()).prop_map(|(points, closed)| Shape::Polyline { points, closed }),
        many(3).prop_map(Shape::Polygon),
        (point(), 0.01..9.0_f64, 0.01..9.0_f64, -4.0..4.0_f64).prop_map(|(centre, w, h, angle)| {
            Shape::Rectangle {
                centre,
                size: Vector2::new(w, h),
                angle,
            }
        }),
        (point(), 0.01..9.0_f64).prop_map(|(centre, radius)| Shape::Circle { centre, radius }),
    ];
    let material = prop_oneof![
        Just(Material::Opaque),
        Just(Material::Glass),
        Just(Material::Dark)
    ];
    (shape, material).prop_map(|(shape, material)| Obstacle { shape, material })
}

fn world() -> impl Strategy<Value = World> {
    let mover = (
        proptest::collection::vec(point(), 1..5),
        any::<bool>(),
        0.0..2.0_f64,
        0.05..0.5_f64,
        prop_oneof![Just(0.0), 0.0..60.0_f64],
    )
        .prop_map(|(waypoints, closed, speed, radius, pause)| Mover {
            waypoints,
            closed,
            speed,
            radius,
            pause,
        });
    let door = (
        point(),
        0.5..2.0_f64,
        any::<bool>(),
        proptest::collection::vec(0.1..9.0_f64, 0..4),
    )
        .prop_map(|(a, width, is_open, waits)| Door {
            leaf: Segment::new(a, a + nalgebra::Vector2::new(width, 0.0)),
            is_open,
            switches: waits
                .iter()
                .scan(0.0, |at, wait| {
                    *at += wait;
                    Some(*at)
                })
                .collect(),
        });
    let lists = (
        proptest::collection::vec(obstacle(), 0..6),
        proptest::collection::vec(door, 0..3),
        proptest::collection::vec(mover, 0..3),
    );
    (
        ".{0,20}",
        lists,
        proptest::option::of(point()),
        any::<u64>(),
        any::<bool>(),
        0..SensorKind::ALL.len(),
    )
        .prop_map(
            |(name, (obstacles, doors, movers), goal, seed, pioneer, sensor)| World {
                obstacles,
                doors,
                movers,
                goal,
                seed,
                robot: if pioneer {
                    RobotKind::Pioneer
                } else {
                    RobotKind::Rp6
                },
                sensor: SensorKind::ALL[sensor].1,
                // Away from everything above.
                ..World::new(name, Pose2::new(500.0, -500.0, 0.0))
            },
        )
}

/// Worlds whose files are damaged a few hundred times: all but `campus`, which is 2 MB.
const SMALL: [&str; 11] = [
    "arena",
    "doors",
    "office",
    "corridor",
    "loop",
    "maze",
    "lab",
    "warehouse",
    "crowd",
    "look-alikes",
    "parallel",
];

proptest! {
    #[test]
    fn worlds_survive_being_written_and_read(world in world()) {
        prop_assert_eq!(read(write(&world).as_bytes()).unwrap(), world);
    }

    #[test]
    fn damaged_files_do_not_panic(
        which in 0..SMALL.len(), cut in 0.0..1.0_f64, edits in proptest::collection::vec((0.0..1.0_f64, any::<u8>()), 0..6),
    ) {
        let mut bytes = write(&worlds::builtin(SMALL[which]).unwrap()).into_bytes();
        for (place, byte) in edits {
            let at = (place * bytes.len() as f64) as usize;
            bytes[at] = byte;
        }
        bytes.truncate((cut * 1.5 * bytes.len() as f64) as usize);
        if let Err(error) = read(&bytes) {
            prop_assert!(error.to_string().starts_with("world file"));
        }
    }

    #[test]
    fn noise_does_not_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let _ = read(&bytes);
    }
}
