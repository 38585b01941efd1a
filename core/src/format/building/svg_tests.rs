//! Drawings whose walls are known.

use proptest::prelude::*;

use super::*;
use crate::format::floor_plan;
use crate::geom::Length;

fn drawing(body: &str) -> String {
    format!("<svg xmlns='http://www.w3.org/2000/svg' data-metres-per-unit='0.5'>\n{body}\n</svg>")
}

fn walls(body: &str) -> Vec<[f64; 4]> {
    let room = "<rect x='-20' y='-20' width='40' height='40' fill='none' stroke='black'/>";
    let imported = of_svg(drawing(&format!("{room}{body}")).as_bytes(), None, "s").unwrap();
    let walls = imported.world.walls();
    // The room's own four, and those of the fence.
    let rest = &walls[4..walls.len() - 4];
    let rounded = |n: f64| (n * 1e6).round() / 1e6 + 0.0;
    rest.iter()
        .map(|w| [w.segment.a.x, w.segment.a.y, w.segment.b.x, w.segment.b.y].map(rounded))
        .collect()
}

#[test]
fn every_shape_becomes_the_walls_that_were_drawn() {
    assert_eq!(
        walls("<line x1='1' y1='2' x2='3' y2='4' stroke='red'/>"),
        [[0.5, -1.0, 1.5, -2.0]]
    );
    assert_eq!(
        walls("<polyline points='0,0 2,0 2 4'/>"),
        [[0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 1.0, -2.0]]
    );
    let triangle = [
        [0.0, 0.0, 1.0, 0.0],
        [1.0, 0.0, 1.0, -2.0],
        [1.0, -2.0, 0.0, 0.0],
    ];
    assert_eq!(walls("<polygon points='0,0 2,0 2,4'/>"), triangle);
    assert_eq!(walls("<path d='M0 0h2v4z'/>"), triangle);
    assert_eq!(
        walls("<path d='m0,0 2,0 0,4Z m4 0 h2'/>").last(),
        Some(&[2.0, 0.0, 3.0, 0.0])
    );
    assert_eq!(
        walls("<rect x='2' y='2' width='2' height='4' style='fill:none; stroke:#123'/>").len(),
        4
    );
    // Turned by a quarter, then moved; 90° take x to y, which is down in a drawing.
    let turned =
        "<g transform='translate(10 0)'><line x2='2' transform='rotate(90)' stroke='red'/></g>";
    assert_eq!(walls(turned), [[5.0, 0.0, 5.0, -1.0]]);
    assert_eq!(
        walls(
            "<line x2='4' transform='rotate(180 1 1) skewX(45) matrix(1 0 0 1 0 0) scale(.5)' stroke='red'/>"
        ),
        [[1.0, -1.0, 0.0, -1.0]]
    );
    for (round, area) in [
        ("<circle cx='2' cy='-4' r='6'/>", 9.0),
        ("<ellipse cx='2' cy='-4' rx='6' ry='3'/>", 4.5),
        ("<path d='M8-4A6 6 0 1 1-4-4A6 6 0 1 1 8-4'/>", 9.0),
    ] {
        let found = walls(round);
        let cross: f64 = found
            .iter()
            .map(|[ax, ay, bx, by]| 0.5 * (ax * by - ay * bx))
            .sum();
        assert!(
            (cross.abs() - area * std::f64::consts::PI).abs() < 0.1,
            "{round}: {cross}"
        );
        assert!(found.len() < 200);
    }
}

#[test]
fn paper_hidden_things_and_words_are_no_walls() {
    for body in [
        "<rect width='9' height='9' fill='white'/>",
        "<rect width='9' height='9' fill='#FFF' stroke='none'/>",
        "<line x2='9'/>",
        "<g display='none'><line x2='9' stroke='red'/></g>",
        "<g style='visibility: hidden'><line x2='9' stroke='red'/></g>",
        "<defs><line x2='9' stroke='red'/></defs>",
        "<text x='1' y='1'>12 m</text><title>plan</title>",
        "<rect width='0' height='9'/>",
    ] {
        assert!(walls(body).is_empty(), "{body}");
    }
    assert_eq!(
        walls("<g stroke='none' fill='none'><line x2='9' stroke='red'/></g>").len(),
        1
    );
    let plan =
        drawing("<rect width='40' height='40'/><use href='#a'/><use href='o.svg#b'/><image/>");
    let none = "2 × <use> (copies of what is not in the file, or has a view box of its own)";
    assert_eq!(
        of_svg(plan.as_bytes(), None, "s").unwrap().skipped,
        [none, "1 × <image>"]
    );
}

