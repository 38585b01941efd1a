//! The blind zone: what a sensor saw before it came too near to be seen.
//!
//! In: each scan's points and the motion since the one before. Out: points inside the sensor's
//! blind zone, so that a robot does not drive into a wall or a person just because its lidar sees
//! nothing below 0.15 m.
//!
//! 1. Remembered points are moved into the robot's current frame by odometry.
//! 2. A point is forgotten when a beam in its direction ends clearly behind it (it has gone), or
//!    not behind it (it is seen again), and when the robot has left it behind. A beam without a
//!    reading proves nothing, because a blind sensor gives none either.
//! 3. Hits nearer than [`BlindZoneConfig::reach`] are remembered for the next scan, and so are
//!    people who came since ([`BlindZone::came`]).
//!
//! A sensor whose readings fold back (an infra-red ranger before its peak) is worse than blind: a
//! wall nearer than [`BlindZoneConfig::blind`] reads far, and nothing in the reading shows it.
//! Before such a scan is used, [`BlindZone::without_folded`] invalidates the readings in directions
//! where something was remembered that near.
//!
//! Ours. The occupancy grid keeps walls in the same way, but it smooths over many scans, and a
//! person appears in it too late.

use std::borrow::Cow;

use nalgebra::{Point2, Vector2};

use super::{Beam, Points};
use crate::bounds::config;
use crate::geom::{Length, Pose2, Segment, sin_cos};
use crate::robot::Scan;

config! {
    /// What is remembered.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct BlindZoneConfig {
        /// Hits nearer to the sensor than this are remembered, m. Default 0.3: more than a lidar is
        /// blind for, and what the robot drives in a scan. Larger: walls that were seen too near by
        /// an error stay longer.
        pub reach: f64 = 0.3,
        /// A beam that ends this far behind a point says that it has gone, m. Default 0.05: five
        /// times a lidar's noise.
        pub behind: f64 = 0.05,
        /// Beams in this direction of a point speak of it, as a part of the angle between two
        /// beams. Default 1.5.
        pub beams: f64 = 1.5,
        /// What is nearer to the sensor than this may read far, m. Default 0: nothing does.
        /// Growing: more readings are taken for folded ones.
        pub blind: f64 = 0.0,
    }
}

impl BlindZoneConfig {
    /// For rangers that scan on command, at most 0.7 m apart: something seen from that far may be
    /// inside the peak, 0.15 m, at the next scan. 3 cm are added for the odometry in between.
    #[must_use]
    pub fn short_range() -> Self {
        Self {
            reach: 0.9,
            blind: 0.18,
            ..Self::default()
        }
    }
}

/// Most points that are remembered; the oldest are forgotten.
const MOST: usize = 1000;
/// Remembered neighbours nearer to one another than this belong to one surface, m: less than the
/// robot could pass through.
const LINK: f64 = 0.1;

/// Half the width for which a reading of a person stands, m: narrower than any person, and one
/// surface.
const HALF_PERSON: f64 = 0.08;

/// Remembers what is near.
#[derive(Clone, Debug, Default)]
pub struct BlindZone {
    config: BlindZoneConfig,
    /// The remembered points, robot frame at the last scan.
    remembered: Vec<Point2<f64>>,
    /// Those that the last scan did not see.
    unseen: Vec<Point2<f64>>,
}

impl BlindZone {
    /// An empty memory.
    #[must_use]
    pub fn new(config: BlindZoneConfig) -> Self {
        Self {
            config,
            ..Self::default()
        }
    }

    /// Uses other settings from the next scan on.
    pub fn reconfigure(&mut self, config: BlindZoneConfig) {
        self.config = config;
    }

