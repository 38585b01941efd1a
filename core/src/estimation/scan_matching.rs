//! SLAM by matching scans to submaps, for lidars in real buildings.
//!
//! In: odometry and scans. Out: the pose with its covariance, the trajectory, the grid. Scans of
//! few beams are first gathered over a stretch of motion (`gathering`).
//!
//! 1. Several candidate motions since the last scan are tried (`guesses`), odometry's first. The
//!    scan's oriented points are matched to the running submap from each, and the motion that fits
//!    and is plausible is taken (`tracking`). Along a direction that the scan does not constrain,
//!    such as that of a corridor, only odometry counts, and its covariance grows until a scan
//!    constrains the direction again. The odometry errors of this robot are learned from reliable
//!    matches (`motion`).
//! 2. After some distance or rotation the scan becomes a keyframe: it is added to the submap and
//!    drawn into the grid (`keyframes`). Sweeps in between sharpen the walls that the submap has.
//! 3. After some keyframes the submap is closed and a new one begun, seeded with the last
//!    keyframes, so there is always a map to match to. A scan that may equally well lie elsewhere,
//!    or that contradicts the submap, begins a submap that is not seeded and is joined loosely.
//!    Poses are kept relative to their submap: moving a submap moves all that was seen in it.
//! 4. A closed submap is compared with earlier ones that may show the same place, one at each scan.
//!    Pairs that surely do, together with others that prove it, are joined by an edge (`closures`),
//!    and the poses of all submaps are optimised ([`PoseGraph`]). Closures that then tear the
//!    trajectory are removed again (`revocation`).
//! 5. Keyframes that drifted within their submap are moved to where the submaps joined to it by
//!    closures have them (`refinement`).
//! 6. Where the map moved, it is redrawn beside the old one, some keyframes at each scan, and
//!    replaces it when complete: no scan has to wait for it.

mod adrift;
mod as_left;
mod canvas;
mod closures;
mod companions;
mod config;
mod drift;
mod edits;
mod gathering;
mod going_on;
mod guesses;
mod keyframes;
mod landmarks;
mod local;
mod loops;
mod loops_closed;
mod merging;
mod motion;
mod odometry_watch;
mod pruning;
mod quality;
mod records;
mod refinement;
mod removal;
mod renumber;
mod revocation;
mod saved;
mod seen;
mod shown;
#[cfg(test)]
mod tests;
mod tracking;

use std::collections::{BTreeMap, VecDeque};

use nalgebra::{Matrix3, Vector2};

use self::canvas::{Keyframe, Redraw};
use self::closures::{Candidate, Waiting};
use self::drift::Drift;
use self::edits::Edit;
use self::gathering::Gathering;
use self::going_on::Piece;
use self::motion::Motion;
use self::odometry_watch::Believed;
use self::records::Records;
use self::refinement::Unrefined;
use self::removal::Removal;
use self::seen::Seen;
use super::free_space::FreeSpace;
use super::innovation::ScanFit;
use super::pose_graph::{EdgeId, PoseGraph};
use super::submap::{ClosedSubmap, Indexes};
use crate::geom::{Pose2, PoseEstimate, symmetrize};
use crate::map::{Grid, SurfelMap};
use crate::points::{OrientedPoint, Points};
use crate::robot::{Odometry, Stamp};

pub use self::closures::Proof;
pub use self::config::{ScanMatcherConfig, ScanMatcherError};
pub use self::edits::{EditError, EditKind, ShownEdit};
pub use self::going_on::Start;
pub use self::landmarks::MapLandmark;
pub use self::loops_closed::LoopsClosed;
pub use self::merging::{MapMergeError, MergedMaps};
pub use self::pruning::Pruned;
pub use self::records::{ClosureFate, ClosureRecord, Delay, Refusal};
pub use self::removal::RemovalError;
pub use self::saved::{RestoreError, SavedMap};
pub use self::shown::{Join, Residual, ShownSubmap};

