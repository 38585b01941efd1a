//! The sense-plan-act cycle for sensors that scan on command, while the robot stands still.
//!
//! 1. Scan, plan, truncate, turn, drive one leg, then again. Each stage is recorded
//!    ([`StageReport`]).
//! 2. A leg ends where the map does, and where odometry would have lost the heading: tracks slip by
//!    degrees in a turn or a metre, and the next scan has to find walls where the filter's first
//!    order still holds. A turn that uses all of that up is followed by a scan, then by the leg.
//!    With [`super::PilotConfig::legs_by_estimate`] the estimate decides on the way when that is; a
//!    leg longer than the model would allow needs as much extra room beside it as the robot may
//!    stray.
//! 3. A leg ends early when a bumper is pressed, and when a partial scan on the move shows somebody
//!    before whom the robot could not stop at its speed ([`leg_is_safe`]); then it scans again.
//!    After such a partial scan during a turn the leg is not begun.
//!
//! Source: TDK 2016 §6.3: scan, plan, truncate the path to what has been seen (first turn and first
//! leg, the leg no longer than the sensor sees), command, repeat. Steps 2 and 3 are ours.

use nalgebra::Point2;

use super::around::people_are_near;
use super::stages::{Cut, StageReport};
use super::{Mode, Pilot, Situation, Status};
use crate::control::{free_distance, leg_is_safe};
use crate::geom::{Length, Pose2, Segment, wrap};
use crate::map::CellState;
use crate::robot::{Command, RobotModel, Stamp, Tracks};

/// The state of the cycle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum Phase {
    /// Scan before anything else.
    #[default]
    Scan,
    /// A scan was asked for at this time.
    Scanning(Stamp),
    /// Plan; whether the last scan followed a turn on the spot.
    Plan { has_turned: bool },
    /// Cut the plan to one leg.
    Truncate { leg: Segment, has_turned: bool },
    /// Turn by this angle, then scan.
    TurnAndScan(f64),
    /// Drive to this point.
    Leg(Leg),
    /// A leg was begun here.
    Going(Point2<f64>),
    /// A turn was begun that is to be followed by a scan.
    Turning,
    /// The scan after a turn was asked for at this time.
    ScanningAfterTurn(Stamp),
}

/// What remains to do of a leg.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leg {
    to: Point2<f64>,
    /// Number of turns towards it so far.
    turns: usize,
    /// Whether a turn and a scan came just before: then it is driven, whatever the next turn costs.
    has_turned: bool,
}

/// Turns smaller than this are left to the next leg, rad.
const SMALL_TURN: f64 = 0.03;
/// Legs shorter than this are not worth the next scan, m.
const SHORT_LEG: f64 = 0.05;
/// A sensor that answers no command within this time is asked again, s.
const SCAN_TIMEOUT: f64 = 30.0;

/// The result of one stage of the cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Next {
    /// Do the next stage at once.
    Stage,
    /// Give a command.
    Tell(Command),
    /// Nothing for now: the robot carries on.
    Wait,
}

impl Pilot {
    /// Whether the next scan belongs to the cycle; scans taken during a leg or a turn do not.
    pub(crate) fn awaits_scan(&self) -> bool {
        let is_awaited = matches!(self.phase, Phase::Scanning(_) | Phase::ScanningAfterTurn(_));
        is_awaited || self.mode == Mode::Manual
    }

    /// Does stages of the cycle up to the next command; `None` while the robot carries on.
    pub(super) fn in_cycle(&mut self, now: &Situation) -> Option<Command> {
        loop {
            match self.stage(now) {
                Next::Stage => {}
                Next::Tell(command) => return Some(command),
                Next::Wait => return None,
            }
        }
    }

    /// While a turn, a leg or a sweep is under way: decides whether it ends here.
    pub(super) fn under_way(&mut self, has_bumped: bool, now: &Situation) -> Option<Command> {
        let is_going = matches!(self.phase, Phase::Going(_));
        if has_bumped && is_going {
            return Some(Command::Stop);
        }
        if self.somebody_came(now.speeds.0, now) || (is_going && self.is_lost(now)) {
            // It does not end through a fault of the way: nothing to back off from.
            self.phase = Phase::Scan;
            return Some(Command::Stop);
        }
        None
    }

    /// Whether the heading has become so uncertain that a scan comes next.
    fn is_lost(&self, now: &Situation) -> bool {
        self.config.legs_by_estimate && now.heading_drift > self.config.leg_heading_sigma
    }

    /// Whether somebody came before whom a robot moving forward (back if negative) could not stop.
    fn somebody_came(&self, forward: f64, now: &Situation) -> bool {
        let config = &self.config.safe;
        now.points.is_some_and(|points| {
            let underway = self.underway(points, now);
            !leg_is_safe(forward, now.walkers, &underway, (&self.model, config))
        })
    }

