//! What the hub's task reports apart from relaying messages: log, audit, service manager, and the
//! state of recording, mapping and audit.

use std::time::Duration;

use slamlab_core::wire::message::{FromBridge, Right, SafetyBody, Severity};

use super::{Guest, Task};
use crate::access_log::{Kind, Peer};
use crate::audit::{What, Who};
use crate::mapping;
use crate::notify;
use crate::record::Recorder;
use crate::rights::Name;
use crate::safety::ClientId;
use crate::source::Running;

impl Task {
    pub(super) fn report(&mut self) {
        notify::alive();
        self.report_audit();
        self.report_mapping();
        let missed = self.sources.iter().map(Running::missed).sum();
        self.metrics.missed.set(missed);
        let Some(status) = self.recorder.as_ref().map(Recorder::status) else {
            return;
        };
        let fault = status.fault.clone();
        self.send_all(FromBridge::Recording(status));
        if fault != self.recording_fault {
            match &fault {
                Some(why) => self
                    .hub
                    .notify(Severity::Error, format!("Recording: {why}.")),
                None => {
                    let text = "The recording goes on in a new file.".to_owned();
                    self.hub.notify(Severity::Info, text);
                }
            }
            self.recording_fault = fault;
            self.act();
        }
    }

    /// Reports once if mapping has ended by itself; driving goes on without it.
    fn report_mapping(&mut self) {
        if let Some(mapped) = &mut self.mapped
            && mapped.mapping.is_broken()
            && !std::mem::replace(&mut mapped.is_broken, true)
        {
            let text = "The bridge maps no longer: its mapper broke down. Start the bridge again; its log says why.";
            self.hub.notify(Severity::Error, text.to_owned());
            self.act();
        }
    }

    pub(super) fn report_audit(&mut self) {
        let fault = self.audit.as_ref().and_then(|audit| audit.fault());
        if fault != self.audit_fault {
            let (severity, text) = match &fault {
                Some(why) => (Severity::Error, format!("Audit: {why}.")),
                None => (
                    Severity::Info,
                    "The audit goes on in a new file.".to_owned(),
                ),
            };
            self.hub.notify(severity, text);
            self.audit_fault = fault;
            self.act();
        }
    }

    /// A connected client, for the audit.
    pub(super) fn who(&self, id: ClientId) -> Option<Who> {
        let Some(guest) = self.guests.get(&id) else {
            return self.own(id);
        };
        let right = guest.granted.as_ref().map(|granted| granted.right.clone());
        let right = right.unwrap_or_default();
        Some(Who::new(id, &right, &guest.name, guest.peer))
    }

    /// The mapper, if the number is its own.
    fn own(&self, id: ClientId) -> Option<Who> {
        let mapped = self.mapped.as_ref().filter(|mapped| mapped.client == id)?;
        let name = mapped.right.as_ref().map_or(String::new(), Name::to_string);
        let right = Right {
            role: mapped.role,
            name,
        };
        let here = Peer::At(([127, 0, 0, 1], 0).into());
        Some(Who::new(id, &right, mapping::NAME, here))
    }

    pub(super) fn audit(&self, now: Duration, what: &What) {
        if let Some(audit) = &self.audit {
            audit.note(now, what);
        }
    }

    /// Writes the audit entries that follow from a new safety state.
    pub(super) fn audit_state(&mut self, state: &SafetyBody) {
        let now = self.clock.now();
        let by = self.asker.and_then(|id| self.who(id));
        let driver = state.driver.and_then(|id| self.who(id));
        for what in self.story.goes_on(now, state, by.as_ref(), driver) {
            self.audit(now, &what);
        }
    }

    /// Logs what a client does; false if that was too often to be logged. Names are whatever
    /// clients call themselves.
    pub(super) fn note(&self, now: Duration, kind: Kind, id: ClientId, does: &str) -> bool {
        let Some(Guest {
            name,
            peer,
            granted,
            ..
        }) = self.guests.get(&id)
        else {
            return false;
        };
        let right = granted.as_ref().map(|granted| granted.right.name.as_str());
        let whose = match right {
            Some("") => " with the owner's token".to_owned(),
            Some(right) => format!(" with the right of {right}"),
            None => String::new(),
        };
        let what = format_args!("client {id} {name:?} at {peer}{whose} {does}");
        self.log.note(now, kind, what)
    }
}
