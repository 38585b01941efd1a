//! Listens to all robots at the router while there is one.

use std::sync::Arc;
use std::time::Duration;

use ::zenoh::Session;
use ::zenoh::pubsub::Subscriber;
use ::zenoh::sample::{Sample, SampleKind};
use slamlab_core::wire::message::{Format, FromBridge, decode};
use tokio::runtime::Handle;

use super::Fleet;
use crate::clock::Clock;
use crate::rights::Name;

/// The streams of each robot that are listened to: few, but all that the page shows.
const STREAMS: [&str; 6] = [
    "safety",
    "alerts",
    "heartbeat",
    "battery",
    "pose",
    "mapping",
];
/// States, which a robot sends only on change, and which are queried when it appears.
const STATES: [&str; 5] = [
    "safety",
    "battery",
    "pose",
    "mapping",
    super::super::streams::PAGE,
];
/// How long a robot may take to answer.
const ANSWER: Duration = Duration::from_secs(2);

/// The fleet's messages are gathered until this is dropped.
pub(in super::super) struct Gathering {
    fleet: Arc<Fleet>,
    _listening: Vec<Subscriber<()>>,
}

impl Gathering {
    pub(in super::super) async fn start(
        session: &Session,
        fleet: &Arc<Fleet>,
        clock: Clock,
    ) -> ::zenoh::Result<Self> {
        let mut listening = vec![];
        for stream in STREAMS {
            let fleet = Arc::clone(fleet);
            let subscriber = session
                .declare_subscriber(format!("slamlab/*/{stream}"))
                .callback(move |sample| hear(&fleet, &sample, clock));
            listening.push(subscriber.await?);
        }
        listening.push(watch_tokens(session, fleet, clock).await?);
        fleet.set_router(Some(session.clone()));
        Ok(Self {
            fleet: Arc::clone(fleet),
            _listening: listening,
        })
    }
}

impl Drop for Gathering {
    fn drop(&mut self) {
        self.fleet.set_router(None);
        self.fleet.with_table(super::Table::all_went);
    }
}

async fn watch_tokens(
    session: &Session,
    fleet: &Arc<Fleet>,
    clock: Clock,
) -> ::zenoh::Result<Subscriber<()>> {
    let (fleet, runtime) = (Arc::clone(fleet), Handle::current());
    let asking = session.clone();
    let told = move |token: Sample| {
        let key = token.key_expr().as_str();
        let Some((name, session)) = robot_of(key).zip(key.rsplit('/').next()) else {
            return;
        };
        match token.kind() {
            SampleKind::Put => {
                fleet.with_table(|table| table.came(name, session, clock.now()));
                // This runs on a thread of Zenoh, which must not wait.
                runtime.spawn(ask(
                    asking.clone(),
                    Arc::clone(&fleet),
                    clock,
                    name.to_owned(),
                ));
            }
            SampleKind::Delete => fleet.with_table(|table| table.went(name, session)),
        }
    };
    let tokens = session.liveliness().declare_subscriber("slamlab/*/alive/*");
    tokens.history(true).callback(told).await
}

/// Queries a new robot for the states that it sends only on change.
async fn ask(session: Session, fleet: Arc<Fleet>, clock: Clock, name: String) {
    for state in STATES {
        let answers = session
            .get(format!("slamlab/{name}/{state}"))
            .timeout(ANSWER);
        match answers.await {
            Ok(answers) => {
                while let Ok(answer) = answers.recv_async().await {
                    if let Ok(sample) = answer.result() {
                        hear(&fleet, sample, clock);
                    }
                }
            }
            Err(error) => tracing::debug!("zenoh: {name}/{state}: {error}"),
        }
    }
}

/// The robot whose key this is; none if no bridge accepts the name.
fn robot_of(key: &str) -> Option<&str> {
    let name = key.strip_prefix("slamlab/")?.split('/').next()?;
    name.parse::<Name>().ok().map(|_| name)
}

fn hear(fleet: &Fleet, sample: &Sample, clock: Clock) {
    let key = sample.key_expr().as_str();
    let (Some(name), bytes) = (robot_of(key), sample.payload().to_bytes()) else {
        return;
    };
    if key.ends_with(super::super::streams::PAGE) {
        if let Ok(page) = serde_json::from_slice::<String>(&bytes) {
            fleet.with_table(|table| table.page(name, &page));
        }
        return;
    }
    // From a bridge of another version, or not from a bridge: nothing that can be shown.
    match decode::<FromBridge>(&bytes, Format::Json) {
        Ok((_, message)) => fleet.with_table(|table| table.heard(name, &message, clock.now())),
        Err(error) => tracing::debug!("zenoh: {key}: {error}"),
    }
}
