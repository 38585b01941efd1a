//! Maps that are laid on another map: submaps (`.smap`) and saved maps (`.slamlab`), recognised by
//! their first bytes, as points.
//!
//! In: bytes. Out: [`MapPoints`], and how many submaps they come from.

use super::known_file::known_file;
use super::slamlab::{self, SlamlabError};
use super::smap::{self, SmapError};
use crate::estimation::{MapPoints, RestoreError, ScanMatcherConfig};

/// A map that was read.
#[derive(Clone, Debug)]
pub struct LoadedMap {
    /// Its walls, the robot's path and its landmarks.
    pub points: MapPoints,
    /// Number of submaps that it is made of.
    pub submaps: usize,
}

/// Why a file is not such a map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LoadedMapError {
    /// Neither of the two kinds.
    #[error(
        "this is {what}, and no map: a map is a submap (.smap), which begins with `#points`, or a saved map (.slamlab)"
    )]
    Foreign {
        /// What it is, if it is recognised.
        what: &'static str,
    },
    /// An invalid submap.
    #[error(transparent)]
    Smap(#[from] SmapError),
    /// An invalid saved map.
    #[error(transparent)]
    Slamlab(#[from] SlamlabError),
    /// A saved map with inconsistent content.
    #[error(transparent)]
    Restore(#[from] RestoreError),
}

/// Reads a map.
///
/// # Errors    [`LoadedMapError`]: what is wrong, and where.
pub fn read(file: &[u8]) -> Result<LoadedMap, LoadedMapError> {
    if !slamlab::begins(file) {
        if let Some(what) = foreign(file) {
            return Err(LoadedMapError::Foreign { what });
        }
        let points = smap::parse(file)?.map_points();
        return Ok(LoadedMap { points, submaps: 1 });
    }
    let saved = slamlab::read(file)?.map;
    let matcher = saved.matcher(ScanMatcherConfig::default())?;
    let way = matcher.trajectory().map(|(_, pose)| pose.position());
    let landmarks = matcher.landmarks().into_iter().map(|found| found.position);
    let made = matcher.submaps().filter(|submap| submap.keyframes > 0);
    Ok(LoadedMap {
        points: MapPoints::of_grid(matcher.grid(), way, landmarks),
        submaps: made.count(),
    })
}

/// What a file is that cannot be a submap; `None` if it may be one.
fn foreign(file: &[u8]) -> Option<&'static str> {
    if let Some(known) = known_file(file) {
        return Some(known.what);
    }
    let text = file.strip_prefix("\u{feff}".as_bytes()).unwrap_or(file);
    match text.trim_ascii_start().first() {
        None => Some("an empty file"),
        Some(b'#') => None,
        Some(_) => Some("a file of another kind"),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;
    use proptest::prelude::*;

    use super::*;
    use crate::estimation::ScanMatcher;
    use crate::format::slamlab::Experiment;
    use crate::format::smap::{LandmarkKind, Smap, SmapLandmark};

    #[test]
    fn both_kinds_are_told_apart_by_their_bytes() {
        let at = Point2::new(1.5, -2.0);
        let smap = Smap {
            points: vec![at; 3],
            path: vec![at],
            landmarks: vec![SmapLandmark {
                at,
                confidence: 2,
                kind: LandmarkKind::Point,
            }],
        };
        let LoadedMap { points, submaps } = read(smap.write().as_bytes()).unwrap();
        assert_eq!(
            (points.walls, points.way, submaps),
            (vec![at; 3], vec![at], 1)
        );
        assert_eq!(points.landmarks, [at]);
        let matcher = ScanMatcher::new(ScanMatcherConfig::default()).unwrap();
        let map = matcher.saved(vec![]);
        let experiment = Experiment {
            map,
            ..Experiment::default()
        };
        let LoadedMap { points, submaps } = read(&slamlab::write(&experiment).unwrap()).unwrap();
        assert!(points.walls.is_empty() && submaps == 0 && points.grid.is_some());
    }

    #[test]
    fn what_is_wrong_is_said_in_the_words_of_its_kind() {
        let text = read(b"#points\n2\n1, 2\n").unwrap_err().to_string();
        assert!(text.contains("line"), "{text}");
        for (file, what) in [
            (&b"\xff\xd8\xff\xe0"[..], "a JPEG picture"),
            (b"# .PCD v0.7", "a point cloud (PCD)"),
            (b"1, 2\n", "a file of another kind"),
            (b" \n", "an empty file"),
        ] {
            assert_eq!(read(file).unwrap_err(), LoadedMapError::Foreign { what });
        }
        let cut = read(&slamlab::MAGIC).unwrap_err();
        assert_eq!(cut, LoadedMapError::Slamlab(SlamlabError::Header { at: 8 }));
    }

    proptest! {
        #[test]
        fn any_bytes_are_a_map_or_an_error(mut bytes in prop::collection::vec(any::<u8>(), 0..200), saved in any::<bool>()) {
            if saved {
                bytes.splice(0..0, slamlab::MAGIC);
            }
            let _ = read(&bytes);
        }
    }
}
