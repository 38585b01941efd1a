//! `buildings`: recorded buildings, also damaged as logs of others are, mapped by the default
//! method with one set of parameters. Some minutes.
//!
//! 1. The logs of the recorded data (`--data DIR`, as its README lays it out), whole: errors over
//!    the relations of Kümmerle et al. (2009), mean shift and mean turn.
//! 2. The same logs without odometry; with every third scan; with a tenth of the scans lost in
//!    bursts; with odometry whose distances are too long and which adds a turn; and Intel with 11
//!    beams of 5 m ([`damage`]). A relation counts only if both of its scans are left, and the
//!    remaining ones may be harder or easier than the rest: with every third scan 27 of CSAIL's
//!    1172 are left, and the whole log has larger errors over those than over all. So a damaged log
//!    is compared with the whole log over the same relations.
//! 3. Two logs with only one scan per metre, against a reference trajectory at its revisits: mean
//!    shift, and the part that is off by more than half a metre.
//! 4. Intel: speed as a multiple of real time, and its slow scans: processor time, reading
//!    included. The memory for Killian is the high-water mark of the process: it runs first and
//!    alone, after no other report (in `all`, none comes before).
//! 5. The verdict on each map, against the errors found: every torn map is called torn, and of the
//!    others less than 5 % ([`verdict`]).
//!
//! `--only ROW` measures one row, and the rows that its limits refer to. Rows and verdicts go to
//! standard error as tables.

mod damage;
mod run;
mod verdict;

use std::collections::BTreeMap;

use anyhow::{Result, bail};
use serde_json::{Value, json};
use slamlab_core::estimation::RelationErrors;

use self::damage::Damage;
use self::run::{Building, Kind, Run};
use self::verdict::Judged;
use super::{Args, Outcome, chosen};
use crate::threads::each;

const KILLIAN: Building = recorded("killian");
const INTEL: Building = recorded("intel");
const FREIBURG: Building = recorded("fr079");
const CSAIL: Building = recorded("csail");
const BELGIOIOSO: Building = keyframes("belgioioso");
const INFINITE_CORRIDOR: Building = keyframes("infinite-corridor");

/// The rows, and what is required of them; Killian and Intel first, which are measured alone.
#[rustfmt::skip]
const ROWS: [Row; 23] = [
    row(KILLIAN, Damage::Whole, Limit::AtMost([0.031, 0.39])),
    row(INTEL, Damage::Whole, Limit::AtMost([0.0146, 0.275])),
    row(FREIBURG, Damage::Whole, Limit::AtMost([0.032, 0.46])),
    row(CSAIL, Damage::Whole, Limit::AtMost([0.029, 0.35])),
    row(INTEL, Damage::WithoutOdometry, Limit::AtMost([0.03, 0.6])),
    row(FREIBURG, Damage::WithoutOdometry, Limit::AtMost([0.05, 0.8])),
    row(CSAIL, Damage::WithoutOdometry, Limit::AtMost([0.05, 0.6])),
    row(KILLIAN, Damage::WithoutOdometry, Limit::None),
    row(INTEL, Damage::Third, Limit::TimesWhole),
    row(FREIBURG, Damage::Third, Limit::TimesWhole),
    row(CSAIL, Damage::Third, Limit::TimesWhole),
    row(KILLIAN, Damage::Third, Limit::TimesWhole),
    row(INTEL, Damage::Bursts, Limit::TimesWhole),
    row(FREIBURG, Damage::Bursts, Limit::TimesWhole),
    row(CSAIL, Damage::Bursts, Limit::TimesWhole),
    row(KILLIAN, Damage::Bursts, Limit::TimesWhole),
    row(INTEL, Damage::Bent, Limit::AsWithoutOdometry),
    row(FREIBURG, Damage::Bent, Limit::AsWithoutOdometry),
    row(CSAIL, Damage::Bent, Limit::AsWithoutOdometry),
    row(KILLIAN, Damage::Bent, Limit::AsWithoutOdometry),
    row(INTEL, Damage::ElevenBeams, Limit::AtMost([0.08, 2.0])),
    row(BELGIOIOSO, Damage::Whole, Limit::AtMost([0.12, 0.02])),
    row(INFINITE_CORRIDOR, Damage::Whole, Limit::AtMost([0.12, 0.02])),
];
/// Rows that are measured alone, one after the other.
const ALONE: [Case; 2] = [(KILLIAN, Damage::Whole), (INTEL, Damage::Whole)];

