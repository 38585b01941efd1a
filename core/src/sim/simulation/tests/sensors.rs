//! What sensors report about a known world: ranges within their sigmas, what they cannot see, and
//! when they look.

use super::*;

#[test]
fn standing_lidar_tells_the_true_ranges_within_its_sigmas() {
    let mut sim = simulation("office", SensorModel::lidar(), 9);
    sim.advance(9.0);
    let (mut squares, mut count, mut lost, mut wild) = (0.0, 0.0, 0.0, 0.0);
    while let Some(scan) = sim.take_scan() {
        assert_eq!(scan.validate(), Ok(()));
        assert!(scan.bearings.windows(2).all(|w| w[1] > w[0]));
        for (i, &bearing) in scan.bearings.iter().enumerate() {
            let angle = sim.truth().heading() + bearing;
            let direction = nalgebra::Vector2::new(libm::cos(angle), libm::sin(angle));
            let truth = sim.caster().cast(sim.truth().position(), direction, 12.0);
            let (range, sigma) = (f64::from(scan.ranges[i]), f64::from(scan.sigmas[i]));
            let Some(truth) = truth.filter(|t| t.distance < 11.5) else {
                continue;
            };
            if range.is_nan() {
                lost += 1.0;
                continue;
            }
            // The effect of the bearing's noise on the range depends on the slant, so only fairly
            // square beams count.
            let wall = sim.caster().walls()[truth.surface]
                .segment
                .vector()
                .normalize();
            if wall.perp(&direction).abs() < 0.7 {
                continue;
            }
            let error = (range - truth.distance) / sigma;
            if error.abs() > 5.0 {
                wild += 1.0;
            } else {
                squares += error * error;
                count += 1.0;
            }
        }
    }
    let variance: f64 = squares / count;
    assert!(
        count > 3000.0 && (variance - 1.0).abs() < 0.1,
        "{variance} of {count}"
    );
    assert!(
        lost / count < 0.03 && wild / count < 0.01,
        "{lost} {wild} of {count}"
    );
}

#[test]
fn quality_falls_with_range_and_incidence_and_is_0_where_nothing_came_back() {
    // From the middle of a corridor 2 m wide: a beam at angle `a` to its axis meets a side wall 1 /
    // sin(a) away, and its normal at 90° - a, so that cos i / d² = sin³(a).
    let mut world = worlds::builtin("corridor").unwrap();
    world.start = Pose2::new(15.0, 1.0, 0.0);
    let mut sim = Simulation::new(world, RobotModel::rp6(), SensorModel::lidar(), 3).unwrap();
    sim.advance(0.4);
    let scan = sim.take_scan().unwrap();
    assert_eq!(scan.validate(), Ok(()));
    let mut compared = 0;
    for (beam, &bearing) in scan.bearings.iter().enumerate() {
        let (range, quality) = (scan.ranges[beam], scan.quality(beam).unwrap());
        assert_eq!(
            quality > 0,
            range.is_finite(),
            "beam {beam}: {range} m, {quality}"
        );
        let sine = libm::sin(bearing).abs();
        // Outliers are weak, wherever they are.
        if !range.is_finite() || (f64::from(range) * sine - 1.0).abs() > 0.1 {
            continue;
        }
        let expect = (144.0 * sine * sine * sine).clamp(1.0, 63.0);
        assert!(
            (f64::from(quality) - expect).abs() < 3.0,
            "at {bearing} rad {quality}, expected {expect}"
        );
        compared += 1;
    }
    assert!(compared > 250, "{compared}");
    let mut sick = simulation("office", SensorKind::Sick.model(), 1);
    sick.advance(0.2);
    assert!(sick.take_scan().unwrap().qualities.is_empty());
}

