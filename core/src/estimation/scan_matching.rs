//! SLAM by matching scans to submaps: for lidars in real buildings.
//!
//! In: odometry and scans. Out: the pose with its covariance, the trajectory, the grid.
//!
//! 1. Odometry since the last scan says where to look; the scan's oriented points are matched to the running submap
//!    ([`match_to_surfels`]), with odometry's own covariance as the prior.
//! 2. After some way or turn the scan becomes a keyframe: it is added to the submap and drawn into the grid.
//! 3. After some keyframes the submap is closed and a new one begun, seeded with the last keyframes, so that there is
//!    always a map to match to. Poses are kept relative to their submap: moving a submap moves all that was seen in it.

use std::collections::VecDeque;

use nalgebra::{Matrix3, Point2, Vector3};

use crate::geom::{Pose2, PoseEstimate, symmetrize};
use crate::map::{Grid, GridConfig, GridError, SurfelConfig, SurfelMap};
use crate::points::{
    Beam, MotionHistory, OrientedConfig, OrientedPoint, PointConfig, Points, oriented_points,
};
use crate::registration::{MatchConfig, Prior, Registration, Verdict, match_to_surfels};
use crate::robot::{Odometry, Scan, Stamp};

/// How scan matching works.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanMatcherConfig {
    /// What is kept of a scan.
    pub points: PointConfig,
    /// How surfaces are found in it.
    pub oriented: OrientedConfig,
    /// How submaps are kept.
    pub surfels: SurfelConfig,
    /// How scans are matched to them.
    pub matching: MatchConfig,
    /// The map that is drawn.
    pub grid: GridConfig,
    /// A scan becomes a keyframe after this way, m. Default 0.25.
    pub keyframe_distance: f64,
    /// A scan becomes a keyframe after this turn, rad. Default 0.2.
    pub keyframe_turn: f64,
    /// Keyframes of one submap, those of the overlap not counted. Default 30; larger drifts more inside, smaller makes
    /// more work.
    pub submap_keyframes: usize,
    /// Keyframes that the next submap takes over from the last. Default 15.
    pub overlap_keyframes: usize,
    /// How far a beam without a return is believed to be free, m. Default 5: glass and black walls return nothing
    /// either.
    pub no_return_clears: f64,
    /// Odometry is never believed better than this, m between scans. Default 0.02.
    pub odometry_sigma: f64,
    /// Odometry is never believed better than this, rad between scans. Default 0.02.
    pub odometry_turn_sigma: f64,
}

impl Default for ScanMatcherConfig {
    fn default() -> Self {
        Self {
            points: PointConfig::default(),
            oriented: OrientedConfig::default(),
            surfels: SurfelConfig::default(),
            matching: MatchConfig::default(),
            grid: GridConfig::default(),
            keyframe_distance: 0.25,
            keyframe_turn: 0.2,
            submap_keyframes: 30,
            overlap_keyframes: 15,
            no_return_clears: 5.0,
            odometry_sigma: 0.02,
            odometry_turn_sigma: 0.02,
        }
    }
}

/// Why scan matching cannot begin.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ScanMatcherError {
    /// The grid's figures.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// A field outside of its range.
    #[error("scan matching: {field} is {value}, expected {expected}")]
    Config {
        /// The field.
        field: &'static str,
        /// What stands there.
        value: f64,
        /// What may stand there.
        expected: &'static str,
    },
}

/// What became of one scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatchReport {
    /// How the match went; `None` for the first scan, which has nothing to be matched to.
    pub registration: Option<Registration>,
    /// Whether the scan became a keyframe.
    pub keyframe: bool,
}

/// SLAM by scan matching.
#[derive(Clone, Debug)]
pub struct ScanMatcher {
    config: ScanMatcherConfig,
    history: MotionHistory,
    pending: Option<Odometry>,
    submaps: Vec<Submap>,
    running: SurfelMap,
    submap_from_robot: Pose2,
    local_cov: Matrix3<f64>,
    recent: VecDeque<Recent>,
    keyframes: Vec<Keyframe>,
    last_keyframe: Option<Pose2>,
    track: Vec<TrackPoint>,
    last_points: Option<Points>,
    grid: Grid,
}

/// A stretch of the way with its own map.
#[derive(Clone, Debug)]
struct Submap {
    map_from_submap: Pose2,
    /// Keyframes of its own, overlap not counted.
    own_keyframes: usize,
}

/// A keyframe whose surfaces may yet seed the next submap.
#[derive(Clone, Debug)]
struct Recent {
    submap_from_robot: Pose2,
    surfaces: Vec<OrientedPoint>,
}

/// What is drawn: the ends of the beams, in single precision.
#[derive(Clone, Debug)]
struct Keyframe {
    submap: usize,
    submap_from_robot: Pose2,
    origin: Point2<f64>,
    ends: Vec<[f32; 2]>,
    hits: Vec<bool>,
}

