//! Rights: named permissions to use the bridge.
//!
//! In: a proof made with a token. Out: the [`Right`] that it shows, or none.
//!
//! 1. The bridge's first token ([`crate::token`]) is the owner's, and its right has no name. Every
//!    other right has a name, and is kept in a file (`file`): name, role, and the verifier for its
//!    proofs. The token itself is shown once, when it is made, and stored nowhere.
//! 2. The commands `token add`, `list` and `revoke` work on the file, and the bridge checks it
//!    several times a second ([`Keys`]). So they work without a running bridge, and no endpoint can
//!    grant rights. Whoever can write the file already has the bridge's own account.
//! 3. A file that cannot be read gives nobody a right: a slip while revoking a right by hand takes
//!    away too much, never too little.
//! 4. What a role may do stands in one table: [`Role::may`].

mod file;
mod keys;
mod name;

#[cfg(feature = "zenoh")]
use slamlab_core::wire::message::MessageKey;
use slamlab_core::wire::message::{CHALLENGE_BYTES, PROOF_BYTES, Right, Role, Verifier};
use subtle::ConstantTimeEq;

pub use file::{RightsError, RightsFile};
pub use keys::{Files, Keys, KeysError};
pub use name::{Name, NameError};

pub(crate) use keys::keep_up;

use crate::token::Token;

/// A right, and the verifier for its proofs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Granted {
    pub(crate) right: Right,
    verifier: Verifier,
}

impl Granted {
    /// Whether its holder gets one of the places and the message rate reserved for drivers. A
    /// watcher with a token has the limits of a watcher.
    pub(crate) fn may_drive(&self) -> bool {
        self.right.role.may_drive()
    }

    /// The key with which its holder signs messages, after showing the right by a proof.
    #[cfg(feature = "zenoh")]
    pub(crate) fn message_key(
        &self,
        challenge: &[u8; CHALLENGE_BYTES],
        shown: &[u8; PROOF_BYTES],
    ) -> MessageKey {
        self.verifier.message_key(challenge, shown)
    }
}

/// All rights.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rights(Vec<Granted>);

impl Rights {
    /// The right of the bridge's first token.
    fn owner(token: &Token) -> Granted {
        Granted {
            right: Right {
                role: Role::Owner,
                name: String::new(),
            },
            verifier: Verifier::of(token.reveal()),
        }
    }

    /// The right that a proof shows. Each comparison takes constant time.
    pub(crate) fn proved(
        &self,
        challenge: &[u8; CHALLENGE_BYTES],
        shown: &[u8; PROOF_BYTES],
    ) -> Option<Granted> {
        let is_proved = |granted: &&Granted| {
            let of_proof = granted.verifier.of_proof(challenge, shown);
            bool::from(of_proof.ct_eq(&granted.verifier.to_bytes()))
        };
        self.0.iter().find(is_proved).cloned()
    }

    /// Whether a right still exists unchanged.
    pub(crate) fn holds(&self, granted: &Granted) -> bool {
        self.0.contains(granted)
    }

    /// The role of the right of this name.
    pub(crate) fn role_of(&self, name: &Name) -> Option<Role> {
        let name = name.to_string();
        let mut all = self.0.iter().map(|granted| &granted.right);
        all.find(|right| right.name == name).map(|right| right.role)
    }

    /// The right of this name.
    #[cfg(feature = "zenoh")]
    pub(crate) fn named(&self, name: &Name) -> Option<Granted> {
        let name = name.to_string();
        let found = self.0.iter().find(|granted| granted.right.name == name);
        found.cloned()
    }

    /// The number of rights.
    #[must_use]
    pub fn count(&self) -> usize {
        self.0.len()
    }
}

#[cfg(test)]
mod tests {
    use slamlab_core::wire::message::proof;

    use super::*;

    #[test]
    fn a_proof_shows_the_right_that_it_was_made_with() {
        let [owner, anna, other] = std::array::from_fn(|_| Token::random().unwrap());
        let granted = Granted {
            right: Right {
                role: Role::Driver,
                name: "anna".to_owned(),
            },
            verifier: Verifier::of(anna.reveal()),
        };
        let rights = Rights(vec![Rights::owner(&owner), granted.clone()]);
        let challenge = [1; CHALLENGE_BYTES];
        let shown = |token: &Token| rights.proved(&challenge, &proof(token.reveal(), &challenge));
        assert_eq!(shown(&owner).unwrap().right.role, Role::Owner);
        assert_eq!(shown(&anna), Some(granted.clone()));
        assert_eq!(shown(&other), None);
        let replayed = proof(anna.reveal(), &[2; CHALLENGE_BYTES]);
        assert_eq!(rights.proved(&challenge, &replayed), None);
        assert!(rights.holds(&granted));
        let mut changed = granted;
        changed.right.role = Role::Watcher;
        assert!(!rights.holds(&changed));
    }
}