/// Maximum error as a multiple of the whole log's, for [`Limit::TimesWhole`].
const MOST_TIMES: f64 = 1.5;
/// Intel: minimum multiple of real time, and maximum 99th percentile of the time per scan, ms.
const LEAST_REAL_TIME_FACTOR: f64 = 500.0;
const MOST_SCAN_MS: f64 = 5.0;
/// Maximum memory for Killian, MB.
const MOST_MEMORY: f64 = 200.0;

type Case = (Building, Damage);

/// A run, and the requirement on its errors.
#[derive(Clone, Copy)]
struct Row {
    case: Case,
    limit: Limit,
}

/// The maximum of a row's two errors: mean shift, m, and mean turn, °; for keyframes, the part of
/// wrong motions instead of the turn.
#[derive(Clone, Copy)]
enum Limit {
    /// No requirement: other rows refer to this one.
    None,
    AtMost([f64; 2]),
    /// 1.5 times the error of the whole log over the same relations.
    TimesWhole,
    /// The error of the log without odometry, or the limit of that row if it is larger.
    AsWithoutOdometry,
}

type Found = BTreeMap<Case, Result<Run, String>>;

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let names: Vec<String> = ROWS.iter().map(Row::name).collect();
    let asked = chosen("row", &args.only, names.iter().map(String::as_str))?;
    let rows: Vec<&Row> = ROWS
        .iter()
        .filter(|row| asked.contains(&row.name().as_str()))
        .collect();
    let found = run_all(args, &rows);
    if let (Some(Err(error)), true) = (found.values().next(), found.values().all(Result::is_err)) {
        bail!("no row could be measured: {error}");
    }
    let mut outcome = Outcome::default();
    let mut table = vec![];
    let mut judged = vec![];
    eprintln!("| row | measured | at most | met |\n| --- | --- | --- | --- |");
    for row in rows {
        let limits = row.limits(&found);
        table.push(row.judge(&found, limits, &mut outcome));
        judged.extend(row.verdict(&found));
    }
    outcome.figure("rows", table);
    verdict::report(&judged, &mut outcome);
    if let Some(Ok(run)) = found.get(&ALONE[0]) {
        let megabytes = run.peak_memory_mb.unwrap_or(f64::NAN);
        outcome.at_most("killian_peak_memory_mb", megabytes, MOST_MEMORY);
    }
    if let Some(Ok(run)) = found.get(&ALONE[1]) {
        let factor = run.real_time_factor;
        outcome.at_least("intel_real_time_factor", factor, LEAST_REAL_TIME_FACTOR);
        outcome.at_most("intel_scan_ms_p99", run.scan_ms_p99, MOST_SCAN_MS);
    }
    Ok(outcome)
}

/// Runs these rows, and those that their limits refer to.
fn run_all(args: &Args, rows: &[&Row]) -> Found {
    let data = args.data();
    let one = |&(building, damage): &Case| {
        Run::of(building, damage, &data).map_err(|error| format!("{error:#}"))
    };
    let is_needed = |case: &Case| {
        let of = |row: &&Row| {
            row.case == *case || row.reference() == Some(*case) || row.whole_log() == *case
        };
        rows.iter().any(of)
    };
    let needed = || ROWS.iter().map(|row| row.case).filter(is_needed);
    let (alone, others): (Vec<_>, Vec<_>) = needed().partition(|case| ALONE.contains(case));
    let mut found: Found = alone.into_iter().map(|case| (case, one(&case))).collect();
    let side_by_side = each(others.len(), |at| Ok(one(&others[at])));
    match side_by_side {
        Ok(runs) => found.extend(others.into_iter().zip(runs)),
        Err(error) => {
            let error = format!("{error:#}");
            found.extend(others.into_iter().map(|case| (case, Err(error.clone()))));
        }
    }
    found
}

impl Row {
    fn name(&self) -> String {
        let (building, damage) = self.case;
        format!("{}{}", building.name, damage.suffix())
    }

    /// The run that the limit refers to.
    fn reference(&self) -> Option<Case> {
        let (building, _) = self.case;
        match self.limit {
            Limit::None | Limit::AtMost(_) => None,
            Limit::TimesWhole => Some((building, Damage::Whole)),
            Limit::AsWithoutOdometry => Some((building, Damage::WithoutOdometry)),
        }
    }

