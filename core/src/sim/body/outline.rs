//! A body that is not round: how far it moves and turns before it touches something.
//!
//! In: the translation and turn of one step. Out: the pose at their end or where something stopped
//! them, and how much of the translation was lost.
//!
//! 1. Conservative advancement (Mirtich 1996): the nearest points of the body and of each nearby
//!    object are d apart in a direction n. A part of the motion is free if no corner moves by more
//!    than d along n towards the object. If all of the motion is free, it is done at once.
//! 2. If almost nothing of it is free, the part that leads into the touched object is removed: from
//!    the translation first, then from the turn.
//! 3. The body never ends inside anything, because every part of the motion was proved free; a
//!    motion that cannot be completed ends where it is.

use nalgebra::{Point2, Vector2};

use super::{Body, Caster, Disc, LOOKOUT, SKIN, TOUCH, Touch};
use crate::geom::{Footprint, Length, Pose2, Segment, wrap};

/// Most parts in which a motion is done.
const MOST_PARTS: usize = 32;
/// A part of the remaining motion below this counts as none.
const STUCK: f64 = 1e-3;

/// A nearby object: the nearest points of body and object, world frame.
struct Proximity {
    on_body: Point2<f64>,
    apart: f64,
    /// From the object to the body, of unit length.
    normal: Vector2<f64>,
}

impl Body {
    /// Moves and turns; returns the part of the translation that was lost.
    pub(super) fn move_outline(
        &mut self,
        outline: &Footprint,
        (way, turn): (Vector2<f64>, f64),
        caster: &Caster,
        movers: &[Disc],
    ) -> Vector2<f64> {
        let is_in_free_room = (self.position + way - self.free.0).length() <= self.free.1;
        if is_in_free_room && movers.is_empty() {
            self.position += way;
            self.heading = wrap(self.heading + turn);
            return Vector2::zeros();
        }
        let mut rest = (way, turn);
        let mut lost = Vector2::zeros();
        for _ in 0..MOST_PARTS {
            if rest.0 == Vector2::zeros() && rest.1 == 0.0 {
                break;
            }
            let near = self.near(outline, rest.0.length(), caster, movers);
            let parts = near.iter().map(|near| self.free_part(outline, rest, near));
            let first = parts.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
            let (part, stop) = match first {
                Some((index, part)) if part < 1.0 => (part, near.get(index)),
                _ => (1.0, None),
            };
            self.position += rest.0 * part;
            self.heading = wrap(self.heading + rest.1 * part);
            rest = (rest.0 * (1.0 - part), rest.1 * (1.0 - part));
            if let Some(near) = stop.filter(|_| part < STUCK) {
                let inwards = near.normal * near.normal.dot(&rest.0).min(0.0);
                rest.0 -= inwards;
                lost += inwards;
                let arm = near.on_body - self.position;
                if near.normal.dot(&(Vector2::new(-arm.y, arm.x) * rest.1)) < 0.0 {
                    rest.1 = 0.0;
                }
            }
        }
        let clearance = caster.clearance(self.position, self.radius + LOOKOUT) - self.radius;
        self.free = (self.position, clearance - TOUCH);
        lost + rest.0
    }

    /// The part of a motion, 0 to 1, that is proved not to touch an object.
    fn free_part(
        &self,
        outline: &Footprint,
        (way, turn): (Vector2<f64>, f64),
        near: &Proximity,
    ) -> f64 {
        let room = (near.apart - 0.5 * SKIN).max(0.0);
        let pose = self.pose();
        // To first order each corner moves on a line; an arc departs from it by half the
        // square of its angle times its radius.
        let nearer = outline.corners().iter().map(|corner| {
            let arm = pose * *corner - self.position;
            -near.normal.dot(&(way + Vector2::new(-arm.y, arm.x) * turn))
        });
        let linear = nearer.fold(0.0, f64::max);
        let bend = 0.5 * turn * turn * outline.radius_around();
        if linear + bend <= room {
            return 1.0;
        }
        // bend f² + linear f = room, in the form without cancellation.
        2.0 * room / (linear + (linear * linear + 4.0 * bend * room).sqrt())
    }

    /// Objects so near that a motion of this length might touch them.
    fn near(
        &self,
        outline: &Footprint,
        length: f64,
        caster: &Caster,
        movers: &[Disc],
    ) -> Vec<Proximity> {
        let pose = self.pose();
        let reach = self.radius + length + TOUCH;
        let mut found = vec![];
        caster.near(self.position, reach, |_, wall| {
            found.push(near_wall(outline, &pose, &wall.segment));
        });
        found.extend(movers.iter().map(|mover| near_disc(outline, &pose, mover)));
        found
    }

    /// The nearest object that an outline touches.
    pub(super) fn touch_of_outline(
        &self,
        outline: &Footprint,
        caster: &Caster,
        movers: &[Disc],
    ) -> Option<Touch> {
        let pose = self.pose();
        let mut near = vec![];
        if (self.position - self.free.0).length() > self.free.1 {
            caster.near(self.position, self.radius + TOUCH, |_, wall| {
                near.push((near_wall(outline, &pose, &wall.segment), false));
            });
        }
        near.extend(movers.iter().map(|m| (near_disc(outline, &pose, m), true)));
        let first = near
            .iter()
            .min_by(|(a, _), (b, _)| a.apart.total_cmp(&b.apart));
        let touched = first.filter(|(near, _)| near.apart <= TOUCH);
        touched.map(|(near, is_mover)| Touch {
            to: near.on_body - self.position,
            into: -near.normal,
            is_mover: *is_mover,
        })
    }
}

fn near_wall(outline: &Footprint, pose: &Pose2, wall: &Segment) -> Proximity {
    let [on_body, on_wall] = outline.nearest(pose, wall);
    between(on_body, on_wall, 0.0)
}

fn near_disc(outline: &Footprint, pose: &Pose2, disc: &Disc) -> Proximity {
    let centre = pose.inverse() * disc.centre;
    let on_body = *pose * outline.closest_point(centre);
    between(on_body, disc.centre, disc.radius)
}

fn between(on_body: Point2<f64>, on_thing: Point2<f64>, radius: f64) -> Proximity {
    let away = on_body - on_thing;
    let distance = away.length();
    Proximity {
        on_body,
        apart: distance - radius,
        normal: away / distance.max(1e-12),
    }
}
