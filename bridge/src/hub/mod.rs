//! The hub: where robot, sensors and clients meet.
//!
//! In: events of the sources, messages of the clients, and time. Out: orders to the robot, messages to the clients. One task
//! owns everything, so there is nothing to lock and one order of things.
//!
//! 1. An event goes to safe mode and to the checks of plausibility, then to every client's outbox and to the recorder.
//! 2. A message goes to the rules ([`Safety`]); what they say is done: orders (limited by safe mode), answers, and news to all.
//! 3. The hub wakes when something happens or runs out, and each second for heartbeats and metrics.

mod client;
mod errand;
pub(crate) mod outbox;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use slamlab_core::wire::message::{
    BridgeHeartbeat, DeviceState, FromBridge, Header, Notice, SafetyBody, Severity, ToBridge,
};
use tokio::sync::{mpsc, oneshot};
use tokio::time::Instant;

use crate::clock::Clock;
use crate::ending::GOING_AWAY;
use crate::metrics::Metrics;
use crate::notify;
use crate::record::Recorder;
use slamlab_core::device::news::{Devices, explain};
use slamlab_core::device::robot_side::RobotSide;

use crate::safety::{ClientId, Input, Output, Safety, SafetyConfig};
use crate::source::{Order, Running, SourceEvent};
use client::Connected;
pub(crate) use client::NewClient;
use errand::Errand;

/// Messages of clients that wait for the hub; who sends more waits.
pub(crate) const MOST_WAITING: usize = 256;
const HEARTBEAT: Duration = Duration::from_secs(1);
/// Of the client that drives: its commands must tell what it had seen.
const DRIVER_HEARTBEAT: Duration = Duration::from_millis(100);

/// What a connection tells the hub.
#[derive(Debug)]
pub(crate) enum FromClient {
    /// It has shown who it is.
    Came(NewClient, oneshot::Sender<ClientId>),
    /// A message, and when it came.
    Says(ClientId, Header, ToBridge, Duration),
    /// It ended.
    Gone(ClientId),
}

/// What the hub is made of.
#[derive(Debug)]
pub(crate) struct HubParts {
    pub(crate) clock: Clock,
    pub(crate) sources: Vec<Running>,
    pub(crate) events: mpsc::Receiver<(u8, SourceEvent)>,
    pub(crate) clients: mpsc::Receiver<FromClient>,
    pub(crate) metrics: Arc<Metrics>,
    pub(crate) recorder: Option<Recorder>,
    pub(crate) safety: SafetyConfig,
}

/// Runs until `stop` ends; then the robot is stopped, and every connection closed.
pub(crate) async fn run(parts: HubParts, stop: impl Future<Output = ()>) {
    let mut hub = Hub::new(
        parts.clock,
        parts.sources,
        parts.metrics,
        parts.recorder,
        parts.safety,
    );
    let (mut events, mut clients) = (parts.events, parts.clients);
    tokio::pin!(stop);
    loop {
        tokio::select! {
            // Stopping and orders come before readings, of which there are many.
            biased;
            () = &mut stop => break,
            () = tokio::time::sleep_until(hub.deadline()) => hub.tick(),
            said = clients.recv() => match said {
                Some(said) => hub.client(said),
                None => break,
            },
            Some((source, event)) = events.recv() => hub.event(source, event),
        }
    }
    hub.shut_down();
}

struct Hub {
    clock: Clock,
    sources: Vec<Running>,
    devices: Devices,
    robot: RobotSide,
    safety: Safety,
    clients: BTreeMap<ClientId, Connected>,
    last_client: ClientId,
    errand: Option<Errand>,
    /// Number of the last order, if it was an errand.
    given: Option<u64>,
    metrics: Arc<Metrics>,
    recorder: Option<Recorder>,
    next_heartbeat: Duration,
    next_driver_heartbeat: Duration,
}

impl Hub {
    fn new(
        clock: Clock,
        sources: Vec<Running>,
        metrics: Arc<Metrics>,
        recorder: Option<Recorder>,
        safety: SafetyConfig,
    ) -> Self {
        let profiles = || sources.iter().map(|source| &source.profile);
        Self {
            devices: Devices::new(profiles()),
            robot: RobotSide::new(&profiles()),
            safety: Safety::new(safety),
            clients: BTreeMap::new(),
            last_client: 0,
            errand: None,
            given: None,
            next_heartbeat: Duration::ZERO,
            next_driver_heartbeat: Duration::ZERO,
            clock,
            sources,
            metrics,
            recorder,
        }
    }

    /// When the hub must wake, whatever happens.
    fn deadline(&self) -> Instant {
        let driver = self.safety.driver().map(|_| self.next_driver_heartbeat);
        let due = [self.safety.deadline(), self.robot.deadline(), driver];
        let due = due
            .into_iter()
            .flatten()
            .fold(self.next_heartbeat, Duration::min);
        self.clock.instant(due)
    }

    fn tick(&mut self) {
        let now = self.clock.now();
        self.rule(now, Input::Tick);
        if let Some(reason) = self.robot.silence(now) {
            self.fault(now, reason);
        }
        if now >= self.next_heartbeat {
            self.next_heartbeat = now + HEARTBEAT;
            self.each_second();
        }
        if now >= self.next_driver_heartbeat
            && let Some(driver) = self.safety.driver()
        {
            self.next_driver_heartbeat = now + DRIVER_HEARTBEAT;
            self.heartbeat(driver);
        }
    }

