//! `safe-drive`: does safe mode keep the robot from hitting anything, whatever the joystick
//! commands? About 10 min for 10 000 trials.
//!
//! 1. A trial is a random scene ([`scene`]): walls, a door little wider than the robot, people who
//!    walk, or a built-in world; an RP6 or a Pioneer; safe mode as in the laboratory's pilot, or as
//!    in the bridge.
//! 2. The stick is pushed all the way for six seconds; in a quarter of the trials the lidar falls
//!    silent meanwhile ([`trial`]).
//! 3. No contact with a wall; none with a person, except those who walk into a standing robot. The
//!    robot can turn on the spot afterwards and leave if there is a way out; without scans it
//!    stands after half a second plus its braking time.
//!
//! Failing seeds are named: `--first-seed N --trials 1` repeats one of them.

mod scene;
mod trial;

use anyhow::Result;
use serde_json::json;

use super::{Args, Outcome};
use scene::{KINDS, Scene};
use trial::Shown;

const TRIALS: u64 = 10_000;
/// Maximum number of seeds named for each failure.
const NAMED: usize = 20;

/// A fault that must not happen, and how it is detected.
type Fault = (&'static str, fn(&Shown) -> bool);

const FAULTS: [Fault; 5] = [
    ("drove_into_wall", |it| it.contacts.walls > 0),
    ("drove_into_person", |it| it.contacts.drove_into_mover > 0),
    ("could_not_turn", |it| it.could_not_turn),
    ("could_not_leave", |it| it.could_not_leave),
    ("ran_without_scans", |it| it.ran_blind),
];

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let trials = args.trials.unwrap_or(TRIALS);
    let mut outcome = Outcome::default();
    let mut kinds = [0_u64; KINDS.len()];
    let (mut driven, mut silent, mut ways_out, mut walked_in) = (0.0, 0_u64, 0_u64, 0_u64);
    let mut seeds: [Vec<u64>; FAULTS.len()] = Default::default();
    for seed in args.first_seed..args.first_seed.saturating_add(trials) {
        let scene = Scene::drawn(seed);
        let shown = trial::drive(&scene, seed)?;
        kinds[scene.kind] += 1;
        driven += shown.driven;
        silent += u64::from(shown.was_silent);
        ways_out += u64::from(shown.had_way_out);
        walked_in += u64::from(shown.contacts.mover_walked_in > 0);
        for ((_, has), seeds) in FAULTS.iter().zip(&mut seeds) {
            if has(&shown) {
                seeds.push(seed);
            }
        }
    }
    let by_kind: serde_json::Map<_, _> = (KINDS.iter().zip(kinds))
        .map(|(kind, count)| ((*kind).to_owned(), json!(count)))
        .collect();
    outcome.figure("trials", trials);
    outcome.figure("trials_by_kind", by_kind);
    outcome.figure("trials_with_silent_lidar", silent);
    outcome.figure("trials_with_a_way_out", ways_out);
    outcome.figure("trials_in_which_a_person_walked_into_the_robot", walked_in);
    outcome.figure("driven_under_the_stick_m_mean", driven / trials as f64);
    for ((name, _), seeds) in FAULTS.iter().zip(&seeds) {
        outcome.at_most(&format!("trials_{name}"), seeds.len() as f64, 0.0);
        if !seeds.is_empty() {
            let named: Vec<u64> = seeds.iter().copied().take(NAMED).collect();
            outcome.figure(format!("seeds_{name}"), json!(named));
        }
    }
    Ok(outcome)
}
