//! What a session shows of the robot and of the bridge.

use super::Live;
use crate::session::Session;
use crate::wire::client::Client;
use crate::wire::message::{Device, RecordingBody};

impl Live {
    /// The conversation with the bridge.
    #[must_use]
    pub fn client(&self) -> &Client {
        &self.client
    }

    /// How often estimate and map began: with the first hello of a bridge, and with one that names another robot.
    #[must_use]
    pub fn begun(&self) -> u32 {
        self.begun
    }

    /// What robot and sensors told so far, and what is intended; of a robot of which nothing is known, the figures of a Pioneer.
    #[must_use]
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// Robot and sensors, as last told.
    #[must_use]
    pub fn devices(&self) -> &[Device] {
        &self.devices
    }

    /// How the recording goes; none where nothing is recorded.
    #[must_use]
    pub fn recording(&self) -> Option<&RecordingBody> {
        self.recording.as_ref()
    }

    /// Volts of the battery; none before the robot told.
    #[must_use]
    pub fn battery(&self) -> Option<f32> {
        self.battery
    }

    /// Readings that this client missed because newer ones came before it took them.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Clients that are connected to the bridge, this one included.
    #[must_use]
    pub fn watchers(&self) -> u16 {
        self.watchers
    }
}
