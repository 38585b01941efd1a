//! Events, messages and time in any order. The bystander knows only what the rules promise.

use std::collections::BTreeSet;

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

use super::*;

/// From the last driving message that counts to the order to stop.
const WATCHDOG: Duration = Duration::from_millis(200);
const DRIVERS: [&str; 2] = ["first", "second"];
const WATCHER: usize = 2;

/// What happens. Clients 0 and 1 may drive; client 2 may not.
#[derive(Clone, Copy, Debug)]
enum Step {
    /// The client joins, or leaves and joins again.
    Join(usize),
    Leave(usize),
    Revoke(usize),
    Take(usize, bool),
    Arm(usize),
    /// With the epoch of the newest lease, or another; what was seen is this many ms old.
    Drive(usize, bool, u64, Command),
    Hold(usize, u64),
    Stop(usize),
    EmergencyStop(usize),
    Reset(usize),
    /// Somebody at the machine stops the robot.
    StopHere(bool),
    Link(LinkState),
    Bumper(bool),
    /// The robot reports rest, after the order this many orders ago.
    Rests(u64),
    Shutdown,
    Wait,
}

fn any_motion() -> impl Strategy<Value = Command> {
    prop_oneof![
        4 => (-0.3..0.3, -1.0..1.0).prop_map(|(forward, turn)| Command::Velocity { forward, turn }),
        1 => Just(Command::Stop),
        1 => (-1.0..1.0).prop_map(Command::Forward),
        2 => (-1.0..1.0).prop_map(Command::Turn),
        1 => Just(Command::Scan),
        1 => Just(Command::Turn(f64::NAN)),
    ]
}

fn any_step() -> impl Strategy<Value = Step> {
    let who = || prop_oneof![6 => Just(0_usize), 2 => Just(1), 1 => Just(WATCHER)];
    let good = || prop::bool::weighted(0.9);
    let ago = || prop_oneof![9 => 0_u64..250, 1 => 250_u64..700];
    prop_oneof![
        2 => who().prop_map(Step::Join),
        1 => who().prop_map(Step::Leave),
        1 => who().prop_map(Step::Revoke),
        2 => (who(), any::<bool>()).prop_map(|(who, force)| Step::Take(who, force)),
        8 => who().prop_map(Step::Arm),
        30 => (who(), good(), ago(), any_motion()).prop_map(|(who, good, ago, motion)| Step::Drive(who, good, ago, motion)),
        5 => (who(), ago()).prop_map(|(who, ago)| Step::Hold(who, ago)),
        1 => who().prop_map(Step::Stop),
        1 => who().prop_map(Step::EmergencyStop),
        3 => who().prop_map(Step::Reset),
        1 => any::<bool>().prop_map(Step::StopHere),
        2 => prop_oneof![3 => Just(LinkState::Up), 1 => Just(LinkState::Down), 1 => Just(LinkState::Opening)].prop_map(Step::Link),
        2 => any::<bool>().prop_map(Step::Bumper),
        6 => (0_u64..3).prop_map(Step::Rests),
        1 => Just(Step::Shutdown),
        10 => Just(Step::Wait),
    ]
}

/// Runs a hub and judges its actions.
struct Bystander {
    hub: Hub,
    now: Duration,
    sequence: u32,
    clients: [Option<ClientId>; 3],
    /// Client and epoch of the newest lease.
    lease: Option<(ClientId, u32)>,
    is_up: bool,
    bumper: bool,
    /// When the last driving message arrived, until the robot is ordered to stop.
    runs_since: Option<Duration>,
    orders: u64,
    /// Client and sequence of the manoeuvre that has begun and is not over.
    manoeuvre: Option<(ClientId, u32)>,
    state: SafetyBody,
    moves: u32,
    ended: u32,
}

impl Bystander {
    /// With a robot in the open that the first client has armed.
    fn new() -> Result<Self, TestCaseError> {
        let hub = hub();
        let state = hub.state();
        let mut all = Self {
            hub,
            now: at(10),
            sequence: 0,
            clients: [None; 3],
            lease: None,
            is_up: false,
            bumper: false,
            runs_since: None,
            orders: 0,
            manoeuvre: None,
            state,
            moves: 0,
            ended: 0,
        };
        all.go(at(10))?;
        for step in [
            Step::Link(LinkState::Up),
            Step::Join(0),
            Step::Join(1),
            Step::Join(WATCHER),
            Step::Take(0, false),
            Step::Arm(0),
        ] {
            all.step(step)?;
        }
        Ok(all)
    }

