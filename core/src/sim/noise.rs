//! The random numbers of a simulation: one stream for each use.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

pub(super) use crate::geom::gaussian_pair;

/// A separate stream for one of the uses of a run's seed.
pub(super) fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    rng
}
