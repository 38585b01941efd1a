//! In: what a sighting was compared with, and the landmark that it was matched to. Out: what would
//! flip this match: how far the sighting would have to shift, along one of its two axes alone, for
//! [`choose`](super::choose) to decide otherwise.
//!
//! 1. Moved by t along the axis e, d²(t) = (v + t e)ᵀ Z⁻¹ (v + t e) = a t² + 2 b t + d², with a =
//!    eᵀ Z⁻¹ e and b = eᵀ Z⁻¹ v (TDK 2016 eq. (3.12)).
//! 2. The sighting leaves the gate where d²(t) = g² (eq. (3.13)).
//! 3. A second landmark makes the match ambiguous where its d²(t) minus that of the match is
//!    `ambiguity`. One at the same place takes the sighting over where the two are equal, and one
//!    that has priority (confirmed, or not across a gap) as soon as its own gate is reached.
//! 4. On either side, the nearest of these counts.
//!
//! When the lines of a scan are matched together, the other lines matter too: they may hold a
//! sighting that this rule would drop, which no single number shows.

use std::cmp::Ordering;

use nalgebra::Vector2;

use super::{AssociationConfig, Candidate, Innovation};

/// A landmark that a sighting was compared with, and its distance from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compared {
    /// The landmark.
    pub candidate: Candidate,
    /// The sighting minus what was expected.
    pub innovation: Innovation,
}

/// What would flip a match on one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flip {
    /// How far the sighting would have to shift, in the unit of its axis; negative towards the
    /// other side.
    pub shift: f64,
    /// What happens to the match then.
    pub outcome: FlipOutcome,
}

/// How the match of a sighting would change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlipOutcome {
    /// It leaves the gate of its landmark.
    LeavesGate,
    /// This landmark, by its index, explains it nearly as well: the sighting is dropped.
    Ambiguous(usize),
    /// This landmark, by its index, takes the sighting over.
    TakenOver(usize),
}

/// What would flip the match of a sighting with `matched` if it were shifted along an axis, 0 or 1:
/// backwards and forwards. `others` are the other landmarks that it was compared with.
///
/// # Units    Shifts in the unit of the axis: rad and m of a line.
#[must_use]
pub fn flips(
    matched: &Compared,
    others: &[Compared],
    axis: usize,
    config: &AssociationConfig,
) -> [Option<Flip>; 2] {
    let own = Parabola::of(&matched.innovation, axis);
    let mut all: Vec<Flip> = vec![];
    let mut add = |outcome, shifts: [f64; 2]| {
        all.extend(shifts.map(|shift| Flip { shift, outcome }));
    };
    add(FlipOutcome::LeavesGate, own.less(config.gate).roots());
    for rival in others.iter().filter(|rival| !rival.candidate.is_beyond) {
        let its = Parabola::of(&rival.innovation, axis);
        let index = rival.candidate.index;
        let apart = rival.innovation.v - matched.innovation.v;
        let is_elsewhere = apart.amax() > config.same_place;
        let (theirs, ours) = (&rival.candidate, &matched.candidate);
        if is_elsewhere && (theirs.is_confirmed || !ours.is_confirmed) {
            // Between these roots the rival is near enough; it counts only inside its own gate.
            let near = its.minus(&own).less(config.ambiguity).roots();
            let enters = its.less(config.new_gate).roots();
            for shift in near.into_iter().chain(enters) {
                let is_near = its.at(shift) - own.at(shift) <= config.ambiguity + TIE;
                let is_inside = its.at(shift) <= config.new_gate + TIE;
                if is_near && is_inside {
                    add(FlipOutcome::Ambiguous(index), [shift, f64::NAN]);
                }
            }
        }
        // A landmark with priority only needs to be inside its gate; one of equal rank has to be
        // nearer.
        let rank = |c: &Candidate| (!c.is_confirmed, c.gap > 0.0);
        let takes_over = match rank(theirs).cmp(&rank(ours)) {
            Ordering::Less => its.less(config.gate).roots(),
            Ordering::Equal => its.minus(&own).roots(),
            Ordering::Greater => continue,
        };
        for shift in takes_over {
            if its.at(shift) <= config.gate + TIE {
                add(FlipOutcome::TakenOver(index), [shift, f64::NAN]);
            }
        }
    }
    let nearest = |is_there: fn(f64) -> bool| {
        let there = all.iter().filter(|flip| is_there(flip.shift));
        there
            .min_by(|a, b| a.shift.abs().total_cmp(&b.shift.abs()))
            .copied()
    };
    [nearest(|shift| shift < 0.0), nearest(|shift| shift > 0.0)]
}

/// Tolerance of d² where two borders meet: rounding.
const TIE: f64 = 1e-9;

/// a t² + 2 b t + c.
#[derive(Clone, Copy, Debug)]
struct Parabola {
    a: f64,
    b: f64,
    c: f64,
}

impl Parabola {
    /// d² of a sighting that is shifted along an axis.
    fn of(innovation: &Innovation, axis: usize) -> Self {
        let z = &innovation.cov;
        let determinant = z[(0, 0)] * z[(1, 1)] - z[(0, 1)] * z[(1, 0)];
        let other = 1 - axis.min(1);
        let along = axis.min(1);
        let v: Vector2<f64> = innovation.v;
        Self {
            a: z[(other, other)] / determinant,
            b: (z[(other, other)] * v[along] - z[(0, 1)] * v[other]) / determinant,
            c: innovation.d2,
        }
    }

