//! How the pose is estimated.

use super::{ANY, BY_LINES, Group};
use crate::association::{AssociationConfig, AssociationMethod};
use crate::estimation::{
    ClosureConfig, Consistency, EkfConfig, GridParticlesConfig, LandmarkKinds, ScanMatcherConfig,
};
use crate::registration::RegistrationMethod;
use crate::settings::field::{Number, at, rows};
use crate::settings::setting::{
    Acts, CENTIMETRES, D2, DEGREES, DEGREES_PER_METRE, Field, METRES, NUMBER, PERCENT, Setting,
    one_of, real, si, switch, whole,
};
use crate::slam::{Method, PriorMapMatching};

const OF_FILTER: Group = Group {
    name: "Filter",
    methods: &[Method::LineEkf],
    ..ANY
};

rows! { FILTER = OF_FILTER;
    "ekf.landmarks", "Landmarks are", one_of::<LandmarkKinds>(), [slam.ekf.landmarks].basic(),
        "What the filter keeps and finds again, in one state. Corners and posts are the points that \"Corners and posts\" looks for; the layer Landmarks shows them.";
    "ekf.association", "Lines are matched", one_of::<AssociationMethod>(), [slam.ekf.association.method].basic(),
        "One by one is faster. Together, one spoilt line cannot mislead the others.";
    "ekf.consistency", "Jacobians at", one_of::<Consistency>(), [slam.ekf.consistency].basic(),
        "At the newest estimates the filter believes to learn a heading that nothing measures.";
    "ekf.gate", "Gate of a match", real(AssociationConfig::GATE, D2), [slam.ekf.association.gate].methods(BY_LINES).basic(),
        "9.21 is 99 % of χ². Larger: more matches, more wrong ones.";
    "ekf.new_gate", "Gate of a new wall", real(AssociationConfig::NEW_GATE, D2), [slam.ekf.association.new_gate].methods(BY_LINES),
        "A line nearer than this to a known wall is no new one. Larger: fewer duplicates, new walls found later.";
    "ekf.ambiguity", "Second best is worse by", real(AssociationConfig::AMBIGUITY, D2), [slam.ekf.association.ambiguity].methods(BY_LINES),
        "Less clear matches are not used. Larger: fewer, safer matches.";
    "ekf.max_gap", "Gap within one wall", real(AssociationConfig::MAX_GAP, METRES), [slam.ekf.association.max_gap].methods(BY_LINES),
        "Farther along the same line begins another wall: less than a door. Larger: longer, fewer walls.";
    "ekf.confirm_sightings", "Sightings of a wall", whole(EkfConfig::CONFIRM_SIGHTINGS, NUMBER), [slam.ekf.confirm_sightings],
        "After so many a line counts as a wall. Larger: fewer false walls, later.";
    "ekf.patience", "Forgotten after", whole(EkfConfig::PATIENCE, si("scans")), [slam.ekf.patience],
        "A line that was not confirmed by then is forgotten. Larger: more false candidates are carried along.";
    "ekf.alpha_sigma", "Unknown of the direction", real(EkfConfig::ALPHA_SIGMA, DEGREES), [slam.ekf.alpha_sigma],
        "Added to what each fit says of α. Larger: more cautious.";
    "ekf.r_sigma", "Unknown of the distance", real(EkfConfig::R_SIGMA, CENTIMETRES), [slam.ekf.r_sigma],
        "Added to what each fit says of r. Larger: more cautious.";
    "ekf.point_sigma", "Unknown of a point", real(EkfConfig::POINT_SIGMA, CENTIMETRES), [slam.ekf.point_sigma],
        "Added to what is known of where a corner or a post is, along each axis. Larger: more cautious.";
    "ekf.shared_part", "Corners on walls believed", real(EkfConfig::SHARED_PART, PERCENT), [slam.ekf.shared_part],
        "Of beams that show a wall and a corner on it, the corner is believed so much and the wall the rest, so that no beam counts twice. 0: such corners are not used.";
    "ekf.prior_curvature", "Straight drives bend by", real(EkfConfig::PRIOR_CURVATURE, DEGREES_PER_METRE), [slam.ekf.odometry_prior.curvature].methods(BY_LINES).on_restart(),
        "How much a straight drive may always bend; the filter learns it. Larger: learnt sooner, trusted less. 0: not at all.";
    "ekf.prior_turn", "Turns are wrong by", real(EkfConfig::PRIOR_TURN_SCALE, PERCENT), [slam.ekf.odometry_prior.turn_scale].methods(BY_LINES).on_restart(),
        "Part by which turns may always be wrong; the filter learns it. Larger: learnt sooner, trusted less. 0: not at all.";
    "ekf.merge_gate", "Gate of a merger", real(EkfConfig::MERGE_GATE, D2), [slam.ekf.merge.gate],
        "Two walls that differ less become one. Larger: fewer duplicates, more wrong mergers.";
}

