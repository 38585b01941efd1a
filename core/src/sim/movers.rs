//! Discs that walk along way-points.
//!
//! A mover walks at constant speed from way-point to way-point, round and round or to and fro, and
//! pauses at each. It waits while the next step would bring it within [`COURTESY`] of the robot:
//! movers do not push.

use nalgebra::Point2;

use super::{Disc, Mover};
use crate::geom::Length;

/// Room that a mover leaves to the robot, m.
const COURTESY: f64 = 0.10;

/// Where one mover is on its way.
#[derive(Clone, Debug)]
pub(super) struct Walker {
    /// All way-points of one round: there and back if the path is open.
    round: Vec<Point2<f64>>,
    /// Index of the way-point it walks to.
    next: usize,
    speed: f64,
    /// How long it stands at each way-point, s.
    pause: f64,
    /// Remaining time of the present pause, s.
    rest: f64,
    pub(super) disc: Disc,
}

impl Walker {
    pub(super) fn new(mover: &Mover) -> Self {
        let mut round = mover.waypoints.clone();
        if !mover.closed {
            round.extend(mover.waypoints.iter().rev().skip(1));
        }
        Self {
            next: usize::from(round.len() > 1),
            speed: mover.speed,
            pause: mover.pause,
            rest: 0.0,
            disc: Disc {
                centre: round.first().copied().unwrap_or_else(Point2::origin),
                radius: mover.radius,
            },
            round,
        }
    }

    /// Walks on for `dt` seconds, or waits for the robot.
    pub(super) fn step(&mut self, dt: f64, robot: &Disc) {
        if self.rest > 0.0 {
            self.rest -= dt;
            return;
        }
        let (aim, next) = self.ahead(self.speed * dt);
        let room = self.disc.radius + robot.radius + COURTESY;
        let now = (self.disc.centre - robot.centre).length();
        let then = (aim - robot.centre).length();
        if then < room && then < now {
            return;
        }
        if next != self.next {
            self.rest = self.pause;
        }
        self.disc.centre = aim;
        self.next = next;
    }

    /// Its position after `way` metres, and the way-point that it walks to then.
    fn ahead(&self, mut way: f64) -> (Point2<f64>, usize) {
        let (mut at, mut next) = (self.disc.centre, self.next);
        // Coincident way-points cost nothing, so a round may be walked more than once; once is
        // enough.
        for _ in 0..=self.round.len() {
            let Some(goal) = self.round.get(next) else {
                break;
            };
            let to = goal - at;
            let length = to.length();
            if way < length {
                return (at + to * (way / length), next);
            }
            way -= length;
            at = *goal;
            next = (next + 1) % self.round.len();
        }
        (at, next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walker(closed: bool) -> Walker {
        Walker::new(&Mover {
            waypoints: vec![
                Point2::new(0.0, 0.0),
                Point2::new(2.0, 0.0),
                Point2::new(2.0, 1.0),
            ],
            closed,
            speed: 1.0,
            radius: 0.2,
            pause: 0.0,
        })
    }

    fn after(walker: &mut Walker, seconds: f64, robot: Point2<f64>) -> Point2<f64> {
        for _ in 0..(seconds * 100.0).round() as usize {
            walker.step(
                0.01,
                &Disc {
                    centre: robot,
                    radius: 0.1,
                },
            );
        }
        walker.disc.centre
    }

    #[test]
    fn walks_to_and_fro_or_round() {
        let far = Point2::new(100.0, 0.0);
        let mut open = walker(false);
        for (seconds, x, y) in [
            (2.5, 2.0, 0.5),
            (1.0, 2.0, 0.5),
            (2.5, 0.0, 0.0),
            (1.0, 1.0, 0.0),
        ] {
            let at = after(&mut open, seconds, far);
            assert!((at - Point2::new(x, y)).length() < 1e-9, "{at}");
        }
        let mut closed = walker(true);
        let at = after(&mut closed, 3.0 + 5.0_f64.sqrt() + 1.0, far);
        assert!((at - Point2::new(1.0, 0.0)).length() < 0.01, "{at}");
    }

    #[test]
    fn stands_at_each_way_point_as_long_as_it_likes() {
        let far = Point2::new(100.0, 0.0);
        let mut walker = Walker {
            pause: 3.0,
            ..walker(true)
        };
        // 2 m on the way, 3 s at the corner, then on.
        let at = after(&mut walker, 4.9, far);
        assert!((at - Point2::new(2.0, 0.0)).length() < 0.02, "{at}");
        let at = after(&mut walker, 0.6, far);
        assert!((at - Point2::new(2.0, 0.5)).length() < 0.03, "{at}");
    }

    #[test]
    fn waits_for_the_robot_and_goes_on() {
        let mut walker = walker(false);
        let at = after(&mut walker, 5.0, Point2::new(1.5, 0.0));
        assert!((at.x - 1.1).abs() < 0.02, "{at}");
        let at = after(&mut walker, 0.5, Point2::new(1.5, 5.0));
        assert!(at.x > 1.5, "{at}");
    }

    #[test]
    fn one_way_point_stands() {
        let mut walker = Walker::new(&Mover {
            waypoints: vec![Point2::new(1.0, 1.0)],
            closed: true,
            speed: 1.0,
            radius: 0.2,
            pause: 0.0,
        });
        assert_eq!(
            after(&mut walker, 1.0, Point2::origin()),
            Point2::new(1.0, 1.0)
        );
    }
}
