//! The entries of the audit.

use serde::Serialize;
use slamlab_core::wire::message::{DisarmReason, Right, Role};

use crate::access_log::Peer;

/// Somebody who is connected.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Who {
    /// Of the connection.
    client: u32,
    /// Name of the right; empty for the owner's first token and for a client without a right.
    #[serde(skip_serializing_if = "String::is_empty")]
    name: String,
    role: Role,
    /// What it calls itself.
    calls_itself: String,
    #[serde(serialize_with = "as_text")]
    from: Peer,
}

impl Who {
    pub(crate) fn new(client: u32, right: &Right, calls_itself: &str, from: Peer) -> Self {
        Self {
            client,
            name: right.name.clone(),
            role: right.role,
            calls_itself: calls_itself.to_owned(),
            from,
        }
    }
}

/// What happened.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "what", rename_all = "kebab-case")]
pub(crate) enum What {
    /// The bridge begins to serve.
    Begins { version: &'static str },
    /// A client got the lease.
    Lease { who: Who },
    /// The client lost or gave back the lease.
    LeaseEnds { who: Who },
    /// From now on the robot moves on this client's commands.
    Drives { who: Who },
    /// The robot no longer moves on them: why, and who stopped it, if somebody did.
    Stops {
        who: Option<Who>,
        cause: DisarmReason,
        #[serde(skip_serializing_if = "Option::is_none")]
        by: Option<Who>,
        after_seconds: f64,
    },
    /// The motors are cut off.
    EmergencyStop {
        cause: DisarmReason,
        #[serde(skip_serializing_if = "Option::is_none")]
        by: Option<Who>,
    },
    /// The motors may run again.
    EmergencyReset {
        #[serde(skip_serializing_if = "Option::is_none")]
        by: Option<Who>,
    },
    /// Somebody pressed a stop that changed nothing.
    StopAgain { by: Who },
    /// A connection that the bridge ended or refused.
    Refused {
        #[serde(serialize_with = "as_text")]
        from: Peer,
        code: u16,
        why: &'static str,
    },
    /// A right was taken away while it was in use.
    Revoked { who: Who },
    /// The bridge's own map was begun anew.
    MapReset { who: Who },
    /// Somebody set the geofence; with 0 zones the robot may be everywhere.
    GeofenceSet { who: Who, zones: usize },
    /// The bridge ends.
    Ends,
}

fn as_text<S: serde::Serializer>(peer: &Peer, to: S) -> Result<S::Ok, S::Error> {
    to.collect_str(peer)
}

/// A line of the file.
#[derive(Serialize)]
pub(super) struct Line<'a> {
    /// UTC.
    pub(super) at: String,
    #[serde(flatten)]
    pub(super) what: &'a What,
}
