//! The parts of an errand: where to, by which way, and whether that way is still valid.

use nalgebra::Point2;

use super::around::Detour;
use super::blocked::{disc_fits, is_blocked, leads_outside, outline_is_blocked};
use super::closing::Closing;
use super::explorer::{Explorer, Reason};
use super::{Failure, Finish, Homecoming, Mode, Pilot, Situation, Status};
use crate::control::{FenceConfig, Follower, ProgressWatch};
use crate::geom::{Length, Segment};
use crate::map::CellState;
use crate::plan::{
    ESCAPE_REACH, Frontier, FrontierChoice, GridSpace, NoPath, Planner, Route, SAME_GOAL, Unknown,
    Wavefront, Within, find_frontiers, order_by_tour, plan_outline_route, plan_route, rect_around,
};
use crate::robot::{BodyShape, Stamp};

/// State of one errand; setting a mode begins a new one.
#[derive(Clone, Debug, Default)]
pub(super) struct Errand {
    pub(super) route: Option<Route>,
    pub(super) tree: Vec<Segment>,
    pub(super) follower: Option<Follower>,
    pub(super) explorer: Explorer,
    pub(super) goal: Option<Point2<f64>>,
    pub(super) watch: ProgressWatch,
    pub(super) detour: Detour,
    pub(super) backing_until: Option<Stamp>,
    pub(super) stuck: usize,
    /// No new plan and no review before this time.
    pub(super) next_review: Stamp,
    /// No check before this time whether another frontier is better.
    next_choice: Stamp,
    /// How often it has changed to another frontier since it last reached one, or since its target
    /// vanished.
    changes_of_mind: u32,
    /// Time since when it stands at an exploration goal.
    pub(super) arrived: Option<Stamp>,
    /// The loop that is being closed.
    pub(super) closing: Option<Closing>,
    /// The gaps of loops for which a drive was made, map frame.
    pub(super) tried_gaps: Vec<Point2<f64>>,
    /// What stays unknown, reported once the robot is home again.
    pub(super) homeward: Option<Remaining>,
    pub(super) empty_scans: usize,
    pub(super) failed_plans: usize,
    last_scan: Option<Stamp>,
}

/// Centres of what stays unknown when an exploration ends, m.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Remaining {
    unreached: Vec<Point2<f64>>,
    fruitless: Vec<Point2<f64>>,
}

impl Remaining {
    fn finish(self, homecoming: Homecoming) -> Status {
        Status::Finished(Finish::Explored {
            unreached: self.unreached,
            fruitless: self.fruitless,
            homecoming,
        })
    }
}

/// Period of comparing the path and the frontier with the map, s.
const REVIEW_PERIOD: f64 = 0.5;
/// How much of the path ahead is compared, m.
const REVIEW_REACH: f64 = 4.0;
/// How long a robot without progress backs off, s.
const BACK_OFF: f64 = 1.0;
/// How often it backs off at most on the way to one goal.
const ATTEMPTS: usize = 3;
/// Scans without a frontier, a review period apart, before exploration ends.
const LAST_SCANS: usize = 3;
/// How long a frontier is scanned from its goal before it is given up, s: five revolutions of a
/// lidar.
const DWELL: f64 = 1.0;
/// Period of checking on the way whether another frontier is better, s.
const CHOICE_PERIOD: f64 = 2.0;
/// After this many changes of mind in a row, each further one halves the rate of checks: a robot
/// between two frontiers of equal promise went to and fro without end.
const CHANGES_OF_MIND: u32 = 4;
/// The longest time between two checks, in periods.
const MOST_PERIODS: u32 = 32;
/// The map begins where the robot did, whatever file it comes from.
const HOME: Point2<f64> = Point2::new(0.0, 0.0);
/// A robot this near need not go home, m.
const HOME_IS_NEAR: f64 = 0.2;
/// How often a plan is tried if it fails for a reason that may pass.
pub(super) const PLAN_ATTEMPTS: usize = 4;

/// How many periods pass until the next check, given how often it has changed its mind.
fn choice_periods(changes_of_mind: u32) -> u32 {
    let doubled = changes_of_mind.saturating_sub(CHANGES_OF_MIND);
    let periods = 1_u32.checked_shl(doubled);
    periods.map_or(MOST_PERIODS, |periods| periods.min(MOST_PERIODS))
}

impl Errand {
    fn drop_route(&mut self) {
        self.route = None;
        self.follower = None;
    }
}

