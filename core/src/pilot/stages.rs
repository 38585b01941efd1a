//! What each stage of the cycle gave, for people who want to follow the cycle.
//!
//! In: one [`StageReport`] for each [`Stage`], from the code that does the stage: scan, lines,
//! localise and map come with a scan, the others from the pilot. Out: the [`StageRecord`], through
//! which a person can step stage by stage while the run itself goes on in whole rounds.
//!
//! Source: TDK 2016 §6.3 (fig. 6.3), where four nodes share the stages.

use std::collections::VecDeque;
use std::fmt;

use nalgebra::Point2;

use crate::geom::{Length, PoseEstimate};
use crate::plan::Planner;

/// Stages of the cycle in the order in which they are done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// The errand begins; at the very first errand the pose is known.
    Init,
    /// The sensor scans while the robot stands.
    Scan,
    /// Lines are found in the scan.
    Lines,
    /// The lines are matched, and the pose is corrected.
    Localise,
    /// What was seen enters the map.
    Map,
    /// A path to the goal is searched for.
    Plan,
    /// The path is cut to what has been seen.
    Truncate,
    /// The robot turns towards the first leg.
    Turn,
    /// The robot drives that leg.
    Go,
}

impl Stage {
    /// All stages in order, with their names.
    pub const ALL: [(&'static str, Self); 9] = [
        ("init", Self::Init),
        ("scan", Self::Scan),
        ("lines", Self::Lines),
        ("localise", Self::Localise),
        ("map", Self::Map),
        ("plan", Self::Plan),
        ("truncate", Self::Truncate),
        ("turn", Self::Turn),
        ("go", Self::Go),
    ];

    /// Its place in [`Self::ALL`].
    #[must_use]
    pub fn index(self) -> usize {
        self as usize
    }
}

/// The result of a stage. Its `Display` is a sentence for people.
#[derive(Clone, Debug, PartialEq)]
pub enum StageReport {
    /// Where the errand begins.
    Init {
        /// The pose with its covariance, map frame.
        estimate: PoseEstimate,
    },
    /// A standing scan was commanded.
    LooksRound,
    /// A scan is complete.
    Scan {
        /// Number of usable readings.
        readings: usize,
        /// Number of hits among them.
        hits: usize,
    },
    /// Lines of the scan.
    Lines {
        /// Number of lines.
        lines: usize,
        /// Number of readings that lie on them.
        points: usize,
    },
    /// The scan corrected the pose.
    Localise {
        /// Lines recognised as known walls.
        matched: usize,
        /// Lines that are new walls.
        added: usize,
        /// Lines that were not used.
        rejected: usize,
        /// The pose afterwards.
        estimate: PoseEstimate,
        /// The pose before.
        before: PoseEstimate,
    },
    /// The scan was drawn into the map.
    Map {
        /// Walls of the line map.
        walls: usize,
        /// Those seen often enough to be sure of.
        confirmed: usize,
    },
    /// A path was found.
    Plan {
        /// Where it leads, map frame, m.
        goal: Point2<f64>,
        /// Its length, m.
        length: f64,
        /// Its legs.
        legs: usize,
        /// The planner that found it.
        by: Planner,
    },
    /// There is nothing to drive, for now or for good.
    NoPath {
        /// Why, in words.
        why: String,
    },
    /// The path was cut to its first leg, and the leg to what may be driven without another scan.
    Truncate {
        /// What is left of the leg, m.
        length: f64,
        /// The leg before, m.
        leg: f64,
        /// What cut it.
        cut: Cut,
    },
    /// The robot turns.
    Turn {
        /// By how much, rad; to the left where positive.
        angle: f64,
    },
    /// The robot drives.
    Go {
        /// How far, m; backwards where negative.
        length: f64,
        /// How far it was to go before the obstacles of the last scan were considered, m.
        wished: f64,
    },
}

/// What cuts a leg.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cut {
    /// Nothing: all of it is driven.
    Nothing,
    /// Farther on, nothing has been seen yet.
    Unseen,
    /// The longest leg allowed between two scans.
    Longest,
    /// Farther on, odometry would lose the heading.
    Odometry,
    /// The turn alone loses so much of the heading that a scan comes first.
    TurnFirst,
}

impl StageReport {
    /// The stage to which the report belongs.
    #[must_use]
    pub fn stage(&self) -> Stage {
        match self {
            Self::Init { .. } => Stage::Init,
            Self::LooksRound | Self::Scan { .. } => Stage::Scan,
            Self::Lines { .. } => Stage::Lines,
            Self::Localise { .. } => Stage::Localise,
            Self::Map { .. } => Stage::Map,
            Self::Plan { .. } | Self::NoPath { .. } => Stage::Plan,
            Self::Truncate { .. } => Stage::Truncate,
            Self::Turn { .. } => Stage::Turn,
            Self::Go { .. } => Stage::Go,
        }
    }
}

