//! Flat arrays of rows: the position of each number in a row, stated once for both sides.

use std::fmt::Write as _;

use wasm_bindgen::prelude::wasm_bindgen;

/// Rows of numbers, in the order in which they are named; the page has the places under the name
/// that is given first.
macro_rules! rows {
    ($($(#[doc = $doc:literal])+ $title:literal: $row:ident of $number:ty { $($field:ident),+ $(,)? })+) => {
        $(
            $(#[doc = $doc])+
            #[derive(Clone, Copy, Debug)]
            pub(crate) struct $row { $(pub(crate) $field: $number),+ }

            impl $row {
                const FIELDS: &[&str] = &[$(stringify!($field)),+];
                /// Numbers of one row.
                pub(crate) const STRIDE: usize = Self::FIELDS.len();
            }

            impl From<$row> for [$number; $row::STRIDE] {
                fn from(row: $row) -> Self {
                    [$(row.$field),+]
                }
            }
        )+

        /// Title, documentation and fields of each kind of row.
        const ROWS: &[(&str, &str, &[&str])] = &[$(($title, concat!($($doc),+), $row::FIELDS)),+];
    };
}

rows! {
    /// A wall of the line map: α and r with their covariance, its ends (rad, m), whether the last
    /// scan matched it, whether it was seen often enough to be a wall, and its number, the same for
    /// its whole life.
    "LINE": LineRow of f64 {
        alpha, r, var_alpha, cov_alpha_r, var_r, x1, y1, x2, y2, matched, confirmed, id,
    }
    /// A cell of the grid: column and row, its side (m), log-odds and probability of an obstacle,
    /// what is believed of it (-1 free, 0 unknown, 1 occupied), log-odds by the sensor and by the
    /// sonars alone (NaN without), what a hit and a miss add to them, how far they may go, and the
    /// probability after one more hit and after one more miss.
    "CELL": CellRow of f64 {
        col, row, resolution, log_odds, probability, state, of_sensor, of_sonars, hit, miss, limit, after_hit,
        after_miss,
    }
    /// A beam of the last scan as the map has it: where it began and ended (map frame, m), its
    /// range and σ, the range that the map would have it measure and how far from the nearest
    /// surface it ended (m, NaN beyond a metre), σ of that, and the part of beams that are held for
    /// random; and whether walls of a prior map were asked, 1, or cells of the grid, 0.
    "EXAMINED_BEAM": ExaminedBeamRow of f64 {
        from_x, from_y, x, y, range, sigma, quality, expected, nearest, field_sigma, random, walls,
    }
    /// Whether a gap between two posts is open, by the grid: cells between them, those of them that
    /// are known, Σ of their log-odds, and the probability that it is open.
    "LEAF": LeafRow of f64 { cells, known, log_odds, open }
    /// What would flip a match: by how much the sighting would have to lie elsewhere (rad or m),
    /// and the wall that explains it as well then, NaN where it only leaves its gate.
    "FLIP": FlipRow of f64 { shift, wall }
    /// A point of the trails, m: truth, dead reckoning, estimate, the submap in which the estimate
    /// is known (0 for methods without), and when, s since the first.
    "TRAIL": TrailRow of f32 { truth_x, truth_y, odometry_x, odometry_y, x, y, submap, time }
    /// A submap: its pose in the map (m, rad), whether it is joined loosely to the one before, the
    /// number of its keyframes, how far it lies from where that join has it (m, rad, χ²), how well
    /// the join is known (σ, m and rad), and its information Ω (over m and rad); NaN where there is
    /// none.
    "SUBMAP": SubmapRow of f32 {
        x, y, heading, loose, keyframes, off_x, off_y, off_turn, chi2, join_shift, join_turn,
        info_xx, info_xy, info_xt, info_yy, info_yt, info_tt,
    }
    /// How far the surfaces of a submap reach along the axes of its frame, m, and how many it has.
    "EXTENT": ExtentRow of f32 { width, height, surfaces }
    /// A placement of a submap in an earlier one: which two, the pose of the new in the old as it
    /// was found (m, rad), how far they lie from that now (m, rad, χ²), what was known before
    /// (σ, m and rad), whether it was searched for, overlap and the part that agrees (0 to 1), and
    /// evidence, what is asked for and the best rival's, in submaps; NaN where it was not judged;
    /// the information Ω of the placement (over m and rad); whether it is accepted and closes a
    /// loop.
    "CLOSURE": ClosureRow of f32 {
        old, new, x, y, heading, off_x, off_y, off_turn, chi2, doubt_shift, doubt_turn, searched,
        overlap, part, evidence, asked, rival, info_xx, info_xy, info_xt, info_yy, info_yt, info_tt,
        loop_closed,
    }
    /// An iteration of a registration: the pose of the moving cloud before its step, how far it
    /// looks, the weighted residual (m, rad), and how many points have a partner.
    "ITERATION": IterationRow of f64 { x, y, heading, width, residual, matched }
    /// A point of the moving cloud, where an iteration wants it, m, and how much it counts, to 1.
    "CORRESPONDENCE": CorrespondenceRow of f32 { from_x, from_y, to_x, to_y, weight }
    /// A cell of a map of starts: its place row by row from the lower left, what became of it, and
    /// how far it ended from the right pose, m.
    "BASIN": BasinRow of f32 { index, outcome, error }
    /// How a hit was read: range and σ in m, and the sensor's own quality, NaN where it tells none;
    /// the number of its beam in the scan.
    "BEAM": BeamRow of f32 { range, sigma, quality, number }
    /// A door of the simulated world: its ends, m, whether it is open, and whether it is to be: one
    /// that is to shut waits while somebody stands in it.
    "DOOR": DoorRow of f32 { x1, y1, x2, y2, open, ordered }
    /// A pose that the robot may have, map frame, m and rad, and its part of the weight, 0 to 1.
    "HYPOTHESIS": HypothesisRow of f32 { x, y, heading, weight }
    /// A side of what a person changed on the map: its ends, m, the place of its kind among the
    /// names of `EditName` (erased, wall, glass), and the number of the change.
    "EDIT": EditRow of f32 { x1, y1, x2, y2, kind, number }
    /// A point found in the last scan: where, map frame (m), its covariance (m²), the place of its
    /// kind among the names of `PointName` (corner, spike, crossing, circle), the radius of a
    /// circle (m, else 0), and the confidence, 0 to 1.
    "POINT": PointRow of f32 { x, y, var_x, cov_xy, var_y, kind, radius, confidence }
    /// A landmark of the filter: its number, the place of its kind among the names of
    /// `LandmarkName` (wall, corner, post), where it is (of a wall the middle of its known part),
    /// map frame (m), the covariance of that (m²; NaN of a wall, which has its band), the radius of
    /// a post (m, else 0), how often it was found again, and whether it was seen often enough to be
    /// believed.
    "LANDMARK": LandmarkRow of f32 { id, kind, x, y, var_x, cov_xy, var_y, radius, confidence, confirmed }
    /// How well landmarks are found again with a gate, d²: true positive rate, false positive rate,
    /// positive predictive value and accuracy, 0 to 1, NaN of nothing; and of how many sightings.
    "REFINDING": RefindingRow of f32 { gate, tpr, fpr, ppv, acc, sightings }
    /// Something that is followed: its number, where it is and its velocity, map frame (m, m/s),
    /// the covariance of its place (m²), the place of what it does among the names of
    /// `TrackMotionName` (new, moving, paused, standing), and whether the last scan saw it.
    "TRACK": TrackRow of f32 { id, x, y, velocity_x, velocity_y, var_x, cov_xy, var_y, motion, seen }
    /// A sample of the twin: s, pose (map frame, m and rad), how far it is off with 3σ (m, rad),
    /// and the ranges' (m).
    "TWIN": TwinRow of f64 { time, x, y, heading, position_off, position_sigma3, heading_off, heading_sigma3, ranges }
}

/// Rows as one flat array.
pub(crate) fn flat<R, N, const STRIDE: usize, A: FromIterator<N>>(
    rows: impl IntoIterator<Item = R>,
) -> A
where
    [N; STRIDE]: From<R>,
{
    rows.into_iter().flat_map(<[N; STRIDE]>::from).collect()
}

/// Positions of numbers in flat arrays, as a TypeScript module; `www/layout.mjs` puts it beside the
/// bindings.
#[wasm_bindgen]
#[must_use]
pub fn layout() -> String {
    let mut text =
        "// Which number stands where in the module's flat arrays: written by layout.mjs.\n"
            .to_owned();
    for (title, doc, fields) in ROWS {
        let places = fields.iter().enumerate();
        let places: Vec<String> = places
            .map(|(i, field)| format!("{}: {i}", camel(field)))
            .collect();
        let _ = writeln!(
            text,
            "\n/**{doc} */\nexport const {title} = {{ {} }} as const;",
            places.join(", ")
        );
        let _ = writeln!(text, "export const {title}_STRIDE = {};", fields.len());
    }
    text
}

/// `var_alpha` as TypeScript writes it: `varAlpha`.
fn camel(name: &str) -> String {
    let mut parts = name.split('_');
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| {
        let mut letters = part.chars();
        let head = letters.next().map(|letter| letter.to_ascii_uppercase());
        text + &head.into_iter().chain(letters).collect::<String>()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_layout_tells_the_page_where_each_number_stands() {
        let text = layout();
        assert!(text.contains("export const LINE = { alpha: 0, r: 1, varAlpha: 2, covAlphaR: 3,"));
        assert!(text.contains("export const LINE_STRIDE = 12;"));
        let row = BeamRow {
            range: 1.0,
            sigma: 2.0,
            quality: 3.0,
            number: 4.0,
        };
        let numbers: Vec<f32> = flat([row, row]);
        assert_eq!(numbers, [1.0, 2.0, 3.0, 4.0, 1.0, 2.0, 3.0, 4.0]);
    }
}
