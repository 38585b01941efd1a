//! The hub's side of the robot: what its readings mean for driving, and what becomes of an event on its way to clients.

use std::time::Duration;

use slamlab_core::robot::{Command, Stamp};
use slamlab_core::wire::message::{
    BatteryBody, BumpersBody, CurrentsBody, DeviceState, DisarmReason, FromBridge, LinkBody,
    LinkState, OdometryBody, RangersBody, ScanBody,
};

use super::Hub;
use crate::safety::plausible::{Plausible, PlausibleConfig};
use crate::safety::safe_mode::SafeMode;
use crate::source::{self, Event, Order, Running};

/// What is known of the robot that takes commands: the first source that has one.
pub(super) struct RobotSide {
    source: Option<usize>,
    safe_mode: Option<SafeMode>,
    /// As it was before the first reading; a link that comes back begins with it.
    fresh: Option<SafeMode>,
    plausible: Plausible,
    /// Newest stamp, and when it came.
    newest: (Stamp, Duration),
    is_up: bool,
}

/// What an event means for driving.
#[derive(Debug, Default)]
pub(super) struct Consequence {
    /// The robot's link came up or went.
    pub(super) link: Option<bool>,
    /// The robot must not go on.
    pub(super) fault: Option<DisarmReason>,
    /// What is under way is no longer safe; this is.
    pub(super) correction: Option<Command>,
}

impl RobotSide {
    pub(super) fn new(sources: &[Running]) -> Self {
        let source = sources
            .iter()
            .position(|source| source.profile.robot.is_some() && source.profile.takes_orders);
        let on_command = source::scans_on_command(sources.iter().map(|source| &source.profile));
        let fresh = source
            .and_then(|at| sources[at].profile.robot)
            .map(|robot| SafeMode::new(robot, on_command));
        Self {
            source,
            safe_mode: fresh.clone(),
            fresh,
            plausible: Plausible::new(PlausibleConfig::default()),
            newest: (Stamp::default(), Duration::ZERO),
            is_up: false,
        }
    }

    /// Which source takes the orders.
    pub(super) fn source(&self) -> Option<usize> {
        self.source
    }

    /// The robot's newest stamp, and when it came.
    pub(super) fn newest(&self) -> (Stamp, Duration) {
        self.newest
    }

    /// The order as far as it is safe.
    pub(super) fn limit(&mut self, order: Order) -> Order {
        match (order, &mut self.safe_mode) {
            (Order::Command(command), Some(safe_mode)) => Order::Command(safe_mode.limit(command)),
            (order, Some(safe_mode)) => {
                safe_mode.stopped();
                order
            }
            (order, None) => order,
        }
    }

    /// Remembers what the robot was told.
    pub(super) fn ordered(&mut self, order: &Order) {
        self.plausible.ordered(order);
    }

    pub(super) fn silence(&mut self, now: Duration) -> Option<DisarmReason> {
        self.plausible.silence(now)
    }

    pub(super) fn deadline(&self) -> Option<Duration> {
        self.plausible.deadline()
    }

    /// Takes an event. Scans count from whatever source: the lidar may be another than the robot.
    pub(super) fn event(&mut self, now: Duration, source: u8, event: &Event) -> Consequence {
        let mut consequence = Consequence::default();
        if let Event::Scan(scan) = event {
            let safe_mode = self.safe_mode.as_mut();
            consequence.correction = safe_mode.and_then(|safe_mode| safe_mode.scan(scan));
        }
        if self.source != Some(usize::from(source)) {
            return consequence;
        }
        match event {
            Event::Odometry(odometry) => {
                if odometry.from < self.newest.0 {
                    self.begin_anew();
                }
                self.newest = (odometry.to, now);
                consequence.fault = self.plausible.odometry(now, odometry);
                if let Some(safe_mode) = &mut self.safe_mode {
                    safe_mode.odometry(odometry);
                }
            }
            Event::Bumpers { left, right, .. } => {
                consequence.fault = self.plausible.bumpers([*left, *right]);
            }
            Event::Battery { volts, .. } => {
                consequence.fault = self.plausible.battery(now, *volts);
            }
            Event::Link(link) => consequence.link = self.link(link.state == LinkState::Up),
            _ => (),
        }
        consequence
    }

    fn link(&mut self, is_up: bool) -> Option<bool> {
        let was_up = std::mem::replace(&mut self.is_up, is_up);
        if is_up && !was_up {
            self.begin_anew();
        }
        (was_up != is_up).then_some(is_up)
    }

    /// A robot that came back may have been carried away, and its clock begins at 0.
    fn begin_anew(&mut self) {
        self.safe_mode = self.fresh.clone();
        self.plausible = Plausible::new(PlausibleConfig::default());
        self.newest.0 = Stamp::default();
    }
}

impl Hub {
    /// What the clients are told of an event.
    pub(super) fn message(&mut self, source: u8, event: Event) -> Option<FromBridge> {
        let micros = |stamp: Stamp| stamp.0;
        Some(match event {
            Event::Odometry(odometry) => FromBridge::Odometry(OdometryBody::new(source, &odometry)),
            Event::Scan(scan) => FromBridge::Scan(ScanBody::new(source, &scan)),
            Event::Rangers { stamp, readings } => FromBridge::Rangers(RangersBody {
                source,
                stamp: micros(stamp),
                readings,
            }),
            Event::Bumpers { stamp, left, right } => FromBridge::Bumpers(BumpersBody {
                source,
                stamp: micros(stamp),
                left,
                right,
            }),
            Event::Battery { stamp, volts } => FromBridge::Battery(BatteryBody {
                source,
                stamp: micros(stamp),
                volts,
            }),
            Event::Currents { stamp, left, right } => FromBridge::Currents(CurrentsBody {
                source,
                stamp: micros(stamp),
                left,
                right,
            }),
            Event::Link(link) => FromBridge::Link(LinkBody {
                source,
                state: link.state,
                round_trip: link.round_trip.map(|duration| duration.as_secs_f32()),
                damaged: link.damaged,
                skipped: link.skipped,
            }),
            Event::Busy { .. } => return None,
            Event::Device {
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
        let device = self.devices.get_mut(usize::from(source))?;
        if state == DeviceState::Fault {
            tracing::warn!("{}: {detail}", device.name);
        }
        (device.state, device.detail) = (state, detail);
        if !model.is_empty() {
            device.model = model;
        }
        Some(FromBridge::Devices(self.devices.clone()))
    }
}

/// A sentence for a person.
pub(super) fn explain(reason: DisarmReason) -> &'static str {
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
