//! What becomes of an event on its way to clients.

use crate::robot::Stamp;
use crate::wire::message::{
    BatteryBody, BumpersBody, CurrentsBody, Device, DeviceState, DisarmReason, FromBridge,
    LinkBody, OdometryBody, RangersBody, ScanBody,
};

use crate::device::source::{Profile, SourceEvent};

/// Robot and sensors, as clients know them.
#[derive(Clone, Debug, Default)]
pub struct Devices(Vec<Device>);

impl Devices {
    /// Those of these sources, in the order of their numbers; they wait.
    #[must_use]
    pub fn new<'a>(sources: impl IntoIterator<Item = &'a Profile>) -> Self {
        let device = |(number, profile): (usize, &Profile)| Device {
            source: number as u8,
            name: profile.name.clone(),
            model: String::new(),
            state: DeviceState::Waiting,
            detail: String::new(),
        };
        Self(sources.into_iter().enumerate().map(device).collect())
    }

    /// All of them.
    #[must_use]
    pub fn all(&self) -> &[Device] {
        &self.0
    }
}

impl Devices {
    /// What clients are told of an event of source `source`; none where it is not for them.
    pub fn message(&mut self, source: u8, event: SourceEvent) -> Option<FromBridge> {
        let micros = |stamp: Stamp| stamp.0;
        Some(match event {
            SourceEvent::Odometry(odometry) => {
                FromBridge::Odometry(OdometryBody::new(source, &odometry))
            }
            SourceEvent::Scan(scan) => FromBridge::Scan(ScanBody::new(source, &scan)),
            SourceEvent::Rangers { stamp, readings } => FromBridge::Rangers(RangersBody {
                source,
                stamp: micros(stamp),
                readings,
            }),
            SourceEvent::Bumpers { stamp, left, right } => FromBridge::Bumpers(BumpersBody {
                source,
                stamp: micros(stamp),
                left,
                right,
            }),
            SourceEvent::Battery { stamp, volts } => FromBridge::Battery(BatteryBody {
                source,
                stamp: micros(stamp),
                volts,
            }),
            SourceEvent::Currents { stamp, left, right } => FromBridge::Currents(CurrentsBody {
                source,
                stamp: micros(stamp),
                left,
                right,
            }),
            SourceEvent::Link(link) => FromBridge::Link(LinkBody {
                source,
                state: link.state,
                round_trip: link.round_trip.map(|duration| duration.as_secs_f32()),
                damaged: link.damaged,
                skipped: link.skipped,
            }),
            // What a look means for driving is known here.
            SourceEvent::Busy { .. } | SourceEvent::PartialScan(_) => return None,
            SourceEvent::Device {
                state,
                model,
                detail,
            } => return self.device(source, state, model, detail),
        })
    }

    fn device(
        &mut self,
        source: u8,
        state: DeviceState,
        model: String,
        detail: String,
    ) -> Option<FromBridge> {
        let device = self.0.get_mut(usize::from(source))?;
        (device.state, device.detail) = (state, detail);
        if !model.is_empty() {
            device.model = model;
        }
        Some(FromBridge::Devices(self.0.clone()))
    }
}

/// A sentence for a person.
pub fn explain(reason: DisarmReason) -> &'static str {
    match reason {
        DisarmReason::Bumper => {
            "A bumper was pressed: the robot was stopped. Arm it again to back off."
        }
        DisarmReason::Battery => "The battery is nearly empty: the robot was stopped. Charge it.",
        DisarmReason::Stall => {
            "The robot was told to run and does not move: it was stopped. Look whether something blocks its tracks."
        }
        DisarmReason::Runaway => {
            "The robot moves without being told to: its motors were cut off. Reset the emergency stop when it is safe."
        }
        DisarmReason::Silence => {
            "The robot has said nothing for half a second: it was stopped. Look at its link."
        }
        _ => "The robot was stopped.",
    }
}
