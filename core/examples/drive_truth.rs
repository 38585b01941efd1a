//! Drives the pilot in a built-in world with the true pose and a grid of simulated scans: planning and driving alone,
//! without the errors of an estimate.
//!
//! `cargo run --release -p slamlab-core --example drive_truth -- --world office --seeds 20 [--rangers] [--goal X,Y]`
//! prints a line for each seed: how it ended, simulated seconds, metres driven, explored fraction, contacts, and the
//! time that the pilot took for a tick.

use std::time::Duration;

use anyhow::{Context, Result, bail};
use clap::Parser;
use nalgebra::{Matrix3, Point2, Vector3};
use slamlab_core::geom::{Pose2, PoseEstimate};
use slamlab_core::map::{CellState, Grid, GridConfig};
use slamlab_core::pilot::{Mode, Pilot, PilotConfig, Situation};
use slamlab_core::points::{PointConfig, Points};
use slamlab_core::robot::Stamp;
use slamlab_core::sim::{SensorModel, Simulation, reachable_area, worlds};

/// Simulated time of one tick, s.
const TICK: f64 = 0.05;

#[derive(Parser)]
struct Arguments {
    /// Name of a built-in world.
    #[arg(long, default_value = "office")]
    world: String,
    /// First seed.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of seeds.
    #[arg(long, default_value_t = 1)]
    seeds: u64,
    /// Four infra-red rangers on a servo instead of a lidar.
    #[arg(long)]
    rangers: bool,
    /// Go to this point of the map frame, "X,Y" in m, instead of exploring.
    #[arg(long)]
    goal: Option<String>,
    /// Give up after this simulated time, s.
    #[arg(long, default_value_t = 1800.0)]
    limit: f64,
    /// Standard deviation that the pilot is told its position has, m.
    #[arg(long, default_value_t = 0.01)]
    sigma: f64,
    /// Say what the pilot does whenever it changes.
    #[arg(long)]
    verbose: bool,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let mode = match &arguments.goal {
        None => Mode::Explore,
        Some(text) => {
            let (x, y) = text.split_once(',').context("--goal: expected X,Y")?;
            Mode::GoTo(Point2::new(x.trim().parse()?, y.trim().parse()?))
        }
    };
    for seed in arguments.seed..arguments.seed + arguments.seeds {
        run(&arguments, mode, seed)?;
    }
    Ok(())
}

fn run(arguments: &Arguments, mode: Mode, seed: u64) -> Result<()> {
    let Some(world) = worlds::builtin(&arguments.world) else {
        bail!(
            "no world {:?}; there are {:?}",
            arguments.world,
            worlds::NAMES
        );
    };
    let model = world.robot.model();
    let (sensor, grid) = if arguments.rangers {
        (SensorModel::rangers(), GridConfig::celej())
    } else {
        (SensorModel::lidar(), GridConfig::default())
    };
    let mut sim = Simulation::new(world, model, sensor, seed)?;
    let start = sim.world().start;
    let mut grid = Grid::new(grid)?;
    let mut pilot = Pilot::new(model, PilotConfig::default(), seed);
    pilot.set_mode(mode);
    let (mut points, mut scanned_at) = (None::<Points>, Pose2::identity());
    let (mut driven, mut last) = (0.0, sim.truth());
    let (mut spent, mut slowest, mut ticks) = (Duration::ZERO, Duration::ZERO, 0_u32);
    let mut contacts = 0;
    while sim.stamp().seconds() < arguments.limit && !pilot.status().is_over() {
        while let Some(scan) = sim.take_scan() {
            let begin = Stamp::from_seconds(scan.stamp.seconds() - scan.sweep);
            let end = sim.truth_at(scan.stamp).unwrap_or(sim.truth());
            let motion = sim.truth_at(begin).unwrap_or(end).delta_to(&end);
            let seen = Points::from_scan(&scan, &motion, &PointConfig::default());
            scanned_at = start.inverse() * end;
            grid.insert(&seen, &scanned_at);
            points = Some(seen);
        }
        let pose = start.inverse() * sim.truth();
        let variance = arguments.sigma * arguments.sigma;
        let estimate = PoseEstimate {
            pose,
            cov: Matrix3::from_diagonal(&Vector3::new(variance, variance, 1e-5)),
        };
        let (before, goal) = (elapsed(), pilot.goal());
        let was = pilot.status().clone();
        let command = pilot.steer(&Situation {
            stamp: sim.stamp(),
            estimate: &estimate,
            grid: &grid,
            points: points.as_ref(),
            walkers: &[],
            motion_since_scan: scanned_at.delta_to(&pose),
            heading_drift: 0.0,
            speeds: sim.speeds(),
            bumpers: sim.bumpers(),
            robot_is_busy: sim.is_busy(),
            scans_on_command: arguments.rangers,
        });
        let took = elapsed() - before;
        spent += took;
        slowest = slowest.max(took);
        let is_news = was != *pilot.status() || goal != pilot.goal() || contacts != sim.contacts();
        if arguments.verbose && is_news {
            println!(
                "{:7.2} s at ({:.2}, {:.2}): {}, goal {:?}, contacts {}, {command:?}",
                sim.stamp().seconds(),
                pose.x(),
                pose.y(),
                pilot.status(),
                pilot.goal().map(|g| (g.x, g.y)),
                sim.contacts(),
            );
        }
        contacts = sim.contacts();
        if let Some(command) = command {
            sim.command(command);
        }
        sim.advance(TICK);
        driven += (sim.truth().position() - last.position()).norm();
        last = sim.truth();
        ticks += 1;
    }
    let area = reachable_area(sim.world(), model.radius(), grid.resolution());
    let known =
        |p: Point2<f64>| grid.state(grid.cell_at(start.inverse() * p)) != CellState::Unknown;
    println!(
        "{} seed {seed}: {}; {:.0} s, {driven:.1} m, explored {:.4}, contacts {}, pilot {:.1} us a tick, slowest {:.1} ms",
        arguments.world,
        pilot.status(),
        sim.stamp().seconds(),
        area.known_fraction(known),
        sim.contacts(),
        spent.as_secs_f64() / f64::from(ticks.max(1)) * 1e6,
        slowest.as_secs_f64() * 1e3,
    );
    Ok(())
}

/// Time since the first call. Core has no clock of its own; an example may look at one.
#[allow(clippy::disallowed_methods)] // the figures printed are about time
fn elapsed() -> Duration {
    use std::sync::OnceLock;
    use std::time::Instant;
    static BEGIN: OnceLock<Instant> = OnceLock::new();
    BEGIN.get_or_init(Instant::now).elapsed()
}
