//! How the robot plans, drives and explores.

use super::{DRIVEN, Group};
use crate::bounds::PART;
use crate::control::Avoidance;
use crate::plan::{FrontierChoice, Planner, Shortening};
use crate::settings::field::{Number, at, rows};
use crate::settings::setting::{
    CENTIMETRES, DEGREES, Field, METRES, NUMBER, PERCENT, SECONDS, SQUARE_METRES, Setting, one_of,
    real, si, switch, whole,
};

const OF_DRIVING: Group = Group {
    name: "Planning and driving",
    ..DRIVEN
};
const PLANNER: &str = "pilot.planner";
const TREES: &[&str] = &["rrt-connect", "rrt", "rrt-star", "informed-rrt-star"];
const LONG_LEGGED: &[&str] = &["rrt-connect", "rrt-star", "informed-rrt-star"];
const OPTIMISING: &[&str] = &["rrt-star", "informed-rrt-star"];

rows! { DRIVING = OF_DRIVING;
    "pilot.planner", "Planner", one_of::<Planner>(), [pilot.route.planner].basic(),
        "Who looks for the path where the straight line is not free.";
    "pilot.goal_bias", "Goal bias of the tree", real(PART, PERCENT), [pilot.route.rrt.goal_bias].needs(PLANNER, &["rrt"]),
        "How often the goal itself is drawn. Larger: straighter in the open, sticks at walls.";
    "pilot.max_iterations", "Points of a tree", whole([10.0, 100_000.0], NUMBER), [pilot.route.rrt.max_iterations].needs(PLANNER, TREES),
        "Most points that are drawn before the planner gives up. Larger: hard paths are found, in more time.";
    "pilot.tree_range", "Longest leg of a tree", real([0.1, 50.0], METRES), [pilot.route.rrt.range].needs(PLANNER, LONG_LEGGED),
        "Larger: fewer points for a first path, and longer straight legs.";
    "pilot.rewire_factor", "Radius of better parents", real([0.5, 10.0], si("×")), [pilot.route.rrt.rewire_factor].needs(PLANNER, OPTIMISING),
        "In units of the least that converges (Karaman & Frazzoli 2011). Larger: shorter paths in fewer, slower iterations.";
    "pilot.seeded_tree", "First path by RRT-Connect", switch(), [pilot.route.rrt.is_seeded].needs(PLANNER, OPTIMISING),
        "On: the first path comes from RRT-Connect, which finds one many times sooner. Off: RRT* as published.";
    "pilot.shortening", "Shortening", one_of::<Shortening>(), [pilot.route.shortening].basic(),
        "What is done to the path that was found. Pulled tight: the shortest through the same gaps, in more legs.";
    "pilot.rounding", "Round corners", switch(), [pilot.route.is_rounded].basic(),
        "Corners become arcs that are driven without a stop, by pure pursuit (Coulter 1992), as far as half of the margin to walls allows.";
    "pilot.pace", "Pace", real([0.05, 1.0], PERCENT), [pilot.follow.pace].basic(),
        "Part of the robot's highest speeds that is used. Larger: faster, and farther off the path.";
    "pilot.look_ahead", "Look ahead", real([0.05, 2.0], METRES), [pilot.follow.look_ahead],
        "Where on the leg it aims. Larger: back on the line later, but without swinging.";
    "pilot.tolerance", "Arrived within", real([0.005, 1.0], CENTIMETRES), [pilot.follow.tolerance],
        "A leg ends this near to its end. Larger: faster, and farther off.";
    "pilot.gap", "Kept from obstacles", real([0.0, 0.5], CENTIMETRES), [pilot.safe.gap].basic(),
        "Between the robot and what the last scan shows. Larger: safer, and slower in narrow places.";
    "pilot.reaction", "Reaction time", real([0.0, 2.0], SECONDS), [pilot.safe.reaction].basic(),
        "From a command to its effect. Larger: braking begins earlier.";
    "pilot.stale_after", "A scan is stale after", real([0.05, 10.0], SECONDS), [pilot.safe.stale_after],
        "Without a newer one the robot stops. Larger: it drives longer without seeing.";
    "pilot.avoidance", "People in its way", one_of::<Avoidance>(), [pilot.avoidance].basic(),
        "Keeps to its way, slows down and waits; or leaves it by the dynamic window (Fox, Burgard & Thrun 1997) while people hold it up. Safe mode limits both.";
    "pilot.patience", "Patience", real([0.5, 60.0], SECONDS), [pilot.patience],
        "Without progress for this long it backs off. Larger: it waits longer for people, and when it is stuck.";
    "pilot.longest_leg", "Longest leg of the cycle", real([0.05, 10.0], METRES), [pilot.longest_leg].basic(),
        "No leg between two scans is longer. Larger: fewer stops, more of the way unseen.";
    "pilot.leg_heading_sigma", "Heading lost in a leg", real([0.005, 1.0], DEGREES), [pilot.leg_heading_sigma],
        "How uncertain odometry may make the heading between two scans. Larger: fewer scans, more walls not recognised.";
    "pilot.legs_by_estimate", "Legs by the estimate", switch(), [pilot.legs_by_estimate],
        "Rangers: drives on until the estimate says that the heading is lost, instead of judging that beforehand. Faster, and less safe among people.";
}

