//! Enums that go to the page, to other tools and into logs. Each variant has one name that all of
//! them use.
//!
//! JSON holds the name, binary messages the number of the variant.

/// Makes an enum whose variants have names: `name()`, `ALL`, `Display`, and the same names in JSON.
macro_rules! named {
    (
        $(#[$meta:meta])*
        pub enum $Enum:ident { $($(#[$doc:meta])* $Variant:ident = $name:literal,)+ }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        pub enum $Enum {
            $($(#[$doc])* #[serde(rename = $name)] $Variant,)+
        }

        impl $Enum {
            /// All of them, in the order of their numbers on the wire.
            pub const ALL: &[Self] = &[$(Self::$Variant),+];

            /// Their names.
            pub const NAMES: &[&str] = &[$($name),+];

            /// The name by which JSON, page and logs know it.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$Variant => $name,)+
                }
            }
        }

        impl std::fmt::Display for $Enum {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}

pub(super) use named;
