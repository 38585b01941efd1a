//! Joint probabilistic data association: the probability that each sighting belongs to each track,
//! considering all of them together.
//!
//! In: for each track, the sightings within its gate, each with the likelihood that it belongs to
//! this track, divided by the density of clutter; and the likelihood of not being seen. Out: the
//! marginal probability of each pairing.
//!
//! 1. A joint event gives each track one of its sightings or none, and no sighting to two tracks.
//!    Its probability is proportional to the product of its likelihoods.
//! 2. Tracks that share no sighting, not even through others, are independent: each such component
//!    is summed by itself.
//! 3. Events are summed exactly, but not one by one. What the later tracks can do depends on the
//!    earlier ones only through the set of sightings already taken, so events with the same set are
//!    added up; sightings that no later track can take are ignored. A forward and a backward sum
//!    over the tracks give all marginals, as in a hidden Markov model. The work grows with the
//!    number of sets, not of events.
//! 4. Only beyond [`MOST_SETS`] sets are the least likely ones left out. That takes a dozen tracks
//!    that can all be any of a dozen sightings.
//!
//! Source: Fortmann, Bar-Shalom & Scheffe (1983), "Sonar tracking of multiple targets using joint
//! probabilistic data association"; step 3 is the exact sum of Horridge & Maskell (2006),
//! "Real-time tracking of hundreds of targets with efficient exact JPDAF implementation".

use std::collections::BTreeMap;

/// Most sets of taken sightings that are kept for a component.
const MOST_SETS: usize = 1 << 14;
/// Sightings that a set can hold; further ones of a component belong to no track.
const MOST_SIGHTINGS: usize = 128;

/// What a track may be in the newest scan, with likelihoods.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Likelihood of not being seen: 1 - P_D of the track.
    pub missed: f64,
    /// Indices of sightings, each with P_D N(z) / λ: the likelihood of being this one, divided by
    /// the density of clutter. Each index once.
    pub sightings: Vec<(usize, f64)>,
}

/// The marginal probabilities of what each track is, in the same form and order; those of a track
/// add up to 1. A track for which everything is impossible was not seen.
#[must_use]
pub fn joint_probabilities(tracks: &[Options]) -> Vec<Options> {
    let mut marginals = vec![Options::default(); tracks.len()];
    for component in components(tracks) {
        let members: Vec<&Options> = component.iter().filter_map(|&t| tracks.get(t)).collect();
        let own = marginals_of(&members);
        for (track, marginal) in component.into_iter().zip(own) {
            if let Some(place) = marginals.get_mut(track) {
                *place = marginal;
            }
        }
    }
    marginals
}

/// Step 2: indices of tracks that are connected by shared sightings.
fn components(tracks: &[Options]) -> Vec<Vec<usize>> {
    let mut found: Vec<(Vec<usize>, Vec<usize>)> = vec![];
    for (number, track) in tracks.iter().enumerate() {
        let mut members = vec![number];
        let mut sightings: Vec<usize> = track.sightings.iter().map(|(s, _)| *s).collect();
        let shares = |other: &(Vec<usize>, Vec<usize>)| {
            other
                .1
                .iter()
                .any(|s| track.sightings.iter().any(|(own, _)| own == s))
        };
        let (joined, apart): (Vec<_>, Vec<_>) = found.into_iter().partition(shares);
        for (others, theirs) in joined {
            members.extend(others);
            sightings.extend(theirs);
        }
        members.sort_unstable();
        found = apart;
        found.push((members, sightings));
    }
    found.into_iter().map(|(members, _)| members).collect()
}

/// Sums over events, by the set of sightings that they have taken.
type Sums = BTreeMap<u128, f64>;