impl Pilot {
    /// Makes sure there is a valid way; otherwise the status says why the robot stands.
    pub(super) fn has_way(&mut self, now: &Situation) -> bool {
        let is_due = now.stamp >= self.errand.next_review;
        if is_due {
            self.errand.next_review = now.stamp.plus(REVIEW_PERIOD);
            self.review(now);
            self.reconsider(now);
        }
        if self.errand.follower.is_some() {
            self.status = Status::Driving;
            return true;
        }
        if !is_due {
            return false;
        }
        match self.mode {
            Mode::Manual => false,
            Mode::GoTo(goal) => self.plan_to(goal, now),
            Mode::Explore => self.plan_exploration(now),
        }
    }

    /// Drops a way that the map no longer allows, or that leads to what is already seen.
    fn review(&mut self, now: &Situation) {
        let here = now.estimate.pose.position();
        if let (Some(follower), Some(route)) = (&self.errand.follower, &self.errand.route) {
            let ahead = follower.remaining(here);
            let keep = self.model.radius() + route.least_margin();
            // The outline is made smaller by the amount by which a cell may be thicker than the
            // wall in it, if the outline is large enough for that.
            let within = self.model.outline(-0.5 * now.grid.resolution());
            let is_blocked = match within.or_else(|| self.model.outline(0.0)) {
                Some(outline) if route.by == Planner::Outline => {
                    outline_is_blocked(now.grid, &ahead, &outline, REVIEW_REACH)
                }
                _ => is_blocked(now.grid, &ahead, keep, REVIEW_REACH),
            };
            if is_blocked || leads_outside(&self.fence, &ahead, self.model.radius()) {
                self.errand.drop_route();
            }
        }
        if self.goes_for_frontiers() {
            self.errand.explorer.pass(here);
            if self.errand.explorer.target_has_vanished(now.grid) {
                self.errand.drop_route();
                self.errand.arrived = None;
                self.errand.changes_of_mind = 0;
            }
        }
    }

    /// Other frontiers may have come in sight: checks whether the current target is still the first
    /// of the tour.
    fn reconsider(&mut self, now: &Situation) {
        let is_touring = self.goes_for_frontiers()
            && self.config.frontier.choice == FrontierChoice::ShortestTour;
        let Some(goal) = self.errand.explorer.target.as_ref().and_then(|t| t.goal) else {
            return;
        };
        if !is_touring || self.errand.follower.is_none() || now.stamp < self.errand.next_choice {
            return;
        }
        let period = CHOICE_PERIOD * f64::from(choice_periods(self.errand.changes_of_mind));
        self.errand.next_choice = now.stamp.plus(period);
        let Ok(found) = self.find_open_frontiers(now) else {
            return;
        };
        let first = found.iter().find(|f| self.errand.explorer.is_open(f));
        let is_other = |first: Point2<f64>| (first - goal).length() > SAME_GOAL;
        if first.and_then(|f| f.goal).is_some_and(is_other) {
            self.errand.changes_of_mind += 1;
            self.errand.explorer.target = None;
            self.errand.drop_route();
        }
    }

    /// Called when the path has been driven.
    pub(super) fn arrive(&mut self, now: &Situation) {
        self.errand.drop_route();
        (self.errand.stuck, self.errand.changes_of_mind) = (0, 0);
        self.errand.watch.reset();
        match self.mode {
            Mode::GoTo(goal) => {
                let off = (goal - now.estimate.pose.position()).length();
                self.status = Status::Finished(Finish::GoalReached { off });
            }
            Mode::Explore => {
                if let Some(remaining) = self.errand.homeward.take() {
                    self.status = remaining.finish(Homecoming::Home);
                    return;
                }
                self.status = Status::Scanning;
                if self.is_closing_loop() {
                    self.close_further();
                    return;
                }
                self.errand.arrived = Some(now.stamp);
                self.errand.next_review = now.stamp.plus(REVIEW_PERIOD);
            }
            Mode::Manual => {}
        }
    }

    /// Where the robot's centre may be: the margin to the border of the fence is kept.
    pub(super) fn within(&self, now: &Situation) -> Within {
        Within {
            fence: self.fence.clone(),
            keep: FenceConfig::default().keeps(&self.model, now.estimate),
        }
    }

    /// Plans to a point; `false` if the robot has to stand.
    pub(super) fn plan_to(&mut self, goal: Point2<f64>, now: &Situation) -> bool {
        if let Some(why) = self.is_outside(now) {
            self.give_up_errand(why);
            return false;
        }
        if self.fence.clearance(goal) < 0.0 {
            self.give_up_errand(Failure::GoalOutside(goal));
            return false;
        }
        match self.route_to(goal, Unknown::Free, now) {
            Ok(()) => true,
            Err(reason) => {
                // A robot pushed against a wall by an error of its pose may be free after the next
                // scans, and a way that is blocked by a false wall may open.
                let may_pass =
                    !matches!(reason, NoPath::GoalBlocked(_) | NoPath::NotOffered { .. });
                self.errand.failed_plans += 1;
                if !may_pass || self.errand.failed_plans >= PLAN_ATTEMPTS {
                    self.give_up_errand(Failure::NoPath(reason));
                }
                false
            }
        }
    }

