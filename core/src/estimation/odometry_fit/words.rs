//! What was found, parameter by parameter, and what a drive did not show.

use super::{OdometryFit, PRIOR};

/// A standard error of a logarithm below which a coefficient of chance counts as known: within a
/// factor of two.
const KNOWN_LOG: f64 = std::f64::consts::LN_2;

/// A parameter of the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedParameter {
    /// Keys of the settings that take it: what the odometry is told, and how a simulated robot is;
    /// none for what follows from others.
    pub keys: &'static [&'static str],
    /// Its name for people.
    pub name: &'static str,
    /// Its unit; empty for a pure number.
    pub unit: &'static str,
    /// What was found.
    pub value: f64,
    /// Its standard error.
    pub sigma: f64,
    /// What the model says.
    pub model: f64,
    /// Whether the drive showed it.
    pub verdict: Verdict,
}

/// Whether a drive showed a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It did.
    Known,
    /// It did not, and why.
    Unknown(&'static str),
}

impl Verdict {
    /// Why it is not known; empty where it is.
    #[must_use]
    pub fn reason(self) -> &'static str {
        match self {
            Self::Known => "",
            Self::Unknown(why) => why,
        }
    }
}

impl OdometryFit {
    /// All parameters, with their doubts.
    #[must_use]
    pub fn parameters(&self) -> Vec<FittedParameter> {
        let mut all = self.tracks();
        all.extend(self.chance());
        all.extend(self.poses());
        all
    }

    /// Keys and numbers of the settings that take what is known.
    #[must_use]
    pub fn settings(&self) -> Vec<(&'static str, f64)> {
        let mut values = vec![];
        for parameter in self.parameters() {
            if parameter.verdict == Verdict::Known {
                values.extend(parameter.keys.iter().map(|key| (*key, parameter.value)));
            }
        }
        if values.iter().any(|(key, _)| key.starts_with("wear.")) {
            values.insert(0, ("wear.given", 1.0));
        }
        values
    }

    fn tracks(&self) -> Vec<FittedParameter> {
        let [left, right, width] = self.wear_sigmas();
        let (wear, model) = (&self.wear, &self.model);
        let ratio = (1.0 + wear.right) / (1.0 + wear.left);
        // By both parts, to first order.
        let cov = &self.wear_cov;
        let of_difference = (cov[(0, 0)] + cov[(1, 1)] - 2.0 * cov[(0, 1)]).max(0.0);
        let effective = wear.width(model.track_width);
        let width_sigma = width * model.track_width;
        let part = |keys, name, value, sigma| FittedParameter {
            keys,
            name,
            unit: "",
            value,
            sigma,
            model: 0.0,
            verdict: self.of_part(sigma, PRIOR),
        };
        let ratio_sigma = of_difference.sqrt();
        vec![
            part(
                &["odometry.left", "wear.left"],
                "Left track runs farther than counted, part",
                wear.left,
                left,
            ),
            part(
                &["odometry.right", "wear.right"],
                "Right track runs farther than counted, part",
                wear.right,
                right,
            ),
            FittedParameter {
                keys: &[],
                name: "Right track over left",
                unit: "",
                value: ratio,
                sigma: ratio_sigma,
                model: 1.0,
                verdict: self.of_part(ratio_sigma, PRIOR * std::f64::consts::SQRT_2),
            },
            part(
                &["odometry.track", "wear.track"],
                "Tracks act wider apart than assumed, part",
                wear.track_width,
                width,
            ),
            FittedParameter {
                keys: &[],
                name: "Effective track width",
                unit: "m",
                value: effective,
                sigma: width_sigma,
                model: model.track_width,
                verdict: self.of_part(width, PRIOR),
            },
            FittedParameter {
                keys: &[],
                name: "Slip factor: effective over ruled width",
                unit: "",
                value: effective / model.ruled_width,
                sigma: width_sigma / model.ruled_width,
                model: model.track_width / model.ruled_width,
                verdict: self.of_part(width, PRIOR),
            },
        ]
    }

    fn chance(&self) -> Vec<FittedParameter> {
        let (found, model) = (&self.noise, &self.model.odometry_noise);
        let rows: [(
            &'static [&'static str],
            &'static str,
            &'static str,
            f64,
            f64,
        ); 3] = [
            (
                &["odometry.per_metre"],
                "Chance of a track's way",
                "m²/m",
                found.per_metre,
                model.per_metre,
            ),
            (
                &["odometry.lateral"],
                "Chance of sideways slip",
                "m²/m",
                found.lateral_per_metre,
                model.lateral_per_metre,
            ),
            (
                &["odometry.turn"],
                "Chance of turns",
                "rad²/rad",
                found.heading_per_radian,
                model.heading_per_radian,
            ),
        ];
        let with_doubt = rows.into_iter().zip(self.noise_log_sigmas);
        with_doubt
            .map(
                |((keys, name, unit, value, model), log_sigma)| FittedParameter {
                    keys,
                    name,
                    unit,
                    value,
                    sigma: value * log_sigma,
                    model,
                    verdict: match log_sigma < KNOWN_LOG {
                        true => Verdict::Known,
                        false => Verdict::Unknown(self.why_no_chance(keys)),
                    },
                },
            )
            .collect()
    }

    fn poses(&self) -> Vec<FittedParameter> {
        let [position, heading] = self.pose_sigmas;
        let of_pose = |name, unit, value| FittedParameter {
            keys: &[],
            name,
            unit,
            value,
            sigma: f64::NAN,
            model: f64::NAN,
            verdict: Verdict::Known,
        };
        vec![
            of_pose("σ of the reference positions", "m", position),
            of_pose("σ of the reference headings", "rad", heading),
        ]
    }

    /// Known where the drive told more than there was before: half the standard error.
    fn of_part(&self, sigma: f64, beforehand: f64) -> Verdict {
        if sigma < 0.5 * beforehand {
            return Verdict::Known;
        }
        Verdict::Unknown(if !self.extent.has_turned() {
            "the drive has no turns: turn on the spot, to both sides"
        } else if self.extent.way < 1.0 {
            "the drive has hardly any way: drive some metres straight on"
        } else {
            "too little for it: turn more, to both sides, and drive farther straight on"
        })
    }

    fn why_no_chance(&self, keys: &[&str]) -> &'static str {
        if keys == ["odometry.turn"] && !self.extent.has_turned() {
            "the drive has no turns: turn on the spot, to both sides"
        } else {
            "not told apart from the other noise: drive longer, or it is smaller than what the poses err"
        }
    }
}