    /// Time passes in steps of 10 ms: the robot reports that it stands still, and the lidar what it
    /// sees.
    fn go(&mut self, pause: Duration) -> Result<(), TestCaseError> {
        let until = self.now + pause;
        while self.now < until {
            let deadline = self.hub.deadline().max(self.now);
            let next = (self.now + at(10)).min(until);
            if deadline <= next {
                self.now = deadline;
                self.hub.tick(self.now);
                self.judge(None)?;
                if self.hub.deadline() <= self.now {
                    return Err(TestCaseError::fail("it is due for ever"));
                }
                continue;
            }
            let (from, to) = (self.now.as_millis() as u64, next.as_millis() as u64);
            self.now = next;
            if to > from && self.is_up {
                self.hub.event(next, ROBOT, odometry(from, to, 0.0));
                self.hub.event(next, LIDAR, far_walls(Stamp(1000 * to)));
                self.judge(None)?;
            }
        }
        Ok(())
    }

    fn step(&mut self, step: Step) -> Result<(), TestCaseError> {
        let now = self.now;
        let of_lease = self.lease.map_or(0, |(_, epoch)| epoch);
        let seen = |ago| now.saturating_sub(at(ago));
        let (who, message) = match step {
            Step::Join(who) => {
                self.leave(who)?;
                let name = DRIVERS.get(who).copied().unwrap_or("watcher");
                let role = match who {
                    WATCHER => Role::Watcher,
                    _ => Role::Driver,
                };
                self.clients[who] = Some(self.hub.join(name.to_owned(), of_role(role)));
                return self.judge(None);
            }
            Step::Leave(who) => return self.leave(who),
            Step::Revoke(who) => {
                if let Some(client) = self.clients[who] {
                    let drove = self.hub.safety.driver() == Some(client);
                    self.hub.revoke(now, client);
                    prop_assert!(self.hub.safety.driver() != Some(client));
                    prop_assert!(!drove || !self.hub.safety.is_armed());
                    self.judge(None)?;
                    self.clients[who] = None;
                }
                return Ok(());
            }
            Step::StopHere(cut_off) => {
                self.hub.stop(now, cut_off);
                prop_assert!(!self.hub.safety.is_armed());
                return self.judge(None);
            }
            Step::Link(state) => {
                self.is_up = state == LinkState::Up;
                self.hub.event(now, ROBOT, link(state));
                return self.judge(None);
            }
            Step::Bumper(left) => {
                let was_pressed = std::mem::replace(&mut self.bumper, left);
                let begins = left && !was_pressed;
                let bumpers = SourceEvent::Bumpers(BumpersBody {
                    source: ROBOT,
                    stamp: now.as_micros() as u64,
                    left,
                    right: false,
                });
                self.hub.event(now, ROBOT, bumpers);
                prop_assert!(!begins || !self.hub.safety.is_armed());
                return self.judge(None);
            }
            Step::Rests(ago) => {
                let after = self.orders.saturating_sub(ago);
                let rests = SourceEvent::Busy { busy: false, after };
                self.hub.event(now, ROBOT, rests);
                return self.judge(None);
            }
            Step::Shutdown => {
                self.hub.shut_down(now);
                prop_assert!(!self.hub.safety.is_armed());
                return self.judge(None);
            }
            Step::Wait => return self.go(at(150)),
            Step::Take(who, force) => (who, ToBridge::Take { force }),
            Step::Arm(who) => (who, ToBridge::Arm { epoch: of_lease }),
            Step::Drive(who, is_good, ago, motion) => {
                let epoch = of_lease + u32::from(!is_good);
                (who, drive(epoch, seen(ago), motion))
            }
            Step::Hold(who, ago) => {
                let hold = ToBridge::Hold {
                    epoch: of_lease,
                    seen: seen(ago).as_micros() as u64,
                    ttl_millis: 300,
                };
                (who, hold)
            }
            Step::Stop(who) => (who, ToBridge::Stop),
            Step::EmergencyStop(who) => (who, ToBridge::EmergencyStop),
            Step::Reset(who) => (who, ToBridge::ResetEmergencyStop { epoch: of_lease }),
        };
        let Some(client) = self.clients[who] else {
            return Ok(());
        };
        self.sequence += 1;
        let header = header(self.sequence);
        self.hub.message(now, now, client, header, message.clone());
        self.judge(Some(&(client, who, message)))
    }

    fn leave(&mut self, who: usize) -> Result<(), TestCaseError> {
        if let Some(client) = self.clients[who].take() {
            self.hub.leave(self.now, client);
            prop_assert!(self.hub.safety.driver() != Some(client));
            self.judge(None)?;
        }
        Ok(())
    }

    /// Judges the actions after a message, or after something else.
    fn judge(&mut self, cause: Option<&(ClientId, usize, ToBridge)>) -> Result<(), TestCaseError> {
        let out = actions(&mut self.hub);
        let was_armed = self.state.armed;
        let is_refused = out.iter().any(|action| {
            matches!(
                action,
                Action::Send(_, FromBridge::Refused(_)) | Action::Close(..)
            )
        });
        for action in out {
            self.action(action, cause, was_armed)?;
        }
        match cause {
            _ if is_refused => (),
            Some((_, _, ToBridge::Hold { .. })) => {
                self.runs_since = self.runs_since.map(|_| self.now);
            }
            Some((_, _, ToBridge::Drive(body))) => {
                self.runs_since = (body.motion != Command::Stop).then_some(self.now);
            }
            _ => (),
        }
        let state = self.hub.state();
        prop_assert_eq!(&self.state, &state, "everybody knows the state");
        let is_ready = state.driver.is_some() && self.is_up && !state.emergency;
        prop_assert!(!state.armed || is_ready);
        if let Some(since) = self.runs_since {
            prop_assert!(state.armed, "disarmed, and it runs");
            prop_assert!(self.now < since + WATCHDOG, "it runs by itself");
        }
        Ok(())
    }

