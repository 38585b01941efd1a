//! In: a [`Scan`] and the motion during its sweep. Out: [`Points`] in the robot frame at the scan's
//! stamp.
//!
//! 1. Invalid beams and those outside the range gate are dropped; beams without a return are kept,
//!    because they show what is free.
//! 2. Each beam is moved by the motion that followed it, so that a moving robot's scan is not
//!    skewed: from recent odometry ([`Points::from_rolling_scan`]) if it is available, otherwise
//!    assuming constant speed and turn rate during the sweep ([`Points::from_scan`]).

use nalgebra::{Point2, Vector2};

use super::{MotionHistory, MovedSince, RangeSigma};
use crate::bounds::config;
use crate::geom::Pose2;
use crate::robot::{Scan, Stamp};

config! {
    /// What is kept of a scan.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct PointConfig {
        /// Readings nearer than this are dropped, m. Default 0.05: the robot's own body.
        pub min_range: f64 = 0.05,
        /// Readings farther than this count as no return, m. Default infinite: the sensor's own
        /// limit.
        pub max_range: f64 = f64::INFINITY,
        /// σ(ρ) of this sensor, as estimated. Default none: what the scan says of itself.
        pub sigma: Option<RangeSigma> = None,
    }
}

/// The usable beams of one scan, in the robot frame at `stamp`.
#[derive(Clone, Debug, PartialEq)]
pub struct Points {
    /// The instant in whose robot frame the points are given.
    pub stamp: Stamp,
    /// Position of the sensor when the last beam was taken.
    pub sensor_in_robot: Point2<f64>,
    /// Standard deviation of a bearing, rad.
    pub bearing_sigma: f64,
    /// Beams in the order of the scan.
    pub beams: Vec<Beam>,
}

/// One usable beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Index of the beam in the scan.
    pub beam_idx: usize,
    /// Where the sensor was when this beam was taken.
    pub origin_in_robot: Point2<f64>,
    /// Where the beam ends: on a surface, or where the sensor stops seeing.
    pub end_in_robot: Point2<f64>,
    /// Range, m.
    pub range: f64,
    /// Standard deviation of the range, m.
    pub sigma: f64,
    /// Whether something came back.
    pub is_hit: bool,
    /// Strength of the echo in the sensor's own unit; `None` if it reports none.
    pub quality: Option<u8>,
    /// How long before the stamp of the points it was taken, s.
    pub age: f64,
}

impl Beam {
    /// The beam in another frame.
    #[must_use]
    pub fn moved(&self, to_from_this: &Pose2) -> Self {
        Self {
            origin_in_robot: *to_from_this * self.origin_in_robot,
            end_in_robot: *to_from_this * self.end_in_robot,
            ..*self
        }
    }
}

impl Points {
    /// Converts a scan; `motion` is the robot's motion during the sweep
    /// (`robot_at_first_from_robot_at_last`). The points are in the robot frame at the stamp of the
    /// scan.
    #[must_use]
    pub fn from_scan(scan: &Scan, motion: &Pose2, config: &PointConfig) -> Self {
        let back = motion.inverse();
        let moved = scan.sweep > 0.0 && *motion != Pose2::identity();
        Self::from_placed_scan(scan, scan.stamp, config, |beam| {
            if moved {
                back.fraction(scan.age_fraction(beam))
            } else {
                Pose2::identity()
            }
        })
    }

    /// Converts a scan that was taken while the robot moved according to `history`. The points are
    /// in the current robot frame, at the end of the newest odometry reading, which may be a little
    /// later than the scan's stamp.
    #[must_use]
    pub fn from_rolling_scan(scan: &Scan, history: &MotionHistory, config: &PointConfig) -> Self {
        let now = history.now().unwrap_or(scan.stamp);
        Self::from_moved_scan(scan, now, &history.since_beams(scan), config)
    }

    /// The same, given the motion since each beam was taken, up to `now`
    /// ([`MotionHistory::since_beams`]).
    #[must_use]
    pub fn from_moved_scan(
        scan: &Scan,
        now: Stamp,
        moved: &[MovedSince],
        config: &PointConfig,
    ) -> Self {
        if scan.sweep <= 0.0 && now == scan.stamp {
            return Self::from_scan(scan, &Pose2::identity(), config);
        }
        Self::from_placed_scan(scan, now, config, |beam| {
            moved.get(beam).map_or_else(Pose2::identity, |m| m.pose)
        })
    }

