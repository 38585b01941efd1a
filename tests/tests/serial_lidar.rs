//! Lidars on pseudo-terminals, through the bridge's own threads: scans equal to what the world
//! gives, and every way in which a line can fail.
#![cfg(unix)]
#![allow(missing_docs)] // a test binary has no public interface
#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not count as tests

use std::f64::consts::FRAC_PI_2;
use std::time::{Duration, Instant};

use nalgebra::Point2;
use slamlab_bridge::serial::DeviceSource;
use slamlab_bridge::settings::SourceSettings;
use slamlab_bridge::source::{self, Running, Source, SourceEvent};
use slamlab_core::device::Kind;
use slamlab_core::geom::Pose2;
use slamlab_core::robot::Scan;
use slamlab_core::sim::worlds;
use slamlab_core::wire::message::{DeviceState, LinkState};
use slamlab_core::wire::rplidar::answer::Status;
use slamlab_core::wire::rplidar::request::Request;
use slamlab_tests::calm::on_a_calm_machine;
use slamlab_tests::devices::{self, Faults, Socket, View};
use tokio::sync::mpsc;

fn view() -> View {
    View::from_start(&worlds::builtin("arena").unwrap())
}

/// Timeout for anything, s, because the machine may be loaded. How long it really takes is measured
/// by the reports.
const PATIENCE: u64 = 60;

/// A source at work, and what it reported.
struct Ear {
    running: Option<Running>,
    events: mpsc::Receiver<(u8, SourceEvent)>,
}

impl Ear {
    fn new(source: impl Source) -> Self {
        Self::boxed(Box::new(source))
    }

    fn boxed(source: Box<dyn Source>) -> Self {
        let (sender, events) = mpsc::channel(source::MOST_WAITING);
        let running = source::start(3, source, sender).unwrap();
        Self {
            running: Some(running),
            events,
        }
    }

    fn of_kind(kind: &str, path: String) -> Self {
        let kind = Kind::named(kind).unwrap();
        let device = (kind.open)("lidar:test".into(), Pose2::identity());
        Self::new(DeviceSource::at_port(device, path))
    }

    fn rplidar(path: String) -> Self {
        Self::of_kind("rplidar", path)
    }

    fn ld06(path: String) -> Self {
        Self::of_kind("ld06", path)
    }

    /// The first event that is wanted, within `seconds`.
    fn wait<T>(&mut self, seconds: u64, mut wanted: impl FnMut(&SourceEvent) -> Option<T>) -> T {
        let until = Instant::now() + Duration::from_secs(seconds);
        let mut others = vec![];
        while Instant::now() < until {
            match self.events.try_recv() {
                Ok((3, event)) => match wanted(&event) {
                    Some(found) => return found,
                    None => others.push(brief(&event)),
                },
                Ok((number, event)) => panic!("source {number}: {event:?}"),
                Err(_) => std::thread::sleep(Duration::from_millis(2)),
            }
        }
        panic!("not within {seconds} s; only: {others:#?}")
    }

    fn scan(&mut self) -> Scan {
        self.wait(PATIENCE, |event| match event {
            SourceEvent::Scan(scan) => Some(scan.clone()),
            _ => None,
        })
    }

    /// Waits for a state; returns the sentence that came with it.
    fn state(&mut self, wanted: DeviceState) -> String {
        self.wait(PATIENCE, |event| match event {
            SourceEvent::Device { state, detail, .. } if *state == wanted => Some(detail.clone()),
            _ => None,
        })
    }

    /// Waits for a report with this state and these words. On a loaded machine a device may stutter
    /// before.
    fn expect(&mut self, wanted: DeviceState, words: &[&str]) {
        self.wait(PATIENCE, |event| match event {
            SourceEvent::Device { state, detail, .. } if *state == wanted => words
                .iter()
                .all(|words| detail.contains(words))
                .then_some(()),
            _ => None,
        });
    }

    fn link(&mut self, wanted: LinkState) {
        self.wait(PATIENCE, |event| match event {
            SourceEvent::Link(link) if link.state == wanted => Some(()),
            _ => None,
        });
    }
}

fn brief(event: &SourceEvent) -> String {
    match event {
        SourceEvent::Scan(scan) => {
            format!("scan of {} at {:.3} s", scan.len(), scan.stamp.seconds())
        }
        other => format!("{other:?}"),
    }
}

/// Every beam that hit something equals what the world gives in its direction, to the resolution of
/// the wire protocol.
fn assert_equals_world(scan: &Scan, view: &View, resolution: f64) {
    scan.validate().unwrap();
    let mut hits = 0;
    for (beam, (&bearing, &range)) in scan.bearings.iter().zip(&scan.ranges).enumerate() {
        let truth = view.range(bearing).unwrap();
        if range.is_finite() {
            hits += 1;
            let error = (f64::from(range) - truth).abs();
            assert!(
                error < 0.5 * resolution + 1e-6,
                "beam {beam}: {range}, the world gives {truth}"
            );
        }
    }
    assert!(hits * 10 >= scan.len() * 9, "{hits} hits of {}", scan.len());
}

