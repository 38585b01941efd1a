//! In: the lines found in a scan, and the truth. Out: how much of the walls was found, and how much
//! else was taken for walls.
//!
//! 1. A true piece is what neighbouring beams saw of one wall: at least 7 beams and 0.5 m. Beams on
//!    smaller pieces are not counted, because whether those are lines is a matter of taste. Beams
//!    on pillars and outliers are negatives.
//! 2. A line claims the beams between its ends that lie within 5 σ of it, and belongs to the piece
//!    that most of them saw.
//! 3. For beams: TPR, positives claimed by a line of their own piece; FPR, negatives claimed; PPV,
//!    claims that are right; ACC, beams decided rightly.
//! 4. For pieces: over-segmented, those with two lines or more; missed, those with none. For lines:
//!    under-segmented, those that hold two pieces, each with at least a fifth of its beams.

use std::collections::BTreeMap;

use nalgebra::Point2;
use slamlab_core::features::LineFeature;
use slamlab_core::geom::Length;
use slamlab_core::points::Points;

const MIN_BEAMS: usize = 7;
const MIN_LENGTH: f64 = 0.5;

/// A scan of a full circle and its truth.
pub(crate) struct Scene {
    pub(crate) points: Points,
    /// The flat wall that each beam hit, and where; `None` for pillars and outliers.
    pub(crate) truth: Vec<Option<(usize, Point2<f64>)>>,
    /// Standard deviation of the ranges, m.
    pub(crate) sigma: f64,
}

/// Counts over many scenes.
#[derive(Default)]
pub(crate) struct Score {
    positives: usize,
    negatives: usize,
    right: usize,
    wrong: usize,
    claimed_negatives: usize,
    pieces: usize,
    missed: usize,
    over: usize,
    lines: usize,
    under: usize,
}

/// What a beam truly saw.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Piece(usize),
    Small,
    Negative,
}

impl Score {
    pub(crate) fn add(&mut self, scene: &Scene, lines: &[LineFeature]) {
        let (kinds, n_pieces) = kinds(scene);
        let mut lines_of_piece = vec![0; n_pieces];
        let mut right = vec![false; kinds.len()];
        let mut claimed = vec![false; kinds.len()];
        for line in lines {
            let beams = claims(scene, line);
            let mut counts = BTreeMap::new();
            for &beam in &beams {
                if let Kind::Piece(piece) = kinds[beam] {
                    *counts.entry(piece).or_insert(0_usize) += 1;
                }
            }
            let most = counts.iter().max_by_key(|(_, n)| **n);
            let owner = most.map(|(piece, _)| *piece);
            if let Some(owner) = owner {
                lines_of_piece[owner] += 1;
            }
            let large = counts.values().filter(|n| **n * 5 >= beams.len()).count();
            self.under += usize::from(large > 1);
            self.lines += 1;
            for beam in beams {
                claimed[beam] = true;
                right[beam] |= owner.is_some_and(|owner| kinds[beam] == Kind::Piece(owner));
            }
        }
        self.pieces += n_pieces;
        self.missed += lines_of_piece.iter().filter(|n| **n == 0).count();
        self.over += lines_of_piece.iter().filter(|n| **n > 1).count();
        for ((kind, claimed), right) in kinds.iter().zip(claimed).zip(right) {
            let is_negative = *kind == Kind::Negative;
            self.positives += usize::from(matches!(kind, Kind::Piece(_)));
            self.negatives += usize::from(is_negative);
            self.right += usize::from(right);
            self.wrong += usize::from(claimed && !right && *kind != Kind::Small);
            self.claimed_negatives += usize::from(claimed && is_negative);
        }
    }

    /// Ratios by name, each from 0 to 1.
    pub(crate) fn ratios(&self) -> BTreeMap<&'static str, f64> {
        let ratio = |part: usize, whole: usize| part as f64 / whole as f64;
        let decided_rightly = self.right + self.negatives - self.claimed_negatives;
        let decided = self.positives + self.negatives;
        BTreeMap::from([
            ("tpr", ratio(self.right, self.positives)),
            ("fpr", ratio(self.claimed_negatives, self.negatives)),
            ("ppv", ratio(self.right, self.right + self.wrong)),
            ("acc", ratio(decided_rightly, decided)),
            ("over_segmented_pieces", ratio(self.over, self.pieces)),
            ("missed_pieces", ratio(self.missed, self.pieces)),
            ("under_segmented_lines", ratio(self.under, self.lines)),
        ])
    }
}

/// Step 2.
fn claims(scene: &Scene, found: &LineFeature) -> Vec<usize> {
    let beams = &scene.points.beams;
    let n = beams.len();
    let (first, last) = (found.first_beam, found.last_beam);
    let n_between = (last + n - first) % n + 1;
    let off = |beam: usize| found.line.signed_distance(beams[beam].end_in_robot);
    let between = (0..n_between).map(|step| (first + step) % n);
    let is_near = |beam: &usize| off(*beam).abs() <= 5.0 * scene.sigma;
    between.filter(is_near).collect()
}

/// Step 1; also the number of pieces. The scan is a full circle.
fn kinds(scene: &Scene) -> (Vec<Kind>, usize) {
    let truth = &scene.truth;
    let n = truth.len();
    let wall = |beam: usize| truth[beam % n].map(|(wall, _)| wall);
    // Begin where the wall changes; outliers on a wall do not end its piece.
    let seen: Vec<usize> = (0..n).filter(|&beam| wall(beam).is_some()).collect();
    let start = (0..seen.len()).find(|&i| {
        let before = seen[(i + seen.len() - 1) % seen.len()];
        wall(seen[i]) != wall(before)
    });
    let (mut kinds, mut n_pieces) = (vec![Kind::Negative; n], 0);
    let mut order = seen;
    order.rotate_left(start.unwrap_or(0));
    for piece in order.chunk_by(|&a, &b| wall(a) == wall(b) && (b + n - a) % n <= 3) {
        let at = |beam: &usize| truth[*beam].map(|(_, point)| point);
        let length = match (piece.first().and_then(at), piece.last().and_then(at)) {
            (Some(first), Some(last)) => (last - first).length(),
            _ => 0.0,
        };
        let is_large = piece.len() >= MIN_BEAMS && length >= MIN_LENGTH;
        let own = Kind::Piece(n_pieces);
        let kind = if is_large { own } else { Kind::Small };
        piece.iter().for_each(|&beam| kinds[beam] = kind);
        n_pieces += usize::from(is_large);
    }
    (kinds, n_pieces)
}
