//! Where a scan lies in the running submap: several motions are tried, and the one that fits and is
//! plausible is taken.
//!
//! In: the scan's surfaces, what odometry says of the motion, the time. Out: [`Tracked`].
//!
//! 1. The scan is matched from where the likeliest motion leads. Where it surely lies there, that
//!    is all.
//! 2. Else it is matched from the other motions too, and where none fits, a window is searched.
//! 3. Each is weighed against the first: what more agrees with the submap, what less contradicts
//!    it, and how far it is from what odometry says. Odometry that was seldom wrong is believed
//!    longer.
//! 4. What fits nearly as well elsewhere makes the pose doubtful. Where it may as well lie
//!    elsewhere, or contradicts the submap at the best of all poses, or the submap says nothing of
//!    it although the robot was there just now, or it comes from who knows where
//!    ([`super::adrift`]), the scan does not belong to the running submap: a new one is begun,
//!    joined as loosely as the pose is known.

use nalgebra::{Matrix3, Point2, Vector3};

use super::super::agreement::{Agreement, Says, says};
use super::super::submap::Doubt;
use super::ScanMatcher;
use super::guesses::Guess;
use super::keyframes::CLOSE;
use super::odometry_watch::Believed;
use super::seen::Seen;
use crate::geom::{Length, Pose2, PoseEstimate, pose_cov};
use crate::points::OrientedPoint;
use crate::registration::{
    MotionError, Registration, Rolling, SearchWindow, Verdict, register, register_rolling,
    search_and_match,
};
use crate::robot::Stamp;

/// Where a scan lies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tracked {
    pub(super) estimate: PoseEstimate,
    /// The match; `None` where the scan said nothing that can be believed.
    pub(super) found: Option<Registration>,
    pub(super) agreement: Agreement,
    /// Whether it surely lies there.
    pub(super) is_sure: bool,
    /// Whether odometry counted the motion.
    pub(super) is_counted: bool,
    /// Whether it does not belong to the running submap.
    pub(super) is_loose: bool,
    /// Whether the motion that was believed first is that of the match.
    pub(super) was_right: bool,
    /// The error of odometry on the way, in the running submap, where what was seen took a while.
    pub(super) error: MotionError,
    /// Whether somebody walked along, so that the scans before may be as far off.
    pub(super) has_companions: bool,
}

impl Tracked {
    /// Whether some of the scan lies where the submap has nothing.
    pub(super) fn contradicts(&self) -> bool {
        self.agreement.part() < SURE_PART
    }
}

/// A motion that was tried.
#[derive(Clone, Debug)]
pub(super) struct Tried {
    pub(super) found: Registration,
    /// See [`Tracked::error`].
    error: MotionError,
    /// What the submap says of each point.
    said: Vec<Says>,
    agreement: Agreement,
    /// What speaks against the motion, in parts of the scan's points.
    cost: f64,
    /// How much better it is than the first, in parts of the scan's points.
    score: f64,
}

/// A scan of which this part agrees with the submap, ...
const SURE_OVERLAP: f64 = 0.7;
/// ... and of all that is said of it this part, surely lies where it was matched.
pub(super) const SURE_PART: f64 = 0.85;
/// A pose that nobody believed first must put this part of the scan on the submap.
pub(super) const OTHER_OVERLAP: f64 = 0.3;
/// Motions nearer to each other than this, m and rad, are one: the match pulls in from there.
const SAME_SHIFT: f64 = 0.06;
const SAME_TURN: f64 = 0.06;
/// How a point that contradicts counts beside one that agrees.
pub(super) const CONTRADICTION: f64 = 2.0;
/// Of a scan of fewer points than this, what agrees counts as a part of this number: a few points
/// agree somewhere by chance.
pub(super) const FULL_SCAN: f64 = 100.0;
/// What an unlikely motion costs, in parts of the points, for each e-fold of its squared distance.
const IMPLAUSIBLE: f64 = 0.02;
/// Motions of which one is this much better, in parts of the points, are e times as likely.
pub(super) const LIKELIER: f64 = 0.05;
/// A scan that may as well lie this far away, m and rad, does not belong to the submap.
const LOOSE_SHIFT: f64 = 0.15;
const LOOSE_TURN: f64 = 0.1;
/// A scan of which less than this part agrees, of all that is said of it, contradicts the submap.
const VERIFIED_PART: f64 = 0.5;
/// Where less than this part of it is spoken of, nothing is said.
const SPOKEN_OF: f64 = 0.1;
/// Where the first motion was contradicted, it may be wrong by this, m, by this part of the way,
/// and by this, rad.
const MISLED_SHIFT: f64 = 0.2;
const MISLED_PART: f64 = 0.2;
const MISLED_TURN: f64 = 0.2;
/// A robot whose scan says nothing of a place where it was just now may be as far off as this, m
/// and rad. It may be farther, but no odometry tells.
const CARRIED_SHIFT: f64 = 1.0;
const CARRIED_TURN: f64 = 0.5;
/// So many distances and turns of keyframes are close to one.
const AT_KEYFRAME: [f64; 2] = [1.0, 1.0];
/// Farther from the match than this, m and rad, a motion was wrong.
const RIGHT_SHIFT: f64 = 0.3;
const RIGHT_TURN: f64 = 0.2;

