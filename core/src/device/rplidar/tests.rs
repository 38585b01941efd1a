//! An RPLIDAR against a scripted sensor: every way to measuring, and every fault.

use std::f64::consts::TAU;

use super::*;
use crate::device::lidar::Lidar;
use crate::device::source::SourceEvent;
use crate::device::{Device, Want};
use crate::geom::Pose2;
use crate::robot::Scan;
use crate::wire::rplidar::answer::Descriptor;
use crate::wire::rplidar::request::RequestDecoder;

/// A sensor that answers requests at once and, while it scans, sends nodes at 2 kHz and 5 turns a
/// second.
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
            requests: RequestDecoder::default(),
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
            Request::Rate if self.knows_rate => with(Descriptor::Rate, &RATE_OF_A1.encode()),
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

fn opened() -> Lidar<Rplidar> {
    let protocol = Rplidar::new(ScanMode::Standard);
    let mut lidar = Lidar::new("rplidar:test", protocol, Pose2::identity());
    lidar.opened(Stamp(0));
    lidar
}

/// Lets lidar and sensor talk; returns the lidar's wants except writes.
fn talk(lidar: &mut Lidar<Rplidar>, sensor: &mut Sensor, from: f64, to: f64) -> Vec<Want> {
    let mut wants = vec![];
    for step in 1..=((to - from) * 100.0).round() as u64 {
        let now = Stamp::from_seconds(from + step as f64 * 0.01);
        lidar.tick(now);
        let mut heard = vec![];
        while let Some(want) = lidar.next_want() {
            match want {
                Want::Write(bytes) => heard.extend(sensor.answer(&bytes)),
                other => wants.push(other),
            }
        }
        heard.extend(sensor.readings());
        lidar.receive(&heard, now);
        while let Some(want) = lidar.next_want() {
            match want {
                Want::Write(bytes) => {
                    let answer = sensor.answer(&bytes);
                    lidar.receive(&answer, now);
                }
                other => wants.push(other),
            }
        }
    }
    wants
}

fn run(sensor: &mut Sensor, seconds: f64) -> (Lidar<Rplidar>, Vec<Want>) {
    let mut lidar = opened();
    let wants = talk(&mut lidar, sensor, 0.0, seconds);
    (lidar, wants)
}

/// The states that were reported, each with its sentence.
fn states(wants: &[Want]) -> Vec<(DeviceState, &str)> {
    let state = |want| match want {
        &Want::Report(SourceEvent::Device {
            state, ref detail, ..
        }) => Some((state, detail.as_str())),
        _ => None,
    };
    wants.iter().filter_map(state).collect()
}

fn last_state(wants: &[Want]) -> Option<(DeviceState, &str)> {
    states(wants).last().copied()
}

fn assert_fault(wants: &[Want], fault: &RplidarFault) {
    let expected = (DeviceState::Fault, &*fault.to_string());
    assert_eq!(last_state(wants), Some(expected));
    assert_eq!(wants.last(), Some(&Want::Reopen));
}

/// How often it was started up again for this reason.
fn restarts(wants: &[Want], fault: &RplidarFault) -> usize {
    let words = fault.to_string();
    let is_it = |want: &&Want| matches!(want, Want::Note(_, text) if text.starts_with(&words));
    wants.iter().filter(is_it).count()
}

fn scans(wants: &[Want]) -> impl Iterator<Item = &Scan> {
    wants.iter().filter_map(|want| match want {
        Want::Report(SourceEvent::Scan(scan)) => Some(scan),
        _ => None,
    })
}

const WELL: Option<(DeviceState, &str)> = Some((DeviceState::Sending, ""));

#[test]
fn a_healthy_sensor_is_asked_in_order_and_measures() {
    let mut sensor = Sensor::new();
    let (_, wants) = run(&mut sensor, 2.0);
    use Request::{Health, Info, Rate, Scan, Stop};
    assert_eq!(sensor.log, [Stop, Info, Health, Rate, Scan]);
    assert_eq!(
        states(&wants),
        [(DeviceState::Connected, ""), (DeviceState::Sending, "")]
    );
    assert!(wants.contains(&Want::Dtr(false)));
    let scans: Vec<_> = scans(&wants).collect();
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
    let (_, wants) = run(&mut sensor, 2.0);
    assert_eq!(sensor.log.first(), Some(&Request::Stop));
    assert_eq!(last_state(&wants), WELL);
}