    /// The same log, undamaged.
    fn whole_log(&self) -> Case {
        (self.case.0, Damage::Whole)
    }

    /// The verdict on its map, and whether the map is torn.
    fn verdict(&self, found: &Found) -> Option<Judged> {
        let run = found.get(&self.case)?.as_ref().ok()?;
        let whole = match self.whole_log() {
            case if case == self.case => None,
            case => Some(found.get(&case)?.as_ref().ok()?),
        };
        Some(Judged::of(self.name(), self.case.0.kind, run, whole))
    }

    /// The limits according to what was found; NaN, which nothing meets, if the run that they refer
    /// to failed.
    fn limits(&self, found: &Found) -> Option<[f64; 2]> {
        let run_of = |case: Case| found.get(&case)?.as_ref().ok();
        let reference = self.reference().and_then(run_of);
        match self.limit {
            Limit::None => None,
            Limit::AtMost(limits) => Some(limits),
            Limit::TimesWhole => {
                let whole = reference.zip(run_of(self.case));
                let errors = whole.map(|(whole, run)| whole.errors_over_those_of(run));
                let errors = errors.map_or([f64::NAN; 2], |errors| self.both(&errors));
                Some(errors.map(|error| MOST_TIMES * error))
            }
            Limit::AsWithoutOdometry => {
                let errors = reference.map(|run| self.both(&run.errors));
                let [shift, turn] = errors.unwrap_or([f64::NAN; 2]);
                let reference = ROWS.iter().find(|row| Some(row.case) == self.reference());
                match reference.map(|row| row.limit) {
                    Some(Limit::AtMost([m, deg])) => Some([shift.max(m), turn.max(deg)]),
                    _ => Some([shift, turn]),
                }
            }
        }
    }

    /// Both errors, in the order of [`Limit`].
    fn both(&self, errors: &RelationErrors) -> [f64; 2] {
        let second = match self.case.0.kind {
            Kind::Relations => errors.rot_abs_mean.to_degrees(),
            Kind::Keyframes => errors.wrong_part,
        };
        [errors.trans_abs_mean, second]
    }

    /// The row for the report, in JSON and as a line of the table; records whether its limits hold.
    fn judge(&self, found: &Found, limits: Option<[f64; 2]>, outcome: &mut Outcome) -> Value {
        let name = self.name();
        let run = match found.get(&self.case) {
            Some(Ok(run)) => run,
            failed => {
                let error = match failed {
                    Some(Err(error)) => error.as_str(),
                    _ => "not run",
                };
                eprintln!("| {name} | {error} | | no |");
                outcome.require(false, || format!("{name}: {error}"));
                return json!({ "row": name, "error": error, "met": false });
            }
        };
        let errors = self.both(&run.errors);
        let is_met = limits.map(|limits| {
            errors
                .iter()
                .zip(limits)
                .all(|(error, most)| *error <= most)
        });
        let unit = match self.case.0.kind {
            Kind::Relations => "deg",
            Kind::Keyframes => "wrong_part",
        };
        let text = |[m, second]: [f64; 2]| format!("{m:.4} m / {second:.3} {unit}");
        let most = limits.map_or("–".into(), text);
        let met = match is_met {
            None => "–",
            Some(true) => "yes",
            Some(false) => "no",
        };
        eprintln!("| {name} | {} | {most} | {met} |", text(errors));
        outcome.require(is_met != Some(false), || {
            format!("{name}: {}, expected at most {most}", text(errors))
        });
        let named = |[m, second]: [f64; 2]| json!({ "m": m, unit: second });
        json!({
            "row": name,
            "measured": named(errors),
            "at_most": limits.map(named),
            "met": is_met,
            "scans": run.scans,
            "motions": run.errors.count,
            "left_out": run.errors.left_out,
            "long": { "m": run.long.trans_abs_mean, "deg": run.long.rot_abs_mean.to_degrees(), "motions": run.long.count },
            "loop_closures": run.closures,
        })
    }
}

const fn row(building: Building, damage: Damage, limit: Limit) -> Row {
    Row {
        case: (building, damage),
        limit,
    }
}

const fn recorded(name: &'static str) -> Building {
    Building {
        name,
        kind: Kind::Relations,
    }
}

const fn keyframes(name: &'static str) -> Building {
    Building {
        name,
        kind: Kind::Keyframes,
    }
}
