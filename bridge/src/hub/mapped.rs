//! The mapper, seen from the hub: it joins as a client that is not counted as one, its results go
//! to all clients, and requests that concern its map are carried out.

use std::sync::Arc;
use std::time::Duration;

use slamlab_core::wire::message::{
    BridgeHello, FromBridge, RefusalReason, Right, Role, Severity, ZoneBody,
};
use tokio::sync::{mpsc, watch};

use super::outbox::Outbox;
use super::{FromClient, Task};
use crate::access_log::Kind;
use crate::audit::What;
use crate::ending::GOING_AWAY;
use crate::mapping::{self, MapError, Mapping, Ready, Shown, ToHub};
use crate::rights::Name;
use crate::safety::ClientId;

/// The hub's side of the mapper.
pub(super) struct Mapped {
    pub(super) client: ClientId,
    pub(super) outbox: Arc<Outbox>,
    pub(super) mapping: Arc<Mapping>,
    shown: watch::Receiver<Shown>,
    /// What all clients were told last.
    pub(super) told: Shown,
    pub(super) is_broken: bool,
    /// The right by which the robot goes home; without one it holds.
    pub(super) right: Option<Name>,
    pub(super) role: Role,
}

/// The mapper's thread ends with the hub, however the hub ends.
impl Drop for Mapped {
    fn drop(&mut self) {
        self.outbox.close(GOING_AWAY);
    }
}

impl Task {
    /// Lets the mapper join, as a client that is not counted, and begins to map.
    ///
    /// # Errors    [`MapError`]: there is no thread for it.
    pub(crate) fn map(
        &mut self,
        ready: Ready,
        hello: BridgeHello,
        hub: mpsc::Sender<FromClient>,
    ) -> Result<Arc<Mapping>, MapError> {
        let right = ready.home.as_ref().map(|home| home.right.clone());
        let role = self.role_by(right.as_ref());
        let outbox = Arc::new(Outbox::default());
        let shown = Right {
            role,
            name: String::new(),
        };
        let client = self.hub.join_own(mapping::NAME.to_owned(), shown);
        let to_hub = ToHub { client, hub };
        let zones = ready.zones.clone();
        let mapping = ready.start(hello, Arc::clone(&outbox), to_hub, self.clock)?;
        let mapping = Arc::new(mapping);
        self.mapped = Some(Mapped {
            client,
            outbox,
            shown: mapping.shown(),
            mapping: Arc::clone(&mapping),
            told: Shown::default(),
            is_broken: false,
            right,
            role,
        });
        self.hub.maps();
        if let Err(error) = self.hub.fence_in(self.clock.now(), &zones) {
            // The zones were checked when they were read.
            tracing::error!("the geofence: {error}");
        }
        self.act();
        Ok(mapping)
    }

    /// The role that a right has now.
    fn role_by(&self, right: Option<&Name>) -> Role {
        let rights = self.rights.borrow();
        right
            .and_then(|right| rights.role_of(right))
            .unwrap_or_default()
    }

    /// Gives the mapper the role that its right has now.
    pub(super) fn follow_right(&mut self, now: Duration) {
        let right = self.mapped.as_ref().and_then(|mapped| mapped.right.clone());
        let role = self.role_by(right.as_ref());
        let Some(mapped) = self.mapped.as_mut().filter(|mapped| mapped.role != role) else {
            return;
        };
        mapped.role = role;
        let (client, may_drive) = (mapped.client, role.may_drive());
        self.hub.give(now, client, role);
        let right = right.map_or(String::new(), |right| right.to_string());
        let (severity, text) = match may_drive {
            true => (
                Severity::Info,
                format!("The right {right} is there: the robot may go home by itself."),
            ),
            false => (
                Severity::Warning,
                format!("The right {right} was taken away: the robot does not go home by itself."),
            ),
        };
        self.hub.notify(severity, text);
    }

    /// Sends the mapper's new results to all clients. They are not recorded: `export` computes them
    /// again.
    pub(super) fn tell_map(&mut self) {
        let Some(mapped) = &mut self.mapped else {
            return;
        };
        let shown = mapped.shown.borrow_and_update().clone();
        let mut pose = None;
        for message in shown.since(&mapped.told) {
            if let FromBridge::Pose(body) = &**message {
                pose = Some(*body);
            }
            for guest in self.guests.values() {
                guest.outbox.put(message);
            }
        }
        mapped.told = shown;
        if let Some(body) = pose {
            self.hub.pose(self.clock.now(), &body);
            self.act();
        }
    }

    /// Saves a geofence that is already in force.
    pub(super) fn keep_geofence(&mut self, client: ClientId, zones: Vec<ZoneBody>) {
        let now = self.clock.now();
        self.note(now, Kind::Map, client, "sets the geofence");
        if let Some(who) = self.who(client) {
            let count = zones.len();
            self.audit(now, &What::GeofenceSet { who, zones: count });
        }
        let mapping = self.mapped.as_ref().map(|mapped| &mapped.mapping);
        if !mapping.is_some_and(|mapping| mapping.keep_fence(zones)) {
            let text = "The geofence is in force, and would be gone after a restart: the mapper is busy. Set it again.";
            self.hub.notify(Severity::Error, text.to_owned());
        }
    }

    /// Begins the map anew, at the request of a client that may do so.
    pub(super) fn reset_map(&mut self, client: ClientId) {
        let is_reset = (self.mapped.as_ref()).is_some_and(|mapped| mapped.mapping.reset());
        if !is_reset {
            return self.send(client, FromBridge::Refused(RefusalReason::NoMap));
        }
        let now = self.clock.now();
        // The geofence was drawn in the map that is gone. Removing all zones cannot fail.
        if let Err(error) = self.hub.fence_in(now, &[]) {
            tracing::error!("the geofence: {error}");
        }
        self.note(now, Kind::Map, client, "begins the map anew");
        if let Some(who) = self.who(client) {
            self.audit(now, &What::MapReset { who });
        }
    }
}

/// Ends when the mapper has a new result; never if there is no mapper.
pub(super) async fn found(mapped: Option<&mut Mapped>) {
    let Some(mapped) = mapped else {
        return std::future::pending().await;
    };
    if mapped.shown.changed().await.is_err() {
        // Its thread has ended: the next report says so.
        std::future::pending().await
    }
}
