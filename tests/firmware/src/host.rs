//! The host at the other end of the serial line.
//!
//! In: commands. Out: events of the link, as the firmware makes them.
//!
//! Bytes to the robot go at the line's speed, one in 10 bits of 38400 baud; those from it come as
//! simavr sends them.

use std::collections::VecDeque;

use anyhow::{Context, Result, ensure};
use slamlab_core::robot::Stamp;
use slamlab_core::wire::rp6::{
    Command, CommandResult, Hello, Link, LinkEvent, Phase, Ranger, Telemetry,
};
use slamlab_tests::devices::{Faults, Line};

use crate::Rig;

/// Time of a byte on the line, s.
const BYTE: f64 = 10.0 / 38_400.0;

/// A link to a simulated robot.
pub struct Host {
    /// The robot.
    pub rig: Rig,
    /// The link.
    pub link: Link,
    /// What the robot said last.
    pub telemetry: Option<Telemetry>,
    /// Readings of the rangers, in the order in which they came.
    pub rangers: Vec<Ranger>,
    /// Other events.
    pub events: Vec<LinkEvent>,
    /// Whether the cable is on.
    pub is_connected: bool,
    /// What the line does to bytes, both ways.
    pub faults: Faults,
    chance: Line,
    line: VecDeque<u8>,
    next_byte: f64,
    next_tick: f64,
}

impl Host {
    /// A host that has just opened its port to a robot that was just switched on.
    #[must_use]
    pub fn new(rig: Rig) -> Self {
        Self {
            link: Link::new(Stamp(0), 1),
            rig,
            telemetry: None,
            rangers: Vec::new(),
            events: Vec::new(),
            is_connected: true,
            faults: Faults::default(),
            chance: Line::new(1),
            line: VecDeque::new(),
            next_byte: 0.0,
            next_tick: 0.0,
        }
    }

    /// The same, once the robot has answered, and armed.
    ///
    /// # Errors
    /// If it does not answer within two seconds.
    pub fn armed(rig: Rig) -> Result<(Self, Hello)> {
        let mut host = Self::new(rig);
        host.run_until(2.0, |host| host.link.phase() == Phase::Running)?;
        host.link.arm()?;
        let up = host.events.drain(..).find_map(|event| match event {
            LinkEvent::Up(hello) => Some(hello),
            _ => None,
        });
        Ok((host, up.context("no hello")?))
    }

    /// Gives a command to the link.
    ///
    /// # Errors
    /// If the link refuses it.
    pub fn command(&mut self, command: Command) -> Result<()> {
        Ok(self.link.command(command, self.now())?)
    }

    /// Lets time pass, s.
    ///
    /// # Errors
    /// If the firmware crashes.
    pub fn run(&mut self, seconds: f64) -> Result<()> {
        let end = self.rig.seconds() + seconds;
        while self.rig.seconds() < end {
            self.step()?;
        }
        Ok(())
    }

    /// Lets time pass while the driver says that it is there, ten times a second.
    ///
    /// # Errors
    /// If the firmware crashes or the link breaks.
    pub fn drive(&mut self, seconds: f64) -> Result<()> {
        let end = self.rig.seconds() + seconds;
        while self.rig.seconds() < end {
            self.command(Command::Alive)?;
            self.run(0.1)?;
        }
        Ok(())
    }

    /// Drives on until the robot says that it no longer moves or sweeps; gives the time that took,
    /// s.
    ///
    /// # Errors
    /// If it takes longer than `most` seconds.
    pub fn finish(&mut self, most: f64) -> Result<f64> {
        let start = self.rig.seconds();
        // Telemetry from before the command says nothing about it.
        self.drive(0.2)?;
        while self
            .telemetry
            .is_none_or(|t| t.state.moving() || t.state.sweeping())
        {
            ensure!(
                self.rig.seconds() - start < most,
                "still busy after {most} s: {:?}",
                self.telemetry
            );
            self.drive(0.1)?;
        }
        Ok(self.rig.seconds() - start)
    }

    /// Runs until something holds; gives the time that took, s.
    ///
    /// # Errors
    /// If it does not within `most` seconds.
    pub fn run_until(&mut self, most: f64, mut holds: impl FnMut(&Self) -> bool) -> Result<f64> {
        let start = self.rig.seconds();
        while !holds(self) {
            ensure!(self.rig.seconds() - start < most, "not within {most} s");
            self.step()?;
        }
        Ok(self.rig.seconds() - start)
    }

    /// What the robot answered to the last commands, oldest first; forgets it.
    pub fn results(&mut self) -> Vec<(Command, CommandResult)> {
        let acknowledged = |event| match event {
            LinkEvent::Acknowledged { command, result } => Some((command, result)),
            _ => None,
        };
        self.events.drain(..).filter_map(acknowledged).collect()
    }

    fn now(&self) -> Stamp {
        Stamp::from_seconds(self.rig.seconds())
    }

    fn step(&mut self) -> Result<()> {
        self.rig.step()?;
        let (seconds, now) = (self.rig.seconds(), self.now());
        let came = self.rig.chip.take_sent();
        let came = self.chance.carry(&came, &self.faults);
        if self.is_connected {
            self.link.receive(&came, now);
        }
        if seconds >= self.next_tick {
            self.next_tick = seconds + 0.01;
            self.link.tick(now);
        }
        let said = self.link.take_output();
        self.line.extend(self.chance.carry(&said, &self.faults));
        if !self.is_connected {
            self.line.clear();
        }
        while self.next_byte <= seconds && !self.line.is_empty() {
            self.next_byte = self.next_byte.max(seconds - BYTE) + BYTE;
            if let Some(byte) = self.line.pop_front() {
                self.rig.chip.receive(byte);
            }
        }
        while let Some(event) = self.link.next_event() {
            match event {
                LinkEvent::Telemetry(telemetry) => self.telemetry = Some(telemetry),
                LinkEvent::Ranger(ranger) => self.rangers.push(ranger),
                other => self.events.push(other),
            }
        }
        Ok(())
    }
}
