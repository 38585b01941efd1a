//! Moving objects, tracked from scan to scan.
//!
//! 1. Before a scan is used: beams that end where an object is expected that moves, or moved just
//!    before, are reported ([`MovingObjects::taken_out`]), so that estimation does without them.
//! 2. Afterwards, when the robot's pose is known ([`MovingObjects::update`]): hits are compared
//!    with the map, clustered, and assigned to tracks.
//! 3. A wrong pose puts many hits into free space. If more than [`MOST_FREE`] of the hits that the
//!    map can judge are there, no track begins. A wall is wider than things that may move, and
//!    stands.
//!
//! Tracks live in a frame of their own, in which the robot moves as scans show: when a loop closes,
//! the map moves, but nobody in it.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Matrix4, Point2, Vector2};

use super::clusters::{Hit, clusters, extent, sighting};
use super::config::{TrackAssociation, TrackingConfig};
use super::free_space::{Place, is_beside_wall, place};
use super::gm_phd::GmPhd;
use super::kalman_tracks::{KalmanTracks, Object};
use super::motion::{History, TrackMotion};
use super::state::Sighting;
use crate::geom::{Length, Pose2};
use crate::map::Grid;
use crate::points::{Points, unreported_turn};
use crate::robot::Stamp;

/// Scans farther apart in time than this say nothing about motion, s.
const SLOWEST: f64 = 1.0;
/// With beams farther apart than this people are not seen well enough, rad.
const COARSE: f64 = 0.06;
/// Greatest fraction of hits in free space, among those that the map can judge.
const MOST_FREE: f64 = 0.4;
/// Bounds of the assumed standard deviation of the pose in the map around it: at most this, m and
/// rad, because with more nothing could be seen; and at least this, rad.
const MOST_DOUBT: [f64; 2] = [0.15, 0.02];
const LEAST_TURN: f64 = 0.003;
/// An object is expected within this distance of its prediction, m: its own size, plus two standard
/// deviations, up to ...
const SIZE: f64 = 0.35;
const MOST_REACH: f64 = 0.8;
/// If more than this fraction of the hits would be taken out none is, because without them the pose
/// cannot be estimated.
const MOST_OUT: f64 = 0.6;
/// A correction by more than this, m and rad, means that the map moved.
const JUMP: f64 = 0.5;

/// The pose at which a scan was matched.
#[derive(Clone, Copy, Debug)]
pub struct Matched {
    /// The motion since the scan before as both were matched, `robot_before_from_robot_now`; `None`
    /// from methods that only give the pose.
    pub motion: Option<Pose2>,
    /// Covariance of the pose in the map around it, map frame.
    pub cov: Matrix3<f64>,
}

/// A track, in the robot frame at the newest scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Track {
    /// Its unique number, never reused.
    pub id: u32,
    /// Position of its middle, m.
    pub position: Point2<f64>,
    /// Its velocity over the ground, m/s.
    pub velocity: Vector2<f64>,
    /// Covariance of both.
    pub cov: Matrix4<f64>,
    /// Its state of motion.
    pub motion: TrackMotion,
    /// Whether it was seen in the newest scan.
    pub is_seen: bool,
}

/// Finds and tracks moving objects.
#[derive(Clone, Debug, Default)]
pub struct MovingObjects {
    config: TrackingConfig,
    filter: Filter,
    histories: BTreeMap<u32, History>,
    local_from_robot: Pose2,
    last: Option<Last>,
    tracks: Vec<Track>,
    /// Beams of the newest scan that were taken out, and their ends.
    taken_out: Vec<usize>,
    points: Vec<Point2<f64>>,
}

/// What is kept of the scan before.
#[derive(Clone, Debug)]
struct Last {
    stamp: Stamp,
    map_from_robot: Pose2,
    hits: Vec<Point2<f64>>,
}

/// The filter that associates sightings with objects.
#[derive(Clone, Debug)]
enum Filter {
    Tracks(KalmanTracks),
    Density(GmPhd),
}

impl MovingObjects {
    /// A tracker without objects; `config` must be valid.
    #[must_use]
    pub fn new(config: TrackingConfig) -> Self {
        Self {
            filter: Filter::of(config.association),
            config,
            ..Self::default()
        }
    }

    /// Uses other settings from the next scan on. A change of the association begins anew.
    pub fn reconfigure(&mut self, config: TrackingConfig) {
        if config.association != self.config.association || !config.is_on {
            self.forget(config.association);
        }
        self.config = config;
    }

    /// The tracks, by number.
    #[must_use]
    pub fn tracks(&self) -> &[Track] {
        &self.tracks
    }

