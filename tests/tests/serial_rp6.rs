//! An RP6 on a pseudo-terminal, through the bridge's own threads: odometry against truth, and above
//! all that it stops whenever something between the driver and the motors fails.
#![cfg(unix)]
#![allow(missing_docs)] // a test binary has no public interface
#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not count as tests

use std::time::{Duration, Instant};

use slamlab_bridge::serial::DeviceSource;
use slamlab_bridge::source::{self, Order, Running, SourceEvent};
use slamlab_core::device::{Kind, Rp6};
use slamlab_core::geom::Pose2;
use slamlab_core::robot::{Command, Odometry};
use slamlab_core::sim::worlds;
use slamlab_core::wire::message::{DeviceState, LinkState};
use slamlab_core::wire::rp6;
use slamlab_tests::calm::on_a_calm_machine;
use slamlab_tests::devices::{self, Faults, Socket};
use tokio::sync::mpsc;

const FORWARD: Order = Order::Command(Command::Velocity {
    forward: 0.1,
    turn: 0.0,
});

fn robot() -> devices::Rp6 {
    devices::Rp6::new(worlds::builtin("arena").unwrap()).unwrap()
}

/// Timeout for anything, s, because the machine may be loaded. How long it really takes is measured
/// by the reports.
const PATIENCE: f64 = 60.0;

/// A source at work, and what it reported.
struct Driver {
    running: Option<Running>,
    events: mpsc::Receiver<(u8, SourceEvent)>,
    /// Accumulated odometry, in the frame where the link came up.
    pose: Pose2,
}

impl Driver {
    fn new(path: String) -> Self {
        let (sender, events) = mpsc::channel(source::MOST_WAITING);
        let source = DeviceSource::at_port(Box::new(Rp6::new("rp6:test")), path);
        let running = source::start(0, Box::new(source), sender).unwrap();
        Self {
            running: Some(running),
            events,
            pose: Pose2::identity(),
        }
    }

    fn order(&self, order: Order) {
        // These tests do not ask which order a report follows.
        self.running.as_ref().unwrap().order(0, order);
    }

    /// Takes the next event, if there is one.
    fn hear(&mut self) -> Option<SourceEvent> {
        let (_, event) = self.events.try_recv().ok()?;
        if let SourceEvent::Odometry(odometry) = &event {
            self.pose = self.pose * odometry.motion;
        }
        Some(event)
    }

    fn wait<T>(&mut self, seconds: f64, mut wanted: impl FnMut(&SourceEvent) -> Option<T>) -> T {
        let until = Instant::now() + Duration::from_secs_f64(seconds);
        let mut others = vec![];
        while Instant::now() < until {
            match self.hear() {
                Some(event) => match wanted(&event) {
                    Some(found) => return found,
                    None if matches!(event, SourceEvent::Odometry(_)) => (),
                    None => others.push(event),
                },
                None => std::thread::sleep(Duration::from_millis(2)),
            }
        }
        panic!("not within {seconds} s; only: {others:#?}")
    }

    fn link(&mut self, wanted: LinkState) {
        self.wait(PATIENCE, |event| match event {
            SourceEvent::Link(link) if link.state == wanted => Some(()),
            _ => None,
        });
    }

    fn detail(&mut self, wanted: DeviceState) -> String {
        self.wait(PATIENCE, |event| match event {
            SourceEvent::Device { state, detail, .. } if *state == wanted && !detail.is_empty() => {
                Some(detail.clone())
            }
            _ => None,
        })
    }

    /// Waits until the link is up, and for the pause that a robot needs after coming back.
    fn up(&mut self) {
        self.link(LinkState::Up);
        std::thread::sleep(Duration::from_millis(350));
    }

    /// Repeats an order, like a person who holds a key down.
    fn hold(&mut self, order: Order, seconds: f64) {
        let until = Instant::now() + Duration::from_secs_f64(seconds);
        while Instant::now() < until {
            self.order(order);
            std::thread::sleep(Duration::from_millis(40));
            while self.hear().is_some() {}
        }
    }
}

fn is_moving(socket: &Socket<devices::Rp6>) -> bool {
    socket.with(|robot| robot.is_moving())
}

