//! How scans are processed: points, lines, what is remembered in the blind zone, and what moves.

use super::{ANY, BY_LINES, Group};
use crate::features::{Hough, LineConfig, PointFeatureConfig, Ransac, SpikeForm, SplitRule};
use crate::points::{BreakRule, Growth, RangeSigma, SectorConfig, SectorRange};
use crate::settings::Settings;
use crate::settings::field::{Number, at, rows};
use crate::settings::setting::{
    CENTIMETRES, D2, DEGREES, Field, METRES, NUMBER, Named, PERCENT, SECONDS, SIGMAS,
    SQUARE_METRES, Setting, named, one_of, real, si, switch, whole,
};
use crate::tracking::{TrackAssociation, TrackingConfig};

const OF_POINTS: Group = Group {
    name: "Points",
    ..ANY
};
/// Stands for "no limit".
const FAR: f64 = 1000.0;
const OWN: &[&str] = &["linear", "square"];

rows! { POINTS = OF_POINTS;
    "points.min_range", "Nearest range used", real([0.0, 5.0], METRES), [slam.points.min_range],
        "Nearer readings are dropped: the robot's own body. Larger: near obstacles are not seen either.";
    "points.max_range", "Farthest range used", real([0.1, FAR], METRES),
        [get |s| Some(s.slam.points.max_range.min(FAR)), set |s, v| s.slam.points.max_range = if v < FAR { v } else { f64::INFINITY }].basic(),
        "Farther readings count as no return. Larger: more, and less certain, points. 1000 m leaves it to the sensor.";
    "points.sector", "Width of a sector", real([0.0, 1.5], DEGREES),
        [get |s| Some(s.slam.sectors.map_or(0.0, |sectors| sectors.width)),
         set |s, v| s.slam.sectors = (v > 0.0).then(|| SectorConfig { width: v, ..s.slam.sectors.unwrap_or_default() })],
        "One reading stands for all of a sector (Celej: 10°). 0: every beam counts. Wide sectors leave no lines to find the pose by: it drifts with the wheels.";
    "points.sector_no_returns", "No returns that are errors", whole([0.0, 1000.0], NUMBER), [Some(sectors) = slam.sectors => sectors.no_returns].needs_more_than_zero("points.sector"),
        "With sectors: so many in one do not count. More of them, and nothing is there.";
    "points.sector_range", "Reading of a sector", one_of::<SectorRange>(), [Some(sectors) = slam.sectors => sectors.range].needs_more_than_zero("points.sector"),
        "With sectors: the least range is the cautious one; the mean has less noise and smooths away what stands out.";
    "points.sigma", "σ of the ranges", named(3, || Named::all(&[("sensor", "as the sensor says"), ("linear", "a + b ρ"), ("square", "a + b ρ²")])),
        [get growth, set set_growth],
        "Own figures for σ(ρ), as estimated from scans taken standing.";
    "points.sigma_constant", "σ at zero range", real([-1.0, 1.0], CENTIMETRES), [Some(sigma) = slam.points.sigma => sigma.constant].needs("points.sigma", OWN),
        "a of σ(ρ). Larger: all points are trusted less.";
    "points.sigma_slope", "Growth of σ with the range", real([-1.0, 1.0], si("m/m, m/m²")), [Some(sigma) = slam.points.sigma => sigma.slope].needs("points.sigma", OWN),
        "b of σ(ρ), with the range or with its square. Larger: far points are trusted less.";
    "points.sigma_least", "Least σ", real([1e-5, 1.0], CENTIMETRES), [Some(sigma) = slam.points.sigma => sigma.least].needs("points.sigma", OWN),
        "σ is never believed smaller than this.";
}

const OF_LINES: Group = Group {
    name: "Lines",
    methods: BY_LINES,
    ..ANY
};
const SPLIT: &str = "lines.rule";
const BREAKS: &str = "lines.breaks";

