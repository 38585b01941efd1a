//! The services for what rosbridge itself does not have: the token, the lease, arming; and the
//! stops.
//!
//! Each call is answered at once, whatever was called before. A call that cannot be done fails with
//! the reason; only a wrong proof ends the connection.

use serde_json::{Value, json};
use slamlab_core::wire::message::{CHALLENGE_BYTES, RefusalReason, ToBridge, close};

use super::message::Reply;
use super::request::argument;
use super::{Peer, rosapi};
use crate::ending::{End, INTERNAL};
use crate::hexadecimal;
use crate::hub::Answer;

/// Type of a call without arguments and an answer without values.
const EMPTY: &str = "std_srvs/srv/Empty";
/// For services for which ROS has no type.
const OWN: &str = "";

/// The services under `/slamlab/`, with their types.
pub(super) const SERVICES: [(&str, &str); 10] = [
    ("challenge", OWN),
    ("enter", OWN),
    ("take", OWN),
    ("renew", EMPTY),
    ("release", EMPTY),
    ("arm", OWN),
    ("stop", EMPTY),
    ("emergency_stop", EMPTY),
    ("reset_emergency_stop", EMPTY),
    ("reset_map", EMPTY),
];

/// How far a client has got.
#[derive(Debug, Default)]
pub(super) struct Services {
    /// Good for one proof.
    challenge: Option<[u8; CHALLENGE_BYTES]>,
    /// Epoch of the lease; 0 without one.
    pub(super) epoch: u32,
}

/// What a service answers: whether it did what was asked, and the values.
type Outcome = (bool, Value);

impl Peer<'_> {
    pub(super) async fn serve(
        &mut self,
        id: Option<Value>,
        service: String,
        args: &Value,
    ) -> Result<(), End> {
        let (result, values) = match service.split_once('/').map(|(_, name)| name) {
            Some(name) => self.outcome(name, args).await?,
            None => no_service(),
        };
        self.adapter.send(&Reply::ServiceResponse {
            id,
            service,
            values,
            result,
        })
    }

    async fn outcome(&mut self, service: &str, args: &Value) -> Result<Outcome, End> {
        if let Some(name) = service.strip_prefix("rosapi/") {
            return Ok(self.rosapi(name, args));
        }
        let epoch = self.services.epoch;
        let message = match service.strip_prefix("slamlab/").unwrap_or_default() {
            "challenge" => {
                let mut challenge = [0; CHALLENGE_BYTES];
                getrandom::fill(&mut challenge).map_err(|_| Some(INTERNAL))?;
                self.services.challenge = Some(challenge);
                return Ok((true, json!({ "challenge": hexadecimal::write(&challenge) })));
            }
            "enter" => return self.enter(args).await,
            "take" => {
                let force = argument(args, "force").and_then(Value::as_bool);
                let force = force.unwrap_or(false);
                ToBridge::Take { force }
            }
            "renew" => ToBridge::Renew { epoch },
            "release" => ToBridge::Release { epoch },
            "arm" => ToBridge::Arm { epoch },
            "stop" => ToBridge::Stop,
            "emergency_stop" => ToBridge::EmergencyStop,
            "reset_emergency_stop" => ToBridge::ResetEmergencyStop { epoch },
            "reset_map" => ToBridge::ResetMap,
            _ => return Ok(no_service()),
        };
        let arms = matches!(message, ToBridge::Arm { .. });
        let reason = match self.ask(message).await? {
            Some(Answer::Done) if arms => return Ok((true, json!({ "armed": true }))),
            Some(Answer::Done) => return Ok((true, json!({}))),
            Some(Answer::Granted(lease)) => {
                self.services.epoch = lease.epoch;
                let values = json!({ "epoch": lease.epoch, "millis": lease.millis });
                return Ok((true, values));
            }
            Some(Answer::Refused(reason)) => reason,
            None => RefusalReason::NoRight,
        };
        Ok((false, json!({ "reason": reason })))
    }

    fn rosapi(&self, name: &str, args: &Value) -> Outcome {
        if self.client.is_none() {
            return (
                false,
                json!("show the proof first: /slamlab/challenge, /slamlab/enter"),
            );
        }
        let clock = &self.shared.clock;
        let now = clock.time_of_day(clock.now());
        match rosapi::answer(name, args, self.shared, now) {
            Ok(values) => (true, values),
            Err(why) => (false, json!(why)),
        }
    }

    /// A wrong proof ends the connection, as everywhere; a challenge is good for one proof. A call
    /// without a proof or a challenge is no attempt, and only fails.
    async fn enter(&mut self, args: &Value) -> Result<Outcome, End> {
        let Some(shown) = argument(args, "proof").and_then(Value::as_str) else {
            return Ok((false, json!("proof is missing, or no text")));
        };
        let Some(challenge) = self.services.challenge.take() else {
            let why = "ask for /slamlab/challenge first: each is worth one proof";
            return Ok((false, json!(why)));
        };
        let shown = hexadecimal::read(shown);
        let granted = shown.and_then(|shown| self.shared.proved(&challenge, &shown));
        let Some(granted) = granted else {
            return Err(Some(close::ACCESS));
        };
        let values = json!({ "role": granted.right.role, "name": granted.right.name });
        self.join(Some(granted)).await?;
        Ok((true, values))
    }
}

fn no_service() -> Outcome {
    (
        false,
        json!(format!(
            "there are {}",
            rosapi::names_of_services().join(", ")
        )),
    )
}
