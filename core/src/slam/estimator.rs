//! The methods behind [`super::Slam`], each with the map it fills.

use super::localiser::Localiser;
use super::{Method, PriorMapFit, SlamConfig, SlamError};
use crate::estimation::{EkfSlam, ScanMatcher, SweepSmoother, SweepTiming, UpdateReport};
use crate::features::{LineExtractor, LineFeature};
use crate::geom::{Pose2, PoseEstimate};
use crate::map::{Evidence, Grid};
use crate::points::{Beam, MotionHistory, Points};
use crate::robot::{Odometry, Scan, Stamp};

/// A method and its state.
#[derive(Clone, Debug)]
pub(super) enum Estimator {
    Odometry {
        motion: Option<Odometry>,
        track: Vec<(Stamp, Pose2)>,
        grid: Grid,
    },
    Lines {
        ekf: Box<EkfSlam>,
        extractor: Box<LineExtractor>,
        features: Vec<LineFeature>,
        smoother: SweepSmoother,
        track: Vec<(Stamp, Pose2)>,
        grid: Grid,
    },
    Matching {
        matcher: Box<ScanMatcher>,
        since_scan: Option<Odometry>,
    },
    Known {
        localiser: Localiser,
        extractor: Box<LineExtractor>,
        features: Vec<LineFeature>,
        fit: PriorMapFit,
        track: Vec<(Stamp, Pose2)>,
        grid: Grid,
    },
}

/// A scan, with all that helps to understand it.
#[derive(Clone, Copy, Debug)]
pub(super) struct PreparedScan<'a> {
    pub(super) scan: &'a Scan,
    /// De-skewed by odometry.
    pub(super) points: &'a Points,
    pub(super) history: &'a MotionHistory,
    pub(super) config: &'a SlamConfig,
}

impl PreparedScan<'_> {
    /// Variance of the heading that odometry gathered since each beam of the scan was taken, rad².
    pub(super) fn heading_variances(&self) -> Vec<f64> {
        let (scan, end) = (self.scan, self.scan.stamp.seconds());
        let taken = |beam| Stamp::from_seconds(end - scan.sweep * scan.age_fraction(beam));
        let moved = self.history.since((0..scan.len()).map(taken));
        moved.iter().map(|m| m.heading_variance).collect()
    }

    /// How well the direction of each usable beam is known in the robot's frame of now, by the heading since it was taken
    /// ([`Self::heading_variances`]) and the sensor, rad.
    fn direction_sigmas(&self, heading_variances: &[f64]) -> Vec<f64> {
        let bearing = self.points.bearing_sigma * self.points.bearing_sigma;
        let since = |beam: usize| heading_variances.get(beam).copied().unwrap_or(0.0);
        let sigma = |beam: &Beam| (since(beam.beam_idx) + bearing).sqrt();
        self.points.beams.iter().map(sigma).collect()
    }

    /// What the scan surely says, once the filter has corrected the pose at some instants of it.
    fn evidence(
        &self,
        report: &UpdateReport,
        smoother: &mut SweepSmoother,
        grid: &Grid,
    ) -> Evidence {
        let poses = smoother.smooth(self.scan, &report.fixes, self.history);
        let stamp = self.points.stamp;
        let placed = |beam: usize| {
            poses
                .get(beam)
                .map_or_else(Pose2::identity, |p| p.robot_from_then)
        };
        let points = Points::from_placed_scan(self.scan, stamp, &self.config.points, placed);
        let sigma = |beam: &Beam| {
            let heading = poses.get(beam.beam_idx).map_or(0.0, |p| p.heading_variance);
            (heading + points.bearing_sigma * points.bearing_sigma).sqrt()
        };
        let sigmas: Vec<f64> = points.beams.iter().map(sigma).collect();
        Evidence::certain(&points, &sigmas, grid.resolution(), &self.config.evidence)
    }
}

impl Estimator {
    pub(super) fn new(method: Method, config: &SlamConfig) -> Result<Self, SlamError> {
        Ok(match method {
            Method::Odometry => Self::Odometry {
                motion: None,
                track: vec![],
                grid: Grid::new(config.grid)?,
            },
            Method::LineEkf => {
                config.lines.validate()?;
                Self::Lines {
                    ekf: Box::new(EkfSlam::new(config.ekf)?),
                    extractor: Box::new(LineExtractor::new(config.lines)),
                    features: vec![],
                    smoother: SweepSmoother::default(),
                    track: vec![],
                    grid: Grid::new(config.grid)?,
                }
            }
            Method::ScanMatching => Self::Matching {
                matcher: Box::new(ScanMatcher::new(config.matcher)?),
                since_scan: None,
            },
            Method::PriorMap => Self::in_known_map(config)?,
        })
    }

    fn in_known_map(config: &SlamConfig) -> Result<Self, SlamError> {
        config.lines.validate()?;
        Ok(Self::Known {
            localiser: Localiser::new(config)?,
            extractor: Box::new(LineExtractor::new(config.lines)),
            features: vec![],
            fit: PriorMapFit::default(),
            track: vec![],
            grid: Grid::new(config.grid)?,
        })
    }

