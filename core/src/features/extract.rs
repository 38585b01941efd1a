//! In: [`Points`]. Out: [`LineFeature`]s, one for each straight piece of wall that is surely one.
//!
//! 1. Runs of neighbouring beams ([`segment`]).
//! 2. Split: a set of points is one line while Σ|dᵢ| < E + k √V, with E = Σ σ_dᵢ √(2/π) and V = Σ σ_dᵢ² (1 - 2/π), σ_d the
//!    standard deviation of a point's distance from the line (TDK 2016 §4.2). The source has k = 1, which splits a true
//!    line about one time in six. Where the test fails, the set is split at the point farthest from the chord through its ends.
//! 3. A single point farther than `max_residual` σ_d from the line is left out instead (the sum does not see it, the line
//!    would be pulled by it).
//! 4. Merge: neighbours become one again where (α, r) agree by χ² and the union passes the test of step 2.
//! 5. Points at a corner or an edge are given up on both sides: which wall they belong to is anyone's guess, and the wrong
//!    guess pulls the line every time the same way.
//! 6. Fit with covariance ([`fit_samples`]); short, sparse, crooked and bent pieces are refused. A filter is ruined by one wrong
//!    line and hardly misses a true one.
//!
//! Lines and tests of sub-ranges come from prefix sums, so a split costs one pass over its points.

use std::f64::consts::{FRAC_2_PI, PI};

use nalgebra::{Point2, Vector2};

use super::fit::{LineFeature, Sample, fit_samples};
use crate::geom::{CHI2_2DOF_99, sin_cos};
use crate::points::{Points, Run, SegmentationConfig, segment};

/// What counts as a straight piece of wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineConfig {
    /// How points are grouped before lines are looked for.
    pub segmentation: SegmentationConfig,
    /// k of the split test. Default 3. Growing: fewer true walls are split, shallower corners stay undetected. A true wall of
    /// 10 to 100 points is split once in 6 (k = 1), 40 (k = 2), 400 (k = 3) times, as the test measures.
    pub split_k: f64,
    /// A point this many standard deviations off its line is left out. Default 4.5: one true point in 150 000.
    pub max_residual: f64,
    /// Points given up at either end of a piece. Default 2: 1 gives longer lines and a less honest map.
    pub trim: usize,
    /// Fewest points of a line. Default 7. Growing: fewer, safer lines.
    pub min_points: usize,
    /// Shortest line, m. Default 0.5: people and most pillars are narrower.
    pub min_length: f64,
    /// Largest standard deviation of α, rad. Default 0.04: with 0.1 the filter's pose was 1.5 times as far off as it said in
    /// `office` and `loop`; what is linear at 2° is not at 6°.
    pub max_alpha_sigma: f64,
    /// Largest χ² of the residuals, in standard deviations above its mean. Default 2.5: one true line in 160 is
    /// lost, and nearly every line across a corner.
    pub max_chi2_sigmas: f64,
    /// Largest bend (the quadratic term of the residuals) in standard deviations. Default 2: one true line in 20 is lost,
    /// most pillars go.
    pub max_bend_sigmas: f64,
    /// Neighbours are merged over at most this many points that belong to neither. Default 3.
    pub merge_gap_points: usize,
    /// Neighbours are merged over at most this distance, m. Default 0.3: not over a door.
    pub merge_gap: f64,
    /// How far from flat a wall may be, m, one standard deviation. Default 0.002.
    pub surface_sigma: f64,
}

impl Default for LineConfig {
    fn default() -> Self {
        Self {
            segmentation: SegmentationConfig::default(),
            split_k: 3.0,
            max_residual: 4.5,
            trim: 2,
            min_points: 7,
            min_length: 0.5,
            max_alpha_sigma: 0.04,
            max_chi2_sigmas: 2.5,
            max_bend_sigmas: 2.0,
            merge_gap_points: 3,
            merge_gap: 0.3,
            surface_sigma: 0.002,
        }
    }
}

impl LineConfig {
    /// For few, noisy readings of a short reach: 180 of four infra-red rangers, over at most 1.5 m.
    ///
    /// With the figures for lidars a sweep shows one line or none, as half of a wall lies out of sight, and the sides of boxes
    /// are shorter than 0.5 m: the robot then reached its goal in 4 of 20 runs in `arena`, with these in 39 of 40. People
    /// become walls by them, for a scan or two; a robot that sees 1.5 m meets few.
    #[must_use]
    pub fn short_range() -> Self {
        Self {
            min_length: 0.2,
            min_points: 5,
            trim: 1,
            max_alpha_sigma: 0.1,
            ..Self::default()
        }
    }
}

