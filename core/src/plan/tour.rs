//! Which frontier to visit first: the one with which the shortest tour through all of them begins.
//!
//! In: frontiers with their goals, and the wavefront from the robot's position. Out: the frontiers
//! in the order of that tour.
//!
//! 1. Ways between goals are measured over the floor that the wavefront reached, in squares of
//!    three by three cells: one wavefront from each goal.
//! 2. A tour visits the [`MOST`] goals with the cheapest ways, and may end anywhere. It is exact:
//!    Held & Karp (1962), "A dynamic programming approach to sequencing problems". Goals farther
//!    away wait; later they will be near, or gone.
//! 3. The goal that the robot is heading for stays first unless that costs [`WORTH`] more than the
//!    shortest tour, so the robot does not dither.
//!
//! So what remains nearby is visited before the robot goes far, since returning for it would cost
//! the way twice. The gain of a frontier does not count: all of them are visited in the end.
//!
//! Ours; planning a tour over all frontiers is usual since Kulich, Faigl & Přeučil (2011), "On
//! distance utility in the exploration task".

use nalgebra::Point2;

use super::cspace::GridSpace;
use super::frontier::Frontier;
use super::wavefront::Wavefront;
use crate::geom::Length;

/// Most goals in a tour.
const MOST: usize = 10;
/// The current goal is given up for a tour that is shorter by this, m.
const WORTH: f64 = 0.5;
/// A frontier with a goal this near to the current goal is taken to be the same one, m.
pub(crate) const SAME_GOAL: f64 = 0.75;
/// Side of a square, m.
const SQUARE: f64 = 0.15;

/// Puts the frontiers into the order in which to visit them; those that are no longer `open`, and
/// those that cannot be reached, come last. `heading_for` is the robot's current goal.
pub fn order_by_tour(
    frontiers: &mut Vec<Frontier>,
    space: &GridSpace,
    wave: &Wavefront,
    heading_for: Option<Point2<f64>>,
    is_open: impl Fn(&Frontier) -> bool,
) {
    frontiers.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let (mut toured, rest): (Vec<Frontier>, Vec<Frontier>) = std::mem::take(frontiers)
        .into_iter()
        .partition(|frontier| frontier.goal.is_some() && is_open(frontier));
    let far = toured.split_off(toured.len().min(MOST));
    // No larger: areas on both sides of a wall must not share a square.
    let side = (SQUARE / space.resolution() + 1e-9).max(1.0) as usize;
    let floor = wave.in_squares(side);
    let cells: Vec<Option<usize>> = toured.iter().map(|f| space.index_at(f.goal?)).collect();
    let between = |&from: &Option<usize>| {
        let wave = from.map(|from| floor.costs_from(from));
        let cost = |to: &Option<usize>| wave.as_ref()?.cost(floor.square_of((*to)?));
        cells
            .iter()
            .map(|to| cost(to).unwrap_or(f64::INFINITY))
            .collect()
    };
    let tours = Tours::new(cells.iter().map(between).collect());
    let to_goal = |goal: Point2<f64>| {
        let off = |i: &usize| {
            toured[*i]
                .goal
                .map_or(f64::INFINITY, |g| (g - goal).length())
        };
        let nearest = (0..toured.len()).min_by(|a, b| off(a).total_cmp(&off(b)))?;
        (off(&nearest) < SAME_GOAL).then_some(nearest)
    };
    let kept = heading_for.and_then(to_goal);
    let costs = |first: usize| {
        let bonus = if kept == Some(first) { WORTH } else { 0.0 };
        toured[first].cost + tours.from(first) - bonus
    };
    let first = (0..toured.len()).min_by(|a, b| costs(*a).total_cmp(&costs(*b)));
    let order = first.map_or(vec![], |first| tours.order(first));
    frontiers.extend(order.into_iter().map(|i| toured[i].clone()));
    frontiers.extend(far);
    frontiers.extend(rest);
}

/// The shortest open tours through some places, by the place where they begin.
struct Tours {
    /// Length of the way from place to place.
    between: Vec<Vec<f64>>,
    /// By set of places (bits) and place: the shortest way from that place through the whole set.
    through: Vec<Vec<f64>>,
}

impl Tours {
    fn new(between: Vec<Vec<f64>>) -> Self {
        let count = between.len();
        let mut tours = Self {
            between,
            through: Vec::with_capacity(1 << count),
        };
        for set in 0..1_usize << count {
            // Smaller sets have smaller numbers, so they are known already.
            let shortest = |from| tours.next(set, from).map_or(0.0, |(way, _)| way);
            let through = (0..count).map(shortest).collect();
            tours.through.push(through);
        }
        tours
    }

    /// The length of the way from a place through a set, and the first place on it; `None` for an
    /// empty set.
    fn next(&self, set: usize, from: usize) -> Option<(f64, usize)> {
        let count = self.between.len();
        let in_set = (0..count).filter(|place| set & (1 << place) != 0);
        let way = |to: usize| {
            (
                self.between[from][to] + self.through[set & !(1 << to)][to],
                to,
            )
        };
        in_set.map(way).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    fn all_but(&self, place: usize) -> usize {
        ((1 << self.between.len()) - 1) & !(1 << place)
    }

    /// The shortest way from one place through all the others.
    fn from(&self, first: usize) -> f64 {
        self.through[self.all_but(first)][first]
    }

    /// The places on that way.
    fn order(&self, first: usize) -> Vec<usize> {
        let (mut order, mut set) = (vec![first], self.all_but(first));
        let mut at = first;
        while let Some((_, to)) = self.next(set, at) {
            order.push(to);
            set &= !(1 << to);
            at = to;
        }
        order
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// All orders of some places.
    fn orders(places: &[usize]) -> Vec<Vec<usize>> {
        if places.is_empty() {
            return vec![vec![]];
        }
        let with_first = |&first: &usize| {
            let others: Vec<usize> = places.iter().copied().filter(|&p| p != first).collect();
            let rest = orders(&others).into_iter();
            rest.map(move |mut rest| {
                rest.insert(0, first);
                rest
            })
        };
        places.iter().flat_map(with_first).collect()
    }

    proptest! {
        #[test]
        fn tours_are_as_short_as_the_shortest_of_all_orders(
            places in proptest::collection::vec((0.0..10.0_f64, 0.0..10.0_f64), 1..7),
        ) {
            let way = |a: &(f64, f64), b: &(f64, f64)| libm::hypot(a.0 - b.0, a.1 - b.1);
            let between: Vec<Vec<f64>> = places.iter().map(|a| places.iter().map(|b| way(a, b)).collect()).collect();
            let length = |order: &[usize]| order.windows(2).map(|pair| between[pair[0]][pair[1]]).sum::<f64>();
            let tours = Tours::new(between.clone());
            let all: Vec<usize> = (0..places.len()).collect();
            for first in 0..places.len() {
                let shortest = orders(&all).into_iter().filter(|order| order[0] == first)
                    .map(|order| length(&order)).fold(f64::INFINITY, f64::min);
                prop_assert!((tours.from(first) - shortest).abs() < 1e-9);
                let order = tours.order(first);
                prop_assert!((length(&order) - shortest).abs() < 1e-9);
                let mut sorted = order;
                sorted.sort_unstable();
                prop_assert_eq!(&sorted, &all);
            }
        }
    }
}
