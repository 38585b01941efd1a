//! Eight numbers of single precision, as `lanes` has four of double precision: for cases with so
//! many numbers that a relative error of 1e-7 in each does not matter in their sum.

use std::ops::{Add, AddAssign, Mul, Sub};

use wide::{f32x8, i32x8};

/// How many numbers are worked on at a time.
pub(crate) const EIGHT: usize = 8;

/// Added to the whole number left in the last bits of a sum with [`ROUND`], it gives an exponent.
const BIAS: i32 = 127;
/// Number of bits of a fraction.
const FRACTION: i32 = 23;

/// Eight numbers.
pub(crate) trait Eight:
    Copy + Add<Output = Self> + AddAssign + Sub<Output = Self> + Mul<Output = Self>
{
    /// Proof that the machine has the instructions.
    type Machine: Copy;

    /// The same number eight times.
    fn splat(machine: Self::Machine, value: f32) -> Self;

    /// Eight numbers side by side.
    fn load(machine: Self::Machine, values: &[f32; EIGHT]) -> Self;

    fn to_array(self) -> [f32; EIGHT];

    /// The lesser of two, neither NaN.
    fn or_lesser(self, other: Self) -> Self;

    /// 2^k, where these numbers are 1.5 * 2^23 + k and so hold the whole number k, from -126 to
    /// 127, in their last bits.
    fn two_to_whole(self) -> Self;
}

/// The sum of all eight, added in the same order on every machine.
#[inline(always)]
pub(crate) fn total(numbers: impl Eight) -> f32 {
    let [a, b, c, d, e, f, g, h] = numbers.to_array();
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

impl Eight for f32x8 {
    type Machine = ();

    #[inline(always)]
    fn splat((): (), value: f32) -> Self {
        Self::splat(value)
    }

    #[inline(always)]
    fn load((): (), values: &[f32; EIGHT]) -> Self {
        Self::new(*values)
    }

    #[inline(always)]
    fn to_array(self) -> [f32; EIGHT] {
        self.to_array()
    }

    #[inline(always)]
    fn or_lesser(self, other: Self) -> Self {
        self.fast_min(other)
    }

    #[inline(always)]
    fn two_to_whole(self) -> Self {
        let bits: i32x8 = pulp::cast(self);
        pulp::cast((bits + i32x8::splat(BIAS)) << FRACTION)
    }
}

#[cfg(all(target_arch = "x86_64", not(feature = "narrow")))]
pub(super) use avx::EightOnAvx;

#[cfg(all(target_arch = "x86_64", not(feature = "narrow")))]
mod avx {
    use pulp::{f32x8, x86::V3};

    use super::*;

    /// Eight numbers in a register of 256 bits, and the proof that the machine has such registers.
    #[derive(Clone, Copy)]
    pub(in crate::lanes) struct EightOnAvx {
        numbers: f32x8,
        machine: V3,
    }

    impl EightOnAvx {
        #[inline(always)]
        fn with(self, numbers: f32x8) -> Self {
            Self { numbers, ..self }
        }
    }

    impl Eight for EightOnAvx {
        type Machine = V3;

        #[inline(always)]
        fn splat(machine: V3, value: f32) -> Self {
            let numbers = machine.splat_f32x8(value);
            Self { numbers, machine }
        }

        #[inline(always)]
        fn load(machine: V3, values: &[f32; EIGHT]) -> Self {
            let numbers = pulp::cast(*values);
            Self { numbers, machine }
        }

        #[inline(always)]
        fn to_array(self) -> [f32; EIGHT] {
            pulp::cast(self.numbers)
        }

        #[inline(always)]
        fn or_lesser(self, other: Self) -> Self {
            self.with(self.machine.min_f32x8(self.numbers, other.numbers))
        }

        #[inline(always)]
        fn two_to_whole(self) -> Self {
            let V3 { avx, avx2, .. } = self.machine;
            let bias = avx._mm256_set1_epi32(BIAS);
            let biased = avx2._mm256_add_epi32(pulp::cast(self.numbers), bias);
            self.with(pulp::cast(avx2._mm256_slli_epi32::<FRACTION>(biased)))
        }
    }

    impl AddAssign for EightOnAvx {
        #[inline(always)]
        fn add_assign(&mut self, other: Self) {
            *self = *self + other;
        }
    }

    macro_rules! operators {
        ($($operator:ident $method:ident $of_machine:ident),+) => { $(
            impl $operator for EightOnAvx {
                type Output = Self;

                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    self.with(self.machine.$of_machine(self.numbers, other.numbers))
                }
            }
        )+ };
    }

    operators!(Add add add_f32x8, Sub sub sub_f32x8, Mul mul mul_f32x8);
}
