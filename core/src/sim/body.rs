//! From the motion of the tracks to the motion of the robot.
//!
//! In: the distance that each track ran in one time step. Out: the true pose, contacts and bumpers.
//!
//! 1. Slip: each track grips a little more or less than it ran, variance k |Δs| (white along the
//!    distance). The body drifts sideways with the distance, and turns a little more or less with
//!    the turn. These are exactly the terms of [`Tracks::covariance`], so the covariance of dead
//!    reckoning is correct by construction. Encoders count what the tracks ran, not how the body
//!    moved.
//! 2. Collision: the disc of the body is swept along the motion. The first touch of a wall grown by
//!    the radius (a stadium around each segment) ends the motion there, and the rest of it slides
//!    along the wall. Because the disc is swept and not sampled, no speed and no time step lets it
//!    through a wall. A body that is not round moves and turns as far as its outline is proved to
//!    touch nothing ([`outline`]).
//! 3. Within a circle that is known to be free, nothing is swept until the robot leaves it.
//!
//! Source for the sweep: ray against an offset shape, Ericson (2005), "Real-Time Collision
//! Detection", §5.5.7.

mod outline;

use nalgebra::{Point2, Vector2};
use rand::{Rng, RngExt};

use super::contact::{Contacts, Touch};
use super::noise::gaussian_pair;
use super::{Caster, Disc};
use crate::geom::{Footprint, Length, Pose2, Segment, sin_cos, unit_vector, wrap};
use crate::robot::{Bumpers, OdometryNoise, RobotModel, TrackWear, Tracks};

/// The body stops this far before a touch, m, so rounding never puts it inside a wall.
const SKIN: f64 = 1e-5;
/// Within this distance of a touch the bumpers stay pressed, m.
const TOUCH: f64 = 1e-3;
/// How often one step may slide along another surface: two walls of a corner, and a mover.
const MOST_SLIDES: usize = 4;
/// How far around the body to look for free room, m.
const LOOKOUT: f64 = 0.4;

/// The robot's body in the world.
#[derive(Clone, Debug)]
pub(super) struct Body {
    /// Of the circumscribed disc.
    pub(super) radius: f64,
    /// Of a body that is not round.
    outline: Option<Footprint>,
    track_width: f64,
    noise: OdometryNoise,
    /// How this robot differs from its model.
    pub(super) wear: TrackWear,
    pub(super) position: Point2<f64>,
    pub(super) heading: f64,
    /// No wall is nearer than this to this point, m.
    free: (Point2<f64>, f64),
    pub(super) contacts: Contacts,
    touching: Option<Touch>,
    /// How much farther the tracks ran than the body moved in the last step, because something
    /// stood in the way, m.
    pub(super) lost: f64,
}

impl Body {
    pub(super) fn new(model: &RobotModel, world_from_robot: &Pose2, rng: &mut impl Rng) -> Self {
        let mut own = |size: f64| {
            let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
            sign * size * rng.random_range(0.5..1.5)
        };
        let longer = 0.5 * own(model.odometry_bias.track_mismatch);
        Self {
            wear: TrackWear {
                left: -longer,
                right: longer,
                track_width: own(model.odometry_bias.track_width),
            },
            radius: model.radius(),
            outline: model.outline(0.0),
            track_width: model.track_width,
            noise: model.odometry_noise,
            position: world_from_robot.position(),
            heading: world_from_robot.heading(),
            free: (world_from_robot.position(), 0.0),
            contacts: Contacts::default(),
            touching: None,
            lost: 0.0,
        }
    }

    pub(super) fn pose(&self) -> Pose2 {
        Pose2::new(self.position.x, self.position.y, self.heading)
    }

    /// Puts the body elsewhere, touching nothing.
    pub(super) fn place(&mut self, world_from_robot: &Pose2) {
        self.position = world_from_robot.position();
        self.heading = world_from_robot.heading();
        self.touching = None;
        self.lost = 0.0;
        self.forget_free_room();
    }

    /// Call this after walls have changed: what was known of free room is no longer valid.
    pub(super) fn forget_free_room(&mut self) {
        self.free = (self.position, 0.0);
    }

