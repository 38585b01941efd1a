//! Closed sets that have no names in the core: each variant crosses by its name. The page must have
//! words for all of them.

use slamlab_core::estimation::Rejection;

/// Types of the page with the names of their variants. With `of`, a type follows an enum of the
/// core variant by variant; with `=`, it is converted back too.
macro_rules! names {
    ($($(#[$doc:meta])* $name:ident $(of $core:path)? $(= $same:path)? { $($variant:ident = $word:literal),+ $(,)? })+) => { $(
        $(#[$doc])*
        #[derive(
            Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, tsify::Tsify,
        )]
        #[expect(missing_docs, reason = "as in the core, or as its name says")]
        pub enum $name { $(#[serde(rename = $word)] $variant),+ }

        impl $name {
            /// All names in order.
            pub const NAMES: &[&'static str] = &[$($word),+];

            /// Its name.
            #[must_use]
            pub fn name(self) -> &'static str {
                Self::NAMES.get(self as usize).copied().unwrap_or_default()
            }
        }

        names!(@from $name $($core)? $($same)? { $($variant),+ });
        names!(@into $name $($same)? { $($variant),+ });
    )+ };
    (@from $name:ident { $($variant:ident),+ }) => {};
    (@from $name:ident $core:path { $($variant:ident),+ }) => {
        const _: () = {
            use $core as Core;
            impl From<&Core> for $name {
                fn from(core: &Core) -> Self {
                    match core { $(Core::$variant { .. } => Self::$variant),+ }
                }
            }
        };
    };
    (@into $name:ident { $($variant:ident),+ }) => {};
    (@into $name:ident $core:path { $($variant:ident),+ }) => {
        const _: () = {
            use $core as Core;
            impl From<$name> for Core {
                fn from(name: $name) -> Self {
                    match name { $($name::$variant => Self::$variant),+ }
                }
            }
        };
    };
}

pub(crate) use names;

names! {
    /// Who decides where to go.
    Mode of slamlab_core::pilot::Mode { Manual = "manual", GoTo = "goto", Explore = "explore" }
    /// What the pilot is doing, or how its task ended.
    TaskState {
        Idle = "idle", Driving = "driving", Closing = "closing", Homeward = "homeward", Scanning = "scanning", Waiting = "waiting",
        Finished = "finished", Failed = "failed",
    }
    /// A stage of the cycle.
    Stage of slamlab_core::pilot::Stage {
        Init = "init", Scan = "scan", Lines = "lines", Localise = "localise", Map = "map", Plan = "plan",
        Truncate = "truncate", Turn = "turn", Go = "go",
    }
    /// The severity of a notice: `good` is what somebody waited for.
    Level { Info = "info", Good = "good", Warn = "warn" }
    /// Why there is no path.
    NoPathKind of slamlab_core::plan::NoPath {
        StartBlocked = "start-blocked", GoalBlocked = "goal-blocked", Unreachable = "unreachable",
        Exhausted = "exhausted", NotOffered = "not-offered", BudgetSpent = "budget-spent",
    }
    /// Where planners search: among the true walls, on the map with unknown cells taken as free, or
    /// only in known cells.
    Ground { Truth = "truth", Map = "map", Known = "known" }
    /// The outcome of a placement of one submap in another, and why: accepted without a search or
    /// by proof; waiting to be judged, for proof, until it is believed possible, or until it is
    /// ahead of its rivals; refused; revoked.
    ClosureOutcome {
        KnownBefore = "known-before", Proved = "proved",
        NotJudged = "not-judged", TooLittleProof = "too-little-proof", BeyondBelief = "beyond-belief", Rivals = "rivals", Tears = "tears",
        Overruled = "overruled", PlacedElsewhere = "placed-elsewhere", NeverProved = "never-proved", Revoked = "revoked",
    }
    /// The diagnosis from the filter's consistency.
    DiagnosisName of slamlab_core::estimation::Diagnosis {
        Collecting = "collecting", Blind = "blind", Honest = "honest", WrongMatch = "wrong-match",
        HiddenDrift = "hidden-drift", NoisySightings = "noisy-sightings", Cautious = "cautious",
    }
    /// Whether the pose in a prior map can be trusted.
    LocalisationName of slamlab_core::estimation::Localisation {
        Localised = "localised", Ambiguous = "ambiguous", Lost = "lost",
    }
    /// What was decided about a line of the scan.
    Decision {
        Matched = "matched", Added = "added", Ambiguous = "ambiguous", OutsideGate = "outside-gate", Taken = "taken",
        OnAWall = "on-a-wall", Seam = "seam", Singular = "singular",
    }
    /// The kind of a landmark; a row of `LANDMARK` has its index in this list.
    LandmarkName { Wall = "wall", Corner = "corner", Post = "post" }
    /// The gate in which a candidate lies.
    Gate of slamlab_core::estimation::Gate { Match = "match", Near = "near", Far = "far", Beyond = "beyond" }
    /// The kind of a point in a scan.
    PointName of slamlab_core::features::PointKind {
        Corner = "corner", Spike = "spike", Crossing = "crossing", Circle = "circle",
    }
    /// Whether a tracked object moves.
    TrackMotionName of slamlab_core::tracking::TrackMotion {
        New = "new", Moving = "moving", Paused = "paused", Standing = "standing",
    }
    /// A field of the grid: distance to the nearest wall, how well a beam's end fits, the clearance
    /// around the robot's centre.
    FieldName { Distance = "distance", Likelihood = "likelihood", Room = "room" }
    /// The kind of a region of the topological map.
    RegionName of slamlab_core::map::RegionKind { Room = "room", Corridor = "corridor" }
    /// The verdict on a map.
    MapVerdictName of slamlab_core::estimation::MapVerdict { Good = "good", Doubtful = "doubtful", Torn = "torn" }
    /// Why a map cannot be judged.
    UnjudgeableName of slamlab_core::estimation::Unjudgeable {
        NoSurfaces = "no-surfaces", OneScan = "one-scan", Unmatched = "unmatched",
    }
    /// Why a map is torn at a place.
    TearName of slamlab_core::estimation::TearKind {
        Doubled = "doubled", Contradicted = "contradicted", Loose = "loose", Unproven = "unproven",
    }
    /// The verdict on a registration of two clouds.
    VerdictName of slamlab_core::registration::Verdict {
        Converged = "converged", Degenerate = "degenerate", TooFewPoints = "too-few-points",
        NotConverged = "not-converged", LocalMinimum = "local-minimum", Ambiguous = "ambiguous",
    }
    /// The axes of a map of starts.
    BasinAxesName of slamlab_core::registration::BasinAxes { ShiftTurn = "shift-turn", Place = "place" }
    /// The outcome of a start; a row of `BASIN` has its index in this list.
    BasinOutcomeName of slamlab_core::registration::BasinOutcome {
        Found = "found", LostAndSaysSo = "lost-and-says-so", WronglySure = "wrongly-sure",
    }
    /// The kind of a person's change to the map.
    EditName = slamlab_core::estimation::EditKind { Erase = "erase", Wall = "wall", Glass = "glass" }
    /// How σ of the range grows with the range.
    GrowthName = slamlab_core::points::Growth { Linear = "linear", Square = "square" }
    /// The variable of a ranger's characteristic, which is a polynomial.
    VariableName = slamlab_core::robot::Variable { Volts = "volts", PerVolt = "per-volt" }
    /// The kind of a setting's number: real, whole, off or on, or an index into a list.
    SettingKind of slamlab_core::settings::Kind { Real = "real", Whole = "whole", Switch = "switch", Choice = "choice" }
    /// What an alignment of maps is based on.
    AlignedName of slamlab_core::estimation::AlignedBy { Walls = "walls", Landmarks = "landmarks", Both = "both" }
    /// How poses of another file relate to a recording.
    PosesAs { Odometry = "odometry", Truth = "truth" }
    /// How a path of poses was placed.
    PathPlaced { Time = "time", Begin = "begin" }
    /// What can be saved.
    SavedKind {
        Map = "map", MapScale = "map-scale", MapRaw = "map-raw", OgMap = "og-map", Smap = "smap", Plan = "plan", Rooms = "rooms",
        Tum = "tum", Carmen = "carmen", Revolutions = "revolutions", Slamlab = "slamlab", G2o = "g2o",
    }
}

impl From<&slamlab_core::estimation::Decision> for Decision {
    fn from(decision: &slamlab_core::estimation::Decision) -> Self {
        use slamlab_core::estimation::Decision as Core;
        match decision {
            Core::Matched(_) => Self::Matched,
            Core::Added(_) => Self::Added,
            Core::Rejected(reason) => match reason {
                Rejection::Ambiguous => Self::Ambiguous,
                Rejection::OutsideGate => Self::OutsideGate,
                Rejection::Taken => Self::Taken,
                Rejection::OnAWall => Self::OnAWall,
                Rejection::Seam => Self::Seam,
                Rejection::Singular => Self::Singular,
            },
        }
    }
}

impl From<&slamlab_core::estimation::ClosureRecord> for ClosureOutcome {
    fn from(record: &slamlab_core::estimation::ClosureRecord) -> Self {
        use slamlab_core::estimation::{ClosureFate, Delay, Refusal};
        match record.fate {
            ClosureFate::Accepted { .. } if record.is_searched => Self::Proved,
            ClosureFate::Accepted { .. } => Self::KnownBefore,
            ClosureFate::Waiting { why } => match why {
                Delay::NotJudged => Self::NotJudged,
                Delay::TooLittleProof => Self::TooLittleProof,
                Delay::BeyondBelief => Self::BeyondBelief,
                Delay::Rivals => Self::Rivals,
                Delay::Tears => Self::Tears,
                Delay::Overruled => Self::Overruled,
            },
            ClosureFate::Refused { why } => match why {
                Refusal::PlacedElsewhere => Self::PlacedElsewhere,
                Refusal::NeverProved => Self::NeverProved,
            },
            ClosureFate::Revoked { .. } => Self::Revoked,
        }
    }
}
