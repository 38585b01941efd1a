//! Roles, and which messages each may send.

use super::ToBridge;
use super::names::named;

named! {
    /// What a right is good for. A later one may do all that an earlier one may.
    #[derive(Default, PartialOrd, Ord)]
    pub enum Role {
        /// Looks, and stops the robot.
        #[default]
        Watcher = "watcher",
        /// Drives, too.
        Driver = "driver",
        /// Also takes the lease from an owner, and says where the robot may be.
        Owner = "owner",
    }
}

impl Role {
    /// Whether this role may send such a message: the one table of rights, for every endpoint.
    #[must_use]
    pub const fn may(self, message: &ToBridge) -> bool {
        let least = match message {
            ToBridge::Hello(_)
            | ToBridge::Heartbeat
            | ToBridge::Probe { .. }
            | ToBridge::Stop
            | ToBridge::EmergencyStop => Self::Watcher,
            ToBridge::Take { .. }
            | ToBridge::Renew { .. }
            | ToBridge::Release { .. }
            | ToBridge::Arm { .. }
            | ToBridge::Drive(_)
            | ToBridge::Hold { .. }
            | ToBridge::ResetEmergencyStop { .. }
            | ToBridge::ResetMap => Self::Driver,
            // It restricts the driver.
            ToBridge::SetGeofence { .. } => Self::Owner,
        };
        self as u8 >= least as u8
    }

    /// Whether this role may have the lease.
    #[must_use]
    pub const fn may_drive(self) -> bool {
        self.may(&ToBridge::Take { force: false })
    }

    /// Whether this role may take the lease from a `holder` that does not give it back.
    #[must_use]
    pub const fn may_take_from(self, holder: Self) -> bool {
        self.may_drive() && self as u8 >= holder as u8
    }
}

/// A right that a client has shown.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Right {
    /// Its role; a watcher's if no right was shown.
    pub role: Role,
    /// Its name. Empty if none was shown, and for the bridge's own first token.
    pub name: String,
}