impl ScanMatcher {
    /// Places the scan, and takes out of it who walks along. `moved` is what is believed of
    /// odometry since the last scan.
    pub(super) fn track(&self, seen: &mut Seen, moved: &Believed, stamp: Stamp) -> Tracked {
        let guesses = self.guesses(moved, stamp);
        let lead = guesses[0];
        let counted = moved.counted().is_some();
        let expected = lead.pose.minus(&(self.local.pose * seen.motion));
        let expected = MotionError::even(&expected);
        let predicted = self.predicted(moved, &lead);
        if self.running.surfels().is_empty() {
            return Tracked {
                estimate: predicted,
                found: None,
                agreement: Agreement::default(),
                is_sure: false,
                is_counted: counted,
                is_loose: false,
                was_right: true,
                error: expected,
                has_companions: false,
            };
        }
        let mut tried = self.tried(seen, &guesses, counted, stamp);
        compare(&seen.surfaces, &mut tried);
        let companions = self.without_companions(seen, best_of(&tried), &guesses, moved);
        let has_companions = companions.is_some();
        if let Some((rest, match_of_rest)) = companions {
            *seen = rest;
            tried = vec![match_of_rest];
        }
        let best = best_of(&tried);
        let was_right = is_right(&lead.pose, &best.found.estimate.pose);
        let (agreement, is_sure) = (best.agreement, best.is_sure());
        let matched = !matches!(best.found.verdict, Verdict::TooFewPoints { .. });
        let estimate = match matched {
            true => self.corrected(&best.found, &predicted),
            false => predicted,
        };
        let tracked = Tracked {
            estimate,
            found: matched.then_some(best.found),
            agreement,
            is_sure,
            is_counted: counted,
            is_loose: false,
            was_right,
            error: if matched { best.error } else { expected },
            has_companions,
        };
        if is_sure {
            return tracked;
        }
        let spread = spread(&tried, best);
        let step = self.local.pose.delta_to(&lead.pose);
        let is_quiet = is_quiet(&agreement);
        let is_elsewhere = is_quiet && self.should_know(seen, &step, counted);
        let adrift = self.adrift(seen, &lead, &agreement, stamp);
        if is_elsewhere || adrift.is_some() || (agreement.part() < VERIFIED_PART && !is_quiet) {
            let misled = if let Some(unseen) = adrift {
                unseen
            } else if is_elsewhere {
                pose_cov(CARRIED_SHIFT, CARRIED_TURN)
            } else {
                let way = step.position().coords.length();
                pose_cov(MISLED_SHIFT + MISLED_PART * way, MISLED_TURN)
            };
            let cov = estimate.cov + spread + predicted.cov + misled;
            return Tracked {
                estimate: PoseEstimate {
                    pose: predicted.pose,
                    cov,
                },
                found: None,
                is_loose: true,
                error: expected,
                ..tracked
            };
        }
        let apart = Doubt::of(&spread);
        Tracked {
            estimate: PoseEstimate {
                cov: estimate.cov + spread,
                ..estimate
            },
            is_loose: apart.shift > LOOSE_SHIFT
                || apart.turn > LOOSE_TURN
                || (!counted && agreement.overlap() < OTHER_OVERLAP),
            ..tracked
        }
    }

