//! The rules themselves: each takes a request or event, changes the state, and adds what follows to
//! the outputs.

use std::time::Duration;

use crate::robot::Command;
use crate::wire::message::{DisarmReason, DriveBody, Lease, RefusalReason, ToBridge, close};

use super::{Client, ClientId, Holder, LEASE, LONGEST_TTL, Output, STOP_AGAIN, Safety, WATCHDOG};
use crate::device::source::Order;

const STOP: Output = Output::Order(Order::Command(Command::Stop));

/// Whether a request was carried out, or why not.
type Done = Result<(), RefusalReason>;

impl Safety {
    pub(super) fn asked(
        &mut self,
        now: Duration,
        client: Client,
        sequence: u32,
        message: &ToBridge,
    ) {
        let id = client.id;
        let done = match client.role {
            role if role.may(message) => self.obey(now, client, sequence, message),
            // A driver is not disconnected for that.
            role if role.may_drive() => Err(RefusalReason::NoRight),
            _ => return self.out.push(Output::Close(id, close::NO_RIGHT)),
        };
        if let Err(reason) = done {
            self.out.push(Output::Refused(id, reason));
        }
    }

    /// Carries out what the client has the right to ask for.
    fn obey(&mut self, now: Duration, client: Client, sequence: u32, message: &ToBridge) -> Done {
        let id = client.id;
        match *message {
            // They keep the connection alive, and ask for nothing that could be refused.
            ToBridge::Hello(_) | ToBridge::Heartbeat | ToBridge::Probe { .. } => Ok(()),
            ToBridge::Stop | ToBridge::EmergencyStop => {
                self.stop(now, message);
                Ok(())
            }
            ToBridge::Take { force } => self.take(now, client, force),
            ToBridge::Renew { epoch } => self.holder(id, epoch).map(|holder| holder.used = now),
            ToBridge::Release { epoch } => self.release(id, epoch),
            ToBridge::Arm { epoch } => self.arm(now, id, epoch),
            ToBridge::Drive(body) => self.drive(now, id, sequence, &body),
            ToBridge::Hold {
                epoch,
                seen,
                ttl_millis,
            } => self
                .counts(now, id, sequence, epoch, seen, ttl_millis)
                // A robot that was stopped meanwhile stays stopped.
                .map(|()| self.driven = self.driven.map(|_| now)),
            ToBridge::ResetEmergencyStop { epoch } => self.reset(now, id, epoch),
            ToBridge::ResetMap => {
                self.out.push(Output::ResetMap(id));
                Ok(())
            }
            ToBridge::SetGeofence { .. } => {
                self.out.push(Output::SetGeofence(id));
                Ok(())
            }
        }
    }

    /// What the passing of time causes.
    pub(super) fn run_out(&mut self, now: Duration) {
        if self.holder.is_some_and(|holder| now >= holder.used + LEASE) {
            self.end_lease(DisarmReason::LeaseExpired);
        }
        if self.driven.is_some_and(|at| now >= at + WATCHDOG) {
            self.driven = None;
            self.out.push(STOP);
        }
    }

    fn take(&mut self, now: Duration, asker: Client, force: bool) -> Done {
        let Client { id: client, role } = asker;
        match self.holder {
            Some(holder) if holder.client != client => {
                if !force || !role.may_take_from(holder.role) {
                    return Err(RefusalReason::Held);
                }
                self.end_lease(DisarmReason::TakenOver);
                self.out
                    .push(Output::Close(holder.client, close::TAKEN_OVER));
            }
            // A client that asks again starts anew, as if it had come back.
            Some(_) => self.end_lease(DisarmReason::Released),
            None => (),
        }
        self.last_epoch += 1;
        self.holder = Some(Holder {
            client,
            role,
            epoch: self.last_epoch,
            sequence: 0,
            used: now,
        });
        let lease = Lease {
            epoch: self.last_epoch,
            millis: LEASE.as_millis() as u16,
        };
        self.out
            .extend([Output::Granted(client, lease), Output::Changed]);
        Ok(())
    }

    fn release(&mut self, client: ClientId, epoch: u32) -> Done {
        self.holder(client, epoch)?;
        // If the robot was already disarmed, the reason for that stays.
        self.end_lease(match self.is_armed {
            true => DisarmReason::Released,
            false => self.reason,
        });
        Ok(())
    }

