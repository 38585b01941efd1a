//! The numbers of the moment, the same for every source.

use slamlab_core::estimation::Figure;
use slamlab_core::session::Session;
use slamlab_core::slam::PriorMapFit;
use wasm_bindgen::prelude::wasm_bindgen;

/// The numbers of the moment; poses in the map frame, m and rad. NaN where the source knows none.
#[wasm_bindgen]
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    missing_docs,
    reason = "names and units as in `Status` of www/src/protocol/frame.ts"
)]
pub struct RunStatus {
    pub time: f64,
    pub progress: f64,
    pub scans: u32,
    pub x: f64,
    pub y: f64,
    pub heading: f64,
    pub cov_xx: f64,
    pub cov_xy: f64,
    pub cov_yy: f64,
    pub cov_heading: f64,
    pub truth_x: f64,
    pub truth_y: f64,
    pub truth_heading: f64,
    pub odometry_x: f64,
    pub odometry_y: f64,
    pub odometry_heading: f64,
    pub distance: f64,
    pub contacts: f64,
    pub goal_x: f64,
    pub goal_y: f64,
    pub nees: f64,
    pub nees_low: f64,
    pub nees_high: f64,
    pub nis: f64,
    pub nis_low: f64,
    pub nis_high: f64,
    pub loop_closures: u32,
    pub known_part: f64,
    pub known_misfit: bool,
    /// Something was seen that the grid has no room for.
    pub map_full: bool,
    pub finished: bool,
}

impl RunStatus {
    /// What every source knows: the estimate, and where the wheels alone would put the robot.
    pub(crate) fn of(session: &Session) -> Self {
        let (odometry, consistency) = (session.dead_reckoning(), session.consistency());
        let (estimate, slam) = (session.shown_estimate(), session.slam());
        let fit = slam.view().prior_map_fit;
        let flat = |figure: Option<Figure>| {
            figure.map_or([f64::NAN; 3], |f| [f.mean, f.band[0], f.band[1]])
        };
        let [nees, nees_low, nees_high] = flat(consistency.nees());
        let [nis, nis_low, nis_high] = flat(consistency.nis());
        Self {
            time: f64::NAN,
            progress: f64::NAN,
            scans: 0,
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
            distance: f64::NAN,
            contacts: f64::NAN,
            goal_x: f64::NAN,
            goal_y: f64::NAN,
            nees,
            nees_low,
            nees_high,
            nis,
            nis_low,
            nis_high,
            loop_closures: slam.view().loop_closures as u32,
            known_part: fit.and_then(PriorMapFit::part).unwrap_or(f64::NAN),
            known_misfit: fit.is_some_and(PriorMapFit::is_misfit),
            map_full: slam.grid().is_whole().is_err(),
            finished: false,
        }
    }
}
