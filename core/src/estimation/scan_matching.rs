//! SLAM by matching scans to submaps: for lidars in real buildings.
//!
//! In: odometry and scans. Out: the pose with its covariance, the trajectory, the grid.
//!
//! 1. Odometry since the last scan says where to look; the scan's oriented points are matched to the running submap
//!    ([`match_to_surfels`]), with odometry's own covariance as the prior.
//! 2. After some way or turn the scan becomes a keyframe: it is added to the submap and drawn into the grid.
//! 3. After some keyframes the submap is closed and a new one begun, seeded with the last keyframes, so that there is
//!    always a map to match to. Poses are kept relative to their submap: moving a submap moves all that was seen in it.
//! 4. A closed submap is compared with earlier ones that may show the same place, one at each scan. Those that do are
//!    joined by an edge, and the poses of all submaps are optimised ([`PoseGraph`]).
//! 5. Where the map moved, it is drawn anew beside the old one, some keyframes at each scan, and takes its place when
//!    it is complete: no scan has to wait for it.

use std::collections::VecDeque;

use nalgebra::{Matrix3, Point2, Vector3};

use super::pose_graph::{Edge, Kernel, PoseGraph, differs, information_at_end};
use super::submap::{ClosedSubmap, ClosureConfig, Doubt};
use crate::geom::{Pose2, PoseEstimate, symmetrize};
use crate::map::{Grid, GridConfig, GridError, LikelihoodPyramid, SurfelConfig, SurfelMap};
use crate::points::{Beam, OrientedConfig, OrientedPoint, Points, oriented_points};
use crate::registration::{
    MatchConfig, Prior, Registration, SearchWindow, Verdict, match_to_surfels, search,
};
use crate::robot::{Odometry, Stamp};

/// How scan matching works.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanMatcherConfig {
    /// How surfaces are found in it.
    pub oriented: OrientedConfig,
    /// How submaps are kept.
    pub surfels: SurfelConfig,
    /// How scans are matched to them.
    pub matching: MatchConfig,
    /// The map that is drawn. By default a crossing beam counts for more than elsewhere (`miss` 0.3): keyframes are few,
    /// and what one of them saw through is to be free.
    pub grid: GridConfig,
    /// A scan becomes a keyframe after this way, m. Default 0.25.
    pub keyframe_distance: f64,
    /// A scan becomes a keyframe after this turn, rad. Default 0.2.
    pub keyframe_turn: f64,
    /// A scan of which a smaller part than this lies on the map becomes a keyframe after three tenths of that way and turn.
    /// Default 0.6.
    pub new_below: f64,
    /// Where a smaller part of a scan than this lies on the map, odometry is doubted and the pose is searched for.
    /// Default 0.55.
    pub lost_below: f64,
    /// How far. Default 0.6 m and 0.2 rad.
    pub lost_window: SearchWindow,
    /// Keyframes of one submap, those of the overlap not counted. Default 15; larger drifts more inside, smaller makes
    /// more work.
    pub submap_keyframes: usize,
    /// Keyframes that the next submap takes over from the last. Default 15.
    pub overlap_keyframes: usize,
    /// When two submaps are one place.
    pub closure: ClosureConfig,
    /// Whether loops are closed. Default true.
    pub close_loops: bool,
    /// Keyframes that are drawn anew at each scan after a loop closure, at least. Default 3.
    pub redraw_keyframes: usize,
    /// The map is drawn anew when a submap has moved by this, m. Default 0.1; at the end, by a fifth of it.
    pub redraw_shift: f64,
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
            oriented: OrientedConfig::default(),
            surfels: SurfelConfig::default(),
            matching: MatchConfig::default(),
            grid: GridConfig {
                miss: 0.3,
                ..GridConfig::default()
            },
            keyframe_distance: 0.25,
            keyframe_turn: 0.2,
            new_below: 0.6,
            lost_below: 0.55,
            lost_window: SearchWindow {
                shift: 0.6,
                turn: 0.2,
            },
            submap_keyframes: 15,
            overlap_keyframes: 15,
            closure: ClosureConfig::default(),
            close_loops: true,
            redraw_keyframes: 3,
            redraw_shift: 0.1,
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
    pending: Option<Odometry>,
    submaps: Vec<Submap>,
    running: SurfelMap,
    submap_from_robot: Pose2,
    local_cov: Matrix3<f64>,
    recent: VecDeque<Recent>,
    keyframes: Vec<Keyframe>,
    last_keyframe: Option<Pose2>,
    track: Vec<TrackPoint>,
    grid: Grid,
    grid_version: u64,
    redraw: Option<Redraw>,
    graph: PoseGraph,
    /// Covariance of the way through the running submap, so far.
    way_cov: Matrix3<f64>,
    /// Covariance of the running submap in the map.
    submap_cov: Matrix3<f64>,
    /// Pairs of submaps, the older first, yet to be compared.
    jobs: VecDeque<(usize, usize)>,
    closures: usize,
    graph_changed: bool,
}