/// Extracts lines; keeps its buffers between scans.
#[derive(Clone, Debug, Default)]
pub struct LineExtractor {
    config: LineConfig,
    runs: Vec<Run>,
    samples: Vec<Sample>,
    sums: Vec<Moments>,
    stack: Vec<Piece>,
    pieces: Vec<Piece>,
}

impl LineExtractor {
    /// An extractor with the given settings.
    #[must_use]
    pub fn new(config: LineConfig) -> Self {
        Self {
            config,
            ..Self::default()
        }
    }

    /// The lines in `points`, written to `lines` (cleared first) in the order of the beams.
    ///
    /// # Units    Robot frame; (α, r) in rad and m.
    /// # Source   TDK 2016 §4.2, with the additions listed in the module.
    pub fn extract(&mut self, points: &Points, lines: &mut Vec<LineFeature>) {
        lines.clear();
        segment(points, &self.config.segmentation, &mut self.runs);
        let runs = std::mem::take(&mut self.runs);
        let min_points = self.config.min_points;
        for run in runs.iter().filter(|run| run.len >= min_points) {
            self.load(points, run);
            self.split();
            self.merge();
            let mut pieces = std::mem::take(&mut self.pieces);
            lines.extend(pieces.drain(..).filter_map(|piece| self.finish(piece)));
            self.pieces = pieces;
        }
        self.runs = runs;
    }

    fn load(&mut self, points: &Points, run: &Run) {
        let roughness = self.config.surface_sigma;
        self.samples.clear();
        self.samples.extend(
            run.beams(points)
                .map(|b| Sample::new(b, points.bearing_sigma, roughness)),
        );
        self.sums.clear();
        let mut sum = Moments::default();
        self.sums.push(sum);
        for sample in &self.samples {
            sum = sum.plus(&Moments::of(sample));
            self.sums.push(sum);
        }
    }

    /// Steps 2 and 3: fills `pieces`, in order.
    fn split(&mut self) {
        self.pieces.clear();
        self.stack.clear();
        self.stack.push(self.piece(0, self.samples.len()));
        while let Some(mut piece) = self.stack.pop() {
            if piece.n_points() < 3 {
                continue;
            }
            let mut leave_out = piece.n_points() / 10 + 1;
            loop {
                let verdict = self.examine(&piece);
                match verdict.worst {
                    _ if verdict.is_line => {
                        self.pieces.push(piece);
                        break;
                    }
                    Some(worst) if verdict.sum_fits && leave_out > 0 => {
                        leave_out -= 1;
                        self.leave_out(&mut piece, worst);
                    }
                    _ => {
                        self.split_at_corner(&piece);
                        break;
                    }
                }
            }
        }
    }

    fn piece(&self, start: usize, end: usize) -> Piece {
        Piece {
            start,
            end,
            moments: self.sums[end].minus(&self.sums[start]),
        }
    }

    fn leave_out(&mut self, piece: &mut Piece, index: usize) {
        if let Some(sample) = self.samples.get_mut(index) {
            sample.dropped = true;
            piece.moments = piece.moments.minus(&Moments::of(sample));
        }
    }

    /// Pushes both parts so that the earlier one is taken first.
    fn split_at_corner(&mut self, piece: &Piece) {
        let Some(corner) = self.farthest_from_chord(piece) else {
            return;
        };
        for (start, end) in [(corner + 1, piece.end), (piece.start, corner + 1)] {
            let mut part = self.piece(start, end);
            for sample in self.samples[start..end].iter().filter(|s| s.dropped) {
                part.moments = part.moments.minus(&Moments::of(sample));
            }
            self.stack.push(part);
        }
    }

    /// The kept point, neither the first nor the last, that is farthest from the line through these two.
    fn farthest_from_chord(&self, piece: &Piece) -> Option<usize> {
        let kept = || {
            (piece.start..piece.end)
                .zip(&self.samples[piece.start..piece.end])
                .filter(|(_, s)| !s.dropped)
        };
        let (first, a) = kept().next()?;
        let (last, b) = kept().next_back()?;
        let chord = b.point - a.point;
        let mut best = (None, -1.0);
        for (index, sample) in kept() {
            let distance = chord.perp(&(sample.point - a.point)).abs();
            if distance > best.1 && index != first && index != last {
                best = (Some(index), distance);
            }
        }
        best.0
    }

