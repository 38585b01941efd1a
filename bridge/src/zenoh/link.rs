//! Keeps the bridge connected to a router, whatever happens to the router.
//!
//! In: a [`ZenohConfig`]. Out: notices for people, none repeated before another one comes; and
//! while there is a session everything that [`super`] lists.

use std::sync::Arc;
use std::time::Duration;

use ::zenoh::Session;
use slamlab_core::wire::message::{FromBridge, Severity};
use tokio::sync::watch;
use tokio::time::{sleep, timeout};

use super::fleet::Gathering;
use super::keys::Keys;
use super::lane::Urgent;
use super::namesake::{self, Claim};
use super::remote::Remote;
use super::ros::{self, Driver};
use super::router::{self, Router};
use super::streams::{Streams, StreamsError};
use super::{ZenohConfig, ZenohError};
use crate::accept::until;
use crate::address::url_towards;
use crate::hub::FromClient;
use crate::rights::Rights;
use crate::shared::Shared;

/// Pause between tries to reach a router: the first, and the longest.
const TRY_AGAIN: (Duration, Duration) = (Duration::from_millis(250), Duration::from_secs(4));
/// Interval between checks that the router is still there.
const LOOK: Duration = Duration::from_millis(100);
/// Interval between checks whether another robot of this name is still there.
const LOOK_AT_NAME: Duration = Duration::from_secs(1);
/// Checks before another robot is reported: for that long a router may still show a lost session of
/// this same robot.
const OWN_SHADOW: u32 = 4;
/// How long a session may take to end.
const FAREWELL: Duration = Duration::from_secs(2);

/// A configuration whose possible faults have been checked.
pub(crate) struct Ready {
    config: ZenohConfig,
    router: Router,
}

/// # Errors    [`ZenohError`]: a file does not hold a certificate or key.
pub(crate) fn ready(config: ZenohConfig) -> Result<Ready, ZenohError> {
    let router = Router::new(&config)?;
    Ok(Ready { config, router })
}

impl Ready {
    /// # Errors    [`ZenohError::NoRight`]: the right for ROS does not exist or may not drive.
    pub(crate) fn check_rights(&self, rights: &Rights) -> Result<(), ZenohError> {
        let right = self.config.ros.as_ref().and_then(|ros| ros.right.clone());
        match right {
            Some(right) if !rights.role_of(&right).is_some_and(|role| role.may_drive()) => {
                Err(ZenohError::NoRight { right })
            }
            _ => Ok(()),
        }
    }

    /// Keeps the robot connected to the router until `stopped`.
    pub(crate) fn start(self, shared: Arc<Shared>, stopped: watch::Receiver<bool>) {
        let link = Link {
            keys: Keys::of(&self.config.name),
            ready: self,
            shared,
            said: None,
        };
        tokio::spawn(async move {
            tokio::select! {
                () = link.keep() => (),
                () = until(stopped) => (),
            }
        });
    }
}

struct Link {
    ready: Ready,
    keys: Keys,
    shared: Arc<Shared>,
    /// The last notice.
    said: Option<String>,
}

/// Why a robot is no longer at a router.
#[derive(Debug, thiserror::Error)]
enum Lost {
    #[error("it is gone")]
    Router,
    #[error("another robot is called {0} there, too")]
    Name(String),
    #[error(transparent)]
    Streams(#[from] StreamsError),
}

impl From<::zenoh::Error> for Lost {
    fn from(error: ::zenoh::Error) -> Self {
        Self::Streams(error.into())
    }
}

impl Link {
    async fn keep(mut self) {
        let mut pause = TRY_AGAIN.0;
        loop {
            match self.ready.router.open().await {
                Ok(session) => {
                    pause = TRY_AGAIN.0;
                    let lost = self.serve(&session).await;
                    self.say_lost(&lost).await;
                    // Closing a session whose router is gone must not take long.
                    let _ = timeout(FAREWELL, async { session.close().await }).await;
                }
                Err(error) => {
                    let text = format!(
                        "Zenoh: {error}. It is tried again and again; robot and local page go on without it."
                    );
                    self.say(Severity::Warning, text).await;
                    pause = (2 * pause).min(TRY_AGAIN.1);
                }
            }
            sleep(pause).await;
        }
    }

