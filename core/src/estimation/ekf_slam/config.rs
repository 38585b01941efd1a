//! Settings of the line filter.

use super::OdometryErrors;
use crate::association::AssociationConfig;
use crate::bounds::{Bounds, NOT_NEGATIVE, OutOfBounds, check, config};

/// Where the Jacobians are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Consistency {
    /// At the newest estimate: the textbook filter.
    Plain,
    /// At the first estimate of each landmark and the predicted pose, so that unobservable
    /// directions stay unobserved.
    FirstEstimates,
}

impl Consistency {
    /// All of them, with the names used by settings, and what a person calls them.
    pub const ALL: [(&'static str, Self, &'static str); 2] = [
        ("newest", Self::Plain, "the newest estimates"),
        ("first", Self::FirstEstimates, "the first estimates"),
    ];
}

/// Which features become landmarks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LandmarkKinds {
    /// Walls.
    Lines,
    /// Corners, and the centres of round objects.
    Points,
    /// Walls and points, in one state.
    Both,
}

impl LandmarkKinds {
    /// All of them, with the names used by settings, and what a person calls them.
    pub const ALL: [(&'static str, Self, &'static str); 3] = [
        ("lines", Self::Lines, "walls"),
        ("points", Self::Points, "corners and posts"),
        ("both", Self::Both, "walls, corners and posts"),
    ];

    /// Whether walls are among them.
    #[must_use]
    pub fn has_lines(self) -> bool {
        self != Self::Points
    }

    /// Whether points are among them.
    #[must_use]
    pub fn has_points(self) -> bool {
        self != Self::Lines
    }
}

config! {
    /// When two landmarks are surely one wall.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct MergeConfig {
        /// Largest d² of their difference. Default 13.82, 99.9 % of χ² with 2 degrees of freedom:
        /// parts of a wall that was seen for the last time are compared with the same error for
        /// ever; at 95 % one pair in twenty stayed apart. Larger: more wrong merges.
        pub gate: f64 = 13.82,
        /// The difference and two standard deviations of it must not be greater than this, rad.
        /// Default 0.05.
        pub alpha: f64 = 0.05,
        /// The same for r where the two parts are nearest, m. Default 0.04: less than a wall is
        /// thick.
        pub r: f64 = 0.04,
        /// A difference is known to be small if so many of its standard deviations are. Default 2;
        /// larger merges later.
        pub sigmas: f64 = 2.0,
        /// Parts of one wall in one scan may overlap by so much, m, as a corner's last beam is
        /// shared. Default 0.1.
        pub shared: f64 = 0.1,
        /// Two landmarks on one line count as doubles if they overlap by so much, m. Default 0.3;
        /// smaller drops more.
        pub doubled: f64 = 0.3,
        /// Two landmarks of a greater angle, rad, are not compared. Default 0.3.
        pub max_turn: f64 = 0.3,
    }
}

impl MergeConfig {
    /// Whether a difference with this variance is known to be at most `most`.
    pub(super) fn is_small(&self, difference: f64, variance: f64, most: f64) -> bool {
        let sigma = variance.max(0.0).sqrt();
        difference.abs().max(self.sigmas * sigma) <= most
    }
}

config! {
    /// Settings of the filter.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct EkfConfig {
        /// Which features become landmarks. Default walls: measured best (`report --
        /// point-landmarks`).
        pub landmarks: LandmarkKinds = LandmarkKinds::Lines,
        /// How sightings are matched.
        pub association: AssociationConfig = AssociationConfig::default(),
        /// When two landmarks become one.
        pub merge: MergeConfig = MergeConfig::default(),
        /// A line is not compared with a landmark whose direction differs by more, rad. Default
        /// 0.8: more than a robot turns unnoticed; smaller is quicker and loses a robot that did.
        pub max_turn: f64 = 0.8,
        /// A landmark is not compared closer if its r alone is further off than this many times the
        /// gate for new walls. Default 4; larger is slower.
        pub far_gates: f64 = 4.0,
        /// The known ends of a wall are as wide as so many standard deviations of the robot's
        /// position along it. Default 3; larger matches lines farther beside the known part.
        pub along_sigmas: f64 = 3.0,
        /// Where the Jacobians are taken.
        pub consistency: Consistency = Consistency::FirstEstimates,
        /// Sightings after which a line counts as a wall. Default 3.
        pub confirm_sightings: u32 = 3,
        /// Scans after which a line that is not confirmed is forgotten. Default 15.
        pub patience: u32 = 15,
        /// What the fit does not know about α (skew within a sweep, walls that are not flat), rad.
        /// Default 0.001. Added to each sighting; growing makes the filter more cautious. This and
        /// `r_sigma` are a part of why NIS is 0.83 of what it should be on tours (`report --
        /// ekf-consistency`). Without both it is 0.89, and the pose's NEES (3 is honest) at the end
        /// of 50 tours of `office` rises from 2.6 to 3.7, of `loop` from 3.4 to 4.4: the errors of
        /// a scan's sightings hang together.
        pub alpha_sigma: f64 = 0.001,
        /// What the fit does not know about r, m. Default 0.002.
        pub r_sigma: f64 = 0.002,
        /// What the fit does not know about where a corner or a post is, along each axis, m.
        /// Default 0.02: a corner's errors hang together from scan to scan. Growing makes the
        /// filter more cautious.
        pub point_sigma: f64 = 0.02,
        /// Of beams that a wall and a corner on it are both found by, the part that the corner is
        /// believed; the wall is believed the rest, so that no beam counts twice. Default 0.1. 0: a
        /// corner on a wall is not used at all.
        pub shared_part: f64 = 0.1,
        /// Standard deviations of the systematic errors of the odometry, known beforehand: by
        /// default 0.1 rad/m (tracks of the RP6 that run 2 % apart) and 0.03. 0 takes the odometry
        /// for free of them.
        pub odometry_prior: OdometryErrors = OdometryErrors {
            curvature: 0.1,
            turn_scale: 0.03,
        },
    }
}

