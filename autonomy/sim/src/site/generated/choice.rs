//! Random choices.

use geometry::Rng;

/// One of several, each with the same probability. The list must not be empty.
pub(super) fn pick<T: Copy>(rng: &mut Rng, choices: &[T]) -> T {
    choices[(rng.bits() % choices.len() as u64) as usize]
}

/// True with that probability.
pub(super) fn chance(rng: &mut Rng, probability: f64) -> bool {
    rng.uniform() < probability
}
