//! The methods by which a pose is estimated, with their names.

use std::str::FromStr;

/// How the pose is estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Odometry alone: the yardstick.
    Odometry,
    /// Kalman filter over walls (TDK 2016 §3.4).
    LineEkf,
    /// Scans matched to submaps, loops closed in a pose graph.
    ScanMatching,
    /// Kalman filter over the walls of a prior map (TDK 2016 §3.2).
    PriorMap,
}

impl Method {
    /// All methods, with the names used by commands and pages.
    pub const ALL: [(&'static str, Self); 4] = [
        ("odometry", Self::Odometry),
        ("line-ekf", Self::LineEkf),
        ("scan-matching", Self::ScanMatching),
        ("known-map", Self::PriorMap),
    ];

    /// The name.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL
            .iter()
            .find(|(_, method)| *method == self)
            .map_or("", |(name, _)| name)
    }
}

/// There is no method of that name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no method `{0}`; expected odometry, line-ekf, scan-matching or known-map")]
pub struct UnknownMethod(String);

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        let found = Self::ALL.iter().find(|(known, _)| *known == name);
        found
            .map(|(_, method)| *method)
            .ok_or_else(|| UnknownMethod(name.to_owned()))
    }
}