    pub(super) fn bumpers(&self) -> Bumpers {
        let Some(Touch { to, .. }) = self.touching else {
            return Bumpers::default();
        };
        let bearing = wrap(libm::atan2(to.y, to.x) - self.heading);
        let front = bearing.abs() < std::f64::consts::FRAC_PI_2;
        // Straight ahead presses both.
        Bumpers {
            left: front && bearing > -0.2,
            right: front && bearing < 0.2,
        }
    }

    /// Moves by one step of the tracks.
    pub(super) fn step(
        &mut self,
        tracks: &Tracks,
        caster: &Caster,
        movers: &[Disc],
        rng: &mut impl Rng,
    ) {
        self.lost = 0.0;
        let (before, heading) = (self.position, self.heading);
        if tracks.left != 0.0 || tracks.right != 0.0 {
            let (way, turn) = self.slipped(tracks, rng);
            let ahead = unit_vector(self.heading);
            let lost = match self.outline.take() {
                Some(outline) => {
                    let lost = self.move_outline(&outline, (way, turn), caster, movers);
                    self.outline = Some(outline);
                    lost
                }
                None => {
                    let lost = self.move_by(way, caster, movers);
                    self.heading = wrap(self.heading + turn);
                    lost
                }
            };
            self.lost = lost.dot(&ahead);
        }
        let turned = wrap(self.heading - heading);
        self.feel((self.position - before, turned), caster, movers);
    }

    /// The motion in the world frame that results from the tracks' distances, and the turn.
    fn slipped(&self, tracks: &Tracks, rng: &mut impl Rng) -> (Vector2<f64>, f64) {
        let (left, right) = gaussian_pair(rng);
        let (sideways, heading) = gaussian_pair(rng);
        let grip = |ran: f64, g: f64| ran + (self.noise.per_metre * ran.abs()).sqrt() * g;
        let gripped = self.wear.ran(&Tracks {
            left: grip(tracks.left, left),
            right: grip(tracks.right, right),
        });
        let advance = 0.5 * (gripped.left + gripped.right);
        let turn = (gripped.right - gripped.left) / self.wear.width(self.track_width);
        let asked_advance = 0.5 * (tracks.left + tracks.right).abs();
        let asked_turn = (tracks.right - tracks.left).abs() / self.track_width;
        let drift = (self.noise.lateral_per_metre * asked_advance).sqrt() * sideways;
        let turn = turn + (self.noise.heading_per_radian * asked_turn).sqrt() * heading;
        let (sin, cos) = sin_cos(self.heading + 0.5 * turn);
        let way = Vector2::new(advance * cos - drift * sin, advance * sin + drift * cos);
        (way, turn)
    }

    /// Moves the disc, sliding along what it meets; it never ends inside anything. Returns the part
    /// of the motion that led into it.
    fn move_by(&mut self, way: Vector2<f64>, caster: &Caster, movers: &[Disc]) -> Vector2<f64> {
        let aim = self.position + way;
        let in_free_room = (aim - self.free.0).length() <= self.free.1;
        if in_free_room && movers.is_empty() {
            self.position = aim;
            return Vector2::zeros();
        }
        let mut lost = Vector2::zeros();
        let mut rest = way;
        for _ in 0..MOST_SLIDES {
            let length = rest.length();
            if length < 1e-12 {
                break;
            }
            let Some((reach, normal)) = self.first_touch(rest / length, length, caster, movers)
            else {
                self.position += rest;
                break;
            };
            let moved = rest * ((reach - SKIN).max(0.0) / length);
            self.position += moved;
            rest -= moved;
            // The part that leads into the wall is lost to slipping tracks.
            let inwards = normal * normal.dot(&rest).min(0.0);
            rest -= inwards;
            lost += inwards;
        }
        let clearance = caster.clearance(self.position, self.radius + LOOKOUT) - self.radius;
        self.free = (self.position, clearance - TOUCH);
        lost
    }

    /// Distance to the first touch along `direction`, and the surface's normal there.
    fn first_touch(
        &self,
        direction: Vector2<f64>,
        length: f64,
        caster: &Caster,
        movers: &[Disc],
    ) -> Option<(f64, Vector2<f64>)> {
        let mut first: Option<(f64, Vector2<f64>)> = None;
        let mut take = |touch: Option<(f64, Vector2<f64>)>| {
            if let Some((reach, _)) = touch
                && reach <= length + SKIN
                && first.is_none_or(|(best, _)| reach < best)
            {
                first = touch;
            }
        };
        let (at, radius) = (self.position, self.radius);
        let middle = at + direction * (0.5 * length);
        caster.near(middle, radius + 0.5 * length + SKIN, |_, wall| {
            take(touch_of_segment(&wall.segment, at, direction, radius));
        });
        for mover in movers {
            take(touch_of_disc(
                mover.centre,
                at,
                direction,
                radius + mover.radius,
            ));
        }
        first
    }

