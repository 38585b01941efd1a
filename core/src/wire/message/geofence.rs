//! Where the robot may be in the bridge's map, and how it relates to that now.

use nalgebra::Point2;
use serde::{Deserialize, Serialize};

use super::names::named;
use crate::geom::geofence::{Geofence, GeofenceError, Zone, ZoneKind};

named! {
    /// What a zone is for.
    pub enum ZoneUse {
        /// The robot stays in it.
        KeepIn = "keep-in",
        /// The robot keeps out of it.
        KeepOut = "keep-out",
    }
}

named! {
    /// How the robot stands to its fence.
    #[derive(Default)]
    pub enum FenceState {
        /// There is none: it may go everywhere.
        #[default]
        Off = "off",
        /// It is within, and nothing holds it back.
        Within = "within",
        /// It would leave, and is held back.
        Held = "held",
        /// It is outside, and goes only where that brings it back.
        Outside = "outside",
        /// It is not known where it is, and it stands.
        NoPose = "no-pose",
    }
}

/// A polygon in the frame of the bridge's map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ZoneBody {
    /// What it is for.
    pub kind: ZoneUse,
    /// x, y of its corners, m.
    pub corners: Vec<[f64; 2]>,
}

/// The whole fence, sent whenever it changes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GeofenceBody {
    /// Where the robot may be; without zones, everywhere.
    pub zones: Vec<ZoneBody>,
    /// Where the robot is relative to it, and whether it is held back.
    pub state: FenceState,
}

impl GeofenceBody {
    /// To the wire.
    #[must_use]
    pub fn new(fence: &Geofence, state: FenceState) -> Self {
        let zones = zones_of(fence);
        Self { zones, state }
    }
}

/// To the wire, and to files.
#[must_use]
pub fn zones_of(fence: &Geofence) -> Vec<ZoneBody> {
    let of = |zone: &Zone| ZoneBody {
        kind: match zone.kind {
            ZoneKind::KeepIn => ZoneUse::KeepIn,
            ZoneKind::KeepOut => ZoneUse::KeepOut,
        },
        corners: zone.corners.iter().map(|at| [at.x, at.y]).collect(),
    };
    fence.zones().iter().map(of).collect()
}

/// From the wire, and from files.
///
/// # Errors    [`GeofenceError`].
pub fn fence_of(zones: &[ZoneBody]) -> Result<Geofence, GeofenceError> {
    let of = |zone: &ZoneBody| Zone {
        kind: match zone.kind {
            ZoneUse::KeepIn => ZoneKind::KeepIn,
            ZoneUse::KeepOut => ZoneKind::KeepOut,
        },
        corners: (zone.corners.iter())
            .map(|[x, y]| Point2::new(*x, *y))
            .collect(),
    };
    Geofence::new(zones.iter().map(of).collect())
}
