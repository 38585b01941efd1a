//! How the robot plans, drives and explores.

use crate::control::Avoidance;
use crate::plan::{FrontierChoice, Planner, Shortening, SmoothConfig};
use crate::settings::{Acts, Kind, Setting};

/// The planners that can be chosen, in the order of their names.
const PLANNERS: [Planner; 7] = [
    Planner::RrtConnect,
    Planner::Rrt,
    Planner::RrtStar,
    Planner::InformedRrtStar,
    Planner::AStar,
    Planner::ThetaStar,
    Planner::Rooms,
];

/// The ways to shorten a path, in the order of their names.
const SHORTENINGS: [Shortening; 3] = [Shortening::Nothing, Shortening::Chords, Shortening::Tight];

/// The settings.
pub(super) const DRIVING: &[Setting] = &[
    Setting {
        key: "pilot.goal_bias",
        group: "Planning and driving",
        name: "Goal bias of the RRT",
        unit: "",
        range: [0.0, 1.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "How often the goal itself is drawn. Larger: straighter in the open, sticks at walls.",
        get: |s| Some(s.pilot.route.rrt.goal_bias),
        set: |s, v| s.pilot.route.rrt.goal_bias = v,
    },
    Setting {
        key: "pilot.max_iterations",
        group: "Planning and driving",
        name: "Points of the RRT",
        unit: "",
        range: [10.0, 100000.0],
        kind: Kind::Whole,
        acts: Acts::AtOnce,
        meaning: "Most points that are drawn before the planner gives up.",
        get: |s| Some(s.pilot.route.rrt.max_iterations as f64),
        set: |s, v| s.pilot.route.rrt.max_iterations = v as usize,
    },
    Setting {
        key: "pilot.planner",
        group: "Planning and driving",
        name: "Planner",
        unit: "",
        range: [0.0, 6.0],
        kind: Kind::Choice(&[
            "RRT-Connect",
            "RRT (TDK 2016)",
            "RRT*",
            "Informed RRT*",
            "A*",
            "Theta*",
            "rooms, then Theta*",
        ]),
        acts: Acts::AtOnce,
        meaning: "Who looks for the path where the straight line is not free.",
        get: |s| {
            let place = PLANNERS.iter().position(|p| *p == s.pilot.route.planner);
            place.map(|place| place as f64)
        },
        set: |s, v| {
            if let Some(planner) = PLANNERS.get(v as usize) {
                s.pilot.route.planner = *planner;
            }
        },
    },
    Setting {
        key: "pilot.shortening",
        group: "Planning and driving",
        name: "Shortening",
        unit: "",
        range: [0.0, 2.0],
        kind: Kind::Choice(&["none", "chords (TDK 2016)", "pulled tight"]),
        acts: Acts::AtOnce,
        meaning: "What is done to the path that was found. Pulled tight: the shortest through the same gaps, in more legs.",
        get: |s| {
            let shortening = s.pilot.route.shortening;
            let place = SHORTENINGS.iter().position(|known| *known == shortening);
            place.map(|place| place as f64)
        },
        set: |s, v| {
            if let Some(shortening) = SHORTENINGS.get(v as usize) {
                s.pilot.route.shortening = *shortening;
            }
        },
    },
    Setting {
        key: "pilot.rounding",
        group: "Planning and driving",
        name: "Round corners",
        unit: "",
        range: [0.0, 1.0],
        kind: Kind::Switch,
        acts: Acts::AtOnce,
        meaning: "Corners become arcs that are driven without a stop, by pure pursuit (Coulter 1992), as far as half of the margin to walls allows.",
        get: |s| Some(f64::from(u8::from(s.pilot.route.rounding.is_some()))),
        set: |s, v| s.pilot.route.rounding = (v > 0.5).then(SmoothConfig::default),
    },
    Setting {
        key: "pilot.pace",
        group: "Planning and driving",
        name: "Pace",
        unit: "",
        range: [0.05, 1.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Part of the robot's highest speeds that is used.",
        get: |s| Some(s.pilot.follow.pace),
        set: |s, v| s.pilot.follow.pace = v,
    },
    Setting {
        key: "pilot.look_ahead",
        group: "Planning and driving",
        name: "Look ahead",
        unit: "m",
        range: [0.05, 2.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Where on the leg it aims. Shorter: back on the line sooner, swings sooner.",
        get: |s| Some(s.pilot.follow.look_ahead),
        set: |s, v| s.pilot.follow.look_ahead = v,
    },
    Setting {
        key: "pilot.tolerance",
        group: "Planning and driving",
        name: "Arrived within",
        unit: "m",
        range: [0.005, 1.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "A leg ends this near to its end.",
        get: |s| Some(s.pilot.follow.tolerance),
        set: |s, v| s.pilot.follow.tolerance = v,
    },
    Setting {
        key: "pilot.gap",
        group: "Planning and driving",
        name: "Kept from obstacles",
        unit: "m",
        range: [0.0, 0.5],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Between the robot's disc and what the last scan shows.",
        get: |s| Some(s.pilot.safe.gap),
        set: |s, v| s.pilot.safe.gap = v,
    },
    Setting {
        key: "pilot.reaction",
        group: "Planning and driving",
        name: "Reaction time",
        unit: "s",
        range: [0.0, 2.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "From a command to its effect; braking begins so much earlier.",
        get: |s| Some(s.pilot.safe.reaction),
        set: |s, v| s.pilot.safe.reaction = v,
    },
    Setting {
        key: "pilot.stale_after",
        group: "Planning and driving",
        name: "A scan is stale after",
        unit: "s",
        range: [0.05, 10.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Without a newer one the robot stops.",
        get: |s| Some(s.pilot.safe.stale_after),
        set: |s, v| s.pilot.safe.stale_after = v,
    },
    Setting {
        key: "pilot.avoidance",
        group: "Planning and driving",
        name: "People in its way",
        unit: "",
        range: [0.0, 1.0],
        kind: Kind::Choice(&["keeps to its way", "dynamic window"]),
        acts: Acts::AtOnce,
        meaning: "Keeps to its way, slows down and waits; or leaves it by the dynamic window (Fox, Burgard & Thrun 1997) while people hold it up. Safe mode limits both.",
        get: |s| {
            Some(f64::from(u8::from(
                s.pilot.avoidance == Avoidance::DynamicWindow,
            )))
        },
        set: |s, v| {
            s.pilot.avoidance = match v > 0.5 {
                true => Avoidance::DynamicWindow,
                false => Avoidance::KeepsToWay,
            }
        },
    },
    Setting {
        key: "pilot.patience",
        group: "Planning and driving",
        name: "Patience",
        unit: "s",
        range: [0.5, 60.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Without progress for this long it backs off.",
        get: |s| Some(s.pilot.patience),
        set: |s, v| s.pilot.patience = v,
    },
    Setting {
        key: "pilot.longest_leg",
        group: "Planning and driving",
        name: "Longest leg of the cycle",
        unit: "m",
        range: [0.05, 10.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "No leg between two scans is longer.",
        get: |s| Some(s.pilot.longest_leg),
        set: |s, v| s.pilot.longest_leg = v,
    },
    Setting {
        key: "pilot.leg_heading_sigma",
        group: "Planning and driving",
        name: "Heading lost in a leg",
        unit: "rad",
        range: [0.005, 1.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "How uncertain odometry may make the heading between two scans. Growing: fewer scans, more walls not recognised.",
        get: |s| Some(s.pilot.leg_heading_sigma),
        set: |s, v| s.pilot.leg_heading_sigma = v,
    },
    Setting {
        key: "pilot.legs_by_estimate",
        group: "Planning and driving",
        name: "Legs by the estimate",
        unit: "",
        range: [0.0, 1.0],
        kind: Kind::Switch,
        acts: Acts::AtOnce,
        meaning: "Rangers: drives on until the estimate says that the heading is lost, instead of judging that beforehand. Faster, and less safe among people.",
        get: |s| Some(f64::from(u8::from(s.pilot.legs_by_estimate))),
        set: |s, v| s.pilot.legs_by_estimate = v > 0.5,
    },
    Setting {
        key: "explore.min_width",
        group: "Exploration",
        name: "Narrowest frontier",
        unit: "m",
        range: [0.05, 2.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Shorter ones are dropped: about the robot's width.",
        get: |s| Some(s.pilot.frontier.min_width),
        set: |s, v| s.pilot.frontier.min_width = v,
    },
    Setting {
        key: "explore.longest",
        group: "Exploration",
        name: "Longest border",
        unit: "m",
        range: [0.5, 100.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "A longer border of the unknown is cut into several, each looked at by itself.",
        get: |s| Some(s.pilot.frontier.longest),
        set: |s, v| s.pilot.frontier.longest = v,
    },
    Setting {
        key: "explore.min_gain",
        group: "Exploration",
        name: "Least gain",
        unit: "m²",
        range: [0.0, 5.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "What promises less is not looked at.",
        get: |s| Some(s.pilot.frontier.min_gain),
        set: |s, v| s.pilot.frontier.min_gain = v,
    },
    Setting {
        key: "explore.most_gain",
        group: "Exploration",
        name: "Most gain",
        unit: "m²",
        range: [0.1, 50.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "Beyond, a hall is no better than a room round the corner.",
        get: |s| Some(s.pilot.frontier.most_gain),
        set: |s, v| s.pilot.frontier.most_gain = v,
    },
    Setting {
        key: "explore.cost_decay",
        group: "Exploration",
        name: "Worth of the near",
        unit: "1/m",
        range: [0.0, 5.0],
        kind: Kind::Real,
        acts: Acts::AtOnce,
        meaning: "How fast a gain loses worth with its way. Larger: the near first.",
        get: |s| Some(s.pilot.frontier.cost_decay),
        set: |s, v| s.pilot.frontier.cost_decay = v,
    },
    Setting {
        key: "explore.looks",
        group: "Exploration",
        name: "Looks at one frontier",
        unit: "",
        range: [1.0, 50.0],
        kind: Kind::Whole,
        acts: Acts::AtOnce,
        meaning: "So many that show nothing new, and it is given up.",
        get: |s| Some(s.pilot.looks as f64),
        set: |s, v| s.pilot.looks = v as usize,
    },
    Setting {
        key: "explore.choice",
        group: "Exploration",
        name: "Goes to",
        unit: "",
        range: [0.0, 4.0],
        kind: Kind::Choice(&[
            "most gain for its cost",
            "nearest frontier",
            "next best view",
            "room by room",
            "shortest tour over all",
        ]),
        acts: Acts::AtOnce,
        meaning: "Which border of the unknown is looked at first. The nearest is the yardstick; views cost more to compute; room by room finishes a room before it leaves.",
        get: |s| {
            let choice = s.pilot.frontier.choice;
            let place = FrontierChoice::ALL
                .iter()
                .position(|(_, known, _)| *known == choice);
            place.map(|place| place as f64)
        },
        set: |s, v| {
            if let Some((_, choice, _)) = FrontierChoice::ALL.get(v as usize) {
                s.pilot.frontier.choice = *choice;
            }
        },
    },
    Setting {
        key: "explore.return_home",
        group: "Exploration",
        name: "Comes home",
        unit: "",
        range: [0.0, 1.0],
        kind: Kind::Switch,
        acts: Acts::AtOnce,
        meaning: "Drives back to where it began when all is explored.",
        get: |s| Some(f64::from(u8::from(s.pilot.return_home))),
        set: |s, v| s.pilot.return_home = v > 0.5,
    },
];
