//! Robot and sensors as clients see them, and how events become messages to clients.

use crate::wire::message::{
    BatteryBody, BumpersBody, CurrentsBody, Device, DeviceState, FromBridge, LinkBody,
    OdometryBody, RangersBody, ScanBody,
};

use crate::device::source::{Profile, SourceEvent};

/// Robot and sensors, as clients know them.
#[derive(Clone, Debug)]
pub(super) struct DeviceList(Vec<Device>);

impl DeviceList {
    /// The devices of these sources, in the order of their numbers; all are waiting.
    pub(super) fn new(sources: &[&Profile]) -> Self {
        let device = |(number, profile): (usize, &&Profile)| Device {
            source: number as u8,
            name: profile.name.clone(),
            model: String::new(),
            state: DeviceState::Waiting,
            detail: String::new(),
        };
        Self(sources.iter().enumerate().map(device).collect())
    }

    /// All of them.
    pub(super) fn all(&self) -> &[Device] {
        &self.0
    }

    /// The message to clients for an event of source `source`; none if clients do not get it.
    pub(super) fn message(&mut self, source: u8, event: SourceEvent) -> Option<FromBridge> {
        Some(match event {
            SourceEvent::Odometry(odometry) => {
                FromBridge::Odometry(OdometryBody::new(source, &odometry))
            }
            SourceEvent::Scan(scan) => FromBridge::Scan(ScanBody::new(source, &scan)),
            SourceEvent::PartialScan(scan) => FromBridge::PartialScan(ScanBody::new(source, &scan)),
            SourceEvent::Rangers(body) => FromBridge::Rangers(RangersBody { source, ..body }),
            SourceEvent::Bumpers(body) => FromBridge::Bumpers(BumpersBody { source, ..body }),
            SourceEvent::Battery(body) => FromBridge::Battery(BatteryBody { source, ..body }),
            SourceEvent::Currents(body) => FromBridge::Currents(CurrentsBody { source, ..body }),
            SourceEvent::Link(body) => FromBridge::Link(LinkBody { source, ..body }),
            // Only the hub uses it, to tell when a manoeuvre is over.
            SourceEvent::Busy { .. } => return None,
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
