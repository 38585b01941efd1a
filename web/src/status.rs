//! The present numbers of a run, the same for every source.

use serde::{Deserialize, Serialize};
use slamlab_core::estimation::{Figure, MeanInnovation, ScanMatcher};
use slamlab_core::geom::Pose2;
use slamlab_core::pilot::{Pilot, Status};
use slamlab_core::robot::BodyShape;
use slamlab_core::session::Session;
use slamlab_core::slam::{PriorMapFit, Slam};
use tsify::Tsify;

use crate::border::{DiagnosisName, Level, LocalisationName, Mode, TaskState};

/// The present numbers; poses in the map frame, m and rad. NaN for what the source does not know.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
#[tsify(missing_as_null)]
pub struct RunStatus {
    /// Time of the simulation, the recording or the robot, s.
    pub time: f64,
    /// How much of a recording is done, 0 to 1.
    pub progress: f64,
    /// Scans so far.
    pub scans: u32,
    /// Estimate.
    pub x: f64,
    /// Estimate.
    pub y: f64,
    /// Estimate.
    pub heading: f64,
    /// Its covariance, m² and rad².
    pub cov_xx: f64,
    /// Its covariance.
    pub cov_xy: f64,
    /// Its covariance.
    pub cov_yy: f64,
    /// Its covariance.
    pub cov_heading: f64,
    /// Truth.
    pub truth_x: f64,
    /// Truth.
    pub truth_y: f64,
    /// Truth.
    pub truth_heading: f64,
    /// Dead reckoning.
    pub odometry_x: f64,
    /// Dead reckoning.
    pub odometry_y: f64,
    /// Dead reckoning.
    pub odometry_heading: f64,
    /// Distance driven, m.
    pub distance: f64,
    /// How often the robot touched something.
    pub contacts: f64,
    /// Goal of the pilot, m; NaN while there is none.
    pub goal_x: f64,
    /// Goal of the pilot, m.
    pub goal_y: f64,
    /// NEES: mean of the last scans; its 95 % band follows.
    pub nees: f64,
    /// Its band.
    pub nees_low: f64,
    /// Its band.
    pub nees_high: f64,
    /// NIS: the same for each degree of freedom of the innovations.
    pub nis: f64,
    /// Its band.
    pub nis_low: f64,
    /// Its band.
    pub nis_high: f64,
    /// What these figures say.
    pub diagnosis: DiagnosisName,
    /// How far the features matched in the last scan lay from where they were expected; `null` if
    /// none were matched, and for methods that do not compare features.
    pub innovation: Option<Innovation>,
    /// Residual of the last scan's match, root mean square distance, m; `NaN` if it was not
    /// matched, and for methods that do not match whole scans.
    pub scan_residual: f64,
    /// Features of the last scan, or its points that were matched; `NaN` if they are not counted.
    pub features_seen: f64,
    /// How many of them were matched.
    pub features_matched: f64,
    /// How many of them became landmarks; `NaN` for points.
    pub features_new: f64,
    /// Loops closed so far.
    pub loop_closures: u32,
    /// The submap in which the robot is; 0 for methods without submaps.
    pub submap: u32,
    /// Part of the sensor's recent hits that lie on the prior map, 0 to 1; NaN without one, or
    /// before enough was seen.
    pub prior_map_overlap: f64,
    /// The overlap is so small that this is probably another map, or another start in it.
    pub prior_map_misfit: bool,
    /// Whether the pose in the prior map can be trusted; `null` for a method that does not tell.
    pub localisation: Option<LocalisationName>,
    /// Whether the robot's place in the map is known; false while a run that goes on in a saved map
    /// has not found its place.
    pub placed: bool,
    /// Effective number of particles with maps; `NaN` for other methods.
    pub effective_particles: f64,
    /// Number of particles with maps; 0 for other methods.
    pub map_particles: u32,
    /// Something was seen for which the grid has no room.
    pub map_full: bool,
    /// Number of actions in a simulation that were not repetitions of recorded ones; 0 for other
    /// sources.
    pub by_hand: u32,
    /// Who decides where to go.
    pub mode: Mode,
    /// What the pilot is doing; `null` for a recording.
    pub task: Option<Task>,
    /// The task or the recording is over.
    pub finished: bool,
    /// Half length of the robot, m.
    pub half_length: f64,
    /// Half width of the robot, m.
    pub half_width: f64,
    /// Whether this rectangle collides with walls; otherwise the disc around it does.
    pub is_rectangle: bool,
    /// Half the opening angle of a sonar's cone, rad; 0 for a laser beam.
    pub beam_half_angle: f64,
}

/// Innovations of a scan with their standard deviations, `NaN` if no feature of that kind was
/// matched; see `Innovations` of the core.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct Innovation {
    /// Direction of lines, rad.
    pub alpha: f64,
    /// Its σ.
    pub alpha_sigma: f64,
    /// Distance of lines, m.
    pub r: f64,
    /// Its σ.
    pub r_sigma: f64,
    /// Points: forward of the robot, m.
    pub x: f64,
    /// Its σ.
    pub x_sigma: f64,
    /// Points: left of the robot, m.
    pub y: f64,
    /// Its σ.
    pub y_sigma: f64,
}

impl Innovation {
    fn of(slam: &Slam) -> Option<Self> {
        let found = slam.view().update?.innovations();
        let flat = |each: Option<MeanInnovation>| each.map_or([f64::NAN; 2], |i| [i.mean, i.sigma]);
        let [[alpha, alpha_sigma], [r, r_sigma]] = [flat(found.alpha), flat(found.r)];
        let [[x, x_sigma], [y, y_sigma]] = [flat(found.x), flat(found.y)];
        let is_empty = [alpha, r, x, y].into_iter().all(f64::is_nan);
        (!is_empty).then_some(Self {
            alpha,
            alpha_sigma,
            r,
            r_sigma,
            x,
            x_sigma,
            y,
            y_sigma,
        })
    }
}

