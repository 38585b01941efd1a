//! What a client learns before it connects, and how it shows that it has the token without sending
//! it.

use hmac::{Hmac, KeyInit, Mac};
use serde::{Deserialize, Serialize};
use sha2::Sha256;

/// Length of a challenge.
pub const CHALLENGE_BYTES: usize = 16;
/// Length of a proof.
pub const PROOF_BYTES: usize = 32;

/// Keeps proofs for slamlab apart from any other use of the same token.
const CONTEXT: &[u8] = b"slamlab bridge 1";

/// Shows that its sender has the token: HMAC-SHA-256 of the challenge, keyed with the token.
///
/// The token never crosses the network, and what does is of no use on another connection, which has
/// another challenge.
///
/// # Source    RFC 2104; RFC 6234.
#[must_use]
pub fn proof(token: &str, challenge: &[u8; CHALLENGE_BYTES]) -> [u8; PROOF_BYTES] {
    // HMAC takes keys of any length; the error is of other functions behind the same trait.
    let Ok(mut mac) = Hmac::<Sha256>::new_from_slice(token.trim().as_bytes()) else {
        return [0; PROOF_BYTES];
    };
    mac.update(CONTEXT);
    mac.update(challenge);
    mac.finalize().into_bytes().into()
}

/// What `/bridge.json` says.
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
    /// Preset of the robot that can be driven; none where only sensors are.
    pub robot: Option<String>,
    /// What the bridge relays: `sim:arena`. Empty: nothing is behind the page but itself.
    pub sources: Vec<String>,
}

/// Who may watch. Driving always needs the token, and Stop never.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Watching {
    /// Whoever reaches the bridge.
    Anyone,
    /// Who has the token.
    Token,
}