#[test]
fn start_goal_and_scale_are_what_the_drawing_says() {
    let room = "<rect width='10' height='8' fill='none' stroke='black'/>";
    let plan = drawing(&format!(
        "{room}<circle id='start' cx='2' cy='2' r='.2'/><rect id='goal' x='6' y='5' width='2' height='2'/>"
    ));
    let world = of_svg(plan.as_bytes(), None, "s").unwrap().world;
    assert_eq!(world.start.position(), Point2::new(1.0, -1.0));
    assert_eq!(world.goal, Some(Point2::new(3.5, -3.0)));
    assert_eq!(world.wall_count(), 8);
    let world = of_svg(plan.as_bytes(), Some(2.0), "s").unwrap().world;
    assert_eq!(world.start.position(), Point2::new(4.0, -4.0));
    let start = of_svg(drawing(room).as_bytes(), None, "s")
        .unwrap()
        .world
        .start
        .position();
    // In the middle of the room, not outside.
    assert!(
        start.x > 1.5 && start.x < 3.5 && (start.y + 2.0).abs() < 0.1,
        "{start}"
    );
    let of = |head: &str| {
        let plan = format!("<svg {head}><rect width='1000' height='600' stroke='black'/></svg>");
        let walls = of_svg(plan.as_bytes(), None, "s").unwrap().world.walls();
        walls[0].segment.length().max(walls[1].segment.length())
    };
    assert!((of("") - 10.0).abs() < 1e-9);
    assert!((of("width='100%' viewBox='0 0 1000 600'") - 10.0).abs() < 1e-9);
    assert!((of("width='8000mm' viewBox='0 0 1000 600'") - 8.0).abs() < 1e-9);
}

#[test]
fn a_floor_plan_that_was_written_is_read_back() {
    let wall = |id: u32, a: (f64, f64), b: (f64, f64)| crate::map::Wall {
        id,
        segment: Segment::new(Point2::new(a.0, a.1), Point2::new(b.0, b.1)),
        sigma_direction: 0.01,
        sigma_across: 0.01,
        sightings: 3,
    };
    let walls = [
        wall(1, (0.0, 0.0), (4.0, 0.0)),
        wall(2, (4.0, 0.0), (4.0, 3.0)),
        wall(3, (4.0, 3.0), (0.0, 3.0)),
        wall(4, (0.0, 3.0), (-0.5, 0.0)),
    ];
    let text = floor_plan::svg(&walls, Some(Point2::new(1.25, 2.0))).unwrap();
    let world = of_svg(text.as_bytes(), None, "plan").unwrap().world;
    for (wall, back) in walls.iter().zip(world.walls()) {
        assert!(
            (wall.segment.a - back.segment.a).length() < 1e-4
                && (wall.segment.b - back.segment.b).length() < 1e-4
        );
    }
    assert_eq!(world.wall_count(), 8);
    let off = world.start.position() - Point2::new(1.25, 2.0);
    assert!(off.length() < 1e-3, "the robot begins where it did: {off}");
}