/// What the pilot is doing, or how its task ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[tsify(missing_as_null)]
pub struct Task {
    /// What it is doing.
    pub state: TaskState,
    /// `good` if all that was asked is done, `warn` if something is left or it is waiting.
    pub level: Level,
    /// The same in words.
    pub text: String,
    /// What found the path, as part of a sentence.
    pub planner: Option<String>,
}

impl Task {
    pub(crate) fn of(pilot: &Pilot) -> Self {
        let status = pilot.status();
        let (state, level) = match status {
            Status::Idle => (TaskState::Idle, Level::Info),
            Status::Driving if pilot.is_closing_loop() => (TaskState::Closing, Level::Info),
            Status::Driving if pilot.is_homeward() => (TaskState::Homeward, Level::Info),
            Status::Driving => (TaskState::Driving, Level::Info),
            Status::Scanning => (TaskState::Scanning, Level::Info),
            Status::Waiting(_) => (TaskState::Waiting, Level::Warn),
            Status::Finished(finish) if finish.is_complete() => (TaskState::Finished, Level::Good),
            Status::Finished(_) => (TaskState::Finished, Level::Warn),
            Status::Failed(_) => (TaskState::Failed, Level::Warn),
        };
        Self {
            state,
            level,
            text: status.to_string(),
            planner: pilot.route().map(|route| route.by.title().to_owned()),
        }
    }
}

/// The number of the submap in progress.
fn running_submap(slam: &Slam) -> usize {
    let submaps = slam.view().map.map_or(0, |map| map.submaps().len());
    submaps.saturating_sub(1)
}

/// The number of particles of a method that maps with particles.
fn map_particles(slam: &Slam) -> usize {
    let view = slam.view();
    (view.effective_particles).map_or(0, |_| view.particles.len())
}

impl RunStatus {
    /// Adds the robot's true pose, map frame, if the source knows it.
    pub(crate) fn with_truth(self, truth: Option<Pose2>) -> Self {
        let of = |value: fn(&Pose2) -> f64| truth.as_ref().map_or(f64::NAN, value);
        Self {
            truth_x: of(Pose2::x),
            truth_y: of(Pose2::y),
            truth_heading: of(Pose2::heading),
            ..self
        }
    }

    /// What every source knows; if the robot is driven, also what its pilot is doing.
    pub(crate) fn of(session: &Session, is_driven: bool) -> Self {
        let (odometry, consistency) = (session.dead_reckoning(), session.consistency());
        let (estimate, slam, robot) = (session.shown_estimate(), session.slam(), session.robot());
        let (pilot, goal) = (session.pilot(), session.pilot().goal());
        let fit = slam.view().prior_map_fit;
        let (scan_fit, counts) = (slam.view().scan_fit, slam.view().feature_counts());
        let count = |count: Option<usize>| count.map_or(f64::NAN, |count| count as f64);
        let flat = |figure: Option<Figure>| {
            figure.map_or([f64::NAN; 3], |f| [f.mean, f.band[0], f.band[1]])
        };
        let [nees, nees_low, nees_high] = flat(consistency.nees());
        let [nis, nis_low, nis_high] = flat(consistency.nis());
        Self {
            time: session.stamp().seconds(),
            progress: f64::NAN,
            scans: session.scans() as u32,
            x: estimate.pose.x(),
            y: estimate.pose.y(),
            heading: estimate.pose.heading(),
            cov_xx: estimate.cov[(0, 0)],
            cov_xy: estimate.cov[(0, 1)],
            cov_yy: estimate.cov[(1, 1)],
            cov_heading: estimate.cov[(2, 2)],
            truth_x: f64::NAN,
            truth_y: f64::NAN,
            truth_heading: f64::NAN,
            odometry_x: odometry.x(),
            odometry_y: odometry.y(),
            odometry_heading: odometry.heading(),
            distance: session.distance(),
            contacts: f64::NAN,
            goal_x: goal.map_or(f64::NAN, |goal| goal.x),
            goal_y: goal.map_or(f64::NAN, |goal| goal.y),
            nees,
            nees_low,
            nees_high,
            nis,
            nis_low,
            nis_high,
            diagnosis: (&consistency.diagnosis()).into(),
            innovation: Innovation::of(slam),
            scan_residual: scan_fit.map_or(f64::NAN, |fit| fit.residual),
            features_seen: count(counts.map(|counts| counts.seen)),
            features_matched: count(counts.map(|counts| counts.matched)),
            features_new: count(counts.and_then(|counts| counts.new)),
            loop_closures: slam.view().loop_closures as u32,
            submap: running_submap(slam) as u32,
            prior_map_overlap: fit.and_then(PriorMapFit::part).unwrap_or(f64::NAN),
            prior_map_misfit: fit.is_some_and(PriorMapFit::is_misfit),
            localisation: fit
                .and(slam.view().pose_quality)
                .map(|quality| (&quality.localisation).into()),
            placed: slam.view().map.is_none_or(ScanMatcher::is_placed),
            effective_particles: slam.view().effective_particles.unwrap_or(f64::NAN),
            map_particles: map_particles(slam) as u32,
            map_full: slam.grid().is_whole().is_err(),
            by_hand: 0,
            mode: (&pilot.mode()).into(),
            task: is_driven.then(|| Task::of(pilot)),
            finished: pilot.status().is_over(),
            half_length: 0.5 * robot.length,
            half_width: 0.5 * robot.width,
            is_rectangle: robot.shape == BodyShape::Rectangle,
            beam_half_angle: 0.0,
        }
    }
}
