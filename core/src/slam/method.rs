//! The methods of pose estimation: what each has to do, and the table of all of them.
//!
//! A new method is a file here and a row of the table: everything else (names, settings files,
//! commands, errors) follows from it.

mod grid_particles;
mod histogram_localisation;
mod line_ekf;
mod odometry;
mod particle_localisation;
mod prior_map;
mod scan_matching;

use std::fmt::Debug;
use std::str::FromStr;

use super::{EarlierMap, PreparedScan, SlamConfig, SlamError, View};
use crate::estimation::ScanMatcher;
use crate::geom::PoseEstimate;
use crate::map::Evidence;
use crate::robot::Odometry;
use crate::tracking::Matched;

/// What a method does. The map and the trajectory are kept by [`super::Slam`], unless the method
/// changes what was drawn.
pub(super) trait Estimator: Debug + Send + Sync {
    /// Takes the motion since the last call; readings come in order of time.
    fn predict(&mut self, odometry: &Odometry) -> Result<(), SlamError>;

    /// Takes a scan. Returns what is to be drawn of it at the currently believed pose; `None` from
    /// a method with a map of its own ([`View::map`]).
    fn update(&mut self, scan: &PreparedScan) -> Result<Option<Evidence>, SlamError>;

    /// Where the robot is now, map frame, the odometry since the last scan included.
    fn estimate(&self) -> PoseEstimate;

    /// How the last scan was matched, for the tracking of moving objects.
    fn matched(&self) -> Matched {
        Matched {
            motion: None,
            cov: self.estimate().cov,
        }
    }

    /// What the method can show.
    fn view(&self) -> View<'_> {
        View::default()
    }

    /// Uses other settings from the next scan on.
    fn reconfigure(&mut self, _config: &SlamConfig) {}

    /// Completes all postponed work.
    fn finish(&mut self) {}

    /// The map that a person may change, if the method has one.
    fn editable(&mut self) -> Option<&mut ScanMatcher> {
        None
    }
}

/// One row for each method: variant, name in commands and saved links, title, constructor, meaning
/// for people.
macro_rules! methods {
    ($($variant:ident, $name:literal, $title:literal, $begin:path, $meaning:literal;)*) => {
        /// How the pose is estimated.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Method {
            $(#[doc = $meaning] $variant,)*
        }

        impl Method {
            /// All methods, in the order of the table.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];
            /// Their names.
            pub const NAMES: &[&str] = &[$($name),*];

            /// The name in commands, settings and saved links.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// The name for people.
            #[must_use]
            pub fn title(self) -> &'static str {
                match self { $(Self::$variant => $title,)* }
            }

            /// What it does, for people.
            #[must_use]
            pub fn meaning(self) -> &'static str {
                match self { $(Self::$variant => $meaning,)* }
            }

            pub(super) fn begin(self, config: &SlamConfig) -> Result<Box<dyn Estimator>, SlamError> {
                match self { $(Self::$variant => $begin(config),)* }
            }
        }
    };
}

methods! {
    Odometry, "odometry", "Odometry", odometry::begin,
        "Odometry alone: the baseline for all others.";
    LineEkf, "line-ekf", "Line EKF-SLAM", line_ekf::begin,
        "A Kalman filter over the pose and all walls seen so far (TDK 2016 §3.4).";
    ScanMatching, "scan-matching", "Scan matching", scan_matching::begin,
        "Whole scans matched to submaps; loops are closed in a pose graph.";
    GridParticles, "grid-particles", "Grid particles", grid_particles::begin,
        "Particles with a map each: the one into which all fits survives (gmapping).";
    PriorMap, "prior-map", "Prior map", prior_map::begin,
        "Localisation in a map that is given before the run (TDK 2016 §3.2).";
    ParticleLocalisation, "particle-localisation", "Particles", particle_localisation::begin,
        "Monte Carlo localisation in a map that is given before the run, from anywhere in it.";
    HistogramLocalisation, "histogram-localisation", "Histogram", histogram_localisation::begin,
        "The probability of every pose in a small map that is given before the run (Markov localisation).";
}

impl Method {
    /// Whether it needs a map that is given before the run ([`SlamConfig::prior_map`]).
    #[must_use]
    pub fn needs_prior_map(self) -> bool {
        matches!(
            self,
            Self::PriorMap | Self::ParticleLocalisation | Self::HistogramLocalisation
        )
    }
}

/// No method has that name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no method `{0}`; expected {names}", names = names())]
pub struct UnknownMethod(String);

fn names() -> String {
    let mut names = Method::NAMES.to_vec();
    let last = names.pop().unwrap_or_default();
    format!("{} or {last}", names.join(", "))
}

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        Self::ALL
            .into_iter()
            .find(|method| method.name() == name)
            .ok_or_else(|| UnknownMethod(name.to_owned()))
    }
}
