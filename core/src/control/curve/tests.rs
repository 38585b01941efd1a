use proptest::prelude::*;

use super::super::Follower;
use super::super::tests::{TICK, drive};
use super::*;
use crate::geom::{Length, Segment};
use crate::plan::{ConfigSpace, smooth};

/// A space without obstacles.
struct Open;

impl ConfigSpace for Open {
    fn walls_near(&self, _point: Point2<f64>, _reach: f64) -> Vec<Segment> {
        vec![]
    }

    fn room(&self, _: Point2<f64>) -> f64 {
        f64::INFINITY
    }

    fn step(&self) -> f64 {
        0.1
    }

    fn bounds(&self) -> (Point2<f64>, Point2<f64>) {
        (Point2::new(-9.0, -9.0), Point2::new(9.0, 9.0))
    }
}

struct Ride {
    arrived: bool,
    seconds: f64,
    /// Greatest distance of the ride from the given points, m.
    off: f64,
    end: Point2<f64>,
}

/// Drives a robot that obeys its model; `points` are dense points of the path that it should
/// follow.
fn ride(follower: &mut Follower, points: &[Point2<f64>], heading: f64, model: &RobotModel) -> Ride {
    let config = FollowConfig::default();
    let (mut pose, mut speeds) = (Pose2::new(0.0, 0.0, heading), (0.0, 0.0));
    let mut ride = Ride {
        arrived: false,
        seconds: 0.0,
        off: 0.0,
        end: pose.position(),
    };
    while ride.seconds < 600.0 {
        match follower.steer(&pose, model, &config) {
            Some((forward, turn)) => {
                assert!((0.0..=model.max_speed).contains(&forward), "{forward} m/s");
                assert!(turn.abs() <= model.max_turn_rate, "{turn} rad/s");
                pose = drive(pose, &mut speeds, (forward, turn), model);
            }
            None => {
                ride.arrived = true;
                break;
            }
        }
        ride.seconds += TICK;
        let near = points.iter().map(|p| (p - pose.position()).length());
        ride.off = ride.off.max(near.fold(f64::INFINITY, f64::min));
    }
    while speeds.0 > 1e-6 {
        pose = drive(pose, &mut speeds, (0.0, 0.0), model);
    }
    ride.end = pose.position();
    ride
}

fn dense(pieces: &[Piece]) -> Vec<Point2<f64>> {
    let points = |piece: &Piece| {
        let piece = *piece;
        let count = (piece.length() / 0.01).ceil().max(1.0) as usize;
        (0..=count).map(move |i| piece.point(i as f64 / count as f64))
    };
    pieces.iter().flat_map(points).collect()
}

