//! Two clouds and all that can be asked of them, for the registration lab of the page.

use nalgebra::{Point2, Vector2};
use serde::{Deserialize, Serialize};
use slamlab_core::format::point_list;
use slamlab_core::geom::Pose2;
use slamlab_core::registration::{
    self, Basin, BasinAxes, BasinConfig, Cloud, CloudMethod, Iteration, JudgeConfig, MEASURED,
    MEASURED_PAIRS, MeasuredMethod, Registration, Verdict, trace_clouds,
};
use slamlab_core::sim::scan_pair::BuiltinPair;
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{
    BasinAxesName, BasinOutcomeName, BasinRow, CorrespondenceRow, Float64Array, IterationRow,
    Typed, VerdictName, WebError, flat, typed,
};

/// What the lab can be asked for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct RegistrationOffer {
    /// Names of the methods.
    pub methods: Vec<String>,
    /// Pairs of scans that are always there.
    pub pairs: Vec<PairInfo>,
    /// What was measured of each method, by condition.
    pub measured: Vec<MeasuredRow>,
    /// Pairs of each condition that were measured.
    pub measured_pairs: u32,
}

/// A pair of scans that is always there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct PairInfo {
    /// Its name.
    pub name: String,
    /// What a person calls it.
    pub title: String,
}

/// What was measured of a method under a condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct MeasuredRow {
    /// Name of the condition.
    pub condition: String,
    /// As a person reads it.
    pub title: String,
    /// Name of the method.
    pub method: String,
    /// Part found of all pairs, and of those with a near start.
    pub found: [f64; 2],
    /// Median time, µs.
    pub micros: f64,
}

/// Two clouds, x y x y ..., m, each in its own frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct CloudPair {
    /// The one that stays.
    pub fixed: Float64Array,
    /// The one that is moved.
    pub moving: Float64Array,
    /// x y heading of the moving one in the fixed one's frame.
    pub truth: [f64; 3],
}

/// Why a pair cannot be had.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LabError {
    /// No such pair.
    #[error("there is no pair of scans `{0}`")]
    NoPair(String),
    /// No such method.
    #[error("there is no registration method `{0}`")]
    NoMethod(String),
}

crate::border::kinds! { Question: LabError; }

/// What a method found; m and rad, in the fixed cloud's frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
#[tsify(missing_as_null)]
pub struct Registered {
    /// x y heading.
    pub pose: [f64; 3],
    /// Covariance of these, row by row.
    pub cov: [f64; 9],
    /// Moving points on a surface of the fixed cloud, as a part of all.
    pub overlap: f64,
    /// Root of their mean squared distance across it, m.
    pub residual: f64,
    /// Iterations taken.
    pub iterations: u32,
    /// What it is worth.
    pub verdict: VerdictName,
    /// x y of the direction that the clouds do not tell.
    pub direction: Option<[f64; 2]>,
    /// Part of the points that could agree and do; NaN where it was not in question.
    pub agreement: f64,
    /// What each iteration saw, see `ITERATION`.
    pub steps: Float64Array,
}

/// Which method to take, and why.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct RegistrationAdvice {
    /// The condition of the measured table that the scans are most like, as a person reads it.
    pub condition: String,
    /// Whether the start is near.
    pub is_near: bool,
    /// How the clouds lie on each other: part of the points on a surface, σ across it in m, part of
    /// the points that lie on none.
    pub overlap: f64,
    /// See `overlap`.
    pub sigma: f64,
    /// See `overlap`.
    pub scatter: f64,
    /// The method to take; its part found and its median time in µs.
    pub method: AdvisedMethod,
    /// The one that was found most often.
    pub surest: AdvisedMethod,
    /// The one that takes the least time.
    pub fastest: AdvisedMethod,
}

/// A method of an advice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct AdvisedMethod {
    /// Its name.
    pub name: String,
    /// Part found.
    pub found: f64,
    /// Median time, µs.
    pub micros: f64,
}

impl AdvisedMethod {
    fn of(method: &MeasuredMethod, is_near: bool) -> Self {
        Self {
            name: method.name.to_owned(),
            found: method.found[usize::from(is_near)],
            micros: method.micros,
        }
    }
}

/// A map of starts to be made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct BasinAsk {
    /// Of which method.
    pub method: String,
    /// x y heading of the pose that is right.
    pub right: [f64; 3],
    /// What the axes are.
    pub axes: BasinAxesName,
    /// The farthest start to either side, m.
    pub shift: f64,
    /// The farthest turn, rad.
    pub turn: f64,
    /// Cells along each side.
    pub cells: u32,
}