    /// Does one stage of the cycle.
    pub(super) fn stage(&mut self, now: &Situation) -> Next {
        match self.phase {
            Phase::Scan => {
                self.phase = Phase::Scanning(now.stamp);
                self.command_scan(now)
            }
            Phase::Turning => {
                self.phase = Phase::ScanningAfterTurn(now.stamp);
                self.command_scan(now)
            }
            Phase::Scanning(since) | Phase::ScanningAfterTurn(since) => self.await_scan(since, now),
            Phase::Plan { has_turned } => self.plan_leg(has_turned, now),
            Phase::Truncate { leg, has_turned } => self.truncate(&leg, has_turned, now),
            Phase::TurnAndScan(angle) => {
                self.phase = Phase::Turning;
                self.stages.record(StageReport::Turn { angle });
                Next::Tell(Command::Turn(angle))
            }
            Phase::Leg(leg) => self.begin_leg(&leg, now),
            Phase::Going(from) => {
                self.phase = Phase::Scan;
                let is_short = (now.estimate.pose.position() - from).length() < 0.5 * SHORT_LEG;
                if is_short && people_are_near(now) {
                    // The safety rules have ended the leg because of somebody: no fault of the way,
                    // and no reason to give up the goal.
                    return Next::Stage;
                }
                if is_short {
                    self.get_unstuck(now);
                    let length = -self.free_way(-1.0, SHORT_LEG, now);
                    let wished = -SHORT_LEG;
                    self.stages.record(StageReport::Go { length, wished });
                    return Next::Tell(Command::Forward(length));
                }
                self.errand.stuck = 0;
                Next::Wait
            }
        }
    }

    fn command_scan(&mut self, now: &Situation) -> Next {
        self.status = Status::Scanning;
        if self.stages.now().is_none() {
            let estimate = *now.estimate;
            self.stages.record(StageReport::Init { estimate });
        }
        self.stages.record(StageReport::LooksRound);
        Next::Tell(Command::Scan)
    }

    fn await_scan(&mut self, since: Stamp, now: &Situation) -> Next {
        let has_turned = matches!(self.phase, Phase::ScanningAfterTurn(_));
        if now.points.is_some_and(|points| points.stamp > since) {
            self.phase = Phase::Plan { has_turned };
            return Next::Stage;
        }
        if now.stamp.since(since) > SCAN_TIMEOUT {
            self.phase = Phase::Scan;
        }
        Next::Wait
    }

    /// Plans again after each scan and takes the first leg.
    fn plan_leg(&mut self, has_turned: bool, now: &Situation) -> Next {
        self.phase = Phase::Scan;
        self.errand.next_review = now.stamp;
        self.errand.follower = None;
        if !self.has_way(now) {
            let why = self.status.to_string();
            self.stages.record(StageReport::NoPath { why });
            return Next::Wait;
        }
        self.tell_plan();
        let here = now.estimate.pose.position();
        let ahead = self.errand.follower.as_ref().map(|f| f.remaining(here));
        let to_go = ahead.as_ref().map_or(0.0, crate::plan::Path::length);
        let first = ahead.and_then(|path| path.legs().find(|leg| leg.length() > 0.02));
        let Some(leg) = first.filter(|_| to_go > self.config.follow.tolerance) else {
            self.arrive(now);
            return Next::Wait;
        };
        let leg = Segment::new(here, leg.b);
        self.phase = Phase::Truncate { leg, has_turned };
        Next::Stage
    }

    fn tell_plan(&mut self) {
        let Some(route) = &self.errand.route else {
            return;
        };
        let report = StageReport::Plan {
            goal: route.path.points.last().copied().unwrap_or_default(),
            length: route.path.length(),
            legs: route.path.legs().count(),
            by: route.by,
        };
        self.stages.record(report);
    }

    /// Cuts the first leg to what was seen and to what odometry can be trusted for.
    fn truncate(&mut self, leg: &Segment, has_turned: bool, now: &Situation) -> Next {
        let way = leg.vector();
        let turn = wrap(libm::atan2(way.y, way.x) - now.estimate.pose.heading());
        let trusted = trusted_length(turn, &self.model, self.config.leg_heading_sigma);
        // Once for each leg: if two ways are equally good, the robot must not turn to and fro. What
        // the turn costs shows after it.
        let is_led = self.config.legs_by_estimate;
        if trusted < 2.0 * SHORT_LEG && !has_turned && !is_led {
            self.tell_cut(0.0, leg, Cut::TurnFirst);
            self.phase = Phase::TurnAndScan(turn);
            return Next::Stage;
        }
        let whole = leg.length();
        let by_odometry = match is_led {
            true => f64::INFINITY,
            false => trusted.max(2.0 * SHORT_LEG),
        };
        let cuts = [
            (self.seen_length(leg, now), Cut::Unseen),
            (self.config.longest_leg, Cut::Longest),
            (by_odometry, Cut::Odometry),
        ];
        let (length, cut) = cuts.into_iter().fold((whole, Cut::Nothing), |least, next| {
            if next.0 < least.0 { next } else { least }
        });
        self.tell_cut(length, leg, cut);
        let to = leg.a + way * (length / whole).min(1.0);
        self.phase = Phase::Leg(Leg {
            to,
            turns: 0,
            has_turned,
        });
        Next::Stage
    }