/// Step 3.
fn marginals_of(tracks: &[&Options]) -> Vec<Options> {
    let mut numbers: Vec<usize> = tracks
        .iter()
        .flat_map(|track| track.sightings.iter().map(|(s, _)| *s))
        .collect();
    numbers.sort_unstable();
    numbers.dedup();
    let bit = |sighting: usize| {
        let place = numbers.binary_search(&sighting).ok();
        place.filter(|p| *p < MOST_SIGHTINGS).map(|p| 1_u128 << p)
    };
    let options = |track: &Options| -> Vec<(u128, f64)> {
        let seen = track.sightings.iter();
        let seen = seen.filter_map(|(s, weight)| Some((bit(*s)?, *weight)));
        std::iter::once((0, track.missed)).chain(seen).collect()
    };
    let options: Vec<Vec<(u128, f64)>> = tracks.iter().map(|track| options(track)).collect();
    // What the tracks after each one may be.
    let mut later = vec![0_u128; options.len()];
    for track in (1..options.len()).rev() {
        let own = options[track].iter().fold(0, |all, (bit, _)| all | bit);
        later[track - 1] = later[track] | own;
    }
    // Over the tracks before each one.
    let mut forward: Vec<Sums> = vec![Sums::from([(0, 1.0)])];
    for (own, later) in options.iter().zip(&later) {
        let before = forward.last().cloned().unwrap_or_default();
        let mut after = Sums::new();
        for (taken, sum) in before {
            for (bit, weight) in own.iter().filter(|(bit, _)| taken & bit == 0) {
                *after.entry((taken | bit) & later).or_insert(0.0) += sum * weight;
            }
        }
        forward.push(scaled(after));
    }
    // Over the tracks from each one on, given what is taken.
    let last = forward.last().cloned().unwrap_or_default();
    let mut backward: Sums = last.into_keys().map(|taken| (taken, 1.0)).collect();
    let mut marginals = vec![];
    let each = tracks.iter().zip(&options).zip(&later).zip(&forward);
    for (((track, own), later), before) in each.rev() {
        let mut sums = vec![0.0; own.len()];
        let mut from_here = Sums::new();
        for (taken, sum) in before {
            for ((bit, weight), place) in own.iter().zip(&mut sums) {
                if taken & bit == 0
                    && let Some(rest) = backward.get(&((taken | bit) & later))
                {
                    *place += sum * weight * rest;
                    *from_here.entry(*taken).or_insert(0.0) += weight * rest;
                }
            }
        }
        backward = scaled(from_here);
        let all: f64 = sums.iter().sum();
        let part = |sum: f64| if all > 0.0 { sum / all } else { 0.0 };
        let of = |sighting: usize| {
            let place = own.iter().position(|(b, _)| Some(*b) == bit(sighting));
            place
                .and_then(|p| sums.get(p))
                .map_or(0.0, |sum| part(*sum))
        };
        let sightings: Vec<_> = track.sightings.iter().map(|(s, _)| (*s, of(*s))).collect();
        let seen: f64 = sightings.iter().map(|(_, p)| p).sum();
        marginals.push(Options {
            missed: (1.0 - seen).max(0.0),
            sightings,
        });
    }
    marginals.reverse();
    marginals
}

