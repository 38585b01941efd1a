//! A client behind the router.

use std::time::Duration;

use serde_json::{Value, json};
use slamlab_core::robot::Command;
use slamlab_core::wire::message::{
    ClientHello, DriveBody, Format, FromBridge, Header, MessageKey, SCHEMA, SafetyBody, ToBridge,
    decode, encode, proof,
};
use tokio::sync::mpsc;
use tokio::time::{Instant, timeout};
use zenoh::Session;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Subscriber;

use crate::process::config;
use crate::started::NEVER;

/// A session at a router, as any program may open it.
pub(crate) async fn session(endpoint: &str, more: &Value) -> Session {
    let mut values = json!({
        "mode": "client",
        "connect/endpoints": [endpoint],
        "scouting/multicast/enabled": false,
    });
    for (key, value) in more.as_object().unwrap() {
        values[key] = value.clone();
    }
    timeout(NEVER, async { zenoh::open(config(&values)).await })
        .await
        .unwrap()
        .unwrap()
}

/// Sessions of the robots of this name (or `*`) that are at the router.
pub(crate) async fn robots(session: &Session, name: &str) -> Vec<String> {
    let alive = format!("slamlab/{name}/alive/*");
    let replies = session.liveliness().get(alive).await.unwrap();
    let mut all = vec![];
    while let Ok(reply) = replies.recv_async().await {
        all.extend(reply.result().map(|sample| sample.key_expr().to_string()));
    }
    all
}

