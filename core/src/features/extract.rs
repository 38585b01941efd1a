//! In: [`Points`]. Out: [`LineFeature`]s, one for each straight piece that is surely a wall.
//!
//! 1. Runs of neighbouring beams ([`segment`]).
//! 2. Split, by the chosen [`SplitRule`].
//! 3. Merge ([`super::merge`]).
//! 4. Fit with covariance, and a test of each line ([`super::accept`]).
//!
//! Lines and tests of sub-ranges use prefix sums, so a split costs one pass over its points.

use std::ops::Range;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::accept::accept;
use super::columns::{Columns, Noise};
use super::config::{LineConfig, LineError, SplitRule};
use super::feature::LineFeature;
use super::fit::{check_beams, is_usable};
use super::hough::Accumulator;
use super::merge::merge;
use super::moments::Moments;
use super::piece::Piece;
use crate::bounds::{self, NOT_NEGATIVE};
use crate::points::{Points, Run, segment};

/// Extracts lines; keeps its buffers between scans.
#[derive(Clone, Debug, Default)]
pub struct LineExtractor {
    config: LineConfig,
    runs: Vec<Run>,
    /// Where each run begins in `columns`.
    run_starts: Vec<usize>,
    columns: Columns,
    pieces: Vec<Piece>,
    /// Buffers for the rules.
    stack: Vec<Piece>,
    sums: Vec<Moments>,
    accumulator: Accumulator,
}

impl LineExtractor {
    /// An extractor with the given settings, which must have passed [`LineConfig::validate`].
    #[must_use]
    pub fn new(config: LineConfig) -> Self {
        Self {
            config,
            ..Self::default()
        }
    }

    /// The lines in `points`, written to `lines` (cleared first) in the order of the beams.
    ///
    /// # Units    Robot frame; (α, r) in rad and m.
    /// # Errors   [`LineError`] for a beam with a number that is not finite; `lines` is then
    /// unchanged. Points that no line fits are no error: there is no line then.
    /// # Source   See [`SplitRule`].
    pub fn extract(
        &mut self,
        points: &Points,
        lines: &mut Vec<LineFeature>,
    ) -> Result<(), LineError> {
        self.find_pieces(points)?;
        lines.clear();
        for &piece in &self.pieces {
            if let Some((fit, chi2)) = accept(&mut self.columns, piece, &self.config.accept) {
                let beam = points.beams.get(self.columns.source(fit.first));
                let origin = beam.map_or(points.sensor_in_robot, |beam| beam.origin_in_robot);
                lines.push(fit.feature(&self.columns, chi2, origin));
            }
        }
        Ok(())
    }

    /// Steps 1 to 3.
    fn find_pieces(&mut self, points: &Points) -> Result<(), LineError> {
        segment(points, &self.config.segmentation, &mut self.runs);
        self.load(points)?;
        self.split();
        merge(
            &mut self.columns,
            &mut self.pieces,
            &self.run_starts,
            &self.config.split,
            &self.config.merge,
        );
        Ok(())
    }

    /// Fills the columns with the runs that are long enough.
    fn load(&mut self, points: &Points) -> Result<(), LineError> {
        let min_points = self.config.accept.min_points.max(3);
        let mut is_suspect = false;
        self.runs.retain(|run| {
            let is_long = run.len >= min_points;
            // A beam that is not a number belongs to no neighbour, so it is a short run.
            is_suspect |= !is_long && !run.beams(points).all(is_usable);
            is_long
        });
        bounds::check(&[("bearing sigma", points.bearing_sigma, NOT_NEGATIVE)])?;
        let noise = Noise {
            bearing_sigma: points.bearing_sigma,
            surface_sigma: self.config.accept.surface_sigma,
        };
        let n_beams = points.beams.len();
        let ranges = self.runs.iter().flat_map(|run| run.ranges(n_beams));
        self.columns.load(&points.beams, ranges, noise);
        self.run_starts.clear();
        let mut start = 0;
        for run in &self.runs {
            self.run_starts.push(start);
            start += run.len;
        }
        if is_suspect || !self.columns.is_usable() {
            check_beams(points.hits())?;
        }
        Ok(())
    }

    fn split(&mut self) {
        self.pieces.clear();
        let Self {
            columns,
            pieces,
            stack,
            sums,
            accumulator,
            ..
        } = self;
        let few = self.config.accept.min_points.max(3);
        let seed = match &self.config.split {
            SplitRule::Ransac(rule) => rule.seed,
            _ => 0,
        };
        let mut rng = ChaCha8Rng::seed_from_u64(seed.into());
        for (&start, run) in self.run_starts.iter().zip(&self.runs) {
            let range: Range<usize> = start..start + run.len;
            match &self.config.split {
                SplitRule::NoiseAware(rule) => rule.split(columns, range, stack, pieces),
                SplitRule::Classic(rule) => rule.split(columns, range, stack, pieces),
                SplitRule::Pilch(rule) => rule.split(columns, range, sums, pieces),
                SplitRule::Ransac(rule) => rule.split(columns, range, few, &mut rng, pieces),
                SplitRule::Hough(rule) => rule.split(columns, range, few, accumulator, pieces),
            }
        }
    }
}

#[cfg(test)]
mod degenerate_tests;
#[cfg(test)]
mod tests;
