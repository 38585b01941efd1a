//! The random numbers of a simulation: a stream for each use.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

pub(super) use crate::geom::gaussian_pair;

/// Numbers of their own for one of the uses that a run has for its seed.
pub(super) fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    rng
}
