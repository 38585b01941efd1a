//! In: for each scan, how far the pose was off (NEES, if the truth is known) and how far the
//! sightings were from what was expected (NIS). Out: whether the filter is honest, and if not, the
//! likeliest cause.
//!
//! 1. Keep the last 25 scans: five seconds of a lidar.
//! 2. NIS is independent from scan to scan if the filter is right, so its sum is χ² with the sum of
//!    the degrees of freedom: a sharp test. NEES is not independent: a heading error persists for
//!    many scans. Its mean is compared with the band of one scan, which holds however the scans are
//!    correlated.
//! 3. Which of the two left its band, and on which side, identifies the cause: [`Diagnosis`].
//!
//! Source: Bar-Shalom, Li & Kirubarajan (2001), §5.4.

use std::cmp::Ordering;
use std::collections::VecDeque;

use crate::geom::chi2_quantile;

/// Scans that are judged together.
const WINDOW: usize = 25;
/// Half of the 95 % band, in standard deviations of a normal distribution.
const SIGMAS: f64 = 1.959_963_984_540_054;
/// Degrees of freedom of the pose.
const POSE_DEGREES: f64 = 3.0;

/// The consistency figures of the last scans.
#[derive(Clone, Debug, Default)]
pub struct ConsistencyWindow {
    nees: VecDeque<f64>,
    /// NIS and its degrees of freedom.
    nis: VecDeque<(f64, usize)>,
}

/// A figure, and the band in which it should lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// Mean over the window: for each scan (NEES), for each degree of freedom (NIS).
    pub mean: f64,
    /// The band that holds it in 95 of 100 windows if the filter is honest.
    pub band: [f64; 2],
}

/// What the figures say, and the likeliest cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Diagnosis {
    /// Too few scans to tell.
    Collecting,
    /// Nothing was recognised in the whole window: the estimate rests on odometry alone.
    Blind,
    /// Both figures (or the one that is known) lie in their bands.
    Honest,
    /// NEES and NIS too large: a wrong match, or slip beyond the odometry's noise.
    WrongMatch,
    /// NEES too large, NIS not: the map has turned with the robot. The heading drifts without any
    /// sighting showing it, due to linearisation or a systematic error of the odometry.
    HiddenDrift,
    /// NIS too large, NEES not: the sensor is noisier than assumed, walls are not flat, or
    /// something moves.
    NoisySightings,
    /// NEES or NIS too small, none too large: the assumed noise is larger than the real noise.
    Cautious,
}

impl Figure {
    /// On which side of its band it lies; equal if inside.
    fn side(&self) -> Ordering {
        match self.mean {
            mean if mean < self.band[0] => Ordering::Less,
            mean if mean > self.band[1] => Ordering::Greater,
            _ => Ordering::Equal,
        }
    }
}

impl ConsistencyWindow {
    /// Takes the figures of one scan; `nees` is `None` where the truth is not known.
    pub fn push(&mut self, nees: Option<f64>, nis: f64, nis_degrees: usize) {
        keep(&mut self.nis, (nis, nis_degrees));
        if let Some(nees) = nees {
            keep(&mut self.nees, nees);
        }
    }

    /// Mean NEES of the pose, with the band of a single scan; `None` without truth.
    #[must_use]
    pub fn nees(&self) -> Option<Figure> {
        (!self.nees.is_empty()).then(|| Figure {
            mean: self.nees.iter().sum::<f64>() / self.nees.len() as f64,
            band: [-SIGMAS, SIGMAS].map(|sigmas| chi2_quantile(POSE_DEGREES, sigmas)),
        })
    }

    /// NIS for each degree of freedom; `None` where nothing was recognised.
    #[must_use]
    pub fn nis(&self) -> Option<Figure> {
        let degrees = self.nis.iter().map(|(_, degrees)| degrees).sum::<usize>() as f64;
        (degrees > 0.0).then(|| Figure {
            mean: self.nis.iter().map(|(nis, _)| nis).sum::<f64>() / degrees,
            band: [-SIGMAS, SIGMAS].map(|sigmas| chi2_quantile(degrees, sigmas) / degrees),
        })
    }

