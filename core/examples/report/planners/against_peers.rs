//! Our planners against OMPL's and pyastar2d's, on the peers' queries: the allowed time in the
//! median, no more than the peer's time in the mean and in the 95th percentile, every query solved,
//! and paths no longer.

use anyhow::Result;

use crate::outcome::Outcome;
use crate::peers::{Peers, Race};

const PER_QUERY: &str = "plan_office_per_query";

/// Ours, OMPL's, and the allowed fraction of its time. Paths of RRT-Connect are shortened, which
/// takes part of the time.
const RACES: [(&str, &str, f64); 2] = [
    ("RRTConnect,shortened", "RRTConnect", 0.5),
    ("RRTstar2000", "RRTstar2000", 0.2),
];

pub(super) fn compare(outcome: &mut Outcome, peers: &Peers) -> Result<()> {
    for (planner, theirs, at_most) in RACES {
        let (ours, theirs) = (format!("slamlab-{planner}"), format!("ompl-1.5.2-{theirs}"));
        let race = Race {
            workload: PER_QUERY,
            ours: &ours,
            theirs: &theirs,
            at_most,
        };
        peers.race(outcome, &race)?;
        for name in ["mean_ms", "p95_ms"] {
            let our_ms = peers.extra(PER_QUERY, &ours, name)?;
            let their_ms = peers.extra(PER_QUERY, &theirs, name)?;
            let key = format!("{planner}_{name}");
            outcome.at_most(&format!("{key}_in_peers"), our_ms / their_ms, 1.0);
            outcome.figure(key, vec![our_ms, their_ms]);
        }
        let solved = peers.extra(PER_QUERY, &ours, "ok")?;
        outcome.at_least(&format!("{planner}_solved_percent"), solved, 100.0);
        let length = peers.extra(PER_QUERY, &ours, "len/straight")?;
        let most = peers.extra(PER_QUERY, &theirs, "len/straight")?;
        outcome.at_most(&format!("{planner}_length_in_straight"), length, most);
    }
    let cells = Race {
        workload: "astar_grid1000_per_query",
        ours: "slamlab-AStar",
        theirs: "pyastar2d",
        at_most: 1.0,
    };
    peers.race(outcome, &cells)
}
