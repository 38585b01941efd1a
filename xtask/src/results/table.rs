//! What is measured: one row for each result.

use std::process::Stdio;
use std::{env, fs};

use anyhow::{Context, Result, bail};
use serde_json::Value;

use crate::wasm::Profile;
use crate::{page, tools};
use Source::{Log, Promise, Report, Sizes, Workloads};
use Takes::{Quick, Slow};

/// One result.
#[derive(Debug)]
pub(super) struct Entry {
    pub(super) name: &'static str,
    source: Source,
    takes: Takes,
    /// Folders whose code affects the result.
    pub(super) measures: &'static [&'static str],
    /// The claim, one sentence without figures.
    pub(super) claim: &'static str,
}

/// How it is measured.
#[derive(Clone, Copy, Debug)]
enum Source {
    /// By the example `report` of core, with the entry's name.
    Report,
    /// By `cargo xtask report`, with the entry's name.
    Promise,
    /// By the example `evaluate` of core, on this log of the recorded data.
    Log(&'static str),
    /// By the example `workloads` of core, on the peers' inputs.
    Workloads,
    /// By the size of the page's files, bytes.
    Sizes,
}

/// How long it takes, without compilation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Takes {
    /// Less than two minutes.
    Quick,
    /// More.
    Slow,
}

const CORE: &[&str] = &["core/src"];
const FEATURES: &[&str] = &[
    "core/src/geom",
    "core/src/lanes",
    "core/src/robot",
    "core/src/points",
    "core/src/features",
];
const GRID: &[&str] = &["core/src/geom", "core/src/map"];
const BRIDGE: &[&str] = &["core/src/device", "core/src/wire", "bridge/src"];
const FLEET: &[&str] = &[
    "core/src/device",
    "core/src/wire",
    "bridge/src",
    "www/src/fleet",
];
const FIRMWARE: &[&str] = &[
    "core/src/device",
    "core/src/wire",
    "bridge/src",
    "bridge/firmware",
];

