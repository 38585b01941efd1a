//! Everything that the doctor says can be found in the guide word for word.

use slamlab_core::wire::rp6::{self, Down};
use slamlab_core::wire::rplidar::request::Request;

use super::*;
use crate::serial::{LineError, OpenError};
use slamlab_core::device::ld06::Ld06Fault;
use slamlab_core::device::rp6::words as rp6_words;
use slamlab_core::device::rplidar::{RplidarFault, warning};

const GUIDE: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/GUIDE.md"));

/// Stands in the guide for the system's own words, and for lists that a new device extends.
const SYSTEM: &str = "…";

/// The rows of the table: what is said, cause, cure.
fn rows() -> Vec<[&'static str; 3]> {
    let (_, table) = GUIDE.split_once("## What the doctor says").unwrap();
    let table = table.split("\n## ").next().unwrap();
    let cells = |line: &'static str| {
        let cells: Vec<_> = line.trim_matches('|').split(" | ").map(str::trim).collect();
        <[&str; 3]>::try_from(cells).unwrap_or_else(|cells| panic!("{cells:?}"))
    };
    let lines = table.lines().filter(|line| line.starts_with("| "));
    lines.skip(1).map(cells).collect()
}

fn ports() -> Vec<String> {
    let path = || "/dev/rplidar".to_owned();
    let (serial, detail) = (|| "/dev/serial0".to_owned(), || SYSTEM.to_owned());
    let all = [
        OpenError::NotFound { path: path() },
        OpenError::Permission { path: path() },
        OpenError::Busy { path: path() },
        OpenError::Settings {
            path: serial(),
            baud_rate: 38_400,
            detail: detail(),
        },
        OpenError::Other {
            path: serial(),
            detail: detail(),
        },
    ];
    // A new variant does not compile here until it is in the list above, and in the guide.
    for error in &all {
        match error {
            OpenError::NotFound { .. }
            | OpenError::Permission { .. }
            | OpenError::Busy { .. }
            | OpenError::Settings { .. }
            | OpenError::Other { .. } => (),
        }
    }
    let lines = [
        LineError::Gone,
        LineError::Failed(detail()),
        LineError::Stuck,
    ];
    for error in &lines {
        match error {
            LineError::Gone | LineError::Failed(_) | LineError::Stuck => (),
        }
    }
    let all = all.iter().map(ToString::to_string);
    all.chain(lines.iter().map(ToString::to_string)).collect()
}

fn robots() -> Vec<String> {
    let links = [
        Down::Silence,
        Down::Unanswered,
        Down::Restarted,
        Down::EmergencyShutdown,
        Down::NobodyThere,
        Down::OtherProtocol(2),
        Down::Closed,
    ];
    let faults = [
        rp6::Fault::LeftEncoder,
        rp6::Fault::RightEncoder,
        rp6::Fault::Overcurrent,
        rp6::Fault::BatteryLow,
        rp6::Fault::Other(9),
    ];
    let links = links.into_iter().map(rp6_words::cause_and_cure);
    let faults = faults
        .into_iter()
        .map(|fault| rp6_words::fault_and_cure(fault).to_owned());
    let others = [rp6_words::NO_PROGRAM, rp6_words::BOOT_LOADER].map(str::to_owned);
    links.chain(faults).chain(others).collect()
}

fn lidars() -> Vec<String> {
    let (request, bytes) = (Request::Info, 4711);
    let a1 = [
        RplidarFault::NoAnswer { request },
        RplidarFault::NotUnderstood { request, bytes },
        RplidarFault::Protection { error: 0x8001 },
        RplidarFault::NoReadings,
        RplidarFault::Silent,
        RplidarFault::DoesNotTurn,
    ];
    let ld06 = [
        Ld06Fault::Silent,
        Ld06Fault::NotUnderstood { bytes },
        Ld06Fault::DoesNotTurn,
    ];
    // Which request it was means nothing to people.
    let a1 = a1
        .iter()
        .map(|fault| fault.to_string().replace(&format!("{request:?}"), SYSTEM));
    let ld06 = ld06.iter().map(ToString::to_string);
    a1.chain(ld06).chain([warning(1)]).collect()
}

fn its_own() -> Vec<String> {
    let measured = Measured {
        damaged: 12,
        seconds: 2.0,
        ..Measured::default()
    };
    vec![
        SENDS_NOTHING.into(),
        nothing_answers(SYSTEM, SYSTEM),
        unknown(4711, SYSTEM),
        speaks_text(38_400, SYSTEM),
        noisy(&measured),
    ]
}

#[test]
fn lists_of_kinds_are_those_of_the_table() {
    assert_eq!(rates(), "38400, 230400 or 115200");
    assert_eq!(
        rates_of_kinds(),
        "38400 (RP6), 230400 (LD06) and 115200 (RPLIDAR)"
    );
    assert_eq!(listeners(), "LD06");
}

#[test]
fn all_that_the_doctor_says_stands_in_the_guide_with_a_cure() {
    let rows = rows();
    let all = [ports(), robots(), lidars(), its_own()].concat();
    for words in &all {
        let row = rows.iter().find(|row| row[0] == words);
        let row = row.unwrap_or_else(|| panic!("the guide does not say: {words}"));
        assert!(!row[2].is_empty(), "no cure for: {words}");
    }
    for row in &rows {
        assert!(
            all.iter().any(|words| words == row[0]),
            "nobody says: {}",
            row[0]
        );
    }
}