/// Only ratios matter; step 4.
fn scaled(mut sums: Sums) -> Sums {
    let most = sums.values().copied().fold(0.0, f64::max);
    if most > 0.0 {
        sums.values_mut().for_each(|sum| *sum /= most);
    }
    if sums.len() > MOST_SETS {
        let mut by_weight: Vec<(u128, f64)> = sums.into_iter().collect();
        by_weight.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        by_weight.truncate(MOST_SETS);
        sums = by_weight.into_iter().collect();
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// All joint events, one by one: what each track is (0: not seen, else 1 + index among its
    /// sightings), and the likelihood.
    fn events(tracks: &[Options]) -> Vec<(Vec<usize>, f64)> {
        let mut all = vec![(vec![], vec![], 1.0)];
        for track in tracks {
            let mut next = vec![];
            for (chosen, taken, weight) in &all {
                let choose = |place: usize, sighting: Option<usize>, factor: f64| {
                    let (mut chosen, mut taken): (Vec<usize>, Vec<usize>) =
                        (chosen.clone(), taken.clone());
                    chosen.push(place);
                    taken.extend(sighting);
                    (chosen, taken, weight * factor)
                };
                next.push(choose(0, None, track.missed));
                for (place, (sighting, factor)) in track.sightings.iter().enumerate() {
                    if !taken.contains(sighting) {
                        next.push(choose(place + 1, Some(*sighting), *factor));
                    }
                }
            }
            all = next;
        }
        all.into_iter()
            .map(|(chosen, _, weight)| (chosen, weight))
            .collect()
    }

    fn check(tracks: &[Options]) -> Result<(), TestCaseError> {
        let events = events(tracks);
        let all: f64 = events.iter().map(|(_, weight)| weight).sum();
        let found = joint_probabilities(tracks);
        for (number, (track, found)) in tracks.iter().zip(&found).enumerate() {
            let expect = |place: usize| {
                let own = events.iter().filter(|(chosen, _)| chosen[number] == place);
                own.map(|(_, weight)| weight).sum::<f64>() / all
            };
            prop_assert!((found.missed - expect(0)).abs() < 1e-10, "{found:?}");
            for (place, (known, own)) in track.sightings.iter().zip(&found.sightings).enumerate() {
                prop_assert_eq!(known.0, own.0);
                prop_assert!((own.1 - expect(place + 1)).abs() < 1e-10, "{found:?}");
            }
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn marginals_are_the_sums_over_all_joint_events(
            gates in proptest::collection::vec(any::<u8>(), 0..6), weights in proptest::array::uniform32(1e-3..50.0_f64),
            missed in 0.01..0.9_f64, n_sightings in 0..5_usize,
        ) {
            let of = |(track, gate): (usize, &u8)| Options {
                missed: missed / (1 + track) as f64,
                sightings: (0..n_sightings)
                    .filter(|sighting| gate >> sighting & 1 == 1)
                    .map(|sighting| (7 * sighting, weights[track * 5 + sighting]))
                    .collect(),
            };
            let tracks: Vec<Options> = gates.iter().enumerate().map(of).collect();
            check(&tracks)?;
        }
    }

    /// Two tracks, of which the first may be either of two sightings and the second the second one
    /// only; P_D = 0.8. By hand, the events (track 1, track 2) weigh
    /// (-, -) 0.2 · 0.2 = 0.04, (1, -) 3 · 0.2 = 0.6, (2, -) 1 · 0.2 = 0.2, (-, 2) 0.2 · 2 = 0.4,
    /// (1, 2) 3 · 2 = 6; (2, 2) cannot be. Together 7.24.
    #[test]
    fn two_tracks_that_share_a_sighting_by_hand() {
        let tracks = [
            Options {
                missed: 0.2,
                sightings: vec![(1, 3.0), (2, 1.0)],
            },
            Options {
                missed: 0.2,
                sightings: vec![(2, 2.0)],
            },
        ];
        let found = joint_probabilities(&tracks);
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} instead of {b}");
        near(found[0].missed, 0.44 / 7.24);
        near(found[0].sightings[0].1, 6.6 / 7.24);
        near(found[0].sightings[1].1, 0.2 / 7.24);
        near(found[1].missed, 0.84 / 7.24);
        near(found[1].sightings[0].1, 6.4 / 7.24);
    }

    /// Twenty tracks in a row, each sharing a sighting with the next: more than a million events,
    /// in an instant; the middle ones are all alike.
    #[test]
    fn a_long_row_is_summed_without_trying_all_events() {
        let of = |track: usize| Options {
            missed: 0.1,
            sightings: vec![(track, 5.0), (track + 1, 5.0)],
        };
        let tracks: Vec<Options> = (0..40).map(of).collect();
        let found = joint_probabilities(&tracks);
        for (a, b) in found.iter().zip(found.iter().rev()) {
            // The row looks the same from the other end.
            assert!((a.sightings[0].1 - b.sightings[1].1).abs() < 1e-9);
            let sum = a.missed + a.sightings[0].1 + a.sightings[1].1;
            assert!((sum - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn what_is_impossible_was_not_seen() {
        assert_eq!(joint_probabilities(&[]), []);
        let nothing = Options {
            missed: 0.0,
            sightings: vec![(3, 0.0)],
        };
        let found = joint_probabilities(&[nothing]);
        assert_eq!((found[0].missed, found[0].sightings[0].1), (1.0, 0.0));
    }
}
