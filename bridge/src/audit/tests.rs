//! The entries of the audit, and that it stays within its budget.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use slamlab_core::wire::message::{DisarmReason, Right, Role, SafetyBody};
use tempfile::TempDir;

use super::*;
use crate::access_log::Peer;

fn who(client: u32, name: &str, role: Role) -> Who {
    let right = Right {
        role,
        name: name.to_owned(),
    };
    Who::new(
        client,
        &right,
        "phone",
        Peer::At(([192, 168, 1, 7], 40_000).into()),
    )
}

fn start(folder: &Path, keep: Keep, clock: Clock) -> Result<Audit, RecordError> {
    Audit::start(Files::audits(folder, keep, clock)?)
}

fn lines(folder: &Path) -> Vec<Value> {
    let mut files: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    let text: String = files
        .iter()
        .map(|file| fs::read_to_string(file).unwrap())
        .collect();
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

#[test]
fn a_drive_is_told_from_its_lease_to_its_stop() {
    let (anna, wall) = (who(3, "anna", Role::Driver), who(4, "", Role::Watcher));
    let state = |driver, armed, emergency, reason| SafetyBody {
        driver,
        driver_name: String::new(),
        armed,
        emergency,
        reason,
    };
    let mut story = Story::default();
    let at = Duration::from_secs;
    let mut goes_on = |now, state: SafetyBody, by: &Who| {
        let driver = state.driver.map(|_| anna.clone());
        story.goes_on(at(now), &state, Some(by), driver)
    };
    let out = goes_on(1, state(Some(3), false, false, DisarmReason::Start), &anna);
    assert_eq!(out, [What::Lease { who: anna.clone() }]);
    let out = goes_on(2, state(Some(3), true, false, DisarmReason::Start), &anna);
    assert_eq!(out, [What::Drives { who: anna.clone() }]);
    let pressed = DisarmReason::EmergencyStop;
    let out = goes_on(9, state(Some(3), false, true, pressed), &wall);
    let stops = What::Stops {
        who: Some(anna.clone()),
        cause: pressed,
        by: Some(wall.clone()),
        after_seconds: 7.0,
    };
    let by = Some(wall);
    let cut = What::EmergencyStop { cause: pressed, by };
    assert_eq!(out, [stops, cut]);
    let out = goes_on(10, state(Some(3), false, false, pressed), &anna);
    let by = Some(anna.clone());
    assert_eq!(out, [What::EmergencyReset { by }]);
    let out = goes_on(11, state(None, false, false, DisarmReason::Released), &anna);
    assert_eq!(out, [What::LeaseEnds { who: anna.clone() }]);
}

#[test]
fn every_line_is_json_with_the_time_of_day_and_who() {
    let folder = TempDir::new().unwrap();
    let clock = Clock::start();
    let audit = start(folder.path(), keep(8), clock).unwrap();
    let anna = who(3, "anna", Role::Driver);
    audit.note(clock.now(), &What::Lease { who: anna });
    let nobody = who(4, "", Role::Watcher);
    audit.note(clock.now(), &What::StopAgain { by: nobody });
    audit.finish();
    let lines = lines(folder.path());
    let what: Vec<_> = lines
        .iter()
        .map(|line| line["what"].as_str().unwrap())
        .collect();
    assert_eq!(what, ["begins", "lease", "stop-again", "ends"]);
    let who = &lines[1]["who"];
    assert_eq!(
        *who,
        serde_json::json!({
            "client": 3, "name": "anna", "role": "driver", "calls_itself": "phone", "from": "192.168.1.7:40000",
        })
    );
    assert!(lines[2]["by"].get("name").is_none());
    for line in &lines {
        let at = line["at"].as_str().unwrap();
        assert!(at.parse::<toml::value::Datetime>().is_ok(), "{at}");
    }
}

#[test]
fn the_oldest_files_go_when_the_budget_is_full() {
    let folder = TempDir::new().unwrap();
    let clock = Clock::start();
    let small = Keep {
        piece_bytes: 10_000,
        all_bytes: 60_000,
        ..keep(1)
    };
    fs::write(folder.path().join("notes.jsonl"), "mine").unwrap();
    let audit = start(folder.path(), small, clock).unwrap();
    for client in 0..900 {
        let who = who(client, "anna", Role::Driver);
        audit.note(clock.now(), &What::Lease { who });
    }
    audit.finish();
    assert!(folder.path().join("notes.jsonl").exists());
    fs::remove_file(folder.path().join("notes.jsonl")).unwrap();
    let bytes: u64 = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().metadata().unwrap().len())
        .sum();
    assert!((30_000..=85_000).contains(&bytes), "{bytes} B");
    let clients: Vec<u64> = lines(folder.path())
        .iter()
        .filter_map(|line| line["who"]["client"].as_u64())
        .collect();
    assert!(
        clients.contains(&899) && !clients.contains(&0),
        "the newest stay"
    );
}

#[test]
fn a_folder_that_cannot_be_is_said() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("file");
    fs::write(&path, "precious").unwrap();
    let error = start(&path, keep(1), Clock::start()).unwrap_err();
    assert!(error.to_string().contains("file"), "{error}");
    assert_eq!(fs::read(&path).unwrap(), b"precious");
}
