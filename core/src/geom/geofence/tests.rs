//! The fence compared with border points and with cells counted one by one.

use super::*;

fn zone(kind: ZoneKind, corners: &[(f64, f64)]) -> Zone {
    let corners = corners.iter().map(|&(x, y)| Point2::new(x, y)).collect();
    Zone { kind, corners }
}

/// An L to stay in, and a table in it to keep out of.
pub(crate) fn fence() -> Geofence {
    let l = [
        (0.0, 0.0),
        (6.0, 0.0),
        (6.0, 2.0),
        (2.0, 2.0),
        (2.0, 5.0),
        (0.0, 5.0),
    ];
    let table = [(3.5, 0.8), (4.5, 0.8), (4.0, 1.2)];
    Geofence::new(vec![
        zone(ZoneKind::KeepIn, &l),
        zone(ZoneKind::KeepOut, &table),
    ])
    .unwrap()
}

/// A second definition of inside, without a polygon: half planes.
fn is_allowed(x: f64, y: f64) -> bool {
    let in_l = (0.0..=6.0).contains(&x) && (0.0..=5.0).contains(&y) && (x <= 2.0 || y <= 2.0);
    // The table's sides: y = 0.8, and two that rise and fall by 0.8 per metre to its top.
    let in_table = y >= 0.8 && y <= 0.8 + 0.8 * (x - 3.5) && y <= 0.8 - 0.8 * (x - 4.5);
    in_l && !in_table
}

/// The distance to the border, by trying every centimetre of it.
fn by_trying(fence: &Geofence, at: Point2<f64>) -> f64 {
    let mut nearest = f64::INFINITY;
    for zone in fence.zones() {
        for (a, b) in sides_of(&zone.corners) {
            let steps = ((b - a).length() / 0.01).ceil();
            for step in 0..=steps as u32 {
                let on = a + (b - a) * (f64::from(step) / steps);
                nearest = nearest.min((on - at).length());
            }
        }
    }
    nearest
}

#[test]
fn the_clearance_has_the_sign_of_half_planes_and_is_no_more_than_the_way_to_the_border() {
    let fence = fence();
    for i in -10..80 {
        for j in -10..70 {
            let (x, y) = (0.1 * f64::from(i) + 0.003, 0.1 * f64::from(j) + 0.007);
            let clearance = fence.clearance(Point2::new(x, y));
            assert_eq!(clearance > 0.0, is_allowed(x, y), "({x}, {y}): {clearance}");
            let tried = by_trying(&fence, Point2::new(x, y));
            // The table lies wholly in the only keep-in zone: here the clearance is the distance
            // itself.
            let off = (clearance.abs() - tried).abs();
            assert!(off < 0.006, "({x}, {y}): {clearance}, {tried}");
        }
    }
    assert_eq!(
        Geofence::default().clearance(Point2::origin()),
        f64::INFINITY
    );
}

#[test]
fn zones_that_overlap_are_one_and_those_that_only_touch_are_not() {
    let square = |x: f64| {
        zone(
            ZoneKind::KeepIn,
            &[(x, 0.0), (x + 2.0, 0.0), (x + 2.0, 2.0), (x, 2.0)],
        )
    };
    let clearance = |second: f64, x: f64| {
        let fence = Geofence::new(vec![square(0.0), square(second)]).unwrap();
        fence.clearance(Point2::new(x, 1.0))
    };
    assert!(clearance(1.0, 1.5) > 0.49);
    assert!(clearance(2.0, 2.0).abs() < 1e-9);
    assert!(clearance(2.0, 3.0) > 0.99);
}

#[test]
fn what_is_no_fence_is_refused_with_its_place() {
    let check = |corners: &[(f64, f64)], expect: &str| {
        let error = Geofence::new(vec![zone(ZoneKind::KeepIn, corners)]).unwrap_err();
        assert!(error.to_string().contains(expect), "{error}");
    };
    check(&[(0.0, 0.0), (1.0, 0.0)], "zone 1 has 2 corners");
    check(&[(0.0, 0.0); 33], "zone 1 has 33 corners");
    check(
        &[(0.0, 0.0), (1.0, f64::NAN), (1.0, 1.0)],
        "corner 2 of zone 1 is (1, NaN)",
    );
    check(
        &[(0.0, 0.0), (1e9, 0.0), (1.0, 1.0)],
        "corner 2 of zone 1 is (1000000000, 0)",
    );
    check(
        &[(0.0, 0.0), (0.0, 0.0), (1.0, 1.0)],
        "corners 1 and the next of zone 1",
    );
    // A bow tie, and spikes: at the first corner, at the last, in the middle.
    check(
        &[(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)],
        "sides from corners 1 and 3 cross",
    );
    check(&[(0.0, 0.0), (2.0, 0.0), (1.0, 0.0)], "cross");
    check(&[(0.0, 0.0), (0.0, 2.0), (1.0, 2.0), (0.0, 1.0)], "cross");
    check(
        &[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 0.0), (0.0, 1.0)],
        "cross",
    );
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let many = Geofence::new(vec![zone(ZoneKind::KeepOut, &square); 9]).unwrap_err();
    assert!(many.to_string().contains("9 zones; 8"), "{many}");
}

#[test]
fn a_fence_in_another_frame_holds_the_same_places() {
    let to_from_fence = Pose2::new(3.0, -2.0, 1.2);
    let moved = fence().moved(&to_from_fence);
    for i in -10..80 {
        for j in -10..70 {
            let at = Point2::new(0.1 * f64::from(i), 0.1 * f64::from(j));
            let off = moved.clearance(to_from_fence * at) - fence().clearance(at);
            assert!(off.abs() < 1e-9, "{at}: {off}");
        }
    }
}