    /// Ends the errand. An exploration that is complete but cannot return home still counts as
    /// complete.
    pub(super) fn give_up_errand(&mut self, why: Failure) {
        self.status = match self.errand.homeward.take() {
            Some(remaining) => remaining.finish(Homecoming::Failed(why)),
            None => Status::Failed(why),
        };
    }

    /// The reason if it does not plan at all.
    fn is_outside(&self, now: &Situation) -> Option<Failure> {
        let here = now.estimate.pose.position();
        (self.fence.clearance(here) < 0.0).then_some(Failure::Outside(here))
    }

    /// Chooses a frontier and plans to it; `false` if the robot has to stand.
    pub(super) fn plan_exploration(&mut self, now: &Situation) -> bool {
        if self.is_homeward() {
            return self.plan_to(HOME, now);
        }
        if let Some(why) = self.is_outside(now) {
            self.give_up_errand(why);
            return false;
        }
        self.status = Status::Scanning;
        if self.is_closing_loop() {
            return self.plan_closing(now);
        }
        if let Some(since) = self.errand.arrived {
            if now.stamp.since(since) < DWELL {
                return false;
            }
            // It was scanned from the best place, and is still there.
            self.errand.arrived = None;
            self.errand.explorer.give_up(Reason::NoGain);
        }
        // A target that is still there stays the target, so the robot does not dither between two
        // of equal promise.
        let kept = self.errand.explorer.target.as_ref().and_then(|t| t.goal);
        if let Some(goal) = kept
            && !self.errand.explorer.target_has_vanished(now.grid)
            && self.route_to(goal, Unknown::Blocked, now).is_ok()
        {
            return true;
        }
        let mut found = match self.find_open_frontiers(now) {
            Ok(found) => found,
            Err(reason) => {
                self.wriggle_free(reason, now);
                return false;
            }
        };
        let most_scans = self.config.scans_per_frontier;
        for _ in 0..PLAN_ATTEMPTS {
            let Some(goal) = self.errand.explorer.choose(found, most_scans) else {
                self.end_exploration(now);
                return false;
            };
            self.errand.empty_scans = 0;
            match self.route_to(goal, Unknown::Blocked, now) {
                Ok(()) => return true,
                Err(reason @ NoPath::StartBlocked { .. }) => {
                    // This says nothing about the frontier.
                    self.wriggle_free(reason, now);
                    return false;
                }
                Err(_) => self.errand.explorer.give_up(Reason::NoWay),
            }
            found = self.errand.explorer.frontiers.clone();
        }
        false
    }

    /// Backs off when the map says that the robot is enclosed where it stands: an error of pose or
    /// map that backing off and the next scans may correct.
    pub(super) fn wriggle_free(&mut self, reason: NoPath, now: &Situation) {
        self.errand.failed_plans += 1;
        self.errand.backing_until = Some(now.stamp.plus(BACK_OFF));
        if self.errand.failed_plans >= 2 * PLAN_ATTEMPTS {
            self.status = Status::Failed(Failure::NoPath(reason));
        }
    }

    /// # Errors    [`NoPath::StartBlocked`] if the robot is enclosed.
    fn find_open_frontiers(&self, now: &Situation) -> Result<Vec<Frontier>, NoPath> {
        let here = now.estimate.pose.position();
        let keep = self.model.radius() + self.config.route.narrowest();
        let Some(rect) = rect_around(now.grid, &[here], 2, i32::MAX) else {
            return Ok(vec![]);
        };
        let space = GridSpace::within(now.grid, rect, keep, Unknown::Blocked, &self.within(now));
        let reach = keep + ESCAPE_REACH;
        // Before the first scan everything is unknown; that does not mean a wall around the robot.
        let is_blank = !space.states().contains(&CellState::Free);
        let Some(start) = space.escape(here, reach) else {
            return match is_blank {
                true => Ok(vec![]),
                false => Err(NoPath::StartBlocked(here)),
            };
        };
        let wave = Wavefront::new(&space, start);
        let mut found = find_frontiers(&space, &wave, &self.config.frontier);
        // What lies beyond the fence stays unknown, which is no failure.
        found.retain(|frontier| self.fence.clearance(frontier.centre) >= 0.0);
        if self.config.frontier.choice == FrontierChoice::ShortestTour {
            let explorer = &self.errand.explorer;
            let heading_for = explorer.target.as_ref().and_then(|target| target.goal);
            order_by_tour(&mut found, &space, &wave, heading_for, |frontier| {
                explorer.is_open(frontier)
            });
        }
        Ok(found)
    }

