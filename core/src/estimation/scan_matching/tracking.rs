//! Where a scan lies in the running submap: several motions are tried, and the one that fits and is
//! plausible is taken.
//!
//! In: the scan's surfaces, what odometry says of the motion, the time since the last scan. Out:
//! the pose in the submap, and whether it is verified.
//!
//! 1. The scan is matched from where odometry puts it; without odometry, from where the last
//!    speed leads.
//! 2. Where that does not fit surely, the scan is matched from other motions too: the robot stood
//!    still; it went on as before; the odometry of the last few scans came late, so that earlier
//!    matches hold a part of it already; the same with a fan of headings.
//! 3. Where none fits, a window around them is searched.
//! 4. The choice weighs how much agrees with the submap, how much contradicts it, and how likely
//!    the motion is. A motion that nobody proposed must explain much more.
//! 5. A scan that contradicts the map at the best of all poses is not verified: it is not drawn.

use nalgebra::{Matrix3, Point2};

use super::super::agreement::{Agreement, Says, says};
use super::ScanMatcher;
use super::super::knob;
use crate::geom::{Pose2, PoseEstimate, pose_cov};
use crate::points::OrientedPoint;
use crate::registration::{
    Prior, Registration, SearchWindow, Verdict, register, search_and_match,
};
use crate::robot::{Odometry, Stamp};

/// A motion that may have happened.
#[derive(Clone, Copy, Debug)]
struct Hypothesis {
    /// Where it leads, in the running submap.
    pose: Pose2,
    /// What is not known of the motion itself.
    cov: Matrix3<f64>,
    /// What speaks against it beforehand, in parts of the scan's points.
    penalty: f64,
}

/// A hypothesis that was matched.
#[derive(Clone, Debug)]
struct Tried {
    found: Registration,
    agreement: Agreement,
    /// Of each point.
    said: Vec<Says>,
    /// What speaks against the motion, in parts of the scan's points.
    cost: f64,
    /// What speaks for it, less than for the lead where negative, in parts of the scan's points.
    score: f64,
}

/// An earlier scan, as far as late odometry needs it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Past {
    pub(super) stamp: Stamp,
    pub(super) submap_from_robot: Pose2,
    /// Odometry, summed since the beginning.
    pub(super) odom_from_robot: Pose2,
}

/// Where a scan lies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tracked {
    pub(super) estimate: PoseEstimate,
    pub(super) found: Option<Registration>,
    pub(super) agreement: Agreement,
    /// Whether it may be drawn where it was put.
    pub(super) is_verified: bool,
    /// Whether it may as well lie elsewhere: the running submap must not be gone on with.
    pub(super) is_loose: bool,
    pub(super) is_sure: bool,
    /// Whether the motion that was believed first is that of the match.
    pub(super) was_right: bool,
}

/// Earlier scans that late odometry may belong to.
pub(super) const PASTS: usize = 8;
/// A scan of which this part agrees is surely where it was matched.
const SURE_OVERLAP: f64 = 0.7;
/// ... where of all that says something this part agrees.
const SURE_PART: f64 = 0.85;
/// Hypotheses nearer to each other than this are one: the match pulls in from there.
const SAME_SHIFT: f64 = 0.06;
const SAME_TURN: f64 = 0.06;
/// How a point that contradicts counts beside one that agrees.
const CONTRADICTION: f64 = 2.0;
/// What an unlikely motion costs, in parts of the points, for each e-fold of its squared distance.
const IMPLAUSIBLE: f64 = 0.06;
/// Speeds that no robot of a building exceeds, m/s and rad/s.
const MOST_SPEED: f64 = 1.5;
const MOST_TURN_RATE: f64 = 1.5;
/// Changes of speed that are usual, m/s² and rad/s².
const ACCELERATION: f64 = 1.0;
const TURN_ACCELERATION: f64 = 3.0;

