//! Compared with truth that the filter does not know, sums over fine grids, and full copies.

use nalgebra::{Matrix3, Point2, Vector3};

use super::proposal::{Likelihood, moments};
use super::*;
use crate::geom::{Length, Segment, wrap};
use crate::points::fixture::look_along;
use crate::registration::Prior;

/// A corridor round a block, 12 x 8 m outside, with a pillar that makes its corners
/// distinguishable.
fn ring() -> Vec<Segment> {
    let closed = |corners: &[[f64; 2]]| {
        let ends = corners.iter().zip(corners.iter().cycle().skip(1));
        let walls = ends.map(|(a, b)| Segment::new(Point2::from(*a), Point2::from(*b)));
        walls.collect::<Vec<_>>()
    };
    let outside = closed(&[[0.0, 0.0], [12.0, 0.0], [12.0, 8.0], [0.0, 8.0]]);
    let block = closed(&[[2.0, 2.0], [10.0, 2.0], [10.0, 6.0], [2.0, 6.0]]);
    let pillar = closed(&[[5.0, 0.0], [5.4, 0.0], [5.4, 0.4], [5.0, 0.4]]);
    [outside, block, pillar].concat()
}

fn seen_from(at: &Pose2, walls: &[Segment], stamp: Stamp) -> Points {
    let bearings = (0..180).map(|beam_idx| 0.035 * f64::from(beam_idx));
    Points {
        stamp,
        ..look_along(bearings, walls, at, 8.0)
    }
}

fn moved(motion: Pose2, stamp: Stamp) -> Odometry {
    Odometry {
        motion,
        cov: Matrix3::from_diagonal(&Vector3::new(4e-4, 4e-4, 1e-4)),
        ..Odometry::standing(stamp)
    }
}

fn filter(count: usize) -> GridParticles {
    let config = GridParticlesConfig {
        count,
        ..GridParticlesConfig::default()
    };
    GridParticles::new(config, ScanMatcherConfig::default(), GridConfig::default()).unwrap()
}

/// Once round the block and a little more, with odometry that turns too far; returns the true poses
/// in the frame of the first one, and where odometry ends.
fn drive_round(filter: &mut GridParticles) -> (Vec<Pose2>, Pose2, Vec<Points>) {
    let walls = ring();
    let begin = Pose2::new(1.0, 1.0, 0.0);
    let (mut at, mut odometry) = (begin, Pose2::identity());
    let (mut truth, mut taken) = (vec![], vec![]);
    let legs = [10.0, 6.0, 10.0, 6.0, 3.0];
    let quarter = std::f64::consts::FRAC_PI_2;
    let mut steps = vec![Pose2::identity()];
    for leg in legs {
        steps.extend(vec![
            Pose2::new(0.2, 0.0, 0.0);
            (leg / 0.2_f64).round() as usize
        ]);
        steps.extend([Pose2::new(0.0, 0.0, quarter / 6.0); 6]);
    }
    for (index, step) in steps.into_iter().enumerate() {
        let stamp = Stamp(200_000 * index as u64);
        at = at * step;
        let counted = Pose2::new(
            step.x() * 1.02,
            0.0,
            step.heading() * 1.03 + 0.02 * step.x(),
        );
        odometry = odometry * counted;
        filter.odometry(&moved(counted, stamp));
        let points = seen_from(&at, &walls, stamp);
        let sigmas = vec![0.002; points.beams.len()];
        filter.update(&points, &sigmas, || {
            taken.push(points.clone());
            Evidence::of(&points)
        });
        truth.push(begin.delta_to(&at));
    }
    (truth, odometry, taken)
}