rows! { LINES = OF_LINES;
    "lines.rule", "How lines are found", one_of::<SplitRule>(), [slam.lines.split].basic(),
        "By splitting a run of points in two: beyond what noise explains, beyond a fixed distance, or where a regression gets worse. Or by looking for lines among its points: through random pairs of them, or by votes.";
    "lines.split_k", "Split at k standard deviations", real(LineConfig::SPLIT_K, SIGMAS), [SplitRule::NoiseAware(rule) = slam.lines.split => rule.split_k].needs(SPLIT, &["noise-aware"]),
        "A point farther off splits. Larger: fewer true walls are torn, shallow corners stay undetected.";
    "lines.max_residual", "Point left out beyond", real(LineConfig::MAX_RESIDUAL, SIGMAS), [SplitRule::NoiseAware(rule) = slam.lines.split => rule.max_residual].needs(SPLIT, &["noise-aware"]),
        "A point so far off its line does not count for it. Larger: outliers bend lines.";
    "lines.threshold", "Split beyond", real(LineConfig::THRESHOLD, CENTIMETRES), [SplitRule::Classic(rule) = slam.lines.split => rule.threshold].needs(SPLIT, &["classic"]),
        "A point farther from its line splits. Larger: fewer walls torn by noise, fewer shallow corners.";
    "lines.max_error", "Largest error of a line", real(LineConfig::MAX_ERROR, SQUARE_METRES), [SplitRule::Pilch(rule) = slam.lines.split => rule.max_error].needs(SPLIT, &["explained"]),
        "Sum of squared distances at which a growing line ends. Larger: longer lines, also around corners.";
    "lines.min_r2", "Least explained scatter", real(LineConfig::MIN_R2, PERCENT), [SplitRule::Pilch(rule) = slam.lines.split => rule.min_r2].needs(SPLIT, &["explained"]),
        "Part of the scatter (r²) that a line explains. Larger: straighter lines, in more pieces.";
    "lines.start_points", "Points that begin a line", whole([2.0, 50.0], NUMBER), [SplitRule::Pilch(rule) = slam.lines.split => rule.min_points].needs(SPLIT, &["explained"]),
        "So many neighbours in a row begin a line that grows. Larger: fewer, surer lines.";
    "lines.inlier_sigmas", "On a line within", real(LineConfig::INLIER_SIGMAS, SIGMAS), [SplitRule::Ransac(Ransac { inlier_sigmas, .. }) | SplitRule::Hough(Hough { inlier_sigmas, .. }) = slam.lines.split => inlier_sigmas].needs(SPLIT, &["ransac", "hough"]),
        "A point nearer to a line is on it. Larger: shallow corners stay undetected.";
    "lines.confidence", "Probability of the longest wall", real(LineConfig::CONFIDENCE, PERCENT), [SplitRule::Ransac(rule) = slam.lines.split => rule.confidence].needs(SPLIT, &["ransac"]),
        "That two points of it at least are drawn together. Larger: more samples, fewer walls overlooked.";
    "lines.max_samples", "Most samples for a line", whole(LineConfig::MAX_SAMPLES, NUMBER), [SplitRule::Ransac(rule) = slam.lines.split => rule.max_samples].needs(SPLIT, &["ransac"]),
        "Larger: short walls among many points are found too; slower.";
    "lines.seed", "Seed of the samples", whole([0.0, 1_000_000.0], NUMBER), [SplitRule::Ransac(rule) = slam.lines.split => rule.seed].needs(SPLIT, &["ransac"]),
        "Another one draws other pairs of points: what changes with it was found by luck.";
    "lines.alpha_step", "Step of the direction", real(LineConfig::ALPHA_STEP, DEGREES), [SplitRule::Hough(rule) = slam.lines.split => rule.alpha_step].needs(SPLIT, &["hough"]),
        "Between two directions that are voted for. Larger: faster; long walls are torn.";
    "lines.r_step", "Step of the distance", real(LineConfig::R_STEP, CENTIMETRES), [SplitRule::Hough(rule) = slam.lines.split => rule.r_step].needs(SPLIT, &["hough"]),
        "Between two distances that are voted for. Larger: walls closer than that are one at first.";
    "lines.breaks", "Neighbours belong together", one_of::<BreakRule>(), [slam.lines.segmentation.rule],
        "When two neighbouring points may lie on one wall: by what a wall seen at a flat angle would give, by ν times the mean distance, or by the sensor's own spacing.";
    "lines.grazing_angle", "Flattest view of a wall", real(LineConfig::GRAZING_ANGLE, DEGREES), [BreakRule::Adaptive { grazing_angle, .. } = slam.lines.segmentation.rule => grazing_angle].needs(BREAKS, &["adaptive"]),
        "A wall seen at a flatter angle is not followed. Larger: more breaks on long walls, fewer walls joined across a depth step.";
    "lines.break_sigmas", "Noise between neighbours", real(LineConfig::BREAK_SIGMAS, SIGMAS), [BreakRule::Adaptive { n_sigmas, .. } = slam.lines.segmentation.rule => n_sigmas].needs(BREAKS, &["adaptive"]),
        "Allowed on top, of the difference of two ranges. Larger: fewer breaks.";
    "lines.break_ratio", "Break beyond", real(LineConfig::BREAK_RATIO, si("×")), [BreakRule::MeanRatio { ratio } | BreakRule::Spacing { ratio, .. } = slam.lines.segmentation.rule => ratio].needs(BREAKS, &["mean-ratio", "spacing"]),
        "ν: times the mean distance of neighbours (TDK 2016: 4 to 5), or times the sensor's spacing (Pilch 2016: 2). Larger: fewer breaks.";
    "lines.spacing_slope", "Spacing of the beams", real(LineConfig::SPACING_SLOPE, DEGREES), [BreakRule::Spacing { spacing, .. } = slam.lines.segmentation.rule => spacing.slope].needs(BREAKS, &["spacing"]),
        "Angle between two beams of the sensor. Larger: fewer breaks.";
    "lines.spacing_offset", "Spacing at zero range", real(LineConfig::SPACING_OFFSET, CENTIMETRES), [BreakRule::Spacing { spacing, .. } = slam.lines.segmentation.rule => spacing.offset].needs(BREAKS, &["spacing"]),
        "Added to the distance that the angle gives. Larger: fewer breaks near the robot.";
    "lines.max_step", "Largest step in bearing", real(LineConfig::MAX_STEP, DEGREES), [slam.lines.segmentation.max_step],
        "Points farther apart in bearing are not of one wall. Larger: lines go on over lost beams.";
    "lines.gap_points", "Points between merged lines", whole([0.0, 50.0], NUMBER), [slam.lines.merge.gap_points],
        "Two lines become one over at most so many points of neither. Larger: longer lines, over things that stand in front.";
    "lines.gap", "Gap between merged lines", real(LineConfig::GAP, CENTIMETRES), [slam.lines.merge.gap],
        "Two lines become one over at most this distance: less than a door. Larger: longer lines.";
    "lines.across_runs", "Merge across gaps", switch(), [slam.lines.merge.across_runs],
        "On: two lines become one also where the points between do not belong together, as behind a pillar.";
    "lines.trim", "Points given up at the ends", whole([0.0, 10.0], NUMBER), [slam.lines.accept.trim],
        "Larger: shorter lines and a more honest map.";
    "lines.min_points", "Fewest points", whole([3.0, 100.0], NUMBER), [slam.lines.accept.min_points],
        "Larger: fewer, safer lines.";
    "lines.min_length", "Shortest line", real(LineConfig::MIN_LENGTH, METRES), [slam.lines.accept.min_length].basic(),
        "Shorter ones are people and pillars more often than walls. Larger: fewer, safer lines.";
    "lines.max_alpha_sigma", "Largest σ of the direction", real(LineConfig::MAX_ALPHA_SIGMA, DEGREES), [slam.lines.accept.max_alpha_sigma],
        "Less certain lines are left out: what is linear at 2° is not at 6°. Larger: more lines, a less honest filter.";
    "lines.max_chi2_sigmas", "Largest misfit", real(LineConfig::MAX_SIGMAS, SIGMAS), [slam.lines.accept.max_chi2_sigmas],
        "χ² of the residuals above its mean, in standard deviations. Larger: lines across corners are kept.";
    "lines.max_bend_sigmas", "Largest bend", real(LineConfig::MAX_SIGMAS, SIGMAS), [slam.lines.accept.max_bend_sigmas],
        "More bent ones are pillars. Larger: round things become lines.";
    "lines.surface_sigma", "Roughness of walls", real(LineConfig::SURFACE_SIGMA, CENTIMETRES), [slam.lines.accept.surface_sigma],
        "How far from flat a wall may be, one standard deviation. Larger: lines are trusted less.";
}

