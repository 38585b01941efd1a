//! In: a beam, and a map of cells or of walls. Out: the range that the map predicts for it, and how
//! far from the nearest surface it ended.
//!
//! These are the two numbers of the usual sensor models: the range z* of a ray through the map
//! (beam model, Thrun, Burgard & Fox (2005), eq. (6.4)), and the distance d from its end to the
//! nearest surface (likelihood field, table 6.3). Written for one beam that a person inspects: it
//! is cast cell by cell, and all cells around its end are examined.

use nalgebra::Point2;

use super::{CellState, Grid, Layers, cells_on_ray};
use crate::geom::{Length as _, Segment};

/// Surfaces are searched for up to this distance behind the end of a beam, and around it, m.
const REACH: f64 = 1.0;

/// What a map predicts of a beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeamFigures {
    /// Distance from its origin to the first surface on its way, m; `None` if there is none up to a
    /// metre behind its end.
    pub expected: Option<f64>,
    /// Distance from its end to the nearest surface, m; `None` beyond a metre.
    pub nearest: Option<f64>,
}

/// What a map shows of a gap that a door could shut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeafFigures {
    /// Cells on the line between its ends, without those at the posts.
    pub cells: usize,
    /// How many of them are known.
    pub known: usize,
    /// Σ l, the sum of their log-odds.
    pub log_odds: f64,
    /// Probability that the gap is open.
    pub open: f64,
}

impl Grid {
    /// What the grid predicts of a beam, map frame, m: surfaces are the centres of cells that count
    /// as occupied.
    #[must_use]
    pub fn beam(&self, from: Point2<f64>, to: Point2<f64>) -> BeamFigures {
        let side = self.resolution();
        let (way, range) = (to - from, (to - from).length());
        let ahead = way * ((range + REACH) / range.max(f64::MIN_POSITIVE));
        let in_cells = |place: Point2<f64>| Point2::from(place.coords / side);
        let is_surface = |cell| self.state(cell) == CellState::Occupied;
        let mut expected = None;
        cells_on_ray(in_cells(from), in_cells(from + ahead), |cell| {
            if expected.is_none() && is_surface(cell) {
                let along = (self.centre_of(cell) - from).dot(&way) / range;
                expected = Some(along.max(0.0));
            }
        });
        let middle = self.cell_at(to);
        let reach = (REACH / side).ceil() as i32;
        let mut nearest = f64::INFINITY;
        for col in middle.col - reach..=middle.col + reach {
            for row in middle.row - reach..=middle.row + reach {
                let cell = super::CellIndex { col, row };
                if is_surface(cell) {
                    nearest = nearest.min((self.centre_of(cell) - to).length());
                }
            }
        }
        BeamFigures {
            expected,
            nearest: (nearest <= REACH).then_some(nearest),
        }
    }
}

/// The same from a map of walls.
#[must_use]
pub fn beam_among(walls: &[Segment], from: Point2<f64>, to: Point2<f64>) -> BeamFigures {
    let range = (to - from).length();
    let towards = (to - from) / range.max(f64::MIN_POSITIVE);
    let hits = walls.iter().filter_map(|w| w.hit_by_ray(from, towards));
    let first = hits.fold(f64::INFINITY, f64::min);
    let away = walls.iter().map(|wall| wall.distance(to));
    let nearest = away.fold(f64::INFINITY, f64::min);
    BeamFigures {
        expected: (first <= range + REACH).then_some(first),
        nearest: (nearest <= REACH).then_some(nearest),
    }
}

