//! What counts as a straight piece of wall, and how the pieces are found.

use super::classic::Classic;
use super::fit::BadBeam;
use super::hough::Hough;
use super::noise_aware::NoiseAware;
use super::pilch::Pilch;
use super::ransac::Ransac;
use crate::bounds::{Bounds, OutOfBounds, PART, check, config, or_no_limit};
use crate::points::{BreakRule, SegmentationConfig, SpacingModel};

/// How a run of points is split into lines. The first three rules follow the points one after the
/// other; the last two look for lines among them in any order.
///
/// | rule | one line while | needs to know |
/// |---|---|---|
/// | [`NoiseAware`] | noise explains Σ\|d\| | σ of each beam |
/// | [`Classic`] | no point is farther than a threshold from the end-point line | a threshold that suits the noise |
/// | [`Pilch`] | S_E and r² of a growing line hold | a largest error that suits noise and length |
/// | [`Ransac`] | its points are within n σ of a line through two of them | σ of each beam |
/// | [`Hough`] | its points are within n σ of a line with many votes | σ of each beam |
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SplitRule {
    /// TDK 2016 §4.2.
    NoiseAware(NoiseAware),
    /// Pilch 2016 §1.2, the textbook's form.
    Classic(Classic),
    /// Pilch 2016 §3.5.1.
    Pilch(Pilch),
    /// Pilch 2016 §1.2.1: random sample consensus.
    Ransac(Ransac),
    /// Pilch 2016 §1.2.1: the Hough transform.
    Hough(Hough),
}

impl SplitRule {
    /// All rules with their default settings, with their names in settings and for people.
    /// calls them.
    #[must_use]
    pub fn all() -> [(&'static str, Self, &'static str); 5] {
        let noise_aware = Self::NoiseAware(NoiseAware::default());
        let classic = Self::Classic(Classic::default());
        let pilch = Self::Pilch(Pilch::default());
        let ransac = Self::Ransac(Ransac::default());
        let hough = Self::Hough(Hough::default());
        [
            ("noise-aware", noise_aware, "noise-aware (TDK 2016)"),
            ("classic", classic, "classic"),
            ("explained", pilch, "by explained scatter (Pilch 2016)"),
            ("ransac", ransac, "random samples (RANSAC)"),
            ("hough", hough, "votes (Hough transform)"),
        ]
    }
}

impl Default for SplitRule {
    fn default() -> Self {
        Self::NoiseAware(NoiseAware::default())
    }
}

/// What counts as a straight piece of wall.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LineConfig {
    /// How points are grouped before lines are extracted.
    pub segmentation: SegmentationConfig,
    /// How groups are split into lines. Default [`NoiseAware`].
    pub split: SplitRule,
    /// When two lines become one.
    pub merge: MergeConfig,
    /// Which lines are kept.
    pub accept: AcceptConfig,
}

config! {
    /// When two neighbouring pieces may be one line.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct MergeConfig {
        /// At most this many points between that belong to neither. Default 3.
        pub gap_points: usize = 3,
        /// At most this far apart where something lies between, m. Default 0.3: not over a door.
        pub gap: f64 = 0.3,
        /// Whether also where the points do not belong together: over a door, behind a pillar.
        /// Default no; `gap` then says how far.
        pub across_runs: bool = false,
    }
}

config! {
    /// Which lines are kept.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct AcceptConfig {
        /// Points given up at either end of a piece. Default 2: 1 gives longer lines and a less
        /// honest map.
        pub trim: usize = 2,
        /// Fewest points of a line. Default 7. Larger: fewer, safer lines.
        pub min_points: usize = 7,
        /// Shortest line, m. Default 0.5: people and most pillars are narrower.
        pub min_length: f64 = 0.5,
        /// Largest standard deviation of α, rad. Default 0.04: with 0.1 the filter's pose was 1.5
        /// times as far off as it said in `office` and `loop`; what is linear at 2° is not at 6°.
        pub max_alpha_sigma: f64 = 0.04,
        /// Largest χ² of the residuals, in standard deviations above its mean. Default 2.5: one
        /// true line in 160 is lost, and nearly every line across a corner.
        pub max_chi2_sigmas: f64 = 2.5,
        /// Largest bend (the quadratic term of the residuals) in standard deviations. Default 2:
        /// one true line in 20 is lost, most pillars go.
        pub max_bend_sigmas: f64 = 2.0,
        /// How far from flat a wall may be, m, one standard deviation. Default 0.002.
        pub surface_sigma: f64 = 0.002,
    }
}

