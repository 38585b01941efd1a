//! Groups particles into hypotheses: neighbouring particles form one hypothesis.
//!
//! In: weighted particles. Out: hypotheses, the heaviest first. Particles in the same bin, or in
//! bins that touch, belong together; the heading wraps at ±π.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};

use super::Particle;
use super::sampling::{Bin, KldConfig};
use crate::geom::{Pose2, PoseEstimate, symmetrize};

/// A pose that the robot may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hypothesis {
    /// Mean and covariance of its particles.
    pub estimate: PoseEstimate,
    /// Its share of the total weight, 0 to 1.
    pub weight: f64,
}

/// The hypotheses of particles whose weights sum to 1.
pub(in crate::estimation) fn hypotheses(
    particles: &[Particle],
    config: &KldConfig,
) -> Vec<Hypothesis> {
    let mut bins: BTreeMap<Bin, Vec<usize>> = BTreeMap::new();
    for (index, particle) in particles.iter().enumerate() {
        bins.entry(config.bin_of(&particle.pose))
            .or_default()
            .push(index);
    }
    let ends = [-PI, PI].map(|heading| (heading / config.bin_turn).floor() as i32);
    let mut found = vec![];
    while let Some((first, members)) = bins.pop_first() {
        let mut group = members;
        let mut front = vec![first];
        while let Some(bin) = front.pop() {
            for next in neighbours(bin, ends) {
                if let Some(members) = bins.remove(&next) {
                    group.extend(members);
                    front.push(next);
                }
            }
        }
        let group: Vec<Particle> = group
            .iter()
            .filter_map(|&i| particles.get(i))
            .copied()
            .collect();
        found.extend(moments(&group));
    }
    found.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    found
}

/// The bins around one; those of the heading run from `low` to `high` and wrap.
fn neighbours(bin: Bin, [low, high]: [i32; 2]) -> impl Iterator<Item = Bin> {
    let around = [-1, 0, 1];
    let turned = move |by: i32| match bin.turn + by {
        turn if turn < low => high,
        turn if turn > high => low,
        turn => turn,
    };
    let place = around
        .into_iter()
        .flat_map(move |dc| around.map(|dr| (dc, dr)));
    place.flat_map(move |(dc, dr)| {
        around.map(|by| Bin {
            col: bin.col + dc,
            row: bin.row + dr,
            turn: turned(by),
        })
    })
}

/// Mean and covariance; `None` if the weight is zero. The mean heading is taken about the heaviest
/// particle.
pub(super) fn moments(particles: &[Particle]) -> Option<Hypothesis> {
    let heaviest = particles
        .iter()
        .max_by(|a, b| a.weight.total_cmp(&b.weight))?;
    let weight: f64 = particles.iter().map(|p| p.weight).sum();
    if weight <= 0.0 {
        return None;
    }
    let off = |p: &Particle, from: &Pose2| p.pose.minus(from);
    let sum: Vector3<f64> = particles
        .iter()
        .map(|p| off(p, &heaviest.pose) * p.weight)
        .sum();
    let pose = heaviest.pose.plus(&(sum / weight));
    let cov = covariance_about(&pose, particles) / weight;
    Some(Hypothesis {
        estimate: PoseEstimate { pose, cov },
        weight,
    })
}

/// Weighted sum of squares of (x, y, θ) about a pose.
pub(in crate::estimation) fn covariance_about(
    pose: &Pose2,
    particles: &[Particle],
) -> Matrix3<f64> {
    let mut cov = Matrix3::zeros();
    for particle in particles {
        let off = particle.pose.minus(pose);
        cov += off * off.transpose() * particle.weight;
    }
    symmetrize(&mut cov);
    cov
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::wrap;

    fn particle(x: f64, y: f64, heading: f64, weight: f64) -> Particle {
        Particle {
            pose: Pose2::new(x, y, heading),
            weight,
        }
    }

    #[test]
    fn two_crowds_are_two_hypotheses_with_their_weights() {
        let mut all = vec![];
        for i in 0..10 {
            let s = 0.02 * f64::from(i);
            all.push(particle(s, -s, 0.3 + s, 0.07));
            all.push(particle(5.0 + s, 2.0, -1.0, 0.03));
        }
        let found = hypotheses(&all, &KldConfig::default());
        assert_eq!(found.len(), 2);
        assert!((found[0].weight - 0.7).abs() < 1e-12 && (found[1].weight - 0.3).abs() < 1e-12);
        let at = found[0].estimate.pose;
        assert!((at.x() - 0.09).abs() < 1e-12 && (at.heading() - 0.39).abs() < 1e-12);
        // The variance of 0, 0.02 … 0.18, each once.
        let variance = 0.02 * 0.02 * 99.0 / 12.0;
        assert!((found[0].estimate.cov[(0, 0)] - variance).abs() < 1e-12);
        assert!((found[0].estimate.cov[(0, 1)] + variance).abs() < 1e-12);
    }

    #[test]
    fn headings_on_both_sides_of_pi_are_one_hypothesis() {
        let all: Vec<_> = [-0.2, -0.1, 0.05, 0.1, 0.2]
            .map(|by| particle(0.0, 0.0, wrap(PI + by), 0.2))
            .to_vec();
        let found = hypotheses(&all, &KldConfig::default());
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(wrap(found[0].estimate.pose.heading() - PI - 0.01).abs() < 1e-12);
        // And opposite headings at one place are two.
        let both = [particle(0.0, 0.0, 0.0, 0.5), particle(0.0, 0.0, PI, 0.5)];
        assert_eq!(hypotheses(&both, &KldConfig::default()).len(), 2);
        assert!(hypotheses(&[], &KldConfig::default()).is_empty());
    }
}
