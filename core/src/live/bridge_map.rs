//! The map that the bridge itself keeps, as far as this client knows it: it is shown beside the map
//! of the run, which does not use it.

use crate::format::map_server::OccupancyMap;
use crate::geom::Pose2;
use crate::geom::geofence::Geofence;
use crate::robot::Odometry;
use crate::wire::CarriedPose;
use crate::wire::message::{FromBridge, GeofenceBody, MapBodyError, MappingBody, fence_of};

/// See the module.
#[derive(Clone, Debug, Default)]
pub struct BridgeMap {
    /// Its cells; `None` before the first one arrived.
    pub map: Option<OccupancyMap>,
    /// Grows with each new map; 0 for none.
    pub revision: u64,
    /// State of its mapping; `None` if the bridge does not map.
    pub mapping: Option<MappingBody>,
    /// Where the robot may be in it.
    pub geofence: GeofenceBody,
    /// `run_map_from_bridge_map`, from the robot's pose in both. `None` before both know it.
    pub place: Option<Pose2>,
    pose: CarriedPose,
    fence: Geofence,
}

impl BridgeMap {
    /// Where the robot may be, in the run's map; `None` before both maps know where the robot is.
    /// Until then the bridge does not allow it to be armed.
    pub(super) fn fence_in_run(&self) -> Option<Geofence> {
        Some(self.fence.moved(&self.place?))
    }

    /// Takes a message about it; `estimate` is the robot's present pose in the run's map.
    ///
    /// # Errors    [`MapBodyError`]; the previous map then stays.
    pub(super) fn take(
        &mut self,
        message: &FromBridge,
        estimate: &Pose2,
    ) -> Result<(), MapBodyError> {
        match message {
            FromBridge::Odometry(body) => {
                // If something is wrong with it, the timeline says so.
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
                // A bridge never keeps an invalid one.
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
