//! In: the candidate landmarks of one sighting. Out: which one it is, or that this is open.
//!
//! 1. Inside the gate, a confirmed landmark has priority over an unconfirmed one. A line that noise
//!    threw out of its wall's gate becomes a second landmark beside it. If both competed for later
//!    sightings, noise of one sign would go to one and of the other sign to the other, and both
//!    would become walls, each certain and wrong.
//! 2. A landmark whose known part overlaps the seen part has priority over one across a gap; after
//!    that, the nearer one in standard deviations wins.
//! 3. If a second landmark at another place explains the sighting nearly as well, the sighting is
//!    ambiguous, and dropped.
//! 4. A sighting just outside the gate is dropped too. Only what is far from every landmark is new.
//!
//! Why so cautious: an EKF cannot undo a wrong match, while a dropped sighting costs next to
//! nothing, because the next scan shows the wall again. Joint compatibility (`joint`) considers all
//! lines of a scan together.

use super::Paired;
use crate::bounds::{Bounds, NOT_NEGATIVE, OutOfBounds, POSITIVE, check, config, or_no_limit};
use crate::geom::CHI2_2DOF_99;

/// How the lines of a scan find their landmarks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AssociationMethod {
    /// Each line by itself, with the nearest landmark in its gate; dropped if two are equally near.
    /// Needs no memory of its own.
    Nearest,
    /// All lines of a scan together ([`super::JointSearch`]): for walls that are close and alike,
    /// poses less certain than the distance between walls, and corrupted lines. One such line,
    /// processed first while the robot turned and so was unsure of its heading, threw one of a
    /// hundred laps of `loop` off by 3 m; the other lines of its scan outvote it.
    #[default]
    Joint,
}

impl AssociationMethod {
    /// All of them, with their names in settings and for people.
    pub const ALL: [(&'static str, Self, &'static str); 2] = [
        ("nearest", Self::Nearest, "one by one (nearest)"),
        ("joint", Self::Joint, "together (JCBB)"),
    ];
}

config! {
    /// How near a sighting must be to its landmark.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct AssociationConfig {
        /// One by one or together. Default [`AssociationMethod::Joint`].
        pub method: AssociationMethod = AssociationMethod::default(),
        /// Largest d² of a match. Default 9.21, 99 % of χ² with 2 degrees of freedom. Larger: more
        /// matches, more wrong ones.
        pub gate: f64 = CHI2_2DOF_99,
        /// Smallest d² to every landmark of a new one. Default 25. Larger: fewer duplicates, new
        /// walls found later. Below [`Self::gate`] it counts as that.
        pub new_gate: f64 = 25.0,
        /// Matched together: largest d² of a line from where all other lines of its scan expect it.
        /// Default 13.82, 99.9 %. Growing: spoilt lines get in among many good ones.
        pub outlier_gate: f64 = 13.82,
        /// A second candidate must be this much worse in d². Default 4: e² times less likely.
        pub ambiguity: f64 = 4.0,
        /// Largest free distance between the seen and the known part of one wall, m. Default 0.5:
        /// less than a door.
        pub max_gap: f64 = 0.5,
        /// Candidates closer than this (m, and rad) to each other are the same place: then no
        /// ambiguity. Default 0.03.
        pub same_place: f64 = 0.03,
        /// Matched together: sets tried before the best one so far is taken, since the worst case
        /// grows exponentially. Default 5 000: a few milliseconds.
        pub most_sets: usize = 5_000,
    }
}

impl AssociationConfig {
    /// What [`Self::gate`] may be.
    pub const GATE: Bounds = [0.1, 100.0];
    /// What [`Self::new_gate`] may be.
    pub const NEW_GATE: Bounds = [0.1, 1000.0];
    /// What [`Self::ambiguity`] may be.
    pub const AMBIGUITY: Bounds = [0.0, 100.0];
    /// What [`Self::max_gap`] may be, m.
    pub const MAX_GAP: Bounds = [0.0, 10.0];

