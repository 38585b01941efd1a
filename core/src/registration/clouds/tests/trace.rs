//! A trace shows what the method does: the same result to the bit, and correspondences that brute
//! force finds as well.

use super::*;
use crate::registration::{Correspondence, Iteration};

fn pair() -> (Cloud, Cloud, Pose2) {
    let truth = Pose2::new(0.25, -0.15, 0.12);
    let fixed = look(&room(), &Pose2::identity(), 0.01, 40);
    let moving = look(&room(), &truth, 0.01, 41);
    (moving, fixed, Pose2::new(0.05, 0.05, -0.05))
}

fn trace(method: &CloudMethod) -> Trace {
    let (moving, fixed, start) = pair();
    trace_clouds(&moving, &fixed, &start, method, &JudgeConfig::default())
}

#[test]
fn a_trace_ends_where_the_plain_call_does_to_the_bit() {
    let (moving, fixed, start) = pair();
    for (name, method) in CloudMethod::all() {
        let judge = JudgeConfig::default();
        let plain = register_clouds(&moving, &fixed, &start, &method, &judge);
        let Trace {
            registration,
            iterations,
        } = trace_clouds(&moving, &fixed, &start, &method, &judge);
        assert_eq!(registration, plain, "{name}");
        // A correlation begins with its search.
        let more = usize::from(name == "correlation");
        assert_eq!(iterations.len(), plain.iterations + more, "{name}");
    }
}

#[test]
fn a_trace_begins_at_the_start_and_closes_in() {
    let (_, _, start) = pair();
    for (name, method) in CloudMethod::all() {
        let Trace {
            registration,
            iterations,
        } = trace(&method);
        let (first, last) = (iterations.first().unwrap(), iterations.last().unwrap());
        // Coherent point drift first moves the means onto each other.
        if name == "cpd" {
            assert!(first.pose.minus(&start).z.abs() < 1e-12, "{name}");
        } else {
            assert!(first.pose.minus(&start).length() < 1e-12, "{name}");
        }
        let left = registration.estimate.pose.minus(&last.pose);
        assert!(left.length() < 5e-3, "{name}: the last step was {left}");
        assert!(last.width <= first.width, "{name}");
        assert!(last.correspondences.len() > 150, "{name}");
        for Iteration {
            pose,
            residual,
            correspondences,
            ..
        } in &iterations
        {
            let most = correspondences.iter().map(|c| c.weight).fold(0.0, f64::max);
            assert!(correspondences.is_empty() || most == 1.0, "{name}: {most}");
            let distance = |c: &Correspondence| (c.to - c.from).norm_squared();
            let total: f64 = correspondences.iter().map(|c| c.weight).sum();
            let squares: f64 = correspondences.iter().map(|c| c.weight * distance(c)).sum();
            let expected = if total > 0.0 { squares / total } else { 0.0 };
            assert!((residual * residual - expected).abs() < 1e-12, "{name}");
            assert!(pose.is_finite(), "{name}");
        }
    }
}

/// Whether `point` is a point of the cloud at this pose.
fn lies_in(cloud: &Cloud, pose: &Pose2, point: &Point2<f64>) -> bool {
    let lies = |p: &Point2<f64>| (*pose * *p - point).length() < 1e-9;
    cloud.points().iter().any(lies)
}

#[test]
fn pairs_of_points_are_the_nearest_ones() {
    let (moving, fixed, _) = pair();
    let method = CloudMethod::Icp(IcpConfig {
        association: Association::Nearest,
        kernel: RobustKernel::None,
        ..IcpConfig::point_to_point()
    });
    for iteration in trace(&method).iterations {
        for pair in &iteration.correspondences {
            assert!(lies_in(&moving, &iteration.pose, &pair.from));
            let distances = fixed.points().iter().map(|p| (p - pair.from).length());
            let nearest = distances.fold(f64::INFINITY, f64::min);
            assert!(((pair.to - pair.from).length() - nearest).abs() < 1e-12);
            assert_eq!(pair.weight, 1.0, "no kernel");
        }
    }
}

