//! The simulated robot as a source: the core's simulation, at the pace of the real clock.
//!
//! In: a world, and orders. Out: odometry at 100 Hz, whatever the sensor sees, bumpers, currents,
//! battery.
//!
//! 1. Each period, the simulation catches up with the clock. If the machine was busy for longer
//!    than `MOST_LATE`, that time is left out: the robot's clock then runs behind, which is
//!    allowed, but never jumps.
//! 2. The same seed gives the same noise; when orders arrive is up to the driver.
//! 3. The emergency stop is latched here, as it is in the real robot.

use std::time::{Duration, Instant};

use slamlab_core::format::world;
use slamlab_core::robot::{Bumpers, Command};
use slamlab_core::sim::{
    SensorKind, SensorModel, SimError, Simulation, UnknownSensor, World, worlds,
};
use slamlab_core::wire::message::{
    BatteryBody, BumpersBody, CurrentsBody, DeviceState, LinkBody, LinkState,
};

use super::{Order, Port, Profile, Source, SourceEvent, Waited};

/// Interval between odometry readings.
const PERIOD: Duration = Duration::from_millis(10);
/// Longest delay for which the simulation makes up.
const MOST_LATE: Duration = Duration::from_millis(200);
/// Periods between readings of the motor currents; below, those of unchanged bumpers, and of
/// battery and link.
const CURRENTS_EVERY: u64 = 5;
const BUMPERS_EVERY: u64 = 50;
const BATTERY_EVERY: u64 = 100;

