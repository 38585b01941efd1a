//! A simulated RP6 with an RPLIDAR, each on a pseudo-terminal: the bridge finds there, byte for
//! byte, what real devices send.
//!
//! In: the name of a built-in world (default `arena`), then commands of [`slamlab_tests::console`].
//! Out: its answers.
//!
//!     cargo run -p slamlab-tests --example wired_robot -- arena
#![allow(missing_docs)] // a program has no public interface

#[cfg(unix)]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    unix::main()
}

#[cfg(not(unix))]
fn main() {
    eprintln!("there are no pseudo-terminals here");
}

#[cfg(unix)]
mod unix {
    use std::error::Error;
    use std::io::{stdin, stdout};
    use std::sync::Arc;

    use serde_json::{Value, json};
    use slamlab_core::sim::{World, worlds};
    use slamlab_tests::console::{Wired, in_map, serve};
    use slamlab_tests::devices::{Aboard, Rp6, Rplidar, Socket, View};

    struct Both {
        world: World,
        robot: Arc<Socket<Rp6>>,
        lidar: Socket<Aboard<Rp6>>,
    }

    impl Wired for Both {
        fn plug(&self, is_in: bool) {
            match is_in {
                true => (self.robot.plug(), self.lidar.plug()),
                false => (self.robot.pull(), self.lidar.pull()),
            };
        }

        fn facts(&self) -> Value {
            let lost = (self.robot.lost() + self.lidar.lost()).as_secs_f64();
            self.robot.with(|robot| {
                let simulation = robot.simulation();
                json!({
                    "lost": lost,
                    "pose": in_map(&self.world, &simulation.truth()),
                    "moves": robot.is_moving(),
                    "told_to_move": robot.was_told_to_move(),
                    "contacts": simulation.contacts().total(),
                    "seconds": simulation.stamp().seconds(),
                })
            })
        }
    }

    pub(super) fn main() -> Result<(), Box<dyn Error>> {
        let name = std::env::args().nth(1).unwrap_or_else(|| "arena".into());
        let world =
            worlds::builtin(&name).ok_or_else(|| format!("there is no built-in world `{name}`"))?;
        let robot = Arc::new(Socket::plugged(Rp6::new(world.clone())?)?);
        let lidar = Aboard::new(Rplidar::new(View::from_start(&world)), Arc::clone(&robot));
        let both = Both {
            robot,
            lidar: Socket::plugged(lidar)?,
            world,
        };
        let ports = json!({ "rp6": both.robot.path(), "rplidar": both.lidar.path() });
        serve(&both.world, &ports, &both, stdin().lock(), stdout().lock())?;
        Ok(())
    }
}
