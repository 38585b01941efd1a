//! tmp
#![allow(
    clippy::all,
    clippy::disallowed_methods,
    missing_docs,
    clippy::unwrap_used
)]
#[path = "shared/log_file.rs"]
mod log_file;
use slamlab_core::replay::Replay;
use slamlab_core::slam::Method;
fn main() {
    let path = std::path::PathBuf::from(std::env::args().nth(1).unwrap());
    let log = log_file::read(&path).unwrap();
    let settings = log.settings();
    let mut replay = Replay::new(log, Method::ScanMatching, &settings).unwrap();
    while replay.step().unwrap() {}
    let map = replay.session().slam().view().map.unwrap();
    let mut first = std::collections::BTreeMap::new();
    for (s, sub, _) in map.scans_in_submaps() {
        first.entry(sub).or_insert(s.seconds());
    }
    for r in map.closure_records() {
        let p = map.graph().poses();
        let now = p[r.old].delta_to(&p[r.new]);
        let off = now.delta_to(&r.motion);
        println!(
            "{} ({:.0}s) <- {} ({:.0}s) searched {} overlap {:.2} part {:.2} worth {:.2} doubt {:.2} {:.3} off ({:.2} {:.2} {:.3}) proof {:?} {:?}",
            r.old,
            first.get(&r.old).unwrap_or(&-1.0),
            r.new,
            first.get(&r.new).unwrap_or(&-1.0),
            r.is_searched,
            r.overlap,
            r.part,
            r.worth,
            r.doubt.shift,
            r.doubt.turn,
            off.x(),
            off.y(),
            off.heading(),
            r.proof.map(|p| (p.evidence, p.asked, p.rival)),
            r.fate
        );
    }
}