    /// Converts a scan for which the robot's pose at each beam is known: `robot_from_robot_at`
    /// gives it in the robot frame at `stamp`.
    #[must_use]
    pub fn from_placed_scan(
        scan: &Scan,
        stamp: Stamp,
        config: &PointConfig,
        robot_from_robot_at: impl Fn(usize) -> Pose2,
    ) -> Self {
        let robot_from_robot_at_last = robot_from_robot_at(scan.len().saturating_sub(1));
        let far = config.max_range.min(scan.max_range);
        let columns = scan.bearings.iter().zip(&scan.ranges).zip(&scan.sigmas);
        let usable = columns
            .enumerate()
            .filter_map(|(beam_idx, ((&bearing, &range), &sigma))| {
                let range = f64::from(range);
                if range.is_nan() || range < config.min_range {
                    return None;
                }
                let robot_from_beam = robot_from_robot_at(beam_idx) * scan.robot_from_sensor;
                let (sin, cos) = crate::geom::sin_cos(bearing);
                let is_hit = range < far;
                let range = range.min(far);
                Some(Beam {
                    beam_idx,
                    origin_in_robot: robot_from_beam.position(),
                    end_in_robot: robot_from_beam * Point2::from(Vector2::new(cos, sin) * range),
                    range,
                    sigma: config.sigma.map_or(f64::from(sigma), |s| s.at(range)),
                    is_hit,
                    quality: scan.quality(beam_idx),
                    age: stamp.since(scan.taken_at(beam_idx)),
                })
            });
        let mut beams = Vec::with_capacity(scan.len());
        beams.extend(usable);
        Self {
            stamp,
            sensor_in_robot: (robot_from_robot_at_last * scan.robot_from_sensor).position(),
            bearing_sigma: scan.bearing_sigma,
            beams,
        }
    }

    /// Angles between neighbouring beams, rad; across dropped beams, the mean.
    pub(super) fn beam_angles(&self) -> impl Iterator<Item = f64> {
        self.neighbours()
            .map(|([u, v], steps)| libm::atan2(u.perp(&v), u.dot(&v)).abs() / steps as f64)
    }

    /// Consecutive beams, and the difference of their numbers.
    fn neighbours(&self) -> impl Iterator<Item = ([Vector2<f64>; 2], usize)> {
        self.beams.windows(2).filter_map(|pair| {
            let [a, b] = pair else { return None };
            let steps = b.beam_idx.checked_sub(a.beam_idx)?;
            let ways = [a, b].map(|beam| beam.end_in_robot - beam.origin_in_robot);
            (steps > 0).then_some((ways, steps))
        })
    }

    /// The median angle between neighbouring beams, rad. `None` for fewer than two beams.
    #[must_use]
    pub fn beam_spacing(&self) -> Option<f64> {
        // Compares the tangents of half the angles, which are in the same order and need no arc
        // tangent.
        let mut half_tangents = Vec::with_capacity(self.beams.len());
        half_tangents.extend(self.neighbours().map(|([u, v], steps)| {
            let (dot, lengths) = (u.dot(&v), (u.norm_squared() * v.norm_squared()).sqrt());
            let across = u.perp(&v).abs();
            // Of two equivalent forms, the one without cancellation.
            let half_tangent = if dot > 0.0 {
                across / (lengths + dot)
            } else {
                (lengths - dot) / across.max(f64::MIN_POSITIVE)
            };
            match steps {
                1 => half_tangent,
                _ => libm::tan(libm::atan(half_tangent) / steps as f64),
            }
        }));
        let middle = half_tangents.len() / 2;
        (!half_tangents.is_empty()).then(|| {
            let (_, median, _) = half_tangents.select_nth_unstable_by(middle, f64::total_cmp);
            2.0 * libm::atan(*median)
        })
    }