/// Methods and pairs of the lab.
///
/// # Errors    None that a page can cause.
#[wasm_bindgen]
pub fn registration_offer() -> Typed<RegistrationOffer> {
    let methods = CloudMethod::all();
    let pairs = BuiltinPair::ALL.iter().map(|pair| PairInfo {
        name: pair.name.to_owned(),
        title: pair.title.to_owned(),
    });
    let measured = MEASURED.iter().flat_map(|condition| {
        condition.methods.iter().map(|method| MeasuredRow {
            condition: condition.name.to_owned(),
            title: condition.title.to_owned(),
            method: method.name.to_owned(),
            found: method.found,
            micros: method.micros,
        })
    });
    typed(&RegistrationOffer {
        methods: methods.iter().map(|(name, _)| (*name).to_owned()).collect(),
        pairs: pairs.collect(),
        measured: measured.collect(),
        measured_pairs: MEASURED_PAIRS as u32,
    })
}

/// A pair of scans that is always there.
///
/// # Errors    A name that none has.
#[wasm_bindgen]
pub fn builtin_pair(name: &str) -> Typed<CloudPair> {
    let builtin = BuiltinPair::ALL.iter().find(|pair| pair.name == name);
    let pair = builtin.and_then(BuiltinPair::draw);
    let pair = pair.ok_or_else(|| LabError::NoPair(name.to_owned()))?;
    typed(&CloudPair {
        fixed: pairs(&pair.fixed),
        moving: pairs(&pair.moving),
        truth: numbers(&pair.truth),
    })
}

/// x y x y ... of a list of points in a file.
///
/// # Errors    A sentence with line and field of what is wrong.
#[wasm_bindgen]
pub fn read_point_list(bytes: &[u8]) -> Result<Vec<f64>, WebError> {
    let points = point_list::read(bytes)?;
    Ok(points.iter().flat_map(|p| [p.x, p.y]).collect())
}

/// Two clouds, and what the methods made of them last.
#[wasm_bindgen]
#[derive(Debug)]
pub struct WebClouds {
    moving: Cloud,
    fixed: Cloud,
    /// Every iteration of each method.
    traces: Vec<(String, Vec<Iteration>)>,
}

#[wasm_bindgen]
impl WebClouds {
    /// Of x y x y ..., m; `are_scans` where a sensor stood at the origin of each.
    ///
    /// # Errors    A point that is none, or too many.
    #[wasm_bindgen(constructor)]
    pub fn new(moving: &[f64], fixed: &[f64], are_scans: bool) -> Result<Self, WebError> {
        let cloud = if are_scans { Cloud::scan } else { Cloud::any };
        Ok(Self {
            moving: cloud(points(moving))?,
            fixed: cloud(points(fixed))?,
            traces: vec![],
        })
    }

    /// Registers by one method, from x y heading, and keeps how it came about.
    ///
    /// # Errors    A name that no method has.
    pub fn register(&mut self, method: &str, start: &[f64]) -> Typed<Registered> {
        let config = method_named(method)?;
        let judge = JudgeConfig::default();
        let trace = trace_clouds(&self.moving, &self.fixed, &pose(start), &config, &judge);
        let registered = Registered::of(&trace.registration, &trace.iterations);
        self.traces.retain(|(name, _)| name != method);
        self.traces.push((method.to_owned(), trace.iterations));
        typed(&registered)
    }

    /// Which points pulled where in an iteration of what a method did last, see `CORRESPONDENCE`;
    /// of one that it did not come to, those of its last one.
    #[must_use]
    pub fn correspondences(&self, method: &str, iteration: usize) -> Vec<f32> {
        let trace = self.traces.iter().find(|(name, _)| name == method);
        let seen = trace.and_then(|(_, all)| all.get(iteration).or_else(|| all.last()));
        flat(seen.into_iter().flat_map(|seen| {
            seen.correspondences.iter().map(|pair| CorrespondenceRow {
                from_x: pair.from.x as f32,
                from_y: pair.from.y as f32,
                to_x: pair.to.x as f32,
                to_y: pair.to.y as f32,
                weight: pair.weight as f32,
            })
        }))
    }