impl ScanMatcher {
    /// Places the scan. `moved` is what odometry says since the last scan, if there is any.
    pub(super) fn track(
        &self,
        surfaces: &[OrientedPoint],
        moved: Option<&Odometry>,
        stamp: Stamp,
    ) -> Tracked {
        let hypotheses = self.hypotheses(moved, stamp);
        let lead = hypotheses[0];
        let predicted = self.predicted(moved, &lead);
        if self.running.surfels().is_empty() {
            return Tracked {
                estimate: predicted,
                found: None,
                agreement: Agreement::default(),
                is_verified: true,
                is_loose: false,
                is_sure: false,
                was_right: true,
            };
        }
        let mut tried = vec![self.try_one(surfaces, &lead, &hypotheses)];
        let is_sure =
            |t: &Tried| t.agreement.overlap() >= SURE_OVERLAP && t.agreement.part() >= SURE_PART;
        if !is_sure(&tried[0]) {
            let mut starts: Vec<Pose2> = vec![lead.pose];
            for hypothesis in &hypotheses[1..] {
                let same = |t: &Pose2| {
                    let d = t.delta_to(&hypothesis.pose);
                    d.position().coords.norm() < SAME_SHIFT && d.heading().abs() < SAME_TURN
                };
                if starts.iter().any(same) {
                    continue;
                }
                starts.push(hypothesis.pose);
                tried.push(self.try_one(surfaces, hypothesis, &hypotheses));
            }
        }
        let overlap = |t: &Tried| t.agreement.overlap();
        if tried.iter().map(overlap).fold(0.0, f64::max) < self.config.locate.lost_below
            && let Some(found) = self.search_around(surfaces, &lead, stamp)
        {
            tried.push(self.weighed(surfaces, found, &hypotheses));
        }
        let (lead_tried, others) = tried.split_at(1);
        let fits = |t: &&Tried| !matches!(t.found.verdict, Verdict::TooFewPoints { .. });
        let tried: Vec<Tried> = lead_tried.iter().chain(others.iter().filter(fits)).cloned().collect();
        let mut tried = tried;
        compare(surfaces, &mut tried);
        let best = best_of(&tried);
        let off = best.found.estimate.pose.minus(&lead.pose);
        let was_right = off.xy().norm() < 0.3 && off.z.abs() < 0.2;
        let matched = !matches!(best.found.verdict, Verdict::TooFewPoints { .. });
        let mut estimate = if matched {
            self.corrected(&best.found, &predicted)
        } else {
            predicted
        };
        let (mut is_verified, mut is_loose) = (true, false);
        if !is_sure(&best) {
            let spread = spread(&tried, &best);
            estimate.cov += spread;
            let shift = (spread[(0, 0)] + spread[(1, 1)]).sqrt();
            let said = best.agreement.agree + best.agreement.contradict;
            is_verified = best.agreement.part() >= knob("vpart", 0.5) || said * 10 < best.agreement.total;
            is_loose = !is_verified
                || shift > knob("lshift", 0.15)
                || spread[(2, 2)].sqrt() > knob("lturn", 0.1)
                || (moved.is_none() && overlap(&best) < knob("lover", 0.3));
        }
        if knob("trace", 0.0) > 0.0 { eprintln!("T {:.2} n {} ov {:.2} part {:.2} tried {} {:?} res {:.4} lead {:.3?} match {:.3?}", stamp.seconds(), surfaces.len(), best.agreement.overlap(), best.agreement.part(), tried.len(), best.found.verdict, best.found.residual, self.local.pose.delta_to(&lead.pose).minus(&Pose2::identity()).as_slice(), self.local.pose.delta_to(&best.found.estimate.pose).minus(&Pose2::identity()).as_slice()); }
        if is_loose && knob("debug", 0.0) > 0.0 {
            eprintln!("L t {:.1} pose {:?} lead {:?} spread {:.2} {:.2} verified {is_verified}", stamp.seconds(), self.local.pose.minus(&Pose2::identity()).as_slice(), lead.pose.minus(&Pose2::identity()).as_slice(), (spread_(&tried, &best)[(0,0)]+spread_(&tried,&best)[(1,1)]).sqrt(), spread_(&tried,&best)[(2,2)].sqrt());
            for t in &tried { eprintln!("   {:.2} {:.2} {:.2} ov {:.2} part {:.2} n {} score {:.3} {:?}", t.found.estimate.pose.x(), t.found.estimate.pose.y(), t.found.estimate.pose.heading(), t.agreement.overlap(), t.agreement.part(), t.agreement.total, t.score, t.found.verdict); }
        }
        Tracked {
            estimate,
            found: matched.then_some(best.found),
            agreement: best.agreement,
            is_verified,
            is_loose,
            is_sure: is_sure(&best),
            was_right,
        }
    }