    /// What the figures say.
    #[must_use]
    pub fn diagnosis(&self) -> Diagnosis {
        if self.nis.len() < WINDOW {
            return Diagnosis::Collecting;
        }
        let Some(nis) = self.nis() else {
            return Diagnosis::Blind;
        };
        let nees = self.nees().map_or(Ordering::Equal, |figure| figure.side());
        match (nees, nis.side()) {
            (Ordering::Greater, Ordering::Greater) => Diagnosis::WrongMatch,
            (Ordering::Greater, _) => Diagnosis::HiddenDrift,
            (_, Ordering::Greater) => Diagnosis::NoisySightings,
            (Ordering::Equal, Ordering::Equal) => Diagnosis::Honest,
            _ => Diagnosis::Cautious,
        }
    }
}

fn keep<T>(window: &mut VecDeque<T>, value: T) {
    if window.len() == WINDOW {
        window.pop_front();
    }
    window.push_back(value);
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// A window in which each of the pose's three errors is `pose` times what is claimed, and each
    /// of the innovations of four walls `sightings` times.
    fn window(seed: u64, pose: f64, sightings: f64) -> ConsistencyWindow {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut square = |scale: f64| {
            // Box & Muller (1958).
            let (u, v): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
            let normal = (-2.0 * libm::log(u)).sqrt() * libm::cos(std::f64::consts::TAU * v);
            let error = scale * normal;
            error * error
        };
        let mut window = ConsistencyWindow::default();
        for _ in 0..WINDOW {
            let nees = (0..3).map(|_| square(pose)).sum();
            let nis = (0..8).map(|_| square(sightings)).sum();
            window.push(Some(nees), nis, 8);
        }
        window
    }

    #[test]
    fn the_cause_is_named_by_what_left_its_band() {
        for (pose, sightings, expect) in [
            (1.0, 1.0, Diagnosis::Honest),
            (3.0, 3.0, Diagnosis::WrongMatch),
            (3.0, 1.0, Diagnosis::HiddenDrift),
            (3.0, 0.3, Diagnosis::HiddenDrift),
            (1.0, 2.0, Diagnosis::NoisySightings),
            (1.0, 0.5, Diagnosis::Cautious),
            (0.1, 1.0, Diagnosis::Cautious),
        ] {
            // In 5 of 100 windows, an honest figure leaves its band.
            let hits = (0..100)
                .filter(|&seed| window(seed, pose, sightings).diagnosis() == expect)
                .count();
            assert!(
                hits >= 88,
                "{pose} {sightings}: {hits} of 100 are {expect:?}"
            );
        }
    }

    #[test]
    fn honest_innovations_stay_in_their_band_in_95_of_100_windows() {
        let inside = (0..2000)
            .filter(|&seed| window(seed, 1.0, 1.0).nis().unwrap().side() == Ordering::Equal)
            .count();
        assert!((1870..=1930).contains(&inside), "{inside} of 2000");
    }

    #[test]
    fn without_truth_only_the_innovations_count() {
        let mut window = ConsistencyWindow::default();
        for _ in 0..WINDOW {
            assert_eq!(window.diagnosis(), Diagnosis::Collecting);
            window.push(None, 40.0, 8);
        }
        assert_eq!(window.nees(), None);
        assert_eq!(window.diagnosis(), Diagnosis::NoisySightings);
    }

    #[test]
    fn who_recognises_nothing_is_blind() {
        let mut window = ConsistencyWindow::default();
        for _ in 0..WINDOW {
            window.push(Some(1.0), 0.0, 0);
        }
        assert_eq!(window.nis(), None);
        assert_eq!(window.diagnosis(), Diagnosis::Blind);
        window.push(Some(1.0), 2.0, 2);
        assert_eq!(window.nis().unwrap().mean, 1.0);
    }
}
