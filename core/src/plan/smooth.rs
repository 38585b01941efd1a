//! A path with rounded corners, for driving without stopping at them.
//!
//! In: a path of straight legs, the space in which the rounding must be free. Out: straight pieces
//! and arcs that join without a kink; a corner that cannot be rounded stays a turn on the spot.
//!
//! 1. At a corner that turns by τ an arc of radius ρ takes ρ tan(|τ|/2) from each of its legs: at
//!    most half of a leg, but all of the first and the last.
//! 2. The largest free radius is found by bisection. Arcs cut corners, and a taut path has its
//!    corners at obstacles, so the space here has a narrower margin than the one in which the path
//!    was planned.
//! 3. No arc is tighter than [`LEAST_RADIUS`]: the curvature is at most its inverse.
//!
//! An arc is free if both the inscribed and the circumscribed polygon are, with corners [`STEP`]
//! apart.

use nalgebra::{Point2, Vector2};

use super::cspace::ConfigSpace;
use super::path::Path;
use crate::geom::{Length, Segment, sin_cos, wrap};

/// Angle between the points by which arcs are tested, rad.
const STEP: f64 = 0.1;
/// Bisection steps for the radius.
const HALVINGS: usize = 12;

/// Least radius of an arc, m.
const LEAST_RADIUS: f64 = 0.1;
/// Greatest radius of an arc, m: wider ones take more of the legs and are hardly faster.
const MOST_RADIUS: f64 = 1.0;

/// A piece of a smooth path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Piece {
    /// A straight line.
    Line(Segment),
    /// An arc.
    Arc {
        /// Where it begins.
        start: Point2<f64>,
        /// Heading there, rad.
        heading: f64,
        /// Radius, m.
        radius: f64,
        /// How far the heading turns, rad; positive to the left.
        turn: f64,
    },
    /// A turn on the spot.
    Turn {
        /// Where.
        at: Point2<f64>,
        /// Angle, rad; positive to the left.
        turn: f64,
    },
}

impl Piece {
    /// Length, m.
    #[must_use]
    pub fn length(&self) -> f64 {
        match self {
            Self::Line(leg) => leg.length(),
            Self::Arc { radius, turn, .. } => radius * turn.abs(),
            Self::Turn { .. } => 0.0,
        }
    }

    /// The point at this fraction of the piece, from 0 to 1.
    #[must_use]
    pub fn point(&self, part: f64) -> Point2<f64> {
        match *self {
            Self::Line(leg) => leg.a + leg.vector() * part,
            Self::Turn { at, .. } => at,
            Self::Arc {
                start,
                heading,
                radius,
                turn,
            } => {
                let side = radius * turn.signum();
                let normal = |heading: f64| {
                    let (sin, cos) = sin_cos(heading);
                    Vector2::new(-sin, cos)
                };
                start + (normal(heading) - normal(heading + part * turn)) * side
            }
        }
    }
}

/// The path with its corners rounded as far as `space` allows.
#[must_use]
pub fn smooth(path: &Path, space: &dyn ConfigSpace) -> Vec<Piece> {
    let legs: Vec<Segment> = path.legs().filter(|leg| leg.length() > 0.0).collect();
    let mut pieces = vec![];
    let Some(first) = legs.first() else {
        return pieces;
    };
    let mut at = first.a;
    for (number, pair) in legs.windows(2).enumerate() {
        let (before, after) = (pair[0], pair[1]);
        let share = |is_end: bool| if is_end { 1.0 } else { 0.5 };
        let most = (before.length() * share(number == 0))
            .min(after.length() * share(number + 2 == legs.len()));
        let corner = Corner::of(&before, &after);
        let rounded = corner.rounded(space, most);
        let begins = rounded.as_ref().map_or(before.b, |arc| arc.point(0.0));
        push_line(&mut pieces, at, begins);
        let piece = rounded.unwrap_or(Piece::Turn {
            at: before.b,
            turn: corner.turn,
        });
        at = piece.point(1.0);
        if corner.turn != 0.0 {
            pieces.push(piece);
        }
    }
    push_line(&mut pieces, at, legs[legs.len() - 1].b);
    pieces
}

fn push_line(pieces: &mut Vec<Piece>, from: Point2<f64>, to: Point2<f64>) {
    // If two arcs use up the whole leg between them, there is no straight piece.
    if (to - from).length() > 1e-9 {
        pieces.push(Piece::Line(Segment::new(from, to)));
    }
}

struct Corner {
    at: Point2<f64>,
    heading: f64,
    turn: f64,
}

impl Corner {
    fn of(before: &Segment, after: &Segment) -> Self {
        Self {
            at: before.b,
            heading: before.heading(),
            turn: wrap(after.heading() - before.heading()),
        }
    }

    /// The widest free arc that takes at most `most` metres of each leg; `None` if even the
    /// tightest is not free.
    fn rounded(&self, space: &dyn ConfigSpace, most: f64) -> Option<Piece> {
        let (sin, cos) = sin_cos(0.5 * self.turn.abs());
        // Turning back: there is no arc.
        if cos < 1e-6 || self.turn == 0.0 {
            return None;
        }
        let taken = sin / cos;
        let free = |radius: f64| {
            let arc = self.arc(radius, taken);
            is_free(space, &arc).then_some(arc)
        };
        let (mut low, mut high) = (LEAST_RADIUS, MOST_RADIUS.min(most / taken));
        if high < low {
            return None;
        }
        if let Some(widest) = free(high) {
            return Some(widest);
        }
        let mut best = free(low)?;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            match free(middle) {
                Some(arc) => (best, low) = (arc, middle),
                None => high = middle,
            }
        }
        Some(best)
    }

    fn arc(&self, radius: f64, taken: f64) -> Piece {
        let (sin, cos) = sin_cos(self.heading);
        Piece::Arc {
            start: self.at - Vector2::new(cos, sin) * (radius * taken),
            heading: self.heading,
            radius,
            turn: self.turn,
        }
    }
}