#[test]
fn an_rplidar_gives_what_the_world_gives() {
    on_a_calm_machine(|| {
        for (kind, beams, resolution) in [("rplidar", 360, 0.25e-3), ("rplidar-express", 720, 1e-3)]
        {
            let socket = Socket::plugged(devices::Rplidar::new(view())).unwrap();
            let mut ear = Ear::of_kind(kind, socket.path());
            let mut last = None;
            for _ in 0..3 {
                let scan = ear.scan();
                assert_eq!(scan.len(), beams, "{kind}");
                assert_equals_world(&scan, &view(), resolution);
                // 180 ms per revolution, by the readings' own figures.
                assert!((scan.sweep - 0.18 * (beams - 1) as f64 / beams as f64).abs() < 1e-6);
                if let Some(last) = last {
                    let apart: f64 = scan.stamp.since(last);
                    assert!(apart > 0.0, "{apart} s apart");
                }
                last = Some(scan.stamp);
            }
            // When the bridge ends, it stops the lidar.
            ear.running = None;
            assert_eq!(
                socket.with(|lidar| lidar.asked.last().copied()),
                Some(Request::Stop)
            );
        }
    });
}

#[test]
fn a_lidar_sits_where_the_settings_say() {
    on_a_calm_machine(|| {
        let check = |name: String| {
            let text =
                format!("name = \"{name}\"\nmount = {{ x = 0.04, y = -0.01, yaw-degrees = 90 }}");
            let settings: SourceSettings = toml::from_str(&text).unwrap();
            let mount = Ear::boxed(settings.open().unwrap())
                .scan()
                .robot_from_sensor;
            let off = mount.position() - Point2::new(0.04, -0.01);
            assert!(
                off.norm() < 1e-12 && (mount.heading() - FRAC_PI_2).abs() < 1e-12,
                "{mount:?}"
            );
        };
        let socket = Socket::plugged(devices::Ld06::new(view())).unwrap();
        check(format!("ld06:{}", socket.path()));
        let socket = Socket::plugged(devices::Rplidar::new(view())).unwrap();
        check(format!("rplidar:{}", socket.path()));
    });
}

#[test]
fn an_rplidar_says_what_it_is() {
    on_a_calm_machine(|| {
        let socket = Socket::plugged(devices::Rplidar::new(view())).unwrap();
        let mut ear = Ear::rplidar(socket.path());
        ear.link(LinkState::Up);
        let model = ear.wait(PATIENCE, |event| match event {
            SourceEvent::Device { model, .. } if !model.is_empty() => Some(model.clone()),
            _ => None,
        });
        assert_eq!(model, "RPLIDAR A1M8, firmware 1.29, hardware 7");
        assert_eq!(ear.state(DeviceState::Sending), "");
    });
}

#[test]
fn an_ld06_gives_what_the_world_gives() {
    on_a_calm_machine(|| {
        let socket = Socket::plugged(devices::Ld06::new(view())).unwrap();
        let mut ear = Ear::ld06(socket.path());
        for _ in 0..5 {
            let scan = ear.scan();
            assert_eq!(scan.len(), 450);
            assert_equals_world(&scan, &view(), 1e-3);
            assert!((scan.sweep - 0.1 * 449.0 / 450.0).abs() < 1e-6);
        }
    });
}

#[test]
fn a_pulled_cable_is_noticed_and_a_new_one_found() {
    on_a_calm_machine(|| {
        let socket = Socket::plugged(devices::Rplidar::new(view())).unwrap();
        let mut ear = Ear::rplidar(socket.path());
        for pull in [Socket::pull, Socket::pull_in_the_middle] {
            ear.scan();
            pull(&socket);
            // This disarms the driver; `cargo xtask report faults` measures how soon.
            ear.link(LinkState::Down);
            let why = ear.state(DeviceState::Waiting);
            assert!(
                why.contains("cable was pulled")
                    || why.contains("does not work")
                    || why.contains("is not there"),
                "{why}"
            );
            socket.plug();
            ear.link(LinkState::Up);
            assert_equals_world(&ear.scan(), &view(), 0.25e-3);
        }
    });
}

#[test]
fn a_lidar_plugged_in_later_is_found() {
    on_a_calm_machine(|| {
        let socket = Socket::unplugged(devices::Ld06::new(view())).unwrap();
        let mut ear = Ear::ld06(socket.path());
        ear.expect(DeviceState::Waiting, &["is not there: plug the device in"]);
        socket.plug();
        ear.scan();
    });
}

