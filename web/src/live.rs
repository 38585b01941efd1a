//! What only a robot behind a bridge has: a connection, the right to drive, devices. Bytes of the
//! WebSocket come in and go out here; times are µs of the page's clock.

use serde::{Deserialize, Serialize};
use slamlab_core::live::{BridgeMap, Live, LiveConfig, Note};
use slamlab_core::wire::message::{self, Severity, ZoneBody, ZoneUse};
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{
    DeviceStateName, DisarmReasonName, FenceStateName, Level, MethodName, RoleName, SettingValues,
    Typed, WebError, messages, typed,
};
use crate::building::PriorMapSetup;
use crate::loaded_map::{MOST_WALLS, flat_points};
use crate::run::{Notice, Source, WebRun};

/// Seed of the planner's random numbers.
const SEED: u64 = 1;

/// How this page presents itself to a bridge, and how it maps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
#[tsify(missing_as_null)]
pub struct LiveSetup {
    /// Name under which others see this page.
    pub name: String,
    /// Token; with an empty one the page can only watch.
    pub token: String,
    /// The SLAM method.
    pub method: MethodName,
    /// The map for the method `prior-map`, placed by where the robot is now.
    pub prior_map: Option<PriorMapSetup>,
    /// Whether the robot drives by the cycle even if its sensor scans all the time.
    pub cycle: bool,
    /// Settings that differ from their defaults.
    pub settings: SettingValues,
}

/// What bridge and robot report of themselves. NaN for what is unknown.
#[derive(Clone, Debug, PartialEq, Serialize, Tsify)]
#[serde(rename_all = "camelCase")]
#[tsify(missing_as_null)]
pub struct BridgeStatus {
    /// This page may request the right to drive.
    pub may_drive: bool,
    /// The role of this page's right.
    pub role: RoleName,
    /// Owner of that right; empty without one, and for the bridge's own first token.
    pub right: String,
    /// This page has the right to drive.
    pub has_lease: bool,
    /// The robot moves on this page's commands.
    pub armed: bool,
    /// The emergency stop is latched.
    pub emergency: bool,
    /// Who has the right to drive; empty if nobody has.
    pub driver: String,
    /// Why the robot is not armed; null while somebody else drives it.
    pub reason: Option<DisarmReasonName>,
    /// Voltage of the battery, V.
    pub battery: f64,
    /// Round-trip time to the bridge, s.
    pub round_trip: f64,
    /// Age of the robot's newest reading at the bridge, s.
    pub reading_age: f64,
    /// Number of readings that this page missed.
    pub dropped: f64,
    /// Number of pages that are connected.
    pub watchers: u32,
    /// File of the recording; empty if there is none.
    pub recording: String,
    /// Number of messages in it.
    pub recorded: f64,
    /// The devices at the bridge's lines.
    pub devices: Vec<DeviceStatus>,
    /// State of the bridge's own map; null if it has none.
    pub map: Option<BridgeMapStatus>,
}

/// The bridge's own map, beside that of this run.
#[derive(Clone, Debug, PartialEq, Serialize, Tsify)]
#[serde(rename_all = "camelCase")]
#[tsify(missing_as_null)]
pub struct BridgeMapStatus {
    /// Grows each time the map is replaced by another one; 0 before the first.
    pub revision: f64,
    /// x y heading of its frame in the map of the run, m and rad; null while unknown.
    pub place: Option<[f64; 3]>,
    /// Name of the method.
    pub method: String,
    /// Number of scans in it since the bridge was started.
    pub scans: f64,
    /// File that it is kept in; empty if there is none.
    pub file: String,
    /// Why the file is out of date; empty if it is not.
    pub fault: String,
    /// Where in it the robot may be.
    pub geofence: FenceZones,
    /// How the robot stands to the geofence.
    pub fence_state: FenceStateName,
}

/// Zones of a geofence, in the frame of the bridge's map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct FenceZones {
    /// Without zones the robot may be anywhere.
    pub zones: Vec<FenceZone>,
}

/// A polygon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct FenceZone {
    /// Whether the robot must stay out of it; otherwise it must stay inside.
    pub keep_out: bool,
    /// x y of its corners, m.
    pub corners: Vec<[f64; 2]>,
}