#[test]
fn bad_drawings_are_told_what_where_and_what_was_expected() {
    let error = |text: &str| of_svg(text.as_bytes(), None, "s").unwrap_err().to_string();
    assert!(error("").starts_with("line 1:"), "{}", error(""));
    assert!(error("<svg>\n<g>").starts_with("line "));
    assert_eq!(
        error("<html/>"),
        "line 1: <html> begins the file, expected <svg>"
    );
    assert_eq!(
        error("<svg/>"),
        "there is no wall in it; expected at least one"
    );
    assert_eq!(
        error(&drawing("<line x1='a'/>")),
        "line 2: x1 of <line> is `a`, expected a finite length in units of the drawing, px, in, cm, mm, pt or pc"
    );
    assert!(
        error(&drawing("<rect width='50%' height='1'/>"))
            .contains("line 2: width of <rect> is `50%`")
    );
    assert!(
        error(&drawing("\n<g transform='spin(3)'/>"))
            .contains("line 3: transform of <g> is `spin(3)`")
    );
    assert!(error(&drawing("<polygon points='0,0 1,x'/>")).contains("points of <polygon>"));
    assert!(
        error(&drawing("<path d='M0 0 L'/>"))
            .contains("line 2: the attribute d of <path> cannot be read")
    );
    assert!(
        error("<svg data-metres-per-unit='-1'/>")
            .contains("data-metres-per-unit of <svg> is `-1`, expected a number above 0")
    );
    assert!(
        error(&drawing("<line x2='1e300' stroke='red'/>")).contains("expected 1 to 2000 m a side")
    );
    // Curves that must not be turned into straight pieces.
    for path in ["M0 0C1e60 0 0 1e60 5 5", "M0 0Q1e20 0 0 1e20"] {
        let path = format!("<path d='{path}' stroke='red'/>");
        assert!(error(&drawing(&path)).contains("expected 1 to 2000 m a side"));
    }
    assert!(error(&drawing("<circle r='1e300' stroke='red'/>")).contains("a radius within"));
    assert!(
        error(&drawing("<ellipse rx='1' ry='1e99' stroke='red'/>")).contains("a radius within")
    );
    assert!(
        error(&drawing("<line x2='.1' stroke='red'/>")).contains("0.05 m x 0.00 m at 0.5 m a unit")
    );
    let narrow = "<rect width='4' height='.2' fill='none' stroke='red'/>";
    assert!(
        error(&drawing(narrow)).contains("nowhere is room")
            || error(&drawing(narrow)).contains("start")
    );
    assert_eq!(
        of_svg(b"<svg/>", Some(f64::NAN), "s")
            .unwrap_err()
            .to_string(),
        "a scale of NaN m a unit, expected a finite number above 0"
    );
    // The parser refuses entities that expand without end.
    assert!(error("<!DOCTYPE svg [<!ENTITY a 'aaaa'>]><svg>&a;</svg>").starts_with("line 1:"));
    let deep = "<g>".repeat(3000) + &"</g>".repeat(3000);
    assert!(!error(&drawing(&deep)).is_empty());
}

proptest! {
    #[test]
    fn damaged_drawings_never_panic(edits in proptest::collection::vec((0.0..1.0_f64, 0_u8..4, any::<u8>()), 1..8)) {
        let mut bytes = drawing("<g transform='rotate(10)'><rect x='2' y='2' width='20' height='40' stroke='red'/></g><path d='M0 0h2v4a1 1 0 0 1 3 3c1 1 2 2 3 3z'/><polyline points='0,0 2,0 2 4'/><circle id='start' cx='2' cy='2' r='.2'/>").into_bytes();
        for (place, kind, byte) in edits {
            let at = (bytes.len() as f64 * place) as usize;
            match kind {
                0 => bytes.truncate(at),
                1 => bytes.insert(at, byte),
                2 if at < bytes.len() => bytes[at] = byte,
                _ if at < bytes.len() => { bytes.remove(at); }
                _ => {}
            }
        }
        match of_svg(&bytes, None, "s") {
            Ok(imported) => prop_assert_eq!(imported.world.validate(0.01), Ok(())),
            Err(error) => prop_assert!(!error.to_string().is_empty()),
        }
    }
}

/// A room of 4 m x 3 m, and what stands in it.
fn in_room(inner: &str) -> Result<Imported, BuildingError> {
    let plan = format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" data-metres-per-unit="1">
        <rect width="4" height="3" fill="none" stroke="black"/><circle id="start" cx="3.5" cy="2.5" r=".1"/>{inner}</svg>"#
    );
    of_svg(plan.as_bytes(), None, "s")
}

/// Corners of everything that stands in the room, in the order of the file, in which the room comes
/// first and the fence last.
fn corners_in_room(inner: &str) -> Vec<(f64, f64)> {
    let Imported { world, skipped } = in_room(inner).unwrap();
    assert_eq!(skipped, [""; 0]);
    let shapes = &world.obstacles[1..world.obstacles.len() - 1];
    let corners = shapes.iter().flat_map(|obstacle| match &obstacle.shape {
        Shape::Polyline { points, .. } => points.clone(),
        other => panic!("{other:?}"),
    });
    // To the millimetre.
    let round = |x: f64| (1000.0 * x).round() / 1000.0;
    corners.map(|p| (round(p.x), round(p.y))).collect()
}