    /// The scan with those readings made invalid (NaN) that may come from something nearer than
    /// [`BlindZoneConfig::blind`]. `moved` is the motion since the scan before.
    #[must_use]
    pub fn without_folded<'a>(&self, scan: &'a Scan, moved: &Pose2) -> Cow<'a, Scan> {
        let blind = self.config.blind;
        let sensor_from_before = scan.robot_from_sensor.inverse() * moved.inverse();
        let surfaces: Vec<Segment> = self
            .remembered
            .windows(2)
            .filter_map(|pair| {
                let [a, b] = pair else { return None };
                let surface = sensor_from_before * Segment::new(*a, *b);
                let is_near = surface.distance(Point2::origin()) < blind;
                (is_near && (a - b).length() < LINK).then_some(surface)
            })
            .collect();
        let mut scan = Cow::Borrowed(scan);
        if surfaces.is_empty() {
            return scan;
        }
        let is_folded = |bearing: f64, range: f32| {
            let (sin, cos) = sin_cos(bearing);
            let ahead = Vector2::new(cos, sin);
            let hits = surfaces
                .iter()
                .filter_map(|s| s.hit_by_ray(Point2::origin(), ahead));
            let nearest = hits.fold(f64::INFINITY, f64::min);
            nearest < blind && f64::from(range) > nearest
        };
        let readings = scan.bearings.iter().zip(&scan.ranges).enumerate();
        let folded: Vec<usize> = readings
            .filter(|(_, (bearing, range))| is_folded(**bearing, **range))
            .map(|(beam, _)| beam)
            .collect();
        for beam in folded {
            if let Some(range) = scan.to_mut().ranges.get_mut(beam) {
                *range = f32::NAN;
            }
        }
        scan
    }

    /// Takes a scan's points, and the motion since the scan before (`robot_before_from_robot_now`).
    pub fn update(&mut self, points: &Points, moved: &Pose2) {
        let now_from_before = moved.inverse();
        let sensor = points.sensor_in_robot;
        let reach = self.config.reach;
        self.unseen.clear();
        for before in &self.remembered {
            let point = now_from_before * *before;
            if (point - sensor).length() < reach + self.config.behind {
                self.unseen.push(point);
            }
        }
        if !self.unseen.is_empty() {
            self.forget_seen(points);
        }
        self.remembered.clone_from(&self.unseen);
        let near = points.hits().filter(|beam| beam.range < reach);
        self.remembered.extend(near.map(|beam| beam.end_in_robot));
        self.forget_oldest();
    }

    fn forget_oldest(&mut self) {
        let too_many = self.remembered.len().saturating_sub(MOST);
        self.remembered.drain(..too_many);
    }

    /// Takes a person who came since the last scan and was seen there (robot frame of that scan):
    /// they may be too near to be seen by the next scan. A single reading stands for a short piece
    /// of surface across it.
    pub fn came(&mut self, at: Point2<f64>) {
        let across = Vector2::new(-at.y, at.x) / at.coords.length().max(f64::MIN_POSITIVE);
        if at.coords.length() < self.config.reach {
            let piece = [-HALF_PERSON, 0.0, HALF_PERSON].map(|by| at + across * by);
            self.remembered.extend(piece);
            self.forget_oldest();
        }
    }

    /// Points that the last scan did not see although they should still be there, robot frame at
    /// that scan, m.
    #[must_use]
    pub fn unseen(&self) -> &[Point2<f64>] {
        &self.unseen
    }

    /// The scan's points, with those that it did not see added as hits; for code that must not
    /// drive into either.
    #[must_use]
    pub fn with_unseen(&self, points: &Points) -> Points {
        let mut all = points.clone();
        let origin = points.sensor_in_robot;
        all.beams.extend(self.unseen.iter().map(|&end| Beam {
            beam_idx: usize::MAX,
            origin_in_robot: origin,
            end_in_robot: end,
            range: (end - origin).length(),
            sigma: self.config.behind,
            is_hit: true,
            quality: None,
            age: 0.0,
        }));
        all
    }

    fn forget_seen(&mut self, points: &Points) {
        let Some(angle) = points.beam_angles().min_by(f64::total_cmp) else {
            return;
        };
        let (width, behind) = (self.config.beams * angle, self.config.behind);
        self.unseen.retain(|point| {
            points.beams.iter().all(|beam| {
                let (to, along) = (
                    point - beam.origin_in_robot,
                    beam.end_in_robot - beam.origin_in_robot,
                );
                let (distance, ahead) = (to.length(), along.dot(&to));
                let is_beside = ahead <= 0.0 || along.perp(&to).abs() > width * ahead;
                // A little behind it: noise, or a reading at the very limit of the range.
                let is_doubtful = beam.range > distance && beam.range < distance + behind;
                is_beside || is_doubtful
            })
        });
    }
}

#[cfg(test)]
mod tests;