#[derive(Clone, Copy, Debug)]
struct TrackPoint {
    stamp: Stamp,
    submap: usize,
    submap_from_robot: Pose2,
}

impl ScanMatcher {
    /// Begins at the origin of the map.
    ///
    /// # Errors   [`ScanMatcherError`], naming the first field out of range.
    pub fn new(config: ScanMatcherConfig) -> Result<Self, ScanMatcherError> {
        let check = |field, value: f64, low: f64, high: f64, expected| {
            if value >= low && value <= high {
                Ok(())
            } else {
                Err(ScanMatcherError::Config {
                    field,
                    value,
                    expected,
                })
            }
        };
        check(
            "keyframe_distance",
            config.keyframe_distance,
            0.01,
            10.0,
            "from 0.01 to 10 m",
        )?;
        check(
            "keyframe_turn",
            config.keyframe_turn,
            0.01,
            3.2,
            "from 0.01 to 3.2 rad",
        )?;
        check(
            "surfels.cell",
            config.surfels.cell,
            0.01,
            0.5,
            "from 0.01 to 0.5 m",
        )?;
        check(
            "surfels.reach",
            config.surfels.reach,
            0.01,
            2.0,
            "from 0.01 to 2 m",
        )?;
        check(
            "submap_keyframes",
            config.submap_keyframes as f64,
            2.0,
            1e4,
            "from 2 to 10000",
        )?;
        Ok(Self {
            history: MotionHistory::new(1.0),
            pending: None,
            submaps: vec![Submap {
                map_from_submap: Pose2::identity(),
                own_keyframes: 0,
            }],
            running: SurfelMap::new(config.surfels),
            submap_from_robot: Pose2::identity(),
            local_cov: Matrix3::zeros(),
            recent: VecDeque::new(),
            keyframes: vec![],
            last_keyframe: None,
            track: vec![],
            last_points: None,
            grid: Grid::new(config.grid)?,
            config,
        })
    }

    /// Takes the motion since the last call. Readings come in order of time.
    pub fn odometry(&mut self, odometry: &Odometry) {
        self.history.push(odometry);
        self.pending = Some(match self.pending {
            Some(so_far) => so_far.then(odometry),
            None => *odometry,
        });
    }

    /// Takes a scan, which was taken at or before the end of the newest odometry.
    pub fn scan(&mut self, scan: &Scan) -> MatchReport {
        let points = if scan.sweep > 0.0 || self.history.now().is_some_and(|now| now > scan.stamp) {
            Points::from_rolling_scan(scan, &self.history, &self.config.points)
        } else {
            Points::from_scan(scan, &Pose2::identity(), &self.config.points)
        };
        self.update(&points)
    }

    /// Takes the points of a scan, in the robot frame at the end of the newest odometry.
    pub fn update(&mut self, points: &Points) -> MatchReport {
        let surfaces = oriented_points(points, &self.config.oriented);
        let moved = self
            .pending
            .take()
            .unwrap_or_else(|| Odometry::standing(points.stamp));
        let predicted = self.submap_from_robot * moved.motion;
        let registration = if self.running.surfels().is_empty() {
            self.submap_from_robot = predicted;
            None
        } else {
            let prior = self.prior(&predicted, &moved);
            let found = match_to_surfels(
                &surfaces,
                &self.running,
                &predicted,
                &prior,
                &self.config.matching,
            );
            self.local_cov = found.estimate.cov;
            self.submap_from_robot = match found.verdict {
                Verdict::TooFewPoints { .. } => predicted,
                _ => found.estimate.pose,
            };
            Some(found)
        };
        let keyframe = self.is_new_place();
        if keyframe {
            self.add_keyframe(points, surfaces);
        }
        self.track.push(TrackPoint {
            stamp: points.stamp,
            submap: self.submaps.len() - 1,
            submap_from_robot: self.submap_from_robot,
        });
        self.last_points = Some(points.clone());
        MatchReport {
            registration,
            keyframe,
        }
    }

    /// Completes all work that was put off.
    pub fn finish(&mut self) {}

    /// The pose in the map, with its covariance.
    #[must_use]
    pub fn estimate(&self) -> PoseEstimate {
        let map_from_submap = self.map_from_running();
        let (cos, sin) = map_from_submap.cos_sin();
        let turned = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        let mut cov = turned * self.local_cov * turned.transpose();
        symmetrize(&mut cov);
        PoseEstimate {
            pose: map_from_submap * self.submap_from_robot,
            cov,
        }
    }

    /// The map.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The last scan's points, in the robot frame.
    #[must_use]
    pub fn last_points(&self) -> Option<&Points> {
        self.last_points.as_ref()
    }

    /// The pose at each scan, as known now: earlier ones change when a loop closes.
    pub fn trajectory(&self) -> impl Iterator<Item = (Stamp, Pose2)> {
        self.track.iter().filter_map(|t| {
            let submap = self.submaps.get(t.submap)?;
            Some((t.stamp, submap.map_from_submap * t.submap_from_robot))
        })
    }