#[test]
fn a_way_round_a_block_is_known_where_odometry_is_lost() {
    let mut filter = filter(15);
    let (truth, odometry, _) = drive_round(&mut filter);
    let end = truth[truth.len() - 1];
    assert!(
        (odometry.position() - end.position()).length() > 1.0,
        "{odometry:?}"
    );
    let trajectory = filter.trajectory();
    assert_eq!(trajectory.len(), truth.len());
    for (index, ((stamp, pose), truth)) in trajectory.iter().zip(&truth).enumerate() {
        assert_eq!(*stamp, Stamp(200_000 * index as u64));
        let off = (pose.position() - truth.position()).length();
        let turned = wrap(pose.heading() - truth.heading()).abs();
        assert!(
            off < 0.14 && turned < 0.04,
            "{index}: {off} m, {turned} rad"
        );
    }
    let off = filter.estimate().pose.minus(&end);
    assert!(
        off.xy().length() < 0.12 && wrap(off.z).abs() < 0.04,
        "{off}"
    );
    // It reports its uncertainty: not less than a tenth of the error.
    let sigma = filter.estimate().cov[(0, 0)].sqrt();
    assert!((0.002..0.3).contains(&sigma), "{sigma}");
    assert_eq!(filter.quality().localisation, Localisation::Localised);
    assert!(filter.quality().agreement > 0.8, "{:?}", filter.quality());
}

/// Copies of a map share memory until they are written; the map of each particle must be the one
/// that its own trajectory alone produces.
#[test]
fn a_map_is_that_of_its_way_however_often_particles_were_drawn_anew() {
    let mut filter = filter(15);
    let (_, _, taken) = drive_round(&mut filter);
    // Some died, and some have several children.
    assert!(filter.maps > 5, "{}", filter.maps);
    for particle in &filter.particles {
        let line = filter.ancestry.line(particle.node.unwrap());
        assert_eq!(line.len(), taken.len());
        let mut walls = SurfelTiles::new(filter.config.surfels);
        for (points, pose) in taken.iter().zip(&line) {
            walls.insert(oriented_points(points).iter().map(|surface| OrientedPoint {
                position: *pose * surface.position,
                normal: pose.rotate(surface.normal),
            }));
        }
        assert!(particle.walls.surfels().eq(walls.surfels()));
    }
    let line = filter.ancestry.line(filter.best().node.unwrap());
    let mut drawn = Grid::new(GridConfig::default()).unwrap();
    for (points, pose) in taken.iter().zip(&line) {
        drawn.insert(points, pose);
    }
    assert_eq!(drawn.block_count(), filter.grid().block_count());
    for (index, cells) in drawn.blocks_since(0) {
        assert_eq!(filter.grid().block(index), Some(cells));
    }
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_one_others() {
    let run = |seed: u64| {
        let config = GridParticlesConfig {
            seed,
            count: 4,
            ..GridParticlesConfig::default()
        };
        let (front, grid) = (ScanMatcherConfig::default(), GridConfig::default());
        let mut filter = GridParticles::new(config, front, grid).unwrap();
        drive_round(&mut filter);
        (filter.trajectory(), filter.particles().to_vec())
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1).1, run(2).1);
}

