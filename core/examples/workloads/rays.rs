//! `rays`: 1000 beams from each of 1000 places, against the 100 walls of `world_office.csv`, up to
//! 30 m.
//!
//! The beams of a place are a full circle of even steps, so [`Caster::cast_fan`] casts a place at
//! once; beside it stands each ray by itself, with its own sine and cosine as in the peers.

use std::f64::consts::TAU;

use anyhow::{Context, Result};
use nalgebra::Point2;
use slamlab_core::geom::unit_vector;
use slamlab_core::sim::{Caster, Fan, Material, Wall};

use crate::inputs::Inputs;
use crate::timing::{emit, median_ms};

const WORKLOAD: &str = "raycast_segments100_1e6beams";
const BEAMS: usize = 1000;
const MAX_RANGE: f64 = 30.0;
const REPEATS: usize = 5;

pub(crate) fn run(inputs: &Inputs) -> Result<()> {
    let places = inputs.table::<3>("ray_poses_1000.csv")?;
    let walls = inputs.segments("world_office.csv")?;
    let walls = walls.into_iter().map(|segment| Wall {
        segment,
        material: Material::Opaque,
    });
    let caster = Caster::new(walls.collect());
    fans(&caster, &places)?;
    single_rays(&caster, &places)
}

/// The sum of the ranges, to compare with the peers'.
#[derive(Default)]
struct Sum {
    ranges: f64,
    hits: usize,
}

impl Sum {
    fn add(&mut self, range: f64) {
        self.ranges += range;
        self.hits += 1;
    }

    fn text(&self) -> String {
        let mean = self.ranges / self.hits as f64;
        format!("mean_range={mean:.4} hits={}", self.hits)
    }
}

fn fans(caster: &Caster, places: &[[f64; 3]]) -> Result<()> {
    let fan = Fan::new(BEAMS, 0.0, TAU / BEAMS as f64);
    let mut fan = fan.context("a full circle is a fan")?;
    let mut sum = Sum::default();
    let ms = median_ms(REPEATS, || {
        sum = Sum::default();
        for [x, y, heading] in places {
            caster.cast_fan(Point2::new(*x, *y), *heading, MAX_RANGE, &mut fan);
            let ranges = fan.distances().iter().filter(|d| d.is_finite());
            ranges.for_each(|range| sum.add(*range));
        }
        Ok(())
    })?;
    emit("slamlab(fans)", WORKLOAD, ms, &sum.text());
    Ok(())
}

fn single_rays(caster: &Caster, places: &[[f64; 3]]) -> Result<()> {
    let mut sum = Sum::default();
    let ms = median_ms(REPEATS, || {
        sum = Sum::default();
        for [x, y, heading] in places {
            for beam in 0..BEAMS {
                let direction = unit_vector(heading + beam as f64 * TAU / BEAMS as f64);
                if let Some(hit) = caster.cast(Point2::new(*x, *y), direction, MAX_RANGE) {
                    sum.add(hit.distance);
                }
            }
        }
        Ok(())
    })?;
    emit("slamlab(ray-by-ray)", WORKLOAD, ms, &sum.text());
    Ok(())
}
