//! From single readings of a turning lidar to whole revolutions.
//!
//! In: readings in the order in which they were taken, angles clockwise as on the wire. Out: one
//! [`Scan`] per turn, angles counter-clockwise, beams evenly spaced in time as [`Scan`] promises.
//!
//! 1. A reading far from the one before it waits until the next one confirms it; otherwise it was
//!    damaged on the wire and is dropped. So one wrong angle costs one reading.
//! 2. The turn ends where the angle passes the seam, which lies behind the sensor: there it is
//!    least likely to cut an object in two. The start flag on the wire is not used, because one
//!    flipped bit would join or split turns.
//! 3. Invalid beams (NaN) replace lost readings, which keeps the instants of the others right. A
//!    turn that lost more than a certain part is dropped.
//! 4. Bearing = -angle. A lidar that turns clockwise gives decreasing bearings: beams are ordered
//!    by time.
//!    time.
//! 5. The scan has qualities where every reading had one. An express scan of an RPLIDAR has none.
//!
//! Distance 0 and too low a quality are invalid: they say nothing, not even that the space is free.
//! A range beyond the greatest trusted one is a no-return (infinite): up to there, space is free.

use std::f64::consts::{PI, TAU};

use crate::geom::{Pose2, wrap};
use crate::robot::{Place, Scan, Stamp, places_of_revolution};

/// A reading more than this ahead of the one before it, or behind it, must be confirmed, rad (10°).
const SURE_STEP: f64 = 10.0 * PI / 180.0;
/// σ of the bearing, rad.
const BEARING_SIGMA: f64 = 0.001;
/// Readings of lower quality are invalid; greater drops weak echoes, those of far and dark
/// surfaces.
const LEAST_QUALITY: u8 = 1;
/// Where a turn ends, rad, clockwise from the sensor's x axis: behind it.
const SEAM: f64 = PI;
/// A turn that lost more than this part of its readings is dropped; greater lets through sparser
/// scans.
const MOST_LOST: f64 = 0.5;
/// More readings without a seam mean that the sensor does not turn: no lidar of this kind takes
/// this many in one turn.
const MOST_BEAMS: usize = 20_000;

/// One reading of a turning lidar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Direction, rad, clockwise from the sensor's x axis, any number of turns.
    pub angle: f64,
    /// Range, m; 0 means invalid.
    pub range: f64,
    /// Quality, in the sensor's own unit; `None` if it gives none.
    pub quality: Option<u8>,
    /// Seconds since the reading before it, by the sensor's own figures.
    pub interval: f64,
    /// When it was taken.
    pub stamp: Stamp,
}

/// What the sensor can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Nearer readings are invalid, m.
    pub min_range: f64,
    /// Farther readings are no-returns, m.
    pub max_range: f64,
    /// σ of the range at no distance, m.
    pub sigma: f64,
    /// Growth of that σ with distance, m/m.
    pub sigma_per_metre: f64,
}

/// Assembles readings into revolutions.
#[derive(Clone, Debug)]
pub struct Revolutions {
    figures: Figures,
    robot_from_sensor: Pose2,
    beams: Vec<Beam>,
    /// Angle from the seam to the last reading, rad, unwrapped; `None` before the first reading.
    turned: Option<f64>,
    /// Whether `beams` began at a seam.
    is_whole: bool,
    unconfirmed: Option<Sample>,
}

#[derive(Clone, Copy, Debug)]
struct Beam {
    /// Angle from the seam, rad.
    turned: f64,
    range: f32,
    sigma: f32,
    quality: Option<u8>,
    interval: f64,
    stamp: Stamp,
}

impl Revolutions {
    /// A collector that waits for the first seam.
    #[must_use]
    pub fn new(figures: Figures, robot_from_sensor: Pose2) -> Self {
        Self {
            figures,
            robot_from_sensor,
            beams: vec![],
            turned: None,
            is_whole: false,
            unconfirmed: None,
        }
    }

    /// Takes a reading; returns the turn that it ends.
    ///
    /// A reading whose angle, range or interval is not finite is dropped and counts as lost.
    pub fn push(&mut self, sample: Sample) -> Option<Scan> {
        if !(sample.angle.is_finite() && sample.range.is_finite() && sample.interval.is_finite()) {
            return None;
        }
        let Some(turned) = self.turned else {
            self.turned = Some((sample.angle - SEAM).rem_euclid(TAU));
            return None;
        };
        if self.step_to(turned, &sample).abs() <= SURE_STEP {
            self.unconfirmed = None;
            return self.take(turned, sample);
        }
        let waiting = self.unconfirmed.replace(sample)?;
        if wrap(sample.angle - waiting.angle).abs() > SURE_STEP {
            return None;
        }
        // The two agree, so readings were lost before them. The sensor turns one way only.
        self.unconfirmed = None;
        let ended = self.take_after_gap(turned, waiting);
        let turned = self.turned.unwrap_or(turned);
        ended.or(self.take(turned, sample))
    }

