//! Every crash that fuzzing ever found, as a test; and a little fuzzing each time.
#![cfg(unix)]
#![allow(missing_docs)] // a test binary has no public interface
#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not count as tests

mod endpoints;

use std::path::Path;

use slamlab_tests::fuzz::{Run, Target, targets, try_one};

use endpoints::ENDPOINTS;

/// Number of inputs for each target, the same ones each time.
const INPUTS: u64 = 300;

#[test]
fn nothing_that_crashed_a_decoder_once_does_so_again() {
    for target in targets().chain(ENDPOINTS) {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("crashes")
            .join(target.name);
        // No crash was ever found in it.
        let Ok(files) = std::fs::read_dir(folder) else {
            continue;
        };
        for file in files {
            let path = file.unwrap().path();
            let input = std::fs::read(&path).unwrap();
            if let Err(crash) = try_one(target, &input) {
                panic!("{}: {}", path.display(), crash.what);
            }
        }
    }
}

#[test]
fn no_decoder_crashes_on_changed_input() {
    for target in targets().chain(ENDPOINTS) {
        let mut run = Run::new(target, 0);
        for _ in 0..INPUTS {
            run.step()
                .unwrap_or_else(|crash| panic!("{}: {:?}", crash.what, crash.input));
        }
        assert!(run.seen().outcomes > 2, "{}: {:?}", target.name, run.seen());
    }
}

#[test]
fn a_panic_and_a_broken_law_are_crashes() {
    fn seeds() -> Vec<Vec<u8>> {
        vec![b"abc".to_vec()]
    }
    let panics = Target {
        name: "panics",
        seeds,
        run: |input| Ok(u64::from(input[1])),
    };
    assert!(
        try_one(&panics, b"x")
            .unwrap_err()
            .what
            .contains("panicked")
    );
    let breaks = Target {
        name: "breaks",
        seeds,
        run: |_| Err("a law".into()),
    };
    assert_eq!(try_one(&breaks, b"x").unwrap_err().what, "breaks: a law");
}
