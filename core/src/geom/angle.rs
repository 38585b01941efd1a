//! The only place that wraps angles.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector2;

/// Wraps an angle to (-π, π].
///
/// # Units    `angle`: rad, up to a thousand million turns either way; beyond that a double has too
/// few digits left for the direction. NaN if `angle` is not finite.
/// # Example
/// ```
/// use std::f64::consts::PI;
/// assert_eq!(slamlab_core::geom::wrap(-PI), PI);
/// assert_eq!(slamlab_core::geom::wrap(0.5), 0.5);
/// ```
#[inline]
#[must_use]
pub fn wrap(angle: f64) -> f64 {
    // Nearly every angle is already in range; leave those bits alone.
    if angle > -PI && angle <= PI {
        return angle;
    }
    let wrapped = angle - TAU * ((angle + PI) / TAU).floor();
    // `wrapped` lies in [-π, π] up to rounding; -π itself belongs to the other end.
    if wrapped <= -PI {
        wrapped + TAU
    } else if wrapped > PI {
        wrapped - TAU
    } else {
        wrapped
    }
}

/// Sine and cosine through `libm`, so that native and browser runs agree to the bit.
#[inline]
#[must_use]
pub fn sin_cos(angle: f64) -> (f64, f64) {
    libm::sincos(angle)
}

/// The vector of length 1 whose angle from the x axis this is.
#[inline]
#[must_use]
pub fn unit_vector(angle: f64) -> Vector2<f64> {
    let (sin, cos) = sin_cos(angle);
    Vector2::new(cos, sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn wrapped_angle_is_in_range_and_points_the_same_way(angle in -1e4..1e4_f64) {
            let wrapped = wrap(angle);
            prop_assert!(wrapped > -PI && wrapped <= PI);
            prop_assert!((libm::sin(wrapped) - libm::sin(angle)).abs() < 1e-9);
            prop_assert!((libm::cos(wrapped) - libm::cos(angle)).abs() < 1e-9);
        }
    }

    #[test]
    fn ends_of_the_range() {
        for (angle, expect) in [
            (PI, PI),
            (-PI, PI),
            (3.0 * PI, PI),
            (-3.0 * PI, PI),
            (0.0, 0.0),
        ] {
            assert!(
                (wrap(angle) - expect).abs() < 1e-12,
                "wrap({angle}) = {}",
                wrap(angle)
            );
        }
        assert!(wrap(f64::NAN).is_nan());
        assert!(wrap(f64::INFINITY).is_nan());
    }
}