/// A stretch of the way with its own map.
#[derive(Clone, Debug)]
struct Submap {
    map_from_submap: Pose2,
    /// Where it lies in the grid that is drawn, or being drawn.
    drawn_at: Pose2,
    /// Keyframes of its own, overlap not counted.
    own_keyframes: usize,
    closed: ClosedSubmap,
}

/// A grid in the making.
#[derive(Clone, Debug)]
struct Redraw {
    grid: Grid,
    next: usize,
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
        let mut graph = PoseGraph::default();
        graph.add_pose(Pose2::identity());
        Ok(Self {
            graph,
            grid_version: 0,
            redraw: None,
            way_cov: Matrix3::zeros(),
            submap_cov: Matrix3::zeros(),
            jobs: VecDeque::new(),
            closures: 0,
            graph_changed: false,
            pending: None,
            submaps: vec![Submap::begun_at(Pose2::identity())],
            running: SurfelMap::new(config.surfels),
            submap_from_robot: Pose2::identity(),
            local_cov: Matrix3::zeros(),
            recent: VecDeque::new(),
            keyframes: vec![],
            last_keyframe: None,
            track: vec![],
            grid: Grid::new(config.grid)?,
            config,
        })
    }

    /// Takes the motion since the last call. Readings come in order of time.
    pub fn odometry(&mut self, odometry: &Odometry) {
        self.pending = Some(match self.pending {
            Some(so_far) => so_far.then(odometry),
            None => *odometry,
        });
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
            let found = self.match_running(&surfaces, &predicted, &prior);
            self.local_cov = found.estimate.cov;
            self.submap_from_robot = match found.verdict {
                Verdict::TooFewPoints { .. } => predicted,
                _ => found.estimate.pose,
            };
            Some(found)
        };
        let keyframe = self.is_new_place(registration.map_or(1.0, |r| r.overlap));
        if keyframe {
            self.add_keyframe(points, surfaces);
        }
        self.track.push(TrackPoint {
            stamp: points.stamp,
            submap: self.submaps.len() - 1,
            submap_from_robot: self.submap_from_robot,
        });
        self.work_off(1);
        MatchReport {
            registration,
            keyframe,
        }
    }

    /// Completes all work that was put off.
    pub fn finish(&mut self) {
        self.work_off(usize::MAX);
    }

    /// The pose in the map, with its covariance.
    #[must_use]
    pub fn estimate(&self) -> PoseEstimate {
        let map_from_submap = self.map_from_running();
        let (cos, sin) = map_from_submap.cos_sin();
        let turned = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        let local = turned * (self.local_cov + self.way_cov) * turned.transpose();
        // The submap's error turns what lies ahead of its origin.
        let ahead = map_from_submap.rotate(self.submap_from_robot.position().coords);
        let carry = Matrix3::new(1.0, 0.0, -ahead.y, 0.0, 1.0, ahead.x, 0.0, 0.0, 1.0);
        let mut cov = carry * self.submap_cov * carry.transpose() + local;
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
        self.closures
    }

    /// Grows by one whenever the grid was drawn anew: what was shown of the old one is void then.
    #[must_use]
    pub fn grid_version(&self) -> u64 {
        self.grid_version
    }

    /// The submaps' poses and the motions between them.
    #[must_use]
    pub fn graph(&self) -> &PoseGraph {
        &self.graph
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

    /// Matches to the running submap; where too little fits, looks around for a pose that fits better: odometry may
    /// have slipped.
    fn match_running(
        &self,
        surfaces: &[OrientedPoint],
        predicted: &Pose2,
        prior: &Prior,
    ) -> Registration {
        let config = &self.config;
        let found = match_to_surfels(surfaces, &self.running, predicted, prior, &config.matching);
        if found.overlap >= config.lost_below {
            return found;
        }
        let places = self.running.surfels().iter().map(|s| s.position);
        let points: Vec<_> = surfaces.iter().map(|s| s.position).collect();
        let candidate = LikelihoodPyramid::new(places, 0.05, 0.05, 5)
            .and_then(|map| search(&points, &map, predicted, &config.lost_window, 0.2));
        let Some(candidate) = candidate else {
            return found;
        };
        let weak = Prior {
            pose: candidate.pose,
            information: prior.information * 0.01,
        };
        let again = match_to_surfels(
            surfaces,
            &self.running,
            &candidate.pose,
            &weak,
            &config.matching,
        );
        if again.overlap > found.overlap + 0.1 && again.inliers >= config.matching.min_points {
            again
        } else {
            found
        }
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

    /// Where little of the scan is known already, as behind a door, the map must grow sooner.
    fn is_new_place(&self, overlap: f64) -> bool {
        let part = if overlap < self.config.new_below {
            0.3
        } else {
            1.0
        };
        self.last_keyframe.is_none_or(|last| {
            let moved = last.delta_to(&self.submap_from_robot);
            moved.position().coords.norm() > part * self.config.keyframe_distance
                || moved.heading().abs() > part * self.config.keyframe_turn
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
        self.way_cov += self.local_cov;
        if let Some(submap) = self.submaps.last_mut() {
            submap.own_keyframes += 1;
        }
    }

    fn begin_submap(&mut self) {
        let old_from_new = self.submap_from_robot;
        let map_from_submap = self.map_from_running() * old_from_new;
        let new_from_old = old_from_new.inverse();
        let begun = SurfelMap::new(self.config.surfels);
        let surfels = std::mem::replace(&mut self.running, begun).into_surfels();
        for recent in &mut self.recent {
            recent.submap_from_robot = new_from_old * recent.submap_from_robot;
            self.running
                .insert(moved(&recent.surfaces, recent.submap_from_robot));
        }
        let old = self.submaps.len() - 1;
        let own = self.keyframes.iter().rev().take_while(|k| k.submap == old);
        let closed = ClosedSubmap::new(surfels, own.flat_map(Keyframe::rays));
        if let Some(submap) = self.submaps.last_mut() {
            submap.closed = closed;
        }
        self.join_to_next(old, &old_from_new, map_from_submap);
        self.submaps.push(Submap::begun_at(map_from_submap));
        self.submap_from_robot = Pose2::identity();
        if self.config.close_loops {
            self.plan_comparisons(old);
        }
    }

    /// The edge from a submap to the one that follows it.
    fn join_to_next(&mut self, old: usize, old_from_new: &Pose2, map_from_new: Pose2) {
        let floor = Matrix3::from_diagonal(&Vector3::new(1e-4, 1e-4, 2.5e-5));
        let cov = self.way_cov + floor;
        let information = cov.try_inverse().unwrap_or_else(Matrix3::identity);
        let new = self.graph.add_pose(map_from_new);
        // Both ends exist, and a match that is not finite was never accepted.
        let _ = self.graph.add_edge(Edge {
            from: old,
            to: new,
            motion: *old_from_new,
            information: information_at_end(old_from_new, &information),
            kernel: Kernel::None,
        });
        let (cos, sin) = self.map_from_running().cos_sin();
        let turned = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        let from = self.map_from_running().position();
        let ahead = map_from_new.position() - from;
        let carry = Matrix3::new(1.0, 0.0, -ahead.y, 0.0, 1.0, ahead.x, 0.0, 0.0, 1.0);
        self.submap_cov =
            carry * self.submap_cov * carry.transpose() + turned * cov * turned.transpose();
        symmetrize(&mut self.submap_cov);
        self.way_cov = Matrix3::zeros();
    }

    /// Lists the earlier submaps that may show the same place as submap `new`, nearest first.
    fn plan_comparisons(&mut self, new: usize) {
        let doubts = self.doubts(new);
        let Some(this) = self.submaps.get(new) else {
            return;
        };
        let centre = this.map_from_submap * this.closed.centre;
        let mut near: Vec<(f64, usize)> = self
            .submaps
            .iter()
            .zip(&doubts)
            .enumerate()
            .take(new.saturating_sub(1))
            .filter_map(|(old, (submap, doubt))| {
                let distance = (submap.map_from_submap * submap.closed.centre - centre).norm();
                let reach = submap.closed.radius.max(this.closed.radius)
                    + (3.0 * doubt.shift).min(self.config.closure.max_shift);
                (distance < reach && !self.are_joined(old, new)).then_some((distance, old))
            })
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let chosen = near.into_iter().take(self.config.closure.candidates);
        self.jobs.extend(chosen.map(|(_, old)| (old, new)));
    }

    fn are_joined(&self, a: usize, b: usize) -> bool {
        self.graph
            .edges()
            .iter()
            .any(|e| (e.from == a && e.to == b) || (e.from == b && e.to == a))
    }

    /// How well each submap's pose is known relative to submap `from`: along the best way through the graph.
    fn doubts(&self, from: usize) -> Vec<Doubt> {
        let poses = self.graph.poses();
        let mut ways: Vec<Vec<(usize, f64, f64)>> = vec![vec![]; poses.len()];
        for edge in self.graph.edges() {
            let Some(cov) = edge.information.try_inverse() else {
                continue;
            };
            let (shift, turn) = (0.5 * (cov[(0, 0)] + cov[(1, 1)]), cov[(2, 2)]);
            ways[edge.from].push((edge.to, shift, turn));
            ways[edge.to].push((edge.from, shift, turn));
        }
        let mut known = vec![(f64::INFINITY, f64::INFINITY); poses.len()];
        let mut done = vec![false; poses.len()];
        let Some(here) = poses.get(from).map(Pose2::position) else {
            return vec![];
        };
        known[from] = (0.0, 0.0);
        // Dijkstra without a heap: a few hundred submaps.
        while let Some(at) = (0..poses.len())
            .filter(|&i| !done[i] && known[i].0.is_finite())
            .min_by(|&a, &b| known[a].0.total_cmp(&known[b].0))
        {
            done[at] = true;
            for &(next, shift, turn) in &ways[at] {
                // An error of the heading here moves all that lies at a distance.
                let lever = (poses[at].position() - here).norm_squared();
                let way = known[at].0 + shift + turn * lever;
                if way < known[next].0 {
                    known[next] = (way, known[at].1 + turn);
                }
            }
        }
        known
            .into_iter()
            .map(|(s, t)| Doubt {
                shift: s.sqrt(),
                turn: t.sqrt(),
            })
            .collect()
    }

    /// Compares up to `count` pairs of submaps; then optimises, if something was found, and goes on with drawing.
    fn work_off(&mut self, count: usize) {
        for _ in 0..count {
            let Some((old, new)) = self.jobs.pop_front() else {
                break;
            };
            self.compare(old, new);
            if self.jobs.front().is_none_or(|next| next.1 != new) && self.graph_changed {
                self.optimize();
            }
        }
        let budget = match count {
            usize::MAX => count,
            _ => self.config.redraw_keyframes.max(self.keyframes.len() / 500),
        };
        let shift = self.config.redraw_shift;
        if self.redraw.is_none() {
            self.begin_redraw(shift);
        }
        self.draw_on(budget);
        if count == usize::MAX {
            // What moved since the drawing began.
            self.begin_redraw(0.2 * shift);
            self.draw_on(budget);
        }
    }

    fn compare(&mut self, old: usize, new: usize) {
        let doubts = self.doubts(new);
        let (Some(a), Some(b), Some(doubt)) = (
            self.submaps.get(old),
            self.submaps.get(new),
            doubts.get(old),
        ) else {
            return;
        };
        let guess = a.map_from_submap.delta_to(&b.map_from_submap);
        let found = a.closed.find(
            &b.closed,
            &guess,
            doubt,
            &self.config.surfels,
            &self.config.matching,
            &self.config.closure,
        );
        let Some(closure) = found else { return };
        let added = self.graph.add_edge(Edge {
            from: old,
            to: new,
            motion: closure.motion,
            information: closure.information,
            kernel: Kernel::Cauchy { c: 3.0 },
        });
        if added.is_ok() {
            self.closures += 1;
            self.graph_changed = true;
        }
    }

    fn optimize(&mut self) {
        self.graph_changed = false;
        self.graph.optimize(30);
        for (submap, pose) in self.submaps.iter_mut().zip(self.graph.poses()) {
            submap.map_from_submap = *pose;
        }
        if let Some(cov) = self.graph.marginal(self.submaps.len() - 1) {
            self.submap_cov = cov;
        }
    }

    /// Begins to draw the map anew if the submaps have moved since it was drawn.
    fn begin_redraw(&mut self, shift: f64) {
        let moved = self
            .submaps
            .iter()
            .any(|s| differs(&s.map_from_submap, &s.drawn_at, shift, 0.1 * shift));
        if moved && let Ok(grid) = Grid::new(self.config.grid) {
            for submap in &mut self.submaps {
                submap.drawn_at = submap.map_from_submap;
            }
            self.redraw = Some(Redraw { grid, next: 0 });
        }
    }

    fn draw_on(&mut self, budget: usize) {
        let Some(redraw) = &mut self.redraw else {
            return;
        };
        for keyframe in self.keyframes.iter().skip(redraw.next).take(budget) {
            if let Some(submap) = self.submaps.get(keyframe.submap) {
                keyframe.draw(
                    &mut redraw.grid,
                    &(submap.drawn_at * keyframe.submap_from_robot),
                );
            }
            redraw.next += 1;
        }
        if redraw.next >= self.keyframes.len()
            && let Some(redraw) = self.redraw.take()
        {
            self.grid = redraw.grid;
            self.grid_version += 1;
        }
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

impl Submap {
    fn begun_at(map_from_submap: Pose2) -> Self {
        Self {
            map_from_submap,
            drawn_at: map_from_submap,
            own_keyframes: 0,
            closed: ClosedSubmap::default(),
        }
    }
}

impl Keyframe {
    /// The beams, from the sensor to their ends, in the submap.
    fn rays(&self) -> impl Iterator<Item = (Point2<f64>, Point2<f64>)> + '_ {
        let at = self.submap_from_robot;
        self.ends.iter().map(move |end| {
            let end = Point2::new(f64::from(end[0]), f64::from(end[1]));
            (at * self.origin, at * end)
        })
    }

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

#[cfg(test)]
mod tests {
    use rand::{Rng, RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::geom::{Segment, sin_cos, wrap};
    use crate::map::CellState;
    use crate::points::PointConfig;
    use crate::robot::Scan;

    /// A ring of corridors, 2 m wide, around a block of 8 m x 6 m, with niches that tell its sides apart.
    fn ring() -> Vec<Segment> {
        let rectangle = |x0: f64, y0: f64, x1: f64, y1: f64| {
            let c = [(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)];
            c.windows(2)
                .map(|w| Segment::new(Point2::new(w[0].0, w[0].1), Point2::new(w[1].0, w[1].1)))
                .collect::<Vec<_>>()
        };
        let mut walls = rectangle(-6.0, -5.0, 6.0, 5.0);
        walls.extend(rectangle(-4.0, -3.0, 4.0, 3.0));
        for (x, y, w, h) in [
            (-2.0, -5.0, 0.8, 0.4),
            (1.5, -5.0, 0.4, 0.5),
            (5.5, -1.0, 0.5, 0.6),
            (5.6, 2.0, 0.4, 0.4),
            (-1.0, 4.6, 1.2, 0.4),
            (2.8, 4.7, 0.3, 0.3),
            (-6.0, 0.5, 0.5, 0.9),
            (-6.0, -2.5, 0.4, 0.3),
        ] {
            walls.extend(rectangle(x, y, x + w, y + h));
        }
        walls
    }

    /// A normal deviate by Box and Muller.
    fn normal(rng: &mut impl Rng) -> f64 {
        let (u, v): (f64, f64) = (rng.random(), rng.random());
        (-2.0 * libm::log(1.0 - u)).sqrt() * libm::cos(std::f64::consts::TAU * v)
    }

    fn points_of(scan: &Scan) -> Points {
        Points::from_scan(scan, &Pose2::identity(), &PointConfig::default())
    }

    fn scan_at(walls: &[Segment], pose: &Pose2, stamp: Stamp, rng: &mut impl Rng) -> Scan {
        let bearings: Vec<f64> = (0..180)
            .map(|i| (f64::from(i) - 90.0).to_radians())
            .collect();
        let ranges = bearings
            .iter()
            .map(|&b| {
                let (sin, cos) = sin_cos(pose.heading() + b);
                let direction = nalgebra::Vector2::new(cos, sin);
                let hits = walls
                    .iter()
                    .filter_map(|w| w.hit_by_ray(pose.position(), direction));
                (hits.fold(f64::INFINITY, f64::min) + 0.01 * normal(rng)) as f32
            })
            .collect::<Vec<f32>>();
        Scan {
            stamp,
            robot_from_sensor: Pose2::identity(),
            sigmas: vec![0.01; bearings.len()],
            bearings,
            ranges,
            bearing_sigma: 0.0,
            max_range: 20.0,
            sweep: 0.0,
        }
    }

    /// Twice around the ring at 0.1 m and 6° a scan, with odometry that turns 3 % too far and slips: the true poses
    /// and the matcher.
    fn run(config: ScanMatcherConfig, seed: u64) -> (Vec<Pose2>, Pose2, ScanMatcher) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let walls = ring();
        let mut matcher = ScanMatcher::new(config).unwrap();
        let corners = [(5.0, -4.0), (5.0, 4.0), (-5.0, 4.0), (-5.0, -4.0)];
        let mut pose = Pose2::new(-5.0, -4.0, 0.0);
        let start = pose;
        let (mut truth, mut odometry) = (vec![], Pose2::identity());
        let mut stamp = Stamp(0);
        let mut visit = |pose: &Pose2, motion: Pose2, rng: &mut ChaCha8Rng| {
            let from = stamp;
            stamp = Stamp(stamp.0 + 200_000);
            let measured = Pose2::new(
                motion.x() * 1.02 + 0.003 * normal(rng),
                0.002 * normal(rng),
                motion.heading() * 1.03 + 0.004 * normal(rng),
            );
            odometry = odometry * measured;
            matcher.odometry(&Odometry {
                from,
                to: stamp,
                motion: measured,
                cov: Matrix3::from_diagonal(&Vector3::new(1e-4, 1e-4, 1e-4)),
            });
            matcher.update(&points_of(&scan_at(&walls, pose, stamp, rng)));
            truth.push(start.delta_to(pose));
        };
        visit(&pose, Pose2::identity(), &mut rng);
        for corner in corners.iter().chain(&corners) {
            let to = Point2::new(corner.0, corner.1);
            loop {
                let ahead = pose.inverse() * to;
                let bearing = libm::atan2(ahead.y, ahead.x);
                let motion = if ahead.coords.norm() < 0.06 {
                    break;
                } else if bearing.abs() > 0.01 {
                    Pose2::new(0.0, 0.0, bearing.clamp(-0.1, 0.1))
                } else {
                    Pose2::new(ahead.x.min(0.1), 0.0, 0.0)
                };
                pose = pose * motion;
                visit(&pose, motion, &mut rng);
            }
        }
        matcher.finish();
        (truth, odometry, matcher)
    }

    #[test]
    fn two_laps_of_a_ring_come_back_to_where_they_were() {
        for seed in 0..3 {
            let (truth, odometry, matcher) = run(ScanMatcherConfig::default(), seed);
            let last = truth.last().unwrap();
            let odometry_error = (odometry.position() - last.position()).norm();
            assert!(
                odometry_error > 0.5,
                "the test is too easy: {odometry_error}"
            );
            let poses: Vec<_> = matcher.trajectory().map(|(_, pose)| pose).collect();
            assert_eq!(poses.len(), truth.len());
            for (found, truth) in poses.iter().zip(&truth) {
                assert!(
                    (found.position() - truth.position()).norm() < 0.10,
                    "{found:?} {truth:?}"
                );
                assert!(wrap(found.heading() - truth.heading()).abs() < 0.03);
            }
            assert!(matcher.loop_closures() > 0);
            let estimate = matcher.estimate();
            assert_eq!(estimate.pose, *poses.last().unwrap());
            assert!(estimate.cov.cholesky().is_some());
        }
    }

    #[test]
    fn the_map_shows_walls_once_and_the_corridor_free() {
        let (_, _, matcher) = run(ScanMatcherConfig::default(), 5);
        let map_from_world = Pose2::new(-5.0, -4.0, 0.0).inverse();
        let grid = matcher.grid();
        let state = |x: f64, y: f64| grid.state(grid.cell_at(map_from_world * Point2::new(x, y)));
        for x in [-3.5, 0.7, 3.0] {
            assert_eq!(state(x, -4.0), CellState::Free);
            let occupied = |y: f64| state(x, y) == CellState::Occupied;
            let thickness = (-30..30)
                .filter(|i| occupied(-3.0 + f64::from(*i) * 0.02))
                .count();
            assert!(
                (1..12).contains(&thickness),
                "{thickness} steps of 2 cm at {x}"
            );
        }
    }

    #[test]
    fn the_same_input_gives_the_same_bits() {
        let hash = |matcher: &ScanMatcher| {
            let mut hash = crate::hash::StateHash::new();
            for (_, pose) in matcher.trajectory() {
                hash.pose(&pose);
            }
            hash.finish()
        };
        let (a, b) = (
            run(ScanMatcherConfig::default(), 9).2,
            run(ScanMatcherConfig::default(), 9).2,
        );
        assert_eq!(hash(&a), hash(&b));
        assert_ne!(hash(&a), hash(&run(ScanMatcherConfig::default(), 10).2));
    }

    #[test]
    fn scans_without_a_return_leave_odometry_to_itself() {
        let mut matcher = ScanMatcher::new(ScanMatcherConfig::default()).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for i in 0..20 {
            let stamp = Stamp((i + 1) * 100_000);
            matcher.odometry(&Odometry {
                from: Stamp(i * 100_000),
                to: stamp,
                motion: Pose2::new(0.1, 0.0, 0.0),
                cov: Matrix3::identity() * 1e-4,
            });
            matcher.update(&points_of(&scan_at(
                &[],
                &Pose2::identity(),
                stamp,
                &mut rng,
            )));
        }
        assert!((matcher.estimate().pose.x() - 2.0).abs() < 1e-9);
    }

    #[test]
    fn bad_configuration_is_named() {
        let config = ScanMatcherConfig {
            keyframe_turn: f64::NAN,
            ..ScanMatcherConfig::default()
        };
        let error = ScanMatcher::new(config).unwrap_err().to_string();
        assert_eq!(
            error,
            "scan matching: keyframe_turn is NaN, expected from 0.01 to 3.2 rad"
        );
    }
}
