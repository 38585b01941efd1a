//! A robot at a serial port of the program that drives it: rules, device and driver in one, in
//! simulated time, against a robot that speaks the protocol. What the bridge promises also holds
//! here.
#![cfg(not(target_family = "wasm"))] // the device at the other end is native
#![allow(missing_docs)] // a test binary has no public interface
#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not count as tests

use std::time::Duration;

use slamlab_core::device::{LocalBridge, Rp6, Want};
use slamlab_core::live::{Live, LiveConfig};
use slamlab_core::sim::worlds;
use slamlab_core::slam::Method;
use slamlab_tests::devices::{self, Device as _};

const STEP: f64 = 0.01;

/// Everything between the person and the motors.
struct Cable {
    live: Live,
    bridge: LocalBridge,
    robot: devices::Rp6,
    seconds: f64,
    /// The driver's messages are no longer read.
    is_driver_gone: bool,
    is_cut: bool,
}

impl Cable {
    fn new() -> Self {
        let mut robot = devices::Rp6::new(worlds::builtin("arena").unwrap()).unwrap();
        robot.power_on();
        let config = LiveConfig {
            name: "page".to_owned(),
            token: None,
            method: Method::LineEkf,
            prior_map: None,
            cycle: false,
            settings: vec![],
            seed: 1,
        };
        let mut cable = Self {
            live: Live::new(config).unwrap(),
            bridge: LocalBridge::new(vec![Box::new(Rp6::new("rp6:cable"))]),
            robot,
            seconds: 1.0,
            is_driver_gone: false,
            is_cut: false,
        };
        assert_eq!(cable.bridge.baud_rate(0), Some(cable.robot.baud_rate()));
        cable.bridge.begin(cable.now());
        cable.bridge.opened(cable.now(), 0);
        cable
    }

    fn now(&self) -> Duration {
        Duration::from_secs_f64(self.seconds)
    }

    fn micros(&self) -> u64 {
        self.now().as_micros() as u64
    }

    fn run(&mut self, seconds: f64) {
        for _ in 0..(seconds / STEP).round() as u32 {
            self.step();
        }
    }

    fn step(&mut self) {
        self.seconds += STEP;
        let said = self.robot.advance(STEP);
        if !self.is_cut {
            self.bridge.received(self.now(), self.now(), 0, &said);
        }
        self.bridge.tick(self.now());
        if !self.is_driver_gone {
            self.live.tick(self.micros()).unwrap();
            for message in self.live.take_outgoing() {
                self.bridge.message(self.now(), &message).unwrap();
            }
        }
        while let Some(want) = self.bridge.next_want(0) {
            if let Want::Write(bytes) = want
                && !self.is_cut
            {
                self.robot.receive(&bytes);
            }
        }
        for message in self.bridge.take_outgoing() {
            self.live.receive(self.micros(), &message).unwrap();
        }
    }

    /// A robot that has been driving ahead for a while.
    fn driving() -> Self {
        let mut cable = Self::new();
        cable.run(2.0);
        assert!(cable.live.client().is_in(), "the page is let in");
        cable.live.take_lease(cable.micros(), false);
        cable.run(0.2);
        assert!(cable.live.client().is_armed());
        cable.live.drive(0.5, 0.0);
        cable.run(1.0);
        assert!(cable.robot.is_moving(), "it drives");
        cable
    }

    /// Whether the robot's last command is to move.
    fn is_told_to_move(&self) -> bool {
        let last = self.robot.done.last();
        last.is_some_and(|(_, command)| command.moves())
    }

    /// Time until it is commanded to stand, s; at most `longest`.
    fn until_it_stands(&mut self, longest: f64) -> f64 {
        let begin = self.seconds;
        while self.is_told_to_move() && self.seconds - begin < longest {
            self.step();
        }
        self.seconds - begin
    }
}

#[test]
fn nothing_moves_before_the_wheel_is_taken() {
    let mut cable = Cable::new();
    cable.run(2.0);
    cable.live.drive(1.0, 0.0);
    cable.run(1.0);
    assert!(!cable.robot.was_told_to_move());
}

/// The lease is granted after Stop was pressed: it must not arm any more.
#[test]
fn a_stop_overtakes_the_arming_that_waits_for_its_lease() {
    let stops: [fn(&mut Live, u64); 3] = [Live::stop, Live::emergency_stop, Live::release_lease];
    for stop in stops {
        let mut cable = Cable::new();
        cable.run(2.0);
        cable.live.take_lease(cable.micros(), false);
        let now = cable.micros();
        stop(&mut cable.live, now);
        for _ in 0..200 {
            cable.live.drive(1.0, 0.0);
            cable.step();
            assert!(!cable.live.client().is_armed());
        }
        assert!(!cable.robot.was_told_to_move());
    }
}