impl Layers<'_> {
    /// Whether the gap between two posts is open, judged by the cells of the map in it.
    ///
    /// One door leaf shuts all of the gap or nothing, so its cells are independent observations of
    /// one question, each by its own beams, and the prior is even: their log-odds add up, and
    /// p(open) = 1 / (1 + exp Σ l). The cells at the posts tell nothing about the leaf: posts stand
    /// anywhere within them, so these cells are occupied whether it is open or shut.
    ///
    /// # Source   Thrun, Burgard & Fox (2005), eq. (9.6): log-odds of independent observations add.
    #[must_use]
    pub fn leaf(&self, posts: &Segment) -> LeafFigures {
        let side = self.main.resolution();
        let inset = posts.vector() * (1.5 * side / posts.length().max(3.0 * side));
        let in_cells = |place: Point2<f64>| Point2::from(place.coords / side);
        let (mut cells, mut known, mut log_odds) = (0, 0, 0.0);
        cells_on_ray(
            in_cells(posts.a + inset),
            in_cells(posts.b - inset),
            |cell| {
                let l = self.figures(self.main.centre_of(cell)).log_odds;
                cells += 1;
                known += usize::from(l != 0.0);
                log_odds += l;
            },
        );
        LeafFigures {
            cells,
            known,
            log_odds,
            open: 1.0 / (1.0 + libm::exp(log_odds)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Pose2;
    use crate::map::{Evidence, GridConfig, Layer};

    /// A wall along x = 2, 4 m long, with a gap from y = 1 to y = 2, seen often by beams
    /// from x = 0.
    fn walled() -> Grid {
        let mut grid = Grid::new(GridConfig::default()).unwrap();
        for i in 0..160 {
            let y = 0.025 * f64::from(i) + 0.01;
            let is_gap = (1.0..2.0).contains(&y);
            let end = Point2::new(if is_gap { 4.0 } else { 2.01 }, y);
            let evidence = Evidence {
                free: vec![[Point2::new(0.01, y), end]],
                hits: vec![end],
            };
            for _ in 0..6 {
                grid.draw(&evidence, &Pose2::identity());
            }
        }
        grid
    }

    fn near(found: Option<f64>, expected: f64, off: f64) {
        let found = found.unwrap();
        assert!((found - expected).abs() <= off, "{found} for {expected}");
    }

    #[test]
    fn a_beam_is_compared_with_the_wall_on_its_way_and_with_what_is_nearest() {
        let grid = walled();
        let side = grid.resolution();
        let from = Point2::new(0.2, 0.5);
        // In front of the wall, in it, and through it.
        for x in [1.6, 2.01, 2.7] {
            let told = grid.beam(from, Point2::new(x, 0.5));
            near(told.expected, 1.81, side);
            near(told.nearest, (x - 2.01_f64).abs(), side);
        }
        // More than a metre behind its end nothing is searched.
        assert_eq!(
            grid.beam(from, Point2::new(0.7, 0.5)),
            BeamFigures {
                expected: None,
                nearest: None
            }
        );
        // Through the gap: the wall beside it is nearest, and the beam meets what stands behind.
        let told = grid.beam(Point2::new(0.2, 1.5), Point2::new(3.5, 1.5));
        near(told.expected, 3.8, side);
    }

    #[test]
    fn cells_and_walls_say_the_same_of_a_beam() {
        let grid = walled();
        let walls = [
            Segment::new(Point2::new(2.01, 0.0), Point2::new(2.01, 1.0)),
            Segment::new(Point2::new(2.01, 2.0), Point2::new(2.01, 4.0)),
            Segment::new(Point2::new(4.0, 1.0), Point2::new(4.0, 2.0)),
        ];
        for (from, to) in [
            ([0.2, 0.5], [1.7, 0.4]),
            ([0.2, 3.5], [2.3, 2.9]),
            ([0.5, 1.5], [3.9, 1.6]),
        ] {
            let [from, to] = [from, to].map(Point2::from);
            let (cells, exact) = (grid.beam(from, to), beam_among(&walls, from, to));
            near(
                cells.expected,
                exact.expected.unwrap(),
                1.5 * grid.resolution(),
            );
            near(cells.nearest, exact.nearest.unwrap(), grid.resolution());
        }
    }

    #[test]
    fn a_gap_is_open_a_wall_is_shut_and_of_the_unknown_neither_is_said() {
        let grid = walled();
        let layers = Layers {
            main: &grid,
            sonar: None,
            shown: Layer::Main,
        };
        let leaf = |x: f64, low: f64, high: f64| {
            layers.leaf(&Segment::new(Point2::new(x, low), Point2::new(x, high)))
        };
        let open = leaf(2.01, 1.0, 2.0);
        assert!(open.open > 0.999 && open.known == open.cells, "{open:?}");
        let shut = leaf(2.01, 2.5, 3.5);
        assert!(shut.open < 0.001 && shut.known == shut.cells, "{shut:?}");
        let unknown = leaf(8.0, 1.0, 2.0);
        assert_eq!((unknown.known, unknown.open), (0, 0.5));
        assert!((15..=19).contains(&open.cells), "{open:?}");
        // Computed from the cells themselves.
        let sum: f64 = (0..open.cells)
            .map(|i| 1.0 + 1.5 * grid.resolution() + grid.resolution() * i as f64)
            .map(|y| layers.figures(Point2::new(2.01, y)).log_odds)
            .sum();
        assert!(
            (open.log_odds - sum).abs() < 1e-9,
            "{} {sum}",
            open.log_odds
        );
    }
}
