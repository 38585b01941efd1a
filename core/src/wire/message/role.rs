//! Roles, and what each may say.

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
    /// Whether somebody of this role may send such a message: the one table of rights, for every
    /// endpoint.
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
            // It binds who drives.
            ToBridge::SetGeofence { .. } => Self::Owner,
        };
        self as u8 >= least as u8
    }

    /// Whether somebody of this role may have the lease.
    #[must_use]
    pub const fn may_drive(self) -> bool {
        self.may(&ToBridge::Take { force: false })
    }

    /// Whether somebody of this role may take the lease from `holder` who does not give it.
    #[must_use]
    pub const fn may_take_from(self, holder: Self) -> bool {
        self.may_drive() && self as u8 >= holder as u8
    }
}

/// A right that a client has shown.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Right {
    /// What it is good for; without any, watching.
    pub role: Role,
    /// Its name. Empty where none was shown, and for the bridge's own first token.
    pub name: String,
}