const OF_SCAN_MATCHING: Group = Group {
    name: "Scan matching",
    methods: &[Method::ScanMatching],
    acts: Acts::OnRestart,
    ..ANY
};

rows! { SCAN_MATCHING = OF_SCAN_MATCHING;
    "match.by", "Scans are matched by", one_of::<RegistrationMethod>(), [slam.matcher.matching.method],
        "What is made as small as possible: distances to lines, which let points slide along a wall, or to points, the first ICP, which needs many more iterations.";
    "match.keyframe_distance", "Distance between keyframes", real(ScanMatcherConfig::KEYFRAME_DISTANCE, METRES), [slam.matcher.keyframe_distance].basic(),
        "A scan is kept after this way. Larger: less work, a coarser map.";
    "match.keyframe_turn", "Turn between keyframes", real(ScanMatcherConfig::KEYFRAME_TURN, DEGREES), [slam.matcher.keyframe_turn],
        "A scan is kept after this turn. Larger: less work, a coarser map.";
    "match.submap_keyframes", "Keyframes of a submap", whole(ScanMatcherConfig::SUBMAP_KEYFRAMES, NUMBER), [slam.matcher.submap_keyframes],
        "Larger: more drift inside of a submap, less work.";
    "match.close_loops", "Loops are closed", switch(), [slam.matcher.close_loops].basic(),
        "Whether a place seen again corrects the trajectory.";
    "match.proof", "Proof of a loop", real(ClosureConfig::PROOF, NUMBER), [slam.matcher.closure.proof].needs("match.close_loops", &["on"]),
        "How much must speak for a place seen again, as a part of the usual. Larger: loops close later and more safely.";
    "match.min_agreement", "Agreement of a loop", real(ClosureConfig::MIN_AGREEMENT, PERCENT), [slam.matcher.closure.min_agreement].needs("match.close_loops", &["on"]),
        "Part of the surfaces that must agree. Larger: fewer, safer closures.";
    "known.by", "Finds itself by", one_of::<PriorMapMatching>(), [slam.prior_map_matching].methods(&[Method::PriorMap]).basic(),
        "What of a scan is found in a prior map: each straight wall, by the filter, or all that was hit at once, which a map of cells with furniture in it asks for.";
}

const OF_GRID_PARTICLES: Group = Group {
    name: "Grid particles",
    methods: &[Method::GridParticles],
    acts: Acts::OnRestart,
    ..ANY
};

rows! { GRID_PARTICLES = OF_GRID_PARTICLES;
    "mapping.particles", "Particles", whole(GridParticlesConfig::COUNT, NUMBER), [slam.grid_particles.count].basic(),
        "Each has a map of its own. Larger: longer loops close well, and each scan takes longer.";
    "mapping.distance", "Distance between scans", real(GridParticlesConfig::WAY, METRES), [slam.grid_particles.way].basic(),
        "A scan is taken into the maps after this way. Larger: less work, until scans no longer overlap.";
    "mapping.turn", "Turn between scans", real(GridParticlesConfig::TURN, DEGREES), [slam.grid_particles.turn],
        "A scan is taken into the maps after this turn. Larger: less work, until scans no longer overlap.";
    "mapping.sigma", "Unknown of a point", real(GridParticlesConfig::SIGMA, CENTIMETRES), [slam.grid_particles.sigma],
        "How far a point may be off its surface, by beam and map. Smaller: weights say more.";
    "mapping.independent", "Independent points", real(GridParticlesConfig::INDEPENDENT_POINTS, NUMBER), [slam.grid_particles.independent_points],
        "So many points of a scan say something of their own. Larger: weights say more, and fewer particles survive.";
    "mapping.news", "News of a scan", real(GridParticlesConfig::NEWS, PERCENT), [slam.grid_particles.news],
        "Part of a scan that those before did not say already. Larger: weights say more, and fewer particles are left when a loop closes.";
    "mapping.resample_below", "Drawn anew below", real(GridParticlesConfig::RESAMPLE_BELOW, PERCENT), [slam.grid_particles.resample_below],
        "Particles are drawn anew where their effective number falls below this part. Larger: more often, and maps are lost sooner.";
}
