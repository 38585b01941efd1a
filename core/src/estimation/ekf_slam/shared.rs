//! Which lines and points of a scan were found by the same beams, and how much each of them is then
//! believed.
//!
//! A corner on two walls is where their lines cross: its noise is that of the lines. Used as a
//! measurement of its own, it would repeat what the lines have said, and the filter would count one
//! scan twice. How the two are correlated depends on which beams each fit used, so nothing is
//! assumed about it. By covariance intersection, lines with covariance R and points with covariance
//! S, with any cross-covariance C, are replaced by independent ones with larger covariances:
//!
//! ```text
//! ⎡ R/(1-w)   0  ⎤   ⎡ R   C ⎤
//! ⎢              ⎥ ≥ ⎢       ⎥   for every C
//! ⎣   0     S/w  ⎦   ⎣ Cᵀ  S ⎦
//! ```
//!
//! w is [`EkfConfig::shared_part`](super::EkfConfig): the points keep that part of their
//! information, the lines the rest of theirs. It is small, because the lines are fitted to all
//! beams of a wall and leave a corner little to add. Lines and points that share no beam keep all
//! of theirs.
//!
//! Two corners at the ends of a short wall share the beams of that wall. Since 2 xᵀ C y ≤ xᵀ S x +
//! yᵀ T y for every such pair, a point that shares beams with k others is covered by 1 + k times
//! its covariance.
//!
//! Source: Julier & Uhlmann (1997), "A non-divergent estimation algorithm in the presence of
//! unknown correlations".

use std::ops::RangeInclusive;

use super::point::is_landmark;
use crate::features::{LineFeature, PointFeature};

/// For each line and each point of a scan, whether it shares beams with one of the other kind.
#[derive(Clone, Debug, Default)]
pub(super) struct SharedBeams {
    lines: Vec<bool>,
    points: Vec<SharedPoint>,
}

/// What a point shares beams with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct SharedPoint {
    /// With a line.
    pub(super) is_on_line: bool,
    /// With this many other points.
    pub(super) others: usize,
}

impl SharedBeams {
    pub(super) fn find(&mut self, lines: &[LineFeature], points: &[PointFeature]) {
        let of_line = |line: &LineFeature| [line.first_beam, line.last_beam];
        let used = || points.iter().filter(|point| is_landmark(&point.kind));
        let is_line_shared = |line| {
            let beams = of_line(line);
            used().any(|point| overlap(beams, point.beams))
        };
        let shared_point = |point: &PointFeature| SharedPoint {
            is_on_line: lines.iter().any(|line| overlap(of_line(line), point.beams)),
            // Do not count the point itself.
            others: used()
                .filter(|other| overlap(other.beams, point.beams))
                .count()
                .saturating_sub(1),
        };
        self.lines.clear();
        self.points.clear();
        self.lines.extend(lines.iter().map(is_line_shared));
        self.points.extend(points.iter().map(shared_point));
    }

    pub(super) fn has_line(&self, index: usize) -> bool {
        self.lines.get(index).is_some_and(|shared| *shared)
    }

    pub(super) fn point(&self, index: usize) -> SharedPoint {
        self.points.get(index).copied().unwrap_or_default()
    }
}

/// Whether two runs of beams have a beam in common.
fn overlap(a: [usize; 2], b: [usize; 2]) -> bool {
    let (a, b) = (runs(a), runs(b));
    let mut pairs = a.iter().flat_map(|a| b.iter().map(move |b| (a, b)));
    pairs.any(|(a, b)| a.start() <= b.end() && b.start() <= a.end())
}

/// From one beam to another, wrapping past the end of the scan if the first is greater.
fn runs([first, last]: [usize; 2]) -> [RangeInclusive<usize>; 2] {
    if first <= last {
        // The same run twice.
        [first..=last, first..=last]
    } else {
        [first..=usize::MAX, 0..=last]
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix4, Point2, SMatrix};
    use proptest::prelude::*;

    use super::*;
    use crate::features::PointKind;

    fn line(first_beam: usize, last_beam: usize) -> LineFeature {
        LineFeature {
            first_beam,
            last_beam,
            ..super::super::tests::feature(0.1, 2.0)
        }
    }

    fn point(beams: [usize; 2]) -> PointFeature {
        PointFeature {
            beams,
            ..super::super::tests::point(Point2::new(1.0, 2.0), PointKind::Corner)
        }
    }

    #[test]
    fn beams_are_shared_also_across_the_end_of_the_scan() {
        let lines = [line(10, 30), line(40, 50), line(350, 5)];
        for (beams, expect) in [
            ([20, 35], [true, false, false]),
            ([30, 40], [true, true, false]),
            ([31, 39], [false, false, false]),
            ([358, 2], [false, false, true]),
            ([355, 359], [false, false, true]),
            ([0, 4], [false, false, true]),
            ([355, 12], [true, false, true]),
        ] {
            let mut shared = SharedBeams::default();
            shared.find(&lines, &[point(beams)]);
            assert_eq!([0, 1, 2].map(|i| shared.has_line(i)), expect, "{beams:?}");
            assert_eq!(shared.point(0).is_on_line, expect.contains(&true));
            assert!(!shared.has_line(3));
            assert_eq!(shared.point(1), SharedPoint::default());
        }
    }

    #[test]
    fn corners_of_a_short_wall_know_of_each_other() {
        let mut shared = SharedBeams::default();
        shared.find(
            &[],
            &[
                point([10, 30]),
                point([25, 50]),
                point([45, 60]),
                point([70, 80]),
            ],
        );
        assert_eq!([0, 1, 2, 3].map(|i| shared.point(i).others), [1, 2, 1, 0]);
    }

    proptest! {
        /// The bound given at the top of the module, for correlations of any size up to 1.
        #[test]
        fn parts_of_both_cover_every_correlation(
            w in 0.01..0.5_f64, entries in prop::array::uniform16(-1.0..1.0_f64),
        ) {
            // Any covariance of four numbers, up to singular ones.
            let root = Matrix4::from_row_slice(&entries);
            let joint = root * root.transpose();
            let mut cover = Matrix4::zeros();
            for (at, part) in [(0, 1.0 - w), (2, w)] {
                let block = joint.fixed_view::<2, 2>(at, at) / part;
                cover.fixed_view_mut::<2, 2>(at, at).copy_from(&block);
            }
            let least = (cover - joint).symmetric_eigenvalues().min();
            prop_assert!(least > -1e-9, "{least}");
        }

        /// Three points in a row; neighbours share beams.
        #[test]
        fn points_in_a_row_are_covered(entries in prop::array::uniform16(-1.0..1.0_f64)) {
            // Points 1 and 2 have two causes in common, 2 and 3 two others; 1 and 3 none.
            let mut root = SMatrix::<f64, 6, 4>::zeros();
            root.fixed_view_mut::<4, 2>(0, 0).copy_from_slice(&entries[..8]);
            root.fixed_view_mut::<4, 2>(2, 2).copy_from_slice(&entries[8..16]);
            let joint = root * root.transpose();
            let mut cover = SMatrix::<f64, 6, 6>::zeros();
            for (at, times) in [(0, 2.0), (2, 3.0), (4, 2.0)] {
                let block = joint.fixed_view::<2, 2>(at, at) * times;
                cover.fixed_view_mut::<2, 2>(at, at).copy_from(&block);
            }
            let least = (cover - joint).symmetric_eigenvalues().min();
            prop_assert!(least > -1e-9, "{least}");
        }
    }
}