/// SLAM by scan matching.
#[derive(Clone, Debug)]
pub struct ScanMatcher {
    config: ScanMatcherConfig,
    pending: Option<Odometry>,
    submaps: Vec<Submap>,
    running: SurfelMap,
    /// Space that the beams of the running submap passed through.
    running_free: FreeSpace,
    /// The pose in the running submap, with its covariance since the last keyframe: from the last
    /// match, or from odometry where the match gave no information.
    local: PoseEstimate,
    /// Whether the last scan could not be matched, so the pose comes from odometry alone.
    is_blind: bool,
    /// How well the last scan fits; `None` if it was not matched, or has only been gathered so far.
    last_fit: Option<ScanFit>,
    motion: Motion,
    gathering: Gathering,
    recent: VecDeque<Recent>,
    keyframes: Vec<Keyframe>,
    last_keyframe: Option<Pose2>,
    trajectory: Vec<TrackPoint>,
    grid: Grid,
    grid_version: u64,
    redraw: Option<Redraw>,
    graph: PoseGraph,
    /// Covariance of the motion through the running submap so far.
    way_cov: Matrix3<f64>,
    /// Covariance of the running submap in the map.
    submap_cov: Matrix3<f64>,
    /// Pairs of submaps still to be compared, the older one first.
    jobs: VecDeque<(usize, usize)>,
    closures: usize,
    waiting: Waiting,
    /// Closures accepted since the graph was last optimised.
    newest: Vec<(EdgeId, Candidate)>,
    records: Records,
    /// Closed submaps whose keyframes may still be refined.
    unrefined: VecDeque<Unrefined>,
    /// The farthest that a keyframe was moved within its submap since the map was drawn, m;
    /// rotations are converted by `redraw_turn`.
    moved_within: f64,
    /// How often submaps, or keyframes within one, were moved.
    moves: u64,
    /// Indexes of the submaps that were compared last.
    indexes: Indexes,
    /// The doubt, m, with which each pair of submaps was compared.
    compared: BTreeMap<(usize, usize), f64>,
    /// The submap that closed the last loop.
    last_closed: usize,
    drift: Drift,
    graph_changed: bool,
    /// Added to the stamps of this run, µs, so that they follow those of earlier runs; `None` until
    /// the first scan.
    stamp_shift: Option<u64>,
    /// Whether a run goes on in a saved map and has not seen anything yet.
    is_new_run: bool,
    /// What was mapped since the run began, while its place in the map is unknown.
    unplaced: Option<Piece>,
    /// What a person has changed on the map.
    edits: Vec<Edit>,
    /// Removals that can be undone, the latest last.
    removals: Vec<Removal>,
}

/// A stretch of the trajectory with its own map.
#[derive(Clone, Debug)]
struct Submap {
    map_from_submap: Pose2,
    /// Where it lies in the grid that is drawn or being drawn.
    drawn_at: Pose2,
    /// Its own keyframes, not counting the overlap.
    own_keyframes: usize,
    /// Whether it took nothing over from the submap before.
    is_loose: bool,
    closed: ClosedSubmap,
}

/// A keyframe whose surfaces may still seed the next submap.
#[derive(Clone, Debug)]
struct Recent {
    submap_from_robot: Pose2,
    surfaces: Vec<OrientedPoint>,
}

#[derive(Clone, Copy, Debug)]
struct TrackPoint {
    stamp: Stamp,
    submap: usize,
    submap_from_robot: Pose2,
}

