//! What must hold before a change is handed over, except for tests.

use anyhow::Result;

use crate::report::Report;
use crate::{page, results, rules, tools};

/// House rules, formatting, lints natively and for wasm32, documentation, TypeScript types, and
/// which results are out of date.
///
/// # Errors
/// If one of them fails; the others still run.
pub fn all() -> Result<()> {
    let mut report = Report::default();
    report.step("house rules", rules::check);
    report.step("formatting", || tools::run_cargo("fmt --all --check"));
    report.step("lints, native", || {
        tools::run_cargo("clippy --workspace --exclude slamlab-storage-report --all-targets --all-features -- -D warnings")
    });
    report.step("lints, wasm32", || {
        tools::need_wasm_target()?;
        tools::run_cargo("clippy --package slamlab-core --package slamlab-web --target wasm32-unknown-unknown -- -D warnings")
    });
    report.step("documentation", || {
        let mut doc = tools::cargo();
        doc.env("RUSTDOCFLAGS", "-D warnings");
        tools::run(doc.args([
            "doc",
            "--workspace",
            "--exclude",
            "slamlab-storage-report",
            "--no-deps",
        ]))
    });
    report.step("types of the page", page::check_types);
    report.step("types of the page's tests", page::check_types_of_tests);
    report.step("age of RESULTS.md", results::name_stale);
    report.finish()
}