/// Weight, mean and covariance compared with a sum over 61³ poses.
#[test]
fn a_particle_is_weighed_by_the_integral_over_its_poses() {
    let config = GridParticlesConfig::default();
    let points = seen_from(&Pose2::new(1.0, 1.0, 0.0), &ring(), Stamp(0));
    let surfaces = oriented_points(&points);
    let mut walls = SurfelTiles::new(config.surfels);
    walls.insert(surfaces.iter().copied());
    let known = Known {
        walls: &walls,
        free: &FreeSpace::default(),
    };
    for shift in [0.0, 0.01, -0.02] {
        let prior_pose = Pose2::new(shift, 0.5 * shift, -0.3 * shift);
        let prior = Prior {
            pose: prior_pose,
            information: pose_cov(0.02, 0.01).try_inverse().unwrap(),
        };
        let peak = Pose2::identity();
        let likelihood = Likelihood::around(&peak, &surfaces, known, &config);
        let (found, log_weight) = moments(&likelihood, &peak, &prior);
        // Most of the mass lies within 5 σ of the prior.
        let (half, span) = (30, [0.1, 0.1, 0.05]);
        let (mut sum, mut mean, mut square) = (0.0, Vector3::zeros(), Matrix3::zeros());
        let step = span.map(|span| span / f64::from(half));
        for a in -half..=half {
            for b in -half..=half {
                for c in -half..=half {
                    let off = Vector3::new(
                        step[0] * f64::from(a),
                        step[1] * f64::from(b),
                        step[2] * f64::from(c),
                    );
                    let pose = prior_pose.plus(&off);
                    let log = likelihood.log_at(&pose) - 0.5 * off.dot(&(prior.information * off));
                    let weight = libm::exp(log);
                    sum += weight;
                    let at = pose.minus(&peak);
                    mean += at * weight;
                    square += at * at.transpose() * weight;
                }
            }
        }
        mean /= sum;
        let cov = square / sum - mean * mean.transpose();
        let exact = libm::log(sum * step[0] * step[1] * step[2]);
        assert!(
            (log_weight - exact).abs() < 0.1,
            "{shift}: {log_weight} {exact}"
        );
        let off = found.pose.minus(&peak) - mean;
        for axis in 0..3 {
            let sigma = cov[(axis, axis)].sqrt();
            assert!(
                off[axis].abs() < 0.1 * sigma,
                "{shift} {axis}: {off} of {sigma}"
            );
            let ratio = found.cov[(axis, axis)] / cov[(axis, axis)];
            assert!((0.85..1.15).contains(&ratio), "{shift} {axis}: {ratio}");
        }
    }
}

#[test]
fn points_on_walls_outliers_and_news_count_as_they_should() {
    let config = GridParticlesConfig {
        sigma: 0.1,
        outlier_sigmas: 2.0,
        independent_points: 1000.0,
        unknown_part: 0.25,
        ..GridParticlesConfig::default()
    };
    let wall = |x: f64| OrientedPoint {
        position: Point2::new(x, 1.02),
        normal: nalgebra::Vector2::new(0.0, -1.0),
    };
    let mut walls = SurfelTiles::new(config.surfels);
    walls.insert((0..20).map(|i| wall(0.1 * f64::from(i))));
    let mut free = FreeSpace::default();
    // A place is free if beams passed through all around it.
    let beam = |y: f64| [Point2::new(0.0, y), Point2::new(3.0, y)];
    free.mark([beam(-0.18), beam(0.02), beam(0.22)].into_iter());
    let known = Known {
        walls: &walls,
        free: &free,
    };
    let at = |x: f64, y: f64| {
        let surface = OrientedPoint {
            position: Point2::new(x, y),
            normal: nalgebra::Vector2::new(0.0, -1.0),
        };
        let pose = Pose2::identity();
        Likelihood::around(&pose, &[surface], known, &config).log_at(&pose)
    };
    // -r²/2σ², no less than -2; a quarter of that where nothing was seen, and all of it where beams
    // passed through.
    let near = |found: f64, exact: f64| assert!((found - exact).abs() < 1e-9, "{found} {exact}");
    near(at(1.0, 1.02), 0.0);
    near(at(1.0, 1.12), -0.5);
    near(at(1.0, 1.32), -2.0);
    near(at(1.0, 5.0), -0.5);
    near(at(1.5, 0.02), -2.0);
}

#[test]
fn figures_out_of_their_bounds_are_named() {
    let begin = |config: GridParticlesConfig| {
        let (front, grid) = (ScanMatcherConfig::default(), GridConfig::default());
        GridParticles::new(config, front, grid).map(|_| ())
    };
    let none = GridParticlesConfig {
        count: 0,
        ..GridParticlesConfig::default()
    };
    let error = begin(none).unwrap_err().to_string();
    assert_eq!(error, "grid particles: count is 0, expected 1 to 500");
    let nan = GridParticlesConfig {
        sigma: f64::NAN,
        ..GridParticlesConfig::default()
    };
    assert!(begin(nan).unwrap_err().to_string().contains("sigma"));
}