    /// The test of step 2.
    fn examine(&self, piece: &Piece) -> Verdict {
        let (normal, r) = piece.moments.line();
        let (mut sum, mut expected, mut variance) = (0.0, 0.0, 0.0);
        let mut worst = (None, self.config.max_residual * self.config.max_residual);
        for (index, sample) in (piece.start..piece.end).zip(&self.samples[piece.start..piece.end]) {
            if sample.dropped {
                continue;
            }
            let var = sample.variance_across(&normal);
            let d = normal.dot(&sample.point.coords) - r;
            sum += d.abs();
            expected += var.sqrt();
            variance += var;
            if d * d > worst.1 * var {
                worst = (Some(index), d * d / var);
            }
        }
        let bound = expected * FRAC_2_PI.sqrt()
            + self.config.split_k * (variance * (1.0 - FRAC_2_PI)).sqrt();
        let sum_fits = sum < bound;
        Verdict {
            sum_fits,
            is_line: sum_fits && worst.0.is_none(),
            worst: worst.0,
        }
    }

    /// Step 4, from left to right, in place.
    fn merge(&mut self) {
        let mut merged = 0;
        for index in 0..self.pieces.len() {
            let next = self.pieces[index];
            if merged > 0
                && let Some(union) = self.union(&self.pieces[merged - 1], &next)
            {
                let between = self.pieces[merged - 1].end..next.start;
                for sample in &mut self.samples[between] {
                    sample.dropped = true;
                }
                self.pieces[merged - 1] = union;
            } else {
                self.pieces[merged] = next;
                merged += 1;
            }
        }
        self.pieces.truncate(merged);
    }

    /// Both pieces as one, if they are one line.
    fn union(&self, a: &Piece, b: &Piece) -> Option<Piece> {
        let between = self.samples.get(a.end..b.start)?;
        let gap = (self.samples[b.start].point - self.samples[a.end - 1].point).norm();
        if between.len() > self.config.merge_gap_points
            || gap > self.config.merge_gap.max(0.0) && !between.is_empty()
        {
            return None;
        }
        let (normal_a, normal_b) = (a.moments.line().0, b.moments.line().0);
        // Walls at a clear angle need no test; 0.5 is the sine of 30°.
        if normal_a.perp(&normal_b).abs() > 0.5 && a.n_points() > 3 && b.n_points() > 3 {
            return None;
        }
        let union = Piece {
            start: a.start,
            end: b.end,
            moments: a.moments.plus(&b.moments),
        };
        (self.agree(a, b) && self.examine_without(&union, a.end, b.start).is_line).then_some(union)
    }

    /// χ² of the difference of (α, r), where both pieces have a line of their own.
    fn agree(&self, a: &Piece, b: &Piece) -> bool {
        let fit = |p: &Piece| fit_samples(&self.samples[p.start..p.end]);
        let (Ok(a), Ok(b)) = (fit(a), fit(b)) else {
            // Too short to have a direction: the test of the union decides alone.
            return true;
        };
        let mut difference = Vector2::new(
            crate::geom::wrap(b.line.alpha() - a.line.alpha()),
            b.line.r() - a.line.r(),
        );
        let mut cov_b = b.cov;
        if difference.x.abs() > 0.5 * PI {
            // The same line through the origin, its normal turned round.
            difference = Vector2::new(
                crate::geom::wrap(difference.x + PI),
                -b.line.r() - a.line.r(),
            );
            cov_b[(0, 1)] = -cov_b[(0, 1)];
            cov_b[(1, 0)] = -cov_b[(1, 0)];
        }
        (a.cov + cov_b)
            .cholesky()
            .is_some_and(|c| difference.dot(&c.solve(&difference)) < CHI2_2DOF_99)
    }

    /// [`Self::examine`] with the samples from `gap_start` to `gap_end` left aside.
    fn examine_without(&self, union: &Piece, gap_start: usize, gap_end: usize) -> Verdict {
        let part = |start, end| Piece {
            start,
            end,
            moments: union.moments,
        };
        if gap_start == gap_end {
            return self.examine(union);
        }
        let (left, right) = (
            self.examine(&part(union.start, gap_start)),
            self.examine(&part(gap_end, union.end)),
        );
        Verdict {
            sum_fits: left.sum_fits && right.sum_fits,
            is_line: left.is_line && right.is_line,
            worst: left.worst.or(right.worst),
        }
    }

    /// Steps 5 and 6.
    fn finish(&mut self, piece: Piece) -> Option<LineFeature> {
        let config = &self.config;
        let samples = &mut self.samples[piece.start..piece.end];
        for _ in 0..config.trim {
            if let Some(first) = samples.iter_mut().find(|s| !s.dropped) {
                first.dropped = true;
            }
            if let Some(last) = samples.iter_mut().rev().find(|s| !s.dropped) {
                last.dropped = true;
            }
        }
        let n_points = samples.iter().filter(|s| !s.dropped).count();
        if n_points < config.min_points.max(3) {
            return None;
        }
        let feature = fit_samples(samples).ok()?;
        let is_wall = feature.length() >= config.min_length
            && feature.cov[(0, 0)] <= config.max_alpha_sigma * config.max_alpha_sigma
            && feature.chi2 <= chi2_limit(n_points - 2, config.max_chi2_sigmas)
            && bend(samples, &feature) <= config.max_bend_sigmas;
        is_wall.then_some(feature)
    }
}

