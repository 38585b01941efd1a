//! TUM trajectories: lines of `seconds x y z qx qy qz qw`, the form that evaluation tools read.
//!
//! In: stamped poses. Out: text, which [`super::poses`] reads. A planar heading θ is the quaternion
//! (0, 0, sin θ/2, cos θ/2).

use std::fmt::Write as _;

use crate::geom::{Pose2, sin_cos};

const COLUMNS: &str = "seconds x y z qx qy qz qw";

/// Writes poses with their stamps in seconds: six decimals for seconds, nine for metres.
#[must_use]
pub fn write(poses: impl IntoIterator<Item = (f64, Pose2)>) -> String {
    let mut text = format!("# {COLUMNS}\n");
    for (seconds, pose) in poses {
        let (sin, cos) = sin_cos(0.5 * pose.heading());
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{seconds:.6} {:.9} {:.9} 0 0 0 {sin:.12} {cos:.12}",
            pose.x(),
            pose.y()
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::poses::read_poses;
    use crate::geom::Length;
    use crate::geom::wrap;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn written_poses_read_back(x in -1e3..1e3_f64, y in -1e3..1e3_f64, t in -4.0..4.0_f64, s in 0.0..1e9_f64) {
            let pose = Pose2::new(x, y, t);
            let back = read_poses(write([(s, pose)]).as_bytes()).unwrap().poses;
            prop_assert!((back[0].0 - s).abs() <= 1e-6);
            prop_assert!((back[0].1.position() - pose.position()).length() < 1e-8);
            prop_assert!(wrap(back[0].1.heading() - t).abs() < 1e-9);
        }
    }

    #[test]
    fn quarter_turn_is_the_known_quaternion() {
        let text = write([(1.5, Pose2::new(1.0, 2.0, std::f64::consts::FRAC_PI_2))]);
        let line = text.lines().nth(1).unwrap();
        assert_eq!(
            line,
            "1.500000 1.000000000 2.000000000 0 0 0 0.707106781187 0.707106781187"
        );
    }
}
