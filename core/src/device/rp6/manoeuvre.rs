//! The motion under way: kept alive, acknowledged, and reported when it is over.

use crate::robot::Stamp;
use crate::wire::rp6;

use super::robot::Motion;
use super::{ALIVE, FORGOTTEN, Rp6};
use crate::device::source::SourceEvent;

impl Rp6 {
    pub(super) fn acknowledged(&mut self, command: rp6::Command, now: Stamp) {
        self.sweep_acknowledged(&command);
        let asked = self.robot.as_mut().map(|robot| &mut robot.asked);
        let asked = asked.and_then(|asked| asked.take_if(|(asked, _)| *asked == command));
        if let Some((_, given)) = asked {
            if let Some(robot) = &mut self.robot
                && matches!(robot.motion, Motion::Manoeuvre(_))
            {
                robot.manoeuvre_acknowledged = Some(now);
            }
            self.report.set_round_trip(now.since(given).max(0.0));
        }
    }

    fn sweep_acknowledged(&mut self, command: &rp6::Command) {
        let is_round = matches!(command, rp6::Command::Sweep { .. }) && !command.looks_aside();
        let sweeps = self.robot.as_mut().and_then(|robot| robot.sweeps.as_mut());
        if let Some(sweeps) = sweeps.filter(|_| is_round) {
            sweeps.begin_sweep();
        }
    }

    /// Reports whether a manoeuvre is under way, if that was not yet reported.
    pub(super) fn report_busy(&mut self) {
        let motion = self.robot.as_ref().map(|robot| robot.motion);
        let busy = matches!(motion, Some(Motion::Manoeuvre(_)));
        if self.busy.replace(busy) != Some(busy) {
            self.report.emit(SourceEvent::Busy { busy, after: 0 });
        }
    }

    /// Keep-alives while under way, and a stop if the driver is gone.
    pub(super) fn keep_alive(&mut self, now: Stamp) {
        let Some(robot) = &mut self.robot else {
            return;
        };
        match robot.motion {
            Motion::None => return,
            Motion::Speed(given) if now.since(given) > FORGOTTEN => {
                robot.motion = Motion::None;
                self.give(rp6::Command::Stop, now);
                return;
            }
            _ => (),
        }
        if now.since(robot.last_alive) >= ALIVE {
            robot.last_alive = now;
            self.give(rp6::Command::Alive, now);
        }
    }
}