    fn each_second(&mut self) {
        notify::alive();
        let all: Vec<ClientId> = self.clients.keys().copied().collect();
        for client in all {
            self.heartbeat(client);
        }
        let missed = self.sources.iter().map(Running::missed).sum();
        self.metrics.missed.store(missed, Ordering::Relaxed);
        let recording = self.recorder.as_ref().map(Recorder::status);
        if let Some(recording) = recording {
            self.tell_all(FromBridge::Recording(recording));
        }
    }

    fn heartbeat(&self, client: ClientId) {
        let Some(connected) = self.clients.get(&client) else {
            return;
        };
        connected.tell(FromBridge::Heartbeat(BridgeHeartbeat {
            dropped: connected.outbox.dropped(),
            clients: self.clients.len() as u16,
            robot_micros: self.robot.newest().0.0,
        }));
    }

    /// Takes what a source says.
    fn event(&mut self, source: u8, event: SourceEvent) {
        let now = self.clock.now();
        self.metrics.events.fetch_add(1, Ordering::Relaxed);
        let consequence = self.robot.event(now, source, &event);
        if let SourceEvent::Busy { busy, after } = event {
            if self.robot.source() == Some(usize::from(source)) {
                self.busy(busy, after);
            }
            return;
        }
        if let Some(is_up) = consequence.link {
            if !is_up {
                self.errand_over();
            }
            self.rule(now, Input::Robot(is_up));
        }
        if let Some(reason) = consequence.fault {
            self.fault(now, reason);
        }
        if let Some(command) = consequence.correction
            && self.safety.is_armed()
        {
            self.order(Order::Command(command));
        }
        if let SourceEvent::Device {
            state: DeviceState::Fault,
            detail,
            ..
        } = &event
            && let Some(device) = self.devices.all().get(usize::from(source))
        {
            tracing::warn!("{}: {detail}", device.name);
        }
        if let Some(message) = self.devices.message(source, event) {
            self.tell_all(message);
        }
    }

    fn fault(&mut self, now: Duration, reason: slamlab_core::wire::message::DisarmReason) {
        // A robot that stands disarmed may be pushed about by hand.
        if self.safety.is_armed() {
            self.rule(now, Input::Fault(reason));
            self.news(Severity::Error, explain(reason));
        }
    }

    /// Lets the rules take something, and does what they say.
    fn rule(&mut self, now: Duration, input: Input) {
        for output in self.safety.on(now, input) {
            match output {
                Output::Order(order) => {
                    let order = self.robot.limit(order);
                    self.order(order);
                }
                Output::Granted(client, lease) => self.tell(client, FromBridge::Granted(lease)),
                Output::Refused(client, reason) => {
                    self.metrics.refused.fetch_add(1, Ordering::Relaxed);
                    self.tell(client, FromBridge::Refused(reason));
                }
                Output::Close(client, code) => {
                    if let Some(connected) = self.clients.get(&client) {
                        connected.outbox.close(code);
                    }
                }
                Output::Changed => self.tell_all(FromBridge::Safety(self.state())),
            }
        }
    }

    fn order(&mut self, order: Order) {
        self.robot.ordered(&order);
        self.metrics.orders.fetch_add(1, Ordering::Relaxed);
        if let Some(recorder) = &self.recorder {
            recorder.order(&order, self.clock.now());
        }
        if let Some(source) = self.robot.source().and_then(|at| self.sources.get(at)) {
            let number = source.order(order);
            self.given = order.is_manoeuvre().then_some(number);
        }
    }

    fn state(&self) -> SafetyBody {
        let driver = self.safety.driver();
        let name = driver.and_then(|id| self.clients.get(&id));
        SafetyBody {
            driver,
            driver_name: name.map_or(String::new(), |client| client.name.clone()),
            armed: self.safety.is_armed(),
            emergency: self.safety.is_emergency(),
            reason: self.safety.reason(),
        }
    }

    fn news(&mut self, severity: Severity, text: impl Into<String>) {
        let text = text.into();
        tracing::info!("{text}");
        self.tell_all(FromBridge::Notice(Notice { severity, text }));
    }

    fn tell(&self, client: ClientId, message: FromBridge) {
        if let Some(connected) = self.clients.get(&client) {
            connected.tell(message);
        }
    }

    fn tell_all(&mut self, message: FromBridge) {
        if let Some(recorder) = &self.recorder {
            recorder.message(&message, self.clock.now());
        }
        let message = Arc::new(message);
        for connected in self.clients.values() {
            connected.outbox.put(&message);
        }
    }

    /// The robot first, the rest later: dropping the sources waits until they have stopped their robots.
    fn shut_down(mut self) {
        let now = self.clock.now();
        self.rule(now, Input::Shutdown);
        for connected in self.clients.values() {
            connected.outbox.close(GOING_AWAY);
        }
        self.sources.clear();
        if let Some(recorder) = self.recorder.take() {
            let done = recorder.finish();
            tracing::info!(
                "{}: {} messages, {} lost",
                done.file,
                done.acknowledged,
                done.lost
            );
        }
    }
}