    /// Checks all settings. Gates and `max_gap` may be infinite: then they let everything pass.
    ///
    /// # Errors    [`OutOfBounds`] with the first one out of range.
    pub fn validate(&self) -> Result<(), OutOfBounds> {
        let limit = |figure, value, bounds| (figure, or_no_limit(value, bounds), bounds);
        check(&[
            limit("association.gate", self.gate, Self::GATE),
            limit("association.new_gate", self.new_gate, Self::NEW_GATE),
            limit("association.outlier_gate", self.outlier_gate, POSITIVE),
            ("association.ambiguity", self.ambiguity, Self::AMBIGUITY),
            limit("association.max_gap", self.max_gap, Self::MAX_GAP),
            ("association.same_place", self.same_place, NOT_NEGATIVE),
        ])
    }
}

/// A candidate landmark for a sighting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Index of the landmark.
    pub index: usize,
    /// Squared Mahalanobis distance.
    pub d2: f64,
    /// Free distance along the wall, m; 0 or less if the parts overlap.
    pub gap: f64,
    /// Whether the seen part lies too far along the line to be a part of this wall.
    pub is_beyond: bool,
    /// Whether it was seen often enough to be believed.
    pub is_confirmed: bool,
    /// Where the landmark is expected: α, rad, and signed r, m; of a point x and y, m.
    pub expected: [f64; 2],
}

/// What a sighting is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Choice {
    /// This landmark.
    Match(Candidate),
    /// One of several that cannot be distinguished.
    Ambiguous,
    /// Outside the gate of a landmark, but not far outside.
    NearMiss,
    /// No landmark so far.
    New,
}

/// Decides which landmark a sighting is.
///
/// # Source   TDK 2016 §3.2 (gate); the rest as the module says.
#[must_use]
pub fn choose(candidates: &[Candidate], config: &AssociationConfig) -> Choice {
    let mut best: Option<&Candidate> = None;
    for candidate in plausible(candidates, config.gate) {
        let rank = |c: &Candidate| (c.gap > 0.0, c.d2);
        if best.is_none_or(|b| rank(candidate) < rank(b)) {
            best = Some(candidate);
        }
    }
    let Some(best) = best else {
        return new_or_near(candidates, config);
    };
    let is_rival = |c: &Candidate| {
        let apart = c.expected.iter().zip(&best.expected);
        c.index != best.index
            && (c.is_confirmed || !best.is_confirmed)
            && c.d2 - best.d2 < config.ambiguity
            && apart
                .into_iter()
                .any(|(a, b)| (a - b).abs() > config.same_place)
    };
    if inside(candidates, config.new_gate).any(is_rival) {
        return Choice::Ambiguous;
    }
    Choice::Match(*best)
}

/// The landmarks inside the gate: the confirmed ones, or if there are none, the others.
pub fn plausible(candidates: &[Candidate], gate: f64) -> impl Iterator<Item = &Candidate> {
    let is_known = inside(candidates, gate).any(|c| c.is_confirmed);
    inside(candidates, gate).filter(move |c| c.is_confirmed == is_known)
}

fn inside(candidates: &[Candidate], gate: f64) -> impl Iterator<Item = &Candidate> {
    let is_inside = move |c: &&Candidate| !c.is_beyond && c.d2 <= gate;
    candidates.iter().filter(is_inside)
}

/// What a sighting is if it matches no landmark.
fn new_or_near(candidates: &[Candidate], config: &AssociationConfig) -> Choice {
    match inside(candidates, config.new_gate).next() {
        Some(_) => Choice::NearMiss,
        None => Choice::New,
    }
}

