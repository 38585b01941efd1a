//! The services that stand in for what rosbridge does not know: the token, the lease, arming.

use serde_json::{Value, json};
use slamlab_core::wire::message::{
    CHALLENGE_BYTES, FromBridge, PROOF_BYTES, RefusalReason, ToBridge, close,
};

use super::Peer;
use super::message::Reply;
use crate::ending::{End, INTERNAL, MALFORMED};
use crate::safety::ClientId;

/// How far a client has come.
#[derive(Debug, Default)]
pub(super) struct Services {
    /// Worth one proof.
    challenge: Option<[u8; CHALLENGE_BYTES]>,
    /// Of the lease; none is 0.
    pub(super) epoch: u32,
    /// The call that waits for the hub's answer.
    waiting: Option<Call>,
}

#[derive(Debug)]
struct Call {
    id: Option<String>,
    service: String,
}

impl Call {
    fn answer<'a>(self, result: bool, values: Value) -> Reply<'a> {
        let Self { id, service } = self;
        Reply::ServiceResponse {
            id,
            service,
            values,
            result,
        }
    }
}

impl Services {
    /// The answer to the call that waits, if this is it.
    pub(super) fn answer_to<'a>(
        &mut self,
        message: &FromBridge,
        client: Option<ClientId>,
    ) -> Option<Reply<'a>> {
        let service = self.waiting.as_ref()?.service.clone();
        let (result, values) = match message {
            FromBridge::Granted(lease) if service == "/slamlab/take" => {
                self.epoch = lease.epoch;
                (
                    true,
                    json!({ "epoch": lease.epoch, "millis": lease.millis }),
                )
            }
            // News from before the call says that it is not armed: only the rest is an answer.
            FromBridge::Safety(safety)
                if service == "/slamlab/arm" && (safety.armed || safety.driver != client) =>
            {
                let is_ours = safety.armed && safety.driver == client;
                (is_ours, json!({ "armed": is_ours }))
            }
            FromBridge::Refused(reason) if is_of(&service, *reason) => {
                (false, json!({ "reason": reason }))
            }
            _ => return None,
        };
        Some(self.waiting.take()?.answer(result, values))
    }
}

/// Whether a call of the service can be refused so; other refusals are of commands that were under
/// way before it.
fn is_of(service: &str, reason: RefusalReason) -> bool {
    use RefusalReason::{Emergency, Held, NoRight, NoRobot, StaleEpoch};
    match service {
        "/slamlab/take" => matches!(reason, Held | NoRight),
        _ => matches!(reason, StaleEpoch | Emergency | NoRobot | NoRight),
    }
}

impl Peer<'_> {
    pub(super) async fn serve(
        &mut self,
        id: Option<String>,
        service: String,
        args: &Value,
    ) -> Result<(), End> {
        let call = Call { id, service };
        match call.service.as_str() {
            "/slamlab/challenge" => {
                let mut challenge = [0; CHALLENGE_BYTES];
                getrandom::fill(&mut challenge).map_err(|_| Some(INTERNAL))?;
                self.services.challenge = Some(challenge);
                let answer = call.answer(true, json!({ "challenge": hex(&challenge) }));
                self.adapter.send(&answer)
            }
            "/slamlab/enter" => self.enter(call, args).await,
            "/slamlab/take" => {
                let force = args.get("force").and_then(Value::as_bool).unwrap_or(false);
                self.wait(call, ToBridge::Take { force }).await
            }
            "/slamlab/arm" => {
                let epoch = self.services.epoch;
                self.wait(call, ToBridge::Arm { epoch }).await
            }
            "/slamlab/stop" => {
                self.ask(ToBridge::Stop).await?;
                self.adapter.send(&call.answer(true, json!({})))
            }
            _ => {
                let text = json!("there are /slamlab/challenge, enter, take, arm and stop");
                self.adapter.send(&call.answer(false, text))
            }
        }
    }

    /// A wrong proof ends the connection, as it does everywhere; a challenge is worth one.
    async fn enter(&mut self, call: Call, args: &Value) -> Result<(), End> {
        let shown = args.get("proof").and_then(Value::as_str).and_then(unhex);
        let challenge = self.services.challenge.take();
        let (Some(shown), Some(challenge), Some(token)) = (shown, challenge, &self.shared.token)
        else {
            return Err(Some(close::ACCESS));
        };
        if !token.is_proved(&challenge, &shown) {
            return Err(Some(close::ACCESS));
        }
        self.join(true).await?;
        self.adapter.send(&call.answer(true, json!({})))
    }

    /// Asks, and answers when the hub does. One call at a time: a second would not know its answer.
    async fn wait(&mut self, call: Call, message: ToBridge) -> Result<(), End> {
        if self.services.waiting.is_some() {
            return Err(Some(MALFORMED));
        }
        self.services.waiting = Some(call);
        self.ask(message).await
    }
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
    fn a_command_refused_on_its_way_is_no_answer_to_a_call() {
        let mut services = Services {
            waiting: Some(Call {
                id: None,
                service: "/slamlab/arm".to_owned(),
            }),
            ..Services::default()
        };
        let mut is_answer = |reason| {
            services
                .answer_to(&FromBridge::Refused(reason), None)
                .is_some()
        };
        assert!(!is_answer(RefusalReason::Disarmed));
        assert!(is_answer(RefusalReason::NoRobot));
        assert!(
            !is_answer(RefusalReason::NoRobot),
            "the call has its answer"
        );
    }

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
