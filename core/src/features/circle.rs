//! In: runs of neighbours. Out: round things that stand alone: posts, pillars, legs.
//!
//! 1. Only runs no wider than the largest circle are considered: a pillar that stands alone is a
//!    run of its own, because beams that miss it end far behind it.
//! 2. Votes, in a separate layer for each radius: each point votes for the centres of all circles
//!    of that radius through it that lie behind it along its beam. Votes are counted relative to
//!    what the circle's width plus one cell would give; with less, thin circles would be favoured,
//!    because any surface touches their arcs for a cell's width. The cell with the most is a guess.
//! 3. The guess is refined by a weighted fit ([`fit`]), with covariance, and its points are chosen
//!    anew.
//! 4. It is kept if an arc of at least `min_arc` was seen from outside, if noise explains the
//!    residuals, if its radius is surely not that of something flatter, and if two straight lines
//!    with a bend explain the points less well. Its points take back their votes, and the next
//!    circle of the run is looked for (two legs beside each other).
//!
//! Source: Duda & Hart (1972); Pilch 2016 §1.2.1, eq. (1.9). Pilch solves the circle's equation for
//! one coordinate in each column; here votes go along the arc, at equal density everywhere.

mod fit;
mod votes;

use std::ops::Range;

use nalgebra::Point2;

use super::columns::Columns;
use super::consensus::longest_stretch;
use super::point::{PointFeature, PointKind, probability_within};
use crate::bounds::config;
use crate::geom::{Length, chi2_quantile};
use fit::CircleFit;
use votes::Votes;

config! {
    /// What is round.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct CircleConfig {
        /// Whether they are looked for. Default yes.
        pub is_on: bool = true,
        /// Smallest radius, m. Default 0.03.
        pub min_radius: f64 = 0.03,
        /// Largest radius, m. Default 0.5. Larger: slower; bent walls become circles.
        pub max_radius: f64 = 0.5,
        /// Side of a cell and step of the radius, m. Default 0.03. Larger: faster, coarser guesses.
        pub cell: f64 = 0.03,
        /// Fewest points. Default 6. Larger: fewer, safer circles.
        pub min_points: usize = 6,
        /// Least arc that must be seen, rad. Default 1.57 (90°). Larger: fewer, safer circles.
        pub min_arc: f64 = 1.57,
        /// Largest χ² of the residuals, in standard deviations above its mean. Default 2.5. Larger:
        /// boxes become circles.
        pub max_chi2_sigmas: f64 = 2.5,
        /// Least radius in its own standard deviations. Default 4: what is flat has a radius that
        /// is not known. Larger: fewer, better known circles.
        pub min_radius_sigmas: f64 = 4.0,
        /// How much less χ² must be than that of a bend, two straight lines. Default 4, e² times
        /// likelier. Larger: fewer boxes become circles, fewer thin posts are found.
        pub min_gain: f64 = 4.0,
    }
}

/// A point is on a circle within so many standard deviations.
const ON_IT_SIGMAS: f64 = 3.0;
/// Most guesses of a run that are checked.
const MOST_GUESSES: usize = 8;
/// How often points and circle are found anew, at most.
const MOST_STEPS: usize = 5;

/// The circles of the runs, which follow each other in the columns; added to `found`.
pub(super) fn circles(
    columns: &Columns,
    runs: impl IntoIterator<Item = Range<usize>>,
    config: &CircleConfig,
    found: &mut Vec<PointFeature>,
) {
    let mut votes = Votes::new(config);
    for run in runs {
        if run.len() < config.min_points || width(columns, &run) > 2.5 * config.max_radius {
            continue;
        }
        votes.begin(columns, &run, config);
        for _ in 0..MOST_GUESSES {
            let Some((cell, guess)) = votes.highest(config.min_points) else {
                break;
            };
            match refined(columns, &run, &votes, guess, config) {
                Some(circle) => {
                    votes.take_back(columns, &run, circle.range.clone());
                    found.extend(circle.feature(columns, config));
                }
                None => votes.clear(cell),
            }
        }
    }
}