    /// Whether the submap would have to speak of a scan after this motion: a keyframe was drawn
    /// close by. Where it does not, the robot was carried off, or the recording goes on elsewhere.
    fn should_know(&self, seen: &Seen, step: &Pose2, counted: bool) -> bool {
        let is_close = !counted || self.is_within(step, CLOSE);
        is_close && self.is_keyframe_within(AT_KEYFRAME) && self.has_much_to_show(seen)
    }

    /// Whether a scan is large enough that the submap should speak of it, if it knows the place.
    pub(super) fn has_much_to_show(&self, seen: &Seen) -> bool {
        seen.surfaces.len() as f64 >= 0.5 * FULL_SCAN && !self.gathering.is_at_work()
    }

    /// The scan matched from the first motion and, where it does not surely lie there, from the
    /// others and by a search. The first one stays the first, whatever it is worth.
    fn tried(&self, seen: &Seen, guesses: &[Guess], counted: bool, stamp: Stamp) -> Vec<Tried> {
        let matched = |guess: &Guess| {
            if seen.is_rolling() {
                return self.rolled(seen, &guess.pose, guess, guesses, counted);
            }
            let prior = self.prior_of(guess);
            let matching = &self.config.matching;
            let found = register(&seen.surfaces, &self.running, &prior.pose, &prior, matching);
            self.weighed(&seen.surfaces, found, guesses, counted)
        };
        let lead = guesses[0];
        let first = matched(&lead);
        if first.is_sure() {
            return vec![first];
        }
        let mut starts = vec![lead.pose];
        let mut others = vec![];
        for guess in &guesses[1..] {
            let is_same = |start: &Pose2| {
                let way = start.delta_to(&guess.pose);
                way.position().coords.length() < SAME_SHIFT && way.heading().abs() < SAME_TURN
            };
            if !starts.iter().any(is_same) {
                starts.push(guess.pose);
                others.push(matched(guess));
            }
        }
        let overlap = |tried: &Tried| tried.agreement.overlap();
        let largest = others.iter().map(overlap).fold(overlap(&first), f64::max);
        if largest < self.config.search_below
            && let Some(found) = self.search_around(&seen.surfaces, &lead, stamp)
        {
            others.push(match seen.is_rolling() {
                true => self.rolled(seen, &found.estimate.pose, &lead, guesses, counted),
                false => self.weighed(&seen.surfaces, found, guesses, counted),
            });
        }
        others.retain(|other| {
            let says_something = !matches!(other.found.verdict, Verdict::TooFewPoints { .. });
            says_something && overlap(other) >= OTHER_OVERLAP
        });
        others.insert(0, first);
        others
    }

    /// What took a while, matched from `start` while the error of `guess` is found.
    fn rolled(
        &self,
        seen: &Seen,
        start: &Pose2,
        guess: &Guess,
        guesses: &[Guess],
        counted: bool,
    ) -> Tried {
        let by_odometry = self.local.pose * seen.motion;
        let prior = self.rolling_prior(guess, &by_odometry);
        let (target, matching) = (&self.running, &self.config.matching);
        let Rolling { found, error } =
            register_rolling(&seen.parts(), target, start, &prior, matching);
        let surfaces = seen.surfaces_after(&found.estimate.pose, &error);
        Tried {
            error,
            ..self.weighed(&surfaces, found, guesses, counted)
        }
    }

    /// What a match is worth. Odometry that `counted` the motion is believed before all guesses.
    pub(super) fn weighed(
        &self,
        surfaces: &[OrientedPoint],
        found: Registration,
        guesses: &[Guess],
        counted: bool,
    ) -> Tried {
        let pose = found.estimate.pose;
        let of = |point| says(point, &pose, &self.running, &self.running_free);
        let said: Vec<Says> = surfaces.iter().map(of).collect();
        let against = |guess: &Guess| {
            let off = pose.minus(&guess.pose);
            let squared = off.dot(&(self.prior_of(guess).information * off));
            IMPLAUSIBLE * libm::log1p(squared / 3.0)
        };
        let cost = if counted {
            let lead = &guesses[0];
            against(lead)
                + match is_right(&lead.pose, &pose) {
                    true => 0.0,
                    false => self.motion.model.mistrust(),
                }
        } else {
            let costs = guesses.iter().map(|guess| guess.penalty + against(guess));
            costs.fold(f64::INFINITY, f64::min)
        };
        Tried {
            found,
            agreement: Agreement::sum(said.iter().copied()),
            said,
            cost,
            score: 0.0,
            error: MotionError::even(&Vector3::zeros()),
        }
    }