    /// Beams with a return.
    pub fn hits(&self) -> impl Iterator<Item = &Beam> {
        self.beams.iter().filter(|beam| beam.is_hit)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use proptest::prelude::*;

    use super::*;
    use crate::geom::{Length, unit_vector};
    use crate::points::fixture::{beam_along, scan_of};
    use crate::robot::Odometry;

    proptest! {
        #[test]
        fn spacing_is_the_median_of_the_angles_between_beams(
            beams in proptest::collection::vec((0.0..3.1_f64, 1..4_usize, 0.0..40.0_f64), 2..40),
            is_clockwise in any::<bool>(),
        ) {
            let (mut bearing, mut number) = (0.7, 0);
            let beams = beams.into_iter().map(|(angle, steps, range)| {
                bearing += if is_clockwise { -angle } else { angle };
                number += steps;
                beam_along(number, unit_vector(bearing), range, true)
            });
            let points = scan_of(beams);
            let mut angles: Vec<f64> = points.beam_angles().collect();
            angles.sort_by(f64::total_cmp);
            let spacing = points.beam_spacing().unwrap();
            prop_assert!((spacing - angles[angles.len() / 2]).abs() < 1e-7, "{spacing}");
        }
    }

    #[test]
    fn beams_that_say_no_direction_and_opposite_ones_have_a_spacing() {
        let spacing = |beams: &[(f64, f64)]| {
            let beams = beams.iter().enumerate();
            let beams =
                beams.map(|(at, &(x, range))| beam_along(at, Vector2::new(x, 0.0), range, true));
            scan_of(beams).beam_spacing()
        };
        assert_eq!(spacing(&[(1.0, 0.0), (1.0, 0.0)]), Some(0.0));
        assert_eq!(
            spacing(&[(1.0, 2.0), (-1.0, 1.0)]),
            Some(std::f64::consts::PI)
        );
        assert_eq!(spacing(&[(1.0, 2.0)]), None);
    }

    /// A round room of 3 m around the origin, seen by a robot that moves by `motion` during the
    /// sweep and ends at the origin: each beam measured from the robot's pose at that moment.
    fn scan_of_round_room(motion: &Pose2) -> Scan {
        let n = 120;
        let mut scan = Scan {
            stamp: Stamp(1),
            robot_from_sensor: Pose2::identity(),
            bearings: (0..n).map(|i| TAU * f64::from(i) / f64::from(n)).collect(),
            ranges: vec![],
            sigmas: vec![0.01; n as usize],
            bearing_sigma: 0.0,
            max_range: 10.0,
            sweep: 0.2,
            qualities: vec![],
        };
        let first_from_last_inverse = motion.inverse();
        for (i, &bearing) in scan.bearings.iter().enumerate() {
            let age = (n as usize - 1 - i) as f64 / f64::from(n - 1);
            let robot = first_from_last_inverse.fraction(age);
            let direction = robot.rotate(Vector2::new(libm::cos(bearing), libm::sin(bearing)));
            // |origin + t d| = 3
            let along = robot.position().coords.dot(&direction);
            let t = -along + (along * along - robot.position().coords.norm_squared() + 9.0).sqrt();
            scan.ranges.push(t as f32);
        }
        scan
    }

    #[test]
    fn moving_robot_sees_a_round_room_round() {
        for motion in [
            Pose2::identity(),
            Pose2::new(0.3, 0.05, 0.4),
            Pose2::new(-0.2, 0.0, -0.6),
        ] {
            let points = Points::from_scan(
                &scan_of_round_room(&motion),
                &motion,
                &PointConfig::default(),
            );
            assert_eq!(points.beams.len(), 120);
            for beam in points.hits() {
                assert!((beam.end_in_robot.coords.length() - 3.0).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn history_of_the_motion_does_what_constant_speed_does_where_the_speed_is_constant() {
        let motion = Pose2::new(0.3, 0.05, 0.4);
        let mut scan = scan_of_round_room(&motion);
        scan.stamp = Stamp(1_200_000);
        let mut history = MotionHistory::new(1.0);
        for i in 0..10 {
            let step = motion.fraction(0.1);
            let (from, to) = (Stamp(1_000_000 + i * 20_000), Stamp(1_020_000 + i * 20_000));
            history.push(&Odometry {
                from,
                to,
                motion: step,
                cov: nalgebra::Matrix3::zeros(),
            });
        }
        let config = PointConfig::default();
        let (rolling, constant) = (
            Points::from_rolling_scan(&scan, &history, &config),
            Points::from_scan(&scan, &motion, &config),
        );
        for (a, b) in rolling.beams.iter().zip(&constant.beams) {
            // Stamps are whole microseconds: at 2 rad/s, half of one is a micrometre at 3 m.
            assert!(
                (a.end_in_robot - b.end_in_robot).length() < 1e-5,
                "{a:?} {b:?}"
            );
        }
        // Read 100 ms later, after a step back of 0.1 m, everything is 0.1 m farther ahead.
        let (from, to) = (Stamp(1_200_000), Stamp(1_300_000));
        history.push(&Odometry {
            from,
            to,
            motion: Pose2::new(-0.1, 0.0, 0.0),
            cov: nalgebra::Matrix3::zeros(),
        });
        let late = Points::from_rolling_scan(&scan, &history, &config);
        assert_eq!(late.stamp, to);
        for (a, b) in late.beams.iter().zip(&constant.beams) {
            assert!((a.end_in_robot - b.end_in_robot - Vector2::new(0.1, 0.0)).length() < 1e-5);
        }
    }

    #[test]
    fn gates_drop_near_and_invalid_and_clear_to_the_limit() {
        let mut scan = scan_of_round_room(&Pose2::identity());
        (
            scan.ranges[0],
            scan.ranges[1],
            scan.ranges[2],
            scan.ranges[3],
        ) = (f32::NAN, 0.01, f32::INFINITY, 8.0);
        let config = PointConfig {
            max_range: 5.0,
            ..PointConfig::default()
        };
        let points = Points::from_scan(&scan, &Pose2::identity(), &config);
        assert_eq!(points.beams.len(), 118);
        let misses: Vec<_> = points
            .beams
            .iter()
            .filter(|b| !b.is_hit)
            .map(|b| (b.beam_idx, b.range))
            .collect();
        assert_eq!(misses, [(2, 5.0), (3, 5.0)]);
    }
}
