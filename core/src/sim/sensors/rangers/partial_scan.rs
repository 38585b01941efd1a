//! Partial scans on the move; without them, a robot would see nothing until it stands and sweeps
//! again.
//!
//! 1. The servo points ahead, to one side, ahead, to the other ([`RangerModel::PARTIAL_SCAN`]). So
//!    four rangers at 90° to one another see twelve directions 30° apart in 0.4 s, those along the
//!    robot twice: a person of 0.2 m who is missed by all of them is at least half a metre away.
//! 2. All rangers are read [`RangerModel::period`] after the servo has had time to get there
//!    ([`PACE`]). The value held then may have been measured before, as in a sweep.
//! 3. Four readings are a scan of their own, but no picture of the room:
//!    [`crate::points::Walkers::partial_scan`] uses it.

use std::f64::consts::FRAC_PI_2;

use rand::{Rng, RngExt};

use super::{RANGERS, RangerModel, Rangers, Span, View};
use crate::geom::wrap;
use crate::robot::Scan;

/// The servo's time for a radian, s: a millisecond for each degree.
const PACE: f64 = 0.057;

/// The servo on its way to the next partial scan.
#[derive(Clone, Copy, Debug)]
pub(super) struct ServoMove {
    /// Index in [`RangerModel::PARTIAL_SCAN`].
    number: usize,
    /// The servo's previous angle, rad.
    from: f64,
    /// When it was commanded to move, s.
    commanded: f64,
}

impl ServoMove {
    fn to(&self) -> f64 {
        RangerModel::PARTIAL_SCAN[self.number % RangerModel::PARTIAL_SCAN.len()]
    }

    fn travel(&self) -> f64 {
        PACE * (self.to() - self.from).abs()
    }

    fn next(&self, commanded: f64) -> Self {
        Self {
            number: (self.number + 1) % RangerModel::PARTIAL_SCAN.len(),
            from: self.to(),
            commanded,
        }
    }
}

impl Rangers {
    /// The robot moves: partial scans follow one another until [`Self::stop_partial_scans`].
    pub(in crate::sim) fn start_partial_scans(&mut self, seconds: f64) {
        let from = self.servo_at_rest();
        self.servo_move.get_or_insert(ServoMove {
            number: 0,
            from,
            commanded: seconds,
        });
    }

    pub(in crate::sim) fn stop_partial_scans(&mut self) {
        self.servo_move = None;
    }

    /// The partial scan that is complete at the end of `span`.
    pub(in crate::sim) fn partial_scan(
        &mut self,
        span: &Span,
        view: &View,
        rng: &mut impl Rng,
    ) -> Option<Scan> {
        let servo = self.servo_move?;
        let read_at = servo.commanded + servo.travel() + self.model.period;
        if read_at > span.to + 1e-9 {
            return None;
        }
        self.servo_move = Some(servo.next(read_at));
        self.readings.clear();
        let stands_at = servo.commanded + servo.travel() + self.model.settle;
        for ranger in 0..RANGERS {
            let age = self.model.cycle * rng.random::<f64>();
            let mount = FRAC_PI_2 * ranger as f64;
            let of = |servo: f64| wrap(servo + mount);
            let is_early = read_at - age < stands_at;
            let measured = if is_early { servo.from } else { servo.to() };
            let volts = self.volts(read_at, of(measured), span, view, rng);
            let (range, sigma) = self.read(volts);
            self.readings.push((of(servo.to()), range, sigma));
        }
        Some(self.complete(read_at))
    }
}