/// How long it still moves, s; it must stop at some time.
fn time_to_stand(socket: &Socket<devices::Rp6>) -> f64 {
    let began = Instant::now();
    while is_moving(socket) {
        assert!(
            began.elapsed().as_secs_f64() < PATIENCE,
            "it goes on moving"
        );
        std::thread::sleep(Duration::from_millis(2));
    }
    began.elapsed().as_secs_f64()
}

#[test]
fn odometry_is_that_of_the_robots_own_counts() {
    on_a_calm_machine(|| {
        let socket = Socket::plugged(robot()).unwrap();
        let mut driver = Driver::new(socket.path());
        driver.up();
        driver.hold(FORWARD, 1.5);
        driver.hold(
            Order::Command(Command::Velocity {
                forward: 0.0,
                turn: 0.8,
            }),
            1.0,
        );
        driver.order(Order::Command(Command::Stop));
        time_to_stand(&socket);
        std::thread::sleep(Duration::from_millis(100));
        while driver.hear().is_some() {}
        let ([left, right], model) =
            socket.with(|robot| (robot.simulation().ticks(), *robot.simulation().robot()));
        // The wire protocol has whole millimetres.
        let track_width = (model.track_width * 1e3).round() * 1e-3;
        let turned = (right - left) as f64 * model.metres_per_tick / track_width;
        assert!(driver.pose.x() > 0.1, "{:?}", driver.pose);
        // Between the last telemetry and reading its counts the robot may still settle by a count
        // or two.
        let settling = 3.0 * model.metres_per_tick / track_width;
        assert!(
            (driver.pose.heading() - turned).abs() < settling,
            "{} and {turned}",
            driver.pose.heading()
        );
    });
}

#[test]
fn robot_and_lidar_are_on_one_clock() {
    on_a_calm_machine(|| {
        let socket = Socket::plugged(robot()).unwrap();
        let lidar = Socket::plugged(devices::Ld06::new(devices::View::from_start(
            &worlds::builtin("arena").unwrap(),
        )))
        .unwrap();
        // The robot's own clock is seconds ahead of its source's.
        std::thread::sleep(Duration::from_secs(2));
        let (sender, mut events) = mpsc::channel(source::MOST_WAITING);
        let robot = DeviceSource::at_port(Box::new(Rp6::new("rp6:test")), socket.path());
        let ld06 = Kind::named("ld06").unwrap();
        let ld06 = (ld06.open)("ld06:test".into(), Pose2::identity());
        let ld06 = DeviceSource::at_port(ld06, lidar.path());
        let _robot = source::start(0, Box::new(robot), sender.clone()).unwrap();
        let _lidar = source::start(1, Box::new(ld06), sender).unwrap();
        let until = Instant::now() + Duration::from_secs_f64(PATIENCE);
        let (mut last, mut apart) = (None, vec![]);
        while apart.len() < 30 && Instant::now() < until {
            match events.try_recv() {
                Ok((_, SourceEvent::Odometry(odometry))) => {
                    let end = last.map_or(odometry.from, |odometry: Odometry| odometry.to);
                    assert_eq!(odometry.from, end, "odometry has no gaps");
                    last = Some(odometry);
                }
                Ok((_, SourceEvent::Scan(scan))) => {
                    apart.extend(last.map(|odometry| scan.stamp.since(odometry.to)));
                }
                Ok(_) => (),
                Err(_) => std::thread::sleep(Duration::from_millis(2)),
            }
        }
        // Since they arrived at the same time, they were taken at about the same time: within a
        // period of telemetry, and a stutter.
        apart.sort_by(f64::total_cmp);
        let median = apart[apart.len() / 2];
        assert!(
            apart.len() == 30 && median.abs() < 0.1,
            "{median} s apart, of {}",
            apart.len()
        );
    });
}

