//! A simulated robot's console: other programs pull its cables and ask for the truth.
//!
//! In: one command per line. Out: one line of JSON per answer; the first one names its ports.
//!
//! | command | answer |
//! |---|---|
//! | `pull`, `plug` | `{}`; its cables are out, or in |
//! | `facts` | the true state of the robot, as its owner reports it |
//! | others | `{}`; defined by the robot's own program |
//! | `map FILE.pgm FILE.yaml` | how accurate that map is: [`crate::map_truth`] |
//!
//! It ends with its input.

use std::io::{BufRead, Write};

use serde_json::{Value, json};
use slamlab_core::geom::Pose2;
use slamlab_core::sim::World;

use crate::map_truth;

/// A robot with cables.
pub trait Wired {
    /// Pulls its cables out, or puts them in.
    fn plug(&self, is_in: bool);

    /// The true state of it.
    fn facts(&self) -> Value;

    /// Does something else; returns whether it knows the command.
    fn act(&self, _words: &[&str]) -> bool {
        false
    }
}

/// Serves a robot in `world` with these ports, until the input ends.
///
/// # Errors    Input or output fails.
pub fn serve(
    world: &World,
    ports: &Value,
    robot: &impl Wired,
    input: impl BufRead,
    mut output: impl Write,
) -> std::io::Result<()> {
    let mut say = |answer: &Value| {
        writeln!(output, "{answer}")?;
        output.flush()
    };
    say(ports)?;
    for line in input.lines() {
        let line = line?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let answer = match words.as_slice() {
            [word @ ("pull" | "plug")] => {
                robot.plug(*word == "plug");
                json!({})
            }
            ["facts"] => robot.facts(),
            ["map", pgm, yaml] => map(world, pgm, yaml),
            words if robot.act(words) => json!({}),
            _ => json!({ "error": format!("expected pull, plug, facts or map, not `{line}`") }),
        };
        say(&answer)?;
    }
    Ok(())
}

fn map(world: &World, pgm: &str, yaml: &str) -> Value {
    let read = || -> Result<map_truth::MapTruth, String> {
        let picture = std::fs::read(pgm).map_err(|error| format!("{pgm}: {error}"))?;
        let text = std::fs::read_to_string(yaml).map_err(|error| format!("{yaml}: {error}"))?;
        map_truth::compare(world, &picture, &text).map_err(|error| error.to_string())
    };
    match read() {
        Ok(truth) => json!({
            "explored": truth.explored, "true_walls": truth.true_walls,
            "wall_error": truth.wall_error, "found_walls": truth.found_walls,
        }),
        Err(error) => json!({ "error": error }),
    }
}

/// A pose as on the page: in the frame that begins at the start of the world.
#[must_use]
pub fn in_map(world: &World, pose: &Pose2) -> Value {
    let pose = world.start.inverse() * *pose;
    json!([pose.x(), pose.y(), pose.heading()])
}
