//! Every entry of the table reads what it writes, and changes nothing else.

use super::*;
use crate::features::SplitRule;
use crate::sim::SensorKind;
use crate::slam::Method;

fn all() -> Vec<Settings> {
    let sensors = SensorKind::ALL.map(|(_, kind, _)| kind.model());
    let robot = RobotModel::rp6();
    sensors.map(|sensor| Settings::of(sensor, &robot)).into()
}

const SIMULATED: Scope = Scope {
    source: Source::Simulation,
    method: Method::LineEkf,
};
const LIVE: Scope = Scope {
    source: Source::Live,
    ..SIMULATED
};

impl Settings {
    /// Sets one number, whatever the source and the method.
    fn set(&mut self, key: &str, value: f64) -> Result<(), String> {
        let setting = find(key).map_err(|e| e.to_string())?;
        setting.check(value).map_err(|e| e.to_string())?;
        match self.unmet(setting) {
            Some(idle) => Err(idle.to_string()),
            None => {
                (setting.field.set)(self, value);
                Ok(())
            }
        }
    }
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

/// Settings in which the setting of this key has what it needs, one for each sensor that has it.
fn with_needs(key: &str) -> Vec<Settings> {
    let setting = find(key).unwrap();
    let mut all = all();
    if let Needs::Choice { key: other, is } = setting.needs {
        let names = find(other).unwrap().names();
        let at = names.iter().position(|named| is.contains(&named.name));
        all.retain_mut(|settings| settings.set(other, at.unwrap() as f64).is_ok());
    }
    if let Needs::MoreThanZero(other) = setting.needs {
        for settings in &mut all {
            settings.set(other, find(other).unwrap().range[1]).unwrap();
        }
    }
    all.retain(|settings| settings.get(setting).is_some() && settings.unmet(setting).is_none());
    all
}

#[test]
fn every_setting_reads_what_was_written_and_leaves_the_others_alone() {
    for setting in table() {
        let all = with_needs(setting.key);
        assert!(!all.is_empty(), "{} is a setting of nothing", setting.key);
        for before in all {
            let default = before.get(setting).unwrap();
            let [low, high] = setting.range;
            let key = setting.key;
            assert!((low..=high).contains(&default), "{key}: {default}");
            let middle = match setting.kind {
                Kind::Real => 0.5 * (low + high),
                _ => (0.5 * (low + high)).floor(),
            };
            for value in [low, high, middle] {
                let mut after = before.clone();
                after.set(key, value).unwrap();
                assert_eq!(after.get(setting), Some(value), "{key}");
                // Another type of ranger brings its own ranges; all other settings stay.
                let others = table().filter(|s| s.key != key && key != "rangers.type");
                for other in others {
                    if let (Some(was), Some(is)) = (before.get(other), after.get(other)) {
                        assert_eq!(was, is, "{key} changes {}", other.key);
                    }
                }
            }
        }
    }
}

/// Validates all configurations that have a `validate`.
fn validated(settings: &Settings) -> Result<(), String> {
    let slam = &settings.slam;
    slam.lines.validate().map_err(|e| e.to_string())?;
    slam.point_features.validate().map_err(|e| e.to_string())?;
    slam.tracking.validate().map_err(|e| e.to_string())?;
    slam.ekf.validate().map_err(|e| e.to_string())?;
    slam.grid.validate().map_err(|e| e.to_string())?;
    slam.matcher.grid.validate().map_err(|e| e.to_string())?;
    slam.matcher.validate().map_err(|e| e.to_string())?;
    settings.sensor.validate().map_err(|e| e.to_string())
}

#[test]
fn a_configuration_allows_just_what_the_table_does() {
    // Groups whose configurations validate themselves. Exceptions are settings for which any number
    // is valid, such as a number of points or a seed.
    let checked = [
        "Sensor",
        "Lines",
        "Corners and posts",
        "Moving objects",
        "Filter",
        "Scan matching",
        "Map",
    ];
    let unchecked = [
        "evidence.sigmas",
        "evidence.margin",
        "evidence.no_return",
        "features.back_checks",
        "lines.gap_points",
        "lines.min_points",
        "lines.seed",
        "lines.start_points",
        "lines.trim",
    ];
    for setting in table() {
        let key = setting.key;
        let [low, high] = setting.range;
        for before in with_needs(key) {
            for value in [low, high] {
                let mut at_end = before.clone();
                (setting.field.set)(&mut at_end, value);
                assert_eq!(validated(&at_end), Ok(()), "{key} = {value}");
            }
            let is_number = matches!(setting.kind, Kind::Real | Kind::Whole);
            if !is_number || !checked.contains(&setting.group) || unchecked.contains(&key) {
                continue;
            }
            let beyond = match setting.kind {
                Kind::Whole => [low - 1.0, high + 1.0],
                _ => [low - 1e-9 - 1e-9 * low.abs(), high + 1e-9 * high.abs()],
            };
            for value in beyond {
                let mut outside = before.clone();
                (setting.field.set)(&mut outside, value);
                assert!(validated(&outside).is_err(), "{key} = {value} is allowed");
            }
        }
    }
}

#[test]
fn what_a_setting_needs_stands_before_it_and_has_these_names() {
    let keys: Vec<&str> = table().map(|setting| setting.key).collect();
    for setting in table() {
        let Needs::Choice { key, is } = setting.needs else {
            continue;
        };
        let at = |key| keys.iter().position(|known| *known == key);
        assert!(at(key) < at(setting.key), "{key}, {}", setting.key);
        let names = find(key).unwrap().names();
        let known = |name: &&str| names.iter().any(|named| named.name == *name);
        assert!(is.iter().all(known), "{}: {is:?}", setting.key);
    }
}

#[test]
fn words_are_for_people_and_few_settings_are_basic() {
    for setting in table() {
        let (key, range) = (setting.key, setting.range);
        assert!(setting.name.chars().count() > 3, "{key}: {}", setting.name);
        assert!(setting.meaning.ends_with('.'), "{key}");
        assert!(range[0] < range[1] && setting.unit.scale > 0.0, "{key}");
        let mut names: Vec<&str> = setting.names().iter().map(|named| named.name).collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count, "{key}");
        if matches!(setting.kind, Kind::Choice(_)) {
            assert_eq!(setting.range, [0.0, count as f64 - 1.0], "{key}");
        }
    }
    for settings in all() {
        for source in [Source::Simulation, Source::Recording, Source::Live] {
            for method in Method::ALL {
                let scope = Scope { source, method };
                let has_effect = |s: &&Setting| settings.idle(s, &scope).is_none();
                let basic = table().filter(has_effect).filter(|s| s.is_basic).count();
                assert!(basic <= 30, "{basic} of {source:?} with {method:?}");
            }
        }
    }
}

