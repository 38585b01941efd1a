//! Two clouds and all that the registration lab of the page can ask of them.

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

/// What the lab offers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct RegistrationOffer {
    /// Names of the methods.
    pub methods: Vec<String>,
    /// Built-in pairs of scans.
    pub pairs: Vec<PairInfo>,
    /// Measured results of each method, by condition.
    pub measured: Vec<MeasuredRow>,
    /// Number of pairs measured under each condition.
    pub measured_pairs: u32,
}

/// A built-in pair of scans.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct PairInfo {
    /// Its name.
    pub name: String,
    /// Its title for people.
    pub title: String,
}

/// The measured result of a method under a condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct MeasuredRow {
    /// Name of the condition.
    pub condition: String,
    /// Its title for people.
    pub title: String,
    /// Name of the method.
    pub method: String,
    /// Part of all pairs that was found, and of those with a near start.
    pub found: [f64; 2],
    /// Median time, µs.
    pub micros: f64,
}

/// Two clouds, x y x y ..., m, each in its own frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct CloudPair {
    /// The cloud that stays.
    pub fixed: Float64Array,
    /// The cloud that is moved.
    pub moving: Float64Array,
    /// x y heading of the moving cloud in the fixed cloud's frame.
    pub truth: [f64; 3],
}

/// Why a pair is not available.
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
    /// Covariance of the pose, row by row.
    pub cov: [f64; 9],
    /// Fraction of the moving points that lie on a surface of the fixed cloud.
    pub overlap: f64,
    /// Root mean square distance of those points across the surface, m.
    pub residual: f64,
    /// Iterations taken.
    pub iterations: u32,
    /// The verdict on it.
    pub verdict: VerdictName,
    /// x y of the direction that the clouds do not determine.
    pub direction: Option<[f64; 2]>,
    /// Fraction of the points that could agree and do; NaN if it was not tested.
    pub agreement: f64,
    /// The trace of the iterations, see `ITERATION`.
    pub steps: Float64Array,
}

/// Which method to take, and why.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct RegistrationAdvice {
    /// The measured condition that the scans are most similar to, as its title for people.
    pub condition: String,
    /// Whether the start is near.
    pub is_near: bool,
    /// How the clouds fit together: fraction of points on a surface, σ across it in m, fraction of
    /// points that lie on none.
    pub overlap: f64,
    /// See `overlap`.
    pub sigma: f64,
    /// See `overlap`.
    pub scatter: f64,
    /// The method to take, with its part found and its median time in µs.
    pub method: AdvisedMethod,
    /// The method that found the motion most often.
    pub surest: AdvisedMethod,
    /// The fastest method.
    pub fastest: AdvisedMethod,
}

/// A method in an advice.
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

/// Parameters of a map of starts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct BasinAsk {
    /// The method.
    pub method: String,
    /// x y heading of the correct pose.
    pub right: [f64; 3],
    /// The axes of the map.
    pub axes: BasinAxesName,
    /// The farthest start in each direction, m.
    pub shift: f64,
    /// The largest turn, rad.
    pub turn: f64,
    /// Number of cells along each side.
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

/// A built-in pair of scans.
///
/// # Errors    An unknown name.
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

/// The points of a file as x y x y ...
///
/// # Errors    A sentence on what is wrong, with line and field.
#[wasm_bindgen]
pub fn read_point_list(bytes: &[u8]) -> Result<Vec<f64>, WebError> {
    let points = point_list::read(bytes)?;
    Ok(points.iter().flat_map(|p| [p.x, p.y]).collect())
}

/// Two clouds, and the last results of the methods on them.
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
    /// From x y x y ..., m; `are_scans` if a sensor stood at the origin of each.
    ///
    /// # Errors    An invalid point, or too many.
    #[wasm_bindgen(constructor)]
    pub fn new(moving: &[f64], fixed: &[f64], are_scans: bool) -> Result<Self, WebError> {
        let cloud = if are_scans { Cloud::scan } else { Cloud::any };
        Ok(Self {
            moving: cloud(points(moving))?,
            fixed: cloud(points(fixed))?,
            traces: vec![],
        })
    }

    /// Registers by one method, starting at x y heading, and keeps the trace.
    ///
    /// # Errors    An unknown method.
    pub fn register(&mut self, method: &str, start: &[f64]) -> Typed<Registered> {
        let config = method_named(method)?;
        let judge = JudgeConfig::default();
        let trace = trace_clouds(&self.moving, &self.fixed, &pose(start), &config, &judge);
        let registered = Registered::of(&trace.registration, &trace.iterations);
        self.traces.retain(|(name, _)| name != method);
        self.traces.push((method.to_owned(), trace.iterations));
        typed(&registered)
    }

    /// Which points pulled where in an iteration of the method's last run, see `CORRESPONDENCE`;
    /// beyond the last iteration, those of the last.
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

    /// Which method to take for these clouds, which truly lie at `right`, from `start`; each x y
    /// heading.
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
    /// # Errors    An unknown method.
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

/// A map of starts in progress.
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

/// A pose from x y heading; missing numbers are 0.
fn pose(numbers: &[f64]) -> Pose2 {
    let at = |index: usize| numbers.get(index).copied().unwrap_or_default();
    Pose2::new(at(0), at(1), at(2))
}

fn numbers(pose: &Pose2) -> [f64; 3] {
    [pose.x(), pose.y(), pose.heading()]
}