const OF_POINT_FEATURES: Group = Group {
    name: "Corners and posts",
    ..ANY
};
const CORNERS: &str = "features.corners";
const CROSSINGS: &str = "features.crossings";
const SPIKES: &str = "features.spikes";
const CIRCLES: &str = "features.circles";
const ON: &[&str] = &["on"];

rows! { POINT_FEATURES = OF_POINT_FEATURES;
    "features.corners", "Look for corners", switch(), [slam.point_features.corners.is_on],
        "Where a row of neighbouring points bends (Pilch 2016: sliding window). They are shown on the map; no method uses them.";
    "features.half_window", "Points on either side", whole(PointFeatureConfig::HALF_WINDOW, NUMBER), [slam.point_features.corners.half_window].needs(CORNERS, ON),
        "5, 6 or 7: windows of 11, 13 and 15 points. Larger: less noise, larger corners.";
    "features.min_angle", "Sharpest corner", real(PointFeatureConfig::CORNER_ANGLE, DEGREES), [slam.point_features.corners.min_angle].needs(CORNERS, ON),
        "Smaller angles are no corners (Pilch 2016: 40°).";
    "features.max_angle", "Flattest corner", real(PointFeatureConfig::CORNER_ANGLE, DEGREES), [slam.point_features.corners.max_angle].needs(CORNERS, ON),
        "Larger angles are no corners (Pilch 2016: 143°). Larger: walls become corners by noise.";
    "features.back_checks", "Neighbours checked again", whole(PointFeatureConfig::BACK_CHECKS, NUMBER), [slam.point_features.corners.back_checks].needs(CORNERS, ON),
        "The angles to the nearest neighbours must be within the limits too (Pilch 2016: 4).";
    "features.back_check_sigmas", "Slack of that check", real(PointFeatureConfig::BACK_CHECK_SIGMAS, SIGMAS), [slam.point_features.corners.back_check_sigmas].needs(CORNERS, ON),
        "By so much of its own noise an angle may miss the limits; 0 is the paper's. Larger: more corners, more wrong ones.";
    "features.max_stretch", "Longest vector per point", real(PointFeatureConfig::MAX_STRETCH, si("×")), [slam.point_features.corners.max_stretch].needs(CORNERS, ON),
        "In spacings of the beams (Pilch 2016: 1.5, which loses most corners of rooms). Larger: corners across gaps.";
    "features.leg_points", "Points of a leg at most", whole(PointFeatureConfig::LEG_POINTS, NUMBER), [slam.point_features.corners.leg_points].needs(CORNERS, ON),
        "The corner is where lines through its legs cross. Larger: better placed, where walls are straight.";
    "features.leg_sigma", "Largest σ of a leg's direction", real(LineConfig::MAX_ALPHA_SIGMA, DEGREES), [slam.point_features.corners.max_alpha_sigma].needs(CORNERS, ON),
        "Less certain corners are left out. Larger: more corners, less honest ellipses.";
    "features.crossings", "Look for crossings of lines", switch(), [slam.point_features.crossings.is_on],
        "Where lines found in a scan cross near both of them.";
    "features.crossing_angle", "Least angle of a crossing", real(PointFeatureConfig::CROSSING_ANGLE, DEGREES), [slam.point_features.crossings.min_angle].needs(CROSSINGS, ON),
        "Larger: fewer crossings, better placed.";
    "features.reach", "Crossing beside a line", real(PointFeatureConfig::REACH, CENTIMETRES), [slam.point_features.crossings.reach].needs(CROSSINGS, ON),
        "At most so far from where either wall was seen. Larger: also hidden corners, and places where nothing is.";
    "features.spikes", "Look for spikes", switch(), [slam.point_features.spikes.is_on],
        "What stands out in range: table legs, posts, edges; and whoever walks by.";
    "features.spike_form", "A spike is", one_of::<SpikeForm>(), [slam.point_features.spikes.form].needs(SPIKES, ON),
        "Both of Pilch's forms: one neighbour ends far behind it, or of three neighbours the middle one is nearest.";
    "features.spike_size", "Least spike", real(PointFeatureConfig::THRESHOLD, CENTIMETRES), [slam.point_features.spikes.threshold].needs(SPIKES, ON),
        "Jump of the range, or sum of both distances. Larger: fewer, clearer ones.";
    "features.spike_step", "Widest step beside a spike", real(LineConfig::MAX_STEP, DEGREES), [slam.point_features.spikes.max_step].needs(SPIKES, ON),
        "Points farther apart in bearing are no neighbours. Larger: spikes beside lost beams too.";
    "features.circles", "Look for circles", switch(), [slam.point_features.circles.is_on],
        "Posts and pillars that stand free (Hough transform).";
    "features.min_radius", "Smallest radius", real(PointFeatureConfig::RADIUS, CENTIMETRES), [slam.point_features.circles.min_radius].needs(CIRCLES, ON),
        "Thinner things are no circles.";
    "features.max_radius", "Largest radius", real(PointFeatureConfig::RADIUS, CENTIMETRES), [slam.point_features.circles.max_radius].needs(CIRCLES, ON),
        "Larger: slower, and bent walls become circles.";
    "features.cell", "Cell of the votes", real(PointFeatureConfig::CELL, CENTIMETRES), [slam.point_features.circles.cell].needs(CIRCLES, ON),
        "Larger: faster, coarser guesses.";
    "features.circle_points", "Fewest points of a circle", whole(PointFeatureConfig::CIRCLE_POINTS, NUMBER), [slam.point_features.circles.min_points].needs(CIRCLES, ON),
        "Larger: fewer, safer circles.";
    "features.min_arc", "Least arc seen", real(PointFeatureConfig::MIN_ARC, DEGREES), [slam.point_features.circles.min_arc].needs(CIRCLES, ON),
        "Larger: fewer, safer circles.";
    "features.circle_chi2", "Largest misfit of a circle", real(LineConfig::MAX_SIGMAS, SIGMAS), [slam.point_features.circles.max_chi2_sigmas].needs(CIRCLES, ON),
        "χ² of the residuals above its mean, in standard deviations. Larger: boxes become circles.";
    "features.radius_sigmas", "Least radius in its σ", real(LineConfig::MAX_SIGMAS, SIGMAS), [slam.point_features.circles.min_radius_sigmas].needs(CIRCLES, ON),
        "What is flat has a radius that is not known. Larger: fewer, better known circles.";
    "features.circle_gain", "Circle better than a bend by", real(PointFeatureConfig::MIN_GAIN, si("χ²")), [slam.point_features.circles.min_gain].needs(CIRCLES, ON),
        "By how much two straight lines must explain the points less well. Larger: fewer boxes become circles, fewer thin posts are found.";
}

