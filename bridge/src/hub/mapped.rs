//! The mapper that the hub has: it is let in as a client that counts as none, what it finds is told
//! to everybody, and what is asked of its map is done.

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

/// The mapper, as the hub has it.
pub(super) struct Mapped {
    pub(super) client: ClientId,
    pub(super) outbox: Arc<Outbox>,
    pub(super) mapping: Arc<Mapping>,
    shown: watch::Receiver<Shown>,
    /// As everybody was told last.
    pub(super) told: Shown,
    pub(super) is_broken: bool,
    /// By which the robot goes home; without one it holds.
    pub(super) right: Option<Name>,
    pub(super) role: Role,
}

/// Its thread ends with the hub, however that ends.
impl Drop for Mapped {
    fn drop(&mut self) {
        self.outbox.close(GOING_AWAY);
    }
}

impl Task {
    /// Lets the mapper in, as a client that counts as none, and begins to map.
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
            // They were looked at when they were read.
            tracing::error!("the geofence: {error}");
        }
        self.act();
        Ok(mapping)
    }

    /// What a right is good for now.
    fn role_by(&self, right: Option<&Name>) -> Role {
        let rights = self.rights.borrow();
        right
            .and_then(|right| rights.role_of(right))
            .unwrap_or_default()
    }

    /// The mapper may what its right says now.
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

    /// Tells everybody what the mapper has found. It is not recorded: `export` finds it again.
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

    /// Keeps a geofence that is in force already.
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

    /// Begins the map anew, as a client asked that may.
    pub(super) fn reset_map(&mut self, client: ClientId) {
        let is_reset = (self.mapped.as_ref()).is_some_and(|mapped| mapped.mapping.reset());
        if !is_reset {
            return self.send(client, FromBridge::Refused(RefusalReason::NoMap));
        }
        let now = self.clock.now();
        // It was drawn in the map that is gone; without zones it cannot be wrong.
        if let Err(error) = self.hub.fence_in(now, &[]) {
            tracing::error!("the geofence: {error}");
        }
        self.note(now, Kind::Map, client, "begins the map anew");
        if let Some(who) = self.who(client) {
            self.audit(now, &What::MapReset { who });
        }
    }
}

/// Ends when the mapper has found something; never where there is none.
pub(super) async fn found(mapped: Option<&mut Mapped>) {
    let Some(mapped) = mapped else {
        return std::future::pending().await;
    };
    if mapped.shown.changed().await.is_err() {
        // Its thread has ended: the next report says so.
        std::future::pending().await
    }
}
