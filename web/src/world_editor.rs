//! What the world editor asks of the core: a world to draw on, and whether a robot can be in the
//! world that was drawn.

use serde::{Deserialize, Serialize};
use slamlab_core::format::world;
use slamlab_core::sim::worlds;
use tsify::Tsify;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{Typed, WebError, typed};

/// No built-in world has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no world `{0}` to draw on; expected one of {expected}", expected = worlds::NAMES.join(", "))]
pub struct NoSuchWorld(String);

crate::border::kinds! { Question: NoSuchWorld; }

/// What is wrong with a world that is being drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[tsify(missing_as_null)]
pub struct WorldFault {
    /// The kind of part: `start`, `goal`, `world`, `obstacle`, `door` or `mover`; `file` if there
    /// is no world to draw at all.
    pub part: String,
    /// Its number from 0; null if there is only one.
    pub index: Option<usize>,
    /// What is wrong, in words.
    pub text: String,
}

/// Whether a robot can be in a world that is being drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[tsify(missing_as_null)]
pub struct WorldCheck {
    /// The first error; null if there is none.
    pub fault: Option<WorldFault>,
}

/// A built-in world as the text of a world file.
///
/// # Errors    No world has this name.
#[wasm_bindgen]
pub fn world_file(name: &str) -> Result<String, WebError> {
    let world = worlds::builtin(name).ok_or_else(|| NoSuchWorld(name.to_owned()))?;
    Ok(world::write(&world))
}

/// Whether a robot can be in the world of this text.
///
/// # Errors    Never because of the text: its errors are the answer.
#[wasm_bindgen]
pub fn check_world(text: &str) -> Typed<WorldCheck> {
    let fault = world::read(text.as_bytes()).err().map(|error| {
        let world::WorldFault { part, index, text } = (&error).into();
        WorldFault { part, index, text }
    });
    typed(&WorldCheck { fault })
}
