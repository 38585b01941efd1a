//! How far an estimated trajectory is from the true one.

use nalgebra::{Matrix2, Point2, Vector2};

use crate::geom::Pose2;

/// Absolute trajectory error: root mean square distance, m, of estimated from true positions after
/// the rigid motion that aligns them best. `None` if there are fewer than two pairs.
///
/// Source: Sturm et al. (2012), "A benchmark for the evaluation of RGB-D SLAM systems", §V;
/// alignment by Umeyama (1991) without scale, in two dimensions.
#[must_use]
pub fn ate_rmse(truth: &[Point2<f64>], estimate: &[Point2<f64>]) -> Option<f64> {
    let truth_from_estimate = align(truth, estimate)?;
    let squares: f64 = truth
        .iter()
        .zip(estimate)
        .map(|(t, e)| (t - truth_from_estimate * *e).norm_squared())
        .sum();
    Some((squares / truth.len().min(estimate.len()) as f64).sqrt())
}

/// The rigid motion `target_from_source` with the least sum of squared distances between paired
/// points.
///
/// Source: Umeyama (1991), eqs. (40)-(42); in the plane the rotation has a closed form, the angle
/// of Σ s × t over Σ s · t.
#[must_use]
pub fn align(target: &[Point2<f64>], source: &[Point2<f64>]) -> Option<Pose2> {
    let n = target.len().min(source.len());
    if n < 2 {
        return None;
    }
    let mean = |points: &[Point2<f64>]| {
        points
            .iter()
            .take(n)
            .map(|p| p.coords)
            .sum::<Vector2<f64>>()
            / n as f64
    };
    let (target_mean, source_mean) = (mean(target), mean(source));
    let cross: Matrix2<f64> = target
        .iter()
        .zip(source)
        .map(|(t, s)| (s.coords - source_mean) * (t.coords - target_mean).transpose())
        .sum();
    Some(closest(&cross, target_mean, source_mean))
}

/// The motion of [`align`], from the sum of products of centred coordinates and from the means.
fn closest(cross: &Matrix2<f64>, target_mean: Vector2<f64>, source_mean: Vector2<f64>) -> Pose2 {
    let turn = libm::atan2(cross[(0, 1)] - cross[(1, 0)], cross[(0, 0)] + cross[(1, 1)]);
    let rotation = Pose2::new(0.0, 0.0, turn);
    let shift = target_mean - rotation.rotate(source_mean);
    Pose2::new(shift.x, shift.y, turn)
}

/// [`align`] for pairs that arrive one by one: keeps sums, and no points.
#[derive(Clone, Debug, Default)]
pub struct Alignment {
    /// The first pair, used as the origin: sums of coordinates far from zero lose digits.
    first: Option<[Vector2<f64>; 2]>,
    count: usize,
    target: Vector2<f64>,
    source: Vector2<f64>,
    /// Σ s tᵀ.
    cross: Matrix2<f64>,
}

impl Alignment {
    /// Takes the next pair.
    pub fn push(&mut self, target: Point2<f64>, source: Point2<f64>) {
        let first = self.first.get_or_insert([target.coords, source.coords]);
        let (target, source) = (target.coords - first[0], source.coords - first[1]);
        self.count += 1;
        self.target += target;
        self.source += source;
        self.cross += source * target.transpose();
    }

    /// `None` if there are fewer than two pairs.
    #[must_use]
    pub fn target_from_source(&self) -> Option<Pose2> {
        let [first_target, first_source] = self.first.filter(|_| self.count >= 2)?;
        let n = self.count as f64;
        let cross = self.cross - self.source * self.target.transpose() / n;
        let (target, source) = (self.target / n, self.source / n);
        Some(closest(
            &cross,
            first_target + target,
            first_source + source,
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Length;
    use proptest::prelude::*;

    fn points() -> impl Strategy<Value = Vec<Point2<f64>>> {
        prop::collection::vec(
            (-9.0..9.0_f64, -9.0..9.0_f64).prop_map(|(x, y)| Point2::new(x, y)),
            3..20,
        )
    }

    proptest! {
        #[test]
        fn a_moved_trajectory_has_no_error(truth in points(), x in -9.0..9.0_f64, y in -9.0..9.0_f64, t in -3.1..3.1_f64) {
            let motion = Pose2::new(x, y, t);
            let moved: Vec<_> = truth.iter().map(|p| motion * *p).collect();
            prop_assert!(ate_rmse(&truth, &moved).unwrap() < 1e-9);
        }

        #[test]
        fn no_other_motion_is_closer(truth in points(), estimate in points(), dx in -0.5..0.5_f64, dt in -0.5..0.5_f64) {
            let best = ate_rmse(&truth, &estimate).unwrap();
            let n = truth.len().min(estimate.len());
            let other = Pose2::new(dx, -dx, dt) * align(&truth, &estimate).unwrap();
            let squares: f64 = truth.iter().zip(&estimate).map(|(t, e)| (t - other * *e).norm_squared()).sum();
            prop_assert!(best <= (squares / n as f64).sqrt() + 1e-9);
        }
    }

    #[test]
    fn one_point_cannot_be_aligned() {
        assert_eq!(ate_rmse(&[Point2::origin()], &[Point2::origin()]), None);
    }

    #[test]
    fn bent_line_has_the_error_of_its_bend() {
        // Truth: three points on the x axis. Estimate: the middle one lifted by 0.3 m. After
        // alignment the residuals are 0.1, 0.2, 0.1 m across.
        let line = |y: f64| {
            [
                Point2::new(-1.0, 0.0),
                Point2::new(0.0, y),
                Point2::new(1.0, 0.0),
            ]
        };
        let expect = ((0.01 + 0.04 + 0.01) / 3.0_f64).sqrt();
        assert!((ate_rmse(&line(0.0), &line(0.3)).unwrap() - expect).abs() < 1e-12);
    }

    #[test]
    fn pairs_one_by_one_align_as_all_at_once_far_from_zero_too() {
        let source: Vec<_> = (0..40)
            .map(f64::from)
            .map(|i| Point2::new(5e6 + 3.0 * libm::sin(0.3 * i), 4e5 + 0.2 * i))
            .collect();
        let motion = Pose2::new(-3.0, 7.0, 2.5);
        let noise = |i: usize| 0.01 * libm::cos(i as f64);
        let target: Vec<_> = (source.iter().enumerate())
            .map(|(i, p)| motion * (*p - Vector2::new(5e6, 4e5)) + Vector2::new(noise(i), 0.0))
            .collect();
        let mut alignment = Alignment::default();
        assert_eq!(alignment.target_from_source(), None);
        for (target, source) in target.iter().zip(&source) {
            alignment.push(*target, *source);
        }
        let (one_by_one, all) = (
            alignment.target_from_source().unwrap(),
            align(&target, &source).unwrap(),
        );
        for point in &source {
            let off = (one_by_one * *point - all * *point).length();
            assert!(off < 1e-6, "{off}");
        }
        assert!((all.heading() - 2.5).abs() < 0.01);
    }
}
