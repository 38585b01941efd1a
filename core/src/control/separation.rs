//! Keeping apart from people: the robot drives only so fast that it can stop before a walker can be
//! in its way.
//!
//! In: speeds that are safe among things that stand still, and the points of walkers
//! ([`crate::points::Walkers`]). Out: speeds at which the robot can stop before any of them,
//! walking in any direction, can reach the path of its front.
//!
//! 1. From speed v the robot stops within T = t + v/a and s = v t + v²/(2 a), with reaction time t
//!    and deceleration a.
//! 2. Its front sweeps the disc along s, on the arcs of the commanded and of the requested speeds.
//!    A walker at distance d of that needs d / u at walking speed u. So d ≥ u T is required, and
//!    the greatest such v is taken; 0 if even v = 0 violates it.
//! 3. Walkers go on while a lidar is silent: t grows with the age of the scan.
//! 4. Walkers behind the robot's centre, in its driving direction, do not count: it does not drive
//!    into them.
//!
//! Source: speed and separation monitoring, ISO/TS 15066:2016 §5.5.4, with the person's speed from
//! ISO 13855 made a setting.

use nalgebra::{Point2, Vector2};

use super::safe::{BRAKING, Limits, Speeds, Underway};
use super::strip::arc;
use crate::geom::Length;

/// Walking speed of people, m/s. Larger: the robot slows down farther from them, and they have to
/// be farther away for it to go on.
pub(super) const WALKING: f64 = 1.2;
/// Number of speeds that are tried between 0 and the requested one.
const TRIED: u32 = 20;
/// Spacing of the places of the swept disc that are examined, m.
const STEP: f64 = 0.05;

/// A lidar scan is at least this old when it is used, s: [`SafeConfig::reaction`] includes it.
const FRESH: f64 = 0.2;

/// Below this speed a robot is about to stand, m/s.
const STANDS: f64 = 0.01;

/// Whether a robot on a straight leg, which drives forward (back if negative) at full speed, may go
/// on among walkers: a leg cannot be slowed down, only stopped. `walkers` as for
/// [`limit_among_walkers`].
#[must_use]
pub fn leg_is_safe(
    forward: f64,
    walkers: &[Point2<f64>],
    underway: &Underway,
    (model, config): Limits,
) -> bool {
    let wish = (model.max_speed.copysign(forward), 0.0);
    let safe = limit_among_walkers(wish, walkers, underway, (model, config));
    forward.abs() < STANDS || safe == wish
}

/// The speeds (m/s, rad/s) that are safe among walkers, for a robot in motion. `walkers` are in the
/// robot frame of the last scan.
#[must_use]
pub fn limit_among_walkers(
    (forward, turn): Speeds,
    walkers: &[Point2<f64>],
    underway: &Underway,
    (model, config): Limits,
) -> Speeds {
    if walkers.is_empty() || forward == 0.0 {
        return (forward, turn);
    }
    let robot_from_scan = underway.since_scan.inverse();
    let ahead: Vec<Point2<f64>> = walkers
        .iter()
        .map(|walker| robot_from_scan * *walker)
        .filter(|walker| walker.x * forward > 0.0)
        .collect();
    // Walkers do not wait while the lidar is silent.
    let reaction = config.reaction + (underway.scan_age - FRESH).max(0.0);
    let brake = BRAKING * model.max_acceleration;
    let is_safe = |speed: f64| {
        let length = speed * config.reaction + speed * speed / (2.0 * brake);
        let apart = WALKING * (reaction + speed / brake) + model.radius();
        underway.turns(turn).into_iter().all(|turn| {
            let steps = (length / STEP).ceil() as u32;
            (0..=steps).all(|step| {
                let part = length * f64::from(step) / f64::from(steps.max(1));
                let angle = turn * part / forward.abs();
                let at: Point2<f64> = arc(part.copysign(forward), angle);
                let is_apart = |w: &Point2<f64>| Vector2::from(w - at).length() >= apart;
                ahead.iter().all(is_apart)
            })
        })
    };
    let tried = (0..=TRIED)
        .rev()
        .map(|i| forward.abs() * f64::from(i) / f64::from(TRIED));
    let speed = tried
        .into_iter()
        .find(|speed| is_safe(*speed))
        .unwrap_or(0.0);
    (speed.copysign(forward), turn)
}