    /// The motions that are tried, the likeliest first.
    fn hypotheses(&self, moved: Option<&Odometry>, stamp: Stamp) -> Vec<Hypothesis> {
        let seconds = self.pasts.back().map_or(0.0, |p| stamp.since(p.stamp));
        let wide = self.unguided_cov(seconds);
        let at = |pose: Pose2, penalty: f64| Hypothesis {
            pose,
            cov: wide,
            penalty,
        };
        let here = self.local.pose;
        let same_speed = self.speed.map(|(past, motion)| {
            // Stamps may jitter: between half and twice the last motion.
            let part = (seconds.max(1e-6) / past.max(1e-6)).clamp(0.5, 2.0);
            [here * motion, here * motion.fraction(part)]
        });
        let mut list = vec![];
        let wrong = self.odometry_model.mistrust();
        match moved {
            Some(moved) => {
                let turned = here.rotation();
                list.push(Hypothesis {
                    pose: here * moved.motion,
                    cov: turned * moved.cov * turned.transpose() * knob("ocov", 1.0) + wide * knob("owide", 0.0),
                    penalty: 0.0,
                });
                list.push(at(here, wrong));
                list.extend(same_speed.iter().flatten().map(|&pose| at(pose, wrong)));
                let odom = self.odom_from_robot;
                for past in self.pasts.iter().rev().skip(1) {
                    let since = past.odom_from_robot.delta_to(&odom);
                    list.push(at(past.submap_from_robot * since, wrong));
                }
            }
            None => {
                let [same, scaled] = same_speed.unwrap_or([here; 2]);
                list.push(at(same, 0.0));
                list.push(at(scaled, 0.0));
                list.push(at(here, 0.05));
            }
        }
        let lead = list[0].pose;
        let most = (MOST_TURN_RATE * seconds.clamp(0.1, 1.0)).min(1.0);
        for turn in [0.15, -0.15, 0.35, -0.35, 0.6, -0.6, 0.9, -0.9] {
            if f64::abs(turn) <= most {
                list.push(at(lead * Pose2::new(0.0, 0.0, turn), if moved.is_some() { wrong } else { 0.1 }));
            }
        }
        list
    }

    /// What the motion of so many seconds is known to without anybody who counts it.
    fn unguided_cov(&self, seconds: f64) -> Matrix3<f64> {
        let seconds = seconds.clamp(0.0, 10.0);
        let way = (0.5 * ACCELERATION * seconds * seconds).min(MOST_SPEED * seconds);
        let turn = (0.5 * TURN_ACCELERATION * seconds * seconds).min(MOST_TURN_RATE * seconds);
        pose_cov(
            self.config.odometry_sigma + way,
            self.config.odometry_turn_sigma + turn,
        )
    }

    /// Where the motion that is tried first leads, with all that is not known of the pose there.
    fn predicted(&self, moved: Option<&Odometry>, lead: &Hypothesis) -> PoseEstimate {
        match moved {
            Some(moved) => moved.after(&self.local),
            None => PoseEstimate {
                pose: lead.pose,
                cov: self.local.cov + lead.cov,
            },
        }
    }

    fn try_one(
        &self,
        surfaces: &[OrientedPoint],
        hypothesis: &Hypothesis,
        all: &[Hypothesis],
    ) -> Tried {
        let prior = self.prior_of(hypothesis);
        let matching = &self.config.locate.matching;
        let found = register(surfaces, &self.running, &prior.pose, &prior, matching);
        self.weighed(surfaces, found, all)
    }

    /// What is believed of a motion while it is matched: the pose at the last match is the map's,
    /// and not doubted here.
    fn prior_of(&self, hypothesis: &Hypothesis) -> Prior {
        let mut cov = hypothesis.cov + self.odometry_floor();
        if self.is_blind {
            cov += self.local.cov;
        }
        // A covariance that odometry spoilt says nothing.
        let information = cov.try_inverse().unwrap_or_else(Matrix3::zeros);
        Prior {
            pose: hypothesis.pose,
            information,
        }
    }

