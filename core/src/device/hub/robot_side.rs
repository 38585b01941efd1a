//! What the robot's readings mean for driving.

use std::time::Duration;

use crate::control::SafeMode;
use crate::robot::{Command, RobotModel, Stamp};
use crate::wire::message::{DisarmReason, LinkState, PoseBody};

use super::fence::Fence;

use crate::device::safety::plausible::Plausible;
use crate::device::source::{self, Order, Profile, SourceEvent};

/// What is known of the robot that takes commands: that of the first source that takes orders.
#[derive(Clone, Debug)]
pub(super) struct RobotSide {
    /// Which source takes the orders.
    pub(super) source: Option<usize>,
    model: Option<RobotModel>,
    safe_mode: Option<SafeMode>,
    /// Safe mode as it was before the first reading; it is restored when the link comes back.
    fresh: Option<SafeMode>,
    /// Only if the bridge maps.
    pub(super) fence: Option<Fence>,
    pub(super) plausible: Plausible,
    /// Newest stamp, and when it arrived.
    pub(super) newest: (Stamp, Duration),
    is_up: bool,
    /// When a sensor that scans all the time was last heard; none before it was heard at all.
    scanned: Option<Duration>,
    scans_on_command: bool,
}

/// A sensor is silent after this time without a scan: a few revolutions of the slowest lidar.
const SILENT: Duration = Duration::from_secs(2);

/// What an event means for driving.
#[derive(Debug, Default)]
pub(super) struct Consequence {
    /// The robot's link came up or was lost.
    pub(super) link: Option<bool>,
    /// The robot must not go on.
    pub(super) fault: Option<DisarmReason>,
    /// The command under way is no longer safe; this one is.
    pub(super) correction: Option<Command>,
}

impl RobotSide {
    /// For these sources, in the order of their numbers.
    pub(super) fn new(sources: &[&Profile]) -> Self {
        let takes_orders = |profile: &&Profile| profile.robot.is_some() && profile.takes_orders;
        let source = sources.iter().position(takes_orders);
        let on_command = source::scans_on_command(sources);
        let model = source.and_then(|at| sources.get(at)?.robot);
        let fresh = model.map(|robot| SafeMode::new(robot, on_command));
        Self {
            source,
            model,
            safe_mode: fresh.clone(),
            fresh,
            fence: None,
            plausible: Plausible::default(),
            newest: (Stamp::default(), Duration::ZERO),
            is_up: false,
            scanned: None,
            scans_on_command: on_command,
        }
    }

    /// Of the robot that takes orders.
    pub(super) fn model(&self) -> Option<RobotModel> {
        self.model
    }

    /// Whether a sensor that scans all the time was heard and has fallen silent. One that was never
    /// heard may not exist.
    pub(super) fn is_blind(&self, now: Duration) -> bool {
        let is_late = |at: Duration| now.saturating_sub(at) > SILENT;
        !self.scans_on_command && self.scanned.is_some_and(is_late)
    }

    /// Limits the order to what is safe.
    pub(super) fn limit(&mut self, order: Order) -> Order {
        let Order::Command(command) = order else {
            if let Some(safe_mode) = &mut self.safe_mode {
                safe_mode.stopped();
            }
            if let Some(fence) = &mut self.fence {
                fence.stopped();
            }
            return order;
        };
        let within = match &mut self.fence {
            Some(fence) => fence.limit(command),
            None => command,
        };
        Order::Command(self.safe(within))
    }

    /// Limits a command that stays within the fence to what obstacles allow; what safe mode makes
    /// of it must stay within the fence, too.
    fn safe(&mut self, within: Command) -> Command {
        let Some(safe_mode) = &mut self.safe_mode else {
            return within;
        };
        let safe = safe_mode.limit(within);
        self.within(safe)
    }

    fn within(&self, command: Command) -> Command {
        match &self.fence {
            Some(fence) => fence.bounded(command),
            None => command,
        }
    }

    /// Takes where the robot is in the bridge's map; returns a safe command if the one under way no
    /// longer is.
    pub(super) fn pose(&mut self, body: &PoseBody) -> Option<Command> {
        let now = self.fence.as_mut()?.pose(body)?;
        Some(self.safe(now))
    }

    /// Takes an event. Scans of every source count: the lidar may be a device of its own.
    pub(super) fn event(&mut self, now: Duration, source: u8, event: &SourceEvent) -> Consequence {
        let mut consequence = Consequence::default();
        if let SourceEvent::Scan(scan) = event {
            self.scanned = Some(now);
            let safe_mode = self.safe_mode.as_mut();
            let correction = safe_mode.and_then(|safe_mode| safe_mode.scan(scan));
            consequence.correction = correction.map(|command| self.within(command));
        }
        if self.source != Some(usize::from(source)) {
            return consequence;
        }
        match event {
            SourceEvent::PartialScan(scan) => {
                let safe_mode = self.safe_mode.as_mut();
                consequence.correction =
                    safe_mode.and_then(|safe_mode| safe_mode.partial_scan(scan));
            }
            SourceEvent::Odometry(odometry) => {
                if odometry.from < self.newest.0 {
                    self.begin_anew();
                }
                self.newest = (odometry.to, now);
                consequence.fault = self.plausible.odometry(now, odometry);
                if let Some(safe_mode) = &mut self.safe_mode {
                    consequence.correction = safe_mode.odometry(odometry);
                }
            }
            SourceEvent::Bumpers(bumpers) => {
                consequence.fault = self.plausible.bumpers([bumpers.left, bumpers.right]);
            }
            SourceEvent::Battery(battery) => {
                consequence.fault = self.plausible.battery(now, battery.volts);
            }
            SourceEvent::Link(link) => consequence.link = self.link(link.state == LinkState::Up),
            _ => (),
        }
        consequence.correction = consequence.correction.map(|command| self.within(command));
        if let SourceEvent::Odometry(odometry) = event {
            let fence = self.fence.as_mut();
            if let Some(within) = fence.and_then(|fence| fence.odometry(odometry)) {
                consequence.correction = Some(self.safe(within));
            }
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

    /// A robot that came back may have been carried elsewhere, and its clock starts at 0.
    fn begin_anew(&mut self) {
        self.safe_mode = self.fresh.clone();
        self.plausible = Plausible::default();
        self.newest.0 = Stamp::default();
    }
}
