//! Each file is read back by rules that are written out here independently.

use serde_json::Value;

use super::*;

fn wall(id: u32, a: (f64, f64), b: (f64, f64)) -> Wall {
    Wall {
        id,
        segment: Segment::new(Point2::new(a.0, a.1), Point2::new(b.0, b.1)),
        sigma_direction: 0.001,
        sigma_across: 0.002,
        sightings: 17,
    }
}

fn walls() -> Vec<Wall> {
    vec![
        wall(0, (0.0, 0.0), (3.0, 4.0)),
        wall(3, (-1.5, 2.25), (-1.5, 0.25)),
        wall(4, (1.0, 1.0), (1.0, 1.3)),
    ]
}

/// Values of the attribute `name` of the elements `element`, in order.
fn attributes(svg: &str, element: &str, name: &str) -> Vec<f64> {
    let opening = format!("<{element} ");
    let elements = svg.split(&opening).skip(1);
    let value = |text: &str| {
        let text = text.split('>').next()?;
        let rest = text.split(&format!("{name}=\"")).nth(1)?;
        rest.split('"').next()?.parse().ok()
    };
    elements.map(|text| value(text).unwrap()).collect()
}

#[test]
fn svg_draws_each_wall_where_it_is_with_y_down() {
    let svg = svg(&walls(), Some(Point2::new(0.5, 1.5))).unwrap();
    assert_eq!(attributes(&svg, "line", "x1"), [0.0, -1.5, 1.0]);
    assert_eq!(attributes(&svg, "line", "y2"), [-4.0, -0.25, -1.3]);
    assert!(svg.contains("<title>5.000 m</title>"));
    assert!(svg.contains("<circle id=\"start\" cx=\"0.5000\" cy=\"-1.5000\""));
    // The short wall has no text; whether upwards or downwards, the text is never upside down.
    assert_eq!(svg.matches("<text").count(), 2);
    assert!(svg.contains(">5.00</text>") && svg.contains(">2.00</text>"));
    let turns: Vec<f64> = svg
        .split("rotate(")
        .skip(1)
        .map(|text| text.split(' ').next().unwrap().parse().unwrap())
        .collect();
    assert!(turns.iter().all(|turn| turn.abs() <= 90.01), "{turns:?}");
    // 4.5 m and 4 m of walls, half a metre around, a centimetre for each metre.
    assert!(svg.contains("width=\"55.00mm\" height=\"50.00mm\""));
    assert!(svg.contains("viewBox=\"-2.000 -4.500 5.500 5.000\""));
}

#[test]
fn dxf_is_pairs_of_code_and_value_with_a_line_for_each_wall() {
    let dxf = dxf(&walls()).unwrap();
    let lines: Vec<&str> = dxf.lines().collect();
    let pairs: Vec<(u32, &str)> = lines
        .chunks(2)
        .map(|pair| (pair[0].parse().unwrap(), pair[1]))
        .collect();
    assert_eq!(pairs.last(), Some(&(0, "EOF")));
    let count = |what: &str| pairs.iter().filter(|pair| **pair == (0, what)).count();
    assert_eq!((count("SECTION"), count("ENDSEC")), (3, 3));
    assert_eq!((count("LINE"), count("TEXT")), (3, 2));
    let at = pairs.iter().position(|pair| *pair == (0, "LINE")).unwrap();
    let value = |code| {
        let mut of_entity = pairs[at + 1..].iter().take_while(|pair| pair.0 != 0);
        let value = of_entity.find(|pair| pair.0 == code).unwrap().1;
        value.parse::<f64>().unwrap()
    };
    assert_eq!([10, 20, 11, 21].map(value), [0.0, 0.0, 3.0, 4.0]);
    assert!(pairs.contains(&(1, "5.00")));
}

#[test]
fn geojson_holds_every_wall_to_the_bit() {
    let walls = walls();
    let json: Value = serde_json::from_str(&geojson(&walls).unwrap()).unwrap();
    assert_eq!(json["type"], "FeatureCollection");
    let features = json["features"].as_array().unwrap();
    assert_eq!(features.len(), walls.len());
    for (feature, wall) in features.iter().zip(&walls) {
        assert_eq!(feature["id"], wall.id);
        assert_eq!(feature["geometry"]["type"], "LineString");
        let end = |i: usize, axis: usize| feature["geometry"]["coordinates"][i][axis].as_f64();
        let (a, b) = (wall.segment.a, wall.segment.b);
        assert_eq!([end(0, 0), end(0, 1)], [Some(a.x), Some(a.y)]);
        assert_eq!([end(1, 0), end(1, 1)], [Some(b.x), Some(b.y)]);
        let length = feature["properties"]["length_m"].as_f64();
        assert_eq!(length, Some(wall.segment.length()));
    }
}

#[test]
fn nothing_and_nonsense_are_refused() {
    assert_eq!(svg(&[], None), Err(FloorPlanError::Empty));
    assert_eq!(geojson(&[]), Err(FloorPlanError::Empty));
    let bad = [wall(7, (0.0, f64::NAN), (1.0, 0.0))];
    assert_eq!(dxf(&bad), Err(FloorPlanError::NotFinite { id: 7 }));
}