impl From<&ZoneBody> for FenceZone {
    fn from(zone: &ZoneBody) -> Self {
        Self {
            keep_out: zone.kind == ZoneUse::KeepOut,
            corners: zone.corners.clone(),
        }
    }
}

impl From<FenceZone> for ZoneBody {
    fn from(FenceZone { keep_out, corners }: FenceZone) -> Self {
        let kind = match keep_out {
            true => ZoneUse::KeepOut,
            false => ZoneUse::KeepIn,
        };
        Self { kind, corners }
    }
}

/// A device at a line of the bridge.
#[derive(Clone, Debug, PartialEq, Serialize, Tsify)]
pub struct DeviceStatus {
    /// As it was named to the bridge: `rplidar:/dev/ttyUSB0`.
    pub name: String,
    /// Its model; empty until it has identified itself.
    pub model: String,
    /// Its state.
    pub state: DeviceStateName,
    /// Cause and cure of a fault.
    pub detail: String,
}

impl From<&message::Device> for DeviceStatus {
    fn from(device: &message::Device) -> Self {
        Self {
            name: device.name.clone(),
            model: device.model.clone(),
            state: device.state.into(),
            detail: device.detail.clone(),
        }
    }
}

#[wasm_bindgen]
impl WebRun {
    /// A robot that is mapped and driven through a bridge.
    ///
    /// # Errors    A sentence on an invalid setting.
    pub fn connect(setup: &Ts<LiveSetup>) -> Result<Self, WebError> {
        let setup = setup.to_rust()?;
        let live = Live::new(LiveConfig {
            name: setup.name,
            token: Some(setup.token).filter(|token| !token.is_empty()),
            method: setup.method.0,
            prior_map: setup.prior_map.as_ref().map(Into::into),
            cycle: setup.cycle,
            settings: setup.settings.0.into_iter().collect(),
            seed: SEED,
        })?;
        let source = Source::Live(Box::new(live));
        Ok(Self::of(source))
    }

    /// A new connection begins; map and pose stay.
    ///
    /// # Errors    No robot behind a bridge.
    pub fn reconnect(&mut self) -> Result<(), WebError> {
        self.live_mut()?.reconnect();
        Ok(())
    }

    /// Takes one binary message.
    ///
    /// # Errors    A sentence on why the connection can no longer be used.
    pub fn receive(&mut self, now: f64, bytes: &[u8]) -> Result<(), WebError> {
        Ok(self.live_mut()?.receive(now as u64, bytes)?)
    }

    /// To be called every 50 ms.
    ///
    /// # Errors    The bridge is gone.
    pub fn tick(&mut self, now: f64) -> Result<(), WebError> {
        Ok(self.live_mut()?.tick(now as u64)?)
    }

    /// The messages to send.
    #[must_use]
    pub fn outgoing(&mut self) -> Vec<js_sys::Uint8Array> {
        self.live_mut()
            .map_or(vec![], |live| messages(&live.take_outgoing()))
    }

    /// Whether the bridge accepted this page.
    #[must_use]
    pub fn is_in(&self) -> bool {
        self.live().is_ok_and(|live| live.client().is_in())
    }

    /// How often estimate and map were restarted.
    #[must_use]
    pub fn begun(&self) -> u32 {
        self.live().map_or(0, |live| live.begun)
    }

    /// Asks for the right to drive, and arms.
    ///
    /// # Errors    No robot behind a bridge.
    pub fn take_lease(&mut self, now: f64, force: bool) -> Result<(), WebError> {
        self.live_mut()?.take_lease(now as u64, force);
        Ok(())
    }

    /// Gives the right to drive back; the robot stops.
    ///
    /// # Errors    No robot behind a bridge.
    pub fn release_lease(&mut self, now: f64) -> Result<(), WebError> {
        self.live_mut()?.release_lease(now as u64);
        Ok(())
    }

    /// Cuts the motors off, no matter who drives.
    ///
    /// # Errors    No robot behind a bridge.
    pub fn emergency_stop(&mut self, now: f64) -> Result<(), WebError> {
        self.live_mut()?.emergency_stop(now as u64);
        Ok(())
    }

