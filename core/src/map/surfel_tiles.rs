//! A surfel map of any extent whose copies share their common parts.
//!
//! In: oriented points in the frame of the map. Out: the surfel nearest to a place, as
//! [`SurfelMap`] gives it.
//!
//! 1. The plane is cut into square tiles, each a [`SurfelMap`] of its own. A tile also holds
//!    surfels beyond its edge, as far as the search reach, so that one tile is enough to answer for
//!    a place.
//! 2. Tiles are shared between copies of the map until one of them writes (copy on write). A copy
//!    costs a pointer for each tile; a scan that is added to it copies the few tiles that it sees.
//!
//! Why tiles: each particle of a grid-mapping filter has a map of its own, and two of them share
//! most of their history. The tree of Eliazar & Parr (2004), "DP-SLAM 2.0", which shares single
//! cells, saves more memory, but needs a search through the ancestors for each look-up.

use std::sync::Arc;

use nalgebra::Point2;

use super::{Surfel, SurfelConfig, SurfelMap};
use crate::points::OrientedPoint;

/// Side of a tile, m: a whole number of cells of the default size.
const SIDE: f64 = 6.4;
/// Spare tiles by which the directory grows beyond what is needed.
const MARGIN: i32 = 2;
/// Most tiles along a side of the directory: 6.5 km.
const MOST_TILES: i32 = 1024;

/// Surfels in tiles.
#[derive(Clone, Debug)]
pub struct SurfelTiles {
    config: SurfelConfig,
    /// Column and row of the first tile.
    low: (i32, i32),
    cols: i32,
    rows: i32,
    tiles: Vec<Option<Arc<SurfelMap>>>,
}

impl SurfelTiles {
    /// An empty map. [`SurfelConfig::half_side`] is not used: the map grows.
    #[must_use]
    pub fn new(config: SurfelConfig) -> Self {
        // Large enough that where a surfel is averaged into another, one cell apart, both tiles
        // contain both.
        let half_side = 0.5 * SIDE + config.reach + 2.0 * config.cell;
        Self {
            config: SurfelConfig {
                half_side,
                ..config
            },
            low: (0, 0),
            cols: 0,
            rows: 0,
            tiles: vec![],
        }
    }

    /// Adds points in the frame of the map. Points that are not finite or kilometres away are
    /// dropped.
    pub fn insert(&mut self, points: impl IntoIterator<Item = OrientedPoint>) {
        let beyond = self.config.half_side - 0.5 * SIDE;
        for point in points {
            let place = point.position;
            let Some(low) = tile_of(Point2::new(place.x - beyond, place.y - beyond)) else {
                continue;
            };
            let Some(high) = tile_of(Point2::new(place.x + beyond, place.y + beyond)) else {
                continue;
            };
            for row in low.1..=high.1 {
                for col in low.0..=high.0 {
                    if let Some(tile) = self.tile_mut((col, row)) {
                        tile.insert([point]);
                    }
                }
            }
        }
    }

    /// The surfel nearest to a place, if one is within reach; see [`SurfelMap::nearest`].
    #[inline]
    #[must_use]
    pub fn nearest(&self, place: Point2<f64>) -> Option<&Surfel> {
        let index = self.index(tile_of(place)?)?;
        self.tiles.get(index)?.as_ref()?.nearest(place)
    }

    /// All surfels, each once.
    pub fn surfels(&self) -> impl Iterator<Item = &Surfel> + Clone {
        let tiles = self.tiles.iter().enumerate();
        tiles.flat_map(move |(index, tile)| {
            let (col, row) = (index as i32 % self.cols, index as i32 / self.cols);
            let own = (self.low.0 + col, self.low.1 + row);
            let surfels = tile.iter().flat_map(|tile| tile.surfels());
            surfels.filter(move |surfel| tile_of(surfel.position) == Some(own))
        })
    }

    /// Number of tiles held, and how many of them are shared with no copy of this map.
    #[must_use]
    pub fn tile_counts(&self) -> [usize; 2] {
        let held = self.tiles.iter().flatten();
        let own = held.clone().filter(|tile| Arc::strong_count(tile) == 1);
        [held.clone().count(), own.count()]
    }

    /// The tile to write into, made if need be; `None` if the map may not grow.
    fn tile_mut(&mut self, at: (i32, i32)) -> Option<&mut SurfelMap> {
        if self.index(at).is_none() {
            self.grow(at)?;
        }
        let index = self.index(at)?;
        let tile = self.tiles.get_mut(index)?.get_or_insert_with(|| {
            let middle = |tile: i32| (f64::from(tile) + 0.5) * SIDE;
            let middle = Point2::new(middle(at.0), middle(at.1));
            Arc::new(SurfelMap::around(middle, self.config))
        });
        Some(Arc::make_mut(tile))
    }

    /// Rebuilds the directory so that it contains `at`.
    fn grow(&mut self, at: (i32, i32)) -> Option<()> {
        let along = |at: i32, low: i32, count: i32| match count {
            0 => (at - MARGIN, 2 * MARGIN + 1),
            _ => {
                let first = if at < low { at - MARGIN } else { low };
                let end = low + count;
                let end = if at >= end { at + MARGIN + 1 } else { end };
                (first, end - first)
            }
        };
        let (col, cols) = along(at.0, self.low.0, self.cols);
        let (row, rows) = along(at.1, self.low.1, self.rows);
        if cols > MOST_TILES || rows > MOST_TILES {
            return None;
        }
        let mut tiles = vec![None; (cols * rows) as usize];
        for (index, tile) in self.tiles.drain(..).enumerate() {
            let index = index as i32;
            let from_left = self.low.0 - col + index % self.cols;
            let from_below = self.low.1 - row + index / self.cols;
            tiles[(from_below * cols + from_left) as usize] = tile;
        }
        (self.low, self.cols, self.rows, self.tiles) = ((col, row), cols, rows, tiles);
        Some(())
    }

