//! The exponential of what is not positive, as arithmetic that compilers make wide.
//!
//! exp(x) = 2^k exp(r) with k the whole number nearest to x log₂e; exp(r) by its Taylor series, 2^k
//! by its bits. What is too small for a normal number comes out as the smallest one or so, never as
//! a denormal, which would cost a hundred times as much.

use std::f32::consts::LN_2;
use std::f64::consts::LOG2_E;

/// exp(x) for x ≤ 0, to a relative error of 1e-14.
#[inline(always)]
pub(super) fn exp_f64(x: f64) -> f64 {
    /// What is added ends in the whole number: its last bit counts 1.
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

/// 2^-x for x ≥ 0, to a relative error of 3e-7: fewer steps than exp, where exponents can be scaled
/// beforehand. Step by step for all of them, or compilers do not make it wide.
#[inline(always)]
pub(in crate::registration) fn exp2_of_minus<const N: usize>(x: &[f32; N]) -> [f32; N] {
    const ROUND: f32 = 12_582_912.0;
    /// 2^r = 1 + r (ln 2 + b r + …) for |r| ≤ ½: of all of this degree that begin so the one whose
    /// relative error, 1e-7, is least (Remez).
    const SERIES: [f32; 4] = [0.009_669_691, 0.055_505_585, 0.240_222_83, LN_2];
    let (mut shifted, mut r) = ([0.0; N], [0.0; N]);
    for at in 0..N {
        let x = if x[at] > 125.0 { 125.0 } else { x[at] };
        shifted[at] = ROUND - x;
        r[at] = (ROUND - shifted[at]) - x;
    }
    let mut series = [0.001_330_059_4; N];
    for factor in SERIES {
        for at in 0..N {
            series[at] = series[at] * r[at] + factor;
        }
    }
    let mut found = [0.0; N];
    for at in 0..N {
        let whole = f32::from_bits(shifted[at].to_bits().wrapping_add(127) << 23);
        found[at] = (series[at] * r[at] + 1.0) * whole;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_libraries() {
        for i in 0..20_000 {
            let x = -0.034_7 * f64::from(i);
            let (ours, true_value) = (exp_f64(x), libm::exp(x));
            assert!((ours / true_value - 1.0).abs() < 1e-14, "{x}: {ours}");
            let x = -0.006_25 * f64::from(i);
            if x > -125.0 {
                let single = f64::from(exp2_of_minus(&[-x as f32])[0]);
                let true_value = libm::exp2(f64::from(x as f32));
                assert!((single / true_value - 1.0).abs() < 3e-7, "{x}: {single}");
            }
        }
        assert_eq!(exp_f64(0.0), 1.0);
        assert_eq!(exp2_of_minus(&[0.0]), [1.0]);
        assert!(exp_f64(-1e300) < 1e-303 && exp_f64(f64::NEG_INFINITY).is_normal());
        let small = exp2_of_minus(&[1e30, f32::INFINITY]);
        assert!(small.iter().all(|x| *x < 1e-37 && x.is_normal()));
    }
}