    /// Unlatches the emergency stop.
    ///
    /// # Errors    No robot behind a bridge.
    pub fn reset_emergency_stop(&mut self, now: f64) -> Result<(), WebError> {
        self.live_mut()?.reset_emergency_stop(now as u64);
        Ok(())
    }

    /// Makes the bridge begin its own map anew.
    ///
    /// # Errors    No robot behind a bridge.
    pub fn reset_bridge_map(&mut self, now: f64) -> Result<(), WebError> {
        self.live_mut()?.reset_bridge_map(now as u64);
        Ok(())
    }

    /// Sets where in the bridge's own map the robot may be.
    ///
    /// # Errors    No robot behind a bridge; a sentence on invalid polygons.
    pub fn set_geofence(&mut self, now: f64, zones: &Ts<FenceZones>) -> Result<(), WebError> {
        let zones = zones.to_rust()?.zones.into_iter().map(Into::into);
        self.live_mut()?.set_geofence(now as u64, zones.collect())?;
        Ok(())
    }

    /// The walls of the bridge's own map, in its frame: x y of the occupied cells, m.
    ///
    /// # Errors    No robot behind a bridge.
    pub fn bridge_map_walls(&self) -> Result<Vec<f32>, WebError> {
        let map = self.live()?.bridge_map.map.as_ref();
        Ok(map.map_or(vec![], |map| flat_points(&map.occupied(), MOST_WALLS).0))
    }

    /// What bridge and robot report of themselves.
    ///
    /// # Errors    No robot behind a bridge.
    pub fn bridge(&self) -> Typed<BridgeStatus> {
        typed(&BridgeStatus::of(self.live()?))
    }
}

impl From<Note> for Notice {
    fn from(Note { severity, text }: Note) -> Self {
        let level = match severity {
            Severity::Info => Level::Info,
            Severity::Warning | Severity::Error => Level::Warn,
        };
        Self { level, text }
    }
}

impl BridgeStatus {
    fn of(live: &Live) -> Self {
        let client = live.client();
        let welcome = client.welcome();
        let (safety, delays, recording) =
            (client.safety(), client.delays(), live.recording.as_ref());
        Self {
            may_drive: client.may_drive(),
            role: welcome
                .map(|welcome| welcome.role)
                .unwrap_or_default()
                .into(),
            right: welcome
                .map(|welcome| welcome.name.clone())
                .unwrap_or_default(),
            has_lease: client.has_lease(),
            armed: client.is_armed(),
            emergency: safety.is_some_and(|safety| safety.emergency),
            driver: safety
                .filter(|safety| safety.driver.is_some())
                .map(|safety| safety.driver_name.clone())
                .unwrap_or_default(),
            reason: safety
                .filter(|safety| !safety.armed)
                .map(|safety| safety.reason.into()),
            battery: live.battery.map_or(f64::NAN, f64::from),
            round_trip: delays.map_or(f64::NAN, |delays| delays.round_trip),
            reading_age: delays.map_or(f64::NAN, |delays| delays.reading_age),
            dropped: live.dropped as f64,
            watchers: u32::from(live.watchers),
            recording: recording.map(|r| r.file.clone()).unwrap_or_default(),
            recorded: recording.map_or(f64::NAN, |r| r.acknowledged as f64),
            devices: live.devices.iter().map(Into::into).collect(),
            map: BridgeMapStatus::of(&live.bridge_map),
        }
    }
}

impl BridgeMapStatus {
    fn of(map: &BridgeMap) -> Option<Self> {
        let mapping = map.mapping.as_ref()?;
        Some(Self {
            revision: map.revision as f64,
            place: (map.place).map(|place| [place.x(), place.y(), place.heading()]),
            method: mapping.method.clone(),
            scans: mapping.scans as f64,
            file: mapping.file.clone(),
            fault: mapping.fault.clone().unwrap_or_default(),
            geofence: FenceZones {
                zones: map.geofence.zones.iter().map(Into::into).collect(),
            },
            fence_state: map.geofence.state.into(),
        })
    }
}
