//! A ring of sonars that fire one after the other.
//!
//! Forward, from the world to an echo:
//! 1. A ping fills a cone, which is sampled by rays; the nearest surface that sends it back is
//!    heard, whatever its bearing.
//! 2. A wall is a mirror for sound: it answers only where a ray meets it within
//!    [`SonarModel::specular_angle`] of its normal. Glass is a wall like any other, and people
//!    always answer.
//! 3. Noise on the range. Some pings are lost; some receive another sonar's echo, nearer than the
//!    truth.
//!
//! Inverse, from an echo to a range: the range is placed on the axis of the cone, and the bearing's
//! σ is that of a uniform distribution over the cone. The cones overlap, so an object ahead within
//! the robot's width is always drawn ahead, no farther away than it is. No echo may mean a wall
//! that mirrors the ping away as well as an empty hall, so it is invalid (NaN) and not free.
//!
//! Source: the specification, "Sensors"; Thrun, Burgard & Fox (2005), "Probabilistic Robotics"
//! §6.2; Devantech SRF05 for the ranges; Kuc & Siegel (1987), "Physically based simulation model
//! for acoustic sensor robot navigation", for the mirror.

use std::f64::consts::{FRAC_PI_2, TAU};

use rand::{Rng, RngExt};

use super::check::check_sensor;
use super::{SensorError, Span, View};
use crate::bounds::{Bounds, PART, config};
use crate::geom::{Pose2, unit_vector, wrap};
use crate::robot::{Scan, Stamp};
use crate::sim::noise::gaussian_pair;

config! {
    /// Figures of a ring of sonars.
    #[derive(Clone, Debug, PartialEq)]
    pub struct SonarModel {
        /// Number of sonars. Default 16.
        pub cones: usize = 16,
        /// Half the opening of a cone, rad. Default 0.262: 15°.
        pub half_angle: f64 = 0.262,
        /// Rays that sample a cone. Default 13: every 2.5°.
        pub rays: usize = 13,
        /// Greatest angle from a wall's normal at which it answers, rad. Default 0.44: 25°.
        pub specular_angle: f64 = 0.44,
        /// Seconds from one ping to the next. Default 0.025: the echo of 4 m is back by then.
        pub period: f64 = 0.025,
        /// Nearest range, m. Default 0.03; nearer the membrane still rings.
        pub min_range: f64 = 0.03,
        /// Farthest range, m. Default 4.
        pub max_range: f64 = 4.0,
        /// σ of the range at no distance, m. Default 0.01.
        pub sigma: f64 = 0.01,
        /// Growth of that σ with the distance, m/m. Default 0.01.
        pub sigma_per_metre: f64 = 0.01,
        /// Part of the pings that are lost. Default 0.01.
        pub dropouts: f64 = 0.01,
        /// Part of the pings that another's echo answers. Default 0.005.
        pub outliers: f64 = 0.005,
        /// Where its middle sits on the robot. Default: the robot's.
        pub robot_from_sensor: Pose2 = Pose2::identity(),
    }
}

impl SonarModel {
    /// σ of a reading at `range`, m.
    #[must_use]
    pub fn sigma_at(&self, range: f64) -> f64 {
        self.sigma + self.sigma_per_metre * range
    }

    /// σ of the bearing, rad: uniform over the cone.
    #[must_use]
    pub fn bearing_sigma(&self) -> f64 {
        self.half_angle / 3.0_f64.sqrt()
    }

    /// What [`Self::cones`] may be.
    pub const CONES: Bounds = [1.0, 64.0];
    /// What [`Self::half_angle`] may be, rad.
    pub const HALF_ANGLE: Bounds = [0.02, 1.0];
    /// What [`Self::specular_angle`] may be, rad.
    pub const SPECULAR_ANGLE: Bounds = [0.0, FRAC_PI_2];
    /// What [`Self::period`] may be, s.
    pub const PERIOD: Bounds = [0.005, 1.0];
    /// What [`Self::max_range`] may be, m.
    pub const MAX_RANGE: Bounds = [0.5, 20.0];
    /// What [`Self::sigma`] may be, m.
    pub const SIGMA: Bounds = [1e-6, 0.5];
    /// What [`Self::sigma_per_metre`] may be, m/m.
    pub const SIGMA_PER_METRE: Bounds = [0.0, 0.2];

