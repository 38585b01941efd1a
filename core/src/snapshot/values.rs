//! The bytes of numbers, lists, matrices and geometric values in the plane.

use std::collections::{BTreeMap, VecDeque};

use nalgebra::{Point2, SMatrix, Vector2};

use super::{Fault, Reader, Snapshot, SnapshotError, snapshot};
use crate::geom::{Pose2, PoseEstimate};
use crate::robot::{Odometry, Stamp};

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

macro_rules! whole_number {
    ($kind:ty) => {
        impl Snapshot for $kind {
            fn write(&self, out: &mut Vec<u8>) {
                (*self as u64).write(out);
            }

            fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
                Self::try_from(u64::read(from)?).map_err(|_| from.fault(Fault::TooLarge))
            }
        }
    };
}
whole_number!(usize);
whole_number!(u32);

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

macro_rules! finite_number {
    ($kind:ty) => {
        impl Snapshot for $kind {
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
    };
}
finite_number!(f64);
finite_number!(f32);

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

/// A cosine and a sine belong to one angle if their squares sum to 1 within this.
const ROUNDING: f64 = 1e-6;

/// Greatest distance from the origin, m.
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
