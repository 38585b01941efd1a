//! Which points of the moving cloud are paired.

use nalgebra::Vector2;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::super::Cloud;
use super::Selection;

/// Directions that surfaces are sorted into, for uniform normals.
const DIRECTIONS: usize = 16;

/// The indices of the points to be paired.
pub(super) fn select(cloud: &Cloud, selection: Selection) -> Vec<usize> {
    let count = cloud.points().len();
    let all = || (0..count).collect::<Vec<_>>();
    let normal = |index: usize| Some(cloud.surfaces().get(index)?.as_ref()?.normal);
    match selection {
        Selection::All => all(),
        Selection::Random { count, seed } => {
            let mut drawn = all();
            drawn.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
            drawn.truncate(count);
            drawn
        }
        Selection::UniformNormals { count } => uniform_normals(&all(), count, normal),
        Selection::KeyPoints { bend } => {
            let least = libm::cos(bend);
            let is_bent = |&index: &usize| {
                let beside = [index.checked_sub(2), Some(index + 2)];
                let [Some(before), Some(after)] = beside.map(|at| at.and_then(normal)) else {
                    return false;
                };
                before.dot(&after) < least
            };
            all().into_iter().filter(is_bent).collect()
        }
    }
}

/// Points taken in turn from each of the directions that their surfaces face.
fn uniform_normals(
    all: &[usize],
    count: usize,
    normal: impl Fn(usize) -> Option<Vector2<f64>>,
) -> Vec<usize> {
    let mut by_direction: [Vec<usize>; DIRECTIONS] = Default::default();
    for &index in all {
        let Some(normal) = normal(index) else {
            continue;
        };
        let part = libm::atan2(normal.y, normal.x) / std::f64::consts::TAU + 0.5;
        let direction = ((part * DIRECTIONS as f64) as usize).min(DIRECTIONS - 1);
        if let Some(those) = by_direction.get_mut(direction) {
            those.push(index);
        }
    }
    // From each direction, an even spread along the scan: every k-th point first.
    for those in &mut by_direction {
        let share = (count / DIRECTIONS).max(1);
        let stride = those.len().div_ceil(share).max(1);
        let spread = (0..stride).flat_map(|first| those.iter().skip(first).step_by(stride));
        *those = spread.copied().collect();
    }
    let most = by_direction.iter().map(Vec::len).max().unwrap_or(0);
    let in_turn = (0..most).flat_map(|at| by_direction.iter().filter_map(move |d| d.get(at)));
    in_turn.copied().take(count).collect()
}
