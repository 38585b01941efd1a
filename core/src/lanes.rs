//! Works on four numbers at a time, with the widest instructions of the machine.
//!
//! 1. [`Lanes`] is the set of operations on four numbers. Each is an IEEE 754 operation, rounded
//!    lane by lane (no fused multiply-add): the same bits on every machine.
//! 2. `wide::f64x4` is the form that every target has: two instructions of 128 bits where the
//!    compiler knows of no wider ones, as in the browser and in the usual build for x86-64.
//! 3. `Avx` is one instruction of 256 bits, for machines that are found at run time to have it.
//! 4. A [`Kernel`] is a loop written once for both; [`run`] picks one.

mod eight;

pub(crate) use eight::{EIGHT, Eight, total as total_of_eight};

use std::ops::{Add, AddAssign, Div, Mul, Sub, SubAssign};

use wide::{f32x8, f64x4, i32x8};

/// How many numbers are worked on at a time.
pub(crate) const LANES: usize = 4;

/// Four numbers.
pub(crate) trait Lanes:
    Copy
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + SubAssign
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// Proof that the machine has the instructions.
    type Machine: Copy;

    /// Eight numbers of single precision by the same instructions.
    type Eight: Eight<Machine = Self::Machine>;

    /// The same number four times.
    fn splat(machine: Self::Machine, value: f64) -> Self;

    /// Four numbers side by side.
    fn load(machine: Self::Machine, values: &[f64; LANES]) -> Self;

    fn to_array(self) -> [f64; LANES];

    /// The last number of `before`, then the first three of these.
    fn after(self, before: Self) -> Self;

    fn abs(self) -> Self;

    fn sqrt(self) -> Self;

    /// The greater of two, neither NaN.
    fn or_greater(self, other: Self) -> Self;

    /// The lesser of two, neither NaN.
    fn or_lesser(self, other: Self) -> Self;

    /// `yes` where `self` is greater than `other`, else `no`.
    fn where_greater(self, other: Self, yes: Self, no: Self) -> Self;

    /// Adds `by` to those of eight numbers whose bit is set, and raises all to at least `least`.
    /// Returns which equal `least` afterwards.
    fn add_where(
        machine: Self::Machine,
        numbers: &mut [f32; 8],
        bits: u8,
        by: f32,
        least: f32,
    ) -> u8;
}

/// The bit of each of eight lanes.
const EIGHT_BITS: [i32; 8] = [1, 2, 4, 8, 16, 32, 64, 128];

/// A loop over numbers, four at a time.
pub(crate) trait Kernel {
    /// The result of the loop.
    type Output;

    /// The loop itself; it must be `#[inline(always)]`, or it is not compiled for the wider
    /// instructions.
    fn run<L: Lanes>(self, machine: L::Machine) -> Self::Output;
}

/// Runs a loop with the widest instructions that the machine has.
#[inline(always)]
pub(crate) fn run<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(all(target_arch = "x86_64", not(feature = "narrow")))]
    if let Some(machine) = pulp::x86::V3::try_new() {
        return machine.vectorize(OnAvx { kernel, machine });
    }
    kernel.run::<f64x4>(())
}

/// Runs code that the compiler vectorises by itself, with the widest instructions that the machine
/// has.
#[inline(always)]
pub(crate) fn widened<F: pulp::NullaryFnOnce>(work: F) -> F::Output {
    if cfg!(feature = "narrow") {
        work.call()
    } else {
        pulp::Arch::new().dispatch(work)
    }
}

/// The sum of the lanes, added in the same order on every machine.
#[inline(always)]
pub(crate) fn total(lanes: impl Lanes) -> f64 {
    let [a, b, c, d] = lanes.to_array();
    (a + b) + (c + d)
}

/// The greatest of the lanes.
#[inline(always)]
pub(crate) fn greatest(lanes: impl Lanes) -> f64 {
    let [a, b, c, d] = lanes.to_array();
    // `f64::max` also checks for NaN, of which there is none.
    let greater = |a: f64, b: f64| if a > b { a } else { b };
    greater(greater(a, b), greater(c, d))
}

/// The least of the lanes.
#[inline(always)]
pub(crate) fn least(lanes: impl Lanes) -> f64 {
    let [a, b, c, d] = lanes.to_array();
    let lesser = |a: f64, b: f64| if a < b { a } else { b };
    lesser(lesser(a, b), lesser(c, d))
}

impl Lanes for f64x4 {
    type Machine = ();
    type Eight = f32x8;

    #[inline(always)]
    fn splat((): (), value: f64) -> Self {
        Self::splat(value)
    }

    #[inline(always)]
    fn load((): (), values: &[f64; LANES]) -> Self {
        Self::new(*values)
    }

    #[inline(always)]
    fn to_array(self) -> [f64; LANES] {
        self.to_array()
    }

