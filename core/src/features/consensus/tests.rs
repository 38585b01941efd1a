use nalgebra::Point2;
use proptest::prelude::*;

use super::*;
use crate::features::columns::Noise;
use crate::points::fixture::hit;

fn columns(points: &[(f64, f64)]) -> Columns {
    let beams: Vec<_> = (points.iter().enumerate())
        .map(|(i, &(x, y))| hit(i, Point2::new(x, y)))
        .collect();
    let mut columns = Columns::default();
    let all = std::iter::once(0..beams.len());
    columns.load(&beams, all, Noise::default());
    columns
}

proptest! {
    /// By definition: over all ranges whose ends are inliers and that skip no more than allowed.
    #[test]
    fn longest_stretch_is_the_best_of_all(inliers in prop::collection::vec(any::<bool>(), 0..40)) {
        let found = longest_stretch(0..inliers.len(), |i| inliers[i]);
        let mut most = 0;
        for from in 0..inliers.len() {
            for to in from + 1..=inliers.len() {
                let range = &inliers[from..to];
                let gaps = range.split(|on| *on).map(<[bool]>::len);
                if range[0] && range[to - from - 1] && gaps.max().unwrap() <= MAX_SKIP {
                    most = most.max(range.iter().filter(|on| **on).count());
                }
            }
        }
        let own = inliers[found.range.clone()].iter().filter(|on| **on).count();
        prop_assert_eq!((found.n_inliers, own), (most, most));
    }

    /// No other border has a smaller sum of squares.
    #[test]
    fn border_is_the_best_of_all(
        wiggle in prop::collection::vec(-0.03..0.03_f64, 40), border in 12..28_usize, turn in 0.2..2.5_f64,
    ) {
        let (sin, cos) = crate::geom::sin_cos(turn);
        let points: Vec<_> = (0..40).map(|i| {
            let along = 0.05 * (i as f64 - 20.0);
            if i < 20 { (2.0 + wiggle[i], along) } else { (2.0 + along * sin, along * cos + wiggle[i]) }
        }).collect();
        let mut columns = columns(&points);
        let mut pieces = [Piece::whole(&columns, 0..border), Piece::whole(&columns, border..40)];
        let lines = pieces.each_ref().map(|piece| piece.moments.line());
        settle_borders(&mut columns, &mut pieces, 7);
        prop_assert!(pieces[0].end == pieces[1].start && pieces[0].n_points() >= 7 && pieces[1].n_points() >= 7);
        let cost = |border: usize| -> f64 {
            (0..40).map(|i| {
                let (normal, r) = lines[usize::from(i >= border)];
                let off = normal.x * points[i].0 + normal.y * points[i].1 - r;
                off * off
            }).sum()
        };
        let least = (border - 7.max(border.saturating_sub(27))..=border).chain(7..=33)
            .filter(|&b| b.abs_diff(border) <= BORDER_REACH)
            .filter(|b| (7..=33).contains(b))
            .map(cost).fold(f64::INFINITY, f64::min);
        prop_assert!(cost(pieces[0].end) <= least + 1e-9, "{} against {least}", cost(pieces[0].end));
    }
}

#[test]
fn refinement_grows_from_a_few_points_to_the_whole_wall_and_no_further() {
    // 30 points on x = 2, then 10 on a wall at right angles to it.
    let mut points: Vec<_> = (0..30).map(|i| (2.0, -1.5 + 0.1 * f64::from(i))).collect();
    points.extend((1..=10).map(|i| (2.0 - 0.1 * f64::from(i), 1.5)));
    points[12].0 = 2.4;
    let mut columns = columns(&points);
    let guess = |index: usize| (3..8).contains(&index);
    let found = refined(&columns, &(0..40), (3.0, 5), |_| true, guess).unwrap();
    assert_eq!(found.stretch.range, 0..30);
    let piece = found.take(&mut columns, 3.0);
    assert!(!columns.is_kept(12) && columns.kept(piece.range()).count() == 29);
    let (normal, r) = piece.moments.line();
    assert!((normal.x.abs() - 1.0).abs() < 1e-12 && (r.abs() - 2.0).abs() < 1e-12);
    // Points that are already taken stay out.
    let found = refined(&columns, &(0..40), (3.0, 5), |i| i < 20, guess).unwrap();
    assert_eq!(found.stretch.range, 0..20);
    assert!(refined(&columns, &(0..40), (3.0, 31), |_| true, guess).is_none());
}