/// All results, in the order of the file.
#[rustfmt::skip]
pub(super) const TABLE: &[Entry] = &[
    entry("intel", Log("intel/intel"), Quick, CORE,
        "A recorded building, Intel Research Lab, mapped by the default method; errors over the relations of Kümmerle et al. (2009)."),
    entry("freiburg", Log("fr079/fr079"), Quick, CORE,
        "A recorded building, Freiburg 079, mapped by the same method with the same parameters."),
    entry("buildings", Report, Slow, CORE,
        "One set of parameters maps every recorded building, and bears what befalls logs: no odometry, bent odometry, lost scans, few beams."),
    entry("explore", Report, Slow, CORE,
        "A robot dropped into an unknown building sees all of it by itself; its way, by strategy."),
    entry("look-alikes", Report, Slow, CORE,
        "Scan matching closes no loop falsely, however much two places look alike, and its walls are where they stand."),
    entry("random-buildings", Report, Slow, CORE,
        "In buildings, with robots and lidars by chance, no map is ruined in silence."),
    entry("ekf-consistency", Report, Slow, CORE,
        "The line filter is as uncertain as it claims."),
    entry("point-landmarks", Report, Slow, CORE,
        "Walls, corners and posts, or both as landmarks of that filter: how far off, how honest, how often matched wrongly."),
    entry("ekf-cost", Report, Quick, &["core/src/lanes", "core/src/association", "core/src/estimation"],
        "What an update of the line filter costs, by the number of landmarks."),
    entry("controller", Report, Quick, &["core/src/robot", "core/src/sim"],
        "The controller makes up for unequal motors and for load."),
    entry("line-fit", Report, Quick, FEATURES,
        "Fitted lines are as uncertain as they claim."),
    entry("split-merge", Report, Slow, FEATURES,
        "How well split-and-merge finds the walls of random rooms, rule by rule."),
    entry("features", Report, Quick, &["core/src/geom", "core/src/points", "core/src/features", "core/src/association", "core/src/sim"],
        "Corners, crossings and circles of a scan stand where something is, and are found again in the next."),
    entry("affine", Report, Quick, &["core/src/registration"],
        "The affine map between two clouds is found without a start and without pairs, where one is a copy of the other."),
    entry("gauss-transform", Report, Quick, &["core/src/lanes", "core/src/registration"],
        "The fast Gauss transform keeps the error that is asked for, in a time that grows with the number of points."),
    entry("registration", Report, Slow, &["core/src/geom", "core/src/registration", "core/src/sim"],
        "Which method finds the motion between two scans, how well, how fast, and whether it knows."),
    entry("degenerate", Report, Quick, &["core/src/geom", "core/src/registration", "core/src/sim"],
        "Every method says that a corridor tells nothing of the way along it, and only there."),
    entry("graphs", Report, Quick, &["core/src/lanes", "core/src/estimation", "core/src/format"],
        "Published pose graphs end where g2o ends, from the files' own poses, and what an update of one costs."),
    entry("grid", Report, Quick, GRID,
        "What the occupancy grid costs, sweep by sweep, and that its cells are right."),
    entry("distance", Report, Quick, GRID,
        "The distance transform is exact, and linear in the number of cells."),
    entry("vector-map", Report, Slow, CORE,
        "The vector map keeps a wall once, with its ends."),
    entry("planners", Report, Slow, &["core/src/geom", "core/src/map", "core/src/plan"],
        "Every planner solves what can be solved, without a collision, and says where there is no way."),
    entry("rounding", Report, Slow, CORE,
        "Corners driven round take less time than stops at them."),
    entry("safe-drive", Report, Slow, &["core/src/points", "core/src/control", "core/src/sim"],
        "Safe mode touches no wall and drives into nobody, whatever the stick says."),
    entry("crowd", Report, Slow, CORE,
        "A robot among people gets where it goes."),
    entry("people", Report, Slow, CORE,
        "A map gets as good among people as without them, and they are followed."),
    entry("kidnap", Report, Slow, CORE,
        "A robot that was carried off finds itself again, and so does one that begins anywhere in a map."),
    entry("ray-cast", Report, Quick, &["core/src/geom", "core/src/sim"],
        "How fast beams are cast among many walls."),
    entry("workloads", Workloads, Slow, CORE,
        "The peers' workloads on the peers' inputs."),
    entry("faults", Promise, Slow, FIRMWARE,
        "Whatever breaks, the motors lose their voltage in time; by the registers of the real firmware."),
    entry("latency", Promise, Slow, FIRMWARE,
        "From the robot to a client, alone and beside watchers."),
    entry("access", Promise, Slow, BRIDGE,
        "Who has no right to the robot is refused, and keeps nobody else from it."),
    entry("router", Promise, Slow, BRIDGE,
        "Robots at a Zenoh router are driven and stopped through it, and stop when it goes."),
    entry("fleet", Promise, Slow, FLEET,
        "Whoever is at a Zenoh router is seen by every bridge there within a second, and stopped from it."),
    entry("soak", Promise, Slow, BRIDGE,
        "Nothing grows with time."),
    entry("fuzz", Promise, Slow, &["core/src/wire", "core/src/format", "core/src/settings", "bridge/src"],
        "No decoder crashes on changed input."),
    entry("browser-cost", Promise, Slow, CORE,
        "An update of the line filter, a registration and a scan of scan matching are not much slower in the browser."),
    entry("page", Promise, Slow, &["www", "web/src", "core/src"],
        "The page is as light, as soon there, and as quick as is promised, and does not grow."),
    entry("page-frames", Promise, Quick, &["www", "web/src"],
        "The page has time for 60 pictures a second while a recorded building plays at 50 times its speed."),
    entry("sizes", Sizes, Quick, &["core/src", "web/src", "www"],
        "What the page weighs, in bytes: as it is, and as it is sent."),
];

const fn entry(
    name: &'static str,
    source: Source,
    takes: Takes,
    measures: &'static [&'static str],
    claim: &'static str,
) -> Entry {
    Entry {
        name,
        source,
        takes,
        measures,
        claim,
    }
}

impl Entry {
    /// Whether it takes less than two minutes, without compilation.
    pub(super) fn is_quick(&self) -> bool {
        self.takes == Quick
    }

