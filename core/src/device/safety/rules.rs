//! The rules themselves: each takes what was asked for, changes the state, and adds what follows to
//! the outputs.

use std::time::Duration;

use crate::robot::Command;
use crate::wire::message::{DisarmReason, DriveBody, Lease, Motion, RefusalReason, close};

use super::{Asked, Client, ClientId, Holder, Output, Safety};
use crate::device::source::Order;

const STOP: Output = Output::Order(Order::Command(Command::Stop));

/// What makes a driving message count.
struct Proof {
    sequence: u32,
    epoch: u32,
    seen: Duration,
    ttl: Duration,
}

impl Safety {
    pub(super) fn asked(
        &mut self,
        now: Duration,
        client: Client,
        asked: Asked,
        out: &mut Vec<Output>,
    ) {
        match asked {
            Asked::Stop => return self.disarm(DisarmReason::Stop, out),
            Asked::EmergencyStop => return self.emergency_stop(DisarmReason::EmergencyStop, out),
            _ if !client.may_drive => return out.push(Output::Close(client.id, close::NO_RIGHT)),
            _ => (),
        }
        let done = match asked {
            Asked::Stop | Asked::EmergencyStop => Ok(()),
            Asked::Take { force } => self.take(now, client.id, force, out),
            Asked::Renew { epoch } => self.renew(now, client.id, epoch),
            Asked::Release { epoch } => self.release(client.id, epoch, out),
            Asked::Arm { epoch } => self.arm(now, client.id, epoch, out),
            Asked::Drive { sequence, body } => self.drive(now, client.id, sequence, &body, out),
            Asked::Hold {
                sequence,
                epoch,
                seen,
                ttl,
            } => {
                let proof = Proof {
                    sequence,
                    epoch,
                    seen,
                    ttl,
                };
                self.hold(now, client.id, &proof)
            }
            Asked::ResetEmergencyStop { epoch } => self.reset(now, client.id, epoch, out),
        };
        if let Err(reason) = done {
            out.push(Output::Refused(client.id, reason));
        }
    }

    /// What time alone brings about.
    pub(super) fn run_out(&mut self, now: Duration, out: &mut Vec<Output>) {
        let lease_ends = self.holder.map(|holder| holder.used + self.config.lease);
        if lease_ends.is_some_and(|end| now >= end) {
            self.end_lease(DisarmReason::LeaseExpired, out);
        }
        if self
            .driven
            .is_some_and(|at| now >= at + self.config.watchdog)
        {
            self.driven = None;
            out.push(STOP);
        }
    }

    fn take(
        &mut self,
        now: Duration,
        client: ClientId,
        force: bool,
        out: &mut Vec<Output>,
    ) -> Result<(), RefusalReason> {
        match self.driver() {
            Some(holder) if holder != client && !force => return Err(RefusalReason::Held),
            Some(holder) if holder != client => {
                self.end_lease(DisarmReason::TakenOver, out);
                out.push(Output::Close(holder, close::TAKEN_OVER));
            }
            // Whoever asks twice starts again, as if it had come back.
            Some(_) => self.end_lease(DisarmReason::Released, out),
            None => (),
        }
        self.last_epoch += 1;
        self.holder = Some(Holder {
            client,
            epoch: self.last_epoch,
            sequence: 0,
            used: now,
        });
        let lease = Lease {
            epoch: self.last_epoch,
            millis: self.config.lease.as_millis() as u16,
        };
        out.extend([Output::Granted(client, lease), Output::Changed]);
        Ok(())
    }

    fn renew(&mut self, now: Duration, client: ClientId, epoch: u32) -> Result<(), RefusalReason> {
        self.holder(client, epoch)?.used = now;
        Ok(())
    }

    fn release(
        &mut self,
        client: ClientId,
        epoch: u32,
        out: &mut Vec<Output>,
    ) -> Result<(), RefusalReason> {
        self.holder(client, epoch)?;
        self.end_lease(DisarmReason::Released, out);
        Ok(())
    }

    fn arm(
        &mut self,
        now: Duration,
        client: ClientId,
        epoch: u32,
        out: &mut Vec<Output>,
    ) -> Result<(), RefusalReason> {
        self.holder(client, epoch)?.used = now;
        if self.is_emergency {
            return Err(RefusalReason::Emergency);
        }
        if !self.is_robot_up {
            return Err(RefusalReason::NoRobot);
        }
        self.is_armed = true;
        out.push(Output::Changed);
        Ok(())
    }

