//! A recorded log of our own, for everything that runs natively and in the browser.

use slamlab_core::geom::Pose2;
use slamlab_core::sim::{Caster, worlds};

use crate::numbers;

/// A CARMEN log of a little more than one lap in the ring corridor, with odometry that drifts and a
/// laser with some noise.
///
/// # Panics    Never: the world is built in.
#[must_use]
#[allow(clippy::expect_used)] // without its world no test that uses it means anything
pub fn recorded_loop() -> String {
    let corners: [(f64, f64); 4] = [(1.0, 1.0), (20.0, 1.0), (20.0, 14.0), (1.0, 14.0)];
    let caster = Caster::new(worlds::builtin("loop").expect("a built-in world").walls());
    let mut noise = numbers().map(|u| 2.0 * u - 1.0);
    let mut noise = || noise.next().unwrap_or(0.0);
    let mut text = String::new();
    let mut odometry = Pose2::identity();
    let mut last: Option<Pose2> = None;
    let mut seconds = 0.0;
    for side in 0..5_u8 {
        let heading = std::f64::consts::FRAC_PI_2 * f64::from(side % 4);
        let [from, to] = [side, side + 1].map(|corner| corners[usize::from(corner % 4)]);
        let length = (to.0 - from.0).abs() + (to.1 - from.1).abs();
        let drives = (0..(length / 0.3) as u32).map(|step| (f64::from(step) * 0.3, 0.0));
        let turns = (1..6).map(|step| (length, 0.25 * f64::from(step)));
        for (along, turn) in drives.chain(turns) {
            let start = Pose2::new(from.0, from.1, heading);
            let truth = start * Pose2::new(along, 0.0, turn);
            if let Some(last) = last {
                let moved = last.inverse() * truth;
                let turned = 1.01 * moved.heading() + 0.002 * noise();
                odometry = odometry * Pose2::new(1.02 * moved.x(), moved.y(), turned);
            }
            last = Some(truth);
            seconds += 0.5;
            text += "FLASER 180";
            for beam in 0..180 {
                let bearing = (f64::from(beam) - 90.0).to_radians();
                let world_from_beam = truth * Pose2::new(0.0, 0.0, bearing);
                let (cos, sin) = world_from_beam.cos_sin();
                let origin = [truth.x(), truth.y()].into();
                let hit = caster.cast(origin, [cos, sin].into(), 80.0);
                let range = hit.map_or(81.83, |hit| hit.distance + 0.01 * noise());
                text += &format!(" {range:.2}");
            }
            let at = format!(
                "{:.4} {:.4} {:.4}",
                odometry.x(),
                odometry.y(),
                odometry.heading()
            );
            text += &format!(" {at} {at} {seconds:.2} host {seconds:.2}\n");
        }
    }
    text
}
