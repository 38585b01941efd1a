//! Every entry of the table reads what it writes, and nothing else changes.

use super::*;
use crate::sim::SensorKind;

fn all() -> Vec<Settings> {
    let sensors = SensorKind::ALL.map(|(_, kind, _)| kind.model());
    let robot = RobotModel::rp6();
    sensors.map(|sensor| Settings::of(sensor, &robot)).into()
}

#[test]
fn keys_are_unique_and_groups_stand_together() {
    let mut keys: Vec<&str> = table().map(|s| s.key).collect();
    keys.sort_unstable();
    keys.dedup();
    assert_eq!(keys.len(), table().count());
    let mut groups: Vec<&str> = table().map(|s| s.group).collect();
    groups.dedup();
    let in_a_row = groups.len();
    groups.sort_unstable();
    groups.dedup();
    assert_eq!(groups.len(), in_a_row);
}

#[test]
fn every_setting_reads_what_was_written_and_leaves_the_others_alone() {
    let mut written = vec![];
    for before in all() {
        for setting in table() {
            let Some(default) = before.get(setting) else {
                continue;
            };
            let [low, high] = setting.range;
            assert!(
                (low..=high).contains(&default),
                "{}: {default}",
                setting.key
            );
            let middle = match setting.kind {
                Kind::Real => 0.5 * (low + high),
                _ => (0.5 * (low + high)).floor(),
            };
            for value in [low, high, middle] {
                let mut after = before.clone();
                after.set(setting.key, value).unwrap();
                assert_eq!(after.get(setting), Some(value), "{}", setting.key);
                let others = table().filter(|s| s.key != setting.key);
                for other in others {
                    // A choice of a rule brings figures of its own; all others stay.
                    if let (Some(was), Some(is)) = (before.get(other), after.get(other)) {
                        assert_eq!(was, is, "{} changes {}", setting.key, other.key);
                    }
                }
            }
            written.push(setting.key);
        }
    }
    let absent = table().filter(|s| !written.contains(&s.key));
    let absent: Vec<&str> = absent.map(|s| s.key).collect();
    // Those that come with a choice.
    let with_choice = [
        "sonars.shown",
        "body.length",
        "body.width",
        "points.sector_no_returns",
        "points.sigma_constant",
        "points.sigma_slope",
        "points.sigma_least",
        "lines.threshold",
    ];
    assert_eq!(absent, with_choice);
    for (choice, key, value) in [
        ("points.sigma", "points.sigma_slope", 0.05),
        ("lines.rule", "lines.threshold", 0.05),
        ("body.shape", "body.length", 0.5),
        ("body.shape", "body.width", 0.3),
        ("sonars.beside", "sonars.shown", 2.0),
        ("points.sector", "points.sector_no_returns", 7.0),
    ] {
        let mut settings = all().remove(0);
        settings.set(choice, 1.0).unwrap();
        settings.set(key, value).unwrap();
        let entry = table().find(|s| s.key == key).unwrap();
        assert_eq!(settings.get(entry), Some(value));
    }
}

#[test]
fn presets_can_be_set_and_name_their_group() {
    for preset in PRESETS {
        let mut settings = all().remove(0);
        for &(key, value) in preset.values {
            settings.set(key, value).unwrap();
            let entry = table().find(|s| s.key == key).unwrap();
            assert_eq!(entry.group, preset.group, "{key}");
        }
    }
}

#[test]
fn what_cannot_be_set_is_said_in_words() {
    let mut settings = all().remove(0);
    let untouched = settings.clone();
    let mut said = |key: &str, value: f64| settings.set(key, value).unwrap_err().to_string();
    assert_eq!(said("ekf.gates", 1.0), "there is no setting `ekf.gates`");
    assert_eq!(
        said("lines.min_length", -1.0),
        "Shortest line is -1 m, expected 0 to 5 m"
    );
    assert_eq!(
        said("lidar.beams", 1.5),
        "Beams is 1.5, expected a whole number from 1 to 10000"
    );
    assert!(said("ekf.gate", f64::NAN).contains("is NaN d²"));
    assert!(said("sonar.cones", 8.0).contains("belongs to another sensor"));
    assert_eq!(settings, untouched);
}

#[test]
fn a_real_robot_takes_what_it_has_and_leaves_out_what_is_of_a_simulated_sensor() {
    let robot = RobotModel::rp6();
    let changes = [
        ("rangers.volts_sigma", 0.1),
        ("odometry.left", 0.01),
        ("pilot.gap", 0.2),
    ];
    let mut set = Settings::of_robot(&robot, false);
    set.set_present(changes).unwrap();
    assert_eq!((set.odometry.wear.left, set.pilot.safe.gap), (0.01, 0.2));
    assert_eq!(set.slam, SlamConfig::default());
    let on_command = Settings::of_robot(&robot, true);
    assert_eq!(on_command.slam, SlamConfig::short_range());
    assert!(set.set_present([("pilot.gap", -1.0)]).is_err());
    assert!(set.set_present([("no.such", 0.0)]).is_err());
}

#[test]
fn what_was_fitted_is_what_the_settings_take() {
    let model = RobotModel::rp6();
    let wear = crate::robot::TrackWear {
        left: -0.01,
        right: 0.02,
        track_width: 0.03,
    };
    let fit = crate::estimation::OdometryFit {
        model,
        wear,
        wear_cov: nalgebra::Matrix3::identity() * 1e-6,
        noise: OdometryNoise {
            per_metre: 1e-3,
            lateral_per_metre: 2e-3,
            heading_per_radian: 3e-3,
        },
        noise_log_sigmas: [0.1; 3],
        pose_sigmas: [0.01; 2],
        extent: crate::estimation::DriveExtent::default(),
        legs: 100,
        left_out: 0,
    };
    let mut settings = all().remove(0);
    settings.set_all(fit.settings()).unwrap();
    assert_eq!(settings.odometry.wear, wear);
    assert_eq!(settings.wear.used(), Some(wear));
    let told = settings.odometry.calibration(&model);
    assert_eq!(told.noise, Some(TrackNoise::Proportional(fit.noise)));
    // A robot of which nothing better is known speaks for itself.
    assert_eq!(
        all().remove(0).odometry.calibration(&model),
        OdometryCalibration::default()
    );
}
