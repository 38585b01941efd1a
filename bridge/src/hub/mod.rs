//! The task that runs the hub ([`slamlab_core::device::hub`]): it feeds in events, messages and
//! time, and carries out the resulting actions.
//!
//! In: events of the sources, messages of the clients. Out: orders to the robot's source, messages
//! into the clients' outboxes and to the recorder. One task owns everything, so nothing needs a
//! lock and everything happens in one order. The rules are not here.

mod mapped;
pub(crate) mod outbox;
mod told;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use slamlab_core::device::hub::{Action, Hub};
use slamlab_core::wire::message::{
    DeviceState, FromBridge, Header, Lease, Notice, RefusalReason, Severity, ToBridge, close,
};
use tokio::sync::{mpsc, oneshot, watch};
use tokio::time::Instant;

use crate::access_log::{AccessLog, Kind, Peer};
use crate::audit::{Audit, Story, What};
use crate::clock::Clock;
use crate::ending::GOING_AWAY;
use crate::metrics::Metrics;
use crate::record::Recorder;
use crate::rights::{Granted, Rights};
use crate::safety::ClientId;
use crate::source::{Order, Running, SourceEvent};
use mapped::{Mapped, found};
use outbox::Outbox;

/// Most messages of clients that may wait for the hub; a client that sends more waits.
pub(crate) const MOST_WAITING: usize = 256;
/// Interval between reports of metrics, of the recording, and to the service manager.
const REPORT: Duration = Duration::from_secs(1);

/// What a connection sends to the hub.
#[derive(Debug)]
pub(crate) enum FromClient {
    /// The client has shown who it is, and wants its number.
    Joined(NewClient, oneshot::Sender<ClientId>),
    /// A message, and when it came.
    Message(ClientId, Header, ToBridge, Duration),
    /// The same, from a client that waits for the result.
    Asked(
        ClientId,
        Header,
        ToBridge,
        Duration,
        oneshot::Sender<Answer>,
    ),
    /// The connection ended.
    Left(ClientId),
    /// The mapper has a sentence for everybody.
    Notice(Severity, String),
}

/// The result of a message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Answer {
    Done,
    Granted(Lease),
    Refused(RefusalReason),
}

/// A client that has shown who it is.
#[derive(Debug)]
pub(crate) struct NewClient {
    pub(crate) name: String,
    pub(crate) granted: Option<Granted>,
    pub(crate) peer: Peer,
    pub(crate) outbox: Arc<Outbox>,
}

/// A client that is in.
struct Guest {
    name: String,
    granted: Option<Granted>,
    peer: Peer,
    outbox: Arc<Outbox>,
}

/// What the hub's task is built from.
pub(crate) struct Parts {
    pub(crate) clock: Clock,
    pub(crate) sources: Vec<Running>,
    pub(crate) metrics: Arc<Metrics>,
    pub(crate) log: Arc<AccessLog>,
    pub(crate) recorder: Option<Recorder>,
    pub(crate) audit: Option<Arc<Audit>>,
    pub(crate) rights: watch::Receiver<Arc<Rights>>,
}

/// The running hub, with everything that it informs.
pub(crate) struct Task {
    hub: Hub,
    clock: Clock,
    sources: Vec<Running>,
    guests: BTreeMap<ClientId, Guest>,
    metrics: Arc<Metrics>,
    log: Arc<AccessLog>,
    recorder: Option<Recorder>,
    audit: Option<Arc<Audit>>,
    story: Story,
    rights: watch::Receiver<Arc<Rights>>,
    mapped: Option<Mapped>,
    /// The client whose message is being handled.
    asker: Option<ClientId>,
    /// The last logged problem of each source.
    lacking: BTreeMap<u8, String>,
    audit_fault: Option<String>,
    /// The fault that all clients were told last.
    recording_fault: Option<String>,
    next_report: Duration,
}

impl Task {
    pub(crate) fn new(parts: Parts) -> Self {
        let Parts {
            clock,
            sources,
            metrics,
            log,
            recorder,
            audit,
            rights,
        } = parts;
        let profiles: Vec<_> = sources.iter().map(|source| &source.profile).collect();
        Self {
            hub: Hub::new(&profiles),
            clock,
            sources,
            guests: BTreeMap::new(),
            metrics,
            log,
            recorder,
            audit,
            story: Story::default(),
            rights,
            mapped: None,
            asker: None,
            lacking: BTreeMap::new(),
            audit_fault: None,
            recording_fault: None,
            next_report: Duration::ZERO,
        }
    }

    /// Runs until `stop` ends; then stops the robot and closes every connection.
    pub(crate) async fn run(
        mut self,
        mut events: mpsc::Receiver<(u8, SourceEvent)>,
        mut clients: mpsc::Receiver<FromClient>,
        stop: impl Future<Output = ()>,
    ) {
        tokio::pin!(stop);
        loop {
            tokio::select! {
                // Stopping and clients' messages come before readings, of which there are many.
                biased;
                () = &mut stop => break,
                () = tokio::time::sleep_until(self.deadline()) => self.tick(),
                Ok(()) = self.rights.changed() => self.revoke(),
                from = clients.recv() => match from {
                    Some(from) => self.client(from),
                    None => break,
                },
                Some((source, event)) = events.recv() => self.event(source, event),
                () = found(self.mapped.as_mut()) => self.tell_map(),
            }
        }
        self.shut_down();
    }

