//! An LD06 or LD19 as a source: the driver of `core` on a line.

use std::collections::VecDeque;

use crate::robot::Stamp;
use crate::wire::ld06::driver::{self, Driver};
use crate::wire::message::{DeviceState, LinkState};
use crate::wire::revolution::RevolutionConfig;

use crate::device::line::{Device, Want};
use crate::device::report::Report;
use crate::device::source::{Order, Profile, SourceEvent};

/// An LD06 or LD19 at the other end of a line. It cannot be told anything: its motor runs while it has power.
#[derive(Debug)]
pub struct Ld06 {
    name: String,
    config: RevolutionConfig,
    driver: Driver,
    report: Report,
    wants: VecDeque<Want>,
}

impl Ld06 {
    /// Its baud rate.
    pub const BAUD_RATE: u32 = 230_400;

    /// A lidar called `name`, as on the command line.
    #[must_use]
    pub fn new(name: impl Into<String>, config: RevolutionConfig) -> Self {
        Self {
            name: name.into(),
            driver: Driver::new(config.clone(), Stamp(0)),
            config,
            report: Report::default(),
            wants: VecDeque::new(),
        }
    }

    fn collect(&mut self, now: Stamp) {
        while let Some(event) = self.driver.next_event() {
            match event {
                // The fault itself follows, and says why.
                driver::Event::State(DeviceState::Fault) => (),
                driver::Event::State(state) => self.state(state),
                driver::Event::Scan(scan) => {
                    self.wants.push_back(Want::Well);
                    self.wants.push_back(Want::Report(SourceEvent::Scan(scan)));
                }
                driver::Event::Fault(fault) => {
                    self.report.detail = fault.to_string();
                    self.state(DeviceState::Fault);
                }
            }
        }
        self.report.count(self.driver.tally());
        self.wants
            .extend(self.report.link_now_and_then(now).map(Want::Report));
    }

    fn state(&mut self, state: DeviceState) {
        if state != DeviceState::Fault {
            self.report.detail.clear();
            self.report.model = "LD06 or LD19".into();
        }
        self.wants
            .extend(self.report.lidar(state).map(Want::Report));
    }
}

impl Device for Ld06 {
    fn profile(&self) -> Profile {
        Profile::of_sensor(&self.name)
    }

    fn baud_rate(&self) -> u32 {
        Self::BAUD_RATE
    }

    fn opened(&mut self, now: Stamp) {
        self.driver = Driver::new(self.config.clone(), now);
        self.report.reopened();
        let events = self.report.change(DeviceState::Waiting, LinkState::Opening);
        self.wants.extend(events.map(Want::Report));
    }

    fn receive(&mut self, bytes: &[u8], now: Stamp) {
        self.driver.receive(bytes, now);
    }

    fn order(&mut self, _: Order, _: Stamp) {
        // It is no robot; nobody drives it.
    }

    fn tick(&mut self, now: Stamp) {
        self.driver.tick(now);
        self.collect(now);
    }

    fn close(&mut self, _: Stamp) {}

    fn broken(&mut self, why: String) {
        self.wants.clear();
        self.wants.extend(self.report.broken(why).map(Want::Report));
    }

    fn next_want(&mut self) -> Option<Want> {
        self.wants.pop_front()
    }
}