    #[inline(always)]
    fn after(self, before: Self) -> Self {
        let ([a, b, c, _], [.., last]) = (self.to_array(), before.to_array());
        Self::new([last, a, b, c])
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn or_greater(self, other: Self) -> Self {
        self.fast_max(other)
    }

    #[inline(always)]
    fn or_lesser(self, other: Self) -> Self {
        self.fast_min(other)
    }

    #[inline(always)]
    fn where_greater(self, other: Self, yes: Self, no: Self) -> Self {
        self.simd_gt(other).select(yes, no)
    }

    #[inline(always)]
    fn add_where((): (), numbers: &mut [f32; 8], bits: u8, by: f32, least: f32) -> u8 {
        let own = i32x8::new(EIGHT_BITS);
        let is_set: f32x8 = pulp::cast((i32x8::splat(i32::from(bits)) & own).simd_eq(own));
        let least = f32x8::splat(least);
        let sum = f32x8::new(*numbers) + (is_set & f32x8::splat(by));
        let lifted = sum.fast_max(least);
        *numbers = lifted.to_array();
        lifted.simd_le(least).to_bitmask() as u8
    }
}

#[cfg(all(target_arch = "x86_64", not(feature = "narrow")))]
use avx::OnAvx;

#[cfg(all(target_arch = "x86_64", not(feature = "narrow")))]
mod avx {
    use pulp::{NullaryFnOnce, f64x4, x86::V3};

    use super::eight::EightOnAvx;
    use super::*;

    /// Four numbers in a register of 256 bits, and the proof that the machine has such registers.
    #[derive(Clone, Copy)]
    pub(super) struct Avx {
        lanes: f64x4,
        machine: V3,
    }

    /// A kernel on a machine with such registers.
    pub(super) struct OnAvx<K> {
        pub(super) kernel: K,
        pub(super) machine: V3,
    }

    impl<K: Kernel> NullaryFnOnce for OnAvx<K> {
        type Output = K::Output;

        #[inline(always)]
        fn call(self) -> K::Output {
            self.kernel.run::<Avx>(self.machine)
        }
    }

    impl Avx {
        #[inline(always)]
        fn with(self, lanes: f64x4) -> Self {
            Self { lanes, ..self }
        }
    }

    impl Lanes for Avx {
        type Machine = V3;
        type Eight = EightOnAvx;

        #[inline(always)]
        fn splat(machine: V3, value: f64) -> Self {
            let lanes = machine.splat_f64x4(value);
            Self { lanes, machine }
        }

        #[inline(always)]
        fn load(machine: V3, values: &[f64; LANES]) -> Self {
            // Not field by field: that would take four instructions, and four more in `to_array`.
            let lanes = pulp::cast(*values);
            Self { lanes, machine }
        }

        #[inline(always)]
        fn to_array(self) -> [f64; LANES] {
            pulp::cast(self.lanes)
        }

        #[inline(always)]
        fn after(self, before: Self) -> Self {
            let (own, before) = (pulp::cast(self.lanes), pulp::cast(before.lanes));
            let avx = self.machine.avx;
            let middle = avx._mm256_permute2f128_pd::<0x21>(before, own);
            self.with(pulp::cast(avx._mm256_shuffle_pd::<0b0101>(middle, own)))
        }

        #[inline(always)]
        fn abs(self) -> Self {
            self.with(self.machine.abs_f64x4(self.lanes))
        }

        #[inline(always)]
        fn sqrt(self) -> Self {
            self.with(self.machine.sqrt_f64x4(self.lanes))
        }

        #[inline(always)]
        fn or_greater(self, other: Self) -> Self {
            self.with(self.machine.max_f64x4(self.lanes, other.lanes))
        }

        #[inline(always)]
        fn or_lesser(self, other: Self) -> Self {
            self.with(self.machine.min_f64x4(self.lanes, other.lanes))
        }

        #[inline(always)]
        fn where_greater(self, other: Self, yes: Self, no: Self) -> Self {
            let is_greater = self.machine.cmp_gt_f64x4(self.lanes, other.lanes);
            self.with(self.machine.select_f64x4(is_greater, yes.lanes, no.lanes))
        }

        #[inline(always)]
        fn add_where(machine: V3, numbers: &mut [f32; 8], bits: u8, by: f32, least: f32) -> u8 {
            let V3 { avx, avx2, .. } = machine;
            let own = pulp::cast(EIGHT_BITS);
            let bits = avx._mm256_set1_epi32(i32::from(bits));
            let is_set = avx2._mm256_cmpeq_epi32(avx2._mm256_and_si256(bits, own), own);
            let by = avx._mm256_and_ps(pulp::cast(is_set), avx._mm256_set1_ps(by));
            let least = avx._mm256_set1_ps(least);
            let sum = avx._mm256_add_ps(pulp::cast(*numbers), by);
            let lifted = avx._mm256_max_ps(sum, least);
            *numbers = pulp::cast(lifted);
            // Less or equal, ordered and quiet.
            let is_least = avx._mm256_cmp_ps::<0x12>(lifted, least);
            avx._mm256_movemask_ps(is_least) as u8
        }
    }

    impl AddAssign for Avx {
        #[inline(always)]
        fn add_assign(&mut self, other: Self) {
            *self = *self + other;
        }
    }

    impl SubAssign for Avx {
        #[inline(always)]
        fn sub_assign(&mut self, other: Self) {
            *self = *self - other;
        }
    }

    macro_rules! operators {
        ($($operator:ident $method:ident $of_machine:ident),+) => { $(
            impl $operator for Avx {
                type Output = Self;

                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    self.with(self.machine.$of_machine(self.lanes, other.lanes))
                }
            }
        )+ };
    }

    operators!(Add add add_f64x4, Sub sub sub_f64x4, Mul mul mul_f64x4, Div div div_f64x4);
}

#[cfg(test)]
mod tests;
