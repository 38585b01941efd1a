//! Memory of an exploration: which frontier is being explored, and which were given up.
//!
//! A frontier is finished when no way leads there, when it is still there after a scan from its
//! goal, or for lack of gain: when `scans_per_frontier` scans of its place (with the robot near its
//! goal) removed less than a tenth of what it promised. A frontier that was only seen from afar is
//! not given up for lack of gain, or only after many more times. One that grew by half is worth
//! another scan.

use nalgebra::Point2;

use crate::geom::Length;
use crate::map::{CellIndex, CellState, Grid};
use crate::plan::Frontier;

/// Frontiers nearer than this to one another are the same place, m.
const SAME_PLACE: f64 = 0.4;
/// A target has vanished when less than this fraction of its cells is still frontier.
const STILL_THERE: f64 = 0.25;
/// A frontier has been scanned once the robot was this near to its goal, m.
const SCANNED_FROM: f64 = 0.5;
/// A scan was worth it when it removed this fraction of what the frontier promised.
const WORTH: f64 = 0.1;
/// Factor between the targets and the scans that a place may have: some targets vanish when seen
/// from afar, and come back.
const TARGETS_PER_SCAN: usize = 5;

/// Chooses frontiers and remembers the results.
#[derive(Clone, Debug, Default)]
pub(super) struct Explorer {
    /// All frontiers as of the last search, best first.
    pub(super) frontiers: Vec<Frontier>,
    /// The frontier that is being explored.
    pub(super) target: Option<Frontier>,
    given_up: Vec<GivenUp>,
    places: Vec<Place>,
}

/// Why a frontier is no longer a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reason {
    /// No way leads there.
    NoWay,
    /// Scans of it showed nothing new.
    NoGain,
}

#[derive(Clone, Debug)]
struct GivenUp {
    frontier: Frontier,
    reason: Reason,
}

/// Where a target was, and what its scans brought since its promise last fell.
#[derive(Clone, Copy, Debug)]
struct Place {
    at: Point2<f64>,
    /// The least that was promised there, m².
    gain: f64,
    is_scanned: bool,
    scans: usize,
    targets: usize,
}

impl Explorer {
    /// Takes the frontiers that were found, and picks the best that was not given up. A frontier of
    /// which `most_scans` standing scans showed nothing is given up.
    pub(super) fn choose(
        &mut self,
        found: Vec<Frontier>,
        most_scans: usize,
    ) -> Option<Point2<f64>> {
        self.frontiers = found;
        self.target = None;
        for candidate in self.frontiers.clone() {
            let Some(goal) = candidate
                .goal
                .filter(|_| self.why_not(&candidate).is_none())
            else {
                continue;
            };
            self.target = Some(candidate);
            if self.is_worth_another_scan(most_scans) {
                return Some(goal);
            }
            self.give_up(Reason::NoGain);
        }
        None
    }

    /// Gives the target up: it cannot be reached, or did not vanish when scanned.
    pub(super) fn give_up(&mut self, reason: Reason) {
        let target = self.target.take();
        self.given_up
            .extend(target.map(|frontier| GivenUp { frontier, reason }));
    }

    /// Whether the target is no frontier any more.
    pub(super) fn target_has_vanished(&self, grid: &Grid) -> bool {
        let Some(target) = &self.target else {
            return true;
        };
        let remaining = target.cells.iter().filter(|&&c| is_frontier(grid, c));
        (remaining.count() as f64) < STILL_THERE * target.cells.len() as f64
    }

    /// Notes that the robot is here, on its way to the target.
    pub(super) fn pass(&mut self, here: Point2<f64>) {
        let Some(target) = &self.target else { return };
        let is_near = |goal: Point2<f64>| (goal - here).length() < SCANNED_FROM;
        if target.goal.is_some_and(is_near)
            && let Some(place) = place_of(&mut self.places, target)
        {
            place.is_scanned = true;
        }
    }

    /// Centres of the frontiers that stay unknown for this reason. A frontier to which no way was
    /// ever searched for counts as [`Reason::NoWay`].
    pub(super) fn remaining(&self, reason: Reason) -> Vec<Point2<f64>> {
        let why = |f: &&Frontier| self.why_not(f).unwrap_or(Reason::NoWay) == reason;
        let remaining = self.frontiers.iter().filter(why);
        remaining.map(|f| f.centre).collect()
    }

    /// Whether a frontier was not given up.
    pub(super) fn is_open(&self, frontier: &Frontier) -> bool {
        self.why_not(frontier).is_none()
    }

    /// Why a frontier was given up; one that grew is worth another scan.
    fn why_not(&self, frontier: &Frontier) -> Option<Reason> {
        let is_it = |old: &&GivenUp| {
            (old.frontier.centre - frontier.centre).length() < SAME_PLACE
                && frontier.gain < 1.5 * old.frontier.gain
        };
        self.given_up.iter().find(is_it).map(|old| old.reason)
    }

