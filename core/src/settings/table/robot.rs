//! The simulated robot's body and tracks; the assumed odometry errors of any robot; and what a
//! recorded log does not say about its robot.

use super::{ANY, Group, RECORDED, SIMULATED};
use crate::robot::BodyShape;
use crate::settings::field::{Number, at, rows};
use crate::settings::setting::{
    CENTIMETRES, Field, METRES, NUMBER, Named, PERCENT, Setting, named, one_of, real, si, switch,
};

const OF_BODY: Group = Group {
    name: "Simulated body",
    ..SIMULATED
};

rows! { BODY = OF_BODY;
    "body.shape", "Outline of the robot", one_of::<BodyShape>(), [body.shape].basic(),
        "Disc: the circle around the body. Rectangle: on its way to a goal the robot also passes where only the rectangle fits, and contacts are the rectangle's. Exploration, the cycle and driving by hand keep the circle.";
    "body.length", "Length of the rectangle", real([0.0, 1.5], CENTIMETRES), [body.length].needs("body.shape", &["rectangle"]),
        "Along the way it drives. Longer: it turns in wider places only. 0: as the robot's model says.";
    "body.width", "Width of the rectangle", real([0.0, 1.5], CENTIMETRES), [body.width].needs("body.shape", &["rectangle"]),
        "Across. Wider: fewer gaps let it through. 0: as the robot's model says.";
}

const OF_TRACKS: Group = Group {
    name: "Simulated tracks",
    ..SIMULATED
};
const GIVEN: &[&str] = &["given"];

rows! { TRACKS = OF_TRACKS;
    "wear.given", "How they differ from the model", named(2, || Named::all(&[("seed", "drawn from the seed"), ("given", "as given here")])), [wear.is_given],
        "No two robots are worn alike. As given: the simulated robot is the twin of one whose drive was fitted.";
    "wear.left", "Left track runs farther by", real([-0.5, 0.5], PERCENT), [wear.given.left].needs("wear.given", GIVEN),
        "Part of its way that is not counted. Below 0 it runs less than is counted.";
    "wear.right", "Right track runs farther by", real([-0.5, 0.5], PERCENT), [wear.given.right].needs("wear.given", GIVEN),
        "The same of the right one. Where the two differ a straight drive bends.";
    "wear.track", "Effective track width larger by", real([-0.5, 0.5], PERCENT), [wear.given.track_width].needs("wear.given", GIVEN),
        "The tracks act wider apart than the model says. Larger: turns fall short.";
}

const OF_ODOMETRY: Group = Group {
    name: "Odometry",
    ..ANY
};
const CONSTANT: &[&str] = &["constant"];
const GROWING: &[&str] = &["growing"];

rows! { ODOMETRY = OF_ODOMETRY;
    "odometry.left", "Left track counted farther by", real([-0.5, 0.5], PERCENT), [odometry.wear.left],
        "Corrects what a fit found of the robot. Larger: more way for the same count. 0: as the robot counts.";
    "odometry.right", "Right track counted farther by", real([-0.5, 0.5], PERCENT), [odometry.wear.right],
        "The same of the right one.";
    "odometry.track", "Track width counted larger by", real([-0.5, 0.5], PERCENT), [odometry.wear.track_width],
        "The same of the effective track width. Larger: turns are counted shorter.";
    "odometry.model", "Odometry noise", named(2, || Named::all(&[("growing", "grows with way and turn"), ("constant", "constant Q")])), [odometry.is_constant].basic(),
        "Constant Q is the paper's (TDK 2016): the same noise in each reading, also of a robot that stands.";
    "odometry.constant", "Variance of each reading", real([0.0, 0.01], si("m²")), [odometry.constant].needs("odometry.model", CONSTANT),
        "Constant Q: variance of a track's way in each reading, 100 a second. Larger: odometry is trusted less.";
    "odometry.per_metre", "Noise of each track", real([0.0, 1.0], si("m²/m")), [odometry.proportional.per_metre].needs("odometry.model", GROWING),
        "Variance of a track's way for each metre that it ran. Larger: odometry is trusted less.";
    "odometry.lateral", "Sideways slip", real([0.0, 1.0], si("m²/m")), [odometry.proportional.lateral_per_metre].needs("odometry.model", GROWING),
        "Variance of the sideways slip for each metre of way. Larger: odometry is trusted less.";
    "odometry.turn", "Slip in turns", real([0.0, 1.0], si("rad²/rad")), [odometry.proportional.heading_per_radian].needs("odometry.model", GROWING),
        "Variance of the heading for each radian turned. Larger: turns are trusted less.";
}

const OF_LOG: Group = Group {
    name: "Recording",
    ..RECORDED
};

rows! { LOG = OF_LOG;
    "log.odometry", "Odometry of the recording", switch(), [log.uses_odometry].basic(),
        "Off: the recording is mapped from its scans alone, by scan matching, as if its sensor had been carried.";
    "log.counts", "Encoder counts of a revolution", real([1.0, 1e6], NUMBER), [log.counts_per_revolution],
        "Of a rover's log, which holds counts and does not say what one is worth. Larger: ways are shorter.";
    "log.wheel", "Diameter of the wheels", real([0.001, 5.0], CENTIMETRES), [log.wheel_diameter],
        "Of a rover's log. Larger: ways are longer.";
    "log.track", "Track width", real([0.01, 5.0], CENTIMETRES), [log.track_width],
        "Of a rover's log: from the left wheels to the right ones. Larger: turns are smaller. Tracks that slip turn as if they lay wider apart.";
    "log.reach", "Rangers are believed up to", real([0.1, 20.0], METRES), [log.ranger_reach],
        "Of a log of rangers: a reading from here on says that nothing came back from nearer. Larger: more walls, and more that are none.";
    "log.revolutions", "Revolutions of the lidar", real([0.1, 100.0], si("Hz")), [log.revolution_rate],
        "Of a log of revolutions, which holds no time. Larger: it was over sooner, and what moves in it is faster.";
}
