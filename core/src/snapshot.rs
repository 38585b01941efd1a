//! The state of a value as bytes, and back to the bit.
//!
//! In: a value. Out: bytes that are the same on every machine; and from such bytes the value, or
//! what is wrong and where. The layout has no names and no lengths beside those of lists: what the
//! bytes mean is said by the code that reads them, so that whoever writes a file of them puts a
//! version before them.
//!
//! | value | bytes |
//! |---|---|
//! | whole number | 7 bits a byte, the lowest first, the highest bit set on all but the last (LEB128) |
//! | number | IEEE 754, lowest byte first; one that is not finite is refused |
//! | truth | 0 or 1 |
//! | list | its length, then its entries |
//! | what may be missing | 0, or 1 and the value |
//! | structure | its fields in the order in which [`snapshot!`] names them |
//!
//! Bytes come from files, so that nothing in them is trusted: no length is reserved before the
//! entries are there, and a structure may have a rule that what was read has to keep. A crate for
//! such formats (`postcard`) would tell neither the place nor the reason of a fault, and a field
//! that somebody adds would be forgotten without a word; [`snapshot!`] does not compile then.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;

use nalgebra::{Point2, SMatrix, Vector2};

use crate::geom::{Pose2, PoseEstimate};
use crate::robot::{Odometry, Stamp};

/// A value that can be written and read again.
pub trait Snapshot: Sized {
    /// Appends its bytes.
    fn write(&self, out: &mut Vec<u8>);

    /// Takes its bytes from the front of what is left.
    ///
    /// # Errors    [`SnapshotError`]: what is wrong, and where.
    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError>;
}

/// What is wrong with the bytes of a value.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{fault} (byte {at} of the content)", Path(.path))]
pub struct SnapshotError {
    /// Fields and numbers of entries that lead there, the innermost first.
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
    /// The same, of what is `field` of something larger.
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

/// What is left of the bytes.
#[derive(Debug)]
pub struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

/// Entries for which memory is reserved before they are read.
const RESERVED: usize = 1024;

impl<'a> Reader<'a> {
    /// At the first of them.
    #[must_use]
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// Reads what is `name` of something larger.
    ///
    /// # Errors    [`SnapshotError`].
    pub fn field<T: Snapshot>(&mut self, name: &'static str) -> Result<T, SnapshotError> {
        T::read(self).map_err(|error| error.within(name))
    }

    /// Refuses what was read last, for it breaks a rule.
    #[must_use]
    pub fn refuse(&self, why: impl Into<String>) -> SnapshotError {
        self.fault(Fault::Rule(why.into()))
    }

    /// Refuses what was read last where `is_kept` is false.
    ///
    /// # Errors    [`SnapshotError`] with the `rule`.
    pub fn rule(&self, is_kept: bool, rule: &str) -> Result<(), SnapshotError> {
        match is_kept {
            true => Ok(()),
            false => Err(self.refuse(rule)),
        }
    }

    /// Whether nothing is left.
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

