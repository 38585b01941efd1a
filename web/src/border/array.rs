//! Flat arrays inside typed objects: a `Vec` here, a typed array in the page.
//!
//! Each type has the name of the page's own typed array, which therefore also appears in the types
//! of the objects around it.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_wasm_bindgen::preserve;

macro_rules! arrays {
    ($($name:ident of $number:ty),+) => { $(
        #[doc = concat!("Crosses as a `", stringify!($name), "`.")]
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct $name(pub Vec<$number>);

        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                preserve::serialize(&js_sys::$name::from(self.0.as_slice()), serializer)
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let array: js_sys::$name = preserve::deserialize(deserializer)?;
                Ok(Self(array.to_vec()))
            }
        }

        impl From<Vec<$number>> for $name {
            fn from(numbers: Vec<$number>) -> Self {
                Self(numbers)
            }
        }

        impl FromIterator<$number> for $name {
            fn from_iter<I: IntoIterator<Item = $number>>(numbers: I) -> Self {
                Self(numbers.into_iter().collect())
            }
        }

        impl std::ops::Deref for $name {
            type Target = [$number];

            fn deref(&self) -> &Self::Target {
                &self.0
            }
        }
    )+ };
}

arrays!(Float32Array of f32, Float64Array of f64, Int32Array of i32, Uint8Array of u8, Uint32Array of u32);

/// Messages as the page sends them.
pub(crate) fn messages(all: &[Vec<u8>]) -> Vec<js_sys::Uint8Array> {
    all.iter().map(|bytes| bytes.as_slice().into()).collect()
}