impl fmt::Display for StageReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Init { estimate } => write!(f, "at {}", Pose(estimate)),
            Self::LooksRound => f.write_str("stands and scans"),
            Self::Scan { readings, hits } => {
                write!(f, "{readings} readings, {hits} on something")
            }
            Self::Lines { lines, points } => {
                write!(f, "{lines} lines through {points} readings")
            }
            Self::Localise {
                matched,
                added,
                rejected,
                estimate,
                before,
            } => {
                let moved = (estimate.pose.position() - before.pose.position()).length();
                write!(f, "{matched} recognised, {added} new, {rejected} unused; ")?;
                write!(
                    f,
                    "{}, corrected by {:.1} cm",
                    Pose(estimate),
                    100.0 * moved
                )
            }
            Self::Map { walls, confirmed } => write!(f, "{walls} walls, {confirmed} of them sure"),
            Self::Plan {
                goal,
                length,
                legs,
                by,
            } => {
                let (x, y) = (goal.x, goal.y);
                write!(f, "{length:.2} m in {legs} legs to ({x:.2}, {y:.2}) m, ")?;
                match by {
                    Planner::Straight => f.write_str("the straight line is free"),
                    _ => write!(f, "found by {}", by.title()),
                }
            }
            Self::NoPath { why } => write!(f, "no path: {why}"),
            Self::Truncate { length, leg, cut } => {
                let why = match cut {
                    Cut::Nothing => "all of the first leg",
                    Cut::Unseen => "farther on nothing was seen yet",
                    Cut::Longest => "the longest leg between two scans",
                    Cut::Odometry => "farther on odometry would lose the heading",
                    Cut::TurnFirst => {
                        "the turn alone costs so much heading that a scan comes first"
                    }
                };
                write!(f, "{length:.2} m of {leg:.2} m: {why}")
            }
            Self::Turn { angle } => {
                let side = if *angle < 0.0 { "right" } else { "left" };
                write!(f, "{:.1}° to the {side}", angle.abs().to_degrees())
            }
            Self::Go { length, wished } => {
                write!(f, "{length:.2} m")?;
                if *length >= 0.0 && *length < *wished - 1e-9 {
                    write!(f, " of {wished:.2} m: something stands beyond")?;
                }
                Ok(())
            }
        }
    }
}

/// A pose and how uncertain it is, in words.
struct Pose<'a>(&'a PoseEstimate);

impl fmt::Display for Pose<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let PoseEstimate { pose, cov } = self.0;
        let sigma = (cov[(0, 0)] + cov[(1, 1)]).max(0.0).sqrt();
        let (x, y, degrees) = (pose.x(), pose.y(), pose.heading().to_degrees());
        write!(
            f,
            "({x:.2}, {y:.2}) m, {degrees:.0}°, ± {:.1} cm",
            100.0 * sigma
        )
    }
}

/// The reports of all rounds in order, and how far they have been shown.
///
/// A report is shown as soon as it is recorded, unless somebody steps through the record (`step`):
/// then reports wait for the next `step`, or for `show_all`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StageRecord {
    /// The newest report of each stage among those shown.
    reports: [Option<StageReport>; Stage::ALL.len()],
    now: Option<Stage>,
    count: u64,
    round: u32,
    /// Reports that wait to be shown.
    waiting: VecDeque<StageReport>,
    is_stepped: bool,
}

impl StageRecord {
    /// Records a stage that is done or under way.
    pub(crate) fn record(&mut self, report: StageReport) {
        if self.is_stepped {
            self.waiting.push_back(report);
        } else {
            self.show(report);
        }
    }

    /// Shows the next report that waits, and returns its stage; `None` if none waits. The beginning
    /// of an errand or of a sweep is shown together with what comes next.
    pub(crate) fn step(&mut self) -> Option<Stage> {
        self.is_stepped = true;
        while let Some(report) = self.waiting.pop_front() {
            let is_stage = !matches!(report, StageReport::Init { .. } | StageReport::LooksRound);
            self.show(report);
            if is_stage {
                return self.now;
            }
        }
        None
    }

    /// Shows everything that waits, and from here on every report as it comes.
    pub(crate) fn show_all(&mut self) {
        self.is_stepped = false;
        while let Some(report) = self.waiting.pop_front() {
            self.show(report);
        }
    }

