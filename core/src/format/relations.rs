//! `.relations`: reference motions between scans, from scan alignments checked by hand.
//!
//! In: bytes. Out: [`Relation`]s. Lines are `t1 t2 x y z roll pitch yaw`: the pose at t2 in the
//! frame of the pose at t1, metres and radians, `#` starts a comment.
//!
//! Source: Kümmerle et al. (2009), "On measuring the accuracy of SLAM algorithms", Autonomous
//! Robots 27.

use super::FieldError;
use super::rows::rows;
use crate::estimation::StampedMotion;
use crate::geom::Pose2;

/// The true motion between two scans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relation {
    /// `ipc_timestamp` of the first scan, s.
    pub from_seconds: f64,
    /// `ipc_timestamp` of the second scan, s.
    pub to_seconds: f64,
    /// `robot_at_from_from_robot_at_to`.
    pub motion: Pose2,
}

impl Relation {
    /// As [`crate::estimation::relation_errors`] takes it.
    #[must_use]
    pub fn stamped_motion(&self) -> StampedMotion {
        (self.from_seconds, self.to_seconds, self.motion)
    }
}

const COLUMNS: &str = "t1 t2 x y z roll pitch yaw";

/// Why bytes are not relations.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RelationsError {
    /// A row that cannot be read.
    #[error(transparent)]
    Row(#[from] FieldError),
    /// No line at all.
    #[error("no relation in the file; expected lines of {COLUMNS}")]
    Empty,
}

/// Reads relations.
///
/// # Errors   [`RelationsError`], with line and field.
pub fn parse(bytes: &[u8]) -> Result<Vec<Relation>, RelationsError> {
    let relation = |[from_seconds, to_seconds, x, y, _, _, _, yaw]: [f64; 8]| Relation {
        from_seconds,
        to_seconds,
        motion: Pose2::new(x, y, yaw),
    };
    let text = String::from_utf8_lossy(bytes);
    let relations = rows(&text, COLUMNS).map(|row| row.map(relation));
    let relations = relations.collect::<Result<Vec<_>, _>>()?;
    if relations.is_empty() {
        return Err(RelationsError::Empty);
    }
    Ok(relations)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_planar_motions_and_skips_comments() {
        let text = b"# made by hand\n10.5 12.25 1 2 0 0 0 -0.5 # sure\r\n\n";
        let relations = parse(text).unwrap();
        assert_eq!(relations.len(), 1);
        assert!((relations[0].to_seconds - 12.25).abs() < 1e-12);
        assert!((relations[0].motion.heading() + 0.5).abs() < 1e-12);
    }

    #[test]
    fn bad_lines_are_named() {
        let message = |text: &[u8]| parse(text).unwrap_err().to_string();
        assert!(message(b"").starts_with("no relation"));
        assert_eq!(
            message(b"1 2 3\n"),
            "line 1: the number of fields is `3`, expected 8: t1 t2 x y z roll pitch yaw"
        );
        assert_eq!(
            message(b"1 2 3 4 5 6 7 8\n1 2 x 4 5 6 7 8\n"),
            "line 2: field 3 is `x`, expected a finite number"
        );
        assert!(message(b"1 2 3 4 5 6 7 NaN\n").contains("field 8"));
        assert!(message(b"\xff\xd8\xff\x00").contains("line 1"));
    }
}
