//! Where a map is reported to be torn.

use super::super::super::map_quality::{MapQuality, MapVerdict, Tear, TearKind, Unjudgeable};
use super::super::super::pose_graph::Edge;
use super::*;

/// χ² of 3 degrees of freedom is below this in 999 of 1000 cases.
const SURE_CHI2: f64 = 16.3;

#[test]
fn a_map_is_called_torn_where_a_wrong_edge_tore_it_and_good_without() {
    let (_, _, mut matcher) = run(ScanMatcherConfig::default(), 1);
    let good = matcher.quality();
    assert_eq!(good.verdict, MapVerdict::Good, "{:?}", good.tears);
    assert!(good.agreement.unwrap() > 0.8, "{:?}", good.agreement);
    // No submap lies far from where the previous one ended.
    let joins = matcher.joins();
    assert_eq!((joins.len(), joins[0]), (matcher.submaps.len(), None));
    for (at, join) in joins.iter().enumerate().skip(1) {
        let Join { residual, doubt } = join.unwrap();
        assert!(
            (0.0..SURE_CHI2).contains(&residual.chi2),
            "{at}: {residual:?}"
        );
        let edges = matcher.graph.edges().iter();
        let edge = edges
            .filter(|edge| edge.cauchy.is_none())
            .find(|edge| edge.to == at);
        let edge = edge.unwrap();
        // The same in the plain form: the residual of the motion, against its covariance.
        let poses = matcher.graph.poses();
        let present = poses[at - 1].inverse() * poses[at];
        let off = edge.motion.inverse() * present;
        let error = Vector3::new(off.x(), off.y(), off.heading());
        let cov = edge.information.try_inverse().unwrap();
        let chi2 = error.dot(&cov.lu().solve(&error).unwrap());
        assert!((residual.chi2 - chi2).abs() < 1e-6 * (1.0 + chi2), "{chi2}");
        assert!((residual.off.position() - off.position()).length() < 1e-12);
        assert!((doubt.shift * doubt.shift - cov[(0, 0)] - cov[(1, 1)]).abs() < 1e-12);
        assert!((doubt.turn * doubt.turn - cov[(2, 2)]).abs() < 1e-12);
    }
    // Wrong edges hold the last submaps at wrong poses.
    let last = matcher.submaps.len() - 1;
    let poses = matcher.graph.poses().to_vec();
    for new in last - 3..last {
        let motion = poses[0].delta_to(&poses[new]) * Pose2::new(0.5, 0.3, 0.0);
        let wrong = Edge {
            from: 0,
            to: new,
            motion,
            information: Matrix3::from_diagonal_element(1e8),
            cauchy: None,
        };
        matcher.graph.add_edge(wrong);
    }
    matcher.optimize();
    let join = matcher.joins()[last - 3].unwrap();
    assert!(join.residual.chi2 > SURE_CHI2, "{join:?}");
    let torn = matcher.quality();
    assert_eq!(torn.verdict, MapVerdict::Torn);
    let begun = matcher.trajectory.iter().find(|t| t.submap == last - 3);
    let begun = begun.unwrap().stamp;
    let told = torn.tears.iter().any(|tear| {
        let off = tear.off.unwrap_or(f64::MAX);
        tear.later[1] >= begun && off > 0.3
    });
    assert!(told, "{:?} {begun:?}", torn.tears);
}

/// A robot is carried into a hall that shares no walls with the ring, while its wheels report that
/// it drove on: or a recording of two buildings.
#[test]
fn a_map_that_goes_on_in_another_building_is_torn_where_that_begins() {
    const CARRIED: usize = 120;
    let corners = [[-9.0, -8.0], [9.0, -8.0], [9.0, 8.5], [-9.0, 8.5]].map(Point2::from);
    let hall = [0, 1, 2, 3].map(|i| Segment::new(corners[i], corners[(i + 1) % 4]));
    let start = Pose2::new(-5.0, -4.0, 0.0);
    let [in_ring, in_hall] = [ring(), hall.into()].map(|w| drive_along(&w, &LAP, start, 1));
    for is_counted in [true, false] {
        let mut matcher = ScanMatcher::new(ScanMatcherConfig::default()).unwrap();
        for step in in_ring
            .iter()
            .take(CARRIED)
            .chain(in_hall.iter().skip(CARRIED))
        {
            if is_counted {
                matcher.odometry(&step.odometry);
            }
            update(&mut matcher, &points_of(&step.scan));
        }
        matcher.finish();
        let quality = matcher.quality();
        assert_eq!(quality.verdict, MapVerdict::Torn, "counted {is_counted}");
        let carried = in_ring[CARRIED].scan.stamp;
        let is_told = |tear: &Tear| tear.kind == TearKind::Loose && tear.later[0] == carried;
        assert!(quality.tears.iter().any(is_told), "{:?}", quality.tears);
    }
}

/// The verdict on the map from these scans of a robot that stands in the ring, as its odometry
/// says; scans that are not `seen` have no returns.
fn standing(seen: &[bool]) -> (MapVerdict, Option<Unjudgeable>) {
    let mut matcher = ScanMatcher::new(ScanMatcherConfig::default()).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let pose = Pose2::new(-5.0, -4.0, 0.0);
    for (second, is_seen) in (0..).zip(seen) {
        let mut scan = scan_at(&ring(), &pose, Stamp(1_000_000 * second), &mut rng);
        if !is_seen {
            scan.ranges.fill(f32::INFINITY);
        }
        matcher.odometry(&Odometry::standing(scan.stamp));
        update(&mut matcher, &points_of(&scan));
    }
    let on_the_way = matcher.quality();
    matcher.finish();
    let quality = matcher.quality();
    let said = |quality: &MapQuality| (quality.verdict, quality.unjudgeable);
    assert_eq!(said(&on_the_way), said(&quality), "{seen:?}");
    said(&quality)
}

#[test]
fn of_a_map_in_which_nothing_was_matched_nothing_good_is_said() {
    let doubtful = |why| (MapVerdict::Doubtful, Some(why));
    assert_eq!(standing(&[]), doubtful(Unjudgeable::NoSurfaces));
    assert_eq!(standing(&[false; 9]), doubtful(Unjudgeable::NoSurfaces));
    assert_eq!(standing(&[true]), doubtful(Unjudgeable::OneScan));
    let covered = [true, false, false, false];
    assert_eq!(standing(&covered), doubtful(Unjudgeable::Unmatched));
    // Scans that were matched to one another are as good as any others.
    assert_eq!(standing(&[true; 2]), (MapVerdict::Good, None));
    assert_eq!(standing(&[true; 9]), (MapVerdict::Good, None));
}
