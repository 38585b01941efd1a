//! From the map to a path, or to the reason why there is none.

mod cspace;
mod frontier;
mod path;
mod reach;
mod route;
mod rrt;
mod shorten;
#[cfg(test)]
mod tests;
mod tree;
mod wavefront;

pub use cspace::{Both, ConfigSpace, GridSpace, SegmentSpace, Unknown, rect_around};
pub use frontier::{Frontier, FrontierConfig, find_frontiers};
pub use path::{NoPath, Path, Planner};
pub use reach::may_reach;
pub use route::{Route, RouteConfig, RouteFailure, plan_route};
pub use rrt::{Growth, RrtConfig, anywhere, rrt, rrt_connect};
pub use shorten::{densify, shorten};
pub use tree::{Nearest, Tree};
pub use wavefront::Wavefront;
