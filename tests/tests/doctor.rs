//! `doctor` names each device and each fault that can be simulated, with its cure.
#![cfg(unix)]
#![allow(missing_docs)] // a test binary has no public interface
#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not count as tests

use slamlab_bridge::doctor::{Finding, examine};
use slamlab_bridge::serial::{Line, PortSettings};
use slamlab_core::sim::worlds;
use slamlab_core::wire::rp6::Fault;
use slamlab_core::wire::rplidar::answer::Status;
use slamlab_tests::calm::on_a_calm_machine;
use slamlab_tests::devices::{Device, Faults, Ld06, Rp6, Rplidar, Socket, View};

fn view() -> View {
    View::from_start(&worlds::builtin("arena").unwrap())
}

fn robot() -> Rp6 {
    Rp6::new(worlds::builtin("arena").unwrap()).unwrap()
}

fn examine_plugged<D: Device>(device: D, faults: Faults) -> Finding {
    examine(&Socket::plugged_with(device, faults).unwrap().path())
}

/// Exactly one problem, whose text contains all of this.
fn assert_names(finding: &Finding, kind: Option<&str>, words: &[&str]) {
    assert_eq!(finding.kind.map(|kind| kind.name), kind, "{finding}");
    assert_eq!(finding.problems.len(), 1, "{finding}");
    for word in words {
        assert!(
            finding.problems[0].contains(word),
            "no {word:?} in: {finding}"
        );
    }
}

#[test]
fn a_healthy_rplidar_is_known_and_measured() {
    on_a_calm_machine(|| {
        let finding = examine_plugged(Rplidar::new(view()), Faults::default());
        assert!(finding.is_well(), "{finding}");
        assert_eq!(finding.kind.map(|kind| kind.name), Some("rplidar"));
        assert!(finding.model.starts_with("RPLIDAR A1M8"));
        assert_eq!(finding.measured.beams, 360);
        // Timed by the clock of this machine, which others load.
        let rate = finding.measured.scans_per_second;
        assert!((3.0..7.0).contains(&rate), "{rate} scans/s");
        assert!(finding.to_string().contains("--source rplidar:"));
    });
}

#[test]
fn a_healthy_ld06_is_known_and_measured() {
    on_a_calm_machine(|| {
        let finding = examine_plugged(Ld06::new(view()), Faults::default());
        assert!(finding.is_well(), "{finding}");
        assert_eq!(
            (finding.kind.map(|kind| kind.name), finding.measured.beams),
            (Some("ld06"), 450)
        );
        assert!(
            (5.0..12.0).contains(&finding.measured.scans_per_second),
            "{finding}"
        );
    });
}

#[test]
fn a_healthy_rp6_is_known_with_and_without_its_boot_loader() {
    on_a_calm_machine(|| {
        for has_boot_loader in [false, true] {
            let mut robot = robot();
            robot.has_boot_loader = has_boot_loader;
            let finding = examine_plugged(robot, Faults::default());
            assert!(finding.is_well(), "{finding}");
            assert_eq!(
                (finding.kind.map(|kind| kind.name), finding.model.as_str()),
                (Some("rp6"), "RP6, firmware 1.0")
            );
            assert!(finding.measured.odometries > 50, "{finding}");
        }
    });
}

#[test]
fn health_2_is_named() {
    on_a_calm_machine(|| {
        let mut lidar = Rplidar::new(view());
        lidar.status = Status::Error;
        let finding = examine_plugged(lidar, Faults::default());
        assert_names(
            &finding,
            Some("rplidar"),
            &["health 2", "weak power", "5 V"],
        );
    });
}

#[test]
fn a_blocked_head_is_named() {
    on_a_calm_machine(|| {
        let mut lidar = Ld06::new(view());
        lidar.is_blocked = true;
        let finding = examine_plugged(lidar, Faults::default());
        assert_names(&finding, Some("ld06"), &["no whole turn", "motor"]);
        let mut lidar = Rplidar::new(view());
        lidar.is_blocked = true;
        let finding = examine_plugged(lidar, Faults::default());
        assert_names(&finding, Some("rplidar"), &["no whole turn", "blocked"]);
    });
}

#[test]
fn silence_is_named() {
    on_a_calm_machine(|| {
        let mute = Faults {
            is_mute: true,
            ..Faults::default()
        };
        let finding = examine_plugged(Rplidar::new(view()), mute);
        assert_names(&finding, None, &["nothing answers", "power", "TX and RX"]);
    });
}

/// A device with a baud rate that none of ours has.
struct Foreign;

impl Device for Foreign {
    fn baud_rate(&self) -> u32 {
        9600
    }

    fn power_on(&mut self) {}

    fn receive(&mut self, _: &[u8]) {}

    fn advance(&mut self, seconds: f64) -> Vec<u8> {
        vec![b'x'; (seconds * 960.0) as usize + 1]
    }
}

#[test]
fn a_wrong_rate_is_named() {
    on_a_calm_machine(|| {
        let finding = examine_plugged(Foreign, Faults::default());
        assert_names(&finding, None, &["bytes came", "another baud rate"]);
    });
}

#[test]
fn a_port_that_is_not_there_is_named() {
    on_a_calm_machine(|| {
        let finding = examine("/dev/ttyUSB77");
        assert_names(&finding, None, &["is not there", "plug the device in"]);
    });
}

#[test]
fn a_busy_port_is_named() {
    on_a_calm_machine(|| {
        let socket = Socket::plugged(Ld06::new(view())).unwrap();
        let path = socket.path();
        let _held = Line::open(&PortSettings {
            path: path.clone(),
            baud_rate: 230_400,
        })
        .unwrap();
        assert_names(&examine(&path), None, &["is busy", "fuser"]);
    });
}

#[test]
fn a_boot_loader_that_starts_nothing_is_named() {
    on_a_calm_machine(|| {
        let mut robot = robot();
        (robot.has_boot_loader, robot.has_program) = (true, false);
        let finding = examine_plugged(robot, Faults::default());
        assert_names(&finding, Some("rp6"), &["boot loader", "flash"]);
    });
}

#[test]
fn a_robot_with_an_empty_battery_is_named() {
    on_a_calm_machine(|| {
        let mut robot = robot();
        robot.fault = Fault::BatteryLow;
        let finding = examine_plugged(robot, Faults::default());
        assert_names(&finding, Some("rp6"), &["battery", "charge"]);
    });
}

#[test]
fn a_noisy_line_is_named() {
    on_a_calm_machine(|| {
        let noise = Faults {
            flipped_bits: 1e-3,
            ..Faults::default()
        };
        let finding = examine_plugged(Ld06::new(view()), noise);
        assert_names(&finding, Some("ld06"), &["noisy", "shorter cable"]);
    });
}