#[test]
fn protection_is_reset_once_and_then_a_fault() {
    let mut sensor = Sensor::new();
    sensor.health = vec![Status::Error];
    let (_, wants) = run(&mut sensor, 3.0);
    assert!(sensor.log.contains(&Request::Reset));
    assert_eq!(last_state(&wants), WELL);

    let mut sensor = Sensor::new();
    sensor.health = vec![Status::Error; 9];
    let (_, wants) = run(&mut sensor, 1.9);
    assert_fault(&wants, &RplidarFault::Protection { error: 0x21 });
    assert_eq!(
        sensor.log.iter().filter(|&&r| r == Request::Reset).count(),
        1
    );
}

#[test]
fn a_warning_is_told_stays_and_does_not_stop_it() {
    let mut sensor = Sensor::new();
    sensor.health = vec![Status::Warning];
    let (_, wants) = run(&mut sensor, 2.0);
    let expected = (DeviceState::Sending, &*warning(0x21));
    assert_eq!(last_state(&wants), Some(expected));
}

#[test]
fn silence_and_noise_are_different_faults() {
    let request = Request::Info;
    let mut mute = Sensor::new();
    mute.is_mute = true;
    let (_, wants) = run(&mut mute, 1.61);
    assert_fault(&wants, &RplidarFault::NoAnswer { request });

    let mut babbling = Sensor::new();
    babbling.is_babbling = true;
    let (_, wants) = run(&mut babbling, 1.61);
    assert_fault(&wants, &RplidarFault::NotUnderstood { request, bytes: 21 });
}

#[test]
fn old_firmware_without_rate_still_measures() {
    let mut sensor = Sensor::new();
    sensor.knows_rate = false;
    let (_, wants) = run(&mut sensor, 4.0);
    let is_noted = |want: &Want| matches!(want, Want::Note(_, text) if text.contains("its rate"));
    assert!(wants.iter().any(is_noted));
    assert_eq!(last_state(&wants), WELL);
}

#[test]
fn silence_while_measuring_is_noticed_within_a_second_and_mended_when_it_ends() {
    let silent = &RplidarFault::Silent;
    let mut sensor = Sensor::new();
    let (mut lidar, _) = run(&mut sensor, 2.0);
    sensor.is_mute = true;
    let wants = talk(&mut lidar, &mut sensor, 2.0, 2.9);
    assert_eq!(restarts(&wants, silent), 0);
    let wants = talk(&mut lidar, &mut sensor, 2.9, 3.1);
    assert_eq!(restarts(&wants, silent), 1);
    let why = silent.to_string();
    assert_eq!(last_state(&wants), Some((DeviceState::Waiting, &*why)));
    sensor.is_mute = false;
    let wants = talk(&mut lidar, &mut sensor, 3.1, 5.0);
    assert!(scans(&wants).count() > 3);
    assert_eq!(last_state(&wants), WELL);
}

#[test]
fn a_sensor_that_stays_silent_becomes_a_fault() {
    let mut sensor = Sensor::new();
    let (mut lidar, _) = run(&mut sensor, 2.0);
    sensor.is_mute = true;
    let wants = talk(&mut lidar, &mut sensor, 2.0, 4.7);
    let request = Request::Info;
    let expected = RplidarFault::NoAnswer { request }.to_string();
    assert_eq!(last_state(&wants), Some((DeviceState::Fault, &*expected)));
}

#[test]
fn a_blocked_head_is_named_in_the_end() {
    let fault = &RplidarFault::DoesNotTurn;
    let mut sensor = Sensor::new();
    sensor.is_blocked = true;
    let (_, wants) = run(&mut sensor, 20.0);
    let expected = fault.to_string();
    assert_eq!(last_state(&wants), Some((DeviceState::Fault, &*expected)));
    assert_eq!(restarts(&wants, fault), MOST_RESTARTS as usize);
}

#[test]
fn a_sensor_that_lost_power_is_brought_up_anew() {
    let mut sensor = Sensor::new();
    let (mut lidar, _) = run(&mut sensor, 2.0);
    sensor.scans = false;
    // A whole node, then the banner.
    lidar.receive(b"RP LIDAR System.\r\n", Stamp::from_seconds(2.0));
    let wants = talk(&mut lidar, &mut sensor, 2.0, 4.0);
    assert_eq!(restarts(&wants, &RplidarFault::LostPower), 1);
    assert!(scans(&wants).count() > 3);
}

#[test]
fn closing_stops_sensor_and_motor() {
    let mut sensor = Sensor::new();
    let (mut lidar, _) = run(&mut sensor, 2.0);
    lidar.close(Stamp::from_seconds(2.0));
    let wants = talk(&mut lidar, &mut sensor, 2.0, 5.0);
    assert!(wants.contains(&Want::Dtr(true)) && !sensor.scans);
    assert_eq!(scans(&wants).count(), 0);
    assert_eq!(last_state(&wants), Some((DeviceState::Waiting, "")));
}
