//! The map that the bridge itself keeps, as far as this client knows it: it is shown beside that of
//! the run, which does not know of it.

use crate::format::map_server::OccupancyMap;
use crate::geom::Pose2;
use crate::geom::geofence::Geofence;
use crate::robot::Odometry;
use crate::wire::CarriedPose;
use crate::wire::message::{FromBridge, GeofenceBody, MapBodyError, MappingBody, fence_of};

/// See the module.
#[derive(Clone, Debug, Default)]
pub struct BridgeMap {
    /// Its cells; none before it came.
    pub map: Option<OccupancyMap>,
    /// Grows with each map that is another one; 0 for none.
    pub revision: u64,
    /// How its mapping does; none of a bridge that does not map.
    pub mapping: Option<MappingBody>,
    /// Where the robot may be in it.
    pub geofence: GeofenceBody,
    /// `run_map_from_bridge_map`: both know where the robot is. None before they do.
    pub place: Option<Pose2>,
    pose: CarriedPose,
    fence: Geofence,
}

impl BridgeMap {
    /// Where the robot may be, in the run's map; none before both maps know where the robot is.
    /// Until then the bridge does not let it be armed.
    pub(super) fn fence_in_run(&self) -> Option<Geofence> {
        Some(self.fence.moved(&self.place?))
    }

    /// Takes what a message says of it; `estimate` is where the robot is now in the run's map.
    ///
    /// # Errors    [`MapBodyError`]; then the map before stays.
    pub(super) fn take(
        &mut self,
        message: &FromBridge,
        estimate: &Pose2,
    ) -> Result<(), MapBodyError> {
        match message {
            FromBridge::Odometry(body) => {
                // What is wrong with it the timeline says.
                if let Ok(step) = body.odometry() {
                    self.moved(&step, estimate);
                }
            }
            FromBridge::Pose(body) => {
                self.pose.tell(body);
                self.find_place(estimate);
            }
            FromBridge::Map(body) => {
                self.map = Some(body.map()?);
                self.revision = body.revision;
            }
            FromBridge::Mapping(body) => self.mapping = Some(body.clone()),
            FromBridge::Geofence(body) => {
                self.geofence = body.clone();
                // A bridge keeps none that is none.
                self.fence = fence_of(&body.zones).unwrap_or_default();
            }
            _ => (),
        }
        Ok(())
    }

    fn moved(&mut self, step: &Odometry, estimate: &Pose2) {
        let waited = self.pose.now().is_none();
        self.pose.odometry(step);
        if waited {
            self.find_place(estimate);
        }
    }

    fn find_place(&mut self, estimate: &Pose2) {
        if let Some(now) = self.pose.now() {
            self.place = Some(*estimate * now.pose.inverse());
        }
    }
}