    fn drive(
        &mut self,
        now: Duration,
        client: ClientId,
        sequence: u32,
        body: &DriveBody,
        out: &mut Vec<Output>,
    ) -> Result<(), RefusalReason> {
        let proof = Proof {
            sequence,
            epoch: body.epoch,
            seen: Duration::from_micros(body.seen),
            ttl: Duration::from_millis(body.ttl_millis.into()),
        };
        if !body.motion.is_finite() {
            return Err(RefusalReason::NotFinite);
        }
        self.counts(now, client, &proof)?;
        self.driven = (body.motion != Motion::Halt).then_some(now);
        out.push(Output::Order(Order::Command(body.motion.into())));
        Ok(())
    }

    fn hold(
        &mut self,
        now: Duration,
        client: ClientId,
        proof: &Proof,
    ) -> Result<(), RefusalReason> {
        self.counts(now, client, proof)?;
        // What was stopped meanwhile does not go on.
        self.driven = self.driven.map(|_| now);
        Ok(())
    }

    /// Whether a driving message counts; if so, the lease is renewed.
    fn counts(
        &mut self,
        now: Duration,
        client: ClientId,
        proof: &Proof,
    ) -> Result<(), RefusalReason> {
        let longest = self.config.longest_ttl;
        let (is_armed, is_emergency) = (self.is_armed, self.is_emergency);
        let holder = self.holder(client, proof.epoch)?;
        if proof.sequence <= holder.sequence {
            return Err(RefusalReason::StaleSequence);
        }
        let Some(age) = now.checked_sub(proof.seen) else {
            return Err(RefusalReason::FromTheFuture);
        };
        if age > proof.ttl.min(longest) {
            return Err(RefusalReason::TooOld);
        }
        if is_emergency {
            return Err(RefusalReason::Emergency);
        }
        if !is_armed {
            return Err(RefusalReason::Disarmed);
        }
        (holder.sequence, holder.used) = (proof.sequence, now);
        Ok(())
    }

    fn reset(
        &mut self,
        now: Duration,
        client: ClientId,
        epoch: u32,
        out: &mut Vec<Output>,
    ) -> Result<(), RefusalReason> {
        self.holder(client, epoch)?.used = now;
        // An order to a robot that is away would be lost, and it would stay latched while the
        // bridge says that it is free.
        if !self.is_robot_up {
            return Err(RefusalReason::NoRobot);
        }
        if std::mem::take(&mut self.is_emergency) {
            out.extend([Output::Order(Order::ResetEmergencyStop), Output::Changed]);
        }
        Ok(())
    }

    pub(super) fn robot(&mut self, is_up: bool, out: &mut Vec<Output>) {
        let was_up = std::mem::replace(&mut self.is_robot_up, is_up);
        if was_up != is_up {
            self.disarm(DisarmReason::Link, out);
        }
        // A robot that was reset has forgotten its latch; the bridge has not.
        if is_up && !was_up && self.is_emergency {
            out.push(Output::Order(Order::EmergencyStop));
        }
    }

    pub(super) fn end_lease(&mut self, reason: DisarmReason, out: &mut Vec<Output>) {
        self.holder = None;
        self.disarm(reason, out);
    }

    /// The stop goes out in any case: it costs nothing, and whoever asks for it may know more than
    /// the bridge.
    pub(super) fn disarm(&mut self, reason: DisarmReason, out: &mut Vec<Output>) {
        (self.is_armed, self.driven, self.reason) = (false, None, reason);
        out.extend([STOP, Output::Changed]);
    }

    pub(super) fn emergency_stop(&mut self, reason: DisarmReason, out: &mut Vec<Output>) {
        out.push(Output::Order(Order::EmergencyStop));
        self.is_emergency = true;
        (self.is_armed, self.driven, self.reason) = (false, None, reason);
        out.push(Output::Changed);
    }

    fn holder(&mut self, client: ClientId, epoch: u32) -> Result<&mut Holder, RefusalReason> {
        let holder = self.holder.as_mut();
        holder
            .filter(|holder| holder.client == client && holder.epoch == epoch)
            .ok_or(RefusalReason::StaleEpoch)
    }
}
