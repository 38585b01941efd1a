//! What a sensor saw before it came too near to see it.
//!
//! In: each scan's points and the motion since the one before. Out: points that stand inside of what the sensor is blind
//! for, so that a robot does not drive into a wall, or a person, only because its lidar sees nothing below 0.15 m.
//!
//! 1. Remembered points are moved into the robot's present frame by odometry.
//! 2. A point is forgotten when a beam in its direction ends clearly behind it (it has gone), or not behind it (it is seen
//!    again), and when the robot has left it behind. A beam without a reading says nothing: that is what blindness looks like.
//! 3. Hits nearer than [`NearConfig::reach`] are remembered for the next scan.
//!
//! Ours. The occupancy grid keeps walls likewise, but it smooths over many scans, and a person stands in it too late.

use nalgebra::Point2;

use super::{Beam, Points};
use crate::geom::Pose2;

/// What is remembered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearConfig {
    /// Hits nearer to the sensor than this are remembered, m. Default 0.3: more than a lidar is blind for, and what the robot
    /// drives in a scan. Growing: walls that were seen too near by an error stay longer.
    pub reach: f64,
    /// A beam that ends this far behind a point says that it has gone, m. Default 0.05: five times a lidar's noise.
    pub behind: f64,
    /// Beams in this direction of a point speak of it, as a part of the angle between two beams. Default 1.5.
    pub beams: f64,
}

impl Default for NearConfig {
    fn default() -> Self {
        Self {
            reach: 0.3,
            behind: 0.05,
            beams: 1.5,
        }
    }
}

/// Most points that are remembered; the oldest are forgotten.
const MOST: usize = 1000;

/// Remembers what is near.
#[derive(Clone, Debug, Default)]
pub struct NearField {
    config: NearConfig,
    /// Robot frame at the last scan.
    remembered: Vec<Point2<f64>>,
    /// Those of them that the last scan did not see.
    unseen: Vec<Point2<f64>>,
}

impl NearField {
    /// Takes a scan's points, and the motion since the scan before (`robot_before_from_robot_now`).
    pub fn update(&mut self, points: &Points, moved: &Pose2) {
        let now_from_before = moved.inverse();
        let sensor = points.sensor_in_robot;
        let reach = self.config.reach;
        self.unseen.clear();
        for before in &self.remembered {
            let point = now_from_before * *before;
            if (point - sensor).norm() < reach + self.config.behind {
                self.unseen.push(point);
            }
        }
        if !self.unseen.is_empty() {
            self.forget_seen(points);
        }
        self.remembered.clone_from(&self.unseen);
        let near = points.hits().filter(|beam| beam.range < reach);
        self.remembered.extend(near.map(|beam| beam.end_in_robot));
        let too_many = self.remembered.len().saturating_sub(MOST);
        self.remembered.drain(..too_many);
    }

    /// Points that the last scan did not see although they are there, robot frame at that scan, m.
    #[must_use]
    pub fn unseen(&self) -> &[Point2<f64>] {
        &self.unseen
    }

    /// The scan's points, and as hits what it did not see; for those who must not drive into either.
    #[must_use]
    pub fn with_unseen(&self, points: &Points) -> Points {
        let mut all = points.clone();
        let origin = points.sensor_in_robot;
        all.beams.extend(self.unseen.iter().map(|&end| Beam {
            beam_idx: usize::MAX,
            origin_in_robot: origin,
            end_in_robot: end,
            range: (end - origin).norm(),
            sigma: self.config.behind,
            is_hit: true,
            quality: None,
        }));
        all
    }

    fn forget_seen(&mut self, points: &Points) {
        let Some(angle) = beam_angle(points) else {
            return;
        };
        let (width, behind) = (self.config.beams * angle, self.config.behind);
        self.unseen.retain(|point| {
            points.beams.iter().all(|beam| {
                let (to, along) = (
                    point - beam.origin_in_robot,
                    beam.end_in_robot - beam.origin_in_robot,
                );
                let (distance, ahead) = (to.norm(), along.dot(&to));
                let is_beside = ahead <= 0.0 || along.perp(&to).abs() > width * ahead;
                // Little behind it: noise, or a reading at the very border of what can be measured.
                let is_doubtful = beam.range > distance && beam.range < distance + behind;
                is_beside || is_doubtful
            })
        });
    }
}

/// Angle between two beams that follow one another, rad; `None` for fewer than two.
fn beam_angle(points: &Points) -> Option<f64> {
    let angles = points.beams.windows(2).filter_map(|pair| {
        let [a, b] = pair else { return None };
        let (u, v) = (
            a.end_in_robot - a.origin_in_robot,
            b.end_in_robot - b.origin_in_robot,
        );
        (b.beam_idx == a.beam_idx + 1).then(|| libm::atan2(u.perp(&v), u.dot(&v)).abs())
    });
    angles.min_by(f64::total_cmp)
}

#[cfg(test)]
mod tests;
