//! The ROS 2 messages themselves, as CDR.

use std::time::Duration;

use nalgebra::Matrix3;
use slamlab_core::format::map_server::{MapMode, OccupancyMap};
use slamlab_core::geom::{Pose2, PoseEstimate};
use slamlab_core::map::Grid;
use slamlab_core::wire::message::ScanBody;

use super::super::cdr::Cdr;
use super::odom::Moved;

/// `sensor_msgs/PointField`: 32 bit float.
const FLOAT32: u8 = 7;
/// Bytes of a point: x, y, z.
const POINT: u32 = 12;

/// `nav_msgs/Odometry`: where the odometry alone puts the robot, with the covariance that has added up, and its present speed.
pub(super) fn odometry(moved: &Moved, now: Duration) -> Vec<u8> {
    let (summed, [x, y, turn]) = (&moved.summed, moved.speeds);
    let mut cdr = Cdr::new();
    cdr.header(now, "odom").text("base_link");
    cdr.all(&placed(&summed.motion)).all(&in_space(&summed.cov));
    cdr.all(&[x, y, 0.0, 0.0, 0.0, turn])
        .all(&in_space(&moved.speeds_cov));
    cdr.finish()
}

/// `geometry_msgs/PoseWithCovarianceStamped` in the map.
pub(super) fn pose(estimate: &PoseEstimate, now: Duration) -> Vec<u8> {
    let mut cdr = Cdr::new();
    cdr.header(now, "map");
    cdr.all(&placed(&estimate.pose))
        .all(&in_space(&estimate.cov));
    cdr.finish()
}

/// `tf2_msgs/TFMessage` of one transform: parent from child.
pub(super) fn transform(pose: &Pose2, [parent, child]: [&str; 2], now: Duration) -> Vec<u8> {
    let mut cdr = Cdr::new();
    cdr.u32(1).header(now, parent).text(child);
    cdr.all(&placed(pose)).finish()
}

/// `sensor_msgs/LaserScan`.
pub(super) fn scan(body: &ScanBody, now: Duration) -> Vec<u8> {
    let even = evenly(&body.bearings, &body.ranges);
    let (first, step, ranges) = (even.first, even.step, &even.ranges);
    let mut cdr = Cdr::new();
    cdr.header(now, "laser");
    cdr.f32(first)
        .f32(first + step * ranges.len().saturating_sub(1) as f32)
        .f32(step);
    let beams = ranges.len().max(2) as f32 - 1.0;
    cdr.f32(body.sweep as f32 / beams).f32(body.sweep as f32);
    cdr.f32(0.0).f32(body.max_range as f32);
    cdr.u32(ranges.len() as u32);
    for &range in ranges {
        cdr.f32(range);
    }
    let intensities = even.intensities(&body.qualities);
    cdr.u32(intensities.len() as u32);
    for intensity in intensities {
        cdr.f32(intensity);
    }
    cdr.finish()
}

/// `sensor_msgs/PointCloud2`: what the beams hit, in the sensor's frame, each at its own bearing.
pub(super) fn points(body: &ScanBody, now: Duration) -> Vec<u8> {
    let beams = body.bearings.iter().zip(&body.ranges);
    let hits: Vec<[f32; 3]> = beams
        .filter(|(_, range)| range.is_finite())
        .map(|(bearing, &range)| {
            let (sin, cos) = bearing.sin_cos();
            let range = f64::from(range);
            [(range * cos) as f32, (range * sin) as f32, 0.0]
        })
        .collect();
    let count = hits.len() as u32;
    let mut cdr = Cdr::new();
    cdr.header(now, "laser").u32(1).u32(count).u32(3);
    for (name, offset) in [("x", 0), ("y", 4), ("z", 8)] {
        cdr.text(name).u32(offset).u8(FLOAT32).u32(1);
    }
    cdr.u8(0).u32(POINT).u32(POINT * count).u32(POINT * count);
    for number in hits.as_flattened() {
        cdr.bytes(&number.to_le_bytes());
    }
    cdr.u8(1).finish()
}

/// `nav_msgs/OccupancyGrid`: 0 free, 100 occupied, -1 unknown; `None` of a map without a known cell.
pub(super) fn map(grid: &Grid, now: Duration) -> Option<Vec<u8>> {
    let map = OccupancyMap::of_grid(grid, MapMode::Trinary).ok()?;
    let mut cdr = Cdr::new();
    cdr.header(now, "map").time(now).f32(map.resolution as f32);
    cdr.u32(map.width as u32).u32(map.height as u32);
    cdr.all(&placed(&map.origin));
    cdr.u32(map.cells.len() as u32);
    for cell in &map.cells {
        cdr.bytes(&cell.to_le_bytes());
    }
    Some(cdr.finish())
}

