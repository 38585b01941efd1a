//! The cycle stage by stage (TDK 2016 §6.3): the same run, cut finer.
//!
//! In: an experiment that drives by the cycle. Out: the same states in the same order as without, stopped after each stage,
//! with a [`StageReport`] of what it gave. No simulated time passes between scan, lines, localise, map, plan and truncate.

use super::{Experiment, READINGS, Sample, situation};
use crate::pilot::{Stage, StageReport};
use crate::robot::Scan;
use crate::slam::{ScanPart, SlamError};

/// Pieces of work that one stage may take: ten simulated minutes of turning or sweeping.
const MOST_PIECES: u32 = 72_000;

impl Experiment {
    /// Goes on to the end of the next stage, and tells which it was; `None` where the errand is over or there is none. The
    /// bits of the run are those of [`Self::step`].
    ///
    /// # Errors    [`SlamError`] for a scan that cannot be used; the simulated sensors make none such.
    pub fn next_stage(&mut self) -> Result<Option<Stage>, SlamError> {
        for _ in 0..MOST_PIECES {
            let told = self.pilot.cycle().told();
            self.piece()?;
            let cycle = self.pilot.cycle();
            // That the sensor begins to look round is no end of a stage.
            let looks = cycle.now().and_then(|stage| cycle.report(stage));
            if cycle.told() > told && looks != Some(&StageReport::LooksRound) {
                return Ok(cycle.now());
            }
            if self.pilot.status().is_over() || !self.is_in_cycle() {
                return Ok(None);
            }
        }
        Ok(None)
    }

    /// The least that can be done: a part of a scan, a reading, or a stage of the pilot.
    fn piece(&mut self) -> Result<(), SlamError> {
        if self.continue_scan()? {
            return Ok(());
        }
        if self.readings < READINGS {
            return match self.read()? {
                Some(scan) => self.begin_scan(scan),
                None => Ok(()),
            };
        }
        let estimate = self.slam.estimate();
        let now = situation(&self.sim, &self.slam, &estimate);
        let (command, has_more) = self.pilot.steer_by_stage(&now);
        if !has_more {
            self.obey(command);
        }
        Ok(())
    }

    pub(super) fn begin_scan(&mut self, scan: Scan) -> Result<(), SlamError> {
        self.before_scan = self.slam.estimate().pose;
        self.slam.begin_scan(scan)?;
        if let Some(points) = self.slam.pending_points().filter(|_| self.is_in_cycle()) {
            let (readings, hits) = (points.beams.len(), points.hits().count());
            self.pilot.tell(StageReport::Scan { readings, hits });
        }
        Ok(())
    }

    /// The rest of the scan that was begun; tells whether there was one.
    pub(super) fn complete_scan(&mut self) -> Result<bool, SlamError> {
        let has_one = self.continue_scan()?;
        while self.continue_scan()? {}
        Ok(has_one)
    }

    /// The next part of the scan that was begun; tells whether there was one.
    fn continue_scan(&mut self) -> Result<bool, SlamError> {
        let Some(part) = self.slam.continue_scan()? else {
            return Ok(false);
        };
        if self.is_in_cycle() {
            self.tell(part);
        }
        if part == ScanPart::Map {
            let sample = Sample {
                stamp: self.sim.stamp(),
                truth: self.truth(),
                estimate: self.slam.estimate(),
                odometry: self.dead_reckoning,
            };
            self.record.push(sample, self.slam.explain());
        }
        Ok(true)
    }

    fn tell(&mut self, part: ScanPart) {
        let slam = &self.slam;
        let report = match part {
            ScanPart::Lines => StageReport::Lines {
                lines: slam.features().len(),
                points: slam.features().iter().map(|line| line.n_points).sum(),
            },
            ScanPart::Localise => {
                let estimate = slam.estimate();
                let counts = slam.explain().map_or([0; 3], |report| {
                    [
                        report.matches.len(),
                        report.added.len(),
                        report.rejected.len(),
                    ]
                });
                let [matched, added, rejected] = counts;
                let moved = (estimate.pose.position() - self.before_scan.position()).norm();
                StageReport::Localise {
                    matched,
                    added,
                    rejected,
                    estimate,
                    moved,
                }
            }
            ScanPart::Map => {
                let walls = slam.landmarks();
                StageReport::Map {
                    confirmed: walls.iter().filter(|wall| wall.is_confirmed).count(),
                    walls: walls.len(),
                }
            }
        };
        self.pilot.tell(report);
    }
}
