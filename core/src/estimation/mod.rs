//! From odometry and matches to a pose with covariance, its map, and quality measures of both.

mod agreement;
mod block_cholesky;
mod consistency;
mod covariance;
mod drive_fit;
mod ekf_slam;
mod facing;
mod free_space;
mod grid_particles;
mod innovation;
mod line_localisation;
mod line_model;
mod loop_error;
mod map_alignment;
mod map_quality;
mod measures;
mod odometry_fit;
mod particles;
mod pose_graph;
mod reference;
mod relations;
mod scan_localisation;
mod scan_matching;
mod stamps;
mod submap;
mod sweep_smoother;
mod triangle;

pub use consistency::{ConsistencyWindow, Diagnosis, Figure};
pub use covariance::{Column, Covariance};
pub use drive_fit::DriveFit;
pub use ekf_slam::{
    Considered, Consistency, Correlations, Decision, EkfConfig, EkfError, EkfSlam, Explanation,
    Fix, Gate, Landmark, LandmarkId, LandmarkKinds, Match, MergeConfig, Merged, OdometryErrors,
    PointLandmark, Rejection, RobotState, SweepTiming, UpdateReport,
};
pub use grid_particles::{GridParticles, GridParticlesConfig, GridParticlesError};
pub use innovation::{FeatureCounts, Innovations, MeanInnovation, ScanFit};
pub use line_localisation::LineLocaliser;
pub use loop_error::LoopError;
pub use map_alignment::{
    AlignedBy, FEWEST_POINTS, MapAlignment, MapAlignmentError, MapPoints, align_map,
};
pub use map_quality::{
    ClosedLoop, MapJudgement, MapQuality, MapVerdict, Stretch, Tear, TearKind, Unjudgeable,
};
pub use measures::{Alignment, align, ate_rmse};
pub use odometry_fit::{Drive, DriveExtent, FittedParameter, OdometryFit, OdometryFitError};
pub use particles::{
    Bin, HistogramConfig, HistogramLocaliser, Hypothesis, JudgementConfig, KldConfig, Localisation,
    MonteCarlo, MonteCarloConfig, Particle, PoseQuality, RecentConfig,
};
pub use pose_graph::{
    Edge, EdgeId, Marginals, OpenLoop, Optimization, PoseGraph, information_at_end,
};
pub use reference::{AbsoluteErrors, absolute_errors, motions_over, revisits};
pub use relations::{RelationErrors, StampedMotion, relation_errors};
pub use scan_localisation::ScanLocaliser;
pub use scan_matching::{
    ClosureFate, ClosureRecord, Delay, EditError, EditKind, Join, LoopsClosed, MapLandmark,
    MapMergeError, MergedMaps, Proof, Pruned, Refusal, RemovalError, Residual, RestoreError,
    SavedMap, ScanMatcher, ScanMatcherConfig, ScanMatcherError, ShownEdit, ShownSubmap, Start,
};
pub use stamps::PosesByStamp;
pub use submap::{ClosureConfig, Doubt};
pub use sweep_smoother::{BeamPose, SweepSmoother};
pub use triangle::SymmetricMatrix;