/// A zigzag of 0.8 m legs.
fn zigzag() -> Path {
    let points = (0..8).map(|i| Point2::new(0.7 * f64::from(i), 0.4 * f64::from(i % 2)));
    Path {
        points: points.collect(),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn it_arrives_near_the_curve(
        corners in proptest::collection::vec((-3.0..3.0_f64, -3.0..3.0_f64), 1..6), heading in -3.1..3.1_f64, pioneer: bool,
    ) {
        let model = if pioneer { RobotModel::pioneer() } else { RobotModel::rp6() };
        let mut points = vec![Point2::origin()];
        points.extend(corners.iter().map(|&(x, y)| Point2::new(x, y)));
        let path = Path { points };
        let pieces = smooth(&path, &Open);
        let ride = ride(&mut Follower::rounded(&pieces), &dense(&pieces), heading, &model);
        prop_assert!(ride.arrived, "still at {}", ride.end);
        let end = path.points[path.points.len() - 1];
        prop_assert!((ride.end - end).length() < 0.06, "{} m from the end", (ride.end - end).length());
        prop_assert!(ride.off < 0.08, "{} m off the curve", ride.off);
    }
}

/// Regression: a pioneer that aimed 0.25 m ahead at 0.7 m/s swung to and fro after its last bend,
/// and was 16 cm off in the end.
#[test]
fn a_fast_robot_does_not_swing_about_a_straight_leg() {
    let model = RobotModel::pioneer();
    let corners = [
        (0.0, 0.0),
        (2.55, 1.09),
        (2.28, -0.35),
        (1.5, -0.34),
        (-1.85, -1.98),
    ];
    let points = corners.map(|(x, y)| Point2::new(x, y)).into();
    let pieces = smooth(&Path { points }, &Open);
    let ride = ride(
        &mut Follower::rounded(&pieces),
        &dense(&pieces),
        0.0,
        &model,
    );
    assert!(
        ride.arrived && ride.off < 0.05,
        "{} m off the curve",
        ride.off
    );
}

#[test]
fn rounded_corners_are_faster_than_stops() {
    let model = RobotModel::rp6();
    let path = zigzag();
    let pieces = smooth(&path, &Open);
    let sharp = dense(&path.legs().map(Piece::Line).collect::<Vec<_>>());
    let stops = ride(&mut Follower::new(&path), &sharp, 0.0, &model);
    let rounded = ride(
        &mut Follower::rounded(&pieces),
        &dense(&pieces),
        0.0,
        &model,
    );
    assert!(stops.arrived && rounded.arrived);
    assert!(
        rounded.seconds < 0.75 * stops.seconds,
        "{} s rounded, {} s with stops",
        rounded.seconds,
        stops.seconds
    );
}

/// A path pulled tight goes round a pillar in short legs, into which no arc fits.
#[test]
fn small_kinks_are_driven_over() {
    let model = RobotModel::rp6();
    let (mut at, mut heading) = (Point2::origin(), 0.0_f64);
    let mut pieces = vec![];
    for _ in 0..12 {
        let (sin, cos) = crate::geom::sin_cos(heading);
        let next = at + nalgebra::Vector2::new(cos, sin) * 0.15;
        pieces.push(Piece::Line(crate::geom::Segment::new(at, next)));
        pieces.push(Piece::Turn {
            at: next,
            turn: 0.15,
        });
        (at, heading) = (next, heading + 0.15);
    }
    let ride = ride(
        &mut Follower::rounded(&pieces),
        &dense(&pieces),
        0.0,
        &model,
    );
    let length: f64 = pieces.iter().map(Piece::length).sum();
    assert!(ride.arrived && ride.off < 0.03, "{} m off", ride.off);
    let least = length / model.max_speed;
    assert!(
        ride.seconds < 1.6 * least,
        "{} s for {length} m",
        ride.seconds
    );
}

#[test]
fn what_remains_begins_at_the_robot_and_ends_at_the_end() {
    let path = zigzag();
    let pieces = smooth(&path, &Open);
    let length: f64 = pieces.iter().map(Piece::length).sum();
    let mut follower = CurveFollower::new(&pieces);
    assert!((follower.remaining().length() - length).abs() < 0.01 * length);
    let model = RobotModel::rp6();
    let at = pieces[0].point(0.5);
    follower.steer(
        &Pose2::new(at.x, at.y, 0.5),
        &model,
        &FollowConfig::default(),
    );
    let rest = follower.remaining();
    let driven = 0.5 * pieces[0].length();
    assert!((rest.length() - (length - driven)).abs() < 2.0 * SPACING);
    assert_eq!(rest.points.last(), path.points.last());
}

#[test]
fn nothing_to_drive_has_arrived() {
    let mut follower = CurveFollower::new(&[]);
    let model = RobotModel::rp6();
    let steering = follower.steer(&Pose2::identity(), &model, &FollowConfig::default());
    assert_eq!(steering, None);
    assert!(follower.remaining().points.is_empty());
}

proptest! {
    /// Coulter (1992), "Implementation of the pure pursuit path tracking algorithm": curvature 2
    /// sin α / L. The oracle is the circle itself.
    #[test]
    fn the_circle_it_drives_touches_its_heading_and_meets_the_point_it_aims_at(
        y in -0.12..0.12_f64, heading in -0.3..0.3_f64, pioneer: bool,
    ) {
        let config = FollowConfig::default();
        // One aims 0.25 m ahead, the other as far as it drives in 0.8 s.
        let (model, ahead) = if pioneer { (RobotModel::pioneer(), 0.56) } else { (RobotModel::rp6(), 0.25) };
        let straight = crate::geom::Segment::new(Point2::origin(), Point2::new(5.0, 0.0));
        let mut follower = CurveFollower::new(&[Piece::Line(straight)]);
        // When it faces along the line it drives off.
        follower.steer(&Pose2::identity(), &model, &config);
        let pose = Pose2::new(0.1, y, heading);
        let Some((forward, turn)) = follower.steer(&pose, &model, &config) else {
            return Err(TestCaseError::fail("it has not arrived"));
        };
        let to_aim = Point2::new(0.1 + ahead, 0.0) - pose.position();
        let astray = wrap(libm::atan2(to_aim.y, to_aim.x) - heading).abs();
        prop_assume!(astray < super::super::follow::ASTRAY && astray > 0.01);
        prop_assert!(forward > 0.0 && turn.abs() <= model.max_turn_rate);
        // The centre lies abeam, at the radius v/ω.
        let radius = forward / turn;
        let centre = pose * Point2::new(0.0, radius);
        let off = (pose.position() + to_aim - centre).length() - radius.abs();
        prop_assert!(off.abs() < 1e-6, "{off} m");
    }
}
