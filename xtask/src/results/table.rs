//! What is measured: one row for each result.

use std::fs;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::wasm::Profile;
use crate::{page, tools};

/// One result.
#[derive(Debug)]
pub(super) struct Entry {
    pub(super) name: &'static str,
    /// What is claimed, a sentence without figures.
    pub(super) claim: &'static str,
    source: Source,
    /// Folders of code that change what is measured.
    pub(super) measures: &'static [&'static str],
    /// Whether it takes less than two minutes, compilation apart.
    pub(super) is_quick: bool,
}

/// Who measures.
#[derive(Clone, Copy, Debug)]
enum Source {
    /// The example `report` of core, with these words.
    Report(&'static str),
    /// `cargo xtask report`, with these words.
    Promise(&'static str),
    /// The example `evaluate` of core, on this log of the recorded data.
    Log(&'static str),
    /// The example `workloads` of core, on the peers' inputs, which the variable `PEERS_INPUTS` names.
    Workloads,
    /// Bytes of the page's files.
    Sizes,
}

const CORE: &[&str] = &["core/src"];
const STAGES_TO_FEATURES: &[&str] = &[
    "core/src/geom",
    "core/src/lanes",
    "core/src/robot",
    "core/src/points",
    "core/src/features",
];
const GRID: &[&str] = &["core/src/geom", "core/src/map"];
const BRIDGE: &[&str] = &["core/src/device", "core/src/wire", "bridge/src"];
const BRIDGE_AND_FIRMWARE: &[&str] = &[
    "core/src/device",
    "core/src/wire",
    "bridge/src",
    "bridge/firmware",
];

/// All results, in the order of the file.
pub(super) const TABLE: &[Entry] = &[
    Entry {
        name: "intel",
        claim: "A recorded building, Intel Research Lab, mapped by the default method; errors over the relations of Kümmerle et al. (2009).",
        source: Source::Log("intel/intel"),
        measures: CORE,
        is_quick: true,
    },
    Entry {
        name: "freiburg",
        claim: "A recorded building, Freiburg 079, mapped by the same method with the same parameters.",
        source: Source::Log("fr079/fr079"),
        measures: CORE,
        is_quick: true,
    },
    Entry {
        name: "explore",
        claim: "A robot dropped into an unknown building sees all of it by itself; its way, by strategy.",
        source: Source::Report("explore"),
        measures: CORE,
        is_quick: false,
    },
    Entry {
        name: "ekf-consistency",
        claim: "The line filter is as uncertain as it claims.",
        source: Source::Report("ekf-consistency"),
        measures: CORE,
        is_quick: false,
    },
    Entry {
        name: "ekf-cost",
        claim: "What an update of the line filter costs, by the number of landmarks.",
        source: Source::Report("ekf-cost"),
        measures: &[
            "core/src/lanes",
            "core/src/association",
            "core/src/estimation",
        ],
        is_quick: true,
    },
    Entry {
        name: "controller",
        claim: "The controller makes up for unequal motors and for load.",
        source: Source::Report("controller"),
        measures: &["core/src/robot", "core/src/sim"],
        is_quick: true,
    },
    Entry {
        name: "line-fit",
        claim: "Fitted lines are as uncertain as they claim.",
        source: Source::Report("line-fit"),
        measures: STAGES_TO_FEATURES,
        is_quick: true,
    },
    Entry {
        name: "split-merge",
        claim: "How well split-and-merge finds the walls of random rooms, rule by rule.",
        source: Source::Report("split-merge"),
        measures: STAGES_TO_FEATURES,
        is_quick: false,
    },
    Entry {
        name: "grid",
        claim: "What the occupancy grid costs, sweep by sweep, and that its cells are right.",
        source: Source::Report("grid"),
        measures: GRID,
        is_quick: true,
    },
    Entry {
        name: "distance",
        claim: "The distance transform is exact, and linear in the number of cells.",
        source: Source::Report("distance"),
        measures: GRID,
        is_quick: true,
    },
    Entry {
        name: "vector-map",
        claim: "The vector map keeps a wall once, with its ends.",
        source: Source::Report("vector-map"),
        measures: CORE,
        is_quick: false,
    },
    Entry {
        name: "planners",
        claim: "Every planner solves what can be solved, without a collision, and says where there is no way.",
        source: Source::Report("planners"),
        measures: &["core/src/geom", "core/src/map", "core/src/plan"],
        is_quick: false,
    },
    Entry {
        name: "rounding",
        claim: "Corners driven round take less time than stops at them.",
        source: Source::Report("rounding"),
        measures: CORE,
        is_quick: false,
    },
    Entry {
        name: "safe-drive",
        claim: "Safe mode touches no wall and drives into nobody, whatever the stick says.",
        source: Source::Report("safe-drive"),
        measures: &["core/src/points", "core/src/control", "core/src/sim"],
        is_quick: false,
    },
    Entry {
        name: "crowd",
        claim: "A robot among people gets where it goes.",
        source: Source::Report("crowd"),
        measures: CORE,
        is_quick: false,
    },
    Entry {
        name: "ray-cast",
        claim: "How fast beams are cast among many walls.",
        source: Source::Report("ray-cast"),
        measures: &["core/src/geom", "core/src/sim"],
        is_quick: true,
    },
    Entry {
        name: "workloads",
        claim: "The peers' workloads on the peers' inputs.",
        source: Source::Workloads,
        measures: CORE,
        is_quick: false,
    },
    Entry {
        name: "faults",
        claim: "Whatever breaks, the motors lose their voltage in time; by the registers of the real firmware.",
        source: Source::Promise("faults"),
        measures: BRIDGE_AND_FIRMWARE,
        is_quick: false,
    },
    Entry {
        name: "latency",
        claim: "From the robot to a client, alone and beside watchers.",
        source: Source::Promise("latency"),
        measures: BRIDGE_AND_FIRMWARE,
        is_quick: false,
    },
    Entry {
        name: "access",
        claim: "Who has no right to the robot is refused.",
        source: Source::Promise("access"),
        measures: BRIDGE,
        is_quick: true,
    },
    Entry {
        name: "soak",
        claim: "Nothing grows with time.",
        source: Source::Promise("soak"),
        measures: BRIDGE,
        is_quick: false,
    },
    Entry {
        name: "fuzz",
        claim: "No decoder crashes on changed input.",
        source: Source::Promise("fuzz"),
        measures: &[
            "core/src/wire",
            "core/src/format",
            "core/src/settings",
            "bridge/src",
        ],
        is_quick: false,
    },
    Entry {
        name: "browser-cost",
        claim: "An update of the line filter is not much slower in the browser.",
        source: Source::Promise("browser-cost"),
        measures: &["core/src/lanes", "core/src/estimation", "web/src"],
        is_quick: false,
    },
    Entry {
        name: "sizes",
        claim: "What the page weighs, in bytes: as it is, and as it is sent.",
        source: Source::Sizes,
        measures: &["core/src", "web/src", "www"],
        is_quick: true,
    },
];

impl Entry {
    /// What to type.
    pub(super) fn command_line(&self) -> String {
        match self.source {
            Source::Report(words) => {
                format!("cargo run --release -p slamlab-core --example report -- {words}")
            }
            Source::Promise(words) => format!("cargo xtask report {words}"),
            Source::Log(log) => {
                let log = log.rsplit('/').next().unwrap_or(log);
                format!(
                    "cargo run --release -p slamlab-core --example evaluate -- --log {log}.clf \
                     --relations {log}.relations --json"
                )
            }
            Source::Workloads => {
                "cargo run --release -p slamlab-core --example workloads -- --inputs INPUTS".into()
            }
            Source::Sizes => "cargo xtask build && ls -l www/dist".into(),
        }
    }

    /// Measures, and returns what is printed. A claim that does not hold is a result, too.
    pub(super) fn run(&self) -> Result<String> {
        match self.source {
            Source::Report(words) => {
                let example = example("report")?;
                printed(Command::new(example).args(words.split(' ')))
            }
            Source::Promise(words) => {
                let mut xtask = Command::new(std::env::current_exe()?);
                printed(xtask.arg("report").args(words.split(' ')))
            }
            Source::Log(log) => {
                let example = example("evaluate")?;
                let file = |ending: &str| tools::data_folder().join(format!("{log}.{ending}"));
                let mut evaluate = Command::new(example);
                evaluate.arg("--log").arg(file("clf"));
                evaluate.arg("--relations").arg(file("relations"));
                printed(evaluate.arg("--json"))
            }
            Source::Workloads => {
                let inputs = std::env::var_os("PEERS_INPUTS").context(
                    "the variable PEERS_INPUTS must name the folder of the peers' inputs",
                )?;
                let example = example("workloads")?;
                let mut workloads = Command::new(example);
                workloads.arg("--inputs").arg(inputs);
                printed(workloads.args("ekf_step rays split_and_merge grid plan".split(' ')))
            }
            Source::Sizes => sizes(),
        }
    }
}

/// An example of core, optimised.
fn example(name: &str) -> Result<std::path::PathBuf> {
    let build = "build --release --quiet --package slamlab-core --example";
    tools::run(tools::cargo().args(build.split(' ')).arg(name))?;
    Ok(tools::built(&format!("release/examples/{name}")))
}

/// What a command prints. It may say by its exit status that a claim does not hold, and does so in its figures, too.
fn printed(command: &mut Command) -> Result<String> {
    let shown = format!("{command:?}");
    eprintln!("$ {shown}");
    let output = command
        .current_dir(tools::root())
        .stderr(Stdio::inherit())
        .output()
        .with_context(|| format!("cannot start {shown}"))?;
    let text = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    if text.is_empty() {
        bail!("{shown} measured nothing ({})", output.status);
    }
    Ok(text)
}

fn sizes() -> Result<String> {
    page::build(Profile::Release)?;
    let dist = tools::root().join("www/dist");
    let lines = [
        "slamlab_web_bg.wasm",
        "main.js",
        "worker.js",
        "local_bridge.js",
    ]
    .map(|name| {
        let bytes = |ending: &str| -> Result<u64> {
            let file = dist.join(format!("{name}{ending}"));
            let facts = fs::metadata(&file);
            Ok(facts
                .with_context(|| format!("{} is missing", file.display()))?
                .len())
        };
        Ok(format!(
            "  \"{name}\": {{ \"plain\": {}, \"br\": {}, \"gz\": {} }}",
            bytes("")?,
            bytes(".br")?,
            bytes(".gz")?
        ))
    });
    let lines = lines.into_iter().collect::<Result<Vec<_>>>()?;
    Ok(format!("{{\n{}\n}}", lines.join(",\n")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_folder_that_is_measured_is_there() {
        for entry in TABLE {
            for folder in entry.measures {
                assert!(
                    tools::root().join(folder).exists(),
                    "{}: {folder}",
                    entry.name
                );
            }
        }
    }

    #[test]
    fn every_report_of_core_has_a_row() {
        let source = tools::root().join("core/examples/report/main.rs");
        let source = fs::read_to_string(source).unwrap();
        let (_, list) = source.split_once("REPORTS: &[Entry] = &[").unwrap();
        let (list, _) = list.split_once("];").unwrap();
        for name in list.lines().filter_map(|line| line.split('"').nth(1)) {
            assert!(TABLE.iter().any(|entry| entry.name == name), "{name}");
        }
    }
}
