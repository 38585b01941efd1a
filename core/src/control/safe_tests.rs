//! Safe mode in closed loop with a robot that obeys its model, seeing exactly or with a lidar's
//! noise.

use nalgebra::{Point2, Vector2};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::tests::{TICK, drive};
use super::*;
use crate::geom::{Length, Pose2, Segment, sin_cos};
use crate::points::Points;
use crate::points::fixture::{beam_along, range_to, scan_of, scan_of_hits};
use crate::robot::RobotModel;

/// What a lidar at the robot's centre sees of walls: 360 beams, each with an error of at most
/// `noise`.
fn look(pose: &Pose2, walls: &[Segment], noise: f64, rng: &mut ChaCha8Rng) -> Points {
    let mut beam = |beam_idx: u32| {
        let (sin, cos) = sin_cos(f64::from(beam_idx).to_radians());
        let local = Vector2::new(cos, sin);
        let range = range_to(walls, pose, local) + noise * rng.random_range(-1.0..1.0);
        beam_along(beam_idx as usize, local, range.min(50.0), range.is_finite())
    };
    scan_of((0..360).map(&mut beam))
}

/// The result of driving a robot by a joystick.
struct Driven {
    way: f64,
    least_room: f64,
}

/// Random errors.
#[derive(Clone, Copy, Default)]
struct Chance {
    seed: u64,
    /// Greatest error of a range, m.
    noise: f64,
    /// Variance of a track's slip for each metre it runs, m²/m: no encoder shows it.
    slip: f64,
}

impl Chance {
    fn seen(noise: f64) -> Self {
        Self {
            noise,
            ..Self::default()
        }
    }

    /// How far both tracks slip forward in a tick, m: uniformly distributed, with the variance of
    /// normal slip.
    fn slipped(&self, turn: f64, model: &RobotModel, rng: &mut ChaCha8Rng) -> f64 {
        let of_track = 0.5 * model.track_width * turn.abs() * TICK * self.slip;
        (3.0 * 0.5 * of_track).sqrt() * rng.random_range(-1.0..1.0)
    }
}

/// Ticks of `stick` (forward, turn) from a pose; the robot scans every fourth tick.
fn under_stick(
    mut pose: Pose2,
    walls: &[Segment],
    chance: Chance,
    model: &RobotModel,
    stick: &[(f64, f64)],
) -> Driven {
    let noise = chance.noise;
    let mut rng = ChaCha8Rng::seed_from_u64(1 + chance.seed);
    let config = SafeConfig::default().by_hand();
    let mut underway = Underway::default();
    let mut points = look(&pose, walls, noise, &mut rng);
    let mut driven = Driven {
        way: 0.0,
        least_room: f64::INFINITY,
    };
    for (tick, wish) in stick.iter().enumerate() {
        if tick % 4 == 0 {
            points = look(&pose, walls, noise, &mut rng);
            underway.since_scan = Pose2::identity();
        }
        underway.commanded = limit_speed(*wish, &points, &underway, (model, &config));
        let before = pose;
        pose = drive(pose, &mut underway.runs, underway.commanded, model);
        let moved = before.delta_to(&pose);
        underway.since_scan = underway.since_scan * moved;
        let slipped = chance.slipped(underway.runs.1, model, &mut rng);
        pose = pose * Pose2::new(slipped, 0.0, 0.0);
        driven.way += moved.position().coords.length();
        let distances = walls.iter().map(|wall| wall.distance(pose.position()));
        driven.least_room = distances
            .map(|d| d - model.radius())
            .fold(driven.least_room, f64::min);
    }
    driven
}