    fn tell_cut(&mut self, length: f64, leg: &Segment, cut: Cut) {
        let leg = leg.length();
        self.stages
            .record(StageReport::Truncate { length, leg, cut });
    }

    /// Turns towards the end of the leg, then drives.
    fn begin_leg(&mut self, leg: &Leg, now: &Situation) -> Next {
        let &Leg {
            to,
            turns,
            has_turned,
        } = leg;
        if turns > 0 && !has_turned && self.is_lost(now) {
            self.phase = Phase::Turning;
            return Next::Stage;
        }
        let pose = &now.estimate.pose;
        let way = to - pose.position();
        let angle = wrap(libm::atan2(way.y, way.x) - pose.heading());
        if angle.abs() > SMALL_TURN && turns < 3 {
            self.phase = Phase::Leg(Leg {
                turns: turns + 1,
                ..*leg
            });
            self.stages.record(StageReport::Turn { angle });
            return Next::Tell(Command::Turn(angle));
        }
        if self.somebody_came(self.model.max_speed, now) {
            self.phase = Phase::Scan;
            return Next::Wait;
        }
        self.phase = Phase::Going(pose.position());
        let wished = way.length();
        let length = self.free_leg(wished, now);
        self.stages.record(StageReport::Go { length, wished });
        Next::Tell(Command::Forward(length))
    }

    /// How much of a leg the last scan shows to be free, m. If the leg is longer than odometry
    /// keeps the heading, the free strip must be wider by as much as the robot may stray meanwhile.
    fn free_leg(&self, length: f64, now: &Situation) -> f64 {
        let free = self.free_way(1.0, length, now);
        let trusted = trusted_length(0.0, &self.model, self.config.leg_heading_sigma);
        if free <= trusted {
            return free;
        }
        let beside = 2.0 * strayed(free, &self.model);
        let wide = self.free_beside(1.0, beside, free, now);
        wide.max(trusted)
    }

    /// How much of `length` (m) the last scan shows to be free ahead (`direction` 1) or behind
    /// (-1).
    fn free_way(&self, direction: f64, length: f64, now: &Situation) -> f64 {
        self.free_beside(direction, 0.0, length, now)
    }

    /// The same for a robot that is wider by `beside` to either side.
    fn free_beside(&self, direction: f64, beside: f64, length: f64, now: &Situation) -> f64 {
        let radius = self.model.radius() + self.config.safe.gap + beside;
        let free = now.points.map_or(length, |points| {
            let along = (direction, 0.0);
            free_distance(along, points, &now.motion_since_scan, radius, length)
        });
        free.max(0.0)
    }

    /// How much of a leg leads over cells that were seen; at least a little, within the sensor's
    /// blind zone.
    fn seen_length(&self, leg: &Segment, now: &Situation) -> f64 {
        let length = leg.length();
        let step = 0.5 * now.grid.resolution();
        // The robot stands there, so the space around it is known to be free.
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

/// The longest leg after a turn for which odometry keeps the heading to `sigma`, m; negative where
/// the turn alone is too much.
fn trusted_length(turn: f64, model: &RobotModel, sigma: f64) -> f64 {
    let half = 0.5 * turn.abs() * model.track_width;
    let by_turn = heading_variance(-half, half, model);
    let per_metre = heading_variance(1.0, 1.0, model);
    (sigma * sigma - by_turn) / per_metre.max(f64::MIN_POSITIVE)
}

/// How far a leg by odometry alone strays to a side, m: the standard deviation of the integral of
/// the heading's random walk.
fn strayed(length: f64, model: &RobotModel) -> f64 {
    let per_metre = heading_variance(1.0, 1.0, model);
    (per_metre * length * length * length / 3.0).sqrt()
}

/// Variance of the heading by odometry after the tracks have run these distances, rad².
fn heading_variance(left: f64, right: f64, model: &RobotModel) -> f64 {
    let tracks = Tracks { left, right };
    tracks.covariance(model.track_width, &model.odometry_noise)[(2, 2)]
}

/// Asks for a scan when a robot that was driven by hand stands again.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct HandScan {
    pub(super) asked: Option<Stamp>,
}

impl HandScan {
    /// Whether it is time to scan.
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
    motion.position().coords.length() > 0.1 || motion.heading().abs() > 0.3
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_leg_strays_by_the_integral_of_its_headings_random_walk() {
        let model = RobotModel::rp6();
        let per_metre =
            2.0 * model.odometry_noise.per_metre / (model.track_width * model.track_width);
        for length in [0.1, 0.4, 0.7] {
            // Each millimetre adds a random turn, which acts on the rest of the leg.
            let step = 1e-3;
            let steps = (length / step) as usize;
            let left = |i: usize| length - (i as f64 + 0.5) * step;
            let variance: f64 = (0..steps)
                .map(|i| per_metre * step * left(i) * left(i))
                .sum();
            let off = strayed(length, &model) - variance.sqrt();
            assert!(off.abs() < 0.02 * variance.sqrt(), "{length}: {off}");
        }
    }

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