    /// The length of a list; each entry takes a byte at least.
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

/// A structure as its fields, in this order; `rule` says what values that were read have to keep.
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

/// Names without content, as their numbers.
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
    /// Refuses a number that stands for nothing.
    #[must_use]
    pub fn no_variant(&self, number: u64) -> SnapshotError {
        self.fault(Fault::NoVariant(number))
    }
}

impl Snapshot for u64 {
    fn write(&self, out: &mut Vec<u8>) {
        let mut rest = *self;
        while rest >= 0x80 {
            out.push(rest as u8 | 0x80);
            rest >>= 7;
        }
        out.push(rest as u8);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        let mut value = 0_u64;
        for shift in (0..).step_by(7) {
            let [byte] = from.take()?;
            let bits = Self::from(byte & 0x7f);
            if shift > 63 || bits << shift >> shift != bits {
                return Err(from.fault(Fault::TooLarge));
            }
            value |= bits << shift;
            if byte < 0x80 {
                break;
            }
        }
        Ok(value)
    }
}

impl Snapshot for usize {
    fn write(&self, out: &mut Vec<u8>) {
        (*self as u64).write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        Self::try_from(u64::read(from)?).map_err(|_| from.fault(Fault::TooLarge))
    }
}

impl Snapshot for u32 {
    fn write(&self, out: &mut Vec<u8>) {
        u64::from(*self).write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        Self::try_from(u64::read(from)?).map_err(|_| from.fault(Fault::TooLarge))
    }
}

impl Snapshot for u8 {
    fn write(&self, out: &mut Vec<u8>) {
        out.push(*self);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        let [byte] = from.take()?;
        Ok(byte)
    }
}

impl Snapshot for i32 {
    fn write(&self, out: &mut Vec<u8>) {
        out.extend(self.to_le_bytes());
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        from.take().map(Self::from_le_bytes)
    }
}

impl Snapshot for bool {
    fn write(&self, out: &mut Vec<u8>) {
        out.push(u8::from(*self));
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        match u8::read(from)? {
            0 => Ok(false),
            1 => Ok(true),
            other => Err(from.fault(Fault::NoVariant(other.into()))),
        }
    }
}

impl Snapshot for f64 {
    fn write(&self, out: &mut Vec<u8>) {
        out.extend(self.to_le_bytes());
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        let value = from.take().map(Self::from_le_bytes)?;
        match value.is_finite() {
            true => Ok(value),
            false => Err(from.fault(Fault::NotFinite)),
        }
    }
}

impl Snapshot for f32 {
    fn write(&self, out: &mut Vec<u8>) {
        out.extend(self.to_le_bytes());
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        let value = from.take().map(Self::from_le_bytes)?;
        match value.is_finite() {
            true => Ok(value),
            false => Err(from.fault(Fault::NotFinite)),
        }
    }
}

impl Snapshot for String {
    fn write(&self, out: &mut Vec<u8>) {
        self.len().write(out);
        out.extend(self.as_bytes());
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        Self::from_utf8(from.entries()?).map_err(|_| from.refuse("a text is not UTF-8"))
    }
}

impl<T: Snapshot> Snapshot for Option<T> {
    fn write(&self, out: &mut Vec<u8>) {
        self.is_some().write(out);
        if let Some(value) = self {
            value.write(out);
        }
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        bool::read(from)?.then(|| T::read(from)).transpose()
    }
}

impl<T: Snapshot> Snapshot for Vec<T> {
    fn write(&self, out: &mut Vec<u8>) {
        self.len().write(out);
        self.iter().for_each(|entry| entry.write(out));
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        from.entries()
    }
}

impl<T: Snapshot> Snapshot for VecDeque<T> {
    fn write(&self, out: &mut Vec<u8>) {
        self.len().write(out);
        self.iter().for_each(|entry| entry.write(out));
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        Ok(from.entries()?.into())
    }
}

impl<K: Snapshot + Ord, V: Snapshot> Snapshot for BTreeMap<K, V> {
    fn write(&self, out: &mut Vec<u8>) {
        self.len().write(out);
        for (key, value) in self {
            key.write(out);
            value.write(out);
        }
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        let entries: Vec<(K, V)> = from.entries()?;
        let rises = entries.windows(2).all(|pair| pair[0].0 < pair[1].0);
        from.rule(rises, "the keys of a table do not rise")?;
        Ok(entries.into_iter().collect())
    }
}

impl<A: Snapshot, B: Snapshot> Snapshot for (A, B) {
    fn write(&self, out: &mut Vec<u8>) {
        self.0.write(out);
        self.1.write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        Ok((A::read(from)?, B::read(from)?))
    }
}

impl<T: Snapshot, const N: usize> Snapshot for [T; N] {
    fn write(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|entry| entry.write(out));
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        let mut list = Vec::with_capacity(N);
        for _ in 0..N {
            list.push(T::read(from)?);
        }
        let array = list.try_into();
        array.map_err(|_| from.fault(Fault::Ends))
    }
}

impl<const R: usize, const C: usize> Snapshot for SMatrix<f64, R, C> {
    fn write(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|value| value.write(out));
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        let mut matrix = SMatrix::zeros();
        for value in &mut matrix {
            *value = f64::read(from)?;
        }
        Ok(matrix)
    }
}

impl Snapshot for Point2<f64> {
    fn write(&self, out: &mut Vec<u8>) {
        self.coords.write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        Vector2::read(from).map(Self::from)
    }
}

/// A cosine and a sine are those of one angle to within this.
const ROUNDING: f64 = 1e-6;

/// Farther from the origin than this, m, nothing lies.
const FARTHEST: f64 = 1e8;

impl Snapshot for Pose2 {
    fn write(&self, out: &mut Vec<u8>) {
        let (cos, sin) = self.cos_sin();
        [self.x(), self.y(), cos, sin].write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        let [x, y, cos, sin] = <[f64; 4]>::read(from)?;
        let is_turn = (cos * cos + sin * sin - 1.0).abs() < ROUNDING;
        from.rule(is_turn, "a cosine and a sine belong to no angle")?;
        let is_near = x.abs().max(y.abs()) < FARTHEST;
        from.rule(is_near, "a place is too far away")?;
        Ok(Self::from_cos_sin(x, y, cos, sin))
    }
}

impl Snapshot for Stamp {
    fn write(&self, out: &mut Vec<u8>) {
        self.0.write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        u64::read(from).map(Self)
    }
}

snapshot!(PoseEstimate { pose, cov });
snapshot!(Odometry {
    from,
    to,
    motion,
    cov
});

#[cfg(test)]
mod tests;