/// What a sighting is, after matching all of its scan together found it to be `paired`. The state
/// has moved since, so the pairing must still be near.
#[must_use]
pub fn choose_paired(
    candidates: &[Candidate],
    paired: Paired,
    config: &AssociationConfig,
) -> Choice {
    match paired {
        Paired::Landmark(index) => inside(candidates, config.new_gate)
            .find(|c| c.index == index)
            .map_or(Choice::NearMiss, |c| Choice::Match(*c)),
        Paired::Ambiguous => Choice::Ambiguous,
        Paired::Nothing => new_or_near(candidates, config),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(index: usize, d2: f64, gap: f64, r: f64) -> Candidate {
        Candidate {
            index,
            d2,
            gap,
            is_beyond: gap > 0.5,
            is_confirmed: true,
            expected: [0.0, r],
        }
    }

    fn check(candidates: &[Candidate], expect: Choice) {
        assert_eq!(choose(candidates, &AssociationConfig::default()), expect);
    }

    #[test]
    fn setting_out_of_range_is_named() {
        let fine = AssociationConfig::default();
        assert_eq!(fine.validate(), Ok(()));
        for bad in [
            AssociationConfig {
                gate: f64::NAN,
                ..fine
            },
            AssociationConfig { gate: 0.0, ..fine },
            AssociationConfig {
                new_gate: 0.0,
                ..fine
            },
            AssociationConfig {
                outlier_gate: -1.0,
                ..fine
            },
            AssociationConfig {
                ambiguity: -1.0,
                ..fine
            },
            AssociationConfig {
                max_gap: f64::NAN,
                ..fine
            },
            AssociationConfig {
                same_place: -0.1,
                ..fine
            },
        ] {
            let error = bad.validate().unwrap_err();
            let settings = format!("{bad:?}");
            let figure = error.figure.trim_start_matches("association.");
            let shown = format!("{figure}: {:?}", error.value);
            assert!(settings.contains(&shown), "{error} of {settings}");
        }
    }

    #[test]
    fn nothing_near_is_new() {
        check(&[], Choice::New);
        check(&[candidate(0, 30.0, -1.0, 1.0)], Choice::New);
    }

    #[test]
    fn collinear_wall_beyond_a_door_is_new() {
        check(&[candidate(0, 0.1, 0.9, 1.0)], Choice::New);
    }

    #[test]
    fn between_the_gates_nothing_is_decided() {
        check(&[candidate(0, 15.0, -1.0, 1.0)], Choice::NearMiss);
    }

    #[test]
    fn nearest_wins_where_it_is_clear() {
        let (a, b) = (candidate(0, 8.0, -1.0, 1.0), candidate(1, 1.0, -1.0, 1.5));
        check(&[a, b], Choice::Match(b));
    }

    #[test]
    fn two_explanations_are_none() {
        check(
            &[candidate(0, 2.0, -1.0, 1.0), candidate(1, 1.0, -1.0, 1.5)],
            Choice::Ambiguous,
        );
        // Even if the second is outside its own gate.
        check(
            &[candidate(0, 10.0, -1.0, 1.0), candidate(1, 7.0, -1.0, 1.5)],
            Choice::Ambiguous,
        );
    }

    #[test]
    fn of_two_walls_on_one_line_the_overlapping_one_is_meant() {
        let (a, b) = (candidate(0, 0.1, 0.3, 1.0), candidate(1, 0.2, -0.4, 1.01));
        check(&[a, b], Choice::Match(b));
    }

    #[test]
    fn paired_sighting_is_its_landmark_while_that_is_near() {
        let config = AssociationConfig::default();
        let near = [candidate(0, 1.0, -1.0, 1.0), candidate(1, 12.0, -1.0, 1.3)];
        let of = |paired| choose_paired(&near, paired, &config);
        assert_eq!(of(Paired::Landmark(1)), Choice::Match(near[1]));
        assert_eq!(of(Paired::Landmark(2)), Choice::NearMiss);
        assert_eq!(of(Paired::Ambiguous), Choice::Ambiguous);
        assert_eq!(of(Paired::Nothing), Choice::NearMiss);
        let none = choose_paired(&[], Paired::Nothing, &config);
        assert_eq!(none, Choice::New);
    }

    #[test]
    fn landmark_not_yet_confirmed_gets_only_what_no_wall_explains() {
        let wall = |d2| candidate(0, d2, -1.0, 1.0);
        let fresh = Candidate {
            is_confirmed: false,
            ..candidate(1, 1.0, -1.0, 1.1)
        };
        check(&[wall(8.0), fresh], Choice::Match(wall(8.0)));
        check(&[fresh], Choice::Match(fresh));
        check(&[wall(9.5), fresh], Choice::Match(fresh));
    }
}
