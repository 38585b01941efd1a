//! A simulated RP6 on a pseudo-terminal: the real firmware in a simulated controller, in a
//! simulated world, in real time.
//!
//! In: the name of a built-in world (default `arena`), and `lidar` where it carries an RPLIDAR too,
//! on a line of its own; then commands of [`slamlab_tests::console`]. Out: its answers; the first
//! line names the ports. Beside those: `mark` (something happens that should stop it: how long it
//! takes is a fact), `edge` (reports when the next count of an encoder happened, and when it was
//! reported), `half` (the robot's cable is pulled in the middle of a frame), `reset` (its button;
//! the boot loader speaks), `noise P` (part P of all bits of the robot's line flipped, both ways),
//! `garble` (both its sides hear noise), `mend` (neither any more). Whoever opens it finds a robot
//! that was switched on before.
//!
//!     cargo run --manifest-path tests/firmware/Cargo.toml --bin rp6_sim -- arena lidar

use std::io::{stdin, stdout};
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use serde_json::{Value, json};
use slamlab_core::sim::{World, worlds};
use slamlab_firmware_tests::{Rig, Wired};
use slamlab_tests::console::{self, in_map, serve};
use slamlab_tests::devices::{Aboard, Faults, Rplidar, Socket, View};

struct Robot {
    world: World,
    socket: Arc<Socket<Wired>>,
    lidar: Option<Socket<Aboard<Wired>>>,
}

impl console::Wired for Robot {
    fn plug(&self, is_in: bool) {
        match is_in {
            true => self.socket.plug(),
            false => self.socket.pull(),
        }
        if let Some(lidar) = &self.lidar {
            match is_in {
                true => lidar.plug(),
                false => lidar.pull(),
            }
        }
    }

    fn facts(&self) -> Value {
        let of_lidar = self.lidar.as_ref().map(Socket::lost).unwrap_or_default();
        let of_chip = self.socket.lost().as_secs_f64();
        self.socket.with(|robot| {
            json!({
                "lost": of_chip + of_lidar.as_secs_f64(),
                "pose": in_map(&self.world, &robot.rig.pose()),
                "moves": robot.is_driven(),
                "duties": robot.rig.chip.duties(),
                "stopped_after": robot.stopped_after().map(|[chip, _]| chip),
                "stopped_after_real": robot.stopped_after().map(|[_, real]| real),
                "edge": robot.edge(),
                "contacts": robot.rig.contacts(),
                "seconds": robot.rig.seconds(),
                "behind": of_chip + robot.behind(),
                "fault": robot.fault(),
            })
        })
    }

    fn act(&self, words: &[&str]) -> bool {
        match words {
            ["mark"] => self.socket.with(Wired::mark),
            ["edge"] => self.socket.with(Wired::watch_edge),
            ["half"] => self.socket.pull_in_the_middle(),
            ["reset"] => self.socket.with(Wired::reset),
            ["garble"] => self.spoil(Faults {
                is_garbled: true,
                ..Faults::default()
            }),
            ["noise", part] => match part.parse() {
                Ok(part) => self.spoil(Faults {
                    flipped_bits: part,
                    flipped_bits_heard: part,
                    ..Faults::default()
                }),
                Err(_) => return false,
            },
            ["mend"] => self.socket.set_faults(Faults::default()),
            _ => return false,
        }
        true
    }
}

impl Robot {
    fn spoil(&self, faults: Faults) {
        self.socket.with(Wired::mark);
        self.socket.set_faults(faults);
    }
}

fn main() -> Result<()> {
    let mut words = std::env::args().skip(1);
    let name = words.next().unwrap_or_else(|| "arena".into());
    let world = worlds::builtin(&name).with_context(|| format!("no built-in world `{name}`"))?;
    let socket = Arc::new(Socket::plugged(Wired::new(Rig::in_world(&world)?))?);
    let mut ports = json!({ "rp6": socket.path() });
    let lidar = match words.next().as_deref() {
        None => None,
        Some("lidar") => {
            let lidar = Rplidar::new(View::from_start(&world));
            let lidar = Socket::plugged(Aboard::new(lidar, Arc::clone(&socket)))?;
            ports["rplidar"] = json!(lidar.path());
            Some(lidar)
        }
        Some(other) => bail!("expected `lidar` or nothing after the world, not `{other}`"),
    };
    let robot = Robot {
        world,
        socket,
        lidar,
    };
    Ok(serve(
        &robot.world,
        &ports,
        &robot,
        stdin().lock(),
        stdout().lock(),
    )?)
}
