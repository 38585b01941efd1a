//! The hub: where robot, sensors and clients meet, without I/O, thread or clock.
//!
//! In: events of the sources, messages of the clients, and the time. Out: [`Action`]s, to be
//! carried out in order. The bridge's task and [`super::LocalBridge`] carry them out; neither holds
//! any rule.
//!
//! 1. An event first goes through the checks of the robot's readings, which may disarm the robot or
//!    correct the command under way; then it goes to every client.
//! 2. A message goes to the rules ([`Safety`]). Their outputs become actions: orders, limited by
//!    safe mode; answers to the client; the new state for everyone.
//! 3. The client that gave a manoeuvre learns when it is over, however it ends (`manoeuvre.rs`).
//! 4. If the bridge maps ([`Hub::maps`]), commands are also limited to its geofence (`fence.rs`).
//! 5. [`Hub::tick`] is due at [`Hub::deadline`]: for the watchdog, the lease, a robot that falls
//!    silent, and heartbeats.
//!
//! Time starts anywhere and never runs backwards.

mod device_list;
mod fence;
mod manoeuvre;
mod robot_side;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use crate::geom::geofence::GeofenceError;
use crate::wire::message::{
    BridgeHeartbeat, BridgeHello, CHALLENGE_BYTES, DisarmReason, FenceState, FromBridge,
    GeofenceBody, Header, Notice, PoseBody, ProbeAnswer, RefusalReason, Right, RobotFigures, Role,
    SCHEMA, SafetyBody, Severity, ToBridge, Watching, Welcome, ZoneBody, close, fence_of,
};

use super::safety::{Client, ClientId, Input, LEASE, Output, Safety, WATCHDOG};
use super::source::{Order, Profile, SourceEvent};
use device_list::DeviceList;
use fence::Fence;
use manoeuvre::Manoeuvre;
use robot_side::RobotSide;

/// Interval of heartbeats to each client.
const HEARTBEAT: Duration = Duration::from_secs(1);
/// Interval of heartbeats to the driver, whose messages must name the bridge time last seen.
const DRIVER_HEARTBEAT: Duration = Duration::from_millis(100);
/// Sender of a stop that comes without a connection; clients count from 1.
const NOBODY: Client = Client {
    id: 0,
    role: Role::Watcher,
};

/// What the owner of the hub is to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Give the robot's source this order.
    Order {
        /// Number of the source.
        source: usize,
        /// The order.
        order: Order,
        /// Counts orders, from 1; [`SourceEvent::Busy`] refers to it.
        number: u64,
    },
    /// Send this to one client. The code that queues messages fills in how many readings the client
    /// missed ([`BridgeHeartbeat::dropped`]).
    Send(ClientId, FromBridge),
    /// Send this to every client.
    SendAll(FromBridge),
    /// End this client's connection with this code.
    Close(ClientId, u16),
    /// Begin the bridge's own map anew: this client asked for it and has the right to. A bridge
    /// without a map refuses.
    ResetMap(ClientId),
    /// Store the geofence that this client set.
    KeepGeofence(ClientId, Vec<ZoneBody>),
}

/// A client that was let in.
#[derive(Clone, Debug)]
struct Connected {
    /// Its name as other clients see it.
    name: String,
    role: Role,
    /// A part of the bridge itself.
    is_own: bool,
}

/// The state of a bridge.
#[derive(Clone, Debug)]
pub struct Hub {
    devices: DeviceList,
    robot: RobotSide,
    safety: Safety,
    clients: BTreeMap<ClientId, Connected>,
    last_client: ClientId,
    manoeuvre: Option<Manoeuvre>,
    /// The state as last sent to everyone.
    told: SafetyBody,
    /// Number of orders so far.
    orders: u64,
    /// The robot was armed until its driver was lost or the lease taken over, and nobody has
    /// stopped it since: a part of the bridge may arm it and go on.
    may_go_on: bool,
    /// Number of the newest order since the last message, if that order is a manoeuvre.
    ordered_manoeuvre: Option<u64>,
    /// Zones of a new geofence, while the message that brought them is processed.
    asked_zones: Vec<ZoneBody>,
    /// The state of the fence as last sent to everyone.
    told_fence: FenceState,
    next_heartbeat: Duration,
    next_driver_heartbeat: Duration,
    actions: VecDeque<Action>,
}

