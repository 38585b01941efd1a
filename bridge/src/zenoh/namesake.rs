//! Detects two robots of the same name at a router, by their liveliness tokens.
//!
//! Each robot declares a token at `slamlab/NAME/alive/SESSION`. The later one sees the other's
//! token, reports it and waits, because both would obey the same commands. If two come at the same
//! moment, the one with the lower session id stays.

use std::time::Duration;

use ::zenoh::Session;
use ::zenoh::liveliness::LivelinessToken;
use ::zenoh::pubsub::Subscriber;
use ::zenoh::sample::SampleKind;
use tokio::sync::watch;

use super::keys::Keys;

/// How long a router may take to list the tokens.
const ANSWER: Duration = Duration::from_secs(2);

/// A claim to the name, until a robot with precedence shows up.
pub(super) struct Claim {
    taken_by: watch::Receiver<Option<String>>,
    _token: LivelinessToken,
    _listening: Subscriber<()>,
}

/// The session of another robot of this name, if there is one.
pub(super) async fn other(session: &Session, keys: &Keys) -> ::zenoh::Result<Option<String>> {
    let own = keys.alive(&session.zid().to_string());
    let tokens = session.liveliness().get(keys.alive("*")).timeout(ANSWER);
    let found = tokens.await?;
    let mut other = None;
    while let Ok(reply) = found.recv_async().await {
        if let Ok(sample) = reply.result()
            && sample.key_expr().as_str() != own
        {
            other = session_of(sample.key_expr().as_str());
        }
    }
    Ok(other)
}

fn session_of(key: &str) -> Option<String> {
    key.rsplit('/').next().map(str::to_owned)
}

impl Claim {
    pub(super) async fn make(session: &Session, keys: &Keys) -> ::zenoh::Result<Self> {
        let own = session.zid().to_string();
        let (found, taken_by) = watch::channel(None);
        let name = own.clone();
        let listening = session
            .liveliness()
            .declare_subscriber(keys.alive("*"))
            .history(true)
            .callback(move |sample| {
                let other = session_of(sample.key_expr().as_str());
                let is_first = |other: &String| *other < name;
                if sample.kind() == SampleKind::Put
                    && let Some(other) = other.filter(is_first)
                {
                    found.send_replace(Some(other));
                }
            })
            .await?;
        let token = session.liveliness().declare_token(keys.alive(&own)).await?;
        Ok(Self {
            taken_by,
            _token: token,
            _listening: listening,
        })
    }

    /// Ends when another robot came first after all.
    pub(super) async fn lost(&mut self) {
        // The sender lives as long as this claim.
        let _ = self.taken_by.wait_for(Option::is_some).await;
    }
}
