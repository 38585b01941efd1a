//! Settings of the tracking of moving objects.

use crate::bounds::{Bounds, OutOfBounds, check, config};

/// How sightings are associated with tracks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TrackAssociation {
    /// Each sighting to one track, with the least total distance (global nearest neighbour).
    Nearest,
    /// Each sighting to all tracks to which it may belong, by the probability of all joint events.
    #[default]
    Jpda,
    /// To no track: a density over the positions of moving objects takes them all (GM-PHD).
    GmPhd,
}

impl TrackAssociation {
    /// All variants, with their names in settings and their names for people.
    pub const ALL: [(&'static str, Self, &'static str); 3] = [
        ("nearest", Self::Nearest, "nearest neighbours"),
        ("jpda", Self::Jpda, "joint probabilities (JPDA)"),
        ("gm-phd", Self::GmPhd, "Gaussian mixture (GM-PHD)"),
    ];
}

config! {
    /// How moving objects are found and followed.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct TrackingConfig {
        /// Whether they are looked for at all. Default true.
        pub is_on: bool = true,
        /// Whether their points are kept out of pose and map. Default false: the recorded buildings
        /// came out no better with it, some worse (`report -- buildings`).
        pub keeps_out: bool = false,
        /// How sightings are given to tracks. Default [`TrackAssociation::Jpda`].
        pub association: TrackAssociation = TrackAssociation::default(),
        /// How sure a hit has to be in free space, m: it is farther than this from all that is not
        /// known to be free. Default 0.1. Growing: who walks along a wall is found later, walls are
        /// taken for people more seldom.
        pub margin: f64 = 0.1,
        /// Widest thing that may move, m. Default 0.9: a person with a bag. Growing: walls that are
        /// misplaced may become tracks.
        pub max_width: f64 = 0.9,
        /// Fewest hits of a sighting. Default 3. Growing: fewer false tracks, people are seen less
        /// far away.
        pub min_hits: usize = 3,
        /// Standard deviation of a sighting's place, m: of the middle of what is seen of one side
        /// only. Default 0.05. Growing: calmer tracks, that move later.
        pub position_sigma: f64 = 0.05,
        /// Spectral density of the white noise of acceleration, m²/s³: how fast velocities change.
        /// Default 0.4: people stop and turn within a step. Growing: tracks follow faster and
        /// scatter more.
        pub acceleration: f64 = 0.4,
        /// Farthest that a sighting may be from a track, squared Mahalanobis distance. Default
        /// 13.8: 99.9 % of what is its own.
        pub gate: f64 = 13.8,
        /// Probability that an object is seen in a scan. Default 0.9. Growing: hidden ones are
        /// forgotten sooner.
        pub detection: f64 = 0.9,
        /// False sightings for each square metre. Default 0.02. Growing: tracks are begun and kept
        /// more cautiously.
        pub clutter: f64 = 0.02,
        /// A track that is not seen any more goes on for so long, s. Default 1.5.
        pub coast: f64 = 1.5,
        /// Squared Mahalanobis distance from standing still, of the mean velocity over the last two
        /// seconds, from which on a track moves. Default 13.8: one in a thousand that stand seems
        /// to. Growing: slow ones are seen to move later.
        pub significance: f64 = 13.8,
        /// Who moved and stands still may move on for so long at most, s, and for a second for each
        /// scan that saw them move; then belongs into the map. Default 15. Growing: people who stop
        /// stay out of it for longer.
        pub memory: f64 = 15.0,
    }
}

impl TrackingConfig {
    /// Bounds of [`Self::margin`], m.
    pub const MARGIN: Bounds = [0.0, 1.0];
    /// Bounds of [`Self::max_width`], m.
    pub const MAX_WIDTH: Bounds = [0.1, 5.0];
    /// Bounds of [`Self::min_hits`].
    pub const MIN_HITS: Bounds = [1.0, 50.0];
    /// Bounds of [`Self::position_sigma`], m.
    pub const POSITION_SIGMA: Bounds = [0.001, 1.0];
    /// Bounds of [`Self::acceleration`], m²/s³.
    pub const ACCELERATION: Bounds = [0.001, 50.0];
    /// Bounds of [`Self::gate`] and [`Self::significance`].
    pub const GATE: Bounds = [1.0, 100.0];
    /// Bounds of [`Self::detection`].
    pub const DETECTION: Bounds = [0.05, 0.999];
    /// Bounds of [`Self::clutter`], 1/m².
    pub const CLUTTER: Bounds = [1e-6, 10.0];
    /// Bounds of [`Self::coast`] and [`Self::memory`], s.
    pub const SECONDS: Bounds = [0.0, 600.0];

    /// # Errors    [`OutOfBounds`] naming the first value out of its bounds.
    pub fn validate(&self) -> Result<(), OutOfBounds> {
        check(&[
            ("margin", self.margin, Self::MARGIN),
            ("max_width", self.max_width, Self::MAX_WIDTH),
            ("min_hits", self.min_hits as f64, Self::MIN_HITS),
            ("position_sigma", self.position_sigma, Self::POSITION_SIGMA),
            ("acceleration", self.acceleration, Self::ACCELERATION),
            ("gate", self.gate, Self::GATE),
            ("detection", self.detection, Self::DETECTION),
            ("clutter", self.clutter, Self::CLUTTER),
            ("coast", self.coast, Self::SECONDS),
            ("significance", self.significance, Self::GATE),
            ("memory", self.memory, Self::SECONDS),
        ])
    }
}