const OF_BLIND_ZONE: Group = Group {
    name: "Blind zone",
    ..ANY
};

rows! { BLIND_ZONE = OF_BLIND_ZONE;
    "near.reach", "Remembered up to", real([0.0, 5.0], CENTIMETRES), [slam.blind_zone.reach],
        "Hits nearer than this are remembered from scan to scan, so that the robot does not drive into what it no longer sees. Larger: false hits stay longer.";
    "near.blind", "Looks far below", real([0.0, 1.0], CENTIMETRES), [slam.blind_zone.blind],
        "A wall nearer than the peak of an IR ranger's curve looks far: readings towards a remembered wall nearer than this are not used. 0 for a lidar. Larger: more readings are dropped.";
    "near.behind", "Gone if seen behind by", real([0.0, 1.0], CENTIMETRES), [slam.blind_zone.behind],
        "A beam that ends this far behind a remembered point says that it has gone. Larger: what has gone is remembered longer.";
    "near.beams", "Beams that speak of a point", real([0.0, 20.0], si("beams")), [slam.blind_zone.beams],
        "How far beside a remembered point a beam may pass and still say that it has gone, in angles between two beams. Larger: more is forgotten.";
}

const OF_MOVING: Group = Group {
    name: "Moving objects",
    ..ANY
};
const MOVING_ON: &str = "moving.on";