    pub(super) fn validate(&self) -> Result<(), SensorError> {
        let growth = self.sigma_per_metre;
        check_sensor(
            "sonar",
            &[
                ("cones", self.cones as f64, Self::CONES),
                ("half_angle", self.half_angle, Self::HALF_ANGLE),
                ("rays", self.rays as f64, [1.0, 1000.0]),
                ("specular_angle", self.specular_angle, Self::SPECULAR_ANGLE),
                ("period", self.period, Self::PERIOD),
                ("min_range", self.min_range, [0.0, Self::MAX_RANGE[0]]),
                ("max_range", self.max_range, Self::MAX_RANGE),
                ("sigma", self.sigma, Self::SIGMA),
                ("sigma_per_metre", growth, Self::SIGMA_PER_METRE),
                ("dropouts", self.dropouts, PART),
                ("outliers", self.outliers, PART),
            ],
        )
    }
}

/// Sonars in operation.
#[derive(Clone, Debug)]
pub(in crate::sim) struct Sonar {
    model: SonarModel,
    /// When the first round began, s.
    began: f64,
    /// Pings since then.
    pings: u64,
    /// Range and σ so far, of the round in progress.
    readings: Vec<(f32, f32)>,
}

impl Sonar {
    pub(super) fn new(model: &SonarModel) -> Self {
        Self {
            model: model.clone(),
            began: 0.0,
            pings: 0,
            readings: Vec::new(),
        }
    }

    pub(super) fn begin(&mut self, seconds: f64) {
        self.began = seconds;
        self.pings = 0;
        self.readings.clear();
    }

    pub(super) fn step(&mut self, span: &Span, view: &View, rng: &mut impl Rng) -> Option<Scan> {
        let mut scan = None;
        loop {
            let seconds = self.began + (self.pings + 1) as f64 * self.model.period;
            // Pings on the border of two steps belong to the first, despite rounding.
            if seconds > span.to + 1e-9 {
                return scan;
            }
            let axis = self.axis(self.readings.len());
            let reading = self.ping(seconds, axis, span, view, rng);
            self.readings.push(reading);
            self.pings += 1;
            if self.readings.len() == self.model.cones {
                scan = Some(self.complete(seconds));
            }
        }
    }

    /// Bearing of a sonar: counted round from the first, which looks backwards; if their number is
    /// even, one looks straight ahead.
    fn axis(&self, cone: usize) -> f64 {
        wrap(TAU * (cone as f64 / self.model.cones as f64 - 0.5))
    }

    fn complete(&mut self, seconds: f64) -> Scan {
        let cones = self.model.cones;
        let (ranges, sigmas) = std::mem::take(&mut self.readings).into_iter().unzip();
        Scan {
            stamp: Stamp::from_seconds(seconds),
            robot_from_sensor: self.model.robot_from_sensor,
            bearings: (0..cones).map(|cone| self.axis(cone)).collect(),
            ranges,
            sigmas,
            bearing_sigma: self.model.bearing_sigma(),
            max_range: self.model.max_range,
            sweep: self.model.period * cones.saturating_sub(1) as f64,
            qualities: vec![],
        }
    }

    /// One reading and its σ.
    fn ping(
        &self,
        seconds: f64,
        axis: f64,
        span: &Span,
        view: &View,
        rng: &mut impl Rng,
    ) -> (f32, f32) {
        let model = &self.model;
        // Drawn for every ping, so that one more wall does not change the noise of everything after
        // it.
        let luck: f64 = rng.random();
        let (of_range, _) = gaussian_pair(rng);
        let sigma = |range: f64| model.sigma_at(range) as f32;
        let silence = (f32::NAN, sigma(model.max_range));
        if luck < model.dropouts {
            return silence;
        }
        let nearest = self.nearest(seconds, axis, span, view);
        let Some(distance) = nearest.filter(|&distance| distance >= model.min_range) else {
            return silence;
        };
        let range = if luck > 1.0 - model.outliers {
            // The remainder of `luck` is uniform too.
            let part = (1.0 - luck) / model.outliers;
            model.min_range + part * (distance - model.min_range)
        } else {
            distance + model.sigma_at(distance) * of_range
        };
        if range > model.max_range {
            return silence;
        }
        let range = range.max(model.min_range);
        (range as f32, sigma(range))
    }

