//! From the map to a path, or to the reason why there is none.

mod a_star;
mod branches;
mod contest;
mod cspace;
mod frontier;
#[cfg(test)]
mod frontier_tests;
mod guide;
mod lattice;
mod outline;
mod path;
mod point_index;
mod pull_tight;
mod query;
mod reach;
mod rooms;
mod route;
mod rrt;
mod rrt_connect;
mod rrt_star;
mod sampler;
mod search;
#[cfg(test)]
mod search_tests;
mod shorten;
mod smooth;
mod squares;
mod tangents;
#[cfg(test)]
mod tests;
mod theta_star;
mod tour;
mod tree;
mod vertex_tree;
mod view;
mod visibility;
mod wavefront;

pub use a_star::AStar;
pub use contest::{
    CONTESTANTS, Contest, ContestBody, ContestConfig, ContestError, Shortest, Standing,
};
pub use cspace::{ConfigSpace, GridSpace, SegmentSpace, SpaceError, Unknown, Within, rect_around};
pub use frontier::{Frontier, FrontierChoice, FrontierConfig, find_frontiers};
pub use lattice::Lattice;
pub use outline::{follows, plan_outline_route};
pub use path::{NoPath, Path, Planner};
pub use pull_tight::pull_tight;
pub use query::{Progress, Query};
pub use rooms::NoRooms;
pub(crate) use route::ESCAPE_REACH;
pub use route::{Route, RouteConfig, RouteFailure, Shortening, plan_route};
pub use rrt::RrtConfig;
pub use sampler::Sampler;
pub use search::Search;
pub use shorten::{densify, shorten};
pub use smooth::{Piece, smooth};
pub(crate) use tour::SAME_GOAL;
pub use tour::order_by_tour;
pub use wavefront::Wavefront;