/// Why there is no such simulated robot.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimSourceError {
    /// Neither a built-in world nor a file.
    #[error(
        "there is no world `{name}`; built in are {known}, and `sim:FILE.json` reads a world file: {source}",
        known = worlds::NAMES.join(", ")
    )]
    NoWorld {
        /// As it was named.
        name: String,
        /// What the system said of a file of this name.
        source: std::io::Error,
    },
    /// The file holds no world.
    #[error("{name}: {source}")]
    File {
        /// As it was named.
        name: String,
        /// What is wrong with it.
        source: world::WorldFileError,
    },
    /// There is no such sensor.
    #[error(transparent)]
    Sensor(#[from] UnknownSensor),
    /// The robot cannot be in this world.
    #[error(transparent)]
    Sim(#[from] SimError),
}

/// A simulated robot that has not started yet.
#[derive(Debug)]
pub struct SimSource {
    name: String,
    simulation: Simulation,
}

impl SimSource {
    /// The simulation of a world, built in or a file, with the world's robot, sensor and seed;
    /// `WORLD,SENSOR` chooses another sensor.
    ///
    /// # Errors    [`SimSourceError`]: there is no such world or sensor, or it cannot be used.
    pub fn new(which: &str) -> Result<Self, SimSourceError> {
        let name = format!("sim:{which}");
        let (world, sensor) = match which.split_once(',') {
            Some((world, sensor)) => (find(world)?, Some(sensor.parse::<SensorKind>()?)),
            None => (find(which)?, None),
        };
        let sensor = sensor.unwrap_or(world.sensor).model();
        let (robot, seed) = (world.robot.model(), world.seed);
        let simulation = Simulation::new(world, robot, sensor, seed)?;
        Ok(Self { name, simulation })
    }
}

fn find(name: &str) -> Result<World, SimSourceError> {
    if let Some(world) = worlds::builtin(name) {
        return Ok(world);
    }
    let named = |source| SimSourceError::NoWorld {
        name: name.to_owned(),
        source,
    };
    let bytes = std::fs::read(name).map_err(named)?;
    world::read(&bytes).map_err(|source| SimSourceError::File {
        name: name.to_owned(),
        source,
    })
}

impl Source for SimSource {
    fn profile(&self) -> Profile {
        Profile {
            name: self.name.clone(),
            robot: Some(*self.simulation.robot()),
            takes_orders: true,
            scans_on_command: self.simulation.sensor().scans_on_command(),
        }
    }

    fn run(self: Box<Self>, port: Port) {
        let sensor = match self.simulation.sensor() {
            SensorModel::Lidar(_) => "lidar",
            SensorModel::Rangers(_) => "rangers on a servo",
            SensorModel::Sonar(_) => "sonars",
        };
        let robot = self.simulation.robot().name;
        port.send(SourceEvent::Device {
            state: DeviceState::Sending,
            model: format!("simulated {robot} with {sensor}"),
            detail: String::new(),
        });
        let mut life = Life {
            simulation: self.simulation,
            port,
            period: 0,
            bumpers: None,
            busy: None,
            is_cut_off: false,
        };
        life.link();
        life.live();
    }
}

struct Life {
    simulation: Simulation,
    port: Port,
    period: u64,
    bumpers: Option<Bumpers>,
    busy: Option<bool>,
    is_cut_off: bool,
}

impl Life {
    fn live(&mut self) {
        let mut next = Instant::now() + PERIOD;
        loop {
            match self
                .port
                .wait(next.saturating_duration_since(Instant::now()))
            {
                Waited::Order(order) => self.obey(order),
                Waited::Closed => return,
                Waited::Nothing => {
                    let late = Instant::now().saturating_duration_since(next);
                    if late > MOST_LATE {
                        next += late;
                    }
                    next += PERIOD;
                    self.step();
                }
            }
        }
    }

    fn obey(&mut self, order: Order) {
        match order {
            Order::Command(_) if self.is_cut_off => (),
            Order::Command(command) => self.simulation.command(command),
            Order::EmergencyStop => {
                self.is_cut_off = true;
                self.simulation.command(Command::Stop);
            }
            Order::ResetEmergencyStop => self.is_cut_off = false,
        }
        self.busy = None;
        self.tell_busy();
    }

    fn step(&mut self) {
        self.simulation.advance(PERIOD.as_secs_f64());
        self.period += 1;
        let odometry = self.simulation.odometry();
        self.port.send(SourceEvent::Odometry(odometry));
        while let Some(scan) = self.simulation.take_scan() {
            self.port.send(SourceEvent::Scan(scan));
        }
        while let Some(scan) = self.simulation.take_partial_scan() {
            self.port.send(SourceEvent::PartialScan(scan));
        }
        self.readings();
    }

    fn tell_busy(&mut self) {
        let busy = self.simulation.is_busy();
        if self.busy.replace(busy) != Some(busy) {
            self.port.send(SourceEvent::Busy { busy, after: 0 });
        }
    }

    fn readings(&mut self) {
        let (source, stamp) = (0, self.simulation.stamp().0);
        let is_due = |every| self.period.is_multiple_of(every);
        let bumpers = self.simulation.bumpers();
        if is_due(BUMPERS_EVERY) || self.bumpers.replace(bumpers) != Some(bumpers) {
            let Bumpers { left, right } = bumpers;
            self.port.send(SourceEvent::Bumpers(BumpersBody {
                source,
                stamp,
                left,
                right,
            }));
        }
        if is_due(CURRENTS_EVERY) {
            let [left, right] = self.simulation.motor_currents().map(|amps| amps as f32);
            self.port.send(SourceEvent::Currents(CurrentsBody {
                source,
                stamp,
                left,
                right,
            }));
        }
        if is_due(BATTERY_EVERY) {
            let volts = self.simulation.battery_volts() as f32;
            self.port.send(SourceEvent::Battery(BatteryBody {
                source,
                stamp,
                volts,
            }));
            self.link();
            self.busy = None;
        }
        self.tell_busy();
    }

    fn link(&self) {
        let up = LinkBody::new(LinkState::Up);
        self.port.send(SourceEvent::Link(up));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_world_that_is_not_there_is_a_sentence_that_names_those_that_are() {
        let error = SimSource::new("atlantis").unwrap_err().to_string();
        assert!(
            error.contains("`atlantis`") && error.contains("arena"),
            "{error}"
        );
    }

    #[test]
    fn another_sensor_can_be_named() {
        let lidar = SimSource::new("arena,lidar").unwrap().profile();
        let rangers = SimSource::new("arena,rangers").unwrap().profile();
        assert!(!lidar.scans_on_command && rangers.scans_on_command);
        let error = SimSource::new("arena,nose").unwrap_err().to_string();
        assert!(
            error.contains("`nose`") && error.contains("lidar"),
            "{error}"
        );
    }

    #[test]
    fn every_built_in_world_has_its_robot() {
        for name in worlds::NAMES {
            let profile = SimSource::new(name).unwrap().profile();
            assert_eq!(profile.name, format!("sim:{name}"));
            assert!(profile.robot.is_some());
        }
    }
}