impl Hub {
    /// A hub for these sources, by their numbers; the first with a robot takes the orders. At first
    /// the robot is disarmed and no client is connected.
    #[must_use]
    pub fn new(sources: &[&Profile]) -> Self {
        Self {
            devices: DeviceList::new(sources),
            robot: RobotSide::new(sources),
            safety: Safety::default(),
            clients: BTreeMap::new(),
            last_client: 0,
            manoeuvre: None,
            told: SafetyBody::default(),
            orders: 0,
            may_go_on: false,
            ordered_manoeuvre: None,
            asked_zones: vec![],
            told_fence: FenceState::Off,
            next_heartbeat: Duration::ZERO,
            next_driver_heartbeat: Duration::ZERO,
            actions: VecDeque::new(),
        }
    }

    /// The next thing to do.
    pub fn next_action(&mut self) -> Option<Action> {
        self.actions.pop_front()
    }

    /// When [`Hub::tick`] is due, if nothing else happens first.
    #[must_use]
    pub fn deadline(&self) -> Duration {
        let driver = self.safety.driver().map(|_| self.next_driver_heartbeat);
        let due = [
            self.safety.deadline(),
            self.robot.plausible.deadline(),
            driver,
        ];
        (due.into_iter().flatten()).fold(self.next_heartbeat, Duration::min)
    }

    /// Processes what is due at this time.
    pub fn tick(&mut self, now: Duration) {
        self.rule(now, Input::Tick);
        if let Some(reason) = self.robot.plausible.silence(now) {
            self.fault(now, reason);
        }
        if now >= self.next_heartbeat {
            self.next_heartbeat = now + HEARTBEAT;
            let all: Vec<ClientId> = self.clients.keys().copied().collect();
            for client in all {
                self.heartbeat(client);
            }
        }
        if now >= self.next_driver_heartbeat
            && let Some(driver) = self.safety.driver()
        {
            self.next_driver_heartbeat = now + DRIVER_HEARTBEAT;
            self.heartbeat(driver);
        }
    }