    /// Exploration is over when several scans in a row show nothing new.
    fn end_exploration(&mut self, now: &Situation) {
        let scan = now.points.map(|points| points.stamp);
        let is_news = scan.is_some() && scan != self.errand.last_scan;
        self.errand.last_scan = scan;
        self.errand.empty_scans += usize::from(is_news);
        if self.errand.empty_scans >= LAST_SCANS && !self.begin_closing(now) {
            let explorer = &self.errand.explorer;
            let remaining = Remaining {
                unreached: explorer.remaining(Reason::NoWay),
                fruitless: explorer.remaining(Reason::NoGain),
            };
            let away = now.estimate.pose.position() - HOME;
            if !self.config.return_home {
                self.status = remaining.finish(Homecoming::NotAsked);
            } else if away.length() > HOME_IS_NEAR {
                self.errand.homeward = Some(remaining);
                (self.errand.failed_plans, self.errand.stuck) = (0, 0);
            } else {
                self.status = remaining.finish(Homecoming::Home);
            }
        }
    }

    /// Whether a goal was given to a robot that is not a disc and scans while driving.
    pub(super) fn goes_by_outline(&self, now: &Situation) -> bool {
        let is_disc = self.model.shape == BodyShape::Disc;
        matches!(self.mode, Mode::GoTo(_)) && !is_disc && !now.scans_on_command
    }

    pub(super) fn route_to(
        &mut self,
        goal: Point2<f64>,
        unknown: Unknown,
        now: &Situation,
    ) -> Result<(), NoPath> {
        let start = now.estimate.pose.position();
        let mut config = self.config.route.clone();
        config.unknown = unknown;
        config.within = self.within(now);
        // The middle margin holds the robot off walls even when the pose errs by two standard
        // deviations.
        let variance = now.estimate.cov[(0, 0)]
            .max(now.estimate.cov[(1, 1)])
            .max(0.0);
        if let [widest, middle, _] = config.margins.as_mut_slice() {
            *middle = (*middle + 2.0 * variance.sqrt()).min(*widest);
        }
        self.errand.goal = Some(goal);
        let radius = self.model.radius();
        let by_outline =
            || plan_outline_route(now.grid, &now.estimate.pose, goal, &self.model, &config);
        let is_outline = self.goes_by_outline(now);
        // If the disc does not fit through a door, its way would begin with a turn that the outline
        // cannot make.
        let first = (is_outline && !disc_fits(now.grid, start, radius)).then(by_outline);
        let planned = match first {
            Some(Ok(route)) => Ok(route),
            first => match plan_route(now.grid, start, goal, radius, &config, &mut self.rng) {
                Err(_) if is_outline => first.unwrap_or_else(by_outline),
                of_disc => of_disc,
            },
        };
        match planned {
            Ok(route) => {
                // The cycle drives straight legs.
                let is_rounded = !route.pieces.is_empty() && !now.scans_on_command;
                self.errand.follower = Some(match is_rounded {
                    true => Follower::rounded(&route.pieces),
                    false => Follower::new(&route.path),
                });
                self.errand.tree.clone_from(&route.tree);
                self.errand.route = Some(route);
                self.errand.failed_plans = 0;
                self.errand.watch.reset();
                self.status = Status::Driving;
                Ok(())
            }
            Err(failure) => {
                self.errand.drop_route();
                self.errand.tree = failure.tree;
                Err(failure.reason)
            }
        }
    }

    /// The robot does not move: backs off, or gives the goal up.
    pub(super) fn get_unstuck(&mut self, now: &Situation) {
        self.errand.watch.reset();
        self.errand.stuck += 1;
        self.errand.drop_route();
        if self.errand.stuck <= ATTEMPTS {
            self.errand.backing_until = Some(now.stamp.plus(BACK_OFF));
            return;
        }
        let attempts = std::mem::take(&mut self.errand.stuck) - 1;
        if self.goes_for_frontiers() {
            self.errand.explorer.give_up(Reason::NoWay);
        } else if self.is_closing_loop() {
            self.end_closing();
        } else {
            let at = now.estimate.pose.position();
            self.give_up_errand(Failure::Stuck { at, attempts });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A robot that never reaches a frontier keeps to one for a minute in the end, which is time
    /// enough to reach it.
    #[test]
    fn who_goes_to_and_fro_makes_up_its_mind() {
        assert_eq!([0, 3, 4].map(choice_periods), [1; 3]);
        assert_eq!([5, 6, 7, 8].map(choice_periods), [2, 4, 8, 16]);
        for changes in [9, 35, 36, 40, u32::MAX] {
            assert_eq!(choice_periods(changes), MOST_PERIODS);
        }
        assert!(CHOICE_PERIOD * f64::from(MOST_PERIODS) > 60.0);
    }
}