#[test]
fn moving_lidar_takes_each_beam_from_where_it_was() {
    // Driving at a wall: the beam straight ahead is in the middle of the revolution, half a sweep
    // old.
    let quiet = crate::sim::sensors::LidarModel {
        sigma: 1e-6,
        sigma_per_metre: 0.0,
        bearing_sigma: 0.0,
        dropouts: 0.0,
        outliers: 0.0,
        ..Default::default()
    };
    let mut robot = RobotModel::rp6();
    robot.odometry_bias = OdometryBias::default();
    robot.odometry_noise = crate::robot::OdometryNoise {
        per_metre: 0.0,
        lateral_per_metre: 0.0,
        heading_per_radian: 0.0,
    };
    let mut world = worlds::builtin("corridor").unwrap();
    world.start = Pose2::new(25.0, 1.0, 0.0);
    let mut sim = Simulation::new(world, robot, SensorModel::Lidar(quiet), 0).unwrap();
    sim.command(Command::Velocity {
        forward: 0.3,
        turn: 0.0,
    });
    let truths = truths_of_steps(&mut sim, 360);
    let scan = std::iter::from_fn(|| sim.take_scan()).last().unwrap();
    assert_eq!(scan.stamp, sim.stamp());
    for (i, &range) in scan.ranges.iter().enumerate() {
        let steps = (scan.stamp.seconds() - scan.sweep * scan.age_fraction(i)) / TIME_STEP;
        let before = truths[steps as usize];
        let then = before
            * before
                .delta_to(&truths[steps.ceil() as usize])
                .fraction(steps.fract());
        let ahead = libm::cos(scan.bearings[i] + then.heading());
        if ahead > 0.98 {
            let expect = (30.0 - then.x()) / ahead;
            assert!(
                (f64::from(range) - expect).abs() < 1e-4,
                "beam {i}: {range} against {expect}"
            );
        }
    }
}

#[test]
fn rangers_sweep_once_on_command_while_the_robot_stands() {
    let mut sim = simulation("arena", SensorModel::rangers(), 4);
    sim.advance(5.0);
    assert_eq!(sim.take_scan(), None);
    sim.command(Command::Velocity {
        forward: 0.3,
        turn: 0.0,
    });
    sim.advance(1.0);
    let began = sim.stamp();
    finish(&mut sim, Command::Scan);
    let scan = sim.take_scan().unwrap();
    assert_eq!(scan.validate(), Ok(()));
    assert_eq!((scan.len(), scan.sweep), (180, 0.0));
    assert!(
        scan.bearings
            .windows(2)
            .all(|w| (w[1] - w[0] - TAU / 180.0).abs() < 1e-9)
    );
    let seconds = sim.stamp().since(began);
    assert!(
        seconds > 45.0 * 0.070 && seconds < 45.0 * 0.070 + 0.7,
        "{seconds}"
    );
    assert!(
        scan.ranges.iter().any(|r| r.is_finite()) && scan.ranges.iter().any(|r| r.is_infinite())
    );
    // A command in the middle ends the sweep.
    sim.command(Command::Scan);
    sim.advance(1.0);
    sim.command(Command::Stop);
    sim.advance(4.0);
    assert!(sim.take_scan().is_none() && !sim.is_busy());
}

#[test]
fn partial_scans_point_where_they_say_and_see_what_is_there() {
    let mut sim = simulation("arena", SensorModel::rangers(), 4);
    sim.advance(2.0);
    assert_eq!(sim.take_partial_scan(), None, "it stands");
    let (mut looked, mut seen, mut wild) = (vec![], 0, 0);
    for _ in 0..20 {
        for command in [
            Command::Forward(0.3),
            Command::Turn(0.4),
            Command::Forward(-0.3),
        ] {
            sim.command(command);
            while sim.is_busy() {
                sim.advance(TIME_STEP);
                let Some(scan) = sim.take_partial_scan() else {
                    continue;
                };
                assert_eq!((scan.validate(), scan.len()), (Ok(()), 4));
                for (i, &bearing) in scan.bearings.iter().enumerate() {
                    looked.push(
                        (bearing.to_degrees().rem_euclid(360.0) / 30.0).round() as usize % 12,
                    );
                    let angle = sim.truth().heading() + bearing;
                    let direction = nalgebra::Vector2::new(libm::cos(angle), libm::sin(angle));
                    let truth = sim.caster().cast(sim.truth().position(), direction, 1.2);
                    let Some(truth) = truth.filter(|t| t.distance > 0.25) else {
                        continue;
                    };
                    let (range, sigma) = (f64::from(scan.ranges[i]), f64::from(scan.sigmas[i]));
                    // The servo's noise, on slanting walls.
                    let off = (range - truth.distance).abs();
                    seen += 1;
                    wild += i32::from(off.is_nan() || off >= 4.0 * sigma + 0.05);
                }
            }
        }
    }
    // Ahead, left, back and right twice as often as the directions in between.
    let count = |at: usize| looked.iter().filter(|l| **l == at).count();
    for at in 0..12 {
        let part = count(at) as f64 / looked.len() as f64;
        let expect = if at % 3 == 0 { 1.0 / 8.0 } else { 1.0 / 16.0 };
        assert!((part - expect).abs() < 0.02, "{}°: {part}", 30 * at);
    }
    assert!(seen > 300 && wild * 20 < seen, "{wild} of {seen}");
    // The readings of the last leg that were not taken; the sweep and standing add none.
    finish(&mut sim, Command::Scan);
    while sim.take_partial_scan().is_some() {}
    sim.advance(2.0);
    assert_eq!(sim.take_partial_scan(), None);
}