    /// Which method to take for these clouds, as they lie on each other at `right`, from `start`;
    /// each x y heading.
    ///
    /// # Errors    None that a page can cause.
    pub fn advise(
        &self,
        right: &[f64],
        start: &[f64],
    ) -> Result<Option<Ts<RegistrationAdvice>>, WebError> {
        let (right, start) = (pose(right), pose(start));
        let judge = JudgeConfig::default();
        let likeness = registration::likeness(&self.moving, &self.fixed, &right, &judge);
        let off = start.minus(&right);
        let shift = Vector2::new(off.x, off.y).norm_squared().sqrt();
        let Some(advice) = registration::advise(&likeness, shift, off.z) else {
            return Ok(None);
        };
        let method = |method| AdvisedMethod::of(method, advice.is_near);
        Ok(Some(typed(&RegistrationAdvice {
            condition: advice.condition.title.to_owned(),
            is_near: advice.is_near,
            overlap: likeness.overlap,
            sigma: likeness.sigma,
            scatter: likeness.scatter,
            method: method(advice.method),
            surest: method(advice.surest),
            fastest: method(advice.fastest),
        })?))
    }

    /// A map of starts, still empty.
    ///
    /// # Errors    A name that no method has.
    pub fn basin(&self, ask: &Ts<BasinAsk>) -> Result<WebBasin, WebError> {
        let ask = ask.to_rust()?;
        let method = method_named(&ask.method)?;
        let config = BasinConfig {
            axes: match ask.axes {
                BasinAxesName::ShiftTurn => BasinAxes::ShiftTurn { direction: 0.0 },
                BasinAxesName::Place => BasinAxes::Place,
            },
            shift: ask.shift,
            turn: ask.turn,
            cells: ask.cells as usize,
            ..BasinConfig::default()
        };
        let clouds = [self.moving.clone(), self.fixed.clone()];
        Ok(WebBasin(Basin::new(
            clouds,
            pose(&ask.right),
            method,
            config,
        )))
    }
}

/// A map of starts that is being filled.
#[wasm_bindgen]
#[derive(Debug)]
pub struct WebBasin(Basin);

#[wasm_bindgen]
impl WebBasin {
    /// The next cell, see `BASIN`; empty when all are done.
    pub fn step(&mut self) -> Vec<f32> {
        flat(self.0.step().map(|cell| BasinRow {
            index: cell.index as f32,
            outcome: BasinOutcomeName::from(&cell.outcome) as u8 as f32,
            error: cell.error as f32,
        }))
    }

    /// The part that is done, 0 to 1.
    #[must_use]
    pub fn progress(&self) -> f64 {
        self.0.progress()
    }
}

impl Registered {
    fn of(found: &Registration, iterations: &[Iteration]) -> Self {
        let rows = iterations.iter().map(|seen| IterationRow {
            x: seen.pose.x(),
            y: seen.pose.y(),
            heading: seen.pose.heading(),
            width: seen.width,
            residual: seen.residual,
            matched: seen.correspondences.len() as f64,
        });
        let cov = found.estimate.cov;
        Self {
            pose: numbers(&found.estimate.pose),
            cov: std::array::from_fn(|at| cov[(at / 3, at % 3)]),
            overlap: found.overlap,
            residual: found.residual,
            iterations: found.iterations as u32,
            verdict: (&found.verdict).into(),
            direction: match found.verdict {
                Verdict::Degenerate { direction } => Some([direction.x, direction.y]),
                _ => None,
            },
            agreement: match found.verdict {
                Verdict::LocalMinimum { agreement } => agreement,
                _ => f64::NAN,
            },
            steps: Float64Array(flat(rows)),
        }
    }
}

fn method_named(name: &str) -> Result<CloudMethod, LabError> {
    let mut all = CloudMethod::all().into_iter();
    let found = all.find_map(|(own, method)| (own == name).then_some(method));
    found.ok_or_else(|| LabError::NoMethod(name.to_owned()))
}

fn points(numbers: &[f64]) -> Vec<Point2<f64>> {
    let pairs = numbers.as_chunks().0.iter();
    pairs.map(|[x, y]| Point2::new(*x, *y)).collect()
}

fn pairs(points: &[Point2<f64>]) -> Float64Array {
    points.iter().flat_map(|p| [p.x, p.y]).collect()
}

/// A pose of x y heading; what is missing is 0.
fn pose(numbers: &[f64]) -> Pose2 {
    let at = |index: usize| numbers.get(index).copied().unwrap_or_default();
    Pose2::new(at(0), at(1), at(2))
}

fn numbers(pose: &Pose2) -> [f64; 3] {
    [pose.x(), pose.y(), pose.heading()]
}
