//! The length of a vector.

use nalgebra::{Dim, Matrix, Storage};

/// Euclidean length.
///
/// nalgebra's `norm` takes the root by libm, so that all functions have the same bits everywhere;
/// in WebAssembly libm computes it digit by digit, which takes twenty times as long as the
/// instruction. IEEE 754 demands a correctly rounded root, so the instruction gives the same bits.
pub trait Length {
    /// The square root of the sum of squares.
    #[must_use]
    fn length(&self) -> f64;
}

impl<R: Dim, C: Dim, S: Storage<f64, R, C>> Length for Matrix<f64, R, C, S> {
    #[inline]
    fn length(&self) -> f64 {
        self.norm_squared().sqrt()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Vector2, Vector3};

    use super::*;

    #[test]
    fn triangles_with_whole_sides_have_whole_lengths() {
        assert_eq!(Vector2::new(3.0, -4.0).length(), 5.0);
        assert_eq!(Vector3::new(2.0, 3.0, 6.0).length(), 7.0);
        assert_eq!(Vector2::<f64>::zeros().length(), 0.0);
        assert!(Vector2::new(f64::NAN, 1.0).length().is_nan());
    }
}
