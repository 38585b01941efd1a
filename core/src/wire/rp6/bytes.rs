//! Values out of a payload and into one: numbers little-endian, structs field by field.

/// A value of a payload.
pub(super) trait Field: Sized {
    /// Appends its bytes.
    fn put(&self, out: &mut Vec<u8>);

    /// Takes it from the front of `payload`; `None` where bytes are missing, or are no such value.
    fn take(payload: &mut &[u8]) -> Option<Self>;
}

macro_rules! numbers {
    ($($number:ty),+) => { $(
        impl Field for $number {
            fn put(&self, out: &mut Vec<u8>) {
                out.extend(self.to_le_bytes());
            }

            fn take(payload: &mut &[u8]) -> Option<Self> {
                let (head, rest) = payload.split_first_chunk()?;
                *payload = rest;
                Some(Self::from_le_bytes(*head))
            }
        }
    )+ };
}

numbers!(u8, u16, i16, u32, i32);

impl<T: Field> Field for [T; 2] {
    fn put(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|value| value.put(out));
    }

    fn take(payload: &mut &[u8]) -> Option<Self> {
        Some([T::take(payload)?, T::take(payload)?])
    }
}

/// A struct's fields in the order in which they stand on the wire.
macro_rules! fields {
    ($Struct:ident { $($field:tt),+ $(,)? }) => {
        impl Field for $Struct {
            fn put(&self, out: &mut Vec<u8>) {
                $(self.$field.put(out);)+
            }

            fn take(payload: &mut &[u8]) -> Option<Self> {
                Some(Self { $($field: Field::take(payload)?),+ })
            }
        }
    };
}
pub(super) use fields;

/// An enum's variants by their numbers on the wire; `or Other` has all other numbers.
macro_rules! codes {
    ($Enum:ident $(or $Other:ident)? { $($Variant:ident = $code:literal),+ $(,)? }) => {
        impl Field for $Enum {
            fn put(&self, out: &mut Vec<u8>) {
                out.push(match *self {
                    $(Self::$Variant => $code,)+
                    $(Self::$Other(code) => code,)?
                });
            }

            fn take(payload: &mut &[u8]) -> Option<Self> {
                match u8::take(payload)? {
                    $($code => Some(Self::$Variant),)+
                    $(code => Some(Self::$Other(code)),)?
                    #[allow(unreachable_patterns, reason = "an enum with all other numbers")]
                    _ => None,
                }
            }
        }
    };
}
pub(super) use codes;
