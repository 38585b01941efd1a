//! Where a scan lies in the running submap: several motions are tried, and the one that fits and is
//! plausible is taken.
//!
//! In: the scan's surfaces, the motion by odometry, the time. Out: [`Tracked`].
//!
//! 1. The scan is matched from where the likeliest motion leads. If it surely lies there, that is
//!    all.
//! 2. Otherwise it is matched from the other motions too, and if none fits, a window is searched.
//! 3. Each result is weighed against the first: how much more agrees with the submap, how much less
//!    contradicts it, and how far it is from odometry. Odometry that was rarely wrong is believed
//!    longer.
//! 4. If other poses fit nearly as well, the pose is uncertain. The scan does not belong to the
//!    running submap if it may equally well lie elsewhere; if it contradicts the submap even at the
//!    best pose; if the submap says nothing about it although the robot was there just now; or if
//!    the robot comes from an unknown place ([`super::adrift`]). Then a new submap is begun, joined
//!    as loosely as the pose is known.

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
    /// The match; `None` if the scan gave no reliable information.
    pub(super) found: Option<Registration>,
    pub(super) agreement: Agreement,
    /// Whether the scan surely lies there.
    pub(super) is_sure: bool,
    /// Whether odometry counted the motion.
    pub(super) is_counted: bool,
    /// Whether the scan does not belong to the running submap.
    pub(super) is_loose: bool,
    /// Whether the match confirms the likeliest motion.
    pub(super) was_right: bool,
    /// The error of odometry during the scan, in the running submap, if the scan took time.
    pub(super) error: MotionError,
    /// Whether people walked along, so that the previous scans may be off by as much.
    pub(super) has_companions: bool,
}

impl Tracked {
    /// Whether a part of the scan contradicts the submap.
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
    /// What the submap says about each point.
    said: Vec<Says>,
    agreement: Agreement,
    /// The penalty of the motion, as a fraction of the scan's points.
    cost: f64,
    /// How much better it is than the first, as a fraction of the scan's points.
    score: f64,
}

/// If at least this part of a scan agrees with the submap, ...
const SURE_OVERLAP: f64 = 0.7;
/// ... and this part of the points that the submap says anything about, it surely lies where it was
/// matched.
pub(super) const SURE_PART: f64 = 0.85;
/// A pose other than the expected one must put this part of the scan on the submap.
pub(super) const OTHER_OVERLAP: f64 = 0.3;
/// Motions nearer to each other than this, m and rad, count as one: the match converges from there.
const SAME_SHIFT: f64 = 0.06;
const SAME_TURN: f64 = 0.06;
/// The weight of a point that contradicts, relative to one that agrees.
pub(super) const CONTRADICTION: f64 = 2.0;
/// In a scan of fewer points than this, agreement counts as a part of this number: a few points
/// agree somewhere by chance.
pub(super) const FULL_SCAN: f64 = 100.0;
/// The penalty of an unlikely motion for each e-fold of its squared distance, as a fraction of the
/// points.
const IMPLAUSIBLE: f64 = 0.02;
/// A motion that is better by this fraction of the points is e times as likely.
pub(super) const LIKELIER: f64 = 0.05;
/// A scan that may equally well lie this far away, m and rad, does not belong to the submap.
const LOOSE_SHIFT: f64 = 0.15;
const LOOSE_TURN: f64 = 0.1;
/// If less than this part of the points that the submap says anything about agrees, the scan
/// contradicts it.
const VERIFIED_PART: f64 = 0.5;
/// If the submap says anything about less than this part of a scan, it says nothing.
const SPOKEN_OF: f64 = 0.1;
/// If the first motion was contradicted, it may be wrong by this, m, plus this part of the
/// distance, and by this, rad.
const MISLED_SHIFT: f64 = 0.2;
const MISLED_PART: f64 = 0.2;
const MISLED_TURN: f64 = 0.2;
/// If the submap says nothing about a scan at a place where the robot was just now, the pose may be
/// off by this, m and rad. It may be off by more, but no odometry tells.
const CARRIED_SHIFT: f64 = 1.0;
const CARRIED_TURN: f64 = 0.5;
/// Within these multiples of the keyframe distance and turn, a scan is close to a keyframe.
const AT_KEYFRAME: [f64; 2] = [1.0, 1.0];
/// A motion farther from the match than this, m and rad, was wrong.
const RIGHT_SHIFT: f64 = 0.3;
const RIGHT_TURN: f64 = 0.2;