    /// The best pose in a window that a fast robot does not leave, matched.
    fn search_around(
        &self,
        surfaces: &[OrientedPoint],
        lead: &Guess,
        stamp: Stamp,
    ) -> Option<Registration> {
        let [way, turn] = Self::fast(self.seconds_until(stamp).min(1.0));
        let least = &self.config.least_window;
        let window = SearchWindow {
            shift: least.shift + way,
            turn: least.turn + turn,
        };
        let prior = self.prior_of(lead);
        let (target, pivot) = (&self.running, Point2::origin());
        let (search, matching) = (&self.config.search, &self.config.matching);
        search_and_match(surfaces, pivot, target, &prior, &window, search, matching)
    }
}

impl Tried {
    fn is_sure(&self) -> bool {
        is_sure(&self.agreement)
    }
}

/// Whether a scan that agrees so with what it was matched to surely lies there.
pub(super) fn is_sure(agreement: &Agreement) -> bool {
    agreement.overlap() >= SURE_OVERLAP && agreement.part() >= SURE_PART
}

/// Whether next to nothing is said of a scan that agrees so.
pub(super) fn is_quiet(agreement: &Agreement) -> bool {
    agreement.spoken_of() < SPOKEN_OF
}

/// Whether a motion that led to `pose` was right, where the match is `found`.
fn is_right(pose: &Pose2, found: &Pose2) -> bool {
    let off = found.minus(pose);
    off.xy().length() < RIGHT_SHIFT && off.z.abs() < RIGHT_TURN
}

/// Scores all that were tried beside the first of them.
fn compare(surfaces: &[OrientedPoint], tried: &mut [Tried]) {
    let Some((first, others)) = tried.split_first_mut() else {
        return;
    };
    for other in others {
        let gain = gain(surfaces, first, other) / (surfaces.len() as f64).max(FULL_SCAN);
        other.score = gain - (other.cost - first.cost);
    }
}

/// How many points more agree with the submap after a motion than after another. A point says which
/// of two poses is better only if it would leave its surface on the way from one to the other: the
/// walls of a corridor agree wherever along it the robot is, as far as they were seen already.
pub(super) fn gain(surfaces: &[OrientedPoint], before: &Tried, after: &Tried) -> f64 {
    let at = before.found.estimate.pose;
    let way = after.found.estimate.pose.minus(&at);
    let shift = way.xy().length();
    let along = at.inverse().rotate(way.xy() / shift.max(1e-9));
    let is_turn = way.z.abs() > 2.0 * SAME_TURN || shift < SAME_SHIFT;
    let leaves = |point: &OrientedPoint| match is_turn {
        true => 1.0,
        // From walls at 12° to the way nothing is left, from those at 30° all.
        false => ((point.normal.dot(&along).abs() - 0.2) / 0.3).clamp(0.0, 1.0),
    };
    let value = |says: &Says| match says {
        Says::Agrees => 1.0,
        Says::Contradicts => -CONTRADICTION,
        Says::Nothing => 0.0,
    };
    let said = before.said.iter().zip(&after.said);
    surfaces
        .iter()
        .zip(said)
        .map(|(point, (before, after))| leaves(point) * (value(after) - value(before)))
        .sum()
}

/// The first of those with the highest score.
fn best_of(tried: &[Tried]) -> &Tried {
    let mut best = &tried[0];
    for other in &tried[1..] {
        if other.score > best.score {
            best = other;
        }
    }
    best
}

/// What is not known of the pose since other motions fit nearly as well: the spread of all that
/// were tried about the best.
fn spread(tried: &[Tried], best: &Tried) -> Matrix3<f64> {
    let (mut sum, mut total) = (Matrix3::zeros(), 0.0);
    for other in tried {
        let weight = libm::exp((other.score - best.score) / LIKELIER);
        let off = other.found.estimate.pose.minus(&best.found.estimate.pose);
        sum += off * off.transpose() * weight;
        total += weight;
    }
    sum / total
}