impl AcceptConfig {
    /// Every line with at least this many points and this length, m, good or bad.
    #[must_use]
    pub fn all(min_points: usize, min_length: f64) -> Self {
        Self {
            trim: 0,
            min_points,
            min_length,
            max_alpha_sigma: f64::INFINITY,
            max_chi2_sigmas: f64::INFINITY,
            max_bend_sigmas: f64::INFINITY,
            ..Self::default()
        }
    }
}

impl LineConfig {
    /// For few, noisy readings of a short range: 180 from four infra-red rangers, over at most 1.5
    /// m.
    ///
    /// With the settings for lidars a sweep shows one line or none, because half of a wall is out
    /// of sight, and the sides of boxes are shorter than 0.5 m: the robot then reached its goal in
    /// 4 of 20 runs in `arena`, with these settings in 39 of 40. With these, people become walls
    /// for a scan or two; a robot that sees 1.5 m meets few.
    #[must_use]
    pub fn short_range() -> Self {
        Self {
            accept: AcceptConfig {
                min_length: 0.2,
                min_points: 5,
                trim: 1,
                max_alpha_sigma: 0.1,
                ..AcceptConfig::default()
            },
            ..Self::default()
        }
    }

    /// The textbook's split-and-merge, which knows nothing of noise: for comparison and teaching.
    #[must_use]
    pub fn classic(threshold: f64) -> Self {
        Self {
            split: SplitRule::Classic(Classic { threshold }),
            accept: AcceptConfig::all(7, 0.5),
            ..Self::default()
        }
    }

    /// The lines of Pilch 2016 §3.5.1, with neighbours closer than 2 k.
    #[must_use]
    pub fn pilch(spacing: SpacingModel) -> Self {
        let rule = Pilch::default();
        Self {
            segmentation: SegmentationConfig {
                rule: BreakRule::spacing(spacing),
                ..SegmentationConfig::default()
            },
            split: SplitRule::Pilch(rule),
            accept: AcceptConfig::all(rule.min_points, 0.0),
            ..Self::default()
        }
    }

    /// What [`SegmentationConfig::max_step`] may be, rad.
    pub const MAX_STEP: Bounds = [0.005, 1.0];
    /// What the grazing angle of [`BreakRule::Adaptive`] may be, rad.
    pub const GRAZING_ANGLE: Bounds = [0.01, 1.5];
    /// What the noise allowed by [`BreakRule::Adaptive`] may be, standard deviations.
    pub const BREAK_SIGMAS: Bounds = [0.0, 20.0];
    /// What the ratio of [`BreakRule::MeanRatio`] and [`BreakRule::Spacing`] may be.
    pub const BREAK_RATIO: Bounds = [1.0, 50.0];
    /// What [`SpacingModel::slope`] may be, m per m of range.
    pub const SPACING_SLOPE: Bounds = [0.0, 1.0];
    /// What [`SpacingModel::offset`] may be, m.
    pub const SPACING_OFFSET: Bounds = [0.0, 1.0];
    /// What [`NoiseAware::split_k`] may be.
    pub const SPLIT_K: Bounds = [0.5, 10.0];
    /// What [`NoiseAware::max_residual`] may be, standard deviations.
    pub const MAX_RESIDUAL: Bounds = [1.0, 20.0];
    /// What [`Classic::threshold`] may be, m.
    pub const THRESHOLD: Bounds = [0.005, 1.0];
    /// What [`Pilch::max_error`] may be, m².
    pub const MAX_ERROR: Bounds = [0.0001, 1.0];
    /// What [`Pilch::min_r2`] may be.
    pub const MIN_R2: Bounds = PART;
    /// What [`Ransac::inlier_sigmas`] and [`Hough::inlier_sigmas`] may be.
    pub const INLIER_SIGMAS: Bounds = [0.5, 10.0];
    /// What [`Ransac::confidence`] may be.
    pub const CONFIDENCE: Bounds = [0.5, 0.9999];
    /// What [`Ransac::max_samples`] may be.
    pub const MAX_SAMPLES: Bounds = [10.0, 10_000.0];
    /// What [`Hough::alpha_step`] may be, rad.
    pub const ALPHA_STEP: Bounds = [0.005, 0.2];
    /// What [`Hough::r_step`] may be, m.
    pub const R_STEP: Bounds = [0.005, 0.5];
    /// What [`MergeConfig::gap`] may be, m.
    pub const GAP: Bounds = [0.0, 2.0];
    /// What [`AcceptConfig::min_length`] may be, m.
    pub const MIN_LENGTH: Bounds = [0.0, 5.0];
    /// What [`AcceptConfig::max_alpha_sigma`] may be, rad.
    pub const MAX_ALPHA_SIGMA: Bounds = [0.001, 1.0];
    /// What [`AcceptConfig::max_chi2_sigmas`] and [`AcceptConfig::max_bend_sigmas`] may be.
    pub const MAX_SIGMAS: Bounds = [0.5, 100.0];
    /// What [`AcceptConfig::surface_sigma`] may be, m.
    pub const SURFACE_SIGMA: Bounds = [0.0, 0.1];