    /// Number of loop closures found.
    #[must_use]
    pub fn loop_closures(&self) -> usize {
        0
    }

    /// Number of submaps.
    #[must_use]
    pub fn submaps(&self) -> usize {
        self.submaps.len()
    }

    fn map_from_running(&self) -> Pose2 {
        self.submaps
            .last()
            .map_or_else(Pose2::identity, |s| s.map_from_submap)
    }

    fn prior(&self, predicted: &Pose2, moved: &Odometry) -> Prior {
        let (cos, sin) = self.submap_from_robot.cos_sin();
        let turned = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        let (way, turn) = (self.config.odometry_sigma, self.config.odometry_turn_sigma);
        let floor = Vector3::new(way * way, way * way, turn * turn);
        let cov = turned * moved.cov * turned.transpose() + Matrix3::from_diagonal(&floor);
        // A covariance that odometry spoilt says nothing.
        let information = cov.try_inverse().unwrap_or_else(Matrix3::zeros);
        Prior {
            pose: *predicted,
            information,
        }
    }

    fn is_new_place(&self) -> bool {
        self.last_keyframe.is_none_or(|last| {
            let moved = last.delta_to(&self.submap_from_robot);
            moved.position().coords.norm() > self.config.keyframe_distance
                || moved.heading().abs() > self.config.keyframe_turn
        })
    }

    fn add_keyframe(&mut self, points: &Points, surfaces: Vec<OrientedPoint>) {
        if self
            .submaps
            .last()
            .is_some_and(|s| s.own_keyframes >= self.config.submap_keyframes)
        {
            self.begin_submap();
        }
        let at = self.submap_from_robot;
        self.running.insert(moved(&surfaces, at));
        self.recent.push_back(Recent {
            submap_from_robot: at,
            surfaces,
        });
        while self.recent.len() > self.config.overlap_keyframes {
            self.recent.pop_front();
        }
        let keyframe = self.keyframe_of(points);
        let map_from_robot = self.map_from_running() * at;
        keyframe.draw(&mut self.grid, &map_from_robot);
        self.keyframes.push(keyframe);
        self.last_keyframe = Some(at);
        if let Some(submap) = self.submaps.last_mut() {
            submap.own_keyframes += 1;
        }
    }

    fn begin_submap(&mut self) {
        let old_from_new = self.submap_from_robot;
        let map_from_submap = self.map_from_running() * old_from_new;
        let new_from_old = old_from_new.inverse();
        self.running = SurfelMap::new(self.config.surfels);
        for recent in &mut self.recent {
            recent.submap_from_robot = new_from_old * recent.submap_from_robot;
            self.running
                .insert(moved(&recent.surfaces, recent.submap_from_robot));
        }
        self.submaps.push(Submap {
            map_from_submap,
            own_keyframes: 0,
        });
        self.submap_from_robot = Pose2::identity();
    }

    fn keyframe_of(&self, points: &Points) -> Keyframe {
        let mut keyframe = Keyframe {
            submap: self.submaps.len() - 1,
            submap_from_robot: self.submap_from_robot,
            origin: points.sensor_in_robot,
            ends: Vec::with_capacity(points.beams.len()),
            hits: Vec::with_capacity(points.beams.len()),
        };
        for beam in &points.beams {
            let along = beam.end_in_robot - beam.origin_in_robot;
            let length = if beam.is_hit {
                1.0
            } else {
                (self.config.no_return_clears / beam.range).min(1.0)
            };
            let end = beam.origin_in_robot + along * length;
            keyframe.ends.push([end.x as f32, end.y as f32]);
            keyframe.hits.push(beam.is_hit);
        }
        keyframe
    }
}

fn moved(
    surfaces: &[OrientedPoint],
    to_from_robot: Pose2,
) -> impl Iterator<Item = OrientedPoint> + '_ {
    surfaces.iter().map(move |s| OrientedPoint {
        position: to_from_robot * s.position,
        normal: to_from_robot.rotate(s.normal),
    })
}

impl Keyframe {
    fn draw(&self, grid: &mut Grid, map_from_robot: &Pose2) {
        let beams =
            self.ends
                .iter()
                .zip(&self.hits)
                .enumerate()
                .map(|(beam_idx, (end, &is_hit))| {
                    let end_in_robot = Point2::new(f64::from(end[0]), f64::from(end[1]));
                    Beam {
                        beam_idx,
                        origin_in_robot: self.origin,
                        end_in_robot,
                        range: (end_in_robot - self.origin).norm(),
                        sigma: 0.01,
                        is_hit,
                    }
                });
        let points = Points {
            stamp: Stamp::default(),
            sensor_in_robot: self.origin,
            bearing_sigma: 0.0,
            beams: beams.collect(),
        };
        grid.insert(&points, map_from_robot);
    }
}