#[test]
fn a_line_that_flips_one_bit_of_a_thousand_still_gives_scans() {
    on_a_calm_machine(|| {
        let faults = Faults {
            flipped_bits: 1e-3,
            ..Faults::default()
        };
        let socket = Socket::plugged(devices::Ld06::new(view())).unwrap();
        socket.set_faults(faults);
        let mut ear = Ear::ld06(socket.path());
        for _ in 0..10 {
            // CRC-8 lets one in 256 damaged packets through: all but a few beams must be right.
            assert_mostly_right(&ear.scan(), 1e-3, 0.02);
        }
        let socket = Socket::plugged(devices::Rplidar::new(view())).unwrap();
        let mut ear = Ear::rplidar(socket.path());
        ear.scan();
        socket.set_faults(faults);
        for _ in 0..10 {
            // A node has three check bits; of every 100 nodes, 3.6 have one of the other 37 bits
            // wrong.
            assert_mostly_right(&ear.scan(), 0.25e-3, 0.08);
        }
    });
}

fn assert_mostly_right(scan: &Scan, resolution: f64, most_wrong: f64) {
    scan.validate().unwrap();
    let is_wrong = |&(&bearing, &range): &(&f64, &f32)| {
        let truth = view().range(bearing).unwrap();
        range.is_finite() && (f64::from(range) - truth).abs() > resolution
    };
    let wrong = scan
        .bearings
        .iter()
        .zip(&scan.ranges)
        .filter(is_wrong)
        .count();
    assert!(
        wrong as f64 <= most_wrong * scan.len() as f64,
        "{wrong} of {} wrong",
        scan.len()
    );
    let hits = scan.ranges.iter().filter(|range| range.is_finite()).count();
    assert!(hits * 2 > scan.len(), "{hits} hits of {}", scan.len());
}

#[test]
fn each_fault_of_an_rplidar_is_named_with_its_cure() {
    on_a_calm_machine(|| {
        let mut protected = devices::Rplidar::new(view());
        protected.status = Status::Error;
        let socket = Socket::plugged(protected).unwrap();
        Ear::rplidar(socket.path()).expect(DeviceState::Fault, &["health 2", "weak power"]);

        let socket = Socket::plugged(devices::Rplidar::new(view())).unwrap();
        socket.set_faults(Faults {
            is_mute: true,
            ..Faults::default()
        });
        let mut ear = Ear::rplidar(socket.path());
        ear.expect(DeviceState::Fault, &["does not answer", "TX and RX"]);
        // And the fault ends by itself.
        socket.set_faults(Faults::default());
        ear.scan();

        // An LD06 instead of an RPLIDAR: bytes, but at another rate.
        let socket = Socket::plugged(devices::Ld06::new(view())).unwrap();
        Ear::rplidar(socket.path())
            .expect(DeviceState::Fault, &["wrong baud rate or another device"]);
    });
}

#[test]
fn an_rplidar_that_a_reset_cures_measures() {
    on_a_calm_machine(|| {
        let mut lidar = devices::Rplidar::new(view());
        lidar.status = Status::Error;
        lidar.is_cured_by_reset = true;
        let socket = Socket::plugged(lidar).unwrap();
        Ear::rplidar(socket.path()).scan();
        assert!(socket.with(|lidar| lidar.asked.contains(&Request::Reset)));
    });
}

#[test]
fn silence_while_measuring_is_mended_when_it_ends() {
    on_a_calm_machine(|| {
        let socket = Socket::plugged(devices::Rplidar::new(view())).unwrap();
        let mut ear = Ear::rplidar(socket.path());
        ear.scan();
        socket.set_faults(Faults {
            is_mute: true,
            ..Faults::default()
        });
        ear.state(DeviceState::Waiting);
        socket.set_faults(Faults::default());
        ear.scan();
    });
}

#[test]
fn faults_of_an_ld06_are_named() {
    on_a_calm_machine(|| {
        let mut blocked = devices::Ld06::new(view());
        blocked.is_blocked = true;
        let socket = Socket::plugged(blocked).unwrap();
        let mut ear = Ear::ld06(socket.path());
        ear.expect(DeviceState::Fault, &["no whole turn"]);
        socket.with(|lidar| lidar.is_blocked = false);
        ear.scan();
        socket.set_faults(Faults {
            is_mute: true,
            ..Faults::default()
        });
        ear.expect(DeviceState::Fault, &["silent"]);
    });
}

#[test]
fn a_port_has_one_user() {
    on_a_calm_machine(|| {
        let socket = Socket::plugged(devices::Ld06::new(view())).unwrap();
        let mut first = Ear::ld06(socket.path());
        first.scan();
        let mut second = Ear::ld06(socket.path());
        second.expect(DeviceState::Waiting, &["is busy"]);
        first.scan();
    });
}
