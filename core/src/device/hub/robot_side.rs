//! What the robot's readings mean for driving.

use std::time::Duration;

use crate::control::SafeMode;
use crate::robot::{Command, RobotModel, Stamp};
use crate::wire::message::{DisarmReason, LinkState, PoseBody};

use super::fence::Fence;

use crate::device::safety::plausible::Plausible;
use crate::device::source::{self, Order, Profile, SourceEvent};

/// What is known of the robot that takes commands: the first source that has one.
#[derive(Clone, Debug)]
pub(super) struct RobotSide {
    /// Which source takes the orders.
    pub(super) source: Option<usize>,
    model: Option<RobotModel>,
    safe_mode: Option<SafeMode>,
    /// As it was before the first reading; a link that comes back begins with it.
    fresh: Option<SafeMode>,
    /// Of a bridge that maps.
    pub(super) fence: Option<Fence>,
    pub(super) plausible: Plausible,
    /// Newest stamp, and when it came.
    pub(super) newest: (Stamp, Duration),
    is_up: bool,
    /// When a sensor that scans all the time was heard last; none before it was heard at all.
    scanned: Option<Duration>,
    scans_on_command: bool,
}

/// Without a scan for so long a sensor is silent: a few revolutions of the slowest lidar.
const SILENT: Duration = Duration::from_secs(2);

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

    /// Whether a sensor that was heard, and scans all the time, has fallen silent. One that was
    /// never heard may be none.
    pub(super) fn is_blind(&self, now: Duration) -> bool {
        let is_late = |at: Duration| now.saturating_sub(at) > SILENT;
        !self.scans_on_command && self.scanned.is_some_and(is_late)
    }

    /// The order as far as it is safe.
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

    /// What stays within the fence, as far as nothing stands in the way; easing off something does
    /// not lead out either.
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

    /// Takes where the robot is in the bridge's map; says what is safe now, where what is under way
    /// no longer is.
    pub(super) fn pose(&mut self, body: &PoseBody) -> Option<Command> {
        let now = self.fence.as_mut()?.pose(body)?;
        Some(self.safe(now))
    }

    /// Takes an event. Scans count from whatever source: the lidar may be another than the robot.
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

    /// A robot that came back may have been carried away, and its clock begins at 0.
    fn begin_anew(&mut self) {
        self.safe_mode = self.fresh.clone();
        self.plausible = Plausible::default();
        self.newest.0 = Stamp::default();
    }
}