    /// The nearest surface in the cone that sends the ping back.
    fn nearest(&self, seconds: f64, axis: f64, span: &Span, view: &View) -> Option<f64> {
        let model = &self.model;
        let (origin, heading) = span.sensor_at(seconds, &model.robot_from_sensor);
        let between = 2.0 * model.half_angle / (model.rays.max(2) - 1) as f64;
        let is_single = model.rays == 1;
        let first = if is_single { 0.0 } else { -model.half_angle };
        let echo = |ray: usize| {
            let direction = unit_vector(heading + axis + first + between * ray as f64);
            view.sound(origin, direction, model.max_range, model.specular_angle)
        };
        (0..model.rays).filter_map(echo).min_by(f64::total_cmp)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::geom::{Segment, sin_cos};
    use crate::sim::{Caster, Disc, Material, Wall};

    fn wall(ax: f64, ay: f64, bx: f64, by: f64, material: Material) -> Wall {
        Wall {
            segment: Segment::new(Point2::new(ax, ay), Point2::new(bx, by)),
            material,
        }
    }

    fn model() -> SonarModel {
        SonarModel {
            sigma: 1e-6,
            sigma_per_metre: 0.0,
            dropouts: 0.0,
            outliers: 0.0,
            ..SonarModel::default()
        }
    }

    fn round(model: &SonarModel, walls: Vec<Wall>, movers: &[Disc]) -> Scan {
        let caster = Caster::new(walls);
        let view = View {
            caster: &caster,
            movers,
        };
        let here = (Point2::origin(), 0.0);
        let span = Span {
            from: 0.0,
            to: 0.4,
            start: here,
            end: here,
        };
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        Sonar::new(model).step(&span, &view, &mut rng).unwrap()
    }

    fn ahead(scan: &Scan) -> f32 {
        let beam = scan.bearings.iter().position(|b| b.abs() < 1e-9);
        scan.ranges[beam.unwrap()]
    }

    #[test]
    fn nearest_surface_of_the_cone_stands_on_its_axis() {
        // A board 10° beside the axis, in front of a wall: once facing the ring, once edge on.
        let far = wall(3.0, -3.0, 3.0, 3.0, Material::Opaque);
        let facing = wall(0.968, 0.272, 1.002, 0.0755, Material::Opaque);
        let edge_on = wall(0.9, 0.16, 1.1, 0.19, Material::Opaque);
        let scan = round(&model(), vec![far, facing], &[]);
        assert_eq!(scan.validate(), Ok(()));
        assert_eq!(scan.len(), 16);
        let foot = facing.segment.distance(Point2::origin());
        assert!(
            (f64::from(ahead(&scan)) - foot).abs() < 0.01,
            "{}",
            ahead(&scan)
        );
        let scan = round(&model(), vec![far, edge_on], &[]);
        assert!((ahead(&scan) - 3.0).abs() < 1e-3, "{}", ahead(&scan));
    }

    #[test]
    fn slanting_walls_are_silent_and_glass_and_people_are_not() {
        let slant = |degrees: f64| {
            let (sin, cos) = sin_cos(degrees.to_radians());
            let wall = wall(
                2.0 + 2.0 * sin,
                -2.0 * cos,
                2.0 - 2.0 * sin,
                2.0 * cos,
                Material::Glass,
            );
            ahead(&round(&model(), vec![wall], &[]))
        };
        assert!((slant(0.0) - 2.0).abs() < 1e-3);
        // Up to the mirror's angle and half a cone more, some ray still meets the wall squarely
        // enough.
        assert!(slant(38.0).is_finite());
        assert!(slant(42.0).is_nan());
        let person = Disc {
            centre: Point2::new(1.5, 0.1),
            radius: 0.2,
        };
        let scan = round(
            &model(),
            vec![wall(2.0, -1.0, 3.0, 5.0, Material::Opaque)],
            &[person],
        );
        let expect = libm::hypot(1.5, 0.1) - 0.2;
        assert!((f64::from(ahead(&scan)) - expect).abs() < 0.01);
        // No echo does not mean free room.
        assert!(
            round(&model(), vec![], &[])
                .ranges
                .iter()
                .all(|r| r.is_nan())
        );
    }
}