impl ScanMatcher {
    /// Starts at the origin of the map.
    ///
    /// # Errors   [`ScanMatcherError`], naming the first field out of range.
    pub fn new(config: ScanMatcherConfig) -> Result<Self, ScanMatcherError> {
        config.validate()?;
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
            waiting: Waiting::default(),
            newest: vec![],
            records: Records::default(),
            unrefined: VecDeque::new(),
            moved_within: 0.0,
            moves: 0,
            indexes: Indexes::default(),
            compared: BTreeMap::new(),
            last_closed: 0,
            drift: Drift::default(),
            motion: Motion::default(),
            gathering: Gathering::default(),
            graph_changed: false,
            stamp_shift: Some(0),
            is_new_run: false,
            unplaced: None,
            edits: vec![],
            removals: vec![],
            pending: None,
            submaps: vec![Submap::begun_at(Pose2::identity(), false)],
            running: SurfelMap::new(config.surfels),
            running_free: FreeSpace::default(),
            local: PoseEstimate::exact(Pose2::identity()),
            is_blind: false,
            last_fit: None,
            recent: VecDeque::new(),
            keyframes: vec![],
            last_keyframe: None,
            trajectory: vec![],
            grid: Grid::new(config.grid)?,
            config,
        })
    }

    /// Takes the motion since the last call. Readings must come in order of time.
    pub fn odometry(&mut self, odometry: &Odometry) {
        self.pending = Some(match self.pending {
            Some(so_far) => so_far.then(odometry),
            None => *odometry,
        });
    }

    /// Takes the points of a scan, in the robot frame at the end of the newest odometry. `sigmas`
    /// are the standard deviations of each beam's direction in that frame, rad, in the order of
    /// `points.beams`: the earlier a beam was taken, the less certain its direction.
    pub fn update(&mut self, points: &Points, sigmas: &[f64]) {
        self.last_fit = None;
        let points = &*self.in_order(points);
        let pending = self.pending.take();
        let moved = pending.map(|moved| self.motion.moved(moved));
        if !self.gathering.is_sparse(points) {
            // The beams of a sweep were gathered without knowledge of the odometry bias.
            let motion = pending.map_or_else(Pose2::identity, |moved| moved.motion);
            let seen = Seen::scan(points, sigmas, motion, self.seconds_until(points.stamp));
            let here = self.local.pose;
            let believed = moved.map_or(Believed::Failed(None), |moved| {
                self.motion.believed(moved, &here, points.stamp)
            });
            self.place(seen, &believed);
        } else {
            self.gathering.push(points, sigmas, moved);
            self.note_place(points.stamp, self.local.pose * self.gathering.here());
            if self.gathering.is_enough() {
                self.place_gathered();
            }
        }
        self.work_off();
    }

    /// Places what was gathered from scans of few beams, and those scans with it.
    fn place_gathered(&mut self) {
        let Some(complete) = self.gathering.take() else {
            return;
        };
        // Where the scans were by odometry alone, including the last one.
        let gathered = complete.places.len() + 1;
        self.trajectory
            .truncate(self.trajectory.len().saturating_sub(gathered));
        let (seen, moved) = (complete.seen, complete.moved);
        self.place(seen, &Believed::from(moved));
        let Some(end) = self.trajectory.pop() else {
            return;
        };
        for (stamp, end_from_robot) in complete.places {
            self.note_place(stamp, self.local.pose * end_from_robot);
        }
        self.trajectory.push(end);
    }

    /// Places what was seen; `moved` is the believed odometry since the last time.
    fn place(&mut self, mut seen: Seen, moved: &Believed) {
        let stamp = seen.points.stamp;
        let mut tracked = self.track(&mut seen, moved, stamp);
        if std::mem::take(&mut self.is_new_run) && !self.begins_here(&seen, &tracked) {
            self.begin_piece();
            tracked = self.track(&mut seen, moved, stamp);
        }
        if tracked.is_counted && tracked.is_sure {
            self.motion.model.note(tracked.was_right);
        }
        if tracked.has_companions {
            self.motion.follow_odometry();
        }
        self.local = tracked.estimate;
        seen.correct(&self.local.pose, &tracked.error);
        self.is_blind = tracked.found.is_none();
        let matched = seen.surfaces.len();
        self.last_fit = (tracked.found).map(|found| ScanFit::of(&found, matched));
        self.motion.remember(stamp, self.local.pose);
        let is_new = self.is_new_place(tracked.agreement.overlap());
        let waits = is_new && !tracked.is_loose && self.can_wait(&seen, &tracked);
        if waits {
            // What misled this scan may mislead the next one as well.
            self.way_cov += self.local.cov;
        } else if is_new || tracked.is_loose {
            self.add_keyframe(seen, &tracked);
        } else if tracked.is_sure
            && tracked.found.is_some()
            && seen.is_rolling()
            && !self.gathering.is_at_work()
        {
            self.sharpen_walls(&seen);
        }
        self.note_place(stamp, self.local.pose);
    }

    fn note_place(&mut self, stamp: Stamp, submap_from_robot: Pose2) {
        self.trajectory.push(TrackPoint {
            stamp,
            submap: self.submaps.len() - 1,
            submap_from_robot,
        });
    }

    /// Completes all postponed work.
    pub fn finish(&mut self) {
        self.place_gathered();
        if self.submaps.last().is_some_and(|s| s.own_keyframes > 0) {
            self.begin_submap(false);
        }
        self.compare_all();
        self.refine(usize::MAX, true);
        self.draw_all();
    }

    /// Compares all pairs that are listed, and those that are listed as a result.
    pub(super) fn compare_all(&mut self) {
        self.compare_next(usize::MAX);
        for new in 0..self.submaps.len() {
            self.believe_proved(new);
        }
        self.compare_next(usize::MAX);
    }

    /// The pose in the map with its covariance, including the odometry since the last scan.
    #[must_use]
    pub fn estimate(&self) -> PoseEstimate {
        let at_scan = self.estimate_at_scan();
        let gathered = self.gathering.moved;
        let at_scan = gathered.map_or(at_scan, |since| since.after(&at_scan));
        self.pending.map_or(at_scan, |since| since.after(&at_scan))
    }

    fn estimate_at_scan(&self) -> PoseEstimate {
        let map_from_submap = self.map_from_running();
        let turned = map_from_submap.rotation();
        let local = turned * (self.local.cov + self.way_cov) * turned.transpose();
        // An error in the submap's heading rotates everything at a distance from its origin.
        let ahead = map_from_submap.rotate(self.local.pose.position().coords);
        let cov = carried(&self.submap_cov, ahead, local);
        PoseEstimate {
            pose: map_from_submap * self.local.pose,
            cov,
        }
    }

    /// The motion between the last two scans as they were matched, which no loop closure changes
    /// (`None` if the last scan was only gathered), and the covariance of the last one in the
    /// running submap.
    pub(crate) fn last_match(&self) -> (Option<Pose2>, Matrix3<f64>) {
        let newest = self.trajectory.last().map(|at| at.stamp);
        let matched = self.motion.pasts.back().map(|past| past.stamp);
        let motion = self.motion.speed.filter(|_| newest == matched);
        (motion.map(|(_, motion)| motion), self.local.cov)
    }

    /// How well the last scan fits the map; `None` if it was not matched, or has only been
    /// gathered.
    #[must_use]
    pub fn last_fit(&self) -> Option<ScanFit> {
        self.last_fit
    }

    /// The map.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The pose at each scan, as known now: a loop closure changes earlier poses.
    pub fn trajectory(&self) -> impl Iterator<Item = (Stamp, Pose2)> {
        self.trajectory.iter().filter_map(|t| {
            let submap = self.submaps.get(t.submap)?;
            Some((t.stamp, submap.map_from_submap * t.submap_from_robot))
        })
    }

    /// For each scan: its stamp, its submap, and the robot's pose in that submap.
    pub fn scans_in_submaps(&self) -> impl Iterator<Item = (Stamp, usize, Pose2)> {
        let tracked = self.trajectory.iter();
        tracked.map(|t| (t.stamp, t.submap, t.submap_from_robot))
    }

    /// The submaps, and the motions measured between them.
    #[must_use]
    pub fn graph(&self) -> &PoseGraph {
        &self.graph
    }

    /// Number of closed loops, see [`LoopsClosed`].
    #[must_use]
    pub fn loop_closures(&self) -> usize {
        self.closures
    }

    /// Grows by one whenever the grid is redrawn: what was shown of the old one is then invalid.
    #[must_use]
    pub fn grid_version(&self) -> u64 {
        self.grid_version
    }

    fn map_from_running(&self) -> Pose2 {
        self.submaps
            .last()
            .map_or_else(Pose2::identity, |s| s.map_from_submap)
    }

    /// Does a part of the postponed work, so that none of it delays a scan.
    fn work_off(&mut self) {
        self.compare_next(1);
        self.refine(1, false);
        if self.redraw.is_none() {
            self.begin_redraw(self.config.redraw_shift, false);
        }
        let in_time = self.keyframes.len() / self.config.redraw_scans.max(1);
        self.draw_on(self.config.redraw_keyframes.max(in_time));
    }

    /// Compares up to `count` pairs of submaps, then optimises if something was found.
    fn compare_next(&mut self, count: usize) {
        for _ in 0..count {
            let Some((old, new)) = self.jobs.pop_front() else {
                break;
            };
            self.compare(old, new);
            if self.jobs.front().is_none_or(|next| next.1 != new) {
                self.believe_proved(new);
                if self.graph_changed {
                    self.optimize();
                }
            }
        }
    }

    /// Redraws the map if it has moved at all.
    pub(super) fn draw_all(&mut self) {
        self.draw_on(usize::MAX);
        // Whatever moved since the drawing began.
        self.begin_redraw(self.config.last_redraw * self.config.redraw_shift, true);
        self.draw_on(usize::MAX);
    }
}

/// The covariance `cov` of a pose, propagated to a place that lies `ahead` of it, plus what is
/// `added` on the way there.
fn carried(cov: &Matrix3<f64>, ahead: Vector2<f64>, added: Matrix3<f64>) -> Matrix3<f64> {
    let carry = Matrix3::new(1.0, 0.0, -ahead.y, 0.0, 1.0, ahead.x, 0.0, 0.0, 1.0);
    let mut cov = carry * cov * carry.transpose() + added;
    symmetrize(&mut cov);
    cov
}

impl Submap {
    fn begun_at(map_from_submap: Pose2, is_loose: bool) -> Self {
        Self {
            map_from_submap,
            drawn_at: map_from_submap,
            own_keyframes: 0,
            is_loose,
            closed: ClosedSubmap::default(),
        }
    }
}
