//! The map that is shown: keyframes drawn into the grid, and redrawn where a loop closure has moved
//! them.
//!
//! In: scans that became keyframes, and the poses of the submaps. Out: the grid. A new grid is
//! drawn beside the old one, some keyframes at each scan, and replaces it when complete: no scan
//! has to wait for it. Of a keyframe, only what is certain is drawn ([`Evidence::certain`]):
//! treating beams as thin and exact would clear walls that they meet at a flat angle.
//!
//! Many scans together know better than one where a surface stands. A keyframe's points on surfaces
//! are moved onto the surfaces of its submap when it is made, and once more when the submap is
//! closed. Otherwise range noise makes walls two cells thick, and a beam never gets behind a wall
//! to clear the second cell.

use nalgebra::Point2;

use super::super::pose_graph::differs;
use super::ScanMatcher;
use super::edits::{erase, lay_walls};
use crate::geom::{Length, Pose2};
use crate::map::{Evidence, Grid, SEEN_OFTEN, SurfelMap};
use crate::points::{Beam, Points};
use crate::robot::Stamp;
use crate::snapshot::snapshot;

/// A point is moved onto a surface of its submap if it is no farther away than this, m.
const SETTLES: f64 = 0.1;

/// A grid that is being drawn.
#[derive(Clone, Debug)]
pub(super) struct Redraw {
    pub(super) grid: Grid,
    pub(super) next: usize,
}

/// What is drawn of a scan, in single precision.
#[derive(Clone, Debug)]
pub(super) struct Keyframe {
    pub(super) submap: usize,
    pub(super) submap_from_robot: Pose2,
    /// Free rays: from (x, y) to (x, y), robot frame, m.
    free: Vec<[[f32; 2]; 2]>,
    /// Points on surfaces, robot frame, m.
    hits: Vec<[f32; 2]>,
}

impl ScanMatcher {
    /// Begins to redraw the map if the submaps have moved since it was drawn, or keyframes `within`
    /// them. Keyframes move all the time, but only by little: they can wait until submaps move.
    pub(super) fn begin_redraw(&mut self, shift: f64, within: bool) {
        let turn = self.config.redraw_turn * shift;
        let moved = self
            .submaps
            .iter()
            .any(|s| differs(&s.map_from_submap, &s.drawn_at, shift, turn));
        let moved = moved || (within && self.moved_within > shift);
        if moved && let Ok(grid) = Grid::new(self.config.grid) {
            for submap in &mut self.submaps {
                submap.drawn_at = submap.map_from_submap;
            }
            self.moved_within = 0.0;
            let next = self.first_drawn();
            self.redraw = Some(Redraw { grid, next });
        }
    }

    /// Redraws the whole map into an empty grid.
    pub(super) fn redraw_at_once(&mut self) {
        for submap in &mut self.submaps {
            submap.drawn_at = submap.map_from_submap;
        }
        self.moved_within = 0.0;
        let Ok(grid) = Grid::new(self.config.grid) else {
            return;
        };
        let next = self.first_drawn();
        self.redraw = Some(Redraw { grid, next });
        self.draw_on(usize::MAX);
    }

    pub(super) fn draw_on(&mut self, budget: usize) {
        let Some(redraw) = &mut self.redraw else {
            return;
        };
        for keyframe in self.keyframes.iter().skip(redraw.next).take(budget) {
            erase(&self.edits, &self.submaps, redraw.next, &mut redraw.grid);
            let drawn_at = self.submaps[keyframe.submap].drawn_at;
            keyframe.draw(&mut redraw.grid, &(drawn_at * keyframe.submap_from_robot));
            redraw.next += 1;
        }
        if redraw.next >= self.keyframes.len()
            && let Some(mut redraw) = self.redraw.take()
        {
            erase(&self.edits, &self.submaps, redraw.next, &mut redraw.grid);
            lay_walls(&self.edits, &self.submaps, &mut redraw.grid);
            self.grid = redraw.grid;
            self.grid_version += 1;
        }
    }

    /// What is drawn of a scan taken at the current pose; `sigmas` as in [`ScanMatcher::update`].
    pub(super) fn keyframe_of(&self, points: &Points, sigmas: &[f64]) -> Keyframe {
        let heading = self.local.cov[(2, 2)].max(0.0);
        let sigmas: Vec<f64> = sigmas.iter().map(|s| (s * s + heading).sqrt()).collect();
        let config = &self.config.evidence;
        let evidence = Evidence::certain(points, &sigmas, self.grid.resolution(), config);
        let single = |p: &Point2<f64>| [p.x as f32, p.y as f32];
        Keyframe {
            submap: self.submaps.len() - 1,
            submap_from_robot: self.local.pose,
            free: (evidence.free.iter())
                .map(|way| way.each_ref().map(single))
                .collect(),
            hits: evidence.hits.iter().map(single).collect(),
        }
    }
}

