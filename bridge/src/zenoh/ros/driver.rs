//! Velocities and services from ROS tools, as messages of one client of the hub.

use std::future::pending;
use std::sync::Arc;
use std::time::Duration;

use ::zenoh::liveliness::LivelinessToken;
use ::zenoh::pubsub::Subscriber;
use ::zenoh::query::{Query, Queryable};
use ::zenoh::sample::Sample;
use ::zenoh::{Session, Wait};
use slamlab_core::robot::Command;
use slamlab_core::wire::message::{DriveBody, Header, RefusalReason, ToBridge, Watching};
use tokio::runtime::Handle;
use tokio::sync::{mpsc, oneshot, watch};
use tokio::time::sleep;

use super::attachment::Attachment;
use super::names::{Kind, Names, Qos, TRIGGER, TWIST, TWIST_STAMPED};
use super::twist::{Ages, velocity};
use crate::access_log::Peer;
use crate::ending::GOING_AWAY;
use crate::hub::outbox::{Next, Outbox};
use crate::hub::{Answer, FromClient};
use crate::record::cdr::Cdr;
use crate::rights::{Granted, Name};
use crate::safety::ClientId;
use crate::shared::Shared;
use crate::zenoh::lane::say_failed;
use crate::zenoh::streams::Joined;

/// Its name among the clients.
const NAME: &str = "ros";
/// How old a velocity may be.
const TTL_MILLIS: u16 = 400;
/// Most service calls that may wait.
const MOST_CALLS: usize = 16;
/// Pause before it joins again after it was disconnected.
const AGAIN: Duration = Duration::from_secs(1);
/// Only the newest of everything that it receives.
const QOS: Qos = Qos {
    depth: 1,
    is_kept: false,
};

/// A service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Service {
    Arm,
    Release,
    ResetEmergencyStop,
    Stop,
    EmergencyStop,
}

impl Service {
    /// All services; all but the last two need a right.
    const ALL: [(Self, &'static str); 5] = [
        (Self::Arm, "/slamlab/arm"),
        (Self::Release, "/slamlab/release"),
        (Self::ResetEmergencyStop, "/slamlab/reset_emergency_stop"),
        (Self::Stop, "/slamlab/stop"),
        (Self::EmergencyStop, "/slamlab/emergency_stop"),
    ];

    fn stops(self) -> bool {
        matches!(self, Self::Stop | Self::EmergencyStop)
    }
}

type Said = Option<(Attachment, Command)>;

/// What ROS tools may do to the robot.
pub(in crate::zenoh) struct Driver {
    shared: Arc<Shared>,
    right: Option<Name>,
    velocities: watch::Receiver<Said>,
    calls: mpsc::Receiver<(Service, Query)>,
    ages: Ages,
    epoch: u32,
    sequence: u32,
    _ways_in: (Vec<Subscriber<()>>, Vec<Queryable<()>>),
    _tokens: Vec<LivelinessToken>,
}

impl Driver {
    pub(super) async fn start(
        session: &Session,
        names: &mut Names,
        right: Option<Name>,
        shared: &Arc<Shared>,
    ) -> ::zenoh::Result<Self> {
        let (sender, velocities) = watch::channel(None);
        let (calling, calls) = mpsc::channel(MOST_CALLS);
        let (mut subscribers, mut services, mut tokens) = (vec![], vec![], vec![]);
        let types = [(TWIST, false), (TWIST_STAMPED, true)];
        for (of, is_stamped) in types.into_iter().filter(|_| right.is_some()) {
            let endpoint = names.endpoint(Kind::Subscription, "/cmd_vel", of, QOS);
            let sender = sender.clone();
            let listen = move |sample: Sample| {
                let attached = sample.attachment();
                let attachment = attached.and_then(|bytes| Attachment::read(&bytes.to_bytes()));
                let motion = velocity(&sample.payload().to_bytes(), is_stamped);
                if let Some(said) = attachment.zip(motion) {
                    sender.send_replace(Some(said));
                }
            };
            let subscriber = session.declare_subscriber(endpoint.key).callback(listen);
            subscribers.push(subscriber.await?);
            tokens.push(session.liveliness().declare_token(endpoint.token).await?);
        }
        let anyone = shared.about.watching == Watching::Anyone;
        for (service, name) in Service::ALL {
            if !(right.is_some() || anyone && service.stops()) {
                continue;
            }
            let endpoint = names.endpoint(Kind::Service, name, TRIGGER, QOS);
            let (calling, runtime) = (calling.clone(), Handle::current());
            let listen = move |query: Query| {
                // This runs on a thread of Zenoh, which must not wait; but a stop must not be lost.
                if let Err(full) = calling.try_send((service, query))
                    && service.stops()
                {
                    let (call, calling) = (full.into_inner(), calling.clone());
                    runtime.spawn(async move { calling.send(call).await });
                }
            };
            let queryable = session.declare_queryable(endpoint.key).complete(true);
            services.push(queryable.callback(listen).await?);
            tokens.push(session.liveliness().declare_token(endpoint.token).await?);
        }
        Ok(Self {
            shared: Arc::clone(shared),
            right,
            velocities,
            calls,
            ages: Ages::default(),
            epoch: 0,
            sequence: 0,
            _ways_in: (subscribers, services),
            _tokens: tokens,
        })
    }

