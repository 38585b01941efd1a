//! The whole state of a scan matcher as bytes: a restored matcher continues as if it had never been
//! stopped, to the bit.
//!
//! In: a matcher. Out: its bytes, and from them a matcher that works with the settings of a new
//! run, or what is wrong and where. Left out are: what can be rebuilt identically (the indexes of
//! the submaps that were last compared or refined), removals that could be undone, and how well the
//! last scan fitted.

use super::super::submap::Indexes;
use super::going_on::Piece;
use super::refinement::Unrefined;
use super::{Recent, ScanMatcher, ScanMatcherConfig, ScanMatcherError, Submap, TrackPoint};
use crate::map::{Grid, SurfelMap};
use crate::robot::Stamp;
use crate::snapshot::{Reader, Snapshot, SnapshotError, snapshot};

snapshot!(Submap {
    map_from_submap,
    drawn_at,
    own_keyframes,
    is_loose,
    closed,
});
snapshot!(Recent {
    submap_from_robot,
    surfaces,
});
snapshot!(TrackPoint {
    stamp,
    submap,
    submap_from_robot,
});

/// A saved map, and when it was seen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SavedMap {
    /// As [`ScanMatcher::save`] wrote it.
    pub state: Vec<u8>,
    /// Stamps of scans, in ascending order, with the times of their logs, s, as far as known.
    pub times: Vec<(Stamp, f64)>,
}

snapshot!(SavedMap { state, times });
snapshot!(Piece { first, aside });