    /// Drops the turn under way: after a break, its parts do not belong together.
    pub fn restart(&mut self) {
        self.beams.clear();
        self.turned = None;
        self.is_whole = false;
        self.unconfirmed = None;
    }

    /// The angle from the last reading to this one, in (-π, π].
    fn step_to(&self, turned: f64, sample: &Sample) -> f64 {
        wrap(sample.angle - SEAM - turned)
    }

    fn take_after_gap(&mut self, turned: f64, sample: Sample) -> Option<Scan> {
        let step = self.step_to(turned, &sample).rem_euclid(TAU);
        self.take_step(turned + step, sample)
    }

    fn take(&mut self, turned: f64, sample: Sample) -> Option<Scan> {
        let step = self.step_to(turned, &sample);
        self.take_step(turned + step, sample)
    }

    fn take_step(&mut self, turned: f64, sample: Sample) -> Option<Scan> {
        let mut ended = None;
        let mut turned = turned;
        if turned >= TAU {
            turned -= TAU;
            if self.is_whole {
                ended = self.finish();
            }
            self.beams.clear();
            self.is_whole = true;
        }
        if self.beams.len() >= MOST_BEAMS {
            self.beams.clear();
            self.is_whole = false;
        }
        self.turned = Some(turned);
        let (range, sigma) = self.read(&sample);
        self.beams.push(Beam {
            turned,
            range,
            sigma,
            quality: sample
                .quality
                .map(|q| if range.is_finite() { q } else { 0 }),
            interval: sample.interval,
            stamp: sample.stamp,
        });
        ended
    }

    /// Range and σ as a scan holds them.
    fn read(&self, sample: &Sample) -> (f32, f32) {
        let figures = &self.figures;
        let sigma = |range: f64| (figures.sigma + figures.sigma_per_metre * range) as f32;
        let range = sample.range;
        if range < figures.min_range || sample.quality.is_some_and(|q| q < LEAST_QUALITY) {
            (f32::NAN, sigma(figures.max_range))
        } else if range > figures.max_range {
            (f32::INFINITY, sigma(figures.max_range))
        } else {
            (range as f32, sigma(range))
        }
    }

    fn finish(&mut self) -> Option<Scan> {
        let last = *self.beams.last()?;
        let taken = self.beams.len();
        let beams = with_gaps_filled(&self.beams);
        let lost = beams.len() - taken;
        if lost as f64 > MOST_LOST * beams.len() as f64 {
            return None;
        }
        let interval = self.beams.iter().map(|beam| beam.interval).sum::<f64>() / taken as f64;
        let qualities: Option<Vec<u8>> = beams.iter().map(|beam| beam.quality).collect();
        let bearing = |beam: &Beam| wrap(-(beam.turned + SEAM));
        Some(Scan {
            stamp: last.stamp,
            robot_from_sensor: self.robot_from_sensor,
            bearings: beams.iter().map(bearing).collect(),
            ranges: beams.iter().map(|beam| beam.range).collect(),
            sigmas: beams.iter().map(|beam| beam.sigma).collect(),
            qualities: qualities.unwrap_or_default(),
            bearing_sigma: BEARING_SIGMA,
            max_range: self.figures.max_range,
            sweep: interval.max(0.0) * (beams.len() - 1) as f64,
        })
    }
}

/// The beams of a turn, with invalid ones in place of missing ones.
fn with_gaps_filled(beams: &[Beam]) -> Vec<Beam> {
    let turned: Vec<f64> = beams.iter().map(|beam| beam.turned).collect();
    let places = places_of_revolution(&turned).into_iter();
    let filled = places.filter_map(|place| match place {
        Place::Taken(beam) => beams.get(beam).copied(),
        Place::Lost(turned) => beams.last().map(|like| Beam {
            turned,
            range: f32::NAN,
            quality: like.quality.map(|_| 0),
            ..*like
        }),
    });
    filled.collect()
}

#[cfg(test)]
mod tests;