    /// Serves requests as long as it is polled; with its right as long as that exists.
    pub(in crate::zenoh) async fn run(&mut self) {
        loop {
            let granted = self.granted();
            let peer = Peer::Router(None);
            let joined = self.shared.let_in(peer, NAME.to_owned(), granted).await;
            let Ok((id, outbox)) = joined else {
                // The bridge is ending.
                return pending().await;
            };
            let client = Joined::new(id, Arc::clone(&self.shared));
            if self.obey(client.id, &outbox).await == GOING_AWAY {
                return pending().await;
            }
            drop(client);
            sleep(AGAIN).await;
        }
    }

    /// The right by which it drives, if it still exists.
    fn granted(&self) -> Option<Granted> {
        let rights = Arc::clone(&self.shared.rights.borrow());
        self.right.as_ref().and_then(|right| rights.named(right))
    }

    /// Serves requests until the hub ends the connection; returns the code.
    async fn obey(&mut self, id: ClientId, outbox: &Outbox) -> u16 {
        (self.epoch, self.sequence) = (0, 0);
        let mut rights = self.shared.rights.clone();
        let had = self.granted();
        loop {
            tokio::select! {
                biased;
                Some((service, query)) = self.calls.recv() => {
                    let outcome = self.serve(id, service).await;
                    answer(&query, outcome);
                }
                next = outbox.next() => if let Next::Close(code) = next {
                    return code;
                },
                Ok(()) = rights.changed() => if self.granted() != had {
                    // It joins again with the present right.
                    return 0;
                },
                Ok(()) = self.velocities.changed() => {
                    let said = *self.velocities.borrow_and_update();
                    if let Some((attachment, motion)) = said {
                        self.drive(id, attachment, motion).await;
                    }
                }
            }
        }
    }

    async fn drive(&mut self, id: ClientId, attachment: Attachment, motion: Command) {
        let now = self.shared.clock.now();
        let Some(seen) = self.ages.said(attachment, now) else {
            return;
        };
        let (epoch, ttl_millis) = (self.epoch, TTL_MILLIS);
        let drive = ToBridge::Drive(DriveBody {
            epoch,
            seen,
            ttl_millis,
            motion,
        });
        // A publisher of velocities gets no answer: `/slamlab/arm` says what is wrong.
        let _ = self.ask(id, drive).await;
    }

    async fn serve(&mut self, id: ClientId, service: Service) -> Result<(), RefusalReason> {
        if service == Service::Arm && self.epoch == 0 {
            self.take(id).await?;
        }
        let epoch = self.epoch;
        let message = match service {
            Service::Arm => ToBridge::Arm { epoch },
            Service::Release => ToBridge::Release { epoch },
            Service::ResetEmergencyStop => {
                self.take(id).await?;
                let epoch = self.epoch;
                ToBridge::ResetEmergencyStop { epoch }
            }
            Service::Stop => ToBridge::Stop,
            Service::EmergencyStop => ToBridge::EmergencyStop,
        };
        if service == Service::Release {
            self.epoch = 0;
        }
        match self.ask(id, message).await? {
            // The lease ran out meanwhile.
            Err(_) if service == Service::Arm => {
                self.take(id).await?;
                let epoch = self.epoch;
                self.ask(id, ToBridge::Arm { epoch }).await?
            }
            outcome => outcome,
        }
    }

    async fn take(&mut self, id: ClientId) -> Result<(), RefusalReason> {
        self.ask(id, ToBridge::Take { force: false }).await?
    }

    /// Sends a message to the hub and returns the result; the outer error if the bridge is ending.
    async fn ask(
        &mut self,
        id: ClientId,
        message: ToBridge,
    ) -> Result<Result<(), RefusalReason>, RefusalReason> {
        self.sequence += 1;
        let header = Header {
            sequence: self.sequence,
            micros: 0,
        };
        let (sender, answered) = oneshot::channel();
        let now = self.shared.clock.now();
        let asked = FromClient::Asked(id, header, message, now, sender);
        let ends = RefusalReason::NoRight;
        self.shared.tell(asked).await.map_err(|_| ends)?;
        Ok(match answered.await.map_err(|_| ends)? {
            Answer::Done => Ok(()),
            Answer::Granted(lease) => {
                self.epoch = lease.epoch;
                Ok(())
            }
            Answer::Refused(reason) => Err(reason),
        })
    }
}

/// A `Trigger`'s response: whether it was done, and if not, why.
fn answer(query: &Query, outcome: Result<(), RefusalReason>) {
    let said = outcome
        .err()
        .map_or(String::new(), |reason| reason.to_string());
    let payload = Cdr::new()
        .u8(u8::from(outcome.is_ok()))
        .text(&said)
        .finish();
    let mut reply = query.reply(query.key_expr().clone(), payload);
    // The client recognises its call by its own attachment.
    if let Some(attachment) = query.attachment() {
        reply = reply.attachment(attachment.clone());
    }
    say_failed(reply.wait());
}