impl Keyframe {
    /// Moves its points onto those surfaces of its submap that were seen often and face the same
    /// side: a thin wall has two sides.
    pub(super) fn settle(&mut self, surfels: &SurfelMap) {
        let at = self.submap_from_robot;
        for hit in &mut self.hits {
            let place = at * double(*hit);
            let Some(surfel) = surfels.nearest(place) else {
                continue;
            };
            let off = surfel.position - place;
            let faces = surfel.normal.dot(&(at.position() - place)) > 0.0;
            if faces && surfel.weight >= SEEN_OFTEN && off.length() <= SETTLES {
                let by = at.inverse().rotate(surfel.normal * surfel.normal.dot(&off));
                hit[0] += by.x as f32;
                hit[1] += by.y as f32;
            }
        }
    }

    /// The beams in the submap frame, from the sensor to where they are surely free.
    pub(super) fn rays(&self) -> impl Iterator<Item = [Point2<f64>; 2]> + '_ {
        self.rays_from(&self.submap_from_robot)
    }

    /// The same, with the robot at `at`.
    pub(super) fn rays_from(&self, at: &Pose2) -> impl Iterator<Item = [Point2<f64>; 2]> + '_ {
        let at = *at;
        self.free
            .iter()
            .map(move |way| way.map(|end| at * double(end)))
    }

    /// Its points on surfaces as a scan, each with standard deviation `sigma`, m, seen from where
    /// its first beam began.
    pub(super) fn points(&self, sigma: f64) -> Points {
        let origin = self.free.first().map(|[begin, _]| double(*begin));
        let origin = origin.unwrap_or_default();
        let hits = self.hits.iter().copied().map(double).enumerate();
        Points {
            stamp: Stamp::default(),
            sensor_in_robot: origin,
            bearing_sigma: 0.0,
            beams: hits
                .map(|(beam_idx, end_in_robot)| Beam {
                    beam_idx,
                    origin_in_robot: origin,
                    end_in_robot,
                    range: (end_in_robot - origin).length(),
                    sigma,
                    is_hit: true,
                    quality: None,
                    age: 0.0,
                })
                .collect(),
        }
    }

    pub(super) fn draw(&self, grid: &mut Grid, map_from_robot: &Pose2) {
        let evidence = Evidence {
            free: self.free.iter().map(|way| way.map(double)).collect(),
            hits: self.hits.iter().copied().map(double).collect(),
        };
        grid.draw(&evidence, map_from_robot);
    }
}

fn double([x, y]: [f32; 2]) -> Point2<f64> {
    Point2::new(f64::from(x), f64::from(y))
}

snapshot!(Redraw { grid, next });
snapshot!(Keyframe {
    submap,
    submap_from_robot,
    free,
    hits,
});

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;
    use crate::map::SurfelConfig;
    use crate::points::OrientedPoint;

    /// Where points at these x, 2 m to the side of a robot at (1, 0.5) that looks along -y, are
    /// drawn if the submap has a wall at x = 2, seen `often` times from the left.
    fn settled(places: &[f64], often: usize) -> Vec<f64> {
        let mut surfels = SurfelMap::new(SurfelConfig::default());
        for _ in 0..often {
            surfels.insert((0..40).map(|at| OrientedPoint {
                position: Point2::new(2.0, 0.1 * f64::from(at)),
                normal: Vector2::new(-1.0, 0.0),
            }));
        }
        let at = Pose2::new(1.0, 0.5, -std::f64::consts::FRAC_PI_2);
        let mut keyframe = Keyframe {
            submap: 0,
            submap_from_robot: at,
            free: vec![],
            hits: (places.iter())
                .map(|&x| at.inverse() * Point2::new(x, 2.51))
                .map(|hit| [hit.x as f32, hit.y as f32])
                .collect(),
        };
        keyframe.settle(&surfels);
        let hits = keyframe.hits.iter();
        hits.map(|hit| at * double(*hit))
            .inspect(|place| assert!((place.y - 2.51).abs() < 1e-5, "moved along the wall"))
            .map(|place| place.x)
            .collect()
    }

    #[test]
    fn points_are_drawn_on_the_wall_that_many_scans_know() {
        for (given, expected) in [(1.95, 2.0), (2.06, 2.0), (2.15, 2.15)] {
            let found = settled(&[given], 4)[0];
            assert!((found - expected).abs() < 1e-5, "{given}: {found}");
        }
        // Seen only once, it may be anything.
        assert!((settled(&[2.06], 1)[0] - 2.06).abs() < 1e-5);
    }

    #[test]
    fn the_other_side_of_a_thin_wall_stays_where_it_was_seen() {
        let mut surfels = SurfelMap::new(SurfelConfig::default());
        for _ in 0..4 {
            surfels.insert([OrientedPoint {
                position: Point2::new(2.0, 0.5),
                normal: Vector2::new(-1.0, 0.0),
            }]);
        }
        // From the far side, the same surface is seen from behind.
        let mut keyframe = Keyframe {
            submap: 0,
            submap_from_robot: Pose2::new(3.0, 0.5, 0.0),
            free: vec![],
            hits: vec![[-0.94, 0.0]],
        };
        keyframe.settle(&surfels);
        assert_eq!(keyframe.hits, [[-0.94, 0.0]]);
    }
}
