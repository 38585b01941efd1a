//! The hub's side of the clients: who came, what they ask for, who went.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use slamlab_core::wire::message::{FromBridge, Header, ProbeAnswer, ToBridge, Welcome};

use super::outbox::Outbox;
use super::{FromClient, Hub};
use crate::safety::{Asked, Client, ClientId, Input};

/// A client that has shown who it is.
#[derive(Debug)]
pub(crate) struct NewClient {
    pub(crate) name: String,
    pub(crate) may_drive: bool,
    pub(crate) outbox: Arc<Outbox>,
}

/// A client, as the hub knows it.
#[derive(Debug)]
pub(super) struct Connected {
    pub(super) name: String,
    pub(super) outbox: Arc<Outbox>,
    may_drive: bool,
}

impl Connected {
    pub(super) fn tell(&self, message: FromBridge) {
        self.outbox.put(&Arc::new(message));
    }
}

impl Hub {
    pub(super) fn client(&mut self, said: FromClient) {
        match said {
            FromClient::Came(client, answer) => {
                let id = self.came(client);
                // A connection that ended meanwhile leaves no one to tell that it did.
                if answer.send(id).is_err() {
                    self.gone(id);
                }
            }
            FromClient::Says(id, header, message, came) => self.says(id, header, &message, came),
            FromClient::Gone(id) => self.gone(id),
        }
        let clients = self.clients.len() as u64;
        self.metrics.clients.store(clients, Ordering::Relaxed);
    }

    fn came(&mut self, client: NewClient) -> ClientId {
        self.last_client += 1;
        let id = self.last_client;
        let connected = Connected {
            name: client.name,
            outbox: client.outbox,
            may_drive: client.may_drive,
        };
        connected.tell(FromBridge::Welcome(Welcome {
            client: id,
            may_drive: client.may_drive,
        }));
        connected.tell(FromBridge::Devices(self.devices.all().to_vec()));
        connected.tell(FromBridge::Safety(self.state()));
        if let Some(errand) = self.errand_now() {
            connected.tell(errand);
        }
        self.clients.insert(id, connected);
        id
    }

    fn gone(&mut self, id: ClientId) {
        self.clients.remove(&id);
        self.rule(self.clock.now(), Input::Gone(id));
    }

    fn says(&mut self, id: ClientId, header: Header, message: &ToBridge, came: Duration) {
        let Some(may_drive) = self.clients.get(&id).map(|client| client.may_drive) else {
            return;
        };
        if let &ToBridge::Probe { token } = message {
            let (stamp, robot_came) = self.robot.newest();
            let answer = ProbeAnswer {
                token,
                came_micros: came.as_micros() as u64,
                robot_micros: stamp.0,
                robot_came_micros: robot_came.as_micros() as u64,
            };
            return self.tell(id, FromBridge::Probe(answer));
        }
        if let Some(asked) = Asked::of(header, message) {
            let now = self.clock.now();
            self.given = None;
            self.rule(now, Input::Asks(Client { id, may_drive }, asked));
            if matches!(message, ToBridge::Drive(body) if body.motion.is_manoeuvre()) {
                let order = self.given.take();
                self.errand_given(id, header.sequence, order);
            }
        }
    }
}
