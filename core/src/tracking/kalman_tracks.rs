//! Tracks, each with a Kalman filter: sightings are assigned one to one, or by joint probabilities.
//!
//! In: the sightings of a scan. Out: the tracks, with corrections, new ones and ended ones.
//!
//! 1. All tracks are predicted to the instant of the scan.
//! 2. Nearest: the assignment of least total squared Mahalanobis distance, where a track without a
//!    sighting costs as much as the gate. JPDA: each track becomes the mixture over all sightings
//!    that may be its own, weighted by the marginal probabilities of the joint events and reduced
//!    to one Gaussian.
//! 3. A sighting in free space that certainly belongs to no track begins one.
//! 4. A track that was not seen for long ends, a new track sooner. A track whose position has
//!    become too uncertain ends as well, before it mistakes a pillar for its object.

use super::config::{TrackAssociation, TrackingConfig};
use super::state::{ObjectState, Sighting};
use crate::association::{Options, assign, joint_probabilities};

/// Standard deviation of the velocity of a new track, m/s.
pub(super) const SPEED_SIGMA: f64 = 0.8;
/// Number of sightings that confirm a track, and how long a track may go without one before that,
/// s.
const CONFIRMED: u32 = 3;
const UNCONFIRMED_COAST: f64 = 0.5;
/// A track less certain than this is lost, m.
const LOST_SIGMA: f64 = 0.4;
/// A sighting that belongs to a track with more than this probability begins none.
const EXPLAINED: f64 = 0.1;
/// A track counts as seen in a scan if it was with at least this probability.
const SEEN: f64 = 0.5;

/// A tracked object.
#[derive(Clone, Copy, Debug)]
pub(super) struct Object {
    pub(super) id: u32,
    pub(super) state: ObjectState,
    /// Whether it was seen in the newest scan, and in free space.
    pub(super) is_seen: bool,
    pub(super) is_free: bool,
    /// Number of sightings.
    sightings: u32,
    /// Time since it was last seen, s.
    unseen: f64,
}

/// Tracks with data association.
#[derive(Clone, Debug, Default)]
pub(super) struct KalmanTracks {
    tracks: Vec<Object>,
    next_id: u32,
}

impl KalmanTracks {
    /// Takes the sightings of a scan, `seconds` after the one before.
    pub(super) fn update(&mut self, seconds: f64, sightings: &[Sighting], config: &TrackingConfig) {
        for track in &mut self.tracks {
            track.state = track.state.predicted(seconds, config.acceleration);
            track.unseen += seconds;
            (track.is_seen, track.is_free) = (false, false);
        }
        let explained = match config.association {
            TrackAssociation::Nearest => self.take_nearest(sightings, config),
            TrackAssociation::Jpda | TrackAssociation::GmPhd => self.take_all(sightings, config),
        };
        self.tracks.retain(|track| {
            let is_known = track.sightings >= CONFIRMED;
            let coast = if is_known {
                config.coast
            } else {
                UNCONFIRMED_COAST
            };
            let sigma = track.state.position_cov().diagonal().max().sqrt();
            track.unseen <= coast && sigma <= LOST_SIGMA
        });
        for (sighting, explained) in sightings.iter().zip(explained) {
            if sighting.is_free && explained < EXPLAINED {
                self.tracks.push(Object {
                    id: self.next_id,
                    state: ObjectState::begun(sighting, SPEED_SIGMA),
                    is_seen: true,
                    is_free: true,
                    sightings: 1,
                    unseen: 0.0,
                });
                self.next_id += 1;
            }
        }
    }

    pub(super) fn objects(&self) -> &[Object] {
        &self.tracks
    }

    /// Assigns each sighting to at most one track; returns the probability that it belongs to any.
    fn take_nearest(&mut self, sightings: &[Sighting], config: &TrackingConfig) -> Vec<f64> {
        // In addition to the sightings there is a column for each track, for going without.
        let n = sightings.len();
        let costs: Vec<Vec<f64>> = (self.tracks.iter().enumerate())
            .map(|(number, track)| {
                let d2 = |s| track.state.innovation(s).map(|i| i.d2);
                let near = |s| {
                    d2(s)
                        .filter(|d2| *d2 <= config.gate)
                        .unwrap_or(f64::INFINITY)
                };
                let without = (0..self.tracks.len()).map(|other| {
                    if other == number {
                        config.gate
                    } else {
                        f64::INFINITY
                    }
                });
                sightings.iter().map(near).chain(without).collect()
            })
            .collect();
        let mut explained = vec![0.0; n];
        for (track, chosen) in self.tracks.iter_mut().zip(assign(&costs)) {
            let taken = chosen.and_then(|s| Some((s, sightings.get(s)?)));
            if let Some((number, sighting)) = taken
                && let Some(innovation) = track.state.innovation(sighting)
            {
                track.state = track.state.corrected(&innovation);
                track.see(sighting.is_free);
                explained[number] = 1.0;
            }
        }
        explained
    }

    /// JPDA: each track is corrected by all sightings that may be its own.
    fn take_all(&mut self, sightings: &[Sighting], config: &TrackingConfig) -> Vec<f64> {
        let options = |track: &Object| {
            let each = sightings
                .iter()
                .enumerate()
                .filter_map(|(number, sighting)| {
                    let innovation = track.state.innovation(sighting)?;
                    let weight = config.detection * innovation.likelihood / config.clutter;
                    (innovation.d2 <= config.gate).then_some((number, weight))
                });
            Options {
                missed: 1.0 - config.detection,
                sightings: each.collect(),
            }
        };
        let options: Vec<Options> = self.tracks.iter().map(options).collect();
        let mut explained = vec![0.0; sightings.len()];
        for (track, found) in self.tracks.iter_mut().zip(joint_probabilities(&options)) {
            let mut parts = vec![(found.missed, track.state)];
            let mut free = 0.0;
            for &(number, probability) in &found.sightings {
                let Some(sighting) = sightings.get(number) else {
                    continue;
                };
                if let Some(innovation) = track.state.innovation(sighting) {
                    free += if sighting.is_free { probability } else { 0.0 };
                    parts.push((probability, track.state.corrected(&innovation)));
                    explained[number] += probability;
                }
            }
            if let Some(state) = ObjectState::of_mixture(&parts) {
                track.state = state;
            }
            if 1.0 - found.missed >= SEEN {
                track.see(free >= SEEN);
            }
        }
        explained
    }
}

impl Object {
    fn see(&mut self, is_free: bool) {
        (self.is_seen, self.is_free, self.unseen) = (true, is_free, 0.0);
        self.sightings += 1;
    }

    /// An object of the mixture filter, which itself decides how long an object is kept.
    pub(super) fn of_mixture(id: u32, state: ObjectState, [is_seen, is_free]: [bool; 2]) -> Self {
        Self {
            id,
            state,
            is_seen,
            is_free,
            sightings: 0,
            unseen: 0.0,
        }
    }
}