    fn action(
        &mut self,
        action: Action,
        cause: Option<&(ClientId, usize, ToBridge)>,
        was_armed: bool,
    ) -> Result<(), TestCaseError> {
        let present: BTreeSet<ClientId> = self.clients.into_iter().flatten().collect();
        match action {
            Action::Order {
                source,
                order,
                number,
            } => {
                self.orders += 1;
                prop_assert_eq!((source, number), (usize::from(ROBOT), self.orders));
                self.order(order, cause, was_armed)?;
            }
            Action::Send(client, message) => match message {
                FromBridge::Granted(lease) => {
                    prop_assert!(self.runs_since.is_none(), "a new lease stops first");
                    prop_assert!(self.lease.is_none_or(|(_, epoch)| lease.epoch > epoch));
                    self.lease = Some((client, lease.epoch));
                }
                FromBridge::Manoeuvre(body) if body.busy => {
                    let it = (body.client, body.sequence);
                    prop_assert_eq!(self.manoeuvre, Some(it), "whoever comes learns of it");
                }
                FromBridge::Manoeuvre(body) => {
                    let sender = cause.map(|(sender, ..)| *sender);
                    prop_assert_eq!((sender, body.client), (Some(client), client));
                    prop_assert_eq!(body.sequence, self.sequence);
                }
                FromBridge::Heartbeat(_) => prop_assert!(present.contains(&client)),
                _ => (),
            },
            Action::SendAll(FromBridge::Safety(state)) => self.state = state,
            Action::SendAll(FromBridge::Manoeuvre(body)) => {
                let it = (body.client, body.sequence);
                prop_assert_eq!(self.manoeuvre, (!body.busy).then_some(it));
                self.manoeuvre = body.busy.then_some(it);
                self.ended += u32::from(!body.busy);
            }
            Action::SendAll(_) => (),
            Action::Close(client, _)
            | Action::ResetMap(client)
            | Action::KeepGeofence(client, _) => {
                prop_assert!(present.contains(&client));
            }
        }
        Ok(())
    }

    fn order(
        &mut self,
        order: Order,
        cause: Option<&(ClientId, usize, ToBridge)>,
        was_armed: bool,
    ) -> Result<(), TestCaseError> {
        match order {
            Order::EmergencyStop | Order::Command(Command::Stop) => {
                self.runs_since = None;
                return Ok(());
            }
            Order::ResetEmergencyStop => return Ok(()),
            Order::Command(Command::Velocity { forward, turn })
                if forward == 0.0 && turn == 0.0 =>
            {
                return Ok(());
            }
            Order::Command(_) => (),
        }
        let Some((client, who, ToBridge::Drive(body))) = cause else {
            // Safe mode corrects a command under way, and never moves a robot that stands.
            prop_assert!(self.runs_since.is_some(), "{:?} moved the robot", cause);
            return Ok(());
        };
        prop_assert!(was_armed && *who != WATCHER);
        prop_assert_eq!(self.lease, Some((*client, body.epoch)));
        prop_assert!(self.now - Duration::from_micros(body.seen) <= at(300));
        self.moves += 1;
        Ok(())
    }
}

fn any_steps() -> impl Strategy<Value = Vec<(Step, u64)>> {
    prop::collection::vec((any_step(), 0_u64..60), 1..80)
}

fn play(steps: &[(Step, u64)]) -> Result<Bystander, TestCaseError> {
    let mut bystander = Bystander::new()?;
    for (step, pause) in steps {
        bystander.step(*step)?;
        bystander.go(at(*pause))?;
    }
    // When a client leaves or the robot's link is lost, nothing stays under way.
    bystander.step(Step::Link(LinkState::Down))?;
    prop_assert!(bystander.manoeuvre.is_none() && bystander.runs_since.is_none());
    Ok(bystander)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn in_any_order_of_things_nothing_moves_that_may_not(steps in any_steps()) {
        play(&steps)?;
    }
}

/// Without this, the property above would also hold if nothing ever moved.
#[test]
fn the_random_steps_do_move_the_robot() {
    let mut runner = TestRunner::deterministic();
    let (mut moves, mut ended) = (0, 0);
    for _ in 0..100 {
        let steps = any_steps().new_tree(&mut runner).unwrap().current();
        let bystander = play(&steps).unwrap();
        (moves, ended) = (moves + bystander.moves, ended + bystander.ended);
    }
    assert!(
        moves > 50 && ended > 20,
        "{moves} moves, {ended} manoeuvres"
    );
}