impl ScanMatcher {
    /// Places the scan, and removes people who walk along from it. `moved` is the believed odometry
    /// since the last scan.
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

    /// Whether the submap should say something about a scan after this motion, because a keyframe
    /// was drawn close by. If it does not, the robot was carried off, or the recording continues
    /// elsewhere.
    fn should_know(&self, seen: &Seen, step: &Pose2, counted: bool) -> bool {
        let is_close = !counted || self.is_within(step, CLOSE);
        is_close && self.is_keyframe_within(AT_KEYFRAME) && self.has_much_to_show(seen)
    }

    /// Whether a scan is large enough that the submap should say something about it, if it knows
    /// the place.
    pub(super) fn has_much_to_show(&self, seen: &Seen) -> bool {
        seen.surfaces.len() as f64 >= 0.5 * FULL_SCAN && !self.gathering.is_at_work()
    }

    /// The scan matched from the first motion and, if it does not surely lie there, from the others
    /// and by a search. The first result stays first, however good it is.
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

    /// Points that took time to see, matched from `start` while the error of `guess` is estimated.
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

    /// Rates a match. Odometry that `counted` the motion is believed before all guesses.
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

    /// The best pose within a window that a fast robot cannot leave, matched.
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

/// Whether a scan with this agreement surely lies where it was matched.
pub(super) fn is_sure(agreement: &Agreement) -> bool {
    agreement.overlap() >= SURE_OVERLAP && agreement.part() >= SURE_PART
}

/// Whether almost nothing is said about a scan with this agreement.
pub(super) fn is_quiet(agreement: &Agreement) -> bool {
    agreement.spoken_of() < SPOKEN_OF
}

/// Whether a motion that led to `pose` was right, if the match is `found`.
fn is_right(pose: &Pose2, found: &Pose2) -> bool {
    let off = found.minus(pose);
    off.xy().length() < RIGHT_SHIFT && off.z.abs() < RIGHT_TURN
}

/// Scores all results relative to the first.
fn compare(surfaces: &[OrientedPoint], tried: &mut [Tried]) {
    let Some((first, others)) = tried.split_first_mut() else {
        return;
    };
    for other in others {
        let gain = gain(surfaces, first, other) / (surfaces.len() as f64).max(FULL_SCAN);
        other.score = gain - (other.cost - first.cost);
    }
}

/// How many more points agree with the submap after one motion than after another. A point
/// distinguishes two poses only if it would leave its surface on the way from one to the other: the
/// walls of a corridor, as far as they were seen already, agree wherever along it the robot is.
pub(super) fn gain(surfaces: &[OrientedPoint], before: &Tried, after: &Tried) -> f64 {
    let at = before.found.estimate.pose;
    let way = after.found.estimate.pose.minus(&at);
    let shift = way.xy().length();
    let along = at.inverse().rotate(way.xy() / shift.max(1e-9));
    let is_turn = way.z.abs() > 2.0 * SAME_TURN || shift < SAME_SHIFT;
    let leaves = |point: &OrientedPoint| match is_turn {
        true => 1.0,
        // Walls at 12° to the motion count nothing, those at 30° fully.
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

/// The first result with the highest score.
fn best_of(tried: &[Tried]) -> &Tried {
    let mut best = &tried[0];
    for other in &tried[1..] {
        if other.score > best.score {
            best = other;
        }
    }
    best
}

/// The uncertainty of the pose because other motions fit nearly as well: the spread of all results
/// about the best.
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