/// Largest distance of two points along an axis, m.
fn width(columns: &Columns, run: &Range<usize>) -> f64 {
    let (mut low, mut high) = (Point2::from([f64::MAX; 2]), Point2::from([f64::MIN; 2]));
    for p in run.clone().map(|index| columns.point(index)) {
        (low, high) = (low.inf(&p), high.sup(&p));
    }
    (high - low).max()
}

/// A centre and a radius.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Circle {
    middle: Point2<f64>,
    radius: f64,
}

impl Circle {
    /// Whether a point is on it within n σ of its range, and `slack` (m) more.
    fn is_near(&self, columns: &Columns, index: usize, slack: f64) -> bool {
        let off = ((columns.point(index) - self.middle).length() - self.radius).abs() - slack;
        off <= 0.0 || off * off <= ON_IT_SIGMAS * ON_IT_SIGMAS * columns.variance_along(index)
    }
}

/// A circle, and the points on it.
struct Round {
    fit: CircleFit,
    range: Range<usize>,
    points: Vec<usize>,
}

/// Step 3.
fn refined(
    columns: &Columns,
    run: &Range<usize>,
    votes: &Votes,
    guess: Circle,
    config: &CircleConfig,
) -> Option<Round> {
    let mut before: Option<Round> = None;
    for _ in 0..MOST_STEPS {
        let on_it = |index: usize| {
            let is_near = match &before {
                Some(round) => round.fit.has(columns, index, ON_IT_SIGMAS),
                None => guess.is_near(columns, index, config.cell),
            };
            is_near && votes.is_free(index - run.start)
        };
        let range = longest_stretch(run.clone(), on_it).range;
        let points: Vec<usize> = range.clone().filter(|&index| on_it(index)).collect();
        if points.len() < config.min_points.max(4) {
            return None;
        }
        if before
            .as_ref()
            .is_some_and(|before| before.points == points)
        {
            break;
        }
        let start = before.as_ref().map_or(guess, |before| before.fit.circle);
        let fit = fit::fit(columns, &points, start)?;
        before = Some(Round { fit, range, points });
    }
    before
}

impl Round {
    /// Step 4.
    fn feature(&self, columns: &Columns, config: &CircleConfig) -> Option<PointFeature> {
        let (&first, &last) = (self.points.first()?, self.points.last()?);
        let Circle { middle, radius } = self.fit.circle;
        let sigma = self.fit.cov[(2, 2)].sqrt();
        let degrees = (self.points.len() - 3) as f64;
        let is_round = (config.min_radius..=config.max_radius).contains(&radius)
            && radius >= config.min_radius_sigmas * sigma
            && self.fit.chi2 <= chi2_quantile(degrees, config.max_chi2_sigmas)
            && self.arc(columns) >= config.min_arc
            && self.fit.chi2 + config.min_gain <= fit::chi2_of_bend(columns, &self.points);
        is_round.then(|| PointFeature {
            position: middle,
            cov: self.fit.cov.fixed_view::<2, 2>(0, 0).into_owned(),
            kind: PointKind::Circle {
                radius,
                var_radius: sigma * sigma,
            },
            confidence: probability_within(radius, sigma, [config.min_radius, config.max_radius]),
            beams: [columns.number(first), columns.number(last)],
        })
    }

    /// The arc over which points were seen, rad; 0 if most lie on the far side of the centre, as in
    /// a round niche.
    fn arc(&self, columns: &Columns) -> f64 {
        let Some(&first) = self.points.first() else {
            return 0.0;
        };
        let out = |index: usize| columns.point(index) - self.fit.circle.middle;
        let is_facing = |index: usize| columns.direction(index).dot(&out(index)) < 0.0;
        let n_facing = self
            .points
            .iter()
            .filter(|&&index| is_facing(index))
            .count();
        if 2 * n_facing <= self.points.len() {
            return 0.0;
        }
        // Angles about the centre, from that of the first point on.
        let zero = out(first);
        let angles = self.points.iter().map(|&index| {
            let out = out(index);
            libm::atan2(zero.perp(&out), zero.dot(&out))
        });
        let (low, high) = angles.fold((0.0_f64, 0.0_f64), |(low, high), angle| {
            (low.min(angle), high.max(angle))
        });
        high - low
    }
}

#[cfg(test)]
mod tests;