    /// When the task must wake even if nothing happens.
    fn deadline(&self) -> Instant {
        self.clock
            .instant(self.hub.deadline().min(self.next_report))
    }

    fn tick(&mut self) {
        let now = self.clock.now();
        self.hub.tick(now);
        self.act();
        if now >= self.next_report {
            self.next_report = now + REPORT;
            self.report();
        }
    }

    /// Ends what clients do by rights that were removed or changed.
    fn revoke(&mut self) {
        let (now, rights) = (
            self.clock.now(),
            Arc::clone(&self.rights.borrow_and_update()),
        );
        let is_over = |guest: &Guest| (guest.granted.as_ref()).is_some_and(|of| !rights.holds(of));
        let over: Vec<ClientId> = (self.guests.iter())
            .filter(|(_, guest)| is_over(guest))
            .map(|(id, _)| *id)
            .collect();
        for id in over {
            self.end_right(now, id);
        }
        self.follow_right(now);
        self.act();
    }

    fn end_right(&mut self, now: Duration, id: ClientId) {
        let does = "has lost its right";
        self.note(now, Kind::ShownOut, id, does);
        if let Some(who) = self.who(id) {
            self.audit(now, &What::Revoked { who });
        }
        self.hub.revoke(now, id);
    }

    fn event(&mut self, source: u8, event: SourceEvent) {
        self.metrics.events.add(1);
        if let SourceEvent::Device { state, detail, .. } = &event {
            self.log_device(source, *state, detail);
        }
        self.hub.event(self.clock.now(), source, event);
        self.act();
    }

    /// Logs a device's problem once, although the device is tried again and again.
    fn log_device(&mut self, source: u8, state: DeviceState, detail: &str) {
        let is_missing = matches!(state, DeviceState::Waiting | DeviceState::Fault);
        let Some(running) = self.sources.get(usize::from(source)) else {
            return;
        };
        let (name, told) = (&running.profile.name, self.lacking.get(&source));
        if is_missing && !detail.is_empty() && told.is_none_or(|told| told != detail) {
            tracing::warn!("{name}: {detail}");
            self.lacking.insert(source, detail.to_owned());
        } else if !is_missing && self.lacking.remove(&source).is_some() {
            tracing::info!("{name}: it is there");
        }
    }

    fn client(&mut self, from: FromClient) {
        let now = self.clock.now();
        match from {
            FromClient::Joined(client, answer) => {
                let NewClient {
                    name,
                    granted,
                    peer,
                    outbox,
                } = client;
                let right = granted.as_ref().map(|granted| granted.right.clone());
                let id = self.hub.join(name.clone(), right.unwrap_or_default());
                let guest = Guest {
                    name,
                    granted,
                    peer,
                    outbox,
                };
                // A right may have been taken away since its proof.
                let is_over = (guest.granted.as_ref())
                    .is_some_and(|granted| !self.rights.borrow().holds(granted));
                if let Some(mapped) = &self.mapped {
                    (mapped.told.all()).for_each(|message| guest.outbox.put(message));
                }
                self.guests.insert(id, guest);
                if is_over {
                    self.end_right(now, id);
                }
                // If the connection has ended meanwhile, nobody else will report that it left.
                if answer.send(id).is_err() {
                    self.left(now, id);
                }
            }
            FromClient::Message(id, header, message, came) => {
                self.asker = Some(id);
                self.message(now, came, id, header, message);
            }
            FromClient::Asked(id, header, message, came, asker) => {
                self.asker = Some(id);
                self.message(now, came, id, header, message);
                let answer = self.act_and_answer(id);
                // A client that has gone meanwhile needs no answer.
                let _ = asker.send(answer);
            }
            FromClient::Left(id) => self.left(now, id),
            FromClient::Notice(severity, text) => self.hub.notify(severity, text),
        }
        self.act();
        self.asker = None;
        self.metrics.clients.set(self.hub.client_count() as u64);
    }

    fn message(
        &mut self,
        now: Duration,
        came: Duration,
        id: ClientId,
        header: Header,
        message: ToBridge,
    ) {
        let does = match message {
            ToBridge::Stop => Some("stops the robot"),
            ToBridge::EmergencyStop => Some("cuts the motors off"),
            _ => None,
        };
        if let Some(does) = does
            && self.note(now, Kind::Stop, id, does)
            && self.story.stands(&message)
            && let Some(by) = self.who(id)
        {
            self.audit(now, &What::StopAgain { by });
        }
        self.hub.message(now, came, id, header, message);
    }

