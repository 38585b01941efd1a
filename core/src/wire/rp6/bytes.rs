//! Reads values from a payload and writes them: numbers little-endian, structs field by field.

/// A value in a payload.
pub(super) trait Field: Sized {
    /// Appends its bytes.
    fn put(&self, out: &mut Vec<u8>);

    /// Takes it from the front of `payload`; `None` if bytes are missing or do not make such a
    /// value.
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

/// A struct whose fields are on the wire in the order given.
macro_rules! fields {
    (
        $(#[$meta:meta])*
        pub struct $Struct:ident { $($(#[$doc:meta])* pub $field:ident: $Type:ty,)+ }
    ) => {
        $(#[$meta])*
        pub struct $Struct {
            $($(#[$doc])* pub $field: $Type,)+
        }

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

/// An enum whose variants have the given numbers on the wire; `or Other` takes all other numbers.
macro_rules! codes {
    (
        $(#[$meta:meta])*
        pub enum $Enum:ident $(or $Other:ident)? {
            $($(#[$doc:meta])* $Variant:ident = $code:literal,)+
        }
    ) => {
        $(#[$meta])*
        pub enum $Enum {
            $($(#[$doc])* $Variant,)+
            $(
                /// One that only a newer firmware knows, by its number.
                $Other(u8),
            )?
        }

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

/// The messages of one direction: kind, and fields in the order on the wire.
macro_rules! messages {
    (
        $Enum:ident, at most $longest:expr;
        $($kind:literal $Message:ident $({ $($field:ident),* })? $(($body:ident))?)+
    ) => {
        impl Message for $Enum {
            const LONGEST_FRAME: usize = $longest;

            fn kind(&self) -> u8 {
                match self {
                    $(Self::$Message { .. } => $kind,)+
                }
            }

            fn put_payload(&self, out: &mut Vec<u8>) {
                match self {
                    $(Self::$Message $({ $($field),* })? $(($body))? => {
                        $($($field.put(out);)*)?
                        $($body.put(out);)?
                    })+
                }
            }

            fn parse(kind: u8, mut payload: &[u8]) -> Option<Self> {
                let message = match kind {
                    $($kind => {
                        $($(let $field = Field::take(&mut payload)?;)*)?
                        $(let $body = Field::take(&mut payload)?;)?
                        Self::$Message $({ $($field),* })? $(($body))?
                    })+
                    _ => return None,
                };
                // A payload that is too long is as wrong as one that is too short.
                payload.is_empty().then_some(message)
            }
        }
    };
}
pub(super) use messages;
