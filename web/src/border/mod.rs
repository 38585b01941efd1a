//! The border to the page: one schema, written here and read in TypeScript.
//!
//! `wasm-bindgen` puts the types of everything that derives `Tsify` into
//! `www/pkg/slamlab_web.d.ts`; `www/layout.mjs` asks [`layout`] for the positions of numbers in
//! flat arrays. Nothing is declared again by hand.
//!
//! | file | subject |
//! |---|---|
//! | `array` | flat arrays inside typed objects |
//! | `core_names` | closed sets by the names that the core has for them |
//! | `error` | errors: a kind and a sentence |
//! | `names` | other closed sets: each variant crosses by its name |
//! | `rows` | flat arrays of rows: which number stands where |
//! | `values` | settings by their keys |

mod array;
mod core_names;
mod error;
mod names;
mod rows;
mod values;

pub(crate) use array::messages;
pub use array::{Float32Array, Float64Array, Int32Array, Uint8Array, Uint32Array};
pub use core_names::{
    DeviceStateName, DisarmReasonName, FenceStateName, MeasureName, MethodName, PlannerName,
    RoleName,
};
pub(crate) use error::kinds;
pub use error::{ErrorKind, WebError};
pub(crate) use names::names;
pub use names::*;
pub use rows::layout;
pub(crate) use rows::{
    BasinRow, BeamRow, CellRow, ClosureRow, CorrespondenceRow, DoorRow, EditRow, ExaminedBeamRow,
    ExtentRow, FlipRow, HypothesisRow, IterationRow, LandmarkRow, LeafRow, LineRow, PointRow,
    RefindingRow, SubmapRow, TrackRow, TrailRow, TwinRow, flat,
};
pub use values::SettingValues;

use serde::Serialize;
use tsify::{Ts, Tsify};

/// The return type of a method called by the page.
pub type Typed<T> = Result<Ts<T>, WebError>;

/// Converts to an object of the page.
pub(crate) fn typed<T: Tsify + Serialize>(value: &T) -> Typed<T> {
    Ok(value.into_ts()?)
}