    /// Takes an event of source `source`.
    pub fn event(&mut self, now: Duration, source: u8, event: SourceEvent) {
        let consequence = self.robot.event(now, source, &event);
        if let SourceEvent::Busy { busy, after } = event {
            if self.robot.source == Some(usize::from(source)) {
                self.robot_is_busy(busy, after);
            }
            return;
        }
        if let Some(is_up) = consequence.link {
            if !is_up {
                self.end_manoeuvre();
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
        self.watch_fence(now);
        if let Some(message) = self.devices.message(source, event) {
            self.actions.push_back(Action::SendAll(message));
        }
    }

    /// Lets in a client that calls itself `name`; returns its number, which is never used again.
    pub fn join(&mut self, name: String, right: Right) -> ClientId {
        self.let_in(name, right, false)
    }

    /// The same for a part of the bridge itself, which is not counted as a client.
    pub fn join_own(&mut self, name: String, right: Right) -> ClientId {
        self.let_in(name, right, true)
    }

    fn let_in(&mut self, name: String, right: Right, is_own: bool) -> ClientId {
        self.last_client += 1;
        let client = self.last_client;
        let role = right.role;
        // The name of the right, which the owner gave, counts more than the client's own name.
        let seen = match right.name.as_str() {
            "" => name,
            whose => format!("{whose} ({name})"),
        };
        let welcome = Welcome {
            client,
            may_drive: role.may_drive(),
            role,
            name: right.name,
        };
        self.send(client, FromBridge::Welcome(welcome));
        self.send(client, FromBridge::Devices(self.devices.all().to_vec()));
        self.send(client, FromBridge::Safety(self.state()));
        if let Some(manoeuvre) = self.manoeuvre {
            self.send(client, manoeuvre.message(true));
        }
        if let Some(fence) = &self.robot.fence {
            let body = GeofenceBody::new(fence.fence(), self.told_fence);
            self.send(client, FromBridge::Geofence(body));
        }
        let connected = Connected {
            name: seen,
            role,
            is_own,
        };
        self.clients.insert(client, connected);
        client
    }

    /// A client's connection ended.
    pub fn leave(&mut self, now: Duration, client: ClientId) {
        self.clients.remove(&client);
        self.rule(now, Input::Gone(client));
    }

    /// A client's right was taken away: its lease ends, the robot stops, the connection is closed.
    pub fn revoke(&mut self, now: Duration, client: ClientId) {
        if self.clients.remove(&client).is_some() {
            self.rule(now, Input::Revoked(client));
            self.actions
                .push_back(Action::Close(client, close::REVOKED));
        }
    }

    /// Number of clients connected.
    #[must_use]
    pub fn client_count(&self) -> usize {
        let clients = self.clients.values();
        clients.filter(|client| !client.is_own).count()
    }

    /// Takes a client's message, which arrived at `came`.
    pub fn message(
        &mut self,
        now: Duration,
        came: Duration,
        id: ClientId,
        header: Header,
        message: ToBridge,
    ) {
        let Some(role) = self.clients.get(&id).map(|client| client.role) else {
            return;
        };
        match message {
            ToBridge::Hello(_) | ToBridge::Heartbeat => (),
            ToBridge::Probe { token } => {
                let (stamp, robot_came) = self.robot.newest;
                let answer = ProbeAnswer {
                    token,
                    came_micros: came.as_micros() as u64,
                    robot_micros: stamp.0,
                    robot_came_micros: robot_came.as_micros() as u64,
                };
                self.send(id, FromBridge::Probe(answer));
            }
            asked => {
                let gives_manoeuvre =
                    matches!(&asked, ToBridge::Drive(body) if body.motion.is_manoeuvre());
                self.ordered_manoeuvre = None;
                let client = Client { id, role };
                if let Some(reason) = self.keeps_from_arming(now, id, &asked) {
                    self.send(id, FromBridge::Refused(reason));
                    return;
                }
                if let ToBridge::SetGeofence { zones } = &asked {
                    self.asked_zones.clone_from(zones);
                }
                self.rule(now, Input::Asks(client, header.sequence, asked));
                self.asked_zones.clear();
                self.watch_fence(now);
                if gives_manoeuvre {
                    let order = self.ordered_manoeuvre.take();
                    self.manoeuvre_given(id, header.sequence, order);
                }
            }
        }
    }

    /// The reason not to arm the robot, although the rules would allow it.
    fn keeps_from_arming(
        &self,
        now: Duration,
        id: ClientId,
        asked: &ToBridge,
    ) -> Option<RefusalReason> {
        // A client without the lease gets that answer, whatever else is wrong.
        if !matches!(asked, ToBridge::Arm { .. }) || self.safety.driver() != Some(id) {
            return None;
        }
        let is_own = self.clients.get(&id).is_some_and(|client| client.is_own);
        match () {
            // After a stop by a person or a fault, only a person may arm it again.
            () if is_own && !self.may_go_on => Some(RefusalReason::Stopped),
            () if self.safety.is_armed() => None,
            () if self.robot.plausible.is_empty(now) => Some(RefusalReason::BatteryLow),
            () if self.robot.is_blind(now) => Some(RefusalReason::NoScan),
            () if self.robot.fence.as_ref().is_some_and(Fence::is_lost) => {
                Some(RefusalReason::NoPose)
            }
            () => None,
        }
    }

    /// Gives a client another role, or takes its right away; without one it goes on watching.
    pub fn give(&mut self, now: Duration, client: ClientId, role: Role) {
        let Some(connected) = self.clients.get_mut(&client) else {
            return;
        };
        connected.role = role;
        if !role.may_drive() {
            self.rule(now, Input::Revoked(client));
        }
    }

    /// A person at the machine itself stops the robot; with `cut_off` the motors are cut off and
    /// stay off.
    pub fn stop(&mut self, now: Duration, cut_off: bool) {
        let stop = match cut_off {
            true => ToBridge::EmergencyStop,
            false => ToBridge::Stop,
        };
        self.rule(now, Input::Asks(NOBODY, 0, stop));
    }

    /// Sends everyone a sentence.
    pub fn notify(&mut self, severity: Severity, text: String) {
        let notice = FromBridge::Notice(Notice { severity, text });
        self.actions.push_back(Action::SendAll(notice));
    }

    /// The bridge shuts down: the robot is stopped.
    pub fn shut_down(&mut self, now: Duration) {
        self.rule(now, Input::Shutdown);
    }

    /// A disarmed robot may be pushed about by hand, so nothing that it reports then is a fault.
    fn fault(&mut self, now: Duration, reason: DisarmReason) {
        if self.safety.is_armed() {
            self.rule(now, Input::Fault(reason));
            self.notify(Severity::Error, sentence(reason).to_owned());
        }
    }

    /// Passes an input to the rules and carries out their outputs.
    fn rule(&mut self, now: Duration, input: Input) {
        let asker = match &input {
            Input::Asks(client, ..) if client.role.may_drive() => Some(client.id),
            _ => None,
        };
        let was_armed = self.safety.is_armed();
        let is_stop = matches!(
            &input,
            Input::Asks(_, _, ToBridge::Stop | ToBridge::EmergencyStop)
                | Input::Robot(_)
                | Input::Shutdown
        );
        let outputs = self.safety.on(now, input);
        if was_armed || self.safety.is_armed() || is_stop {
            self.may_go_on = !is_stop && !self.safety.is_armed() && self.has_lost_its_driver();
        }
        for output in outputs {
            match output {
                Output::Order(order) => {
                    let order = self.robot.limit(order);
                    self.order(order);
                }
                Output::Granted(client, lease) => self.send(client, FromBridge::Granted(lease)),
                Output::Refused(client, reason) => self.send(client, FromBridge::Refused(reason)),
                Output::Close(client, code) => self.actions.push_back(Action::Close(client, code)),
                Output::Changed => self.tell_state(asker),
                Output::ResetMap(client) if self.is_fenced_against(client) => {
                    self.send(client, FromBridge::Refused(RefusalReason::Fenced));
                }
                Output::ResetMap(client) => self.actions.push_back(Action::ResetMap(client)),
                Output::SetGeofence(client) => self.set_geofence(now, client),
            }
        }
    }

    /// Called if the bridge maps: its robot may have a geofence in that map.
    pub fn maps(&mut self) {
        self.robot.fence = self.robot.model().map(Fence::new);
    }

    /// Takes the pose at which the mapper found the robot.
    pub fn pose(&mut self, now: Duration, body: &PoseBody) {
        let correction = self.robot.pose(body);
        if let Some(command) = correction.filter(|_| self.safety.is_armed()) {
            self.order(Order::Command(command));
        }
        self.watch_fence(now);
    }

    /// Sets where the robot may be in the map from now on; without zones, everywhere.
    ///
    /// # Errors    [`GeofenceError`]; the previous fence stays in force.
    pub fn fence_in(&mut self, now: Duration, zones: &[ZoneBody]) -> Result<(), GeofenceError> {
        let geofence = fence_of(zones)?;
        if let Some(fence) = &mut self.robot.fence {
            fence.set(geofence);
            self.told_fence = fence.state(now);
            let body = GeofenceBody::new(fence.fence(), self.told_fence);
            self.actions
                .push_back(Action::SendAll(FromBridge::Geofence(body)));
        }
        Ok(())
    }

    fn set_geofence(&mut self, now: Duration, client: ClientId) {
        if self.robot.fence.is_none() {
            return self.send(client, FromBridge::Refused(RefusalReason::NoMap));
        }
        let zones = std::mem::take(&mut self.asked_zones);
        if let Err(error) = self.fence_in(now, &zones) {
            let (severity, text) = (Severity::Warning, format!("The geofence is none: {error}."));
            self.send(client, FromBridge::Notice(Notice { severity, text }));
            return self.send(client, FromBridge::Refused(RefusalReason::BadFence));
        }
        self.actions.push_back(Action::KeepGeofence(client, zones));
    }

    /// A new map has no fence: a client that may not remove the fence may not begin a new map
    /// either.
    fn is_fenced_against(&self, client: ClientId) -> bool {
        let fence = self.robot.fence.as_ref();
        let is_fenced = fence.is_some_and(|fence| !fence.fence().is_empty());
        let role = self.clients.get(&client).map(|client| client.role);
        let lifts = ToBridge::SetGeofence { zones: vec![] };
        is_fenced && !role.unwrap_or_default().may(&lifts)
    }

    /// Disarms a robot that has left its fence, and tells everyone when the fence's state changes.
    fn watch_fence(&mut self, now: Duration) {
        let Some(fence) = &mut self.robot.fence else {
            return;
        };
        let state = fence.state(now);
        if state == self.told_fence {
            return;
        }
        let before = std::mem::replace(&mut self.told_fence, state);
        let body = GeofenceBody::new(fence.fence(), state);
        self.actions
            .push_back(Action::SendAll(FromBridge::Geofence(body)));
        // Only leaving counts: a robot that was armed outside may be driven back.
        let has_left = state == FenceState::Outside && before != FenceState::Off;
        match state {
            _ if has_left => self.fault(now, DisarmReason::Geofence),
            FenceState::Held if self.safety.is_armed() => self.notify(
                Severity::Warning,
                "The geofence holds the robot back: drive it another way.".to_owned(),
            ),
            FenceState::NoPose if self.safety.is_armed() => self.notify(
                Severity::Warning,
                "The robot stands: it has a geofence, and it is not known where it is.".to_owned(),
            ),
            _ => (),
        }
    }

    fn has_lost_its_driver(&self) -> bool {
        matches!(
            self.safety.reason(),
            DisarmReason::DriverGone | DisarmReason::LeaseExpired | DisarmReason::TakenOver
        )
    }

    /// Sends the state to everyone if it has changed; otherwise only to a driver who asked for
    /// something and waits for an answer.
    fn tell_state(&mut self, asker: Option<ClientId>) {
        let state = self.state();
        if state != self.told {
            self.told = state.clone();
            self.actions
                .push_back(Action::SendAll(FromBridge::Safety(state)));
        } else if let Some(asker) = asker {
            self.send(asker, FromBridge::Safety(state));
        }
    }

    fn order(&mut self, order: Order) {
        self.robot.plausible.ordered(&order);
        if let Some(source) = self.robot.source {
            self.orders += 1;
            let number = self.orders;
            self.ordered_manoeuvre = order.is_manoeuvre().then_some(number);
            self.actions.push_back(Action::Order {
                source,
                order,
                number,
            });
        }
    }

    fn state(&self) -> SafetyBody {
        let driver = self.safety.driver();
        let client = driver.and_then(|id| self.clients.get(&id));
        SafetyBody {
            driver,
            driver_name: client.map_or(String::new(), |client| client.name.clone()),
            armed: self.safety.is_armed(),
            emergency: self.safety.is_emergency(),
            reason: self.safety.reason(),
        }
    }

    fn heartbeat(&mut self, client: ClientId) {
        let heartbeat = BridgeHeartbeat {
            dropped: 0,
            clients: self.client_count() as u16,
            robot_micros: self.robot.newest.0.0,
        };
        self.send(client, FromBridge::Heartbeat(heartbeat));
    }

    fn send(&mut self, client: ClientId, message: FromBridge) {
        self.actions.push_back(Action::Send(client, message));
    }
}

/// What a bridge says first, to a client and at the head of a recording. `challenge` is drawn for
/// the connection.
#[must_use]
pub fn hello(
    challenge: [u8; CHALLENGE_BYTES],
    watching: Watching,
    robot: Option<RobotFigures>,
) -> BridgeHello {
    BridgeHello {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        schema: SCHEMA,
        challenge,
        watching,
        robot,
        watchdog_millis: WATCHDOG.as_millis() as u16,
        lease_millis: LEASE.as_millis() as u16,
    }
}

/// A fault in words for a person: cause and cure.
fn sentence(reason: DisarmReason) -> &'static str {
    match reason {
        DisarmReason::Bumper => {
            "A bumper was pressed: the robot was stopped. Arm it again to back off."
        }
        DisarmReason::Battery => "The battery is nearly empty: the robot was stopped. Charge it.",
        DisarmReason::Stall => {
            "The robot was commanded to run and does not move: it was stopped. Look whether something blocks its tracks."
        }
        DisarmReason::Runaway => {
            "The robot moves without a command: its motors were cut off. Reset the emergency stop when it is safe."
        }
        DisarmReason::Silence => {
            "The robot has said nothing for half a second: it was stopped. Look at its link."
        }
        DisarmReason::Geofence => {
            "The robot has left its geofence: it was stopped. Arm it again to drive it back; it goes no other way."
        }
        _ => "The robot was stopped.",
    }
}
