//! The points of a scan sorted by bearing: one lookup finds the point that the sensor saw in a
//! direction, and one more the point nearest to a place.
//!
//! Bearings are measured along a diamond, not along a circle: y / (|x| + |y|) grows with the angle,
//! and costs a division instead of an arc tangent.

use nalgebra::Point2;

use crate::lanes::{LANES, Lanes};

/// Points that are compared at once to find the one nearest to a place.
const WINDOW: usize = 2 * LANES;
/// The bits that hold an index into the window.
const PLACES: u64 = WINDOW as u64 - 1;
/// The indices, as the bits of floating-point numbers.
const WINDOW_PLACES: [[f64; LANES]; 2] = {
    let mut places = [[0.0; LANES]; 2];
    let mut at = 0;
    while at < WINDOW {
        places[at / LANES][at % LANES] = f64::from_bits(at as u64);
        at += 1;
    }
    places
};
/// Beyond the window, a search goes on until this many points in a row are no nearer.
const BESIDE: usize = 2;

/// The points of a scan, sorted by bearing, in a list that wraps around the full circle.
#[derive(Clone, Debug)]
pub(super) struct Bearings {
    /// The position of each point on the diamond.
    along: Vec<f64>,
    /// For each section of the diamond, the first point in it or after it.
    first: Vec<u32>,
    /// The points by columns, wrapped around: half a window of the last ones before the first, and
    /// a window of the first ones after the last.
    x: Vec<f64>,
    y: Vec<f64>,
    /// The index in the list of the first of these numbers.
    turn: usize,
}

/// The position on the diamond, from 0 to 4: it starts at the negative x axis and grows with the
/// angle.
#[inline(always)]
fn along_diamond(point: &Point2<f64>) -> f64 {
    let part = point.y / (point.x.abs() + point.y.abs());
    let behind = if point.y >= 0.0 { 4.0 - part } else { -part };
    let along = if point.x >= 0.0 { 2.0 + part } else { behind };
    // At the sensor itself there is no direction.
    if along.is_nan() { 0.0 } else { along }
}

/// The bits of a non-negative number, with the lowest ones replaced by an index: they are ordered
/// as the numbers are.
#[inline(always)]
fn tagged(number: f64, place: f64) -> u64 {
    number.to_bits() & !PLACES | place.to_bits()
}

impl Bearings {
    /// Sorts the points by their bearings.
    pub(super) fn sort(points: &mut Vec<Point2<f64>>) -> Self {
        let count = points.len();
        let mut along: Vec<f64> = points.iter().map(along_diamond).collect();
        if !along.is_sorted() {
            let mut keyed: Vec<_> = along.iter().copied().zip(points.iter().copied()).collect();
            keyed.sort_by(|a, b| a.0.total_cmp(&b.0));
            (along, *points) = keyed.into_iter().unzip();
        }
        // With fewer points than that, they still wrap around.
        let turn = LANES.next_multiple_of(count.max(1)) - LANES;
        let mut view = Self {
            turn,
            first: vec![0; count.next_power_of_two() + 1],
            along,
            x: Vec::with_capacity(LANES + count + WINDOW),
            y: Vec::with_capacity(LANES + count + WINDOW),
        };
        // How many points each section has, then how many all sections before it have.
        for along in &view.along {
            let part = view.part(*along);
            if let Some(points) = view.first.get_mut(part + 1) {
                *points += 1;
            }
        }
        let mut sum = 0;
        for points in &mut view.first {
            sum += *points;
            *points = sum;
        }
        let before = points.iter().cycle().skip(turn).take(LANES);
        let after = points.iter().cycle().take(WINDOW);
        for (column, along) in [(&mut view.x, 0), (&mut view.y, 1)] {
            column.extend(before.clone().map(|point| point[along]));
            column.extend(points.iter().map(|point| point[along]));
            column.extend(after.clone().map(|point| point[along]));
        }
        view
    }

    /// x and y of the points, wrapped around: [`LANES`] of the last ones before the first, and
    /// twice as many of the first ones after the last.
    pub(super) fn columns(&self) -> [&[f64]; 2] {
        [&self.x, &self.y]
    }

    /// The section that contains a position on the diamond.
    #[inline(always)]
    fn part(&self, along: f64) -> usize {
        // One number follows the last section.
        let parts = self.first.len() - 1;
        ((along * 0.25 * parts as f64) as usize).min(parts - 1)
    }