    fn less(self, value: f64) -> Self {
        Self {
            c: self.c - value,
            ..self
        }
    }

    fn minus(self, other: &Self) -> Self {
        Self {
            a: self.a - other.a,
            b: self.b - other.b,
            c: self.c - other.c,
        }
    }

    fn at(self, t: f64) -> f64 {
        (self.a * t + 2.0 * self.b) * t + self.c
    }

    /// Where it is zero; NaN if there is no root.
    fn roots(self) -> [f64; 2] {
        let Self { a, b, c } = self;
        // From two numbers of the same sign, so nothing cancels.
        let q = -(b + (b * b - a * c).sqrt().copysign(b));
        [q / a, c / q].map(|t| if t.is_finite() { t } else { f64::NAN })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix2;
    use proptest::prelude::*;

    use super::*;
    use crate::association::{Choice, choose};

    /// A landmark whose distance from the sighting is `v`.
    fn compared(index: usize, v: [f64; 2], cov: [f64; 3], is_confirmed: bool) -> Compared {
        let cov = Matrix2::new(cov[0], cov[1], cov[1], cov[2]);
        let innovation = Innovation::new(v.into(), cov).unwrap();
        Compared {
            candidate: Candidate {
                index,
                d2: innovation.d2,
                gap: -1.0,
                is_beyond: false,
                is_confirmed,
                expected: [-v[0], -v[1]],
            },
            innovation,
        }
    }

    /// The decision of `choose` about the sighting shifted by `shift` along an axis.
    fn moved(all: &[Compared], axis: usize, shift: f64, config: &AssociationConfig) -> Choice {
        let candidates = all.iter().map(|each| {
            let mut v = each.innovation.v;
            v[axis] += shift;
            Candidate {
                d2: Innovation::new(v, each.innovation.cov).unwrap().d2,
                ..each.candidate
            }
        });
        choose(&candidates.collect::<Vec<_>>(), config)
    }

    #[test]
    fn alone_a_match_stands_as_far_as_its_gate_reaches() {
        let config = AssociationConfig::default();
        let one = compared(3, [0.01, 0.02], [1e-4, 0.0, 4e-4], true);
        // d² of α is 1, so r may contribute the rest.
        let most = 0.02 * (config.gate - 1.0).sqrt();
        let [nearer, farther] = flips(&one, &[], 1, &config);
        assert!((nearer.unwrap().shift - (-0.02 - most)).abs() < 1e-12);
        assert!((farther.unwrap().shift - (most - 0.02)).abs() < 1e-12);
        assert_eq!(nearer.unwrap().outcome, FlipOutcome::LeavesGate);
    }

    #[test]
    fn towards_a_second_wall_it_becomes_ambiguous_first() {
        let config = AssociationConfig::default();
        let cov = [1e-4, 0.0, 4e-4];
        // The second wall is 10 cm farther away: the sighting is 8 cm nearer than that.
        let walls = [[0.0, 0.02], [0.0, -0.08]].map(|v| v[1]);
        let [one, two] = [0, 1].map(|i| compared(i, [0.0, walls[i]], cov, true));
        let [_, farther] = flips(&one, &[two], 1, &config);
        // ((t - 0.08)² - (t + 0.02)²) / 0.02² = 4.
        let expected = (0.08 * 0.08 - 0.02 * 0.02 - 4.0 * 4e-4) / 0.2;
        assert!((farther.unwrap().shift - expected).abs() < 1e-12);
        assert_eq!(farther.unwrap().outcome, FlipOutcome::Ambiguous(1));
    }

    proptest! {
        /// The truth is the rule itself, evaluated step by step.
        #[test]
        fn up_to_a_flip_the_rule_chooses_the_same_and_behind_it_another(
            v in prop::array::uniform3((-3.0..3.0, -3.0..3.0)),
            variances in prop::array::uniform3((0.5..2.0, -0.4..0.4, 0.5..2.0)),
            confirmed in prop::array::uniform3(any::<bool>()),
            gaps in prop::array::uniform3(prop_oneof![Just(-1.0), Just(0.3)]),
            axis in 0usize..2,
        ) {
            let config = AssociationConfig::default();
            let all: Vec<Compared> = (0..3)
                .map(|i| {
                    let (a, c, b) = variances[i];
                    let mut one = compared(i, [v[i].0, v[i].1], [a, c, b], confirmed[i]);
                    one.candidate.gap = gaps[i];
                    one
                })
                .collect();
            let Choice::Match(best) = moved(&all, axis, 0.0, &config) else {
                return Ok(());
            };
            let others: Vec<Compared> = all.iter().filter(|each| each.candidate.index != best.index).copied().collect();
            let is_same = |shift| matches!(moved(&all, axis, shift, &config), Choice::Match(m) if m.index == best.index);
            for (flip, sign) in flips(&all[best.index], &others, axis, &config).into_iter().zip([-1.0, 1.0]) {
                // The gate ends every match.
                let flip = flip.unwrap();
                prop_assert!(flip.shift * sign > 0.0);
                prop_assert!(!is_same(flip.shift + sign * 1e-6), "{flip:?}");
                for part in 0..1000 {
                    let shift = flip.shift * f64::from(part) * 1e-3;
                    prop_assert!(is_same(shift), "{flip:?}, but another at {shift}");
                }
            }
        }
    }
}
