//! Fuzzes every decoder, and the messages of other tools to a bridge: [`slamlab_tests::fuzz`].
//!
//! `cargo xtask report fuzz --minutes 10`, or `... --example fuzz -- MINUTES [TARGET...]`; the
//! minutes are per target. Continues where the last run ended; prints JSON, and exits with 0 only
//! if nothing crashed. A crash is saved under `tests/crashes`.
#![allow(missing_docs, clippy::unwrap_used)] // a harness: failing is how it reports

#[cfg(unix)]
fn main() -> std::process::ExitCode {
    unix::main()
}

#[cfg(not(unix))]
fn main() {
    eprintln!("the devices that give the seeds need pseudo-terminals");
}

#[cfg(unix)]
#[path = "../tests/fuzz/endpoints.rs"]
mod endpoints;

#[cfg(unix)]
mod unix {
    use std::path::{Path, PathBuf};
    use std::process::ExitCode;
    use std::time::{Duration, Instant};

    use serde_json::{Map, Value, json};
    use slamlab_tests::fuzz::{Crash, Run, Target, targets};

    use crate::endpoints::ENDPOINTS;

    const HOME: &str = env!("CARGO_MANIFEST_DIR");

    pub(super) fn main() -> ExitCode {
        let mut words = std::env::args().skip(1);
        let minutes: f64 = words.next().map_or(10.0, |word| word.parse().unwrap());
        let wanted: Vec<String> = words.collect();
        let is_wanted = |target: &&'static Target| {
            wanted.is_empty() || wanted.iter().any(|name| name == target.name)
        };
        // Panics are expected here: one line for each is enough.
        std::panic::set_hook(Box::new(|info| eprintln!("{info}")));
        let mut figures = Map::new();
        let mut holds = true;
        for target in targets().chain(ENDPOINTS).filter(is_wanted) {
            let (is_sound, figure) = fuzz(target, Duration::from_secs_f64(60.0 * minutes));
            eprintln!("{}: {figure}", target.name);
            holds &= is_sound;
            figures.insert(target.name.into(), figure);
        }
        holds &= !figures.is_empty();
        let whole = json!({ "report": "fuzz", "holds": holds, "minutes_each": minutes, "figures": figures });
        println!("{}", serde_json::to_string_pretty(&whole).unwrap());
        ExitCode::from(u8::from(!holds))
    }

    fn fuzz(target: &'static Target, time: Duration) -> (bool, Value) {
        let state = state_file(target);
        let next = std::fs::read_to_string(&state).ok();
        let mut run = Run::new(
            target,
            next.and_then(|text| text.trim().parse().ok()).unwrap_or(0),
        );
        let (begun, mut saved) = (Instant::now(), Instant::now());
        let mut crash = None;
        while begun.elapsed() < time && crash.is_none() {
            crash = run.step().err();
            if saved.elapsed() > Duration::from_secs(5) || crash.is_some() {
                std::fs::write(&state, run.next().to_string()).unwrap();
                saved = Instant::now();
            }
        }
        std::fs::write(&state, run.next().to_string()).unwrap();
        let seen = run.seen();
        let saved = crash.as_ref().map(|crash| save(target, crash, run.next()));
        let figures = json!({
            "inputs": seen.inputs, "outcomes": seen.outcomes, "slowest_ms": seen.slowest.as_secs_f64() * 1e3,
            "crash": crash.as_ref().map(|crash| &crash.what), "saved": saved,
        });
        (crash.is_none(), figures)
    }

    fn state_file(target: &Target) -> PathBuf {
        let folder = Path::new(HOME).join("../target/fuzz");
        std::fs::create_dir_all(&folder).unwrap();
        folder.join(format!("{}.next", target.name))
    }

    fn save(target: &Target, crash: &Crash, number: u64) -> String {
        let folder = Path::new(HOME).join("crashes").join(target.name);
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join(format!("{number}.bin"));
        std::fs::write(&file, &crash.input).unwrap();
        format!("tests/crashes/{}/{number}.bin", target.name)
    }
}
