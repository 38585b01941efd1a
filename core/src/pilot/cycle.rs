//! The sense-plan-act cycle for sensors that scan on command, the robot standing still.
//!
//! 1. Scan, plan, turn, drive one leg, again.
//! 2. A leg ends where the map does, and where odometry would have lost the heading: tracks slip by degrees in a turn or
//!    a metre, and the next scan has to find walls where the filter's first order still holds. A turn that uses all of
//!    that up is followed by a scan, then by the leg.
//!
//! Source: TDK 2016 §6.3: scan, plan, truncate the path to what has been seen (first turn and first leg, the leg no
//! longer than the sensor sees), command, repeat. Step 2 is ours.

use nalgebra::Point2;

use super::{Pilot, Situation, Status};
use crate::control::free_distance;
use crate::geom::{Pose2, Segment, wrap};
use crate::map::CellState;
use crate::robot::{Command, RobotModel, Stamp, Tracks};

/// Where the cycle stands.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum Phase {
    /// To look before anything else.
    #[default]
    Look,
    /// A scan was asked for at this time.
    Looking(Stamp),
    /// To drive to this point, after so many turns.
    Leg(Point2<f64>, usize),
    /// A leg was begun here.
    Going(Point2<f64>),
    /// A turn was begun that is to be followed by a scan.
    Turning,
    /// That scan was asked for at this time.
    LookingAfterTurn(Stamp),
}

/// Turns smaller than this are left to the next leg, rad.
const SMALL_TURN: f64 = 0.03;
/// Legs shorter than this are not worth the next scan, m.
const SHORT_LEG: f64 = 0.05;
/// A sensor that answers no command within this time is asked again, s.
const SCAN_TIMEOUT: f64 = 30.0;

impl Pilot {
    /// One step of the cycle; `None` while the robot carries on.
    pub(super) fn in_cycle(&mut self, now: &Situation) -> Option<Command> {
        match self.phase {
            Phase::Look => {
                self.phase = Phase::Looking(now.stamp);
                self.status = Status::Scanning;
                Some(Command::Scan)
            }
            Phase::Turning => {
                self.phase = Phase::LookingAfterTurn(now.stamp);
                self.status = Status::Scanning;
                Some(Command::Scan)
            }
            Phase::Looking(since) | Phase::LookingAfterTurn(since) => {
                let has_seen = now.points.is_some_and(|points| points.stamp > since);
                if !has_seen {
                    if now.stamp.since(since) > SCAN_TIMEOUT {
                        self.phase = Phase::Look;
                    }
                    return None;
                }
                let has_turned = matches!(self.phase, Phase::LookingAfterTurn(_));
                self.plan_leg(has_turned, now)
            }
            Phase::Leg(to, turns) => self.begin_leg(to, turns, now),
            Phase::Going(from) => {
                self.phase = Phase::Look;
                if (now.estimate.pose.position() - from).norm() < 0.5 * SHORT_LEG {
                    self.get_unstuck(now);
                    return Some(Command::Forward(-self.free_way(-1.0, SHORT_LEG, now)));
                }
                self.errand.stuck = 0;
                None
            }
        }
    }

    /// Plans anew after each scan and takes the first leg.
    fn plan_leg(&mut self, has_turned: bool, now: &Situation) -> Option<Command> {
        self.phase = Phase::Look;
        self.errand.next_review = now.stamp;
        self.errand.follower = None;
        if !self.has_way(now) {
            return None;
        }
        let here = now.estimate.pose.position();
        let ahead = self.errand.follower.as_ref().map(|f| f.remaining(here));
        let to_go = ahead.as_ref().map_or(0.0, crate::plan::Path::length);
        let first = ahead.and_then(|path| path.legs().find(|leg| leg.length() > 0.02));
        let Some(leg) = first.filter(|_| to_go > self.config.follow.tolerance) else {
            self.arrive(now);
            return None;
        };
        let leg = Segment::new(here, leg.b);
        let way = leg.vector();
        let turn = wrap(libm::atan2(way.y, way.x) - now.estimate.pose.heading());
        let trusted = trusted_length(turn, &self.model, self.config.leg_heading_sigma);
        // Once for each leg: where two ways are alike, the robot must not turn to and fro.
        if trusted < 2.0 * SHORT_LEG && !has_turned {
            self.phase = Phase::Turning;
            return Some(Command::Turn(turn));
        }
        let length = self
            .seen_length(&leg, now)
            .min(self.config.longest_leg)
            .min(trusted.max(2.0 * SHORT_LEG));
        let to = here + leg.vector() * (length / leg.length()).min(1.0);
        self.begin_leg(to, 0, now)
    }

