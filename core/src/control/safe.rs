//! Safe mode: no command, by hand or by pilot, drives into what the last scan saw.
//!
//! In: the requested speeds, the last scan's points, the robot's actual speeds. Out: speeds that
//! stop before contact.
//!
//! 1. The points are moved into the robot's current frame by odometry.
//! 2. The robot's disc is swept ([`super::strip`]) along the arc of the requested speeds, of the
//!    commanded speeds and of the actual speeds, and straight on: the turn rate takes a second to
//!    change, and the true motion is somewhere between them. The first point that it would touch
//!    gives the free distance. Points that the disc moves away from do not count, so backing off a
//!    wall stays possible.
//! 3. Speed: v t + v²/(2 a) may not exceed the free distance, with reaction time t and braking a.
//!    Turning on the spot is never limited.
//! 4. A robot that stands beside a wall, nearer than it would approach it, may creep along it, but
//!    no nearer than a centimetre: points scatter, and some of them always seem to come nearer.
//! 5. Tracks slip, so a robot that turns on the spot wanders by a centimetre a second, unseen by
//!    any encoder. A robot that is driven by hand and has come too near to something in this way is
//!    eased off it ([`super::ease`]) while it turns.
//!
//! Anything thinner than the gap between two beams, such as a wall without thickness seen end-on,
//! is hidden from a scan, and so from safe mode.
//!
//! Source: Celej §5 (safe mode); braking distance plus reaction time as in the specification.

use super::ease::ease_off;
use super::strip::Strip;
use crate::bounds::config;
use crate::geom::Pose2;
use crate::points::Points;
use crate::robot::RobotModel;

/// Fraction of the robot's acceleration that braking counts on.
pub(super) const BRAKING: f64 = 0.7;

config! {
    /// How cautious safe mode is.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct SafeConfig {
        /// Distance kept between the robot's disc and obstacles, m. Default 0.018: below what
        /// planned paths keep.
        pub gap: f64 = 0.018,
        /// Time from what is seen to an effect, s. Default 0.3: a tick, a revolution of a lidar,
        /// and the motors. What stands still asks for half of that, since odometry moves its points
        /// along; a person who comes nearer meanwhile for all of it.
        pub reaction: f64 = 0.3,
        /// How much wider than the disc the swept strip becomes, for each metre ahead. Default 0.
        /// Larger slows the robot before what it would only just pass: where that will be is not
        /// known to the centimetre.
        pub spread: f64 = 0.0,
        /// Oldest scan that is still trusted, s. Default 0.5.
        pub stale_after: f64 = 0.5,
        /// How fast a robot that turns on the spot is eased off what it has come too near to, m/s.
        /// Default 0: who follows a path would be pushed off it.
        pub ease: f64 = 0.0,
    }
}

impl SafeConfig {
    /// How a robot with this greatest acceleration brakes.
    pub(super) fn braking_of(&self, acceleration: f64) -> Braking {
        Braking {
            deceleration: BRAKING * acceleration,
            reaction: self.reaction,
        }
    }

    /// For driving by hand: people do not steer through gaps by the millimetre, and a key held down
    /// at a wall must not make the robot creep into it scan by scan. The robot's radius and the gap
    /// together exceed the 0.15 m within which a lidar is blind.
    #[must_use]
    pub fn by_hand(self) -> Self {
        Self {
            gap: self.gap.max(0.05),
            spread: self.spread.max(0.1),
            ease: self.ease.max(0.05),
            ..self
        }
    }
}

/// How a robot brakes: in m, m/s and m/s², or in rad, rad/s and rad/s².
#[derive(Clone, Copy, Debug)]
pub(super) struct Braking {
    pub(super) deceleration: f64,
    pub(super) reaction: f64,
}

impl Braking {
    /// The stopping distance, v t + v²/(2 a).
    pub(super) fn way(&self, speed: f64) -> f64 {
        speed.abs() * self.reaction + speed * speed / (2.0 * self.deceleration)
    }