#[test]
fn copies_stand_where_their_transforms_put_them() {
    let bar = "<defs><g id='bar' transform='translate(0 .5)'><path d='M1 0h.5' stroke='black'/></g></defs>";
    for link in ["href", "xlink:href"] {
        let copies = format!(
            "{bar}<use {link}='#bar'/><use {link}='#bar' x='1' y='.5'/><use {link}='#bar' x='1' transform='scale(2 1)'/>"
        );
        let expect = [
            (1.0, -0.5),
            (1.5, -0.5),
            (2.0, -1.0),
            (2.5, -1.0),
            (4.0, -0.5),
            (5.0, -0.5),
        ];
        assert_eq!(corners_in_room(&copies), expect);
    }
    // A copy of copies; a symbol is drawn only where it is copied; the copy gives the stroke that a
    // part does not state.
    let nested = "<symbol id='dot'><path id='one' d='M1 1h.1'/></symbol><g stroke='red'><use id='two' href='#dot'/></g><use href='#two' x='1' stroke='red'/>";
    assert_eq!(
        corners_in_room(nested),
        [(1.0, -1.0), (1.1, -1.0), (2.0, -1.0), (2.1, -1.0)]
    );
    // The copy of a start is not a start.
    let start = in_room("<use href='#start' x='-2'/>").unwrap().world.start;
    assert_eq!(start.position(), Point2::new(3.5, -2.5));
}

#[test]
fn copies_of_themselves_and_without_end_are_refused() {
    for round in [
        "<g id='a'><use href='#a'/></g>",
        "<use id='a' href='#b'/><use id='b' href='#a'/>",
        "<defs><g id='a'><use href='#b'/></g><g id='b'><use href='#a'/></g></defs><use href='#a'/>",
    ] {
        let said = in_room(round).unwrap_err().to_string();
        assert!(said.contains("does not hold this copy itself"), "{said}");
    }
    // Ten times ten times ten …
    let mut laughs = "<defs><g id='g0'><path d='M1 1'/></g>".to_owned();
    for i in 1..10 {
        let ten = format!("<use href='#g{}'/>", i - 1).repeat(10);
        laughs += &format!("<g id='g{i}'>{ten}</g>");
    }
    let said = in_room(&(laughs + "</defs><use href='#g9'/>"))
        .unwrap_err()
        .to_string();
    assert!(said.contains("more than 1000000 elements"), "{said}");
}

#[test]
fn classes_draw_and_hide_as_the_style_sheet_says() {
    let bar = |attributes: &str| format!("<path d='M1 1h1' fill='none' {attributes}/>");
    let sheet = "<style>.off { display: none } .dim { visibility: hidden } .wall, #w { stroke: black } path { stroke: none } .off.on { display: inline } \
                 .must { stroke: none !important }</style>";
    for (attributes, is_wall) in [
        ("class='wall'", true),
        ("id='w'", true),
        ("", false),
        ("stroke='black'", false),
        ("style='stroke: black'", true),
        ("class='wall off'", false),
        ("class='wall dim'", false),
        ("class='wall off on'", true),
        ("class='must' style='stroke: black'", false),
    ] {
        let found = corners_in_room(&format!("{sheet}{}", bar(attributes)));
        assert_eq!(!found.is_empty(), is_wall, "{attributes}: {found:?}");
    }
    // A removed element takes its children with it; children of an element that is only hidden may
    // be visible.
    let inner = bar("class='wall' style='visibility: visible'");
    assert_eq!(
        corners_in_room(&format!("{sheet}<g class='off'>{inner}</g>")),
        []
    );
    assert_eq!(
        corners_in_room(&format!("{sheet}<g class='dim'>{inner}</g>")).len(),
        2
    );
}

#[test]
fn rules_that_are_not_read_are_named() {
    let sheet = "<style>g path { display: none } @media print { path { display: none } }</style>";
    let skipped = in_room(sheet).unwrap().skipped;
    assert_eq!(
        skipped,
        ["2 × <style> (rules for elements within others, or for some media only)"]
    );
}