    fn arm(&mut self, now: Duration, client: ClientId, epoch: u32) -> Done {
        self.holder(client, epoch)?.used = now;
        if self.is_emergency {
            return Err(RefusalReason::Emergency);
        }
        if !self.is_robot_up {
            return Err(RefusalReason::NoRobot);
        }
        (self.is_armed, self.stopped) = (true, None);
        self.out.push(Output::Changed);
        Ok(())
    }

    fn drive(&mut self, now: Duration, client: ClientId, sequence: u32, body: &DriveBody) -> Done {
        let &DriveBody {
            epoch,
            seen,
            ttl_millis,
            motion,
        } = body;
        if !motion.is_finite() {
            return Err(RefusalReason::NotFinite);
        }
        self.counts(now, client, sequence, epoch, seen, ttl_millis)?;
        self.driven = (motion != Command::Stop).then_some(now);
        self.out.push(Output::Order(Order::Command(motion)));
        Ok(())
    }

    /// Whether a driving message counts; if so, the lease is renewed.
    fn counts(
        &mut self,
        now: Duration,
        client: ClientId,
        sequence: u32,
        epoch: u32,
        seen: u64,
        ttl_millis: u16,
    ) -> Done {
        let (is_armed, is_emergency) = (self.is_armed, self.is_emergency);
        let holder = self.holder(client, epoch)?;
        if sequence <= holder.sequence {
            return Err(RefusalReason::StaleSequence);
        }
        let Some(age) = now.checked_sub(Duration::from_micros(seen)) else {
            return Err(RefusalReason::FromTheFuture);
        };
        if age > Duration::from_millis(ttl_millis.into()).min(LONGEST_TTL) {
            return Err(RefusalReason::TooOld);
        }
        if is_emergency {
            return Err(RefusalReason::Emergency);
        }
        if !is_armed {
            return Err(RefusalReason::Disarmed);
        }
        (holder.sequence, holder.used) = (sequence, now);
        Ok(())
    }

    fn reset(&mut self, now: Duration, client: ClientId, epoch: u32) -> Done {
        self.holder(client, epoch)?.used = now;
        // An order to a robot that is away would be lost: the robot would stay latched while the
        // bridge reports it as free.
        if !self.is_robot_up {
            return Err(RefusalReason::NoRobot);
        }
        if std::mem::take(&mut self.is_emergency) {
            self.out
                .extend([Output::Order(Order::ResetEmergencyStop), Output::Changed]);
        }
        Ok(())
    }

    pub(super) fn robot(&mut self, is_up: bool) {
        let was_up = std::mem::replace(&mut self.is_robot_up, is_up);
        if was_up != is_up {
            // A robot that appears for the first time was never lost.
            let reason = match self.reason {
                DisarmReason::Start if is_up => DisarmReason::Start,
                _ => DisarmReason::Link,
            };
            self.disarm(reason);
        }
        // A robot that was reset has lost its latch; the bridge has not.
        if is_up && !was_up && self.is_emergency {
            self.out.push(Output::Order(Order::EmergencyStop));
        }
    }

    pub(super) fn end_lease(&mut self, reason: DisarmReason) {
        self.holder = None;
        self.disarm(reason);
    }

    /// The first stop goes out at once, whatever the bridge believes of the robot, because its
    /// sender may know more. So does one that changes something; any other is ignored for a while.
    fn stop(&mut self, now: Duration, message: &ToBridge) {
        let cuts_off = matches!(message, ToBridge::EmergencyStop);
        let changes = self.is_armed || cuts_off && !self.is_emergency;
        let is_soon = self.stopped.is_some_and(|at| now < at + STOP_AGAIN);
        if is_soon && !changes {
            return;
        }
        self.stopped = Some(now);
        match cuts_off {
            true => self.emergency_stop(DisarmReason::EmergencyStop),
            false => self.disarm(DisarmReason::Stop),
        }
    }

    pub(super) fn disarm(&mut self, reason: DisarmReason) {
        (self.is_armed, self.driven, self.reason) = (false, None, reason);
        self.out.extend([STOP, Output::Changed]);
    }

    pub(super) fn emergency_stop(&mut self, reason: DisarmReason) {
        self.is_emergency = true;
        (self.is_armed, self.driven, self.reason) = (false, None, reason);
        self.out
            .extend([Output::Order(Order::EmergencyStop), Output::Changed]);
    }

    fn holder(&mut self, client: ClientId, epoch: u32) -> Result<&mut Holder, RefusalReason> {
        let holder = self.holder.as_mut();
        holder
            .filter(|holder| holder.client == client && holder.epoch == epoch)
            .ok_or(RefusalReason::StaleEpoch)
    }
}
