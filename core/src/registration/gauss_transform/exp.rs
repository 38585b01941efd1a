//! The exponential of non-positive numbers, as arithmetic that compilers vectorise.
//!
//! exp(x) = 2^k exp(r) with k the integer nearest to x log₂e; exp(r) by its Taylor series, 2^k by
//! its bits. A result too small for a normal number becomes about the smallest one, never a
//! denormal, which would cost a hundred times as much.

use std::f32::consts::LN_2;
use std::f64::consts::LOG2_E;

use crate::lanes::Eight;

/// exp(x) for x ≤ 0, to a relative error of 1e-14.
#[inline(always)]
pub(super) fn exp_f64(x: f64) -> f64 {
    /// Adding this rounds to an integer: its last bit counts 1.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    // ln 2 in two parts, so that k ln 2 is exact in the first.
    const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
    const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    let x = if x < -700.0 { -700.0 } else { x };
    let shifted = x * LOG2_E + ROUND;
    let whole = shifted - ROUND;
    let r = (x - whole * LN2_HIGH) - whole * LN2_LOW;
    let mut series = 1.0 / 479_001_600.0;
    for factorial in [
        39_916_800.0,
        3_628_800.0,
        362_880.0,
        40_320.0,
        5_040.0,
        720.0,
        120.0,
        24.0,
        6.0,
        2.0,
        1.0,
        1.0,
    ] {
        series = series * r + 1.0 / factorial;
    }
    series * f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52)
}

/// 2^-x for x ≥ 0, to a relative error of 3e-7. It takes fewer steps than exp, where exponents can
/// be scaled beforehand.
#[inline(always)]
pub(in crate::registration) fn exp2_of_minus<E: Eight>(machine: E::Machine, x: E) -> E {
    const ROUND: f32 = 12_582_912.0;
    /// 2^r = 1 + r (ln 2 + b r + …) for |r| ≤ ½: of all polynomials of this degree that begin so,
    /// the one with the least relative error, 1e-7 (Remez).
    const SERIES: [f32; 4] = [0.009_669_691, 0.055_505_585, 0.240_222_83, LN_2];
    let splat = |value| E::splat(machine, value);
    let x = x.or_lesser(splat(125.0));
    let shifted = splat(ROUND) - x;
    let r = (splat(ROUND) - shifted) - x;
    let mut series = splat(0.001_330_059_4);
    for factor in SERIES {
        series = series * r + splat(factor);
    }
    (series * r + splat(1.0)) * shifted.two_to_whole()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{self, EIGHT, Kernel, Lanes};

    struct Exp2([f32; EIGHT]);

    impl Kernel for Exp2 {
        type Output = [f32; EIGHT];

        #[inline(always)]
        fn run<L: Lanes>(self, machine: L::Machine) -> [f32; EIGHT] {
            exp2_of_minus(machine, L::Eight::load(machine, &self.0)).to_array()
        }
    }

    /// 2^-x.
    fn exp2_of_minus_one(x: f32) -> f32 {
        lanes::run(Exp2([x; EIGHT]))[0]
    }

    #[test]
    fn agrees_with_the_libraries() {
        for i in 0..20_000 {
            let x = -0.034_7 * f64::from(i);
            let (ours, true_value) = (exp_f64(x), libm::exp(x));
            assert!((ours / true_value - 1.0).abs() < 1e-14, "{x}: {ours}");
            let x = -0.006_25 * f64::from(i);
            if x > -125.0 {
                let single = f64::from(exp2_of_minus_one(-x as f32));
                let true_value = libm::exp2(f64::from(x as f32));
                assert!((single / true_value - 1.0).abs() < 3e-7, "{x}: {single}");
            }
        }
        assert_eq!(exp_f64(0.0), 1.0);
        assert_eq!(exp2_of_minus_one(0.0), 1.0);
        assert!(exp_f64(-1e300) < 1e-303 && exp_f64(f64::NEG_INFINITY).is_normal());
        let small = [1e30, f32::INFINITY].map(exp2_of_minus_one);
        assert!(small.iter().all(|x| *x < 1e-37 && x.is_normal()));
    }
}
