//! A simulated robot that records its commands with their times, and how its motors ran.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use slamlab_bridge::Config;
use slamlab_bridge::source::{Order, Port, Profile, Source, SourceEvent, Waited};
use slamlab_core::robot::Command;
use slamlab_core::sim::{SensorModel, Simulation, World, worlds};
use slamlab_core::wire::message::{LinkBody, LinkState, Watching};

const PERIOD: Duration = Duration::from_millis(5);

/// The robot's record.
#[derive(Clone, Default)]
pub(crate) struct Memory(Arc<Mutex<Remembered>>);

#[derive(Default)]
struct Remembered {
    orders: Vec<(Instant, Order)>,
    /// When the motors last ran.
    ran: Option<Instant>,
    /// Whether to simulate a pulled cable.
    is_cut: bool,
    has_ended: bool,
    /// When the odometry up to this stamp was sent.
    sent: BTreeMap<u64, Instant>,
}

impl Memory {
    /// Its commands, and when they arrived.
    pub(crate) fn orders(&self) -> Vec<(Instant, Order)> {
        self.0.lock().unwrap().orders.clone()
    }

    /// Whether any order would have moved the robot.
    pub(crate) fn was_moved(&self) -> bool {
        self.orders().iter().any(|(_, order)| is_motion(order))
    }

    pub(crate) fn ran(&self) -> Option<Instant> {
        self.0.lock().unwrap().ran
    }

    pub(crate) fn forget(&self) {
        let mut remembered = self.0.lock().unwrap();
        remembered.orders.clear();
        remembered.ran = None;
        remembered.sent.clear();
    }

    pub(crate) fn cut(&self, is_cut: bool) {
        self.0.lock().unwrap().is_cut = is_cut;
    }

    pub(crate) fn sent(&self, stamp: u64) -> Option<Instant> {
        self.0.lock().unwrap().sent.get(&stamp).copied()
    }

    pub(crate) fn has_ended(&self) -> bool {
        self.0.lock().unwrap().has_ended
    }

    /// Whether an order to stop came at `from` or later.
    pub(crate) fn stopped_since(&self, from: Instant) -> bool {
        let orders = self.orders();
        let mut stops = orders.iter().filter(|(_, order)| is_stop(order));
        stops.any(|(at, _)| *at >= from)
    }

    /// The first order to stop that came at `from` or later.
    pub(crate) async fn stopped_after(&self, from: Instant) -> Duration {
        for _ in 0..2000 {
            let orders = self.orders();
            let mut stops = orders
                .iter()
                .filter(|(at, order)| *at >= from && is_stop(order));
            if let Some((at, _)) = stops.next() {
                return at.duration_since(from);
            }
            tokio::time::sleep(Duration::from_millis(2)).await;
        }
        panic!("it was never stopped: {:?}", self.orders());
    }
}

pub(crate) fn is_stop(order: &Order) -> bool {
    matches!(order, Order::Command(Command::Stop) | Order::EmergencyStop)
}

pub(crate) fn is_motion(order: &Order) -> bool {
    !is_stop(order) && !matches!(order, Order::ResetEmergencyStop)
}

/// The robot, in a world large enough for driving a while.
pub(crate) struct TestRobot {
    simulation: Simulation,
    memory: Memory,
}

/// Settings of a bridge with such a robot, and the robot's record.
pub(crate) fn with_robot() -> (Config, Memory) {
    with_robot_in(worlds::builtin("arena").unwrap())
}

/// Settings of a bridge with such a robot, which nobody may watch without the token.
pub(crate) fn private() -> Config {
    Config {
        watching: Some(Watching::Token),
        ..with_robot().0
    }
}

pub(crate) fn with_robot_in(world: World) -> (Config, Memory) {
    let memory = Memory::default();
    let robot = world.robot.model();
    let simulation = Simulation::new(world, robot, SensorModel::lidar(), 1).unwrap();
    let source = TestRobot {
        simulation,
        memory: memory.clone(),
    };
    let config = Config {
        sources: vec![Box::new(source)],
        ..Config::default()
    };
    (config, memory)
}

impl Source for TestRobot {
    fn profile(&self) -> Profile {
        Profile {
            name: "test".into(),
            robot: Some(*self.simulation.robot()),
            takes_orders: true,
            scans_on_command: false,
        }
    }

    fn run(mut self: Box<Self>, port: Port) {
        let mut next = Instant::now();
        let mut was_cut = true;
        let mut emergency = false;
        loop {
            let is_cut = self.memory.0.lock().unwrap().is_cut;
            if is_cut != was_cut {
                was_cut = is_cut;
                port.send(link(is_cut));
            }
            match port.wait(next.saturating_duration_since(Instant::now())) {
                Waited::Closed => break,
                Waited::Order(order) => {
                    let now = Instant::now();
                    self.memory.0.lock().unwrap().orders.push((now, order));
                    match order {
                        Order::Command(command) if !emergency => self.simulation.command(command),
                        Order::EmergencyStop => {
                            emergency = true;
                            self.simulation.command(Command::Stop);
                        }
                        Order::ResetEmergencyStop => emergency = false,
                        _ => (),
                    }
                }
                Waited::Nothing => {
                    next += PERIOD;
                    self.simulation.advance(PERIOD.as_secs_f64());
                    self.report(&port, is_cut);
                }
            }
        }
        self.memory.0.lock().unwrap().has_ended = true;
    }
}

impl TestRobot {
    fn report(&mut self, port: &Port, is_cut: bool) {
        let (forward, turn) = self.simulation.speeds();
        if forward.abs() > 1e-3 || turn.abs() > 1e-2 {
            self.memory.0.lock().unwrap().ran = Some(Instant::now());
        }
        let odometry = self.simulation.odometry();
        let scan = self.simulation.take_scan();
        if is_cut {
            return;
        }
        let now = Instant::now();
        self.memory
            .0
            .lock()
            .unwrap()
            .sent
            .insert(odometry.to.0, now);
        port.send(SourceEvent::Odometry(odometry));
        if let Some(scan) = scan {
            port.send(SourceEvent::Scan(scan));
        }
    }
}

fn link(is_cut: bool) -> SourceEvent {
    SourceEvent::Link(LinkBody::new(if is_cut {
        LinkState::Down
    } else {
        LinkState::Up
    }))
}
