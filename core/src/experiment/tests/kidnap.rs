//! A kidnapped robot: it does not notice by itself, but its method does.

use super::*;
use crate::estimation::Localisation;
use crate::geom::{Length, Pose2};
use crate::slam::Method;

fn in_office(method: Method, anywhere: bool) -> Experiment {
    let world = worlds::builtin("office").unwrap();
    let robot = world.robot.model();
    let mut config = ExperimentConfig::new(world, robot, SensorModel::lidar(), 3);
    config.method = method;
    config.slam.prior_map.anywhere = anywhere;
    Experiment::new(config).unwrap()
}

fn is_sure(run: &Experiment) -> bool {
    let quality = run.session().slam().view().pose_quality;
    quality.is_some_and(|q| q.localisation == Localisation::Localised)
}

fn error(run: &Experiment) -> f64 {
    let estimate = run.session().estimate().pose;
    (estimate.position() - run.truth().position()).length()
}

#[test]
fn what_is_carried_off_neither_counts_it_nor_stands_in_a_wall() {
    let mut run = in_office(Method::LineEkf, false);
    for _ in 0..20 {
        run.step().unwrap();
    }
    let (ticks, estimate) = (run.sim().ticks(), run.session().estimate());
    let wall = run.sim().world().walls()[0].segment.a;
    let before = run.sim().truth();
    let blocked = run.kidnap(Some(&Pose2::new(wall.x, wall.y, 0.0)));
    assert!(blocked.is_err() && run.sim().truth() == before);
    assert!(run.kidnap(Some(&Pose2::new(f64::NAN, 0.0, 0.0))).is_err());
    run.kidnap(None).unwrap();
    let after = run.sim().truth();
    assert!((after.position() - before.position()).length() > 0.1);
    let room = run.sim().caster().clearance(after.position(), 1.0);
    assert!(room >= run.sim().robot().radius());
    assert_eq!(
        (run.sim().ticks(), run.session().estimate()),
        (ticks, estimate)
    );
    run.kidnap(Some(&before)).unwrap();
    assert_eq!(run.sim().truth(), before);
}

#[test]
fn both_methods_with_a_map_find_a_kidnapped_robot_while_it_goes_on_exploring() {
    for method in [Method::ParticleLocalisation, Method::PriorMap] {
        let mut run = in_office(method, false);
        while run.seconds() < 20.0 {
            run.step().unwrap();
        }
        let name = method.name();
        assert!(
            is_sure(&run) && error(&run) < 0.05,
            "{name}: {}",
            error(&run)
        );
        let mapped = run.session().slam().grid().blocks_since(0).count();
        run.kidnap(None).unwrap();
        let mut was_lost = false;
        while run.seconds() < 120.0 && !(was_lost && is_sure(&run)) {
            run.step().unwrap();
            was_lost |= !is_sure(&run);
        }
        assert!(
            was_lost && is_sure(&run) && error(&run) < 0.1,
            "{name}: {}",
            error(&run)
        );
        // The earlier map is there again, without what was drawn while the robot was lost.
        assert!(run.session().slam().grid().blocks_since(0).count() >= mapped);
        assert!(run.session().slam().grid_version() >= 2, "{name}");
    }
}

#[test]
fn a_robot_that_begins_anywhere_drives_until_it_knows_where_it_is() {
    for method in [Method::ParticleLocalisation, Method::PriorMap] {
        let mut run = in_office(method, true);
        while run.seconds() < 120.0 && !is_sure(&run) {
            run.step().unwrap();
        }
        assert!(
            is_sure(&run) && error(&run) < 0.1,
            "{}: {}",
            method.name(),
            error(&run)
        );
    }
}
