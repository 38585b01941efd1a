//! An RP6 at the bridge's own serial device, faster than real time: neither has a clock.
//!
//! Every three minutes the line is cut or the robot reset; in between it drives to and fro. Each
//! simulated hour: memory of this process, and the error of the stamps that the bridge reports.

use serde_json::{Value, json};
use slamlab_bridge::source::{Order, SourceEvent};
use slamlab_core::device::{Device as _, Rp6, Want};
use slamlab_core::robot::{Command, Stamp};
use slamlab_core::sim::worlds;
use slamlab_tests::devices::{self, Device as _};

use crate::trend::Trend;

const TICK: f64 = 0.01;
const TICKS_OF_AN_HOUR: u32 = 360_000;
/// Ticks between two faults.
const TICKS_OF_CALM: u32 = 18_000;

pub(crate) fn run(hours: u32) -> (bool, Value) {
    let mut bridge = Rp6::new("rp6:soak");
    let mut robot = devices::Rp6::new(worlds::builtin("arena").unwrap()).unwrap();
    robot.power_on();
    let mut pair = Pair {
        odometries: 0,
        ups: 0,
        worst_age: 0.0,
    };
    bridge.opened(Stamp(0));
    let (mut memory, mut ages) = (vec![], vec![]);
    for tick in 0..hours * TICKS_OF_AN_HOUR {
        let now = Stamp::from_seconds(TICK * f64::from(tick));
        match tick % TICKS_OF_CALM {
            0 if (tick / TICKS_OF_CALM).is_multiple_of(2) => {
                bridge.broken("cut".into());
                bridge.opened(now);
                pair.ups += 1;
            }
            0 => robot.power_on(),
            k if k > 300 && k % 4 == 0 => bridge.order(Order::Command(to_and_fro(k)), now),
            _ => (),
        }
        let said = robot.advance(TICK);
        bridge.receive(&said, now);
        bridge.tick(now);
        pair.take(&mut bridge, &mut robot, now);
        // `done` is memory of the test harness, not of the bridge.
        robot.done.clear();
        if (tick + 1) % TICKS_OF_AN_HOUR == 0 {
            let hour = f64::from((tick + 1) / TICKS_OF_AN_HOUR);
            memory.push((hour, anonymous_kb()));
            ages.push((hour, 1e3 * pair.worst_age));
            pair.worst_age = 0.0;
        }
    }
    let settled = memory.len() / 5;
    let (memory, ages) = (Trend::of(&memory[settled..]), Trend::of(&ages[settled..]));
    let (Some(memory), Some(ages)) = (memory, ages) else {
        return (false, Value::Null);
    };
    let rate = f64::from(pair.odometries) / (f64::from(hours) * 3600.0);
    let holds = !memory.grows(512.0) && !ages.grows(5.0) && rate > 10.0;
    let figures = json!({
        "hours": hours, "faults": pair.ups * 2, "odometries_a_second": rate,
        "anonymous_kb": memory.figures(512.0), "oldest_stamp_ms": ages.figures(5.0),
    });
    (holds, figures)
}

struct Pair {
    odometries: u32,
    ups: u32,
    /// Age of an odometry reading when it is reported, s.
    worst_age: f64,
}

impl Pair {
    fn take(&mut self, bridge: &mut Rp6, robot: &mut devices::Rp6, now: Stamp) {
        while let Some(want) = bridge.next_want() {
            match want {
                Want::Write(bytes) => robot.receive(&bytes),
                Want::Report(SourceEvent::Odometry(odometry)) => {
                    self.odometries += 1;
                    self.worst_age = self.worst_age.max(now.since(odometry.to));
                }
                _ => (),
            }
        }
    }
}

fn to_and_fro(tick: u32) -> Command {
    let forward = if (tick / 400).is_multiple_of(2) {
        0.05
    } else {
        -0.05
    };
    Command::Velocity { forward, turn: 0.0 }
}

fn anonymous_kb() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("RssAnon:"));
    line.and_then(|rest| rest.split_whitespace().next()?.parse().ok())
        .unwrap()
}
