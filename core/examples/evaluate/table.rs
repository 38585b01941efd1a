//! The Markdown table of several runs: one row each, printed as soon as it is known.

use std::io::Write as _;

use anyhow::Context;
use serde_json::Value;

use crate::worth::NOT_JUDGED;

/// Stands where a run lacks a figure.
const NOTHING: &str = "–";

/// A column: its title, and its cell from the figures of a run.
struct Column {
    title: &'static str,
    cell: fn(&Value) -> Option<String>,
}

pub(crate) struct Table {
    columns: Vec<Column>,
}

impl Table {
    /// Includes the columns that need relations, and those that need a reference trajectory.
    pub(crate) fn new(has_relations: bool, has_truth: bool) -> Self {
        let mut columns = vec![
            column("log", |f| text(f, "/log")),
            column("method", |f| text(f, "/method")),
            column("scans", |f| number(f, "/scans", 0)),
        ];
        if has_relations {
            columns.extend([
                column("relations (left out)", |f| counts(f, "/relations/all")),
                column("all, m / °", |f| shift_and_turn(f, "/relations/all")),
                column("≥ 20 s, m / °", |f| shift_and_turn(f, "/relations/long")),
            ]);
        }
        if has_truth {
            columns.extend([
                column("poses (left out)", |f| counts(f, "/truth")),
                column("ATE, m", |f| number(f, "/truth/ate_rmse_m", 3)),
                column("RPE 10 m, m / °", |f| {
                    shift_and_turn(f, "/truth/rpe/1/errors")
                }),
                column("revisits, m / °", |f| shift_and_turn(f, "/truth/revisits")),
                column("over 0.5 m", |f| {
                    let part = f.pointer("/truth/revisits/wrong_part")?.as_f64()?;
                    Some(format!("{:.1} %", 100.0 * part))
                }),
            ]);
        }
        columns.push(column("closures", |f| number(f, "/loop_closures", 0)));
        if has_truth {
            columns.push(column("false", |f| number(f, "/false_closures", 0)));
        }
        columns.extend([
            column("ms a scan, mean / p99", |f| {
                let mean = number(f, "/scan_ms/mean", 2)?;
                Some(format!("{mean} / {}", number(f, "/scan_ms/p99", 2)?))
            }),
            column("x real time", |f| number(f, "/real_time_factor", 0)),
            column("memory, MB", |f| number(f, "/peak_memory_mb", 0)),
            column("map", |f| {
                Some(text(f, "/quality/verdict").unwrap_or_else(|| NOT_JUDGED.to_owned()))
            }),
        ]);
        Self { columns }
    }

    pub(crate) fn print_head(&self) -> anyhow::Result<()> {
        let titles = self.columns.iter().map(|column| column.title.to_owned());
        print_cells(titles)?;
        print_cells(self.columns.iter().map(|_| "---".to_owned()))
    }

    /// A run that failed gives the reason after its method.
    pub(crate) fn print_row(&self, figures: &Value) -> anyhow::Result<()> {
        let error = text(figures, "/error");
        let cell = |(at, column): (usize, &Column)| match (&error, at) {
            (Some(error), 2) => format!("failed: {error}"),
            (Some(_), 3..) => String::new(),
            _ => (column.cell)(figures).unwrap_or_else(|| NOTHING.to_owned()),
        };
        print_cells(self.columns.iter().enumerate().map(cell))
    }
}

fn column(title: &'static str, cell: fn(&Value) -> Option<String>) -> Column {
    Column { title, cell }
}

fn print_cells(cells: impl Iterator<Item = String>) -> anyhow::Result<()> {
    let cells: Vec<_> = cells.map(|cell| cell.replace('|', "\\|")).collect();
    writeln!(std::io::stdout().lock(), "| {} |", cells.join(" | "))
        .context("cannot write to standard output")
}

fn text(figures: &Value, pointer: &str) -> Option<String> {
    Some(figures.pointer(pointer)?.as_str()?.to_owned())
}

fn number(figures: &Value, pointer: &str, decimals: usize) -> Option<String> {
    let number = figures.pointer(pointer)?.as_f64()?;
    Some(format!("{number:.decimals$}"))
}

fn counts(figures: &Value, pointer: &str) -> Option<String> {
    let count = |name: &str| number(figures, &format!("{pointer}/{name}"), 0);
    Some(format!("{} ({})", count("count")?, count("left_out")?))
}

fn shift_and_turn(figures: &Value, pointer: &str) -> Option<String> {
    let error = |name: &str, decimals| number(figures, &format!("{pointer}/{name}"), decimals);
    let shift = error("trans_abs_mean_m", 4)?;
    Some(format!("{shift} / {}", error("rot_abs_mean_deg", 3)?))
}