/// Position, and the quaternion of a turn about z.
pub(crate) fn placed(pose: &Pose2) -> [f64; 7] {
    let half = 0.5 * pose.heading();
    [pose.x(), pose.y(), 0.0, 0.0, 0.0, half.sin(), half.cos()]
}

/// The covariance of x, y, heading among x, y, z and turns about them, row by row.
pub(crate) fn in_space(cov: &Matrix3<f64>) -> [f64; 36] {
    const PLACES: [usize; 3] = [0, 1, 5];
    let mut all = [0.0; 36];
    for (row, at) in PLACES.into_iter().enumerate() {
        for (col, to) in PLACES.into_iter().enumerate() {
            if let Some(place) = all.get_mut(6 * at + to) {
                *place = cov[(row, col)];
            }
        }
    }
    all
}

/// Beams at equal angles.
pub(crate) struct Even {
    /// First bearing, rad.
    pub(crate) first: f32,
    /// From one beam to the next, rad.
    pub(crate) step: f32,
    pub(crate) ranges: Vec<f32>,
    /// Which beam of the scan each range is of; `None` where there was none so near.
    beams: Vec<Option<usize>>,
}

impl Even {
    /// Quality of each beam, 0 where there is none; empty where the sensor tells none.
    pub(crate) fn intensities(&self, qualities: &[u8]) -> Vec<f32> {
        if qualities.is_empty() {
            return Vec::new();
        }
        let of = |beam: &Option<usize>| beam.and_then(|beam| qualities.get(beam)).copied();
        let tell = |beam| f32::from(of(beam).unwrap_or_default());
        self.beams.iter().map(tell).collect()
    }
}

pub(crate) fn evenly(bearings: &[f64], ranges: &[f32]) -> Even {
    let least = bearings.iter().copied().fold(f64::INFINITY, f64::min);
    let most = bearings.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let gaps = bearings.len().saturating_sub(1);
    let step = (most - least) / gaps.max(1) as f64;
    let mut even = Even {
        first: least as f32,
        step: step as f32,
        ranges: vec![f32::NAN; bearings.len()],
        beams: vec![None; bearings.len()],
    };
    for (beam, (bearing, &range)) in bearings.iter().zip(ranges).enumerate() {
        // Equal bearings have no step; all fall on the first beam.
        let at = if step > 0.0 {
            ((bearing - least) / step).round() as usize
        } else {
            0
        };
        let (Some(nearest), Some(from)) = (even.ranges.get_mut(at), even.beams.get_mut(at)) else {
            continue;
        };
        // Of two in one place the nearer one counts, and a number before NaN.
        if from.is_none() || nearest.is_nan() || range < *nearest {
            (*nearest, *from) = (range, Some(beam));
        }
    }
    even
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bearings_come_into_counter_clockwise_order_at_equal_steps() {
        let even = evenly(&[0.2, 0.1, 0.0], &[3.0, 2.0, 1.0]);
        assert_eq!((even.first, &even.ranges), (0.0, &vec![1.0, 2.0, 3.0]));
        assert!((even.step - 0.1).abs() < 1e-6);
        assert_eq!(even.intensities(&[7, 8, 9]), [9.0, 8.0, 7.0]);
        assert!(even.intensities(&[]).is_empty());
        let uneven = evenly(&[0.0, 0.01, 0.3], &[1.0, 0.5, 2.0]);
        assert_eq!(uneven.intensities(&[7, 8, 9]), [8.0, 0.0, 9.0]);
        let uneven = uneven.ranges;
        assert_eq!((uneven[0], uneven[2]), (0.5, 2.0));
        assert!(uneven[1].is_nan());
        let same = evenly(&[1.0, 1.0], &[f32::INFINITY, f32::NAN]).ranges;
        assert!(same[0].is_infinite() && same[1].is_nan());
    }

    #[test]
    fn variances_of_the_plane_stand_in_their_places_in_space() {
        #[rustfmt::skip]
        let cov = Matrix3::new(
            1.0, 2.0, 3.0,
            2.0, 4.0, 5.0,
            3.0, 5.0, 6.0,
        );
        let all = in_space(&cov);
        assert_eq!([all[0], all[1], all[5]], [1.0, 2.0, 3.0]);
        assert_eq!([all[6], all[7], all[11]], [2.0, 4.0, 5.0]);
        assert_eq!([all[30], all[31], all[35]], [3.0, 5.0, 6.0]);
        assert_eq!(all.iter().sum::<f64>(), 31.0);
    }

    #[test]
    fn a_quarter_turn_is_the_quaternion_of_a_quarter_turn() {
        let placed = placed(&Pose2::new(1.0, 2.0, std::f64::consts::FRAC_PI_2));
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let expect = [1.0, 2.0, 0.0, 0.0, 0.0, half, half];
        let off = placed.iter().zip(expect).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-12, "{placed:?}");
    }
}