    fn weighed(
        &self,
        surfaces: &[OrientedPoint],
        found: Registration,
        hypotheses: &[Hypothesis],
    ) -> Tried {
        let pose = found.estimate.pose;
        let of = |point| says(point, &pose, &self.running, &self.running_free);
        let said: Vec<Says> = surfaces.iter().map(of).collect();
        let agreement = Agreement::sum(said.iter().copied());
        let cost = hypotheses
            .iter()
            .map(|h| {
                let off = pose.minus(&h.pose);
                let d2 = off.dot(&(self.prior_of(h).information * off));
                h.penalty + IMPLAUSIBLE * libm::log1p(d2 / 3.0)
            })
            .fold(f64::INFINITY, f64::min);
        Tried {
            found,
            agreement,
            said,
            cost,
            score: 0.0,
        }
    }

    fn search_around(
        &self,
        surfaces: &[OrientedPoint],
        lead: &Hypothesis,
        stamp: Stamp,
    ) -> Option<Registration> {
        let seconds = self.pasts.back().map_or(0.0, |p| stamp.since(p.stamp));
        let locate = &self.config.locate;
        let window = SearchWindow {
            shift: locate.window.shift.max(0.3 + MOST_SPEED * seconds.min(1.0)),
            turn: locate.window.turn.max(0.2 + MOST_TURN_RATE * seconds.min(1.0)),
        };
        let prior = self.prior_of(lead);
        let (search, matching) = (&locate.search, &locate.matching);
        let pivot = Point2::origin();
        search_and_match(surfaces, pivot, &self.running, &prior, &window, search, matching)
    }
}

/// Scores all that were tried beside the first of them. A point says which of two poses is better
/// only if it would leave its surface on the way from one to the other: the walls of a corridor
/// agree wherever along it the robot is, as far as they were seen already.
fn compare(surfaces: &[OrientedPoint], tried: &mut [Tried]) {
    let Some((lead, others)) = tried.split_first_mut() else {
        return;
    };
    let value = |says: &Says| match says {
        Says::Agrees => 1.0,
        Says::Contradicts => -CONTRADICTION,
        Says::Nothing => 0.0,
    };
    let at = lead.found.estimate.pose;
    for other in others {
        let way = other.found.estimate.pose.minus(&at);
        let shift = way.xy().norm();
        let direction = at.inverse().rotate(way.xy() / shift.max(1e-9));
        let is_turn = way.z.abs() > SAME_TURN * 2.0 || shift < SAME_SHIFT;
        let gain: f64 = surfaces
            .iter()
            .zip(lead.said.iter().zip(&other.said))
            .map(|(point, (before, after))| {
                let leaves = if is_turn {
                    1.0
                } else {
                    ((point.normal.dot(&direction).abs() - 0.2) / 0.3).clamp(0.0, 1.0)
                };
                leaves * (value(after) - value(before))
            })
            .sum();
        other.score = gain / surfaces.len().max(1) as f64 - (other.cost - lead.cost);
    }
}

fn best_of(tried: &[Tried]) -> Tried {
    let by_score = |a: &&Tried, b: &&Tried| a.score.total_cmp(&b.score);
    // The first of equals: max_by would take the last.
    tried.iter().rev().max_by(by_score).expect("the lead was tried").clone()
}

/// What is not known of the pose since other motions fit nearly as well: the spread of all that
/// were tried about the best.
fn spread_(tried: &[Tried], best: &Tried) -> Matrix3<f64> { spread(tried, best) }
fn spread(tried: &[Tried], best: &Tried) -> Matrix3<f64> {
    let (mut sum, mut total) = (Matrix3::zeros(), 0.0);
    for other in tried {
        let weight = libm::exp((other.score - best.score) / knob("temp", 0.05));
        let off = other.found.estimate.pose.minus(&best.found.estimate.pose);
        sum += off * off.transpose() * weight;
        total += weight;
    }
    sum / total
}