    /// The greatest speed with a stopping distance within `free`, the solution of v t + v²/(2 a) =
    /// d; at most `wish`, whose stopping distance is `longest`.
    pub(super) fn speed_within(&self, free: f64, wish: f64, longest: f64) -> f64 {
        if free >= longest {
            return wish.abs();
        }
        let at = self.deceleration * self.reaction;
        ((at * at + 2.0 * self.deceleration * free).sqrt() - at).min(wish.abs())
    }
}

/// Forward speed, m/s, and turn rate, rad/s.
pub type Speeds = (f64, f64);

/// What a robot can do, and how cautious it is to be.
pub type Limits<'a> = (&'a RobotModel, &'a SafeConfig);

/// The motion of a robot when it gets another command.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Underway {
    /// The speeds that were commanded last, m/s and rad/s.
    pub commanded: Speeds,
    /// The actual speeds, by odometry: motors take time.
    pub runs: Speeds,
    /// `robot_at_scan_from_robot`: the motion since the last scan.
    pub since_scan: Pose2,
    /// Age of that scan, s.
    pub scan_age: f64,
}

impl Underway {
    /// Turn rates that bound the true one after a command to turn at `turn`, rad/s.
    pub(super) fn turns(&self, turn: f64) -> [f64; 4] {
        [turn, self.commanded.1, self.runs.1, 0.0]
    }
}

/// Along a wall nearer than [`SafeConfig::gap`] the robot drives no faster than this, m/s.
pub(super) const CREEP: f64 = 0.1;

/// The speeds (m/s, rad/s) that are safe, for a robot in motion.
#[must_use]
pub fn limit_speed(wish: Speeds, points: &Points, underway: &Underway, limits: Limits) -> Speeds {
    let (model, config) = limits;
    let (forward, turn) = within_model(wish, model);
    let forward = limit_forward((forward, turn), points, underway, limits);
    if forward != 0.0 || turn == 0.0 || config.ease <= 0.0 {
        return (forward, turn);
    }
    let off = ease_off(points, &underway.since_scan, model.radius(), config.ease);
    let off = limit_forward((off, turn), points, underway, limits);
    (off, turn)
}

/// The safe forward speed at a turn rate, m/s; both requested speeds must be within the robot's
/// limits.
fn limit_forward(wish: Speeds, points: &Points, underway: &Underway, limits: Limits) -> f64 {
    let ((forward, turn), (model, config)) = (wish, limits);
    if forward == 0.0 {
        return 0.0;
    }
    let braking = config.braking_of(model.max_acceleration);
    let longest = braking.way(forward);
    let strip = Strip {
        radius: model.radius() + config.gap,
        spread: config.spread,
        least: None,
    };
    let near = strip.near(points, &underway.since_scan, longest);
    if near.is_empty() {
        return forward;
    }
    // The actual speeds are an arc of their own: a robot commanded to turn less is still on the
    // narrower arc.
    let runs = (underway.runs.0 * forward > 0.0).then_some(underway.runs);
    let arcs = underway.turns(turn).map(|turn| (forward, turn));
    let free_on_arcs = |strip: &Strip| {
        let arcs = arcs.iter().copied().chain(runs);
        arcs.map(|arc| strip.free_distance(arc, &near, longest))
            .fold(longest, f64::min)
    };
    let speed_for = |free: f64| braking.speed_within(free, forward, longest);
    let mut speed = speed_for(free_on_arcs(&strip));
    if speed < CREEP.min(forward.abs())
        && let Some(beside) = strip.beside_wall(&near, forward, model.radius())
    {
        speed = speed_for(free_on_arcs(&beside)).min(CREEP).max(speed);
    }
    speed.copysign(forward)
}

/// The speeds (m/s, rad/s) limited to what the robot can do; 0 for NaN.
#[must_use]
pub fn within_model((forward, turn): Speeds, model: &RobotModel) -> Speeds {
    let bounded = |wish: f64, most: f64| {
        if wish.is_finite() {
            wish.clamp(-most, most)
        } else {
            0.0
        }
    };
    (
        bounded(forward, model.max_speed),
        bounded(turn, model.max_turn_rate),
    )
}