#[test]
fn rangers_tell_the_true_ranges_within_their_sigmas() {
    let mut sim = simulation("arena", SensorModel::rangers(), 8);
    let (mut squares, mut count, mut lost) = (0.0, 0.0, 0.0);
    for _ in 0..60 {
        finish(&mut sim, Command::Scan);
        let scan = sim.take_scan().unwrap();
        for (i, &bearing) in scan.bearings.iter().enumerate() {
            let angle = sim.truth().heading() + bearing;
            let direction = nalgebra::Vector2::new(libm::cos(angle), libm::sin(angle));
            let truth = sim.caster().cast(sim.truth().position(), direction, 1.4);
            // As for the lidar: the servo's noise matters on slanting walls; 4 sigma from the edge
            // of the range.
            let Some(truth) = truth.filter(|t| t.distance > 0.25) else {
                continue;
            };
            let wall = sim.caster().walls()[truth.surface]
                .segment
                .vector()
                .normalize();
            if wall.perp(&direction).abs() < 0.9 {
                continue;
            }
            let (range, sigma) = (f64::from(scan.ranges[i]), f64::from(scan.sigmas[i]));
            if !range.is_finite() {
                lost += 1.0;
                continue;
            }
            let error = (range - truth.distance) / sigma;
            if error.abs() < 5.0 {
                squares += error * error;
                count += 1.0;
            }
        }
    }
    let variance: f64 = squares / count;
    assert!(
        count > 2000.0 && (variance - 1.0).abs() < 0.15,
        "{variance} of {count}"
    );
    assert!(lost / count < 0.02, "{lost} of {count}");
}

#[test]
fn folding_rangers_take_near_things_for_far_ones() {
    let near = |folds: bool| {
        let mut world = worlds::builtin("corridor").unwrap();
        world.start = Pose2::new(30.0 - 0.12, 1.0, 0.0);
        let model = crate::robot::RangerModel {
            folds,
            dropouts: 0.0,
            ..Default::default()
        };
        let mut sim =
            Simulation::new(world, RobotModel::rp6(), SensorModel::Rangers(model), 1).unwrap();
        finish(&mut sim, Command::Scan);
        let scan = sim.take_scan().unwrap();
        let ahead = scan.bearings.iter().position(|b| b.abs() < 0.02).unwrap();
        scan.ranges[ahead]
    };
    assert!(near(false).is_nan());
    // At 0.12 m of 0.15 m the volts are 0.8 of the highest, 2.2 V: the same as at 0.25 m by the
    // data sheet.
    assert!((near(true) - 0.25).abs() < 0.05, "{}", near(true));
}

#[test]
fn lidar_answers_scan_with_one_revolution_taken_standing() {
    let mut sim = simulation("arena", SensorModel::lidar(), 4);
    sim.command(Command::Velocity {
        forward: 0.3,
        turn: 0.0,
    });
    sim.advance(1.0);
    while sim.take_scan().is_some() {}
    sim.command(Command::Scan);
    let truths: Vec<Pose2> = std::iter::from_fn(|| {
        sim.advance(TIME_STEP);
        sim.is_busy().then(|| sim.truth())
    })
    .collect();
    assert!(std::iter::from_fn(|| sim.take_scan()).last().is_some());
    assert_eq!(truths[truths.len() - 35], sim.truth());
}