    /// What to type; `DATA` is the folder of recorded data, `INPUTS` that of the peers' inputs.
    pub(super) fn command_line(&self) -> String {
        let example = "cargo run --release -p slamlab-core --example";
        let name = self.name;
        match self.source {
            Report => format!("{example} report -- {name}"),
            Promise => format!("cargo xtask report {name}"),
            Log(log) => format!(
                "{example} evaluate -- --log DATA/{log}.clf --relations DATA/{log}.relations --json"
            ),
            Workloads => format!(
                "{example} workloads -- --inputs INPUTS ekf_step rays split_and_merge grid plan"
            ),
            Sizes => "cargo xtask build && ls -l www/dist".into(),
        }
    }

    /// Measures, and returns the printed output.
    ///
    /// A command may report by its exit status that a claim does not hold: that is a result, too.
    pub(super) fn run(&self) -> Result<String> {
        if let Sizes = self.source {
            return sizes();
        }
        let line = self.command_line();
        eprintln!("$ {line}");
        let mut command = tools::cargo();
        for word in line.split(' ').skip(1) {
            match word.strip_prefix("DATA/") {
                Some(file) => command.arg(tools::data_folder().join(file)),
                None if word == "INPUTS" => command.arg(env::var_os("PEERS_INPUTS").context(
                    "the variable PEERS_INPUTS must name the folder of the peers' inputs",
                )?),
                None => command.arg(word),
            };
        }
        let output = command
            .stderr(Stdio::inherit())
            .output()
            .context("cannot start cargo")?;
        let text = String::from_utf8_lossy(&output.stdout).trim().to_owned();
        if text.is_empty() {
            bail!("`{line}` measured nothing ({})", output.status);
        }
        // The location of the data is irrelevant, and differs between machines.
        let data = tools::data_folder();
        let text = text.replace(&*data.to_string_lossy(), "DATA");
        match self.source {
            Log(_) => without_lists(&text),
            Report | Promise | Workloads | Sizes => Ok(text),
        }
    }
}

/// The figures of a log without its lists of hundreds of loops and stretches.
fn without_lists(text: &str) -> Result<String> {
    let mut figures: Value = serde_json::from_str(text).context("no JSON was printed")?;
    if let Some(quality) = figures.get_mut("quality").and_then(Value::as_object_mut) {
        quality.retain(|_, figure| !figure.is_array());
    }
    Ok(serde_json::to_string_pretty(&figures)?)
}

fn sizes() -> Result<String> {
    page::build(Profile::Release)?;
    let dist = tools::root().join("www/dist");
    let files = [
        "slamlab_web_bg.wasm",
        "slamlab_web_rest.wasm",
        "main.js",
        "worker.js",
        "slamlab_files_bg.wasm",
        "files.js",
        "slamlab_cable_bg.wasm",
        "local_bridge.js",
        "slamlab_lab_bg.wasm",
        "registration.js",
        "editor.js",
        "inspector.js",
        "plotter.js",
        "svg_context.js",
        "registration_worker.js",
    ];
    let mut lines = vec![];
    for name in files {
        let bytes = |ending: &str| {
            let file = dist.join(format!("{name}{ending}"));
            let facts = fs::metadata(&file);
            facts.with_context(|| format!("{} is missing", file.display()))
        };
        let [plain, br, gz] = [bytes("")?, bytes(".br")?, bytes(".gz")?].map(|facts| facts.len());
        lines.push(format!(
            "  \"{name}\": {{ \"plain\": {plain}, \"br\": {br}, \"gz\": {gz} }}"
        ));
    }
    Ok(format!("{{\n{}\n}}", lines.join(",\n")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_a_log_are_left_out_and_its_figures_stay() {
        let all = r#"{"scans": 3, "quality": {"agreement": 0.9, "loops": [{"at": 1.0}]}}"#;
        let found: Value = serde_json::from_str(&without_lists(all).unwrap()).unwrap();
        let figures = serde_json::json!({"scans": 3, "quality": {"agreement": 0.9}});
        assert_eq!(found, figures);
        assert!(without_lists("no JSON").is_err());
    }

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