    /// Turns towards the end of the leg, then drives.
    fn begin_leg(&mut self, to: Point2<f64>, turns: usize, now: &Situation) -> Option<Command> {
        let pose = &now.estimate.pose;
        let way = to - pose.position();
        let error = wrap(libm::atan2(way.y, way.x) - pose.heading());
        if error.abs() > SMALL_TURN && turns < 3 {
            self.phase = Phase::Leg(to, turns + 1);
            return Some(Command::Turn(error));
        }
        self.phase = Phase::Going(pose.position());
        Some(Command::Forward(self.free_way(1.0, way.norm(), now)))
    }

    /// How much of `length` (m) the last scan shows to be free ahead (`direction` 1) or behind (-1).
    fn free_way(&self, direction: f64, length: f64, now: &Situation) -> f64 {
        let radius = self.model.radius() + self.config.safe.gap;
        let free = now.points.map_or(length, |points| {
            let along = (direction, 0.0);
            free_distance(along, points, &now.motion_since_scan, radius, length)
        });
        free.max(0.0)
    }

    /// How much of a leg leads over cells that were seen; at least a little, where the sensor is blind.
    fn seen_length(&self, leg: &Segment, now: &Situation) -> f64 {
        let length = leg.length();
        let step = 0.5 * now.grid.resolution();
        // Around itself the robot knows by standing there.
        let blind = self.model.radius() + 2.0 * now.grid.resolution();
        let steps = (length / step).ceil() as usize;
        let unseen = (0..=steps)
            .map(|i| (i as f64 * step).min(length))
            .find(|&at| {
                let point = leg.a + leg.vector() * (at / length);
                at > blind && now.grid.state(now.grid.cell_at(point)) == CellState::Unknown
            });
        unseen.map_or(length, |at| (at - self.model.radius()).max(2.0 * SHORT_LEG))
    }
}

/// The longest leg after a turn for which odometry keeps the heading to `sigma`, m; negative where the turn alone is
/// too much.
fn trusted_length(turn: f64, model: &RobotModel, sigma: f64) -> f64 {
    let variance =
        |tracks: Tracks| tracks.covariance(model.track_width, &model.odometry_noise)[(2, 2)];
    let half = 0.5 * turn.abs() * model.track_width;
    let by_turn = variance(Tracks {
        left: -half,
        right: half,
    });
    let per_metre = variance(Tracks {
        left: 1.0,
        right: 1.0,
    });
    (sigma * sigma - by_turn) / per_metre.max(f64::MIN_POSITIVE)
}

/// A scan when the robot has been driven by hand and stands again.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct HandScan {
    pub(super) asked: Option<Stamp>,
}

impl HandScan {
    /// Whether it is time to look.
    pub(super) fn is_due(&mut self, now: &Situation) -> bool {
        let moved = now.points.is_none() || has_moved(&now.motion_since_scan);
        let asked_lately = self.asked.is_some_and(|at| now.stamp.since(at) < 1.0);
        if moved && !asked_lately {
            self.asked = Some(now.stamp);
            return true;
        }
        false
    }
}

fn has_moved(motion: &Pose2) -> bool {
    motion.position().coords.norm() > 0.1 || motion.heading().abs() > 0.3
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leg_and_turn_together_cost_the_heading_what_was_allowed() {
        let model = RobotModel::rp6();
        let noise = &model.odometry_noise;
        let turns = noise.heading_per_radian + noise.per_metre / model.track_width;
        let metres = 2.0 * noise.per_metre / (model.track_width * model.track_width);
        for turn in [0.0, 0.3, -0.3, 0.6] {
            let length = trusted_length(turn, &model, 0.05);
            let variance = turns * turn.abs() + metres * length;
            assert!((variance - 0.05 * 0.05).abs() < 1e-12, "{turn}");
        }
        assert!(trusted_length(3.0, &model, 0.05) < 0.0);
    }
}