#[test]
fn dark_walls_are_lost_from_afar_and_bad_figures_are_refused() {
    let mut world = worlds::builtin("corridor").unwrap();
    world.obstacles[0].material = Material::Dark;
    let mut sim = Simulation::new(world, RobotModel::rp6(), SensorModel::lidar(), 1).unwrap();
    sim.advance(0.2);
    let scan = sim.take_scan().unwrap();
    assert!(scan.ranges.iter().all(|r| !r.is_finite() || *r < 3.2));

    let error = |robot: RobotModel, sensor: SensorModel, start: Pose2| {
        let mut world = worlds::builtin("arena").unwrap();
        world.start = start;
        Simulation::new(world, robot, sensor, 0)
            .unwrap_err()
            .to_string()
    };
    let fine = Pose2::new(0.6, 0.7, 0.0);
    let inside = error(
        RobotModel::rp6(),
        SensorModel::lidar(),
        Pose2::new(1.5, 1.3, 0.0),
    );
    assert!(inside.contains("world \"arena\": start: a robot of radius 0.1101 m at (1.5, 1.3) stands in obstacle 1 (a rectangle)"), "{inside}");
    let mut robot = RobotModel::rp6();
    robot.track_width = 0.0;
    assert!(error(robot, SensorModel::lidar(), fine).contains("track_width is 0"));
    let sensor = crate::sim::sensors::LidarModel {
        beams: 0,
        ..Default::default()
    };
    assert!(
        error(RobotModel::rp6(), SensorModel::Lidar(sensor), fine).contains("lidar: beams is 0")
    );
}

#[test]
fn sick_sees_half_of_the_horizon_ten_times_a_second_and_says_its_greatest_range() {
    let model = SensorKind::Sick.model();
    let mut world = worlds::builtin("corridor").unwrap();
    world.start = Pose2::new(1.0, 1.0, 0.0);
    let mut sim = Simulation::new(world, RobotModel::rp6(), model, 3).unwrap();
    sim.advance(1.0);
    let scans: Vec<_> = std::iter::from_fn(|| sim.take_scan()).collect();
    assert_eq!(scans.len(), 10);
    for scan in &scans {
        assert_eq!(scan.validate(), Ok(()));
        assert_eq!(scan.len(), 361);
        assert!((scan.bearings[0] + FRAC_PI_2).abs() < 1e-12);
        assert!((scan.bearings[360] - FRAC_PI_2).abs() < 1e-12);
        assert!((scan.sweep - 0.1 * 360.0 / 5415.0).abs() < 1e-9);
    }
    // Along 29 m of corridor nothing comes back; nearer the walls do.
    let ahead = |scan: &Scan| scan.ranges[180];
    assert!(scans.iter().filter(|s| ahead(s) == 20.0).count() >= 9);
    let right = |scan: &Scan| f64::from(scan.ranges[0]);
    assert!(
        scans
            .iter()
            .filter(|s| (right(s) - 1.0).abs() < 0.05)
            .count()
            >= 9
    );
}

#[test]
fn sensors_are_found_by_name_and_bad_figures_are_named() {
    for (name, kind, _) in SensorKind::ALL {
        assert_eq!(name.parse(), Ok(kind));
        assert_eq!(kind.name(), name);
        assert_eq!(kind.model().validate(), Ok(()), "{name}");
    }
    let error = "radar".parse::<SensorKind>().unwrap_err().to_string();
    assert_eq!(
        error,
        "there is no sensor `radar`; expected one of lidar, sick, rangers, sonar"
    );
    let lidar = crate::sim::sensors::LidarModel {
        dropouts: 1.5,
        ..Default::default()
    };
    let error = SensorModel::Lidar(lidar).validate().unwrap_err();
    assert_eq!(error.to_string(), "lidar: dropouts is 1.5, expected 0 to 1");
}
