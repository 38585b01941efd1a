//! Fixtures shared by tests and benches.

pub mod browser_cost;
#[cfg(not(target_family = "wasm"))]
pub mod calm;
#[cfg(unix)]
pub mod console;
#[cfg(unix)]
pub mod devices;
#[cfg(unix)]
pub mod fuzz;
#[cfg(unix)]
pub mod map_truth;
pub mod recorded_loop;

/// Numbers in [0, 1) without any crate, the same everywhere: a 64-bit linear congruential generator
/// (Knuth, MMIX).
pub fn numbers() -> impl Iterator<Item = f64> {
    let mut state = 1_u64;
    std::iter::repeat_with(move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    })
}
