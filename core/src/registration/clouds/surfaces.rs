//! The surface at each point of a cloud: the line through its neighbours.
//!
//! - In a scan, the neighbours are the adjacent beams, as long as the steps between them are no
//!   longer than a wall at this range makes them.
//! - For points in any order, they are the nearest points.
//!
//! If the neighbours do not form a line, the point has no surface: a meaningless direction would
//! pull a match anywhere.

use nalgebra::{Point2, Vector2};

use super::neighbours::Neighbours;
use crate::lanes::{self, Kernel, LANES, Lanes};
use crate::points::{MAX_FLATNESS, OrientedPoint, Scatter};

/// Neighbours on either side that make the line of a point in a scan.
const BESIDE: usize = 4;
/// How many nearest points make the line of a point in an unordered cloud, itself among them.
const NEAREST: usize = 7;
/// Steps between beams up to this length always count as along a wall, m, ...
const SHORTEST_GAP: f64 = 0.1;
/// ... and so do those up to this many times the spacing of the beams at this range.
const GAP: f64 = 4.0;
/// The spacing of beams is the median of at most about this many angles.
const MOST_ANGLES: usize = 100;
/// Fewer points make no line.
const FEWEST: f64 = 3.0;
/// Points whose neighbours spread by less than this along the line, m², all lie in one place.
const LEAST_SPREAD: f64 = 1e-8;

/// The surfaces of a scan, facing the sensor; `columns` are x and y of its points, wrapped around.
pub(super) fn scan_surfaces(
    points: &[Point2<f64>],
    columns: [&[f64]; 2],
) -> Vec<Option<OrientedPoint>> {
    lanes::run(OfScan {
        count: points.len(),
        columns,
    })
}

/// The surfaces of points in any order.
pub(super) fn nearest_surfaces(points: &[Point2<f64>]) -> Vec<Option<OrientedPoint>> {
    let neighbours = Neighbours::of(points);
    let surface = |point: &Point2<f64>| {
        let mut scatter = Scatter::default();
        for near in neighbours.nearest_few(*point, NEAREST) {
            scatter.add(points.get(near)? - point);
        }
        let normal = scatter.normal()?;
        Some(OrientedPoint {
            position: point + normal * normal.dot(&scatter.mean()),
            normal,
        })
    };
    points.iter().map(surface).collect()
}

/// The median of non-negative numbers. Their bits have the same order, and compare faster.
pub(super) fn median(numbers: impl Iterator<Item = f64>) -> Option<f64> {
    // Reserve room for all of them: a filter does not know how many it lets pass.
    let mut bits = Vec::with_capacity(numbers.size_hint().1.unwrap_or(0));
    bits.extend(numbers.map(f64::to_bits));
    if bits.is_empty() {
        return None;
    }
    let middle = bits.len() / 2;
    Some(f64::from_bits(*bits.select_nth_unstable(middle).1))
}

/// Four numbers of a column, from an index on.
#[inline(always)]
fn four<L: Lanes>(machine: L::Machine, column: &[f64], at: usize) -> L {
    let chunk = column.get(at..).and_then(<[f64]>::first_chunk);
    L::load(machine, chunk.unwrap_or(&[0.0; LANES]))
}

/// Four points, and the neighbours that make their lines.
const AROUND: usize = LANES + 2 * BESIDE;

/// The numbers of a column around those from `at` on: sliced once, so that each load from them
/// needs no check.
#[inline(always)]
fn around(column: &[f64], at: usize) -> &[f64; AROUND] {
    let from = column.get(at.wrapping_sub(BESIDE)..);
    let around = from.and_then(<[f64]>::first_chunk);
    around.unwrap_or(&[0.0; AROUND])
}

/// The line through the neighbours of each point of a scan, four points at a time.
struct OfScan<'a> {
    count: usize,
    /// x and y, beginning [`LANES`] points before the first.
    columns: [&'a [f64]; 2],
}

