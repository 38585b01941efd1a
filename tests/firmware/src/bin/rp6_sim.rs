//! A simulated RP6 on a pseudo-terminal: the real firmware in a simulated controller, in a simulated world, in real time.
//!
//! In: the name of a built-in world (default `arena`), then commands of [`slamlab_tests::console`]. Out: its answers; the first line
//! names the port. Whoever opens it finds a robot that was switched on before.
//!
//!     cargo run --manifest-path tests/firmware/Cargo.toml --bin rp6_sim -- arena

use std::io::{stdin, stdout};

use anyhow::{Context, Result};
use serde_json::{Value, json};
use slamlab_core::sim::{World, worlds};
use slamlab_firmware_tests::{Rig, Wired};
use slamlab_tests::console::{self, in_map, serve};
use slamlab_tests::devices::Socket;

struct Robot {
    world: World,
    socket: Socket<Wired>,
}

impl console::Wired for Robot {
    fn plug(&self, is_in: bool) {
        match is_in {
            true => self.socket.plug(),
            false => self.socket.pull(),
        }
    }

    fn facts(&self) -> Value {
        self.socket.with(|robot| {
            json!({
                "pose": in_map(&self.world, &robot.rig.pose()),
                "moves": robot.is_driven(),
                "duties": robot.rig.chip.duties(),
                "stopped_after": robot.stopped_after(),
                "contacts": robot.rig.contacts(),
                "seconds": robot.rig.seconds(),
                "behind": robot.behind(),
                "fault": robot.fault(),
            })
        })
    }
}

fn main() -> Result<()> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "arena".into());
    let world = worlds::builtin(&name).with_context(|| format!("no built-in world `{name}`"))?;
    let robot = Robot {
        socket: Socket::plugged(Wired::new(Rig::in_world(&world)?))?,
        world,
    };
    let ports = json!({ "rp6": robot.socket.path() });
    Ok(serve(&robot.world, &ports, &robot, stdin().lock(), stdout().lock())?)
}