fn room(half: f64) -> Vec<Segment> {
    let corner = |x: f64, y: f64| Point2::new(half * x, half * y);
    let [a, b, c, d] = [
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ];
    [(a, b), (b, c), (c, d), (d, a)]
        .map(|(a, b)| Segment::new(a, b))
        .into()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    /// Motors take a second to turn the other way, and the arc swept meanwhile is none of the
    /// commanded arcs.
    #[test]
    fn a_stick_thrown_to_and_fro_touches_nothing(
        throws in proptest::collection::vec((prop_oneof![Just(1.0), Just(1.0), Just(-1.0)], -1.0..=1.0_f64, 4..20_usize), 6..12),
        x in -1.5..1.5_f64, y in -1.5..1.5_f64, heading in -3.1..3.1_f64, pioneer: bool,
    ) {
        let model = if pioneer { RobotModel::pioneer() } else { RobotModel::rp6() };
        let mut walls = room(2.5);
        // As thick as a real wall: the end of a wall without thickness would hide between two
        // beams.
        let spur = [(0.75, -2.5), (0.75, -1.9), (0.85, -1.9), (0.85, -2.5)].map(|(x, y)| Point2::new(x, y));
        walls.extend(spur.windows(2).map(|ends| Segment::new(ends[0], ends[1])));
        let stick: Vec<_> = throws.iter().flat_map(|&(forward, turn, ticks)| {
            std::iter::repeat_n((forward * model.max_speed, turn.signum() * turn.abs().sqrt() * model.max_turn_rate), ticks)
        }).collect();
        let driven = under_stick(Pose2::new(x, y, heading), &walls, Chance::default(), &model, &stick);
        prop_assert!(driven.least_room > 0.0, "{} m", driven.least_room);
    }

    #[test]
    fn who_stands_beside_a_wall_can_leave_along_it_without_touching_it(room in 0.022..0.08_f64, lean in -0.05..0.05_f64, pioneer: bool) {
        let model = if pioneer { RobotModel::pioneer() } else { RobotModel::rp6() };
        let off = -(model.radius() + room);
        let wall = [Segment::new(Point2::new(-5.0, off), Point2::new(5.0, off))];
        let stick = vec![(model.max_speed, 0.0); 80];
        let driven = under_stick(Pose2::new(0.0, 0.0, lean), &wall, Chance::seen(0.015), &model, &stick);
        prop_assert!(driven.way > 0.05, "{} m in 4 s", driven.way);
        prop_assert!(driven.least_room > 0.005, "{} m", driven.least_room);
    }
}

#[test]
fn who_leans_on_the_stick_before_a_wall_does_not_creep_into_it() {
    for model in [RobotModel::rp6(), RobotModel::pioneer()] {
        let ahead = model.radius() + 0.06;
        let wall = [Segment::new(
            Point2::new(ahead, -3.0),
            Point2::new(ahead, 3.0),
        )];
        let stick = vec![(model.max_speed, 0.0); 600];
        let driven = under_stick(
            Pose2::identity(),
            &wall,
            Chance::seen(0.015),
            &model,
            &stick,
        );
        assert!(driven.least_room > 0.03, "{} m", driven.least_room);
    }
}

/// Regression: a pioneer that stood at 53° to the wall of a corridor crept on until the slip of its
/// tracks was enough to touch it.
#[test]
fn a_wall_aslant_is_not_crept_into() {
    let model = RobotModel::pioneer();
    for degrees in [-65.0_f64, -53.0, -40.0, 40.0, 53.0, 65.0] {
        let (sin, cos) = sin_cos(degrees.to_radians());
        let (to, along) = (Vector2::new(cos, sin), Vector2::new(-sin, cos));
        let foot = Point2::from(to * (model.radius() + 0.045));
        let wall = [Segment::new(foot - along * 3.0, foot + along * 3.0)];
        let stick = vec![(model.max_speed, 0.0); 160];
        let chance = Chance::seen(0.015);
        let driven = under_stick(Pose2::identity(), &wall, chance, &model, &stick);
        assert!(
            driven.least_room > 0.028,
            "{degrees}°: {} m",
            driven.least_room
        );
    }
}

/// Regression: pioneers that were turned round and round a centimetre from a wall.
#[test]
fn who_turns_before_a_wall_on_tracks_that_slip_is_eased_off_it() {
    let model = RobotModel::pioneer();
    let ahead = model.radius() + 0.015;
    let (a, b) = (Point2::new(ahead, -3.0), Point2::new(ahead, 3.0));
    let wall = [Segment::new(a, b)];
    let stick = vec![(model.max_speed, model.max_turn_rate); 240];
    for seed in 0..40 {
        let chance = Chance {
            seed,
            noise: 0.015,
            slip: model.odometry_noise.per_metre,
        };
        let driven = under_stick(Pose2::identity(), &wall, chance, &model, &stick);
        assert!(
            driven.least_room > 0.0,
            "seed {seed}: {} m",
            driven.least_room
        );
    }
}

