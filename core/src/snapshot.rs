//! The state of a value as bytes, and the value from its bytes, exact to the bit.
//!
//! In: a value. Out: bytes that are the same on every machine; and from such bytes the value, or
//! what is wrong and where. The layout has no names, and no lengths but those of lists. Only the
//! code that reads the bytes defines their meaning, so a file of them has to begin with a version.
//!
//! | value | bytes |
//! |---|---|
//! | whole number | 7 bits a byte, lowest first, highest bit set on all but the last (LEB128) |
//! | number | IEEE 754, lowest byte first; one that is not finite is refused |
//! | truth | 0 or 1 |
//! | list | its length, then its entries |
//! | what may be missing | 0, or 1 and the value |
//! | structure | its fields in the order in which `snapshot!` names them |
//!
//! Bytes come from files, so nothing in them is trusted: memory is reserved only as far as entries
//! arrive, and a structure may have a rule that its values must satisfy. A crate for such formats
//! (`postcard`) would give neither the place nor the reason of a fault, and would silently skip a
//! field that somebody adds; `snapshot!` then does not compile.

mod values;

use std::fmt;

/// A value that can be written and read again.
pub trait Snapshot: Sized {
    /// Appends its bytes.
    fn write(&self, out: &mut Vec<u8>);

    /// Reads a value from the front of the remaining bytes.
    ///
    /// # Errors    [`SnapshotError`]: what is wrong, and where.
    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError>;
}

/// What is wrong with the bytes of a value.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{fault} (byte {at} of the content)", Path(.path))]
pub struct SnapshotError {
    /// Fields and entry numbers that lead to the fault, the innermost first.
    path: Vec<Place>,
    fault: Fault,
    at: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Field(&'static str),
    Entry(usize),
}

#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
enum Fault {
    #[error("the content ends here")]
    Ends,
    #[error("a number is not finite")]
    NotFinite,
    #[error("a whole number does not fit")]
    TooLarge,
    #[error("{0} stands for nothing")]
    NoVariant(u64),
    #[error("{entries} entries are said to follow, and {bytes} bytes are left")]
    TooLong { entries: usize, bytes: usize },
    #[error("{0}")]
    Rule(String),
}

struct Path<'a>(&'a [Place]);

impl fmt::Display for Path<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (depth, place) in self.0.iter().rev().enumerate() {
            match place {
                Place::Field(name) if depth == 0 => write!(f, "{name}")?,
                Place::Field(name) => write!(f, ".{name}")?,
                Place::Entry(at) => write!(f, "[{at}]")?,
            }
        }
        let ends = if self.0.is_empty() { "" } else { ": " };
        f.write_str(ends)
    }
}

impl SnapshotError {
    /// The same error, within `field` of a larger value.
    #[must_use]
    pub fn within(mut self, field: &'static str) -> Self {
        self.path.push(Place::Field(field));
        self
    }

    fn in_entry(mut self, at: usize) -> Self {
        self.path.push(Place::Entry(at));
        self
    }
}

/// The bytes that remain to be read.
#[derive(Debug)]
pub struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

/// Entries for which memory is reserved at most before they are read.
const RESERVED: usize = 1024;

impl<'a> Reader<'a> {
    /// Starts at the first byte.
    #[must_use]
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// Reads the part called `name` of a larger value.
    ///
    /// # Errors    [`SnapshotError`].
    pub fn field<T: Snapshot>(&mut self, name: &'static str) -> Result<T, SnapshotError> {
        T::read(self).map_err(|error| error.within(name))
    }

    /// Refuses what was read last, because it breaks a rule.
    #[must_use]
    pub fn refuse(&self, why: impl Into<String>) -> SnapshotError {
        self.fault(Fault::Rule(why.into()))
    }

    /// Refuses what was read last if `is_kept` is false.
    ///
    /// # Errors    [`SnapshotError`] with the `rule`.
    pub fn rule(&self, is_kept: bool, rule: &str) -> Result<(), SnapshotError> {
        match is_kept {
            true => Ok(()),
            false => Err(self.refuse(rule)),
        }
    }

    /// Whether nothing remains.
    #[must_use]
    pub fn is_at_end(&self) -> bool {
        self.at == self.bytes.len()
    }

    fn fault(&self, fault: Fault) -> SnapshotError {
        SnapshotError {
            path: vec![],
            fault,
            at: self.at,
        }
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], SnapshotError> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let taken = rest.first_chunk().ok_or_else(|| self.fault(Fault::Ends))?;
        self.at += N;
        Ok(*taken)
    }

    /// The length of a list; each entry takes at least one byte.
    fn length(&mut self) -> Result<usize, SnapshotError> {
        let entries = usize::read(self)?;
        let bytes = self.bytes.len() - self.at;
        match entries <= bytes {
            true => Ok(entries),
            false => Err(self.fault(Fault::TooLong { entries, bytes })),
        }
    }

    fn entries<T: Snapshot>(&mut self) -> Result<Vec<T>, SnapshotError> {
        let length = self.length()?;
        let mut list = Vec::with_capacity(length.min(RESERVED));
        for at in 0..length {
            list.push(T::read(self).map_err(|error| error.in_entry(at))?);
        }
        Ok(list)
    }
}

/// A structure as its fields, in this order; `rule` is what values that were read must satisfy.
macro_rules! snapshot {
    ($kind:ident { $($field:ident),* $(,)? } $(, $rule:expr, $words:literal)* $(,)?) => {
        impl $crate::snapshot::Snapshot for $kind {
            fn write(&self, out: &mut Vec<u8>) {
                let Self { $($field),* } = self;
                $($crate::snapshot::Snapshot::write($field, out);)*
            }

            fn read(
                from: &mut $crate::snapshot::Reader<'_>,
            ) -> Result<Self, $crate::snapshot::SnapshotError> {
                let read = Self { $($field: from.field(stringify!($field))?),* };
                $(
                    let is_kept: fn(&Self) -> bool = $rule;
                    from.rule(is_kept(&read), $words)?;
                )*
                Ok(read)
            }
        }
    };
}
pub(crate) use snapshot;

/// Enum variants without content, written as their numbers.
macro_rules! snapshot_names {
    ($kind:ident { $($name:ident = $number:literal),* $(,)? }) => {
        impl $crate::snapshot::Snapshot for $kind {
            fn write(&self, out: &mut Vec<u8>) {
                let number: u64 = match self { $(Self::$name => $number),* };
                number.write(out);
            }

            fn read(
                from: &mut $crate::snapshot::Reader<'_>,
            ) -> Result<Self, $crate::snapshot::SnapshotError> {
                match u64::read(from)? {
                    $($number => Ok(Self::$name),)*
                    other => Err(from.no_variant(other)),
                }
            }
        }
    };
}
pub(crate) use snapshot_names;

impl Reader<'_> {
    /// Refuses a number that stands for no variant.
    #[must_use]
    pub fn no_variant(&self, number: u64) -> SnapshotError {
        self.fault(Fault::NoVariant(number))
    }
}

#[cfg(test)]
mod tests;