#[test]
fn a_setting_that_would_have_no_effect_is_refused_in_words() {
    let recording = Scope {
        source: Source::Recording,
        method: Method::LineEkf,
    };
    let robot = RobotModel::rp6();
    let mut settings = Settings::of_robot(&robot, false);
    let untouched = settings.clone();
    let mut said = |key: &str, value: f64| match settings.take(&recording, [(key, value)]) {
        Ok(idle) => idle[0].to_string(),
        Err(error) => error.to_string(),
    };
    assert_eq!(
        said("body.shape", 1.0),
        "Outline of the robot has no effect on a recording: it is a setting of a simulated robot"
    );
    assert_eq!(
        said("pilot.pace", 0.5),
        "Pace has no effect on a recording: it is a setting of a simulated robot or a live robot"
    );
    assert_eq!(
        said("known.by", 0.0),
        "Finds itself by has no effect with the method Line EKF-SLAM: it is a setting of Prior map"
    );
    assert_eq!(
        said("lines.threshold", 0.1),
        "Split beyond has no effect unless \"How lines are found\" is classic"
    );
    assert_eq!(said("ekf.gates", 0.1), "there is no setting `ekf.gates`");
    assert_eq!(settings, untouched);
    let live = Scope {
        source: Source::Live,
        ..recording
    };
    assert_eq!(settings.take(&live, [("pilot.gap", 0.1)]), Ok(vec![]));
    assert_eq!(settings.pilot.safe.gap, 0.1);
}

#[test]
fn of_a_preset_all_that_has_an_effect_is_taken_and_the_rest_is_returned() {
    let recording = Scope {
        source: Source::Recording,
        method: Method::LineEkf,
    };
    let mut settings = Settings::of_robot(&RobotModel::rp6(), true);
    let preset = [
        ("wear.left", 0.02),
        ("wear.given", 1.0),
        ("lines.threshold", 0.05),
        ("odometry.left", 0.01),
        ("lines.rule", 1.0),
    ];
    let idle = settings.take(&recording, preset).unwrap();
    let idle: Vec<String> = idle.iter().map(ToString::to_string).collect();
    assert_eq!(idle.len(), 2, "{idle:?}");
    assert!(idle[0].starts_with("How they differ from the model has no effect on a recording"));
    let rule = SplitRule::Classic(crate::features::Classic { threshold: 0.05 });
    assert_eq!(settings.slam.lines.split, rule);
    assert_eq!(settings.odometry.wear.left, 0.01);
    let before = settings.clone();
    let changes = [("odometry.left", 0.02), ("ekf.gate", -1.0)];
    assert!(settings.take(&recording, changes).is_err());
    assert_eq!(settings, before);
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
    let mut said = |key: &str, value: f64| settings.set(key, value).unwrap_err();
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
    assert_eq!(
        said("sonar.cones", 8.0),
        "Sonars in the ring is a setting of a ring of sonars, and the run has another sensor"
    );
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
    set.take(&LIVE, changes).unwrap();
    assert_eq!((set.odometry.wear.left, set.pilot.safe.gap), (0.01, 0.2));
    assert_eq!(set.slam, SlamConfig::default());
    let on_command = Settings::of_robot(&robot, true);
    assert_eq!(on_command.slam, SlamConfig::short_range());
    assert!(set.take(&LIVE, [("pilot.gap", -1.0)]).is_err());
    assert!(set.take(&LIVE, [("no.such", 0.0)]).is_err());
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
    settings.take(&SIMULATED, fit.settings()).unwrap();
    assert_eq!(settings.odometry.wear, wear);
    assert_eq!(settings.wear.used(), Some(wear));
    let known = settings.odometry.calibration(&model);
    assert_eq!(known.noise, Some(TrackNoise::Proportional(fit.noise)));
    // Without better knowledge the robot's own figures are used.
    assert_eq!(
        all().remove(0).odometry.calibration(&model),
        OdometryCalibration::default()
    );
}
