//! `kidnap`: does a kidnapped robot find itself again, and a robot that starts anywhere?
//!
//! 1. [`simulated`]: in `office`, by lidar, it drives to random places, is carried to another place
//!    after half a minute, and drives on; 50 seeds (`--seeds`).
//! 2. [`recorded`]: in the map of Intel, from 100 places along the log (`--data DIR`, with
//!    `intel/intel.clf` in it).
//!
//! Found means sure ([`Localisation::Localised`]) and right. A robot that starts anywhere must
//! never be sure and wrong; how long a kidnapped one takes to notice is reported. A few minutes of
//! one core.
//!
//! [`Localisation::Localised`]: slamlab_core::estimation::Localisation::Localised

mod recorded;
mod simulated;

use anyhow::Result;
use slamlab_core::estimation::Localisation;
use slamlab_core::geom::{Length, Pose2, wrap};
use slamlab_core::session::Session;

use super::{Args, Outcome};

/// A pose within these errors is right, m and rad.
const RIGHT: [f64; 2] = [0.3, 0.1];
/// A pose beyond one of these errors is wrong, m and rad.
const WRONG: [f64; 2] = [0.5, 0.3];

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let mut outcome = Outcome::default();
    simulated::measure(args, &mut outcome)?;
    recorded::measure(args, &mut outcome)?;
    Ok(outcome)
}

/// What a session believes, compared with the truth.
struct Belief {
    is_sure: bool,
    off: [f64; 2],
}

impl Belief {
    fn of(session: &Session, truth: &Pose2) -> Self {
        let quality = session.slam().view().pose_quality;
        let pose = session.estimate().pose;
        let way = (pose.position() - truth.position()).length();
        Self {
            is_sure: quality.is_some_and(|q| q.localisation == Localisation::Localised),
            off: [way, wrap(pose.heading() - truth.heading()).abs()],
        }
    }

    fn is_found(&self) -> bool {
        self.is_sure && self.off[0] < RIGHT[0] && self.off[1] < RIGHT[1]
    }

    fn is_deceived(&self) -> bool {
        self.is_sure && (self.off[0] > WRONG[0] || self.off[1] > WRONG[1])
    }
}
