//! The result, parameter by parameter, and what a drive did not show.

use std::f64::consts::{LN_2, SQRT_2};

use super::{OdometryFit, PRIOR};

/// A noise coefficient counts as shown if the standard error of its logarithm is below this: within
/// a factor of two.
const SHOWN_LOG: f64 = LN_2;

const NO_TURNS: &str = "the drive has no turns: turn on the spot, to both sides";

/// A parameter of the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedParameter {
    /// Keys of the settings that take it: the odometry correction, and the simulated robot; none
    /// for what follows from others.
    pub keys: &'static [&'static str],
    /// Its name for people.
    pub name: &'static str,
    /// Its unit; empty for a pure number.
    pub unit: &'static str,
    /// What was found.
    pub value: f64,
    /// Its standard error.
    pub sigma: f64,
    /// The value of the model.
    pub model: f64,
    /// Why the drive did not show it; empty if it did.
    pub unknown: &'static str,
}

impl FittedParameter {
    pub(in crate::estimation) fn new(
        keys: &'static [&'static str],
        [name, unit]: [&'static str; 2],
        [value, sigma, model]: [f64; 3],
        unknown: &'static str,
    ) -> Self {
        Self {
            keys,
            name,
            unit,
            value,
            sigma,
            model,
            unknown,
        }
    }

    /// Keys and values of the settings that take it.
    pub(in crate::estimation) fn settings(
        &self,
    ) -> impl Iterator<Item = (&'static str, f64)> + use<> {
        let value = self.value;
        self.keys.iter().map(move |key| (*key, value))
    }
}

impl OdometryFit {
    /// All parameters with their standard errors.
    #[must_use]
    pub fn parameters(&self) -> Vec<FittedParameter> {
        let row = FittedParameter::new;
        let [left, right, width] = self.wear_sigmas();
        let (wear, model) = (&self.wear, &self.model);
        let ratio = (1.0 + wear.right) / (1.0 + wear.left);
        // From both parts, to first order.
        let cov = &self.wear_cov;
        let of_difference = (cov[(0, 0)] + cov[(1, 1)] - 2.0 * cov[(0, 1)]).max(0.0);
        let ratio_sigma = of_difference.sqrt();
        let (effective, width_sigma) = (wear.width(model.track_width), width * model.track_width);
        let (ruled, shown) = (model.ruled_width, |sigma| self.of_part(sigma, PRIOR));
        let slip = [effective, width_sigma, model.track_width].map(|width| width / ruled);
        let [of_track, sideways, of_turns] = self.noise_log_sigmas;
        let [of_drive, of_model] = [&self.noise, &model.odometry_noise]
            .map(|n| [n.per_metre, n.lateral_per_metre, n.heading_per_radian]);
        let chance = |i: usize| {
            let sigma = of_drive[i] * self.noise_log_sigmas[i];
            [of_drive[i], sigma, of_model[i]]
        };
        let [position, heading] = self.pose_sigmas;
        vec![
            row(
                &["odometry.left", "wear.left"],
                ["Left track runs farther than counted, part", ""],
                [wear.left, left, 0.0],
                shown(left),
            ),
            row(
                &["odometry.right", "wear.right"],
                ["Right track runs farther than counted, part", ""],
                [wear.right, right, 0.0],
                shown(right),
            ),
            row(
                &[],
                ["Right track over left", ""],
                [ratio, ratio_sigma, 1.0],
                self.of_part(ratio_sigma, PRIOR * SQRT_2),
            ),
            row(
                &["odometry.track", "wear.track"],
                ["Tracks act wider apart than assumed, part", ""],
                [wear.track_width, width, 0.0],
                shown(width),
            ),
            row(
                &[],
                ["Effective track width", "m"],
                [effective, width_sigma, model.track_width],
                shown(width),
            ),
            row(
                &[],
                ["Slip factor: effective over ruled width", ""],
                slip,
                shown(width),
            ),
            row(
                &["odometry.per_metre"],
                ["Chance of a track's way", "m²/m"],
                chance(0),
                of_chance(of_track, false),
            ),
            row(
                &["odometry.lateral"],
                ["Chance of sideways slip", "m²/m"],
                chance(1),
                of_chance(sideways, false),
            ),
            row(
                &["odometry.turn"],
                ["Chance of turns", "rad²/rad"],
                chance(2),
                of_chance(of_turns, !self.extent.has_turned()),
            ),
            row(
                &[],
                ["σ of the reference positions", "m"],
                [position, f64::NAN, f64::NAN],
                "",
            ),
            row(
                &[],
                ["σ of the reference headings", "rad"],
                [heading, f64::NAN, f64::NAN],
                "",
            ),
        ]
    }

    /// Keys and values of the settings for which the drive gave a value.
    #[must_use]
    pub fn settings(&self) -> Vec<(&'static str, f64)> {
        let shown = self.parameters().into_iter();
        let shown = shown.filter(|p| p.unknown.is_empty());
        let mut values: Vec<_> = shown.flat_map(|p| p.settings()).collect();
        if values.iter().any(|(key, _)| key.starts_with("wear.")) {
            values.insert(0, ("wear.given", 1.0));
        }
        values
    }

    /// Shown if the drive said more than the prior: half its standard error.
    fn of_part(&self, sigma: f64, beforehand: f64) -> &'static str {
        if sigma < 0.5 * beforehand {
            ""
        } else if !self.extent.has_turned() {
            NO_TURNS
        } else if self.extent.way < 1.0 {
            "the drive has hardly any way: drive some metres straight on"
        } else {
            "too little for it: turn more, to both sides, and drive farther straight on"
        }
    }
}

fn of_chance(log_sigma: f64, lacks_turns: bool) -> &'static str {
    match log_sigma < SHOWN_LOG {
        true => "",
        false if lacks_turns => NO_TURNS,
        false => {
            "not distinguished from the other noise: drive longer, or it is smaller than what the poses err"
        }
    }
}