    /// Counts the target, and the scan of it if there was one since the last call; the count starts
    /// again if the last scan was worth it. Promises fall by a fraction each time and places have a
    /// size, so exploration ends.
    fn is_worth_another_scan(&mut self, most_scans: usize) -> bool {
        let Some(target) = &self.target else {
            return false;
        };
        let Some(place) = place_of(&mut self.places, target) else {
            self.places.push(Place {
                at: target.centre,
                gain: target.gain,
                is_scanned: false,
                scans: 0,
                targets: 0,
            });
            return true;
        };
        if target.gain < (1.0 - WORTH) * place.gain {
            place.gain = target.gain;
            (place.scans, place.targets) = (0, 0);
        } else {
            place.scans += usize::from(place.is_scanned);
            place.targets += 1;
        }
        place.is_scanned = false;
        let is_worth = place.scans < most_scans && place.targets < TARGETS_PER_SCAN * most_scans;
        if !is_worth {
            // Should the frontier grow, counting starts again.
            place.gain = target.gain;
            (place.scans, place.targets) = (0, 0);
        }
        is_worth
    }
}

fn place_of<'a>(places: &'a mut [Place], target: &Frontier) -> Option<&'a mut Place> {
    places
        .iter_mut()
        .find(|place| (place.at - target.centre).length() < SAME_PLACE)
}

fn is_frontier(grid: &Grid, cell: CellIndex) -> bool {
    let unknown = |dc: i32, dr: i32| {
        let neighbour = CellIndex::new(cell.col + dc, cell.row + dr);
        grid.state(neighbour) == CellState::Unknown
    };
    grid.state(cell) == CellState::Free
        && (unknown(1, 0) || unknown(-1, 0) || unknown(0, 1) || unknown(0, -1))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOOKS: usize = 4;

    fn frontier(x: f64, gain: f64) -> Frontier {
        Frontier {
            cells: vec![],
            centre: Point2::new(x, 0.0),
            gain,
            goal: Some(Point2::new(x - 1.0, 0.0)),
            cost: 1.0,
            score: gain,
        }
    }

    /// How often a frontier of this gain is chosen before it is given up, by a robot that comes to
    /// `here` each time.
    fn times_chosen(explorer: &mut Explorer, gain: f64, here: Point2<f64>) -> usize {
        let mut times = 0;
        while explorer.choose(vec![frontier(5.0, gain)], LOOKS).is_some() && times < 1000 {
            explorer.pass(here);
            times += 1;
        }
        times
    }

    #[test]
    fn scans_that_show_nothing_end_a_frontier_and_growth_opens_it_again() {
        let mut explorer = Explorer::default();
        let goal = Point2::new(4.0, 0.3);
        assert_eq!(times_chosen(&mut explorer, 1.0, goal), LOOKS);
        assert_eq!(explorer.remaining(Reason::NoGain), [Point2::new(5.0, 0.0)]);
        assert_eq!(times_chosen(&mut explorer, 1.4, goal), 0);
        assert_eq!(times_chosen(&mut explorer, 1.6, goal), LOOKS);
        assert_eq!(times_chosen(&mut explorer, 1.6, goal), 0);
    }

    #[test]
    fn from_afar_a_frontier_is_chosen_many_more_times_but_not_for_ever() {
        let times = times_chosen(&mut Explorer::default(), 1.0, Point2::origin());
        assert_eq!(times, TARGETS_PER_SCAN * LOOKS);
    }

    #[test]
    fn scans_that_show_something_do_not_count() {
        let mut explorer = Explorer::default();
        let mut gain = 8.0;
        while gain > 0.06 {
            for _ in 1..LOOKS {
                assert!(explorer.choose(vec![frontier(5.0, gain)], LOOKS).is_some());
                explorer.pass(Point2::new(4.0, 0.0));
            }
            gain *= 0.89;
        }
        assert!(explorer.remaining(Reason::NoGain).is_empty());
    }

    #[test]
    fn what_no_way_leads_to_is_told_apart_and_the_next_best_is_chosen() {
        let mut explorer = Explorer::default();
        let found = vec![frontier(5.0, 2.0), frontier(9.0, 1.0)];
        assert_eq!(explorer.choose(found.clone(), LOOKS), found[0].goal);
        explorer.give_up(Reason::NoWay);
        assert_eq!(explorer.choose(found.clone(), LOOKS), found[1].goal);
        explorer.give_up(Reason::NoGain);
        assert_eq!(explorer.choose(found.clone(), LOOKS), None);
        assert_eq!(explorer.remaining(Reason::NoWay), [found[0].centre]);
        assert_eq!(explorer.remaining(Reason::NoGain), [found[1].centre]);
    }
}
