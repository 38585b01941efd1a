//! Closed sets whose names stand in a table of the core: a new variant there needs no change here.

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use slamlab_core::lesson::Measure;
use slamlab_core::plan::Planner;
use slamlab_core::slam::Method;
use slamlab_core::wire::message::{DeviceState, DisarmReason, FenceState, Role};
use wasm_bindgen::prelude::wasm_bindgen;

/// Types of the page for enums of the core that have names.
macro_rules! core_names {
    ($($(#[$doc:meta])* $Name:ident of $Core:ident;)+) => { $(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct $Name(pub $Core);

        impl From<$Core> for $Name {
            fn from(core: $Core) -> Self {
                Self(core)
            }
        }

        impl Serialize for $Name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.0.name())
            }
        }

        impl $Name {
            /// The type in TypeScript.
            pub const UNION: &str = {
                const HEAD: &str = concat!("export type ", stringify!($Name), " =");
                const UNION: ([u8; MOST_BYTES], usize) = union(HEAD, $Core::NAMES);
                match str::from_utf8(UNION.0.split_at(UNION.1).0) {
                    Ok(text) => text,
                    Err(_) => "",
                }
            };
        }

        #[wasm_bindgen(typescript_custom_section)]
        const UNION: &str = $Name::UNION;
    )+ };
}

core_names! {
    /// A SLAM method.
    MethodName of Method;
    /// A planner.
    PlannerName of Planner;
    /// A measure by which a try at a lesson is graded.
    MeasureName of Measure;
    /// The state of a device.
    DeviceStateName of DeviceState;
    /// Why the robot is disarmed.
    DisarmReasonName of DisarmReason;
    /// How a robot stands to its geofence.
    FenceStateName of FenceState;
    /// The role of a right.
    RoleName of Role;
}

impl<'de> Deserialize<'de> for MethodName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        name.parse().map(Self).map_err(D::Error::custom)
    }
}

/// Buffer size for the longest [`union`]; if it is too small, this does not compile.
const MOST_BYTES: usize = 512;

/// The names as a union type of TypeScript, `export type Name = | "a" | "b";`, and its length.
const fn union(head: &str, names: &[&str]) -> ([u8; MOST_BYTES], usize) {
    let mut text = [b';'; MOST_BYTES];
    let mut at = append(&mut text, 0, head);
    let mut place = 0;
    while place < names.len() {
        at = append(&mut text, at, " | \"");
        at = append(&mut text, at, names[place]);
        at = append(&mut text, at, "\"");
        place += 1;
    }
    (text, at + ";".len())
}

/// Returns where the text continues.
const fn append(text: &mut [u8], at: usize, part: &str) -> usize {
    let (_, room) = text.split_at_mut(at);
    let (room, _) = room.split_at_mut(part.len());
    room.copy_from_slice(part.as_bytes());
    at + part.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_knows_every_name_of_the_core() {
        let names: String = Method::ALL
            .iter()
            .map(|method| format!(" | \"{}\"", method.name()))
            .collect();
        assert_eq!(
            MethodName::UNION,
            format!("export type MethodName ={names};")
        );
        assert_eq!(PlannerName::UNION.matches('|').count(), Planner::ALL.len());
    }
}
