//! The mapper's results: for the hub, which sends them to its clients, and for HTTP.

use std::sync::Arc;

use slamlab_core::format::map_server::OccupancyMap;
use slamlab_core::wire::message::FromBridge;

/// The newest of each; none before the first.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shown {
    /// [`FromBridge::Pose`].
    pub(crate) pose: Option<Arc<FromBridge>>,
    /// [`FromBridge::Map`].
    pub(crate) map: Option<Arc<FromBridge>>,
    /// [`FromBridge::Mapping`].
    pub(crate) mapping: Option<Arc<FromBridge>>,
    /// The same map, with its revision.
    pub(crate) cells: Option<(u64, Arc<OccupancyMap>)>,
}

impl Shown {
    /// What a new client is told.
    pub(crate) fn all(&self) -> impl Iterator<Item = &Arc<FromBridge>> {
        [&self.mapping, &self.map, &self.pose].into_iter().flatten()
    }

    /// The messages that differ from those in `before`.
    pub(crate) fn since<'a>(
        &'a self,
        before: &'a Self,
    ) -> impl Iterator<Item = &'a Arc<FromBridge>> {
        let now = [&self.mapping, &self.map, &self.pose];
        let then = [&before.mapping, &before.map, &before.pose];
        now.into_iter().zip(then).filter_map(|(now, then)| {
            let now = now.as_ref()?;
            let is_same = then.as_ref().is_some_and(|then| Arc::ptr_eq(now, then));
            (!is_same).then_some(now)
        })
    }
}