/// What the split test says.
struct Verdict {
    /// Σ|d| is within its bound.
    sum_fits: bool,
    /// It is one line.
    is_line: bool,
    /// The point farthest out, where one is too far.
    worst: Option<usize>,
}

/// Neighbouring samples, from `start` to before `end`, and the sums over those not dropped.
#[derive(Clone, Copy, Debug)]
struct Piece {
    start: usize,
    end: usize,
    moments: Moments,
}

impl Piece {
    fn n_points(&self) -> usize {
        self.end - self.start
    }
}

/// Weighted sums over points; differences of prefix sums give those of any range.
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    w: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Moments {
    fn of(sample: &Sample) -> Self {
        let (w, p): (f64, Point2<f64>) = (sample.weight, sample.point);
        Self {
            w,
            x: w * p.x,
            y: w * p.y,
            xx: w * p.x * p.x,
            xy: w * p.x * p.y,
            yy: w * p.y * p.y,
        }
    }

    fn plus(&self, o: &Self) -> Self {
        Self {
            w: self.w + o.w,
            x: self.x + o.x,
            y: self.y + o.y,
            xx: self.xx + o.xx,
            xy: self.xy + o.xy,
            yy: self.yy + o.yy,
        }
    }

    fn minus(&self, o: &Self) -> Self {
        Self {
            w: self.w - o.w,
            x: self.x - o.x,
            y: self.y - o.y,
            xx: self.xx - o.xx,
            xy: self.xy - o.xy,
            yy: self.yy - o.yy,
        }
    }

    /// Normal and distance of the total-least-squares line; the distance may be negative.
    fn line(&self) -> (Vector2<f64>, f64) {
        let (x, y) = (self.x / self.w, self.y / self.w);
        let (xx, xy, yy) = (
            self.xx - self.x * x,
            self.xy - self.x * y,
            self.yy - self.y * y,
        );
        let (sin, cos) = sin_cos(0.5 * libm::atan2(-2.0 * xy, yy - xx));
        (Vector2::new(cos, sin), x * cos + y * sin)
    }
}

/// The value that χ² with `dof` degrees of freedom exceeds as seldom as a normal variable exceeds `sigmas`.
///
/// Source: Wilson & Hilferty (1931), "The distribution of chi-square".
fn chi2_limit(dof: usize, sigmas: f64) -> f64 {
    let dof = dof.max(1) as f64;
    let spread = 2.0 / (9.0 * dof);
    let root = 1.0 - spread + sigmas * spread.sqrt();
    dof * root * root * root
}

/// The quadratic term of the residuals along the line, in standard deviations.
fn bend(samples: &[Sample], feature: &LineFeature) -> f64 {
    let normal = feature.line.normal();
    let [a, b] = feature.ends;
    let (middle, half) = (nalgebra::center(&a, &b), 0.5 * (b - a));
    let scale = 1.0 / half.norm_squared().max(f64::MIN_POSITIVE);
    let kept = || {
        samples.iter().filter(|s| !s.dropped).map(|s| {
            let t = (s.point - middle).dot(&half) * scale;
            let weight = 1.0 / s.variance_across(&normal);
            (t, weight, feature.line.signed_distance(s.point))
        })
    };
    // The part of t² that no line can take up: least squares of t² on 1 and t.
    let (mut s0, mut s1, mut s2, mut s3) = (0.0, 0.0, 0.0, 0.0);
    for (t, w, _) in kept() {
        let wt = w * t;
        s0 += w;
        s1 += wt;
        s2 += wt * t;
        s3 += wt * t * t;
    }
    let determinant = s0 * s2 - s1 * s1;
    if determinant.is_nan() || determinant <= 0.0 {
        return 0.0;
    }
    let (constant, slope) = (
        (s2 * s2 - s1 * s3) / determinant,
        (s0 * s3 - s1 * s2) / determinant,
    );
    let (mut product, mut norm) = (0.0, 0.0);
    for (t, w, d) in kept() {
        let q = t * t - constant - slope * t;
        product += w * q * d;
        norm += w * q * q;
    }
    if norm > 0.0 {
        product.abs() / norm.sqrt()
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests;
