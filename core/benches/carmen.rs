//! Reading a CARMEN log: 2000 scans of 180 readings, generated here.
#![allow(missing_docs, reason = "criterion's macros")]

use std::fmt::Write as _;
use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use slamlab_core::format::carmen::CarmenLog;

fn log() -> String {
    let mut text = String::new();
    for i in 0..2000 {
        text += "FLASER 180";
        for beam in 0..180 {
            let _ = write!(
                text,
                " {}.{:02}",
                1 + (i + beam) % 9,
                (i * 7 + beam * 3) % 100
            );
        }
        let _ = writeln!(text, " 0.1 0.2 0.3 0.1 0.2 0.3 {i}.25 host {i}.25");
    }
    text
}

fn bench(c: &mut Criterion) {
    let text = log();
    let mut group = c.benchmark_group("carmen");
    group.sample_size(20);
    group.throughput(Throughput::Bytes(text.len() as u64));
    group.bench_function("parse_2000_scans_of_180", |b| {
        b.iter(|| CarmenLog::parse(black_box(text.as_bytes())));
    });
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
