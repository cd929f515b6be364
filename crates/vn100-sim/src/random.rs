//! Random numbers: a stream of its own for each component of each channel.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// A standard normal deviate.
pub(crate) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// Numbers of the random streams of one channel. They are part of every capture's recipe: append
/// only.
#[derive(Debug, Clone, Copy)]
pub(crate) enum NoiseComponent {
    White = 0,
    Flicker = 1,
    Walk = 2,
    LinePhase = 3,
    TurnOnBias = 4,
}

pub(crate) fn random_stream(seed: u64, channel: u32, component: NoiseComponent) -> ChaCha8Rng {
    // room for components to come, so that they do not renumber those of the next channel
    const STREAMS_PER_CHANNEL: u64 = 16;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(u64::from(channel) * STREAMS_PER_CHANNEL + component as u64);
    rng
}
