//! `graphs`: published pose graphs, optimised from the files' own poses. Seconds.
//!
//! 1. `intel.g2o` and `m3500.g2o` of the recorded data (`--data`) end at the same χ² as in g2o.
//! 2. The cost of one update: the last poses of `m3500.g2o` arrive one by one, with their edges,
//!    and the graph is optimised after each; and the cost of covariances, from the newest pose
//!    alone to all.
//! 3. With `--peers FILE`, from the same machine and hour: the same χ² as in the lines of g2o and
//!    GTSAM, in at most half of g2o's time. Ours is the median of some runs, each with a new
//!    elimination order. FILE has lines `peer workload median_ms chi2=…` of peers that begin with
//!    `g2o` and `gtsam`, for the workloads `posegraph_intel` and `posegraph_m3500`. Of g2o's lines
//!    the fastest counts that ends where the best of them does; of GTSAM's the best. GTSAM takes
//!    the logarithm of an error, g2o its (x, y, θ): their χ² agree only as far as errors are small,
//!    and are compared accordingly. Ours may be below GTSAM's: an edge of `intel.g2o` (from 160 to
//!    161, where the robot turned on the spot) has an information of 2.7e12 along one axis, and
//!    GTSAM 4.3 does not solve that file even from the minimum.

use std::path::Path;

use anyhow::{Context, Result};
use slamlab_core::estimation::PoseGraph;
use slamlab_core::format::g2o;

use crate::clock::cpu_seconds;
use crate::peers::Peers;
use crate::statistics::{median, quantile};
use crate::{Args, Outcome};

/// Name of the file, and χ² of g2o-python 0.0.12 after 20 steps of Gauss-Newton.
const GRAPHS: [(&str, f64); 2] = [("intel", 215.830_235), ("m3500", 137.912_951)];
/// The graph that grows, and how many of its poses arrive one by one.
const GROWS: &str = "m3500";
const UPDATES: usize = 100;
const RUNS: usize = 11;
const MOST_ITERATIONS: usize = 100;
/// Maximum relative difference of χ² from g2o's, and from GTSAM's.
const AS_G2O: f64 = 1e-6;
const AS_GTSAM: f64 = 1e-4;
/// Maximum time, as a fraction of g2o's.
const MOST_TIME: f64 = 0.5;

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let mut outcome = Outcome::default();
    let folder = args.data();
    let peers = args.peers.as_deref().map(Peers::read).transpose()?;
    for (name, expected) in GRAPHS {
        let graph = read(&folder.join(format!("posegraphs/{name}.g2o")))?;
        let (ms, chi2) = solve(&mut outcome, name, &graph);
        outcome.at_most(
            &format!("{name}_chi2_off_known"),
            (chi2 - expected).abs() / expected,
            AS_G2O,
        );
        if let Some(peers) = &peers {
            against_peers(&mut outcome, name, ms, chi2, peers)?;
        }
        if name == GROWS {
            grow(&mut outcome, name, &graph)?;
        }
    }
    if peers.is_none() {
        outcome.figure("peers", "not compared: no --peers FILE");
    }
    Ok(outcome)
}

fn read(path: &Path) -> Result<PoseGraph> {
    let name = || format!("graph {}", path.display());
    let bytes = std::fs::read(path).with_context(name)?;
    let file = g2o::parse(&bytes).with_context(name)?;
    file.to_pose_graph().with_context(name)
}

/// Point 1: the median time, ms, and χ².
fn solve(outcome: &mut Outcome, name: &str, graph: &PoseGraph) -> (f64, f64) {
    let mut times = vec![];
    let mut solved = graph.clone();
    for _ in 0..=RUNS {
        solved = graph.clone();
        let begin = cpu_seconds();
        let found = solved.optimize_with_figures(MOST_ITERATIONS);
        times.push(1e3 * (cpu_seconds() - begin));
        outcome.figure(format!("{name}_iterations"), found.iterations);
        outcome.require(found.converged, || format!("{name} does not converge"));
    }
    // The first run warms up.
    let ms = median(&times[1..]);
    outcome.figure(format!("{name}_poses"), graph.poses().len());
    outcome.figure(format!("{name}_edges"), graph.edges().len());
    outcome.figure(format!("{name}_chi2_before"), graph.chi2());
    outcome.figure(format!("{name}_chi2"), solved.chi2());
    outcome.figure(format!("{name}_ms"), ms);
    (ms, solved.chi2())
}

