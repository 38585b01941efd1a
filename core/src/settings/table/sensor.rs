//! The simulated sensors.

use super::{Group, SIMULATED};
use crate::bounds::PART;
use crate::map::Layer;
use crate::robot::{RangerModel, Sharp};
use crate::settings::field::{Choice, Number, at, rows};
use crate::settings::setting::{
    CENTIMETRES, CENTIMETRES_PER_METRE, DEGREES, Field, METRES, MILLISECONDS, NUMBER, Needs,
    PERCENT, Setting, VOLTS, one_of, real, switch, whole,
};
use crate::sim::SensorModel;
use crate::sim::sensors::{LidarModel, SonarModel};

const OF_LIDAR: Group = Group {
    name: "Sensor",
    needs: Needs::Sensor("a lidar"),
    ..SIMULATED
};

rows! { LIDAR = OF_LIDAR;
    "lidar.beams", "Beams", whole(LidarModel::BEAMS, NUMBER),
        [get |s| match &s.sensor { SensorModel::Lidar(m) => Some(m.beams.number()), _ => None },
         set |s, v| if let SensorModel::Lidar(m) = &mut s.sensor { *m = m.with_beams(v as usize); }],
        "Beams of one revolution. More: finer, and more work for each scan.";
    "lidar.period", "Time of a revolution", real(LidarModel::PERIOD, MILLISECONDS), [SensorModel::Lidar(m) = sensor => m.period],
        "Longer: a moving robot skews the scan more.";
    "lidar.min_range", "Nearest range", real(LidarModel::MIN_RANGE, METRES), [SensorModel::Lidar(m) = sensor => m.min_range],
        "Nearer things give no reading. Larger: a wider blind zone.";
    "lidar.max_range", "Farthest range", real(LidarModel::MAX_RANGE, METRES), [SensorModel::Lidar(m) = sensor => m.max_range].basic(),
        "Farther things give no reading. Larger: more is seen from one place.";
    "lidar.sigma", "σ of the range at 0 m", real(LidarModel::SIGMA, CENTIMETRES), [SensorModel::Lidar(m) = sensor => m.sigma].basic(),
        "Noise of each reading, standard deviation. Larger: rougher walls, fewer lines.";
    "lidar.sigma_per_metre", "Growth of σ with the range", real(LidarModel::SIGMA_PER_METRE, CENTIMETRES_PER_METRE), [SensorModel::Lidar(m) = sensor => m.sigma_per_metre],
        "What σ gains with each metre of range. Larger: far walls are rougher.";
    "lidar.bearing_sigma", "σ of the bearing", real(LidarModel::BEARING_SIGMA, DEGREES), [SensorModel::Lidar(m) = sensor => m.bearing_sigma],
        "Noise of the direction of each beam. Larger: far ends of walls fray.";
    "lidar.dropouts", "Lost readings", real(PART, PERCENT), [SensorModel::Lidar(m) = sensor => m.dropouts].basic(),
        "Part of the readings that do not come.";
    "lidar.outliers", "Wrong readings", real(PART, PERCENT), [SensorModel::Lidar(m) = sensor => m.outliers],
        "Part of the readings that lie somewhere short of the surface.";
    "lidar.dark_range", "Dark surfaces seen within", real(LidarModel::DARK_RANGE, METRES), [SensorModel::Lidar(m) = sensor => m.dark_range],
        "Farther away they return nothing. Larger: dark walls are mapped from afar.";
    "lidar.glass_angle", "Glass returns within", real(LidarModel::GLASS_ANGLE, DEGREES), [SensorModel::Lidar(m) = sensor => m.glass_angle],
        "Angle from its normal; other beams go through. Larger: more of a pane is seen.";
}

const OF_RANGERS: Group = Group {
    needs: Needs::Sensor("IR rangers"),
    ..OF_LIDAR
};

