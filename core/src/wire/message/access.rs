//! What a client learns before it connects, and how it proves that it has the token without sending
//! it.

use hmac::{Hmac, KeyInit, Mac};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// Length of a challenge.
pub const CHALLENGE_BYTES: usize = 16;
/// Length of a proof.
pub const PROOF_BYTES: usize = 32;

/// Separates proofs for slamlab from any other use of the same token.
const CONTEXT: &[u8] = b"slamlab bridge 2";
/// Separates the signatures of messages from proofs.
const SIGNED: &[u8] = b"slamlab signed messages 1";

/// Proves to the holder of the [`Verifier`] that the sender has the token.
///
/// The token never crosses the network, and the proof is of no use on another connection, because
/// that has another challenge. With `client = HMAC-SHA-256(token, "slamlab bridge 2")` and
/// `stored = SHA-256(client)`, the proof is `client xor HMAC-SHA-256(stored, challenge)`.
///
/// # Source    RFC 5802 §3 (SCRAM), without salt and iterations: they protect passwords that can be
/// guessed, and a token is random.
#[must_use]
pub fn proof(token: &str, challenge: &[u8; CHALLENGE_BYTES]) -> [u8; PROOF_BYTES] {
    let client = hmac(token.trim().as_bytes(), CONTEXT);
    xor(client, Verifier::of_client(client).signature(challenge))
}

/// What is kept of a token: it can check whether a proof was made with the token, but cannot make
/// one.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Verifier([u8; PROOF_BYTES]);

impl Verifier {
    /// The verifier of a token.
    #[must_use]
    pub fn of(token: &str) -> Self {
        Self::of_client(hmac(token.trim().as_bytes(), CONTEXT))
    }

    /// From the bytes as stored.
    #[must_use]
    pub const fn from_bytes(bytes: [u8; PROOF_BYTES]) -> Self {
        Self(bytes)
    }

    /// The bytes to be stored.
    #[must_use]
    pub const fn to_bytes(&self) -> [u8; PROOF_BYTES] {
        self.0
    }

    /// The verifier of the token that made `shown`, if that is this verifier's token; the caller
    /// compares the two in constant time.
    #[must_use]
    pub fn of_proof(
        &self,
        challenge: &[u8; CHALLENGE_BYTES],
        shown: &[u8; PROOF_BYTES],
    ) -> [u8; PROOF_BYTES] {
        Self::of_client(xor(*shown, self.signature(challenge))).0
    }

    /// The key of the client that made `shown` with this verifier's token.
    #[must_use]
    pub fn message_key(
        &self,
        challenge: &[u8; CHALLENGE_BYTES],
        shown: &[u8; PROOF_BYTES],
    ) -> MessageKey {
        MessageKey::new(xor(*shown, self.signature(challenge)), challenge)
    }

    fn of_client(client: [u8; PROOF_BYTES]) -> Self {
        Self(Sha256::digest(client).into())
    }

    fn signature(&self, challenge: &[u8; CHALLENGE_BYTES]) -> [u8; PROOF_BYTES] {
        hmac(&self.0, challenge)
    }
}

/// A verifier cannot drive, but it does not belong in a log either.
impl std::fmt::Debug for Verifier {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Verifier(…)")
    }
}

/// Signs messages where a proof at the beginning is not enough: behind a router, anybody may write
/// under the name of a client that has given one.
///
/// With `client` as in [`proof`], the key is `HMAC-SHA-256(client, "slamlab signed messages 1" |
/// challenge)`. A listener who has seen challenge and proof does not have the key, because without
/// the verifier the two do not reveal `client`.
#[derive(Clone)]
pub struct MessageKey([u8; PROOF_BYTES]);

impl MessageKey {
    /// The key of a client that has the token, after this challenge.
    #[must_use]
    pub fn of_token(token: &str, challenge: &[u8; CHALLENGE_BYTES]) -> Self {
        Self::new(hmac(token.trim().as_bytes(), CONTEXT), challenge)
    }

    fn new(client: [u8; PROOF_BYTES], challenge: &[u8; CHALLENGE_BYTES]) -> Self {
        Self(hmac(&client, &[SIGNED, challenge].concat()))
    }

    /// The signature of a message: its HMAC-SHA-256.
    #[must_use]
    pub fn sign(&self, message: &[u8]) -> [u8; PROOF_BYTES] {
        hmac(&self.0, message)
    }

    /// Whether a message was signed with this key, checked in constant time.
    #[must_use]
    pub fn has_signed(&self, message: &[u8], signature: &[u8]) -> bool {
        Hmac::<Sha256>::new_from_slice(&self.0).is_ok_and(|mut mac| {
            mac.update(message);
            mac.verify_slice(signature).is_ok()
        })
    }
}

/// Whoever has the key can drive.
impl std::fmt::Debug for MessageKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("MessageKey(…)")
    }
}

/// # Source    RFC 2104; RFC 6234.
fn hmac(key: &[u8], text: &[u8]) -> [u8; PROOF_BYTES] {
    // HMAC takes keys of any length; the error exists for other functions behind the same trait.
    let Ok(mut mac) = Hmac::<Sha256>::new_from_slice(key) else {
        return [0; PROOF_BYTES];
    };
    mac.update(text);
    mac.finalize().into_bytes().into()
}

fn xor(mut a: [u8; PROOF_BYTES], b: [u8; PROOF_BYTES]) -> [u8; PROOF_BYTES] {
    a.iter_mut().zip(b).for_each(|(a, b)| *a ^= b);
    a
}

/// The content of `/bridge.json`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct About {
    /// Version of the program.
    pub version: String,
    /// [`super::PROTOCOL`].
    pub protocol: u8,
    /// [`super::SCHEMA`] in hexadecimal: JavaScript's numbers hold 53 bits.
    pub schema: String,
    /// Path of the WebSocket on the same server.
    pub websocket: String,
    /// Whether watching needs a token.
    pub watching: Watching,
    /// Preset of the robot that can be driven; none if there are only sensors.
    pub robot: Option<String>,
    /// What the bridge relays: `sim:arena`. Empty: the server serves only the page.
    pub sources: Vec<String>,
}

/// Who may watch. Driving always needs a token.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Watching {
    /// Anyone who reaches the bridge.
    Anyone,
    /// Anyone who has a token.
    Token,
}
