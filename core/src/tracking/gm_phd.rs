//! The Gaussian-mixture PHD filter: a density of objects over the plane, whose integral is their
//! number, without assigning sightings to objects.
//!
//! In: the sightings of a scan. Out: the mixture, and the objects in it.
//!
//! 1. Prediction: each component by constant velocity, its weight times the probability of survival
//!    (eq. 24); components that began at sightings of the scan before are added (eq. 21).
//! 2. Correction: an unseen component keeps 1 - P_D of its weight, and each sighting divides a
//!    weight of at most 1 among clutter and all components to which it may belong (eq. 30 to 33).
//! 3. Pruning and merging (table II): components of little weight are dropped, those near each
//!    other are merged, and at most [`MOST_COMPONENTS`] are kept.
//! 4. Objects are the components with a weight above one half (table III).
//!
//! Beyond the source: objects begin where something stands in free space that no component
//! explains, as in Ristic et al. (2012), instead of everywhere. And components carry the number of
//! their object through correction and merging, so that it has an identity (Panta, Clark & Vo
//! 2009); if two components have the same number, the heavier one keeps it.
//!
//! Source: Vo & Ma (2006), "The Gaussian mixture probability hypothesis density filter".

use std::collections::BTreeMap;

use super::config::TrackingConfig;
use super::kalman_tracks::{Object, SPEED_SIGMA};
use super::state::{ObjectState, Sighting};

/// Probability that an object is still there in the next scan.
const SURVIVAL: f64 = 0.99;
/// Weight of a new component.
const BORN: f64 = 0.2;
/// Components of less weight are dropped.
const PRUNED: f64 = 1e-4;
/// Components nearer together than this squared Mahalanobis distance are merged.
const MERGED: f64 = 4.0;
const MOST_COMPONENTS: usize = 100;
/// A component of more than this weight is an object.
const EXTRACTED: f64 = 0.5;
/// An object of less weight no longer exists.
const LEAST: f64 = 5e-3;
/// A sighting that is explained by components with more than this begins none.
const EXPLAINED: f64 = 0.1;

/// A component of the density.
#[derive(Clone, Copy, Debug)]
pub(super) struct Component {
    pub(super) weight: f64,
    pub(super) state: ObjectState,
    id: u32,
    /// Whether its newest sighting stands in free space.
    is_free: bool,
}

/// The density.
#[derive(Clone, Debug, Default)]
pub(super) struct GmPhd {
    components: Vec<Component>,
    /// The objects in it.
    objects: Vec<Object>,
    next_id: u32,
}

impl GmPhd {
    /// Takes the sightings of a scan, `seconds` after the one before.
    pub(super) fn update(&mut self, seconds: f64, sightings: &[Sighting], config: &TrackingConfig) {
        self.predict(seconds, SURVIVAL, config.acceleration);
        let explained = self.correct(sightings, config);
        self.merge();
        self.extract();
        for (sighting, explained) in sightings.iter().zip(explained) {
            if sighting.is_free && explained < EXPLAINED {
                self.begin(BORN, ObjectState::begun(sighting, SPEED_SIGMA));
            }
        }
    }

    pub(super) fn objects(&self) -> &[Object] {
        &self.objects
    }

    fn begin(&mut self, weight: f64, state: ObjectState) {
        self.components.push(Component {
            weight,
            state,
            id: self.next_id,
            is_free: true,
        });
        self.next_id += 1;
    }

    /// Step 1.
    fn predict(&mut self, seconds: f64, survival: f64, acceleration: f64) {
        for component in &mut self.components {
            component.weight *= survival;
            component.state = component.state.predicted(seconds, acceleration);
        }
    }

    /// Step 2; returns for each sighting the weight that components take of it.
    fn correct(&mut self, sightings: &[Sighting], config: &TrackingConfig) -> Vec<f64> {
        let predicted = self.components.clone();
        for component in &mut self.components {
            component.weight *= 1.0 - config.detection;
            component.is_free = false;
        }
        let mut explained = vec![];
        for sighting in sightings {
            let of = |component: &Component| {
                let innovation = component.state.innovation(sighting)?;
                let weight = config.detection * component.weight * innovation.likelihood;
                (innovation.d2 <= config.gate).then(|| Component {
                    weight,
                    state: component.state.corrected(&innovation),
                    is_free: sighting.is_free,
                    ..*component
                })
            };
            let own: Vec<Component> = predicted.iter().filter_map(of).collect();
            let sum: f64 = own.iter().map(|c| c.weight).sum();
            let all = config.clutter + sum;
            explained.push(sum / all);
            self.components.extend(own.into_iter().map(|c| Component {
                weight: c.weight / all,
                ..c
            }));
        }
        explained
    }

