//! The driver against a sensor that answers as told: every way to measuring, and every fault.

use super::super::answer::Descriptor;
use super::super::request::RequestDecoder;
use super::*;
use std::f64::consts::TAU;

/// A sensor that answers requests at once and, while it scans, sends nodes at 2 kHz and 5 turns a second.
struct Sensor {
    requests: RequestDecoder,
    is_mute: bool,
    is_babbling: bool,
    is_blocked: bool,
    knows_rate: bool,
    /// Status of each health answer to come; good when none is left.
    health: Vec<Status>,
    scans: bool,
    readings: u64,
    log: Vec<Request>,
}

impl Sensor {
    fn new() -> Self {
        Self {
            requests: RequestDecoder::new(),
            is_mute: false,
            is_babbling: false,
            is_blocked: false,
            knows_rate: true,
            health: vec![],
            scans: false,
            readings: 0,
            log: vec![],
        }
    }

    fn answer(&mut self, bytes: &[u8]) -> Vec<u8> {
        self.requests.extend(bytes);
        let mut out = vec![];
        while let Some(request) = self.requests.next() {
            self.log.push(request);
            out.extend(self.answer_to(request));
        }
        if self.is_mute { vec![] } else { out }
    }

    fn answer_to(&mut self, request: Request) -> Vec<u8> {
        if self.is_babbling {
            return b"login: ".to_vec();
        }
        let with =
            |descriptor: Descriptor, bytes: &[u8]| [&descriptor.encode()[..], bytes].concat();
        match request {
            Request::Info => {
                let info = Info {
                    model: 0x18,
                    firmware: [1, 29],
                    hardware: 7,
                    serial: [3; 16],
                };
                with(Descriptor::Info, &info.encode())
            }
            Request::Health => {
                let status = if self.health.is_empty() {
                    Status::Good
                } else {
                    self.health.remove(0)
                };
                with(
                    Descriptor::Health,
                    &Health {
                        status,
                        error: 0x21,
                    }
                    .encode(),
                )
            }
            Request::Rate if self.knows_rate => {
                with(Descriptor::Rate, &config::RATE_OF_A1.encode())
            }
            Request::Scan => {
                self.scans = true;
                Descriptor::Scan.encode().to_vec()
            }
            Request::Stop => {
                self.scans = false;
                vec![]
            }
            Request::Reset => {
                self.scans = false;
                b"RP LIDAR System.\r\nFirmware Ver 1.29, HW Ver 7\r\n".to_vec()
            }
            _ => vec![],
        }
    }

    /// Nodes of 10 ms.
    fn readings(&mut self) -> Vec<u8> {
        if !self.scans || self.is_mute {
            return vec![];
        }
        let mut out = vec![];
        for _ in 0..20 {
            let part = if self.is_blocked {
                0.2
            } else {
                self.readings as f64 / 400.0
            };
            out.extend(Node::new(TAU * part, 2.0, 15).encode());
            self.readings += 1;
        }
        out
    }
}

/// Lets driver and sensor talk; gives what the driver said, sends aside.
fn talk(driver: &mut Driver, sensor: &mut Sensor, from: f64, to: f64) -> Vec<Event> {
    let mut said = vec![];
    for step in 1..=((to - from) * 100.0).round() as u64 {
        let now = Stamp::from_seconds(from + step as f64 * 0.01);
        driver.tick(now);
        let mut heard = vec![];
        while let Some(event) = driver.next_event() {
            match event {
                Event::Send(bytes) => heard.extend(sensor.answer(&bytes)),
                other => said.push(other),
            }
        }
        heard.extend(sensor.readings());
        driver.receive(&heard, now);
        while let Some(event) = driver.next_event() {
            match event {
                Event::Send(bytes) => {
                    let answer = sensor.answer(&bytes);
                    driver.receive(&answer, now);
                }
                other => said.push(other),
            }
        }
    }
    said
}

fn run(sensor: &mut Sensor, seconds: f64) -> (Driver, Vec<Event>) {
    let mut driver = Driver::new(DriverConfig::default());
    driver.start(Stamp(0));
    let said = talk(&mut driver, sensor, 0.0, seconds);
    (driver, said)
}

fn fault(said: &[Event]) -> Option<&Fault> {
    said.iter().find_map(|event| match event {
        Event::Fault(fault) => Some(fault),
        _ => None,
    })
}

fn scans(said: &[Event]) -> impl Iterator<Item = &Scan> {
    said.iter().filter_map(|event| match event {
        Event::Scan(scan) => Some(scan),
        _ => None,
    })
}

#[test]
fn a_healthy_sensor_is_asked_in_order_and_measures() {
    let mut sensor = Sensor::new();
    let (driver, said) = run(&mut sensor, 2.0);
    use Request::{Health, Info, Rate, Scan, Stop};
    assert_eq!(sensor.log, [Stop, Info, Health, Rate, Scan]);
    assert_eq!(driver.state(), DeviceState::Measuring);
    assert!(said.contains(&Event::Motor(true)));
    let scans: Vec<_> = scans(&said).collect();
    // 5 turns a second from about 0.15 s on; the first begins at a seam.
    assert!((8..=9).contains(&scans.len()), "{}", scans.len());
    for scan in &scans {
        scan.validate().unwrap();
        assert_eq!(scan.len(), 400);
        assert!((scan.sweep - 0.1995).abs() < 1e-9, "{}", scan.sweep);
    }
    for pair in scans.windows(2) {
        assert!((pair[1].stamp.since(pair[0].stamp) - 0.2).abs() < 1e-6);
    }
}