const OF_EXPLORATION: Group = Group {
    name: "Exploration",
    ..DRIVEN
};
const CHOICE: &str = "explore.choice";

rows! { EXPLORATION = OF_EXPLORATION;
    "explore.choice", "Next frontier", one_of::<FrontierChoice>(), [pilot.frontier.choice].basic(),
        "Which border of the unknown is visited first. The nearest is the yardstick; views cost more to compute; room by room finishes a room before it leaves.";
    "explore.sight", "Sight of a view", real([0.5, 50.0], METRES), [pilot.frontier.sight].needs(CHOICE, &["next-best-view"]),
        "How far the sensor is taken to see. Larger: halls are preferred, more work.";
    "explore.min_width", "Narrowest frontier", real([0.05, 2.0], CENTIMETRES), [pilot.frontier.min_width].basic(),
        "Shorter ones are dropped: about the robot's width. Larger: sooner done, corners stay unknown.";
    "explore.longest", "Longest frontier", real([0.5, 100.0], METRES), [pilot.frontier.longest],
        "A longer one is cut into several, each visited by itself. Larger: fewer visits, less of each border seen.";
    "explore.min_gain", "Least gain", real([0.0, 5.0], SQUARE_METRES), [pilot.frontier.min_gain],
        "What promises less is not visited. Larger: sooner done, corners stay unknown.";
    "explore.most_gain", "Most gain", real([0.1, 50.0], SQUARE_METRES), [pilot.frontier.most_gain].needs(CHOICE, &["gain-over-cost", "room-by-room"]),
        "Beyond, a hall is no better than a room round the corner. Larger: large unknown areas come first.";
    "explore.cost_decay", "Preference for near frontiers", real([0.0, 5.0], si("1/m")), [pilot.frontier.cost_decay].needs(CHOICE, &["gain-over-cost", "next-best-view", "room-by-room"]),
        "How fast a gain loses worth with the way to it. Larger: near frontiers come first.";
    "explore.looks", "Scans at one frontier", whole([1.0, 50.0], NUMBER), [pilot.scans_per_frontier],
        "After so many that show nothing new it is given up. Larger: more patience with glass and narrow places.";
    "explore.close_loops", "Closes loops", switch(), [pilot.close_loops].basic(),
        "When all is explored, drives on through places that lie next to each other and that the map joins only by a long way round, until the loop is closed. Scan matching only.";
    "explore.return_home", "Comes home", switch(), [pilot.return_home].basic(),
        "Drives back to where it began when all is explored.";
}