#[test]
fn a_driven_robot_tells_where_it_is() {
    let cable = Cable::driving();
    let start = cable.robot.simulation().world().start;
    let truth = start.inverse() * cable.robot.simulation().truth();
    let odometry = cable.live.session().dead_reckoning();
    assert!(truth.x() > 0.05, "it went {} m", truth.x());
    assert!((odometry.position() - truth.position()).norm() < 0.02);
}

#[test]
fn a_driver_who_falls_silent_stops_the_robot_within_a_quarter_of_a_second() {
    let mut cable = Cable::driving();
    cable.is_driver_gone = true;
    let after = cable.until_it_stands(2.0);
    assert!(after <= 0.25, "{after} s");
    // The lease has expired meanwhile: a driver who comes back has to take it again.
    cable.run(2.5);
    cable.is_driver_gone = false;
    cable.run(3.0);
    assert!(!cable.robot.is_moving() && !cable.live.client().is_armed());
}

#[test]
fn stop_and_emergency_stop_reach_the_robot_at_once() {
    for is_emergency in [false, true] {
        let mut cable = Cable::driving();
        let now = cable.micros();
        match is_emergency {
            true => cable.live.emergency_stop(now),
            false => cable.live.stop(now),
        }
        let after = cable.until_it_stands(2.0);
        assert!(after <= 0.1, "{after} s");
        cable.run(0.5);
        assert!(!cable.live.client().is_armed());
    }
}

/// The mapping program plans or fits for a while: the person's commands do not wait for it.
#[test]
fn stop_does_not_wait_for_who_maps() {
    for cut_off in [false, true] {
        let mut cable = Cable::driving();
        cable.is_driver_gone = true;
        let now = cable.now();
        cable.bridge.stop(now, cut_off);
        let after = cable.until_it_stands(0.2);
        assert!(after <= 0.02, "{after} s");
        cable.is_driver_gone = false;
        cable.run(0.5);
        assert!(!cable.live.client().is_armed());
        let safety = cable.live.client().safety().unwrap();
        assert_eq!(safety.emergency, cut_off);
    }
}

/// A client that connects while the motors are cut off has no right to drive yet, and needs it to
/// undo that.
#[test]
fn an_emergency_stop_is_undone_by_who_comes_later_and_nothing_moves_by_that() {
    let mut cable = Cable::driving();
    cable.bridge.stop(cable.now(), true);
    cable.run(0.1);
    cable.live.reconnect();
    cable.bridge.begin(cable.now());
    cable.run(3.0);
    assert!(!cable.live.client().has_lease());
    let is_cut_off = |cable: &Cable| cable.live.client().safety().unwrap().emergency;
    assert!(is_cut_off(&cable));
    cable.live.take_lease(cable.micros(), false);
    cable.run(0.5);
    assert!(cable.live.client().has_lease() && !cable.live.client().is_armed());
    cable.live.reset_emergency_stop(cable.micros());
    cable.run(0.5);
    assert!(!is_cut_off(&cable) && !cable.live.client().is_armed());
    cable.live.take_lease(cable.micros(), false);
    cable.run(0.5);
    assert!(cable.live.client().is_armed() && !cable.robot.is_moving());
}

#[test]
fn a_cable_that_is_pulled_disarms_and_one_put_back_moves_nothing() {
    let mut cable = Cable::driving();
    cable.is_cut = true;
    cable.bridge.broken(cable.now(), 0, "the cable was pulled");
    cable.run(0.2);
    assert!(!cable.live.client().is_armed());
    // Nobody is there to be armed, whatever the device behind the cable makes of the silence.
    cable.live.take_lease(cable.micros(), false);
    cable.run(0.8);
    assert!(!cable.live.client().is_armed());
    cable.is_cut = false;
    cable.bridge.opened(cable.now(), 0);
    cable.run(3.0);
    assert!(!cable.robot.is_moving());
    cable.live.take_lease(cable.micros(), false);
    cable.run(0.5);
    cable.live.drive(0.5, 0.0);
    cable.run(1.0);
    assert!(cable.robot.is_moving(), "it can be driven again");
}

#[test]
fn what_is_closed_is_stopped_first() {
    let mut cable = Cable::driving();
    let now = cable.now();
    cable.bridge.close(now);
    while let Some(want) = cable.bridge.next_want(0) {
        if let Want::Write(bytes) = want {
            cable.robot.receive(&bytes);
        }
    }
    cable.robot.advance(STEP);
    assert!(!cable.is_told_to_move());
}