#[test]
fn a_sensor_that_still_scans_is_stopped_first() {
    let mut sensor = Sensor::new();
    sensor.scans = true;
    let (driver, said) = run(&mut sensor, 2.0);
    assert_eq!(sensor.log.first(), Some(&Request::Stop));
    assert_eq!(
        (driver.state(), fault(&said)),
        (DeviceState::Measuring, None)
    );
}

#[test]
fn protection_is_reset_once_and_then_a_fault() {
    let mut sensor = Sensor::new();
    sensor.health = vec![Status::Error];
    let (driver, said) = run(&mut sensor, 3.0);
    assert!(sensor.log.contains(&Request::Reset));
    assert_eq!(
        (driver.state(), fault(&said)),
        (DeviceState::Measuring, None)
    );

    let mut sensor = Sensor::new();
    sensor.health = vec![Status::Error; 9];
    let (driver, said) = run(&mut sensor, 3.0);
    assert_eq!(driver.state(), DeviceState::Fault);
    assert_eq!(fault(&said), Some(&Fault::Protection { error: 0x21 }));
    assert_eq!(
        sensor.log.iter().filter(|&&r| r == Request::Reset).count(),
        1
    );
    assert!(fault(&said).unwrap().to_string().contains("weak power"));
}

#[test]
fn a_warning_is_told_and_does_not_stop_it() {
    let mut sensor = Sensor::new();
    sensor.health = vec![Status::Warning];
    let (driver, said) = run(&mut sensor, 2.0);
    assert!(said.contains(&Event::Warning(0x21)));
    assert_eq!(driver.state(), DeviceState::Measuring);
}

#[test]
fn silence_and_noise_are_different_faults() {
    let mut mute = Sensor::new();
    mute.is_mute = true;
    let (_, said) = run(&mut mute, 3.0);
    assert_eq!(
        fault(&said),
        Some(&Fault::NoAnswer {
            request: Request::Info
        })
    );

    let mut babbling = Sensor::new();
    babbling.is_babbling = true;
    let (_, said) = run(&mut babbling, 3.0);
    let expected = Fault::NotUnderstood {
        request: Request::Info,
        bytes: 21,
    };
    assert_eq!(fault(&said), Some(&expected));
}

#[test]
fn old_firmware_without_rate_still_measures() {
    let mut sensor = Sensor::new();
    sensor.knows_rate = false;
    let (driver, said) = run(&mut sensor, 4.0);
    assert!(said.contains(&Event::RateUnknown));
    assert_eq!(driver.state(), DeviceState::Measuring);
}

#[test]
fn silence_while_measuring_is_noticed_within_a_second_and_mended_when_it_ends() {
    let mut sensor = Sensor::new();
    let (mut driver, _) = run(&mut sensor, 2.0);
    sensor.is_mute = true;
    assert!(!talk(&mut driver, &mut sensor, 2.0, 2.9).contains(&Event::Restarting(Fault::Silent)));
    let said = talk(&mut driver, &mut sensor, 2.9, 3.1);
    assert!(said.contains(&Event::Restarting(Fault::Silent)));
    sensor.is_mute = false;
    let said = talk(&mut driver, &mut sensor, 3.1, 5.0);
    assert!(scans(&said).count() > 3);
}

#[test]
fn a_sensor_that_stays_silent_becomes_a_fault() {
    let mut sensor = Sensor::new();
    let (mut driver, _) = run(&mut sensor, 2.0);
    sensor.is_mute = true;
    let said = talk(&mut driver, &mut sensor, 2.0, 6.0);
    assert_eq!(
        fault(&said),
        Some(&Fault::NoAnswer {
            request: Request::Info
        })
    );
}

#[test]
fn a_blocked_head_is_named_in_the_end() {
    let mut sensor = Sensor::new();
    sensor.is_blocked = true;
    let (_, said) = run(&mut sensor, 20.0);
    assert_eq!(fault(&said), Some(&Fault::DoesNotTurn));
    let restarts = said
        .iter()
        .filter(|&e| *e == Event::Restarting(Fault::DoesNotTurn))
        .count();
    assert_eq!(restarts, MOST_RESTARTS as usize);
}

#[test]
fn a_sensor_that_lost_power_is_brought_up_anew() {
    let mut sensor = Sensor::new();
    let (mut driver, _) = run(&mut sensor, 2.0);
    sensor.scans = false;
    // A whole node, then the banner.
    driver.receive(b"RP LIDAR System.\r\n", Stamp::from_seconds(2.0));
    let said = talk(&mut driver, &mut sensor, 2.0, 4.0);
    assert!(
        said.contains(&Event::Restarting(Fault::LostPower)),
        "{said:?}"
    );
    assert!(scans(&said).count() > 3);
}

#[test]
fn stop_stops_sensor_and_motor() {
    let mut sensor = Sensor::new();
    let (mut driver, _) = run(&mut sensor, 2.0);
    driver.stop(Stamp::from_seconds(2.0));
    let said = talk(&mut driver, &mut sensor, 2.0, 5.0);
    assert!(said.contains(&Event::Motor(false)) && !sensor.scans);
    assert_eq!(scans(&said).count(), 0);
    assert_eq!(driver.state(), DeviceState::Waiting);
}