rows! { MOVING = OF_MOVING;
    "moving.on", "Follow what moves", switch(), [slam.tracking.is_on],
        "People are found where the map is free, and followed from scan to scan. It takes a lidar that looks round at least once a second.";
    "moving.keeps_out", "Keep it out of pose and map", switch(), [slam.tracking.keeps_out].needs(MOVING_ON, ON),
        "Points of what moves, or moved just before, are not used. Scan matching passes over most people by itself; recorded buildings came out no better with this, some worse.";
    "moving.association", "Which sighting is whose", one_of::<TrackAssociation>(), [slam.tracking.association].needs(MOVING_ON, ON),
        "Each sighting to the nearest track; to all that it may be, by the probabilities of all joint events; or to a density over where moving objects are (Vo & Ma 2006).";
    "moving.margin", "Farther from all that is not free", real(TrackingConfig::MARGIN, CENTIMETRES), [slam.tracking.margin].needs(MOVING_ON, ON),
        "A hit in free space is, beyond the doubt of the pose. Larger: who walks along a wall is found later, walls are taken for people more seldom.";
    "moving.max_width", "Widest thing that moves", real(TrackingConfig::MAX_WIDTH, CENTIMETRES), [slam.tracking.max_width].needs(MOVING_ON, ON),
        "Larger: groups and carts are followed, and so may walls be that are misplaced.";
    "moving.min_hits", "Fewest points of it", whole(TrackingConfig::MIN_HITS, NUMBER), [slam.tracking.min_hits].needs(MOVING_ON, ON),
        "Larger: fewer false tracks, people are seen less far away.";
    "moving.sigma", "σ of a sighting", real(TrackingConfig::POSITION_SIGMA, CENTIMETRES), [slam.tracking.position_sigma].needs(MOVING_ON, ON),
        "Of the middle of what is seen from one side. Larger: calmer tracks, that move later.";
    "moving.acceleration", "Noise of acceleration", real(TrackingConfig::ACCELERATION, si("m²/s³")), [slam.tracking.acceleration].needs(MOVING_ON, ON),
        "How fast velocities change. Larger: tracks follow faster and scatter more.";
    "moving.gate", "Gate of a track", real(TrackingConfig::GATE, D2), [slam.tracking.gate].needs(MOVING_ON, ON),
        "Sightings farther away are not of it. Larger: fewer lost tracks, more that take each other's sightings.";
    "moving.detection", "Seen in a scan", real(TrackingConfig::DETECTION, PERCENT), [slam.tracking.detection].needs(MOVING_ON, ON),
        "With what probability. Larger: what is hidden is forgotten sooner.";
    "moving.clutter", "False sightings", real(TrackingConfig::CLUTTER, si("1/m²")), [slam.tracking.clutter].needs(MOVING_ON, ON),
        "In each scan, for each square metre. Larger: tracks are begun and kept more cautiously.";
    "moving.coast", "Unseen for", real(TrackingConfig::SECONDS, SECONDS), [slam.tracking.coast].needs(MOVING_ON, ON),
        "A track that is not seen goes on for so long. Larger: people keep their number behind pillars, and false tracks stay.";
    "moving.significance", "Moves from here on", real(TrackingConfig::GATE, D2), [slam.tracking.significance].needs(MOVING_ON, ON),
        "Distance of its velocity from none. Larger: slow people are seen to move later.";
    "moving.memory", "May move on for", real(TrackingConfig::SECONDS, SECONDS), [slam.tracking.memory].needs(MOVING_ON, ON),
        "At most, and a second for each scan that saw them move: who stands still then belongs into the map. Larger: people who stop stay out of it for longer.";
}

fn growth(settings: &Settings) -> Option<f64> {
    Some(match settings.slam.points.sigma {
        None => 0.0,
        Some(sigma) if sigma.growth == Growth::Linear => 1.0,
        Some(_) => 2.0,
    })
}

/// A new growth starts with 1 cm and no slope.
fn set_growth(settings: &mut Settings, value: f64) {
    let growth = match value == 1.0 {
        true => Growth::Linear,
        false => Growth::Square,
    };
    let before = settings.slam.points.sigma.unwrap_or(RangeSigma {
        growth,
        constant: 0.01,
        slope: 0.0,
        least: 0.001,
    });
    settings.slam.points.sigma = (value != 0.0).then_some(RangeSigma { growth, ..before });
}