impl OfScan<'_> {
    /// For each step between neighbours, wrapped around as the columns are: 1 if it goes along a
    /// wall, else 0.
    #[inline(always)]
    fn steps<L: Lanes>(&self, machine: L::Machine) -> Vec<f64> {
        let [xs, ys] = self.columns;
        let four = |column, at| four::<L>(machine, column, at);
        let steps = xs.len().saturating_sub(1);
        // The angle between neighbours from its sine, squared: wide gaps come out too small, which
        // does not matter.
        let stride = LANES * self.count.div_ceil(MOST_ANGLES).max(1);
        let mut angles = Vec::with_capacity(steps + LANES);
        for at in (LANES..LANES + self.count).step_by(stride) {
            let (ax, ay, bx, by) = (
                four(xs, at),
                four(ys, at),
                four(xs, at + 1),
                four(ys, at + 1),
            );
            let across = ax * by - ay * bx;
            let squares = (ax * ax + ay * ay) * (bx * bx + by * by);
            angles.extend((across * across / squares).to_array());
        }
        angles.truncate(self.count);
        // Next to a point at the sensor itself there is no angle.
        let known = angles.iter().copied().filter(|angle| angle.is_finite());
        let spacing = median(known).unwrap_or(0.0);
        let splat = |value| L::splat(machine, value);
        let (shortest, scale) = (
            splat(SHORTEST_GAP * SHORTEST_GAP),
            splat(GAP * GAP * spacing),
        );
        let mut along = angles;
        along.clear();
        for at in (0..steps).step_by(LANES) {
            let (ax, ay) = (four(xs, at), four(ys, at));
            let (dx, dy) = (four(xs, at + 1) - ax, four(ys, at + 1) - ay);
            let longest = shortest.or_greater(scale * (ax * ax + ay * ay));
            let is_gap = (dx * dx + dy * dy).where_greater(longest, splat(0.0), splat(1.0));
            along.extend(is_gap.to_array());
        }
        along
    }
}

impl Kernel for OfScan<'_> {
    type Output = Vec<Option<OrientedPoint>>;

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) -> Self::Output {
        let [xs, ys] = self.columns;
        let steps = self.steps::<L>(machine);
        let four = |column: &[f64; AROUND], at| four::<L>(machine, column, at);
        let splat = |value| L::splat(machine, value);
        let (zero, half, one) = (splat(0.0), splat(0.5), splat(1.0));
        // No neighbour is used twice when wrapping around.
        let beside = BESIDE.min(self.count.saturating_sub(1) / 2);
        let mut surfaces = Vec::with_capacity(self.count.next_multiple_of(LANES));
        for at in (LANES..LANES + self.count).step_by(LANES) {
            let [xs, ys, steps] = [xs, ys, &steps].map(|column| around(column, at));
            let (px, py) = (four(xs, BESIDE), four(ys, BESIDE));
            // Sums over the neighbours relative to the point, which itself adds nothing.
            let (mut n, mut x, mut y) = (one, zero, zero);
            let (mut xx, mut xy, mut yy) = (zero, zero, zero);
            let (mut after, mut before) = (one, one);
            for away in 1..=BESIDE {
                if away > beside {
                    break;
                }
                after = after * four(steps, BESIDE + away - 1);
                before = before * four(steps, BESIDE - away);
                for (other, is_near) in [(BESIDE + away, after), (BESIDE - away, before)] {
                    let (dx, dy) = (four(xs, other) - px, four(ys, other) - py);
                    let (wx, wy) = (is_near * dx, is_near * dy);
                    n += is_near;
                    x += wx;
                    y += wy;
                    xx += wx * dx;
                    xy += wx * dy;
                    yy += wy * dy;
                }
            }
            // The scatter, times the square of the number of points.
            let (xx, xy, yy) = (n * xx - x * x, n * xy - x * y, n * yy - y * y);
            let (lean, middle) = (half * (xx - yy), half * (xx + yy));
            let spread = (lean * lean + xy * xy).sqrt();
            let (across, along) = (middle - spread, middle + spread);
            // The eigenvector of the larger eigenvalue is (spread + lean, xy) or (xy, spread -
            // lean), whichever is longer. Its squared length is 2 spread (spread + |lean|).
            let long = spread + lean.abs();
            let per_length = one / ((spread + spread) * long).sqrt();
            let tx = lean.where_greater(zero, long, xy) * per_length;
            let ty = lean.where_greater(zero, xy, long) * per_length;
            // Facing the sensor.
            let sign = (ty * px - tx * py).where_greater(zero, one, zero - one);
            let (nx, ny) = (zero - ty * sign, tx * sign);
            let off = (nx * x + ny * y) / n;
            // A line if this is not negative.
            let flat = splat(MAX_FLATNESS) * along - across;
            let flat = along.where_greater(n * n * splat(LEAST_SPREAD), flat, zero - one);
            let flat = n.where_greater(splat(FEWEST - 0.5), flat, zero - one);
            let flat = flat.to_array();
            let (sx, sy) = ((px + nx * off).to_array(), (py + ny * off).to_array());
            let (nx, ny) = (nx.to_array(), ny.to_array());
            for lane in 0..LANES {
                surfaces.push((flat[lane] >= 0.0).then(|| OrientedPoint {
                    position: Point2::new(sx[lane], sy[lane]),
                    normal: Vector2::new(nx[lane], ny[lane]),
                }));
            }
        }
        surfaces.truncate(self.count);
        surfaces
    }
}