    /// Checks all settings. Upper limits of a line can be infinite: then all lines are kept.
    ///
    /// # Errors    [`LineError::Bounds`] with the first one out of range.
    pub fn validate(&self) -> Result<(), LineError> {
        let limit = |figure, value, bounds| (figure, or_no_limit(value, bounds), bounds);
        let (accept, step) = (&self.accept, self.segmentation.max_step);
        let (chi2, bend) = (accept.max_chi2_sigmas, accept.max_bend_sigmas);
        let (alpha, surface) = (accept.max_alpha_sigma, accept.surface_sigma);
        check(&[
            ("segmentation.max_step", step, Self::MAX_STEP),
            ("merge.gap", self.merge.gap, Self::GAP),
            ("accept.min_length", accept.min_length, Self::MIN_LENGTH),
            limit("accept.max_alpha_sigma", alpha, Self::MAX_ALPHA_SIGMA),
            limit("accept.max_chi2_sigmas", chi2, Self::MAX_SIGMAS),
            limit("accept.max_bend_sigmas", bend, Self::MAX_SIGMAS),
            ("accept.surface_sigma", surface, Self::SURFACE_SIGMA),
        ])?;
        match self.split {
            SplitRule::NoiseAware(rule) => check(&[
                ("split.split_k", rule.split_k, Self::SPLIT_K),
                limit("split.max_residual", rule.max_residual, Self::MAX_RESIDUAL),
            ])?,
            SplitRule::Classic(rule) => {
                check(&[("split.threshold", rule.threshold, Self::THRESHOLD)])?;
            }
            SplitRule::Pilch(rule) => check(&[
                ("split.max_error", rule.max_error, Self::MAX_ERROR),
                ("split.min_r2", rule.min_r2, Self::MIN_R2),
            ])?,
            SplitRule::Ransac(rule) => check(&[
                (
                    "split.inlier_sigmas",
                    rule.inlier_sigmas,
                    Self::INLIER_SIGMAS,
                ),
                ("split.confidence", rule.confidence, Self::CONFIDENCE),
                (
                    "split.max_samples",
                    rule.max_samples.into(),
                    Self::MAX_SAMPLES,
                ),
            ])?,
            SplitRule::Hough(rule) => check(&[
                (
                    "split.inlier_sigmas",
                    rule.inlier_sigmas,
                    Self::INLIER_SIGMAS,
                ),
                ("split.alpha_step", rule.alpha_step, Self::ALPHA_STEP),
                ("split.r_step", rule.r_step, Self::R_STEP),
            ])?,
        }
        Ok(match self.segmentation.rule {
            BreakRule::Adaptive {
                grazing_angle: angle,
                n_sigmas,
            } => check(&[
                ("segmentation.grazing_angle", angle, Self::GRAZING_ANGLE),
                ("segmentation.n_sigmas", n_sigmas, Self::BREAK_SIGMAS),
            ]),
            BreakRule::MeanRatio { ratio } => {
                check(&[("segmentation.ratio", ratio, Self::BREAK_RATIO)])
            }
            BreakRule::Spacing {
                spacing: SpacingModel { slope, offset },
                ratio,
            } => check(&[
                ("segmentation.ratio", ratio, Self::BREAK_RATIO),
                ("segmentation.spacing.slope", slope, Self::SPACING_SLOPE),
                ("segmentation.spacing.offset", offset, Self::SPACING_OFFSET),
            ]),
        }?)
    }
}

/// Why no lines, or points, can be found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LineError {
    /// A beam whose numbers cannot be used.
    #[error(transparent)]
    Beam(#[from] BadBeam),
    /// A figure of [`LineConfig`] or [`super::PointFeatureConfig`] out of its bounds.
    #[error(transparent)]
    Bounds(#[from] OutOfBounds),
}
