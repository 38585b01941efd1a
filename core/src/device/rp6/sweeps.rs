//! Sweeps of an RP6's rangers: single readings in, whole scans out.
//!
//! 1. Readings of one sweep become one scan ([`RangerScans`]). It ends with the first reading of
//!    the next, or when telemetry says that the servo rests.
//! 2. A scan holds only what was seen from one place: a sweep during which the tracks ran is
//!    dropped.
//! 3. Sweeps of a single position, which are ordered while the robot drives
//!    ([`super::partial_scans`]), are partial scans.
//!
//! The rangers are assumed to be the long ones of the simulated robot; their characteristic is
//! fitted to the same pairs.

use crate::robot::{CharacteristicError, RangerModel, Scan};
use crate::wire::rp6::{Hello, Ranger, RangerScans, Telemetry};

/// If a track moved by more counts than this, about 5 mm, the robot did not stand.
const STOOD: u32 = 20;

/// Readings of the sweep under way.
#[derive(Clone, Debug)]
pub(super) struct Sweeps {
    scans: RangerScans,
    /// Counts of the tracks at the first telemetry of the sweep.
    began: Option<[i32; 2]>,
    /// The readings belong to partial scans.
    are_partial: bool,
}

/// What a sweep gave.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Swept {
    /// All round, from one place.
    Scan(Scan),
    /// A few readings while moving.
    PartialScan(Scan),
}

impl Sweeps {
    /// For the rangers that the robot reports; `None` if it has none.
    ///
    /// # Errors    If the calibration does not determine a characteristic.
    pub(super) fn of(hello: &Hello) -> Result<Option<Self>, CharacteristicError> {
        if hello.ranger_angles_mrad.is_empty() {
            return Ok(None);
        }
        Ok(Some(Self {
            scans: RangerScans::new(hello, RangerModel::long())?,
            began: None,
            are_partial: false,
        }))
    }

    /// Readings from here on belong to partial scans.
    pub(super) fn begin_partial(&mut self) {
        self.are_partial = true;
    }

    /// The robot has accepted a whole sweep: earlier readings do not count.
    pub(super) fn begin_sweep(&mut self) {
        if std::mem::take(&mut self.are_partial) {
            self.scans.spoil();
            // The counts of a partial scan say nothing about where the robot stands now.
            self.began = None;
        }
    }

    /// Takes a reading; returns the previous sweep if this reading begins another. Stamps are in
    /// the robot's time, ms.
    pub(super) fn reading(&mut self, reading: &Ranger) -> Option<Swept> {
        let scan = self.scans.take(reading)?;
        Some(self.swept(scan))
    }

    /// Takes the robot's telemetry; returns the sweep that it ends.
    pub(super) fn telemetry(&mut self, telemetry: &Telemetry) -> Option<Swept> {
        if !telemetry.state.sweeping() {
            self.began = None;
            let scan = self.scans.finish()?;
            return Some(self.swept(scan));
        }
        let began = *self.began.get_or_insert(telemetry.counts);
        let ran = |(now, then): (i32, i32)| now.wrapping_sub(then).unsigned_abs() > STOOD;
        if !self.are_partial && telemetry.counts.into_iter().zip(began).any(ran) {
            self.scans.spoil();
        }
        None
    }

    fn swept(&self, scan: Scan) -> Swept {
        match self.are_partial {
            true => Swept::PartialScan(scan),
            false => Swept::Scan(scan),
        }
    }
}
