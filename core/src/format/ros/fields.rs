//! The fields of a message in order, as ROS 1 and ROS 2 serialise them.
//!
//! | encoding | numbers | text |
//! |---|---|---|
//! | ROS 1 | little-endian, without padding | length, bytes |
//! | CDR (ROS 2) | byte order given by the header, each aligned to its own size, counted from the end of the header | length, bytes, a zero that the length counts |
//! | XCDR 2 | the same, but eight bytes are aligned to four | the same |
//!
//! Sources: wiki.ros.org/msg (Serialization); OMG DDSI-RTPS 2.5 §10.2 (encapsulation), DDS-XTYPES
//! 1.3 §7.4 (both versions of CDR).

/// How a message is serialised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// That of ROS 1.
    Ros1,
    /// That of ROS 2, with its header of four bytes.
    Cdr,
}

/// Why a message cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum FieldsError {
    /// The message ends too early, or a length in it is wrong.
    #[error("`{field}` needs {needed} bytes at byte {at}, and the message has {length} bytes")]
    Short {
        /// The field.
        field: &'static str,
        /// Place in the message.
        at: usize,
        /// Bytes that the field takes.
        needed: usize,
        /// Bytes of the message.
        length: usize,
    },
    /// The header names an encoding that is not plain data.
    #[error(
        "the head of the CDR is {0:02x?}; expected 00 00 or 00 01 (CDR), or 00 06 or 00 07 (XCDR 2)"
    )]
    Head([u8; 2]),
}

/// Length of the CDR header.
const HEAD: usize = 4;

/// Reads fields.
#[derive(Debug)]
pub(super) struct Fields<'a> {
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
    is_big_endian: bool,
    /// The largest alignment.
    most: usize,
}

impl<'a> Fields<'a> {
    pub(super) fn new(bytes: &'a [u8], encoding: Encoding) -> Result<Self, FieldsError> {
        let mut fields = Self {
            bytes,
            at: 0,
            encoding,
            is_big_endian: false,
            most: 8,
        };
        if encoding == Encoding::Cdr {
            let [a, b, ..] = fields.array::<HEAD>("head", 1)?;
            (fields.is_big_endian, fields.most) = match [a, b] {
                [0, 0] => (true, 8),
                [0, 1] => (false, 8),
                [0, 6] => (true, 4),
                [0, 7] => (false, 4),
                other => return Err(FieldsError::Head(other)),
            };
        }
        Ok(fields)
    }

    /// Whether message headers have a sequence number before the stamp.
    pub(super) fn has_sequence(&self) -> bool {
        self.encoding == Encoding::Ros1
    }

    pub(super) fn u32(&mut self, field: &'static str) -> Result<u32, FieldsError> {
        let bytes = self.array(field, 4)?;
        Ok(match self.is_big_endian {
            true => u32::from_be_bytes(bytes),
            false => u32::from_le_bytes(bytes),
        })
    }

    pub(super) fn f32(&mut self, field: &'static str) -> Result<f32, FieldsError> {
        Ok(f32::from_bits(self.u32(field)?))
    }

    pub(super) fn f64(&mut self, field: &'static str) -> Result<f64, FieldsError> {
        let bytes = self.array(field, 8)?;
        Ok(match self.is_big_endian {
            true => f64::from_be_bytes(bytes),
            false => f64::from_le_bytes(bytes),
        })
    }

    pub(super) fn f64s<const N: usize>(
        &mut self,
        field: &'static str,
    ) -> Result<[f64; N], FieldsError> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.f64(field)?;
        }
        Ok(values)
    }

    /// Number of elements of a list, each of at least `least` bytes: the remaining bytes must be
    /// able to hold them.
    pub(super) fn count(
        &mut self,
        field: &'static str,
        least: usize,
    ) -> Result<usize, FieldsError> {
        let count = self.u32(field)? as usize;
        let needed = count.saturating_mul(least);
        match needed <= self.bytes.len().saturating_sub(self.at) {
            true => Ok(count),
            false => Err(self.short(field, needed)),
        }
    }

    pub(super) fn f32s(&mut self, field: &'static str) -> Result<Vec<f32>, FieldsError> {
        let count = self.count(field, 4)?;
        (0..count).map(|_| self.f32(field)).collect()
    }

    /// Bytes that are not UTF-8 are replaced: a name has to be shown, and must be the same each
    /// time.
    pub(super) fn text(&mut self, field: &'static str) -> Result<String, FieldsError> {
        let count = self.count(field, 1)?;
        let bytes = self.take(field, count)?;
        let bytes = match self.encoding {
            Encoding::Ros1 => bytes,
            Encoding::Cdr => bytes.strip_suffix(&[0]).unwrap_or(bytes),
        };
        Ok(String::from_utf8_lossy(bytes).into_owned())
    }

    fn array<const N: usize>(
        &mut self,
        field: &'static str,
        alignment: usize,
    ) -> Result<[u8; N], FieldsError> {
        if self.encoding == Encoding::Cdr && alignment > 1 {
            // Counted from the end of the header.
            let behind = self.at - HEAD;
            self.at = HEAD + behind.next_multiple_of(alignment.min(self.most));
        }
        let bytes = self.take(field, N)?;
        match bytes.first_chunk() {
            Some(bytes) => Ok(*bytes),
            None => Err(self.short(field, N)),
        }
    }

    fn take(&mut self, field: &'static str, count: usize) -> Result<&'a [u8], FieldsError> {
        let end = self.at.saturating_add(count);
        let Some(bytes) = self.bytes.get(self.at..end) else {
            return Err(self.short(field, count));
        };
        self.at = end;
        Ok(bytes)
    }

    fn short(&self, field: &'static str, needed: usize) -> FieldsError {
        FieldsError::Short {
            field,
            at: self.at,
            needed,
            length: self.bytes.len(),
        }
    }
}
