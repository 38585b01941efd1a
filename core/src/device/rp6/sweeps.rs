//! Sweeps of an RP6's rangers: single readings in, whole scans out.
//!
//! 1. Readings of one sweep become one scan ([`SweepReader`]). It ends with the first reading of the next, or when telemetry
//!    says that the servo rests.
//! 2. A scan holds only what was seen from one place: a sweep during which the tracks ran is dropped.
//! 3. Sweeps of one position, which a robot that drives gets ([`super::looks`]), are looks.
//!
//! The rangers are taken to be the long ones that the simulated robot has; their characteristic is fitted to the same pairs.

use crate::robot::Scan;
use crate::sim::sensors::{RangerModel, SensorError};
use crate::wire::rp6::{Hello, Ranger, RangerFigures, SweepReader, Telemetry};

/// Counts of a track, about 5 mm, beyond which the robot did not stand.
const STOOD: u32 = 20;

/// Readings of the sweep under way.
#[derive(Clone, Debug)]
pub(super) struct Sweeps {
    reader: SweepReader,
    /// Counts of the tracks at the first telemetry of the sweep.
    began: Option<[i32; 2]>,
    /// What is read belongs to looks.
    are_looks: bool,
}

/// What a sweep gave.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Swept {
    /// All round, from one place.
    Scan(Scan),
    /// A few readings on the move.
    Look(Scan),
}

impl Sweeps {
    /// For the rangers that the robot says it has; `None` where it has none.
    ///
    /// # Errors    Where the calibration settles no characteristic.
    pub(super) fn of(hello: &Hello) -> Result<Option<Self>, SensorError> {
        if hello.ranger_angles_mrad.is_empty() {
            return Ok(None);
        }
        let model = RangerModel::long();
        let figures = RangerFigures {
            fit: model.fit()?,
            volts_sigma: model.volts_sigma,
            min_range: model.min_range,
            max_range: model.max_range,
            bearing_sigma: model.bearing_sigma,
            robot_from_sensor: model.robot_from_sensor,
        };
        Ok(Some(Self {
            reader: SweepReader::new(hello, figures),
            began: None,
            are_looks: false,
        }))
    }

    /// What is read from here on belongs to looks.
    pub(super) fn looks(&mut self) {
        self.are_looks = true;
    }

    /// The robot has taken an order to sweep all round: what was read before does not count.
    pub(super) fn sweeps(&mut self) {
        if std::mem::take(&mut self.are_looks) {
            self.reader.spoil();
            // Where the tracks were as it looked says nothing of where it stands now.
            self.began = None;
        }
    }

    /// Takes a reading; gives the sweep before, where this one begins another. Stamps are in the robot's time, ms.
    pub(super) fn reading(&mut self, reading: &Ranger) -> Option<Swept> {
        let scan = self.reader.take(reading)?;
        Some(self.swept(scan))
    }

    /// Takes what the robot says of itself; gives the sweep that it ends.
    pub(super) fn telemetry(&mut self, telemetry: &Telemetry) -> Option<Swept> {
        if !telemetry.state().sweeping() {
            self.began = None;
            let scan = self.reader.finish()?;
            return Some(self.swept(scan));
        }
        let began = *self.began.get_or_insert(telemetry.counts);
        let ran = |(now, then): (i32, i32)| now.wrapping_sub(then).unsigned_abs() > STOOD;
        if !self.are_looks && telemetry.counts.into_iter().zip(began).any(ran) {
            self.reader.spoil();
        }
        None
    }

    fn swept(&self, scan: Scan) -> Swept {
        match self.are_looks {
            true => Swept::Look(scan),
            false => Swept::Scan(scan),
        }
    }
}