    /// Step 3.
    fn merge(&mut self) {
        let mut left = std::mem::take(&mut self.components);
        left.retain(|c| c.weight > PRUNED);
        left.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        while let Some(&heaviest) = left.first() {
            let is_near = |c: &Component| {
                let off = c.state.mean - heaviest.state.mean;
                let inverse = c.state.cov.try_inverse();
                inverse.is_some_and(|inverse| off.dot(&(inverse * off)) <= MERGED)
            };
            let mut near = vec![(heaviest.weight, heaviest.state)];
            let mut rest = vec![];
            for component in left.drain(..).skip(1) {
                match is_near(&component) {
                    true => near.push((component.weight, component.state)),
                    false => rest.push(component),
                }
            }
            left = rest;
            if let Some(state) = ObjectState::of_mixture(&near) {
                self.components.push(Component {
                    weight: near.iter().map(|(weight, _)| weight).sum(),
                    state,
                    ..heaviest
                });
            }
        }
        self.components
            .sort_by(|a, b| b.weight.total_cmp(&a.weight));
        self.components.truncate(MOST_COMPONENTS);
    }

    /// Step 4. An object that is momentarily hidden is the heaviest component with its number.
    fn extract(&mut self) {
        let mut known: BTreeMap<u32, Object> = BTreeMap::new();
        // Heaviest first.
        for component in &mut self.components {
            let is_there = component.weight > EXTRACTED;
            if known.contains_key(&component.id) {
                if !is_there {
                    continue;
                }
                component.id = self.next_id;
                self.next_id += 1;
            }
            if component.weight > LEAST {
                let seen = [is_there, is_there && component.is_free];
                let object = Object::of_mixture(component.id, component.state, seen);
                known.insert(component.id, object);
            }
        }
        self.objects = known.into_values().collect();
    }