rows! { RANGERS = OF_RANGERS;
    "rangers.type", "Type of the rangers", one_of::<Sharp>(),
        [get |s| match &s.sensor { SensorModel::Rangers(m) => Some(m.sharp.number()), _ => None },
         set |s, v| if let (SensorModel::Rangers(m), Some((_, sharp, _))) = (&mut s.sensor, Sharp::all().get(v as usize)) && m.sharp != *sharp {
             *m = RangerModel::of(*sharp);
         }].basic(),
        "Sharp's infra-red rangers, with their ranges and the pairs of their data sheet. The short type has its peak nearer to the robot.";
    "rangers.positions", "Positions of the servo", whole(RangerModel::POSITIONS, NUMBER), [SensorModel::Rangers(m) = sensor => m.positions],
        "Readings of each ranger in its 90°. More: finer scans that take longer.";
    "rangers.period", "Time at each position", real(RangerModel::PERIOD, MILLISECONDS), [SensorModel::Rangers(m) = sensor => m.period],
        "If it is shorter than the servo takes to settle and a ranger to measure, what is read was measured at the position before.";
    "rangers.settle", "Settling time of the servo", real(RangerModel::SETTLE, MILLISECONDS), [SensorModel::Rangers(m) = sensor => m.settle],
        "Until it stands at a new angle. Longer needs more time at each position.";
    "rangers.min_range", "Nearest range", real(RangerModel::MIN_RANGE, CENTIMETRES), [SensorModel::Rangers(m) = sensor => m.min_range],
        "Nearer things look far, or give no reading. Larger: a wider blind zone.";
    "rangers.max_range", "Farthest range", real(RangerModel::MAX_RANGE, METRES), [SensorModel::Rangers(m) = sensor => m.max_range].basic(),
        "Farther things give no reading. Larger: more is seen, with much more noise.";
    "rangers.volts_sigma", "σ of the voltage", real(RangerModel::VOLTS_SIGMA, VOLTS), [SensorModel::Rangers(m) = sensor => m.volts_sigma].basic(),
        "Noise of the output. Larger: rougher ranges, the more so the farther the wall is.";
    "rangers.bearing_sigma", "σ of the servo", real(RangerModel::BEARING_SIGMA, DEGREES), [SensorModel::Rangers(m) = sensor => m.bearing_sigma],
        "Noise of its angle. Larger: far ends of walls fray.";
    "rangers.dropouts", "Lost readings", real(PART, PERCENT), [SensorModel::Rangers(m) = sensor => m.dropouts],
        "Part of the readings that do not come.";
    "rangers.outliers", "Wrong readings", real(PART, PERCENT), [SensorModel::Rangers(m) = sensor => m.outliers],
        "Part of the readings that are any voltage at all.";
    "rangers.folds", "Near things look far", switch(), [SensorModel::Rangers(m) = sensor => m.folds],
        "On, as on the real robot: nearer than the peak the voltage falls again. Off: such readings are recognised.";
}

const OF_SONAR: Group = Group {
    needs: Needs::Sensor("a ring of sonars"),
    ..OF_LIDAR
};

rows! { SONAR = OF_SONAR;
    "sonar.cones", "Sonars in the ring", whole(SonarModel::CONES, NUMBER), [SensorModel::Sonar(m) = sensor => m.cones].basic(),
        "They fire one after the other. More: finer, but a round takes longer.";
    "sonar.half_angle", "Half opening of a cone", real(SonarModel::HALF_ANGLE, DEGREES), [SensorModel::Sonar(m) = sensor => m.half_angle],
        "The nearest thing inside is heard, whatever its bearing. Wider: coarser.";
    "sonar.specular_angle", "A wall answers within", real(SonarModel::SPECULAR_ANGLE, DEGREES), [SensorModel::Sonar(m) = sensor => m.specular_angle],
        "Angle from its normal; beyond it mirrors the ping away. Larger: more walls are heard.";
    "sonar.period", "Time between pings", real(SonarModel::PERIOD, MILLISECONDS), [SensorModel::Sonar(m) = sensor => m.period],
        "The echo of the farthest range has to be back by then. Longer: a round takes longer.";
    "sonar.max_range", "Farthest range", real(SonarModel::MAX_RANGE, METRES), [SensorModel::Sonar(m) = sensor => m.max_range].basic(),
        "Farther things give no echo. Larger: more is heard from one place.";
    "sonar.sigma", "σ of the range at 0 m", real(SonarModel::SIGMA, CENTIMETRES), [SensorModel::Sonar(m) = sensor => m.sigma],
        "Noise of each echo, standard deviation. Larger: rougher walls.";
    "sonar.sigma_per_metre", "Growth of σ with the range", real(SonarModel::SIGMA_PER_METRE, CENTIMETRES_PER_METRE), [SensorModel::Sonar(m) = sensor => m.sigma_per_metre],
        "What σ gains with each metre of range. Larger: far walls are rougher.";
    "sonar.dropouts", "Lost pings", real(PART, PERCENT), [SensorModel::Sonar(m) = sensor => m.dropouts],
        "Part of the pings without an echo.";
    "sonar.outliers", "Cross-talk", real(PART, PERCENT), [SensorModel::Sonar(m) = sensor => m.outliers],
        "Part of the pings that hear another sonar's echo.";
}

const OF_SONARS_BESIDE: Group = Group {
    needs: Needs::Sensor("a lidar or IR rangers"),
    ..OF_LIDAR
};

rows! { SONARS_BESIDE = OF_SONARS_BESIDE;
    "sonars.beside", "Sonars beside it", switch(),
        [get |s| (!matches!(s.sensor, SensorModel::Sonar(_))).then(|| s.sonars_beside.is_some().number()),
         set |s, v| s.sonars_beside = (v > 0.5).then(SonarModel::default)].basic(),
        "A ring of 16 that draws a map of its own; it hears glass. The pose comes from the sensor alone.";
    "sonars.shown", "Map that is shown", one_of::<Layer>(), [slam.sonars.shown].needs("sonars.beside", &["on"]).at_once(),
        "Each sensor draws by its own model, and both are fused by Bayes' rule. The pilot uses the sensor's map.";
}