/// Root mean square distance from the mean, m.
fn extent(points: &[Point2<f64>]) -> f64 {
    let count = points.len() as f64;
    let mean = points
        .iter()
        .map(|p| p.coords)
        .sum::<nalgebra::Vector2<f64>>()
        / count;
    let squares = points.iter().map(|p| (p.coords - mean).norm_squared());
    (squares.sum::<f64>() / count).sqrt()
}

/// Coherent point drift and mixtures pull every point to the mean of all fixed ones, weighted by
/// its Gaussian: here with a double loop, without a fast transform.
#[test]
fn soft_correspondences_are_those_of_a_double_loop() {
    let (moving, fixed, _) = pair();
    let outliers = CpdConfig::default().outliers;
    for name in ["cpd", "gmm"] {
        let methods = CloudMethod::all();
        let (_, method) = methods.iter().find(|(n, _)| *n == name).unwrap();
        for Iteration {
            pose,
            width,
            correspondences,
            ..
        } in trace(method).iterations
        {
            let moved: Vec<_> = moving.points().iter().map(|p| pose * *p).collect();
            // The product of two Gaussians is one of twice the variance.
            let variance = width * width * if name == "gmm" { 2.0 } else { 1.0 };
            let kernel = |a: &Point2<f64>, b: &Point2<f64>| {
                libm::exp(-0.5 * (a - b).norm_squared() / variance)
            };
            let (m, n) = (moved.len() as f64, fixed.points().len() as f64);
            // The share of outliers is counted in clouds of extent 1.
            let extent = extent(fixed.points()).max(extent(moving.points()));
            let by_outliers = std::f64::consts::TAU * variance / (extent * extent) * outliers
                / (1.0 - outliers)
                * m
                / n;
            let share = |x: &Point2<f64>| match name {
                "cpd" => 1.0 / (moved.iter().map(|y| kernel(y, x)).sum::<f64>() + by_outliers),
                _ => 1.0,
            };
            let shares: Vec<f64> = fixed.points().iter().map(share).collect();
            let pulled = |y: &Point2<f64>| {
                let mut sum = nalgebra::Vector3::zeros();
                for (x, share) in fixed.points().iter().zip(&shares) {
                    sum += x.coords.push(1.0) * (kernel(y, x) * share);
                }
                (sum.xy() / sum.z, sum.z)
            };
            let all: Vec<_> = moved.iter().map(pulled).collect();
            let most = all.iter().map(|(_, weight)| *weight).fold(0.0, f64::max);
            let counted = all.iter().filter(|(_, weight)| *weight > 0.011 * most);
            assert!(correspondences.len() >= counted.count(), "{name}");
            for pair in &correspondences {
                let at = moved.iter().position(|y| (y - pair.from).length() < 1e-9);
                let (to, weight) = all[at.expect("a point of the cloud")];
                // As precise as was requested of the sums.
                let off = (pair.to.coords - to).length();
                assert!(off < 2e-3 / pair.weight, "{name}: {off} m of {width}");
                assert!((pair.weight - weight / most).abs() < 2e-3, "{name}");
            }
        }
    }
}

#[test]
fn cells_of_normal_distributions_are_means_of_fixed_points() {
    let (_, fixed, _) = pair();
    for iteration in trace(&CloudMethod::Ndt(NdtConfig::default())).iterations {
        for pair in &iteration.correspondences {
            let half = 0.5 * iteration.width;
            let off = pair.to - pair.from;
            assert!(off.amax() < 2.0 * half, "within the cell of both");
            let near = |p: &&Point2<f64>| (**p - pair.to).amax() <= 2.0 * half;
            assert!(fixed.points().iter().filter(near).count() >= 3);
        }
    }
}

#[test]
fn nothing_is_traced_of_clouds_without_points() {
    let (moving, _, start) = pair();
    let none = Cloud::scan(vec![]).unwrap();
    for (name, method) in CloudMethod::all() {
        for (moving, fixed) in [(&moving, &none), (&none, &moving)] {
            let judge = JudgeConfig::default();
            let trace = trace_clouds(moving, fixed, &start, &method, &judge);
            assert_eq!(trace.iterations, [], "{name}");
            assert_eq!(
                trace.registration.verdict,
                Verdict::TooFewPoints { found: 0 }
            );
        }
    }
}