    /// Ends of the beams of the newest scan that were taken out, robot frame, m.
    #[must_use]
    pub fn taken_out_points(&self) -> &[Point2<f64>] {
        &self.points
    }

    /// Step 1: numbers of the beams that end on moving objects, ascending. `moved` is the motion
    /// since the scan before by odometry (`robot_before_from_robot_now`), `map_from_robot` the
    /// resulting pose.
    pub fn taken_out(
        &mut self,
        points: &Points,
        moved: &Pose2,
        grid: &Grid,
        map_from_robot: &Pose2,
    ) -> &[usize] {
        self.taken_out.clear();
        self.points.clear();
        let Some(last) = &self.last else {
            return &self.taken_out;
        };
        let seconds = points.stamp.since(last.stamp);
        if !(self.config.is_on && self.config.keeps_out) || seconds > SLOWEST {
            return &self.taken_out;
        }
        let expected: Vec<&Object> = (self.filter.objects().iter())
            .filter(|object| {
                let history = self.histories.get(&object.id);
                history.is_some_and(|h| h.moved_lately(points.stamp.seconds(), &self.config))
            })
            .collect();
        if expected.is_empty() {
            return &self.taken_out;
        }
        // `robot_now_from_robot_as_odometry_has_it`.
        let turn = unreported_turn(last.hits.iter().copied(), moved, points);
        let local_from_robot = self.local_from_robot * *moved * turn.inverse();
        let map_from_robot = *map_from_robot * turn.inverse();
        let robot_from_local = local_from_robot.inverse();
        let hits: Vec<Hit> = points
            .hits()
            .map(|beam| Hit {
                beam,
                place: Place::Unknown,
            })
            .collect();
        let mut taken: Vec<Hit> = vec![];
        for cluster in clusters(&hits) {
            let count = cluster.len() as f64;
            let age = cluster.iter().map(|hit| hit.beam.age).sum::<f64>() / count;
            let ends = cluster.iter().map(|hit| hit.beam.end_in_robot.coords);
            let middle = Point2::from(ends.sum::<Vector2<f64>>() / count);
            let is_small = extent(&cluster) <= self.config.max_width;
            for object in &expected {
                let state = object
                    .state
                    .predicted(seconds - age, self.config.acceleration);
                let at = robot_from_local * state.position();
                let sigma = state.position_cov().diagonal().max().sqrt();
                let reach = (SIZE + 2.0 * sigma).min(MOST_REACH);
                let is_theirs = |hit: &&Hit| {
                    (is_small && (middle - at).length() < reach)
                        || (hit.beam.end_in_robot - at).length() < SIZE
                };
                let is_free =
                    |hit: &&Hit| !is_beside_wall(grid, map_from_robot * hit.beam.end_in_robot);
                taken.extend(cluster.iter().filter(is_theirs).filter(is_free));
            }
        }
        taken.sort_by_key(|hit| hit.beam.beam_idx);
        taken.dedup_by_key(|hit| hit.beam.beam_idx);
        if taken.len() as f64 <= MOST_OUT * hits.len() as f64 {
            self.taken_out
                .extend(taken.iter().map(|hit| hit.beam.beam_idx));
            self.points
                .extend(taken.iter().map(|hit| hit.beam.end_in_robot));
        }
        &self.taken_out
    }

    /// Steps 2 and 3: takes all points of a scan, which was matched at `map_from_robot`; `moved` as
    /// for [`Self::taken_out`].
    pub fn update(
        &mut self,
        points: &Points,
        moved: &Pose2,
        grid: &Grid,
        map_from_robot: &Pose2,
        matched: &Matched,
    ) {
        let hits: Vec<Point2<f64>> = points.hits().map(|beam| beam.end_in_robot).collect();
        let stamp = points.stamp;
        let next = Last {
            stamp,
            map_from_robot: *map_from_robot,
            hits,
        };
        let Some(last) = self.last.replace(next) else {
            return;
        };
        let seconds = stamp.since(last.stamp);
        let spacing = points.beam_spacing().filter(|spacing| *spacing < COARSE);
        let (Some(spacing), true) = (spacing, self.config.is_on && seconds <= SLOWEST) else {
            self.forget(self.config.association);
            return;
        };
        self.move_robot(
            moved,
            &last.map_from_robot.delta_to(map_from_robot),
            matched,
        );
        let sightings = self.sightings(points, spacing, grid, map_from_robot, &matched.cov);
        self.filter
            .update(seconds.max(0.0), &sightings, &self.config);
        self.remember(stamp.seconds());
    }

    fn forget(&mut self, association: TrackAssociation) {
        self.filter = Filter::of(association);
        self.histories.clear();
        self.tracks.clear();
    }