#[test]
fn it_says_what_it_is_and_how_it_is() {
    on_a_calm_machine(|| {
        let socket = Socket::plugged(robot()).unwrap();
        let mut driver = Driver::new(socket.path());
        let model = driver.wait(PATIENCE, |event| match event {
            SourceEvent::Device { model, .. } if !model.is_empty() => Some(model.clone()),
            _ => None,
        });
        assert_eq!(model, "RP6, firmware 1.0");
        let volts = driver.wait(PATIENCE, |event| match event {
            SourceEvent::Battery(battery) => Some(battery.volts),
            _ => None,
        });
        let truth = socket.with(|robot| robot.simulation().battery_volts());
        assert!(
            (f64::from(volts) - truth).abs() < 0.02,
            "{volts} V, in truth {truth} V"
        );
        let round_trip = driver.wait(PATIENCE, |event| match event {
            SourceEvent::Link(link) => link.round_trip,
            _ => None,
        });
        assert!(round_trip > 0.0, "{round_trip}");
    });
}

#[test]
fn an_errand_is_done_to_its_end() {
    on_a_calm_machine(|| {
        let socket = Socket::plugged(robot()).unwrap();
        let mut driver = Driver::new(socket.path());
        driver.up();
        // 3 s of driving: without signs of life the firmware would stop after 0.4 s.
        driver.order(Order::Command(Command::Forward(0.4)));
        let until = Instant::now() + Duration::from_secs_f64(PATIENCE);
        while Instant::now() < until && driver.pose.x() < 0.38 {
            driver.hear();
            std::thread::sleep(Duration::from_millis(1));
        }
        assert!(driver.pose.x() >= 0.38, "it came {} m far", driver.pose.x());
        let alive = socket.with(|robot| {
            robot
                .done
                .iter()
                .filter(|(_, c)| *c == rp6::Command::Alive)
                .count()
        });
        assert!(alive >= 5, "{alive} signs of life");
    });
}

#[test]
fn it_stands_when_the_driver_falls_silent() {
    on_a_calm_machine(|| {
        let socket = Socket::plugged(robot()).unwrap();
        let mut driver = Driver::new(socket.path());
        driver.up();
        driver.hold(FORWARD, 0.8);
        assert!(is_moving(&socket));
        // No further order: the source itself stops the robot, because its heartbeats would keep
        // the firmware's watchdog satisfied.
        let stood = time_to_stand(&socket);
        assert!(stood < 1.0, "{stood} s");
    });
}

#[test]
fn it_stands_when_the_cable_is_pulled_and_comes_back_disarmed() {
    on_a_calm_machine(|| {
        for pull in [Socket::pull, Socket::pull_in_the_middle] {
            let socket = Socket::plugged(robot()).unwrap();
            let mut driver = Driver::new(socket.path());
            driver.up();
            driver.hold(FORWARD, 0.8);
            assert!(is_moving(&socket));
            pull(&socket);
            driver.link(LinkState::Down);
            // A person holds the key down all the while.
            driver.hold(FORWARD, 0.3);
            socket.plug();
            driver.hold(FORWARD, 3.0);
            assert!(!socket.with(|robot| robot.was_told_to_move()));
            assert!(!is_moving(&socket));
            // Release, then press again: that is a deliberate start.
            std::thread::sleep(Duration::from_millis(400));
            driver.hold(FORWARD, 0.8);
            assert!(is_moving(&socket));
        }
    });
}

#[test]
fn a_robot_that_starts_anew_stands_until_the_key_is_let_go() {
    on_a_calm_machine(|| {
        let mut booting = robot();
        booting.has_boot_loader = true;
        let socket = Socket::plugged(booting).unwrap();
        let mut driver = Driver::new(socket.path());
        let detail = driver.detail(DeviceState::Waiting);
        assert!(detail.contains("boot loader"), "{detail}");
        driver.up();
        driver.hold(FORWARD, 0.8);
        assert!(is_moving(&socket));
        // A reset: the line stays open.
        socket.with(devices::Device::power_on);
        let until = Instant::now() + Duration::from_secs(2);
        let mut was_up = false;
        while Instant::now() < until {
            driver.order(FORWARD);
            std::thread::sleep(Duration::from_millis(40));
            while let Some(event) = driver.hear() {
                was_up |= matches!(event, SourceEvent::Link(link) if link.state == LinkState::Up);
            }
        }
        assert!(was_up);
        assert!(!socket.with(|robot| robot.was_told_to_move()));
        assert!(!is_moving(&socket));
        std::thread::sleep(Duration::from_millis(400));
        driver.hold(FORWARD, 0.8);
        assert!(is_moving(&socket));
    });
}

