//! An RPLIDAR as a source: the driver of `core` on a line.

use std::collections::VecDeque;

use crate::robot::Stamp;
use crate::wire::message::DeviceState;
use crate::wire::rplidar::driver::{self, Driver, DriverConfig};

use crate::device::line::{Device, Want, Weight};
use crate::device::report::Report;
use crate::device::source::{Order, Profile, SourceEvent};

/// An RPLIDAR at the other end of a line.
#[derive(Debug)]
pub struct Rplidar {
    name: String,
    config: DriverConfig,
    driver: Driver,
    report: Report,
    wants: VecDeque<Want>,
}

impl Rplidar {
    /// Baud rate of the A1.
    pub const BAUD_RATE: u32 = 115_200;

    /// A lidar called `name`, as on the command line.
    #[must_use]
    pub fn new(name: impl Into<String>, config: DriverConfig) -> Self {
        Self {
            name: name.into(),
            driver: Driver::new(config.clone()),
            config,
            report: Report::default(),
            wants: VecDeque::new(),
        }
    }

    /// Takes over what the driver wants.
    fn collect(&mut self, now: Stamp) {
        while let Some(event) = self.driver.next_event() {
            match event {
                driver::Event::Send(bytes) => self.wants.push_back(Want::Write(bytes)),
                // The A1's board runs the motor while DTR is cleared.
                driver::Event::Motor(is_on) => self.wants.push_back(Want::Dtr(!is_on)),
                // The fault itself follows, and says why.
                driver::Event::State(DeviceState::Fault) => (),
                driver::Event::State(state) => self.state(state),
                driver::Event::Identified(info) => {
                    let [major, minor] = info.firmware;
                    self.report.model = format!(
                        "{}, firmware {major}.{minor:02}, hardware {}",
                        model_name(info.model),
                        info.hardware
                    );
                    self.state(self.driver.state());
                }
                driver::Event::Warning(code) => {
                    self.report.detail = warning(code);
                    self.state(self.driver.state());
                }
                driver::Event::RateUnknown => {
                    let text = "does not tell its rate; 500 µs a reading are taken".to_owned();
                    self.wants.push_back(Want::Note(Weight::Info, text));
                }
                driver::Event::Restarting(fault) => {
                    let text = format!("{fault}; it is brought up anew");
                    self.wants.push_back(Want::Note(Weight::Warning, text));
                    self.report.detail = fault.to_string();
                }
                driver::Event::Scan(scan) => {
                    self.report.detail.clear();
                    self.wants.push_back(Want::Well);
                    self.wants.push_back(Want::Report(SourceEvent::Scan(scan)));
                }
                driver::Event::Fault(fault) => {
                    self.report.detail = fault.to_string();
                    self.state(DeviceState::Fault);
                    self.wants.push_back(Want::Reopen);
                }
            }
        }
        self.report.count(self.driver.tally());
        self.wants
            .extend(self.report.link_now_and_then(now).map(Want::Report));
    }

    fn state(&mut self, state: DeviceState) {
        self.wants
            .extend(self.report.lidar(state).map(Want::Report));
    }
}

impl Device for Rplidar {
    fn profile(&self) -> Profile {
        Profile::of_sensor(&self.name)
    }

    fn baud_rate(&self) -> u32 {
        Self::BAUD_RATE
    }

    fn opened(&mut self, now: Stamp) {
        self.driver = Driver::new(self.config.clone());
        self.report.reopened();
        // Why the last line broke is no more true of this one.
        self.report.detail.clear();
        self.driver.start(now);
        self.collect(now);
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

    fn close(&mut self, now: Stamp) {
        self.driver.stop(now);
        self.collect(now);
    }

    fn broken(&mut self, why: String) {
        self.wants.clear();
        self.wants.extend(self.report.broken(why).map(Want::Report));
    }

    fn next_want(&mut self) -> Option<Want> {
        self.wants.pop_front()
    }
}

/// What the lidar's own warning means.
#[must_use]
pub fn warning(code: u16) -> String {
    format!("the lidar warns ({code:#06x}): it may soon stop; check its supply")
}

/// The name of a model: the high digit is the series, the low one the model within it (maker's driver).
pub(crate) fn model_name(model: u8) -> String {
    let (major, minor) = (model >> 4, model & 0xF);
    match major {
        1 => format!("RPLIDAR A1M{minor}"),
        2 => format!("RPLIDAR A2M{minor}"),
        3 => format!("RPLIDAR A3M{minor}"),
        _ => format!("RPLIDAR, model {model:#04x}"),
    }
}