    /// Moves the robot relative to the tracks by the motion between the matched scans, or by
    /// odometry if the map moved instead.
    fn move_robot(&mut self, moved: &Pose2, in_map: &Pose2, matched: &Matched) {
        let motion = matched.motion.unwrap_or(*in_map);
        let off = moved.delta_to(&motion);
        let is_jump = off.position().coords.length() > JUMP || off.heading().abs() > JUMP;
        self.local_from_robot = self.local_from_robot * if is_jump { *moved } else { motion };
    }

    /// Sightings of things that may move, in the frame of the tracks.
    fn sightings(
        &self,
        points: &Points,
        spacing: f64,
        grid: &Grid,
        map_from_robot: &Pose2,
        cov: &Matrix3<f64>,
    ) -> Vec<Sighting> {
        let [most_shift, most_turn] = MOST_DOUBT;
        let shift = cov[(0, 0)].max(cov[(1, 1)]).max(0.0).sqrt().min(most_shift);
        let turn = cov[(2, 2)].max(0.0).sqrt().clamp(LEAST_TURN, most_turn);
        let looked_up = points.hits().map(|beam| {
            let doubt = self.config.margin + shift + turn * beam.range;
            let place = place(grid, *map_from_robot * beam.end_in_robot, doubt);
            Hit { beam, place }
        });
        let hits: Vec<Hit> = looked_up.collect();
        let count = |kind: Place| hits.iter().filter(|hit| hit.place == kind).count() as f64;
        let (free, walls) = (count(Place::Free), count(Place::Wall));
        let is_sound = free <= MOST_FREE * (free + walls);
        let loose: Vec<Hit> = hits
            .into_iter()
            .filter(|hit| hit.place != Place::Wall)
            .collect();
        let rotation = self
            .local_from_robot
            .rotation()
            .fixed_view::<2, 2>(0, 0)
            .into_owned();
        let found = clusters(&loose).into_iter().filter_map(|cluster| {
            let own = sighting(
                &cluster,
                points.sensor_in_robot,
                spacing,
                turn,
                &self.config,
            )?;
            Some(Sighting {
                at: self.local_from_robot * own.at,
                cov: rotation * own.cov * rotation.transpose(),
                is_free: own.is_free && is_sound,
                ..own
            })
        });
        found.collect()
    }

    /// Notes the positions of all tracks, and what is shown of them.
    fn remember(&mut self, now: f64) {
        let objects = self.filter.objects();
        let mut before = std::mem::take(&mut self.histories);
        for object in objects {
            let history = before.remove(&object.id);
            let mut history = history.unwrap_or_else(|| History::begun(now));
            if object.is_free {
                let state = &object.state;
                history.see(now, state.position(), state.position_cov(), &self.config);
            }
            self.histories.insert(object.id, history);
        }
        let robot_from_local = self.local_from_robot.inverse();
        let rotation = robot_from_local
            .rotation()
            .fixed_view::<2, 2>(0, 0)
            .into_owned();
        let mut turn = Matrix4::zeros();
        turn.fixed_view_mut::<2, 2>(0, 0).copy_from(&rotation);
        turn.fixed_view_mut::<2, 2>(2, 2).copy_from(&rotation);
        let shown = |object: &Object| {
            let motion = self.histories.get(&object.id)?.motion(now, &self.config);
            Some(Track {
                id: object.id,
                position: robot_from_local * object.state.position(),
                velocity: robot_from_local.rotate(object.state.velocity()),
                cov: turn * object.state.cov * turn.transpose(),
                motion,
                is_seen: object.is_seen,
            })
        };
        self.tracks = objects.iter().filter_map(shown).collect();
        self.tracks.sort_by_key(|track| track.id);
    }
}

impl Filter {
    fn of(association: TrackAssociation) -> Self {
        match association {
            TrackAssociation::Nearest | TrackAssociation::Jpda => {
                Self::Tracks(KalmanTracks::default())
            }
            TrackAssociation::GmPhd => Self::Density(GmPhd::default()),
        }
    }

    fn update(&mut self, seconds: f64, sightings: &[Sighting], config: &TrackingConfig) {
        match self {
            Self::Tracks(tracks) => tracks.update(seconds, sightings, config),
            Self::Density(density) => density.update(seconds, sightings, config),
        }
    }

    fn objects(&self) -> &[Object] {
        match self {
            Self::Tracks(tracks) => tracks.objects(),
            Self::Density(density) => density.objects(),
        }
    }
}

impl Default for Filter {
    fn default() -> Self {
        Self::of(TrackAssociation::default())
    }
}

#[cfg(test)]
mod tests;