    #[cfg(test)]
    pub(super) fn expected_count(&self) -> f64 {
        self.components.iter().map(|c| c.weight).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::state::tests::sighting;
    use super::*;
    use crate::geom::gaussian_pair;
    use nalgebra::Point2;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const STEP: f64 = 0.2;

    /// Always seen, always there, no clutter: the closed form is one Kalman filter, of weight 1.
    #[test]
    fn of_a_single_object_it_is_the_kalman_filter() {
        let config = TrackingConfig {
            detection: 1.0,
            clutter: 0.0,
            gate: f64::INFINITY,
            ..TrackingConfig::default()
        };
        let mut state = ObjectState::begun(&sighting(1.0, 2.0), 1.0);
        let mut phd = GmPhd::default();
        phd.begin(1.0, state);
        for number in 1..30 {
            let at = f64::from(number) * STEP;
            let seen = sighting(1.0 + at, 2.0 - 0.3 * at + 0.05 * libm::sin(7.0 * at));
            state = state.predicted(STEP, config.acceleration);
            state = state.corrected(&state.innovation(&seen).unwrap());
            phd.predict(STEP, 1.0, config.acceleration);
            phd.correct(&[seen], &config);
            phd.merge();
            phd.extract();
            let [found] = phd.objects() else {
                panic!("{} objects", phd.objects().len());
            };
            assert!((found.state.mean - state.mean).amax() < 1e-10);
            assert!((found.state.cov - state.cov).amax() < 1e-10);
            assert!((phd.expected_count() - 1.0).abs() < 1e-12 && found.id == 0);
        }
    }

    /// Computed by hand: one component of weight 0.8 at the sighting, P_D = 0.9, clutter 2/m². The
    /// unseen part weighs 0.08, the seen part 0.72 q / (2 + 0.72 q), with q the density at the
    /// sighting.
    #[test]
    fn one_correction_by_hand() {
        let config = TrackingConfig {
            clutter: 2.0,
            ..TrackingConfig::default()
        };
        let mut phd = GmPhd::default();
        let seen = sighting(0.0, 0.0);
        phd.begin(0.8, ObjectState::begun(&seen, 1.0));
        let explained = phd.correct(&[seen], &config);
        // Both variances are 0.0025 m².
        let q = 1.0 / (std::f64::consts::TAU * 0.005);
        let weight = 0.72 * q / (2.0 + 0.72 * q);
        assert!((explained[0] - weight).abs() < 1e-12);
        assert!((phd.expected_count() - 0.08 - weight).abs() < 1e-12);
    }

    /// Number of clutter sightings in a scan: Poisson, by products of uniform numbers (Knuth).
    fn poisson(mean: f64, rng: &mut ChaCha8Rng) -> usize {
        let (mut product, mut count) = (rng.random::<f64>(), 0);
        while product > libm::exp(-mean) {
            product *= rng.random::<f64>();
            count += 1;
        }
        count
    }

    /// Mean number of objects, expected and extracted, of five that walk straight on in an area of
    /// 20 by 20 m, seen nine times in ten amid eight false sightings a scan, with the filter set to
    /// these figures.
    fn counted(tells_births: bool) -> [f64; 2] {
        const SIDE: f64 = 20.0;
        const FALSE: f64 = 8.0;
        let config = TrackingConfig {
            clutter: FALSE / (SIDE * SIDE),
            detection: 0.9,
            ..TrackingConfig::default()
        };
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let (mut sums, mut count) = ([0.0; 2], 0.0);
        for _ in 0..20 {
            let mut phd = GmPhd::default();
            let mut number = || rng.random::<f64>() - 0.5;
            let mut places: Vec<[f64; 4]> = (0..OBJECTS)
                .map(|_| [8.0, 8.0, 2.0, 2.0].map(|range| range * number()))
                .collect();
            for [x, y, _, _] in places.iter().filter(|_| tells_births) {
                phd.begin(1.0, ObjectState::begun(&sighting(*x, *y), 1.0));
            }
            for number in 0..40 {
                let mut seen = vec![];
                let mut see = |x: f64, y: f64| {
                    seen.push(Sighting {
                        is_free: !tells_births,
                        ..sighting(x, y)
                    });
                };
                for [x, y, u, v] in &mut places {
                    (*x, *y) = (*x + *u * STEP, *y + *v * STEP);
                    let (a, b) = gaussian_pair(&mut rng);
                    if rng.random::<f64>() < config.detection {
                        see(*x + 0.05 * a, *y + 0.05 * b);
                    }
                }
                for _ in 0..poisson(FALSE, &mut rng) {
                    let mut place = || (rng.random::<f64>() - 0.5) * SIDE;
                    see(place(), place());
                }
                phd.update(STEP, &seen, &config);
                if number >= 10 {
                    // Before the components that have just begun.
                    let born = phd
                        .components
                        .iter()
                        .filter(|c| c.weight.to_bits() == BORN.to_bits());
                    sums[0] += phd.expected_count() - born.map(|c| c.weight).sum::<f64>();
                    sums[1] += phd.objects().iter().filter(|o| o.is_seen).count() as f64;
                    count += 1.0;
                }
            }
        }
        sums.map(|sum| sum / count)
    }

    const OBJECTS: usize = 5;

    /// Monte Carlo: if the filter is told where objects began, the expected number is the true one
    /// on average, and the objects just seen are extracted, nine in ten, because an unseen
    /// component keeps a tenth of its weight. If each false sighting may also begin an object, some
    /// of them are counted.
    #[test]
    fn it_counts_objects_amid_clutter() {
        let true_count = OBJECTS as f64;
        let [expected, extracted] = counted(true);
        assert!((expected - true_count).abs() < 0.15, "{expected} expected");
        assert!(
            (extracted - 0.9 * true_count).abs() < 0.15,
            "{extracted} extracted"
        );
        let [expected, extracted] = counted(false);
        assert!((expected - true_count).abs() < 0.7, "{expected} expected");
        assert!(
            (extracted - 0.9 * true_count).abs() < 0.7,
            "{extracted} extracted"
        );
    }

    /// Two objects that pass each other keep their numbers if the sightings tell them apart.
    #[test]
    fn numbers_stay_with_their_objects() {
        let config = TrackingConfig::default();
        let mut phd = GmPhd::default();
        let mut first = None;
        for number in 0..30 {
            let x = f64::from(number) * STEP - 3.0;
            phd.update(STEP, &[sighting(x, 0.8), sighting(-x, -0.8)], &config);
            let up = |o: &&Object| (o.state.position() - Point2::new(x, 0.8)).norm_squared() < 0.1;
            if number > 3 {
                let id = phd.objects().iter().find(up).unwrap().id;
                assert_eq!(*first.get_or_insert(id), id, "at {x}");
                assert_eq!(phd.objects().iter().filter(|o| o.is_seen).count(), 2);
            }
        }
    }
}