    fn show(&mut self, report: StageReport) {
        let stage = report.stage();
        if report == StageReport::LooksRound {
            self.round += 1;
        }
        self.now = Some(stage);
        self.count += 1;
        if let Some(place) = self.reports.get_mut(stage.index()) {
            *place = Some(report);
        }
    }

    /// The newest report of a stage.
    #[must_use]
    pub fn report(&self, stage: Stage) -> Option<&StageReport> {
        self.reports.get(stage.index())?.as_ref()
    }

    /// The stage of the newest report.
    #[must_use]
    pub fn now(&self) -> Option<Stage> {
        self.now
    }

    /// Reports shown so far.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Scans asked for so far: the number of the round of the cycle, from 1.
    #[must_use]
    pub fn round(&self) -> u32 {
        self.round
    }

    /// Whether a stage is done but its report waits to be shown: its effects must not be visible
    /// yet.
    #[must_use]
    pub fn awaits(&self, stage: Stage) -> bool {
        self.waiting.iter().any(|report| report.stage() == stage)
    }

    /// The estimate to show while its correction waits to be shown; otherwise the newest.
    #[must_use]
    pub fn held_estimate(&self) -> Option<&PoseEstimate> {
        self.waiting.iter().find_map(|report| match report {
            StageReport::Localise { before, .. } => Some(before),
            _ => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Pose2;

    #[test]
    fn stages_stand_in_their_places() {
        for (index, (_, stage)) in Stage::ALL.into_iter().enumerate() {
            assert_eq!(stage.index(), index);
        }
    }

    #[test]
    fn reports_are_kept_by_stage_and_say_what_was_cut_and_why() {
        let mut stages = StageRecord::default();
        assert_eq!((stages.now(), stages.round()), (None, 0));
        stages.record(StageReport::LooksRound);
        stages.record(StageReport::Scan {
            readings: 180,
            hits: 40,
        });
        stages.record(StageReport::Turn { angle: -0.5 });
        assert_eq!(
            (stages.now(), stages.count(), stages.round()),
            (Some(Stage::Turn), 3, 1)
        );
        let said = |stage| stages.report(stage).map(ToString::to_string);
        assert_eq!(said(Stage::Scan).unwrap(), "180 readings, 40 on something");
        assert_eq!(said(Stage::Turn).unwrap(), "28.6° to the right");
        assert_eq!(said(Stage::Go), None);
        let cut = |cut| {
            let (length, leg) = (0.7, 2.0);
            StageReport::Truncate { length, leg, cut }.to_string()
        };
        assert_eq!(
            cut(Cut::Unseen),
            "0.70 m of 2.00 m: farther on nothing was seen yet"
        );
        let go = |length, wished| StageReport::Go { length, wished }.to_string();
        assert_eq!(go(0.4, 0.4), "0.40 m");
        assert_eq!(go(0.3, 0.4), "0.30 m of 0.40 m: something stands beyond");
        let estimate = PoseEstimate::exact(Pose2::identity());
        assert_eq!(
            StageReport::Init { estimate }.to_string(),
            "at (0.00, 0.00) m, 0°, ± 0.0 cm"
        );
    }

    #[test]
    fn who_steps_sees_one_stage_at_a_time_and_the_pose_as_it_was() {
        let mut stages = StageRecord::default();
        let [before, estimate] = [0.0, 1.0].map(|x| PoseEstimate::exact(Pose2::new(x, 0.0, 0.0)));
        assert_eq!(stages.step(), None);
        stages.record(StageReport::LooksRound);
        let (readings, hits) = (10, 5);
        stages.record(StageReport::Scan { readings, hits });
        stages.record(StageReport::Localise {
            matched: 1,
            added: 0,
            rejected: 0,
            estimate,
            before,
        });
        assert_eq!((stages.now(), stages.round()), (None, 0));
        assert_eq!(stages.step(), Some(Stage::Scan));
        assert!(stages.awaits(Stage::Localise) && !stages.awaits(Stage::Scan));
        assert_eq!(stages.held_estimate(), Some(&before));
        assert_eq!(stages.step(), Some(Stage::Localise));
        assert_eq!((stages.step(), stages.held_estimate()), (None, None));
        stages.record(StageReport::Turn { angle: 0.1 });
        assert!(stages.awaits(Stage::Turn));
        stages.show_all();
        assert_eq!((stages.now(), stages.round()), (Some(Stage::Turn), 1));
        stages.record(StageReport::Turn { angle: 0.2 });
        assert!(!stages.awaits(Stage::Turn));
    }
}
