//! The faults to fix: one row per lesson, from the plainest to the subtlest.

use Measure::{Contacts, Explored, Nees, PositionError, TrajectoryError, WheelDrift};

use super::{Goal, Lesson, Measure};

/// All lessons, in the recommended order.
pub const LESSONS: &[Lesson] = &[
    Lesson {
        name: "blind-faith",
        title: "It never looks twice",
        fault: "The robot draws what it sees where its wheels say that it is. Soon walls stand twice, rooms turn about themselves, and the robot loses its way in its own map.",
        task: "Have it draw all rooms, and be right about its way. Another method may help.",
        hint: "Wheels tell how far the robot went since the last scan, each time a little wrong, and the errors add up. Every method but odometry compares what it sees with what it has drawn.",
        link: "run&world=doors&sensor=lidar&method=odometry&seed=7",
        given: &[],
        is_method_free: true,
        seconds: 240.0,
        goals: &[least(Explored, 0.95), most(TrajectoryError, 0.1)],
    },
    Lesson {
        name: "shy",
        title: "Through no door",
        fault: "The robot looks through the doors and goes through none, though they stand open: what cannot be seen from where it began stays unknown.",
        task: "Have it see all rooms, and touch nothing.",
        hint: "Settings, Planning and driving: a doorway has to be wider than the robot and what it keeps from either side.",
        link: "run&world=doors&sensor=lidar&method=line-ekf&seed=7&set=pilot.gap:0.3",
        given: &[],
        is_method_free: false,
        seconds: 240.0,
        goals: &[least(Explored, 0.95), most(Contacts, 0.0)],
    },
    Lesson {
        name: "short-sighted",
        title: "It sees only its feet",
        fault: "The lidar measures up to 12 m, yet the robot maps as if it saw an arm's length: for most of its way it knows too little of what is around it to say where it is.",
        task: "Have it draw all rooms, and be right about its way, by the same method.",
        hint: "Settings, Points: not every reading that came is used.",
        link: "run&world=doors&sensor=lidar&method=line-ekf&seed=7&set=points.max_range:1",
        given: &[],
        is_method_free: false,
        seconds: 240.0,
        goals: &[least(Explored, 0.95), most(TrajectoryError, 0.05)],
    },
    Lesson {
        name: "long-walls",
        title: "It wants long walls only",
        fault: "The filter has one wall or none in view at a time. One wall says how far away it is, and nothing of the way along it: the robot drifts there, and then everywhere.",
        task: "Give the filter enough landmarks to stand on: all rooms, and the way right.",
        hint: "Settings, Lines: what a line has to be before it counts as a wall. The Filter tab shows which were matched.",
        link: "run&world=doors&sensor=lidar&method=line-ekf&seed=7&set=lines.min_length:4",
        given: &[],
        is_method_free: false,
        seconds: 240.0,
        goals: &[least(Explored, 0.95), most(TrajectoryError, 0.05)],
    },
    Lesson {
        name: "narrow-gate",
        title: "It knows no wall again",
        fault: "Each wall is taken for a new one as soon as it lies a few millimetres beside where it was expected. The map fills with copies, and none of them corrects the pose.",
        task: "Have walls known again: all rooms, and the way right.",
        hint: "Settings, Filter, with All settings ticked: a wall is known again inside a gate. A right one with two degrees of freedom is within d² = 6 in 95 of 100 cases.",
        link: "run&world=doors&sensor=lidar&method=line-ekf&seed=7&set=ekf.gate:0.1;ekf.new_gate:0.1",
        given: &[],
        is_method_free: false,
        seconds: 240.0,
        goals: &[least(Explored, 0.95), most(TrajectoryError, 0.05)],
    },
    Lesson {
        name: "perfect-wheels",
        title: "It takes its wheels for perfect",
        fault: "The filter believes that the wheels do not err at all. So its pose has no doubt, what it sees cannot move it, and walls that do not fit become new ones.",
        task: "Let it doubt its wheels as much as they deserve: all rooms, and the way right.",
        hint: "Settings, Odometry, with All settings ticked: how the variance grows with way and turn. Without it the ellipse stays a point.",
        link: "run&world=doors&sensor=lidar&method=line-ekf&seed=7&set=odometry.per_metre:0;odometry.lateral:0;odometry.turn:0",
        given: &[],
        is_method_free: false,
        seconds: 240.0,
        goals: &[least(Explored, 0.95), most(TrajectoryError, 0.05)],
    },
    Lesson {
        name: "crooked",
        title: "It pulls to one side",
        fault: "This robot's left track runs farther than its counter says. The filter makes up for it, but look at the trail of the wheels alone: a straight drive is a bent one.",
        task: "Calibrate the odometry, so that the wheels alone end within 8 % of the way. The tracks themselves stay as they are.",
        hint: "With All settings ticked, Settings show under Simulated tracks what is wrong, and under Odometry what the robot believes of them. The second should be as the first; half a percent matters.",
        link: "run&world=arena&sensor=lidar&method=line-ekf&seed=7&set=wear.given:1;wear.left:0.06",
        given: &["wear.given", "wear.left", "wear.right", "wear.track"],
        is_method_free: false,
        seconds: 300.0,
        goals: &[least(Explored, 0.95), most(WheelDrift, 0.08)],
    },
    Lesson {
        name: "carried-off",
        title: "Carried off",
        fault: "After half a minute somebody carries the robot into another room. It does not notice, goes on drawing where it believes to be, and lays one room upon another.",
        task: "After two minutes the robot has to know where it is, though it was carried off. Another method may help.",
        hint: "Who draws a map cannot tell a new place from a wrong pose. Who has a map of the building can look for himself in it.",
        link: "run&world=office&sensor=lidar&method=line-ekf&seed=7&do=600:kidnap",
        given: &[],
        is_method_free: true,
        seconds: 120.0,
        goals: &[most(PositionError, 0.1)],
    },
    Lesson {
        name: "too-sure",
        title: "Too sure of itself",
        fault: "Round the ring the error leaves the 3σ band, and at its end the filter does not know its own first walls again: it is much surer than it is right.",
        task: "Make the filter honest: NEES at most 6, where 3 is honest, and the way right.",
        hint: "Settings, Filter, with All settings ticked: one track always runs a little farther than the other, which is no chance; and the point at which is linearised is a choice, too.",
        link: "run&world=loop&sensor=lidar&method=line-ekf&seed=7&set=ekf.consistency:0;ekf.prior_curvature:0;ekf.prior_turn:0",
        given: &[],
        is_method_free: false,
        seconds: 600.0,
        goals: &[most(Nees, 6.0), most(TrajectoryError, 0.05)],
    },
    Lesson {
        name: "one-story",
        title: "One story only",
        fault: "Each particle is a guess of the whole way, with a map of its own. Here there is one, so the robot cannot doubt it: at the end of the ring it is surer than it is right.",
        task: "Let it keep several stories until one is proved: NEES at most 12, where 3 is honest, by the same method.",
        hint: "Settings, Grid particles: with more of them, the right story is among them more often, and their spread says how sure one may be.",
        link: "run&world=loop&sensor=lidar&method=grid-particles&seed=7&set=mapping.particles:1",
        given: &[],
        is_method_free: false,
        seconds: 600.0,
        goals: &[most(Nees, 12.0), least(Explored, 0.8)],
    },
];

const fn least(measure: Measure, bound: f64) -> Goal {
    Goal { measure, bound }
}

const fn most(measure: Measure, bound: f64) -> Goal {
    Goal { measure, bound }
}