    /// Whether there are points all round, without a gap of more than about a quarter turn.
    pub(super) fn is_all_round(&self) -> bool {
        /// Along the diamond.
        const QUARTER: f64 = 1.0;
        let (Some(first), Some(last)) = (self.along.first(), self.along.last()) else {
            return false;
        };
        let mut steps = self.along.array_windows().map(|[a, b]| b - a);
        first + 4.0 - last <= QUARTER && steps.all(|step| step <= QUARTER)
    }

    /// The points in the direction of `place`: the last one before it and the first one after it,
    /// wrapped around.
    pub(super) fn about(&self, place: &Point2<f64>) -> [usize; 2] {
        let along = along_diamond(place);
        let mut after = self.first_of(along);
        while self.along.get(after).is_some_and(|other| *other < along) {
            after += 1;
        }
        let before = after.checked_sub(1).unwrap_or(self.along.len() - 1);
        [before, if after < self.along.len() { after } else { 0 }]
    }

    /// The first point in the same section of the diamond, or after it.
    #[inline(always)]
    fn first_of(&self, along: f64) -> usize {
        let first = self.first.get(self.part(along));
        first.map_or(0, |first| *first as usize)
    }

    /// The point nearest to `place` among those in about its direction, and its squared distance.
    /// It is the nearest of all unless walls lie one behind the other.
    #[inline(always)]
    pub(super) fn nearest<L: Lanes>(
        &self,
        machine: L::Machine,
        place: &Point2<f64>,
    ) -> Option<(usize, f64)> {
        self.nearest_from::<L>(machine, self.first_of(along_diamond(place)), place)
    }

    /// The point nearest to `place` around the one at `hint`, and its squared distance. The search
    /// goes on as long as points get nearer.
    #[inline(always)]
    pub(super) fn nearest_from<L: Lanes>(
        &self,
        machine: L::Machine,
        hint: usize,
        place: &Point2<f64>,
    ) -> Option<(usize, f64)> {
        let (x, y) = (L::splat(machine, place.x), L::splat(machine, place.y));
        let columns = [&self.x, &self.y].map(|column| column.get(hint..hint + WINDOW));
        let [Some(xs), Some(ys)] = columns else {
            return None;
        };
        let ([x_low, x_high], [y_low, y_high]) = (xs.as_chunks().0, ys.as_chunks().0) else {
            return None;
        };
        let square = |xs: &[f64; LANES], ys: &[f64; LANES]| {
            let (dx, dy) = (L::load(machine, xs) - x, L::load(machine, ys) - y);
            dx * dx + dy * dy
        };
        let (low, high) = (square(x_low, y_low), square(x_high, y_high));
        // Which one is nearest is unpredictable, so no branch. The low bits of the squares hold the
        // indices: non-negative squares are ordered as integers are.
        let [low_places, high_places] = WINDOW_PLACES;
        let (low_places, high_places) = (
            L::load(machine, &low_places),
            L::load(machine, &high_places),
        );
        let squares = low.or_lesser(high).to_array();
        let at = low.where_greater(high, high_places, low_places).to_array();
        let ([a, b, c, d], [at_a, at_b, at_c, at_d]) = (squares, at);
        let least_of_two = tagged(a, at_a).min(tagged(b, at_b));
        let least = least_of_two.min(tagged(c, at_c).min(tagged(d, at_d)));
        let (at, least) = ((least & PLACES) as usize, f64::from_bits(least & !PLACES));
        let count = self.along.len();
        let mut index = hint + at + self.turn;
        while index >= count {
            index -= count;
        }
        Some(match at {
            0 => self.walk(place, (index, least), false),
            _ if at + 1 == WINDOW => self.walk(place, (index, least), true),
            _ => (index, least),
        })
    }

    /// Walks on from a point, up or down the list, as long as points get nearer.
    fn walk(
        &self,
        place: &Point2<f64>,
        (mut best, mut least): (usize, f64),
        is_up: bool,
    ) -> (usize, f64) {
        let count = self.along.len();
        let (mut at, mut since) = (best, 0);
        while since < BESIDE {
            at = match (is_up, at) {
                (true, _) if at + 1 == count => 0,
                (true, _) => at + 1,
                (false, 0) => count - 1,
                (false, _) => at - 1,
            };
            let point = self.x.get(at + LANES).zip(self.y.get(at + LANES));
            let here = point.map_or(f64::INFINITY, |(x, y)| {
                let (dx, dy) = (x - place.x, y - place.y);
                dx * dx + dy * dy
            });
            if here < least {
                (best, least, since) = (at, here, 0);
            } else {
                since += 1;
            }
        }
        (best, least)
    }
}
