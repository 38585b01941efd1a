//! A simulated RP6 on a pseudo-terminal: the real firmware in a simulated controller, in a simulated world, in real time.
//!
//! In: the name of a built-in world (default `arena`), then commands of [`slamlab_tests::console`]. Out: its answers; the first line
//! names the port. Beside those: `mark` (something happens that should stop it: how long it takes is a fact), `edge` (of the next count of an
//! encoder it is a fact when it was, and when it was told), `half` (the cable is pulled
//! in the middle of a frame), `reset` (its button; the boot loader speaks), `noise P` (part P of all bits flipped, both ways), `garble`
//! (both sides hear noise), `mend` (neither any more). Whoever opens it finds a robot that was switched on before.
//!
//!     cargo run --manifest-path tests/firmware/Cargo.toml --bin rp6_sim -- arena

use std::io::{stdin, stdout};

use anyhow::{Context, Result};
use serde_json::{Value, json};
use slamlab_core::sim::{World, worlds};
use slamlab_firmware_tests::{Rig, Wired};
use slamlab_tests::console::{self, in_map, serve};
use slamlab_tests::devices::{Faults, Socket};

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
        let late = self.socket.late().as_secs_f64();
        self.socket.with(|robot| {
            json!({
                "late": late,
                "pose": in_map(&self.world, &robot.rig.pose()),
                "moves": robot.is_driven(),
                "duties": robot.rig.chip.duties(),
                "stopped_after": robot.stopped_after().map(|[chip, _]| chip),
                "stopped_after_real": robot.stopped_after().map(|[_, real]| real),
                "edge": robot.edge(),
                "contacts": robot.rig.contacts(),
                "seconds": robot.rig.seconds(),
                "behind": robot.behind(),
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
    let name = std::env::args().nth(1).unwrap_or_else(|| "arena".into());
    let world = worlds::builtin(&name).with_context(|| format!("no built-in world `{name}`"))?;
    let robot = Robot {
        socket: Socket::plugged(Wired::new(Rig::in_world(&world)?))?,
        world,
    };
    let ports = json!({ "rp6": robot.socket.path() });
    Ok(serve(
        &robot.world,
        &ports,
        &robot,
        stdin().lock(),
        stdout().lock(),
    )?)
}