fn is_free(space: &dyn ConfigSpace, arc: &Piece) -> bool {
    let Piece::Arc {
        start,
        heading,
        radius,
        turn,
    } = *arc
    else {
        return true;
    };
    let (sin, cos) = sin_cos(heading);
    let centre = start + Vector2::new(-sin, cos) * (radius * turn.signum());
    let pieces = (turn.abs() / STEP).ceil().max(1.0);
    // The corners around the arc lie on a wider arc, half a step farther on.
    let wider = radius / libm::cos(0.5 * turn / pieces) - radius;
    let sag = radius - libm::cos(0.5 * turn / pieces) * radius;
    let through: Vec<_> = (0..=pieces as usize)
        .map(|i| arc.point(i as f64 / pieces))
        .collect();
    let mut around = vec![arc.point(0.0)];
    around.extend(through.windows(2).map(|pair| {
        let middle = pair[0] + 0.5 * (pair[1] - pair[0]);
        middle + (middle - centre).normalize() * (sag + wider)
    }));
    around.push(arc.point(1.0));
    [through, around].iter().all(|points| {
        let mut legs = points.windows(2).map(|pair| Segment::new(pair[0], pair[1]));
        legs.all(|leg| space.leg_is_free(&leg))
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;
    use crate::plan::SegmentSpace;
    use proptest::prelude::*;

    const BOUNDS: (Point2<f64>, Point2<f64>) = (Point2::new(-9.0, -9.0), Point2::new(9.0, 9.0));

    fn path(points: &[(f64, f64)]) -> Path {
        Path {
            points: points.iter().map(|&(x, y)| Point2::new(x, y)).collect(),
        }
    }

    fn length(pieces: &[Piece]) -> f64 {
        pieces.iter().map(Piece::length).sum()
    }

    #[test]
    fn a_right_angle_in_the_open_becomes_a_quarter_circle() {
        let space = SegmentSpace::new(vec![], 0.1, BOUNDS).unwrap();
        let angle = path(&[(0.0, 0.0), (2.0, 0.0), (2.0, 2.0)]);
        let pieces = smooth(&angle, &space);
        assert!((length(&pieces) - (2.0 + FRAC_PI_2)).abs() < 1e-12);
        assert!(
            (pieces[1].point(0.5) - Point2::new(1.0 + 0.5_f64.sqrt(), 1.0 - 0.5_f64.sqrt()))
                .length()
                < 1e-12
        );
        let back = smooth(&path(&[(0.0, 0.0), (2.0, 0.0), (1.0, 0.0)]), &space);
        assert!(matches!(back[1], Piece::Turn { turn, .. } if (turn.abs() - PI).abs() < 1e-12));
    }

    #[test]
    fn a_wall_in_the_corner_makes_the_arc_as_tight_as_it_has_to_be() {
        // A post on the diagonal: an arc of radius ρ about (2 - ρ, ρ) passes the corner at ρ (√2 -
        // 1).
        let off = 0.5;
        let post = Point2::new(2.0 - off * 0.5_f64.sqrt(), off * 0.5_f64.sqrt());
        let space = SegmentSpace::new(vec![Segment::new(post, post)], 0.3, BOUNDS).unwrap();
        let angle = path(&[(0.0, 0.0), (2.0, 0.0), (2.0, 2.0)]);
        let pieces = smooth(&angle, &space);
        let Piece::Arc { radius, .. } = pieces[1] else {
            panic!("no arc in {pieces:?}");
        };
        let widest = (off - 0.3) / (2.0_f64.sqrt() - 1.0);
        assert!((radius - widest).abs() < 0.01, "{radius} against {widest}");
    }

    proptest! {
        #[test]
        fn pieces_join_without_a_kink_and_stay_free(
            points in proptest::collection::vec((-4.0..4.0_f64, -4.0..4.0_f64), 3..8),
            wall in proptest::array::uniform4(-4.0..4.0_f64),
        ) {
            let wall = Segment::new(Point2::new(wall[0], wall[1]), Point2::new(wall[2], wall[3]));
            let wide = SegmentSpace::new(vec![wall], 0.4, BOUNDS).unwrap();
            let narrow = SegmentSpace::new(vec![wall], 0.2, BOUNDS).unwrap();
            let path = path(&points);
            prop_assume!(path.legs().all(|leg| wide.leg_is_free(&leg)));
            let pieces = smooth(&path, &narrow);
            prop_assert!(length(&pieces) <= path.length() + 1e-9);
            let (mut at, mut heading) = (path.points[0], None::<f64>);
            for piece in &pieces {
                prop_assert!((piece.point(0.0) - at).length() < 1e-8, "a gap before {piece:?}");
                at = piece.point(1.0);
                for i in 0..=50 {
                    let point = piece.point(f64::from(i) / 50.0);
                    prop_assert!(wall.distance(point) > 0.2 - 1e-9);
                }
                let (begins, ends) = match *piece {
                    Piece::Line(leg) => { let h = libm::atan2(leg.vector().y, leg.vector().x); (h, h) }
                    Piece::Arc { heading, radius, turn, .. } => {
                        prop_assert!(radius >= 0.1);
                        (heading, heading + turn)
                    }
                    Piece::Turn { turn, .. } => { let h = heading.unwrap_or(0.0); (h, h + turn) }
                };
                prop_assert!(heading.is_none_or(|h| wrap(h - begins).abs() < 1e-6), "a kink before {piece:?}");
                heading = Some(ends);
            }
            prop_assert!((at - path.points[path.points.len() - 1]).length() < 1e-8);
        }
    }
}