    #[inline]
    fn index(&self, (col, row): (i32, i32)) -> Option<usize> {
        let (col, row) = (col - self.low.0, row - self.low.1);
        let is_inside = col >= 0 && row >= 0 && col < self.cols && row < self.rows;
        is_inside.then(|| (row * self.cols + col) as usize)
    }
}

/// The tile that holds a place; `None` if it is not finite, or too far away to be held.
#[inline]
fn tile_of(place: Point2<f64>) -> Option<(i32, i32)> {
    let at = place * (1.0 / SIDE);
    let most = f64::from(MOST_TILES);
    // NaN compares false.
    let is_near = at.x.abs() < most && at.y.abs() < most;
    is_near.then(|| (at.x.floor() as i32, at.y.floor() as i32))
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;
    use proptest::prelude::*;

    use super::*;

    fn point(x: f64, y: f64) -> OrientedPoint {
        OrientedPoint {
            position: Point2::new(x, y),
            normal: Vector2::x(),
        }
    }

    /// The surfels of two maps, as numbers that can be compared.
    fn all(map: &SurfelTiles) -> Vec<(u64, u64, u64)> {
        let bits = |s: &Surfel| {
            let at = s.position;
            (at.x.to_bits(), at.y.to_bits(), s.weight.to_bits())
        };
        map.surfels().map(bits).collect()
    }

    proptest! {
        #[test]
        fn tiles_answer_as_one_map_does(
            places in prop::collection::vec((-14.0..14.0_f64, -14.0..14.0_f64), 1..150),
            looks in prop::collection::vec((-14.0..14.0_f64, -14.0..14.0_f64), 1..60),
        ) {
            let config = SurfelConfig { half_side: 16.0, ..SurfelConfig::default() };
            let (mut whole, mut tiles) = (SurfelMap::new(config), SurfelTiles::new(config));
            whole.insert(places.iter().map(|&(x, y)| point(x, y)));
            tiles.insert(places.iter().map(|&(x, y)| point(x, y)));
            prop_assert_eq!(tiles.surfels().count(), whole.surfels().len());
            // Near the points as well, where something is found.
            let near = places.iter().map(|&(x, y)| (x + 0.11, y - 0.07));
            for (x, y) in looks.into_iter().chain(near) {
                let place = Point2::new(x, y);
                prop_assert_eq!(tiles.nearest(place), whole.nearest(place), "{} {}", x, y);
            }
        }

        #[test]
        fn copies_that_share_tiles_are_as_full_copies_are(
            places in prop::collection::vec((-14.0..14.0_f64, -14.0..14.0_f64), 1..60),
            own in prop::collection::vec((-9.0..9.0_f64, -9.0..9.0_f64), 1..20),
            others in prop::collection::vec((-9.0..9.0_f64, -9.0..9.0_f64), 1..20),
        ) {
            let insert = |map: &mut SurfelTiles, places: &[(f64, f64)]| {
                map.insert(places.iter().map(|&(x, y)| point(x, y)));
            };
            let made_of = |parts: [&[(f64, f64)]; 2]| {
                let mut map = SurfelTiles::new(SurfelConfig::default());
                parts.iter().for_each(|part| insert(&mut map, part));
                map
            };
            let mut first = made_of([&places, &[]]);
            let mut second = first.clone();
            insert(&mut first, &own);
            insert(&mut second, &others);
            prop_assert_eq!(all(&first), all(&made_of([&places, &own])));
            prop_assert_eq!(all(&second), all(&made_of([&places, &others])));
        }
    }

    #[test]
    fn a_copy_owns_what_it_writes_and_shares_the_rest() {
        let mut map = SurfelTiles::new(SurfelConfig::default());
        map.insert((0..10).map(|i| point(3.0 + 6.4 * f64::from(i), 3.0)));
        assert_eq!(map.tile_counts(), [10, 10]);
        let mut copy = map.clone();
        assert_eq!(copy.tile_counts(), [10, 0]);
        copy.insert([point(3.5, 3.0)]);
        assert_eq!(copy.tile_counts(), [10, 1]);
        drop(map);
        assert_eq!(copy.tile_counts(), [10, 10]);
    }

    #[test]
    fn what_is_not_finite_or_too_far_is_dropped() {
        let mut map = SurfelTiles::new(SurfelConfig::default());
        let far = [
            (f64::NAN, 0.0),
            (0.0, f64::INFINITY),
            (1e9, 0.0),
            (6560.0, 0.0),
        ];
        map.insert(far.map(|(x, y)| point(x, y)));
        assert_eq!((map.surfels().count(), map.tile_counts()), (0, [0, 0]));
        map.insert([point(-40.0, 7.0)]);
        assert_eq!(map.surfels().count(), 1);
        assert!(map.nearest(Point2::new(f64::NAN, 1e300)).is_none());
        assert!(map.nearest(Point2::new(-40.1, 7.0)).is_some());
    }
}