    fn left(&mut self, now: Duration, id: ClientId) {
        self.hub.leave(now, id);
        self.act();
        self.guests.remove(&id);
    }

    /// Carries out the hub's actions.
    fn act(&mut self) {
        while let Some(action) = self.hub.next_action() {
            self.do_one(action);
        }
    }

    /// Carries out the hub's actions after a message of a client that waits for an answer: a
    /// message to this client becomes the answer, and a missing right does not end the connection.
    fn act_and_answer(&mut self, asker: ClientId) -> Answer {
        let mut answer = Answer::Done;
        while let Some(action) = self.hub.next_action() {
            match action {
                Action::Send(to, FromBridge::Granted(lease)) if to == asker => {
                    self.lease_granted(asker);
                    answer = Answer::Granted(lease);
                }
                Action::Send(to, FromBridge::Refused(reason)) if to == asker => {
                    self.metrics.refused.add(1);
                    answer = Answer::Refused(reason);
                }
                Action::ResetMap(to) if to == asker && self.mapped.is_none() => {
                    answer = Answer::Refused(RefusalReason::NoMap);
                }
                Action::Close(to, close::NO_RIGHT) if to == asker => {
                    answer = Answer::Refused(RefusalReason::NoRight);
                }
                other => self.do_one(other),
            }
        }
        answer
    }

    fn do_one(&mut self, action: Action) {
        match action {
            Action::Order {
                source,
                order,
                number,
            } => self.order(source, order, number),
            Action::Send(client, message) => self.send(client, message),
            Action::SendAll(message) => self.send_all(message),
            Action::Close(client, code) => {
                if let Some(guest) = self.guests.get(&client) {
                    guest.outbox.close(code);
                }
            }
            Action::ResetMap(client) => self.reset_map(client),
            Action::KeepGeofence(client, zones) => self.keep_geofence(client, zones),
        }
    }

    fn order(&self, source: usize, order: Order, number: u64) {
        self.metrics.orders.add(1);
        if let Some(recorder) = &self.recorder {
            recorder.order(&order, self.clock.now());
        }
        if let Some(source) = self.sources.get(source) {
            source.order(number, order);
        }
    }

    fn send(&self, client: ClientId, mut message: FromBridge) {
        let Some(guest) = self.guests.get(&client) else {
            if let Some(mapped) = &self.mapped
                && mapped.client == client
            {
                mapped.outbox.put(&Arc::new(message));
            }
            return;
        };
        match &mut message {
            FromBridge::Heartbeat(heartbeat) => heartbeat.dropped = guest.outbox.dropped(),
            FromBridge::Refused(_) => self.metrics.refused.add(1),
            FromBridge::Granted(_) => self.lease_granted(client),
            _ => (),
        }
        guest.outbox.put(&Arc::new(message));
    }

    fn lease_granted(&self, client: ClientId) {
        let does = "has the right to drive";
        self.note(self.clock.now(), Kind::Lease, client, does);
    }

    fn send_all(&mut self, message: FromBridge) {
        if let FromBridge::Safety(state) = &message {
            self.audit_state(state);
        }
        if let FromBridge::Notice(notice) = &message {
            log_notice(notice);
        }
        if let Some(recorder) = &self.recorder {
            recorder.message(&message, self.clock.now());
        }
        let message = Arc::new(message);
        for guest in self.guests.values() {
            guest.outbox.put(&message);
        }
        // The mapper does not act on notices, and would only log them again.
        if let Some(mapped) = &self.mapped
            && !matches!(*message, FromBridge::Notice(_))
        {
            mapped.outbox.put(&message);
        }
    }

    /// The robot first, the rest later: dropping the sources waits until they have stopped their
    /// robots.
    fn shut_down(mut self) {
        self.hub.shut_down(self.clock.now());
        self.act();
        for guest in self.guests.values() {
            guest.outbox.close(GOING_AWAY);
        }
        self.sources.clear();
        if let Some(mapped) = self.mapped.take() {
            let mapping = Arc::clone(&mapped.mapping);
            drop(mapped);
            mapping.finish();
        }
        if let Some(audit) = self.audit.take() {
            audit.finish();
            log_untold("Audit", audit.fault(), self.audit_fault.as_ref());
        }
        if let Some(recorder) = self.recorder.take() {
            let done = recorder.finish();
            log_untold("Recording", done.fault, self.recording_fault.as_ref());
            tracing::info!(
                "{}: {} messages, {} lost",
                done.file,
                done.acknowledged,
                done.lost
            );
        }
    }
}

/// Logs a fault of the last second, when no client is left to be told.
fn log_untold(what: &str, fault: Option<String>, told: Option<&String>) {
    if let Some(why) = fault.filter(|why| told != Some(why)) {
        tracing::error!("{what}: {why}.");
    }
}

fn log_notice(Notice { severity, text }: &Notice) {
    match severity {
        Severity::Info => tracing::info!("{text}"),
        Severity::Warning => tracing::warn!("{text}"),
        Severity::Error => tracing::error!("{text}"),
    }
}
