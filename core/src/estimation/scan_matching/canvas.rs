//! The map that is shown: keyframes drawn into the grid, and drawn anew where a closed loop has moved them.
//!
//! In: scans that became keyframes, and the poses of the submaps. Out: the grid. A new grid is made beside the old one,
//! some keyframes at each scan, and takes its place when it is complete: no scan has to wait for it.

use nalgebra::Point2;

use super::super::pose_graph::differs;
use super::ScanMatcher;
use crate::geom::Pose2;
use crate::map::Grid;
use crate::points::{Beam, Points};
use crate::robot::Stamp;

/// A grid in the making.
#[derive(Clone, Debug)]
pub(super) struct Redraw {
    pub(super) grid: Grid,
    pub(super) next: usize,
}

/// What is drawn: the ends of the beams, in single precision.
#[derive(Clone, Debug)]
pub(super) struct Keyframe {
    pub(super) submap: usize,
    pub(super) submap_from_robot: Pose2,
    pub(super) origin: Point2<f64>,
    pub(super) ends: Vec<[f32; 2]>,
    pub(super) hits: Vec<bool>,
}

impl ScanMatcher {
    /// Begins to draw the map anew if the submaps have moved since it was drawn.
    pub(super) fn begin_redraw(&mut self, shift: f64) {
        let moved = self
            .submaps
            .iter()
            .any(|s| differs(&s.map_from_submap, &s.drawn_at, shift, 0.1 * shift));
        if moved && let Ok(grid) = Grid::new(self.config.grid) {
            for submap in &mut self.submaps {
                submap.drawn_at = submap.map_from_submap;
            }
            self.redraw = Some(Redraw { grid, next: 0 });
        }
    }

    pub(super) fn draw_on(&mut self, budget: usize) {
        let Some(redraw) = &mut self.redraw else {
            return;
        };
        for keyframe in self.keyframes.iter().skip(redraw.next).take(budget) {
            if let Some(submap) = self.submaps.get(keyframe.submap) {
                keyframe.draw(
                    &mut redraw.grid,
                    &(submap.drawn_at * keyframe.submap_from_robot),
                );
            }
            redraw.next += 1;
        }
        if redraw.next >= self.keyframes.len()
            && let Some(redraw) = self.redraw.take()
        {
            self.grid = redraw.grid;
            self.grid_version += 1;
        }
    }

    pub(super) fn keyframe_of(&self, points: &Points) -> Keyframe {
        let mut keyframe = Keyframe {
            submap: self.submaps.len() - 1,
            submap_from_robot: self.submap_from_robot,
            origin: points.sensor_in_robot,
            ends: Vec::with_capacity(points.beams.len()),
            hits: Vec::with_capacity(points.beams.len()),
        };
        for beam in &points.beams {
            let along = beam.end_in_robot - beam.origin_in_robot;
            let length = if beam.is_hit {
                1.0
            } else {
                (self.config.no_return_clears / beam.range).min(1.0)
            };
            let end = beam.origin_in_robot + along * length;
            keyframe.ends.push([end.x as f32, end.y as f32]);
            keyframe.hits.push(beam.is_hit);
        }
        keyframe
    }
}

impl Keyframe {
    /// The beams, from the sensor to their ends, in the submap.
    pub(super) fn rays(&self) -> impl Iterator<Item = (Point2<f64>, Point2<f64>)> + '_ {
        let at = self.submap_from_robot;
        self.ends.iter().map(move |end| {
            let end = Point2::new(f64::from(end[0]), f64::from(end[1]));
            (at * self.origin, at * end)
        })
    }

    pub(super) fn draw(&self, grid: &mut Grid, map_from_robot: &Pose2) {
        let beams =
            self.ends
                .iter()
                .zip(&self.hits)
                .enumerate()
                .map(|(beam_idx, (end, &is_hit))| {
                    let end_in_robot = Point2::new(f64::from(end[0]), f64::from(end[1]));
                    Beam {
                        beam_idx,
                        origin_in_robot: self.origin,
                        end_in_robot,
                        range: (end_in_robot - self.origin).norm(),
                        sigma: 0.01,
                        is_hit,
                    }
                });
        let points = Points {
            stamp: Stamp::default(),
            sensor_in_robot: self.origin,
            bearing_sigma: 0.0,
            beams: beams.collect(),
        };
        grid.insert(&points, map_from_robot);
    }
}