/// Waits until `count` robots are there.
pub(crate) async fn wait_for(session: &Session, name: &str, count: usize) -> Option<Duration> {
    let begun = Instant::now();
    while begun.elapsed() < NEVER {
        if robots(session, name).await.len() == count {
            return Some(begun.elapsed());
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    None
}

/// Every safety state that arrives at the router's key, in order.
pub(crate) async fn safety(
    session: &Session,
    name: &str,
) -> (Subscriber<()>, mpsc::UnboundedReceiver<SafetyBody>) {
    let (sender, states) = mpsc::unbounded_channel();
    let listening = session
        .declare_subscriber(format!("slamlab/{name}/safety"))
        .callback(move |sample| {
            let read = decode(&sample.payload().to_bytes(), Format::Json);
            if let Ok((_, FromBridge::Safety(state))) = read {
                let _ = sender.send(state);
            }
        })
        .await
        .unwrap();
    (listening, states)
}

/// What arrived.
#[derive(Debug)]
pub(crate) enum Came {
    Message(Box<FromBridge>),
    Closed(u64),
}

/// A conversation with one robot.
pub(crate) struct Remote {
    session: Session,
    pub(crate) key: String,
    came: mpsc::UnboundedReceiver<(u64, Came)>,
    signs: Option<MessageKey>,
    challenge: [u8; 16],
    sequence: u32,
    pub(crate) seen: u64,
    pub(crate) epoch: u32,
    /// The last state that it was told.
    pub(crate) safety: SafetyBody,
    _token: LivelinessToken,
    _listening: Subscriber<()>,
}

impl Remote {
    /// Enters as the `number`-th client.
    pub(crate) async fn enter(
        session: &Session,
        robot: &str,
        number: u64,
        token: Option<&str>,
    ) -> Self {
        let mut remote = Self::connect(session, robot, number).await;
        remote.hello(token).await;
        remote
            .wait(|message| matches!(message, FromBridge::Welcome(_)).then_some(()))
            .await;
        remote
    }

    pub(crate) async fn connect(session: &Session, robot: &str, number: u64) -> Self {
        let (sender, came) = mpsc::unbounded_channel();
        let listening = session
            .declare_subscriber(format!("slamlab/{robot}/from/{number:016x}"))
            .callback(move |sample| {
                let bytes = sample.payload().to_bytes();
                let came = match decode(&bytes, Format::Json) {
                    Ok((header, message)) => (header.micros, Came::Message(Box::new(message))),
                    Err(_) => {
                        let last: Value = serde_json::from_slice(&bytes).unwrap_or_default();
                        (0, Came::Closed(last["close"].as_u64().unwrap_or_default()))
                    }
                };
                let _ = sender.send(came);
            })
            .await
            .unwrap();
        let key = format!("slamlab/{robot}/to/{number:016x}");
        let token = session.liveliness().declare_token(key.clone()).await;
        let mut remote = Self {
            session: session.clone(),
            key,
            came,
            signs: None,
            challenge: [0; 16],
            sequence: 0,
            seen: 0,
            epoch: 0,
            safety: SafetyBody::default(),
            _token: token.unwrap(),
            _listening: listening,
        };
        remote.challenge = remote
            .wait(|message| match message {
                FromBridge::Hello(hello) => Some(hello.challenge),
                _ => None,
            })
            .await;
        remote
    }

    pub(crate) async fn hello(&mut self, token: Option<&str>) {
        let hello = ToBridge::Hello(ClientHello {
            schema: SCHEMA,
            name: "remote".into(),
            proof: token.map(|token| proof(token, &self.challenge)),
        });
        self.signs = token.map(|token| MessageKey::of_token(token, &self.challenge));
        self.say(&hello).await;
    }

    pub(crate) async fn say(&mut self, message: &ToBridge) {
        self.sequence += 1;
        let payload = written(self.sequence, message);
        let put = self.session.put(&self.key, &payload);
        match &self.signs {
            Some(key) => put.attachment(key.sign(&payload).to_vec()).await.unwrap(),
            None => put.await.unwrap(),
        }
    }

    /// Takes the lease and arms, once the robot is there.
    pub(crate) async fn take_and_arm(&mut self) {
        loop {
            self.say(&ToBridge::Take { force: false }).await;
            self.epoch = self
                .wait(|message| match message {
                    FromBridge::Granted(lease) => Some(lease.epoch),
                    _ => None,
                })
                .await;
            self.say(&ToBridge::Arm { epoch: self.epoch }).await;
            let armed = self
                .wait(|message| match message {
                    FromBridge::Safety(state) if state.armed => Some(true),
                    FromBridge::Refused(_) => Some(false),
                    _ => None,
                })
                .await;
            if armed {
                return;
            }
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
    }

    pub(crate) async fn drive(&mut self, forward: f64) {
        let drive = ToBridge::Drive(DriveBody {
            epoch: self.epoch,
            seen: self.seen,
            ttl_millis: 400,
            motion: Command::Velocity { forward, turn: 0.0 },
        });
        self.say(&drive).await;
    }

    /// What has arrived, without waiting.
    pub(crate) fn try_next(&mut self) -> Option<Came> {
        let came = self.came.try_recv().ok()?;
        Some(self.note(came))
    }

    pub(crate) async fn next(&mut self) -> Option<Came> {
        let came = timeout(NEVER, self.came.recv()).await.ok()??;
        Some(self.note(came))
    }

    fn note(&mut self, (micros, came): (u64, Came)) -> Came {
        self.seen = self.seen.max(micros);
        if let Came::Message(message) = &came
            && let FromBridge::Safety(state) = &**message
        {
            self.safety = state.clone();
        }
        came
    }

    pub(crate) async fn wait<T>(&mut self, mut find: impl FnMut(&FromBridge) -> Option<T>) -> T {
        loop {
            match self.next().await {
                Some(Came::Message(message)) => {
                    if let Some(found) = find(&message) {
                        return found;
                    }
                }
                other => panic!("the conversation ended: {other:?}"),
            }
        }
    }

    /// The code with which the conversation is ended.
    pub(crate) async fn end(&mut self) -> Option<u64> {
        loop {
            match self.next().await? {
                Came::Message(_) => (),
                Came::Closed(code) => return Some(code),
            }
        }
    }
}

/// The text of a message.
pub(crate) fn written(sequence: u32, message: &ToBridge) -> Vec<u8> {
    let header = Header {
        sequence,
        micros: 0,
    };
    encode(header, message, Format::Json).unwrap()
}