/// Point 3.
fn against_peers(
    outcome: &mut Outcome,
    name: &str,
    ms: f64,
    chi2: f64,
    peers: &Peers,
) -> Result<()> {
    let workload = format!("posegraph_{name}");
    let best = |peer: &str| -> Result<f64> {
        let found = peers.all(&workload, peer, "chi2").map(|(_, chi2)| chi2);
        found
            .min_by(f64::total_cmp)
            .with_context(|| format!("no line of `{peer}` with chi2= for {workload}"))
    };
    let mut off = |peer: &str| -> Result<f64> {
        let theirs = best(peer)?;
        outcome.figure(format!("{name}_chi2_{peer}"), theirs);
        Ok((chi2 - theirs) / theirs)
    };
    let [off_g2o, off_gtsam] = [off("g2o")?, off("gtsam")?];
    outcome.at_most(&format!("{name}_chi2_off_g2o"), off_g2o.abs(), AS_G2O);
    outcome.at_most(&format!("{name}_chi2_above_gtsam"), off_gtsam, AS_GTSAM);
    let good = best("g2o")? * (1.0 + AS_G2O);
    let fast = peers.all(&workload, "g2o", "chi2");
    let fast = fast.filter(|(_, chi2)| *chi2 <= good).map(|(ms, _)| ms);
    let theirs = fast.min_by(f64::total_cmp).unwrap_or(f64::NAN);
    outcome.figure(format!("{name}_ms_g2o"), theirs);
    outcome.at_most(&format!("{name}_time_in_g2o"), ms / theirs, MOST_TIME);
    Ok(())
}

/// Point 2.
fn grow(outcome: &mut Outcome, name: &str, whole: &PoseGraph) -> Result<()> {
    let mut solved = whole.clone();
    solved.optimize(MOST_ITERATIONS);
    let count = solved.poses().len();
    let begun = count.saturating_sub(UPDATES).max(1);
    let mut graph = PoseGraph::default();
    let mut times = vec![];
    let mut iterations = vec![];
    for (index, pose) in solved.poses().iter().enumerate() {
        let mut edges = whole.edges().iter().filter(|e| e.from.max(e.to) == index);
        // Until the graph reaches its initial size, the optimised pose; then the pose that the
        // motion from the last pose leads to.
        let step = edges.clone().find(|e| e.from + 1 == index);
        let ahead = step.and_then(|e| Some(*graph.poses().get(e.from)? * e.motion));
        graph.add_pose(ahead.filter(|_| index >= begun).unwrap_or(*pose));
        edges
            .try_for_each(|edge| graph.add_edge(*edge).map(|_| ()))
            .context("an edge is refused")?;
        if index + 1 == begun {
            graph.optimize(MOST_ITERATIONS);
        }
        if index >= begun {
            let begin = cpu_seconds();
            let found = graph.optimize_with_figures(MOST_ITERATIONS);
            times.push(1e3 * (cpu_seconds() - begin));
            iterations.push(found.iterations as f64);
        }
    }
    outcome.figure(format!("{name}_update_median_ms"), median(&times));
    outcome.figure(format!("{name}_update_p95_ms"), quantile(&times, 0.95));
    outcome.figure(format!("{name}_update_iterations"), median(&iterations));
    let off = (graph.chi2() - solved.chi2()).abs() / solved.chi2();
    outcome.at_most(&format!("{name}_chi2_off_grown"), off, AS_G2O);
    let begin = cpu_seconds();
    let marginals = graph.marginals().context("a pose hangs on nothing")?;
    let known = marginals.relative_covs(count - 1).len();
    let ms = 1e3 * (cpu_seconds() - begin);
    outcome.figure(format!("{name}_relative_covariances"), known);
    outcome.figure(format!("{name}_relative_covariances_ms"), ms);
    Ok(())
}