/// Why a saved map cannot be restored.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RestoreError {
    /// Its bytes are not those of a map.
    #[error("the saved map is damaged: {0}")]
    Snapshot(#[from] SnapshotError),
    /// A setting of the new run is wrong.
    #[error(transparent)]
    Matcher(#[from] ScanMatcherError),
}

/// Writes and reads the fields in one order; a field missing here is a compile error.
macro_rules! fields {
    ($($field:ident),* $(,)?) => {
        fn write_fields(matcher: &ScanMatcher, out: &mut Vec<u8>) {
            let ScanMatcher { config: _, indexes: _, removals: _, last_fit: _, $($field),* } = matcher;
            $($field.write(out);)*
        }

        fn read_fields(
            from: &mut Reader<'_>,
            config: ScanMatcherConfig,
        ) -> Result<ScanMatcher, SnapshotError> {
            Ok(ScanMatcher {
                config,
                indexes: Indexes::default(),
                removals: vec![],
                last_fit: None,
                $($field: from.field(stringify!($field))?),*
            })
        }
    };
}

fields!(
    pending,
    submaps,
    running,
    running_free,
    local,
    is_blind,
    motion,
    gathering,
    recent,
    keyframes,
    last_keyframe,
    trajectory,
    grid,
    grid_version,
    redraw,
    graph,
    way_cov,
    submap_cov,
    jobs,
    closures,
    waiting,
    newest,
    records,
    unrefined,
    moved_within,
    moves,
    compared,
    last_closed,
    drift,
    graph_changed,
    stamp_shift,
    is_new_run,
    unplaced,
    edits,
);

impl SavedMap {
    /// Restores the saved matcher, with the settings of a new run.
    ///
    /// # Errors    [`RestoreError`]: what is wrong, and where.
    pub fn matcher(&self, config: ScanMatcherConfig) -> Result<ScanMatcher, RestoreError> {
        let mut from = Reader::new(&self.state);
        let matcher = ScanMatcher::restore(&mut from, config)?;
        from.rule(from.is_at_end(), "more follows than a map")?;
        Ok(matcher)
    }
}

impl ScanMatcher {
    /// The map for saving, with the times of its scans ([`SavedMap::times`]).
    #[must_use]
    pub fn saved(&self, times: Vec<(Stamp, f64)>) -> SavedMap {
        let mut state = vec![];
        self.save(&mut state);
        SavedMap { state, times }
    }

    /// Appends the whole state.
    pub fn save(&self, out: &mut Vec<u8>) {
        write_fields(self, out);
    }

    /// Restores a saved state with the settings of a new run: map settings apply to what is made
    /// from here on, and a grid with other figures is redrawn.
    ///
    /// # Errors    [`RestoreError`]: what is wrong, and where.
    pub fn restore(from: &mut Reader<'_>, config: ScanMatcherConfig) -> Result<Self, RestoreError> {
        config.validate()?;
        let mut matcher = read_fields(from, config)?;
        matcher.check_names(from)?;
        if *matcher.running.config() != config.surfels {
            let surfels = matcher.running.into_surfels();
            matcher.running = SurfelMap::from_surfels(config.surfels, surfels);
        }
        if *matcher.grid.config() != config.grid {
            if let Some(piece) = &mut matcher.unplaced {
                piece.aside = None;
            }
            matcher.grid = Grid::new(config.grid).map_err(ScanMatcherError::from)?;
            matcher.redraw_at_once();
        }
        Ok(matcher)
    }

    /// Whether every submap, keyframe and edge that is referred to exists.
    fn check_names(&self, from: &Reader<'_>) -> Result<(), SnapshotError> {
        let count = self.submaps.len();
        let in_order = |(old, new): (usize, usize)| old < new && new < count;
        from.rule(
            count > 0 && self.graph.poses().len() == count,
            "there are not as many submaps as poses of the graph, or none",
        )?;
        let of_keyframes = self.keyframes.iter().map(|keyframe| keyframe.submap);
        from.rule(
            are_in_order(of_keyframes, count),
            "a keyframe names a submap that is not there, or stands before one of an earlier submap",
        )?;
        let mut own = self.submaps.iter().enumerate();
        from.rule(
            own.all(|(submap, kept)| {
                let [first, behind] = self.keyframes_of(submap);
                behind - first == kept.own_keyframes
            }),
            "a submap says of another number of keyframes than there are of it",
        )?;
        let of_scans = self.trajectory.iter().map(|scan| scan.submap);
        from.rule(
            are_in_order(of_scans, count),
            "a scan names a submap that is not there, or stands before one of an earlier submap",
        )?;
        let pairs = self.jobs.iter().copied();
        from.rule(
            pairs.chain(self.compared.keys().copied()).all(in_order),
            "two submaps to be compared are not there",
        )?;
        let waiting = self
            .waiting
            .iter()
            .chain(self.newest.iter().map(|(_, c)| c));
        let recorded = self.records.iter().map(|r| (r.old, r.new));
        from.rule(
            (waiting.map(|c| (c.old, c.new)).chain(recorded)).all(in_order),
            "a placement names submaps that are not there",
        )?;
        let accepted = self.records.accepted().count();
        let held = self.records.accepted();
        let held = held.filter(|(_, edge, _)| self.graph.edge(*edge).is_some());
        from.rule(
            held.count() == accepted,
            "an accepted placement names an edge that is not there",
        )?;
        from.rule(
            self.last_closed < count,
            "the submap by which a loop was closed last is not there",
        )?;
        let (submaps, keyframes) = (count, self.keyframes.len());
        from.rule(
            (self.edits.iter()).all(|e| e.submap < submaps && e.after <= keyframes),
            "a change names a submap or a keyframe that is not there",
        )?;
        let piece = self.unplaced.as_ref();
        from.rule(
            piece.is_none_or(|piece| (1..count).contains(&piece.first)),
            "a piece of the map begins where none can",
        )?;
        let is_sound = |unrefined: &Unrefined| {
            let [first, behind] = self.keyframes_of(unrefined.submap);
            unrefined.submap < count && unrefined.is_sound(count, behind - first)
        };
        from.rule(
            self.unrefined.iter().all(is_sound),
            "a submap to be refined names what is not there",
        )?;
        let drawn = self.redraw.as_ref().map_or(0, |redraw| redraw.next);
        from.rule(
            drawn <= self.keyframes.len(),
            "more keyframes were drawn than there are",
        )
    }
}

/// Whether these are ascending numbers of `count` submaps.
fn are_in_order(submaps: impl Iterator<Item = usize> + Clone, count: usize) -> bool {
    submaps.clone().all(|submap| submap < count) && submaps.is_sorted()
}

#[cfg(test)]
pub(super) mod tests;