    async fn say_lost(&mut self, lost: &Lost) {
        if !matches!(lost, Lost::Streams(StreamsError::Ends)) {
            let text = format!(
                "Zenoh: the router at {} is lost: {lost}. Whoever drove through it drives no longer; it is tried again and again.",
                self.ready.router.endpoint()
            );
            self.say(Severity::Warning, text).await;
        }
    }

    /// Sends a notice, unless it is the same as the last one.
    async fn say(&mut self, severity: Severity, text: String) {
        if self.said.as_ref() != Some(&text) {
            self.said = Some(text.clone());
            // The hub is gone only when the bridge ends.
            let _ = self.shared.tell(FromClient::Notice(severity, text)).await;
        }
    }

    /// Serves everything that the robot offers at a router, until the router is lost.
    async fn serve(&mut self, session: &Session) -> Lost {
        let served = tokio::select! {
            served = self.serve_until_lost(session) => served,
            () = gone(session) => Err(Lost::Router),
        };
        match served {
            Ok(never) => match never {},
            Err(lost) => lost,
        }
    }

    async fn serve_until_lost(
        &mut self,
        session: &Session,
    ) -> Result<std::convert::Infallible, Lost> {
        self.wait_for_name(session).await?;
        let mut claim = Claim::make(session, &self.keys).await?;
        let urgent = Urgent::start().map_err(StreamsError::from)?;
        let (keys, shared) = (&self.keys, &self.shared);
        let name = self.ready.config.name.to_string();
        let (mut node, mut driver) = match &self.ready.config.ros {
            Some(ros) => {
                let (node, driver) = ros::start(session, ros, &name, shared).await?;
                (Some(node), Some(driver))
            }
            None => (None, None),
        };
        let also = move |message: &FromBridge| {
            if let Some(node) = &mut node {
                node.publish(message);
            }
        };
        let router = self.ready.router.endpoint();
        let page = match shared.listening {
            Some(at) => url_towards(at, shared.is_tls, (&router.host, router.port)).await,
            None => None,
        };
        let mut streams = Streams::start(session, keys, shared, urgent.clone(), page, also).await?;
        let mut remote = Remote::start(session, keys, shared, urgent).await?;
        let _gathering = match &shared.fleet {
            Some(fleet) => Some(Gathering::start(session, fleet, shared.clock).await?),
            None => None,
        };
        let endpoint = self.ready.router.endpoint();
        let text = format!("Zenoh: the robot is at the router at {endpoint} as {name}.");
        self.say(Severity::Info, text).await;
        tokio::select! {
            error = streams.run() => Err(error.into()),
            () = remote.run() => Err(StreamsError::Ends.into()),
            () = drive(driver.as_mut()) => Err(StreamsError::Ends.into()),
            () = claim.lost() => Err(Lost::Name(self.ready.config.name.to_string())),
        }
    }

    /// Waits until no other robot at the router has this one's name.
    async fn wait_for_name(&mut self, session: &Session) -> Result<(), Lost> {
        let mut looks = 0;
        while let Some(other) = namesake::other(session, &self.keys).await? {
            looks += 1;
            if looks > OWN_SHADOW {
                let name = &self.ready.config.name;
                let text = format!(
                    "Zenoh: another robot at {} is called {name} already, as session {other}. This one stays away until it is gone: \
                     give each a zenoh name of its own.",
                    self.ready.router.endpoint()
                );
                self.say(Severity::Error, text).await;
            }
            sleep(LOOK_AT_NAME).await;
        }
        Ok(())
    }
}

/// Serves ROS tools, if there is a node for them.
async fn drive(driver: Option<&mut Driver>) {
    match driver {
        Some(driver) => driver.run().await,
        None => std::future::pending().await,
    }
}

/// Ends when the session has no router any more.
async fn gone(session: &Session) {
    while router::router_of(session).await.is_some() {
        sleep(LOOK).await;
    }
}
