//! The ROS 2 messages themselves, as CDR.

use std::time::Duration;

use nalgebra::Matrix3;
use slamlab_core::format::map_server::OccupancyMap;
use slamlab_core::geom::{Pose2, PoseEstimate};
use slamlab_core::robot::EvenBeams;
use slamlab_core::wire::message::ScanBody;

use super::super::cdr::Cdr;
use super::odom::Moved;

/// `sensor_msgs/PointField`: 32 bit float.
const FLOAT32: u8 = 7;
/// Bytes of a point: x, y, z.
const POINT: u32 = 12;

/// `nav_msgs/Odometry`: the pose by odometry alone, with its accumulated covariance, and the
/// present speed.
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
    let even = EvenBeams::of(&body.bearings, &body.ranges);
    let (first, step) = (even.first as f32, even.step as f32);
    let ranges = even.pick(&body.ranges, f32::NAN);
    let mut cdr = Cdr::new();
    cdr.header(now, "laser");
    cdr.f32(first)
        .f32(first + step * ranges.len().saturating_sub(1) as f32)
        .f32(step);
    let beams = ranges.len().max(2) as f32 - 1.0;
    cdr.f32(body.sweep as f32 / beams).f32(body.sweep as f32);
    cdr.f32(0.0).f32(body.max_range as f32);
    cdr.u32(ranges.len() as u32);
    for &range in &ranges {
        cdr.f32(range);
    }
    let intensities = intensities(&even, &body.qualities);
    cdr.u32(intensities.len() as u32);
    for intensity in intensities {
        cdr.f32(intensity);
    }
    cdr.finish()
}

/// `sensor_msgs/PointCloud2`: the hits in the sensor's frame, each at its own bearing.
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

/// `nav_msgs/OccupancyGrid`: 0 free, 100 occupied, -1 unknown.
pub(super) fn map(map: &OccupancyMap, now: Duration) -> Vec<u8> {
    let mut cdr = Cdr::new();
    cdr.header(now, "map").time(now).f32(map.resolution as f32);
    cdr.u32(map.width as u32).u32(map.height as u32);
    cdr.all(&placed(&map.origin));
    cdr.u32(map.cells.len() as u32);
    for cell in &map.cells {
        cdr.bytes(&cell.to_le_bytes());
    }
    cdr.finish()
}

/// Position, and the quaternion of a turn about z.
pub(crate) fn placed(pose: &Pose2) -> [f64; 7] {
    let half = 0.5 * pose.heading();
    [pose.x(), pose.y(), 0.0, 0.0, 0.0, half.sin(), half.cos()]
}

/// The covariance of x, y, heading as a 6 x 6 matrix of x, y, z and the rotations about them, row
/// by row.
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

/// Quality of each beam, 0 where it has none; empty if the sensor reports none.
pub(crate) fn intensities(even: &EvenBeams, qualities: &[u8]) -> Vec<f32> {
    if qualities.is_empty() {
        return Vec::new();
    }
    let picked = even.pick(qualities, 0);
    picked.into_iter().map(f32::from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beams_without_a_quality_have_none_and_directions_without_a_beam_have_0() {
        let uneven = EvenBeams::of(&[0.0, 0.01, 0.3], &[1.0, 0.5, 2.0]);
        assert_eq!(intensities(&uneven, &[7, 8, 9]), [8.0, 0.0, 9.0]);
        assert!(intensities(&uneven, &[]).is_empty());
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
