//! Scan matching. It keeps keyframes, and redraws the map when a loop closure moves them, so it has
//! a map and a trajectory of its own.

use super::{EarlierMap, Estimator, PreparedScan, SlamConfig, SlamError, View};
use crate::estimation::ScanMatcher;
use crate::geom::PoseEstimate;
use crate::map::Evidence;
use crate::robot::Odometry;
use crate::tracking::Matched;

pub(super) fn begin(config: &SlamConfig) -> Result<Box<dyn Estimator>, SlamError> {
    let Some(EarlierMap { map, start }) = &config.saved_map else {
        return Ok(Box::new(ScanMatcher::new(config.matcher)?));
    };
    let mut matcher = map.matcher(config.matcher)?;
    matcher.go_on(*start);
    Ok(Box::new(matcher))
}

impl Estimator for ScanMatcher {
    fn predict(&mut self, odometry: &Odometry) -> Result<(), SlamError> {
        self.odometry(odometry);
        Ok(())
    }

    fn update(&mut self, scan: &PreparedScan) -> Result<Option<Evidence>, SlamError> {
        Self::update(self, &scan.points, &scan.direction_sigmas());
        Ok(None)
    }

    fn estimate(&self) -> PoseEstimate {
        Self::estimate(self)
    }

    fn matched(&self) -> Matched {
        let (motion, cov) = self.last_match();
        Matched { motion, cov }
    }

    fn view(&self) -> View<'_> {
        View {
            loop_closures: self.loop_closures(),
            graph: Some(self.graph()),
            map: Some(self),
            own_map: Some(self),
            scan_fit: self.last_fit(),
            ..View::default()
        }
    }

    fn finish(&mut self) {
        Self::finish(self);
    }

    fn editable(&mut self) -> Option<&mut ScanMatcher> {
        Some(self)
    }
}