impl EkfConfig {
    /// What [`MergeConfig::gate`] may be.
    pub const MERGE_GATE: Bounds = [0.1, 100.0];
    /// What [`Self::confirm_sightings`] may be.
    pub const CONFIRM_SIGHTINGS: Bounds = [1.0, 50.0];
    /// What [`Self::patience`] may be, scans.
    pub const PATIENCE: Bounds = [1.0, 10_000.0];
    /// What [`Self::alpha_sigma`] may be, rad.
    pub const ALPHA_SIGMA: Bounds = [0.0, 0.2];
    /// What [`Self::r_sigma`] may be, m.
    pub const R_SIGMA: Bounds = [0.0, 0.2];
    /// What [`Self::point_sigma`] may be, m.
    pub const POINT_SIGMA: Bounds = [0.0, 0.2];
    /// What [`Self::shared_part`] may be.
    pub const SHARED_PART: Bounds = [0.0, 0.5];
    /// What the curvature of [`Self::odometry_prior`] may be, rad/m.
    pub const PRIOR_CURVATURE: Bounds = [0.0, 1.0];
    /// What the turn scale of [`Self::odometry_prior`] may be.
    pub const PRIOR_TURN_SCALE: Bounds = [0.0, 0.5];

    /// Checks all settings.
    ///
    /// # Errors    [`OutOfBounds`] with the first one out of range.
    pub fn validate(&self) -> Result<(), OutOfBounds> {
        self.association.validate()?;
        let (merge, prior) = (&self.merge, &self.odometry_prior);
        let (curvature, turn) = (prior.curvature, prior.turn_scale);
        let sightings = f64::from(self.confirm_sightings);
        check(&[
            ("merge.gate", merge.gate, Self::MERGE_GATE),
            ("merge.alpha", merge.alpha, NOT_NEGATIVE),
            ("merge.r", merge.r, NOT_NEGATIVE),
            ("merge.sigmas", merge.sigmas, NOT_NEGATIVE),
            ("merge.shared", merge.shared, NOT_NEGATIVE),
            ("merge.doubled", merge.doubled, NOT_NEGATIVE),
            ("merge.max_turn", merge.max_turn, NOT_NEGATIVE),
            ("max_turn", self.max_turn, NOT_NEGATIVE),
            ("far_gates", self.far_gates, NOT_NEGATIVE),
            ("along_sigmas", self.along_sigmas, NOT_NEGATIVE),
            ("alpha_sigma", self.alpha_sigma, Self::ALPHA_SIGMA),
            ("r_sigma", self.r_sigma, Self::R_SIGMA),
            ("point_sigma", self.point_sigma, Self::POINT_SIGMA),
            ("shared_part", self.shared_part, Self::SHARED_PART),
            ("odometry_prior.curvature", curvature, Self::PRIOR_CURVATURE),
            ("odometry_prior.turn_scale", turn, Self::PRIOR_TURN_SCALE),
            ("confirm_sightings", sightings, Self::CONFIRM_SIGHTINGS),
            ("patience", f64::from(self.patience), Self::PATIENCE),
        ])
    }

    /// For a sensor that scans on command and sees little: every sighting counts, and nothing is
    /// forgotten soon.
    ///
    /// Between two scans of such a robot the heading drifts by degrees, not by tenths, and lines
    /// are short: the neglected higher-order terms grow with both. And a ranger's fitted
    /// characteristic errs by the same centimetre for all points of a wall, which no line fit to
    /// them can reveal. With 15 mrad and 15 mm for all that, the mean NEES of the pose (3 is
    /// honest) over errands of seeds 1 to 60 in `arena` is 2.8 and its error 9 cm at the goal; with
    /// 5 mrad and 4 mm it was 7.6 and 13 cm
    /// (`--example simulate -- --world arena --sensor rangers --mode goto`).
    #[must_use]
    pub fn short_range() -> Self {
        Self {
            confirm_sightings: 2,
            patience: 200,
            alpha_sigma: 0.015,
            r_sigma: 0.015,
            ..Self::default()
        }
    }
}