    /// Counts a contact when it begins, in a step in which the body moved by a distance and a turn.
    fn feel(&mut self, motion: (Vector2<f64>, f64), caster: &Caster, movers: &[Disc]) {
        let is_touched = |touch: &Touch| touch.to.length() <= self.radius + TOUCH;
        let touching = match &self.outline {
            Some(outline) => self.touch_of_outline(outline, caster, movers),
            None => self.nearest(caster, movers).filter(is_touched),
        };
        if let (Some(touch), None) = (&touching, &self.touching) {
            self.contacts.count(touch, motion);
        }
        self.touching = touching;
    }

    /// The nearest surface around, if it is near enough to matter for a touch.
    fn nearest(&self, caster: &Caster, movers: &[Disc]) -> Option<Touch> {
        let mut nearest: Option<Touch> = None;
        let mut take = |to: Vector2<f64>, is_mover: bool| {
            if nearest.is_none_or(|n| to.norm_squared() < n.to.norm_squared()) {
                let into = to;
                nearest = Some(Touch { to, into, is_mover });
            }
        };
        if (self.position - self.free.0).length() > self.free.1 {
            caster.near(self.position, self.radius + TOUCH, |_, wall| {
                let at = wall.segment.closest_point(self.position);
                take(at - self.position, false);
            });
        }
        for mover in movers {
            let to = mover.centre - self.position;
            let distance = to.length();
            take(to * ((distance - mover.radius) / distance.max(1e-9)), true);
        }
        nearest
    }
}

/// Where a disc of `radius` moving from `from` along the unit `direction` first touches the
/// segment.
fn touch_of_segment(
    segment: &Segment,
    from: Point2<f64>,
    direction: Vector2<f64>,
    radius: f64,
) -> Option<(f64, Vector2<f64>)> {
    let away = from - segment.closest_point(from);
    let distance = away.length();
    if distance <= radius {
        // Already touching (by rounding): only motion away from it is free.
        let normal = away / distance.max(1e-12);
        return (direction.dot(&normal) < 0.0).then_some((0.0, normal));
    }
    let along = segment.vector();
    let length = along.length();
    let mut first = [segment.a, segment.b]
        .into_iter()
        .filter_map(|end| touch_of_disc(end, from, direction, radius))
        .min_by(|p, q| p.0.total_cmp(&q.0));
    if length > 0.0 {
        let along = along / length;
        let mut normal = Vector2::new(-along.y, along.x);
        if normal.dot(&(from - segment.a)) < 0.0 {
            normal = -normal;
        }
        let closing = -normal.dot(&direction);
        let height = normal.dot(&(from - segment.a)) - radius;
        if closing > 0.0 && height >= 0.0 {
            let reach = height / closing;
            let foot = along.dot(&(from + direction * reach - segment.a));
            if (0.0..=length).contains(&foot) && first.is_none_or(|(best, _)| reach < best) {
                first = Some((reach, normal));
            }
        }
    }
    first
}

/// Where a point moving along the unit `direction` first comes within `radius` of `centre`.
fn touch_of_disc(
    centre: Point2<f64>,
    from: Point2<f64>,
    direction: Vector2<f64>,
    radius: f64,
) -> Option<(f64, Vector2<f64>)> {
    let away = from - centre;
    let closing = -away.dot(&direction);
    if closing <= 0.0 {
        return None;
    }
    let outside = away.norm_squared() - radius * radius;
    if outside <= 0.0 {
        return Some((0.0, away / away.length().max(1e-12)));
    }
    let root = closing * closing - outside;
    if root < 0.0 {
        return None;
    }
    // The nearer root of t² - 2 closing t + outside = 0, in the form without cancellation.
    let reach = outside / (closing + root.sqrt());
    let normal = away + direction * reach;
    Some((reach, normal / normal.length().max(1e-12)))
}

#[cfg(test)]
mod tests;
