//! A scripted device on a pseudo-terminal.
#![cfg(unix)]

use std::collections::VecDeque;
use std::io::Write;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

use serialport::{SerialPort, TTYPort};
use slamlab_core::robot::{Command, Stamp};

use super::DeviceSource;
use crate::serial::{Device, Want};
use crate::source::{self, Order, Profile, SourceEvent};

const NEVER: Duration = Duration::from_secs(60);

/// It reports at each byte that it is idle, and at each order that it is busy. At a byte it lets
/// the test act.
struct Scripted {
    heard: Sender<()>,
    go_on: Receiver<()>,
    wants: VecDeque<Want>,
}

impl Scripted {
    fn tell(&mut self, busy: bool) {
        let event = SourceEvent::Busy { busy, after: 0 };
        self.wants.push_back(Want::Report(event));
    }
}

impl Device for Scripted {
    fn profile(&self) -> Profile {
        Profile {
            name: "scripted".into(),
            robot: None,
            takes_orders: false,
            scans_on_command: false,
        }
    }

    fn baud_rate(&self) -> u32 {
        38_400
    }

    fn opened(&mut self, _: Stamp) {}

    fn receive(&mut self, _: &[u8], _: Stamp) {
        self.heard.send(()).unwrap();
        self.go_on.recv_timeout(NEVER).unwrap();
        self.tell(false);
    }

    fn order(&mut self, _: Order, _: Stamp) {
        self.tell(true);
    }

    fn tick(&mut self, _: Stamp) {}

    fn close(&mut self, _: Stamp) {}

    fn broken(&mut self, _: String) {}

    fn next_want(&mut self) -> Option<Want> {
        self.wants.pop_front()
    }
}

/// Regression: a task was reported as over at the moment when it was given, because an earlier
/// report got its number.
#[test]
fn what_was_said_before_an_order_does_not_count_after_it() {
    let (mut robot, port) = TTYPort::pair().unwrap();
    let path = port.name().unwrap();
    let (heard, hears) = channel();
    let (goes_on, go_on) = channel();
    let device = Scripted {
        heard,
        go_on,
        wants: VecDeque::new(),
    };
    let (sender, mut events) = tokio::sync::mpsc::channel(source::MOST_WAITING);
    let source = DeviceSource::at_port(Box::new(device), path);
    let running = source::start(0, Box::new(source), sender).unwrap();

    let until = std::time::Instant::now() + NEVER;
    while hears.try_recv().is_err() {
        assert!(std::time::Instant::now() < until, "the line is not open");
        robot.write_all(&[0]).unwrap();
        std::thread::sleep(Duration::from_millis(10));
    }
    // The order arrives in the same turn as the byte.
    let number = 1;
    running.order(number, Order::Command(Command::Scan));
    for _ in 0..1000 {
        // More bytes may have come meanwhile: let the device answer each without waiting.
        goes_on.send(()).unwrap();
    }
    let mut said = Vec::new();
    while !said.contains(&(true, number)) {
        match events.blocking_recv() {
            Some((_, SourceEvent::Busy { busy, after })) => said.push((busy, after)),
            Some(_) => (),
            None => panic!("it has ended: {said:?}"),
        }
    }
    assert_eq!(said.first(), Some(&(false, 0)), "{said:?}");
    drop(running);
}
