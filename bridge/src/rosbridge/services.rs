//! The services that stand in for what rosbridge does not know: the token, the lease, arming; and
//! the stops.
//!
//! Each call is answered at once, whatever was called before. What cannot be done is a call that
//! failed, with the reason, and ends no connection but where a proof is wrong.

use serde_json::{Value, json};
use slamlab_core::wire::message::{CHALLENGE_BYTES, PROOF_BYTES, RefusalReason, ToBridge, close};

use super::message::Reply;
use super::request::argument;
use super::{Peer, rosapi};
use crate::ending::{End, INTERNAL};
use crate::hub::Answer;

/// Behind `/slamlab/`.
pub(super) const NAMES: [&str; 9] = [
    "challenge",
    "enter",
    "take",
    "renew",
    "release",
    "arm",
    "stop",
    "emergency_stop",
    "reset_emergency_stop",
];

/// How far a client has come.
#[derive(Debug, Default)]
pub(super) struct Services {
    /// Worth one proof.
    challenge: Option<[u8; CHALLENGE_BYTES]>,
    /// Of the lease; none is 0.
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
                return Ok((true, json!({ "challenge": hex(&challenge) })));
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

    /// A wrong proof ends the connection, as it does everywhere; a challenge is worth one.
    async fn enter(&mut self, args: &Value) -> Result<Outcome, End> {
        let shown = argument(args, "proof")
            .and_then(Value::as_str)
            .and_then(unhex);
        let challenge = self.services.challenge.take();
        let (Some(shown), Some(challenge), Some(token)) = (shown, challenge, &self.shared.token)
        else {
            return Err(Some(close::ACCESS));
        };
        if !token.is_proved(&challenge, &shown) {
            return Err(Some(close::ACCESS));
        }
        self.join(true).await?;
        Ok((true, json!({})))
    }
}

fn no_service() -> Outcome {
    (
        false,
        json!(format!("there are {}", rosapi::services().join(", "))),
    )
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn unhex(text: &str) -> Option<[u8; PROOF_BYTES]> {
    let mut bytes = [0; PROOF_BYTES];
    if text.len() != 2 * PROOF_BYTES {
        return None;
    }
    for (at, byte) in bytes.iter_mut().enumerate() {
        *byte = u8::from_str_radix(text.get(2 * at..2 * at + 2)?, 16).ok()?;
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hexadecimal_is_read_as_it_is_written_and_nothing_else_is() {
        let mut bytes = [0; PROOF_BYTES];
        bytes[0] = 0xA5;
        assert_eq!(unhex(&hex(&bytes)), Some(bytes));
        assert_eq!(unhex("a5"), None);
        assert_eq!(unhex(&"zz".repeat(PROOF_BYTES)), None);
        assert_eq!(unhex(&"é".repeat(PROOF_BYTES)), None);
    }
}