#[test]
fn an_emergency_stop_holds_through_a_pulled_cable() {
    on_a_calm_machine(|| {
        let socket = Socket::plugged(robot()).unwrap();
        let mut driver = Driver::new(socket.path());
        driver.up();
        driver.hold(FORWARD, 0.8);
        driver.order(Order::EmergencyStop);
        let stood = time_to_stand(&socket);
        assert!(stood < 0.5, "{stood} s");
        socket.pull();
        driver.link(LinkState::Down);
        socket.plug();
        driver.up();
        driver.hold(FORWARD, 0.8);
        assert!(!is_moving(&socket));
        driver.order(Order::ResetEmergencyStop);
        std::thread::sleep(Duration::from_millis(300));
        assert!(!is_moving(&socket), "a reset moves nothing");
        driver.hold(FORWARD, 0.8);
        assert!(is_moving(&socket));
    });
}

#[test]
fn a_bridge_that_ends_stops_the_robot() {
    on_a_calm_machine(|| {
        let socket = Socket::plugged(robot()).unwrap();
        let mut driver = Driver::new(socket.path());
        driver.up();
        driver.hold(FORWARD, 0.8);
        driver.running = None;
        let stood = time_to_stand(&socket);
        assert!(
            stood < 0.4,
            "{stood} s: that was the watchdog, not the stop"
        );
        let last = socket.with(|robot| robot.done.last().copied().unwrap());
        assert_eq!(last.1, rp6::Command::Stop);
    });
}

#[test]
fn a_line_that_flips_one_bit_of_a_thousand_still_drives_and_stops() {
    on_a_calm_machine(|| {
        let socket = Socket::plugged(robot()).unwrap();
        let mut driver = Driver::new(socket.path());
        driver.up();
        socket.set_faults(Faults {
            flipped_bits: 1e-3,
            ..Faults::default()
        });
        driver.hold(FORWARD, 3.0);
        driver.order(Order::Command(Command::Stop));
        let stood = time_to_stand(&socket);
        assert!(stood < 0.8, "{stood} s");
        let ([left, _], model) =
            socket.with(|robot| (robot.simulation().ticks(), *robot.simulation().robot()));
        assert!(left as f64 * model.metres_per_tick > 0.1, "{left} counts");
        let damaged = driver.wait(PATIENCE, |event| match event {
            SourceEvent::Link(link) => (link.damaged > 0).then_some(link.damaged),
            _ => None,
        });
        // 150 telemetry frames of about 34 bytes in 3 s: 2 to 60 of them damaged.
        assert!((1..100).contains(&damaged), "{damaged}");
    });
}

#[test]
fn what_is_wrong_with_the_robot_is_told_with_its_cure() {
    on_a_calm_machine(|| {
        let socket = Socket::plugged(robot()).unwrap();
        let mut driver = Driver::new(socket.path());
        driver.up();
        socket.with(|robot| robot.fault = rp6::Fault::BatteryLow);
        assert!(driver.detail(DeviceState::Fault).contains("charge it"));
        socket.with(|robot| robot.fault = rp6::Fault::None);
        socket.with(devices::Rp6::shut_down);
        let detail = driver.detail(DeviceState::Fault);
        assert!(
            detail.contains("a motor is blocked") && detail.contains("reset button"),
            "{detail}"
        );
        driver.link(LinkState::ResetNeeded);
        socket.with(devices::Device::power_on);
        driver.link(LinkState::Up);
    });
}

#[test]
fn nobody_there_and_no_program_are_told_apart() {
    on_a_calm_machine(|| {
        let faults = Faults {
            is_mute: true,
            ..Faults::default()
        };
        let mute = Socket::plugged_with(robot(), faults).unwrap();
        let detail = Driver::new(mute.path()).detail(DeviceState::Fault);
        assert!(
            detail.contains("nobody answers") && detail.contains("START"),
            "{detail}"
        );
        let mut empty = robot();
        (empty.has_boot_loader, empty.has_program) = (true, false);
        let socket = Socket::unplugged(empty).unwrap();
        let mut driver = Driver::new(socket.path());
        socket.plug();
        let detail = driver.detail(DeviceState::Fault);
        assert!(detail.contains("flash slamlab's firmware"), "{detail}");
    });
}