    pub(super) fn predict(&mut self, odometry: &Odometry) -> Result<(), SlamError> {
        let then = |so_far: &Option<Odometry>| Some(so_far.map_or(*odometry, |o| o.then(odometry)));
        match self {
            Self::Odometry { motion, .. } => *motion = then(motion),
            Self::Lines { ekf, .. } => ekf.predict(odometry)?,
            Self::Known { localiser, .. } => localiser.predict(odometry)?,
            Self::Matching {
                matcher,
                since_scan,
            } => {
                matcher.odometry(odometry);
                *since_scan = then(since_scan);
            }
        }
        Ok(())
    }

    pub(super) fn reconfigure(&mut self, config: &SlamConfig) {
        match self {
            Self::Lines { ekf, extractor, .. } => {
                **extractor = LineExtractor::new(config.lines);
                ekf.reconfigure(config.ekf);
            }
            Self::Known { extractor, .. } => **extractor = LineExtractor::new(config.lines),
            Self::Odometry { .. } | Self::Matching { .. } => {}
        }
    }

    /// First part of a scan: the lines in it, for a method that uses them.
    pub(super) fn find_lines(&mut self, points: &Points) -> Result<(), SlamError> {
        if let Self::Lines {
            extractor,
            features,
            ..
        }
        | Self::Known {
            extractor,
            features,
            ..
        } = self
        {
            extractor.extract(points, features)?;
        }
        Ok(())
    }

    /// Last part: what the scan shows, for a method that draws it once the pose is known.
    pub(super) fn draw(&mut self, sweep: &PreparedScan) {
        if let Self::Lines {
            ekf,
            smoother,
            track,
            grid,
            ..
        } = self
        {
            let pose = ekf.estimate().pose;
            grid.draw(&sweep.evidence(ekf.report(), smoother, grid), &pose);
            track.push((sweep.points.stamp, pose));
        }
    }

    /// Middle part: the pose, and all of it for methods that draw at once.
    pub(super) fn correct(&mut self, sweep: &PreparedScan) -> Result<(), SlamError> {
        let points = sweep.points;
        match self {
            Self::Odometry {
                grid,
                track,
                motion,
            } => {
                let pose = motion.map_or_else(Pose2::identity, |o| o.motion);
                grid.insert(points, &pose);
                track.push((points.stamp, pose));
            }
            Self::Lines { ekf, features, .. } => {
                ekf.update(features, &SweepTiming::at(points.stamp, sweep.scan))?;
            }
            Self::Known {
                localiser,
                features,
                fit,
                track,
                grid,
                ..
            } => {
                let known = &sweep.config.prior_map;
                let turned = sweep.heading_variances();
                localiser.update(sweep, features, &turned)?;
                let pose = localiser.estimate().pose;
                fit.push(points, &pose, known);
                let (sigmas, config) = (sweep.direction_sigmas(&turned), &sweep.config.evidence);
                let evidence = Evidence::certain(points, &sigmas, grid.resolution(), config);
                grid.draw(&evidence, &pose);
                track.push((points.stamp, pose));
            }
            Self::Matching {
                matcher,
                since_scan,
            } => {
                let sigmas = sweep.direction_sigmas(&sweep.heading_variances());
                matcher.update_swept(points, &sigmas);
                *since_scan = None;
            }
        }
        Ok(())
    }

    pub(super) fn estimate(&self) -> PoseEstimate {
        match self {
            Self::Odometry { motion: None, .. } => PoseEstimate::exact(Pose2::identity()),
            Self::Odometry {
                motion: Some(o), ..
            } => PoseEstimate {
                pose: o.motion,
                cov: o.cov,
            },
            Self::Lines { ekf, .. } => ekf.estimate(),
            Self::Known { localiser, .. } => localiser.estimate(),
            Self::Matching {
                matcher,
                since_scan,
            } => {
                let at_scan = matcher.estimate();
                let Some(since) = since_scan else {
                    return at_scan;
                };
                let map_from_scan = Odometry {
                    from: since.from,
                    to: since.from,
                    motion: at_scan.pose,
                    cov: at_scan.cov,
                };
                let now = map_from_scan.then(since);
                PoseEstimate {
                    pose: now.motion,
                    cov: now.cov,
                }
            }
        }
    }

    pub(super) fn grid(&self) -> &Grid {
        match self {
            Self::Odometry { grid, .. } | Self::Lines { grid, .. } | Self::Known { grid, .. } => {
                grid
            }
            Self::Matching { matcher, .. } => matcher.grid(),
        }
    }

    pub(super) fn trajectory(&self) -> Vec<(Stamp, Pose2)> {
        match self {
            Self::Odometry { track, .. }
            | Self::Lines { track, .. }
            | Self::Known { track, .. } => track.clone(),
            Self::Matching { matcher, .. } => matcher.trajectory().collect(),
        }
    }
}