#[test]
fn what_the_robot_still_turns_into_slows_it() {
    let model = RobotModel::pioneer();
    let config = SafeConfig::default();
    // 0.4 m/s at 1.4 rad/s to the right leads into it; after a command to turn left, the robot
    // needs a second to do so.
    let wall = [Segment::new(
        Point2::new(0.2, -0.45),
        Point2::new(0.5, -0.45),
    )];
    let points = look(
        &Pose2::identity(),
        &wall,
        0.0,
        &mut ChaCha8Rng::seed_from_u64(1),
    );
    let wish = (0.7, 0.7);
    let with = |runs| {
        let underway = Underway {
            commanded: wish,
            runs,
            ..Underway::default()
        };
        limit_speed(wish, &points, &underway, (&model, &config)).0
    };
    assert_eq!(with((0.4, 0.7)), 0.7);
    assert!(with((0.4, -1.4)) < 0.5, "{}", with((0.4, -1.4)));
}

#[test]
fn among_walkers_the_way_they_may_walk_unseen_counts() {
    let model = RobotModel::pioneer();
    let config = SafeConfig::default();
    let brake = safe::BRAKING * model.max_acceleration;
    let speed = |distance: f64, scan_age| {
        let underway = Underway {
            scan_age,
            ..Underway::default()
        };
        let walkers = [Point2::new(distance, 0.0)];
        limit_among_walkers((0.7, 0.0), &walkers, &underway, (&model, &config)).0
    };
    // d = u (t + v/a) + s + r, with s = v t + v²/(2 a): the greatest multiple v of a twentieth of
    // 0.7 m/s that satisfies it.
    let needs = |v: f64, t: f64| {
        let way = v * config.reaction + v * v / (2.0 * brake);
        separation::WALKING * (t + v / brake) + way + model.radius()
    };
    for (age, late) in [(0.0, 0.0), (0.2, 0.0), (0.5, 0.3), (0.7, 0.5)] {
        for v in [0.0, 0.21, 0.42, 0.665] {
            let enough = needs(v, config.reaction + late) + 1e-6;
            assert!(
                (speed(enough, age) - v).abs() < 1e-9,
                "{v} m/s after {age} s: {}",
                speed(enough, age)
            );
        }
    }
}

#[test]
fn a_leg_goes_on_only_where_its_full_speed_is_safe() {
    let model = RobotModel::rp6();
    let config = SafeConfig::default();
    let (v, brake) = (model.max_speed, safe::BRAKING * model.max_acceleration);
    let way = v * config.reaction + v * v / (2.0 * brake);
    let needs = separation::WALKING * (config.reaction + v / brake) + way + model.radius();
    for (at, forward, goes_on) in [
        (needs + 1e-6, 0.3, true),
        (needs - 1e-6, 0.3, false),
        // However slow it still is on its leg: it will be as fast.
        (needs - 1e-6, 0.1, false),
        (-0.3, 0.3, true),
        (-0.3, -0.3, false),
        // It is at the end of its leg.
        (0.3, 0.005, true),
    ] {
        let walkers = [Point2::new(at, 0.0)];
        let underway = Underway::default();
        let safe = leg_is_safe(forward, &walkers, &underway, (&model, &config));
        assert_eq!(safe, goes_on, "somebody at {at} m, {forward} m/s");
    }
}

/// A post of one or two points beside the heading is not a wall along which it may creep.
#[test]
fn a_thin_post_beside_the_heading_is_not_driven_into() {
    for model in [RobotModel::pioneer(), RobotModel::rp6()] {
        for config in [SafeConfig::default(), SafeConfig::default().by_hand()] {
            for hundredths in (30..110).step_by(5) {
                for count in 1..=2 {
                    let off = model.radius() * f64::from(hundredths) / 100.0;
                    let posts: Vec<Point2<f64>> = (0..count)
                        .map(|at| Point2::new(0.6 + 0.004 * f64::from(at), off))
                        .collect();
                    let room = towards(&posts, &model, &config);
                    assert!(
                        room > 0.0,
                        "{hundredths} % of the radius, {count}: {room} m"
                    );
                }
            }
        }
    }
}

/// The least room that remains between the robot and any of the points while the stick is pushed
/// forward, m.
fn towards(posts: &[Point2<f64>], model: &RobotModel, config: &SafeConfig) -> f64 {
    let mut pose = Pose2::identity();
    let mut underway = Underway::default();
    let mut least = f64::INFINITY;
    for _ in 0..200 {
        let points = scan_of_hits(posts.iter().map(|post| pose.inverse() * *post));
        underway.since_scan = Pose2::identity();
        underway.commanded =
            limit_speed((model.max_speed, 0.0), &points, &underway, (model, config));
        pose = drive(pose, &mut underway.runs, underway.commanded, model);
        let rooms = posts
            .iter()
            .map(|post| (post - pose.position()).length() - model.radius());
        least = rooms.fold(least, f64::min);
    }
    least
}
