//! The clock of the sensor.

use rand_chacha::ChaCha8Rng;

use crate::{
    noise::{NoiseComponent, random_stream},
    normal::normal,
};

/// Number of the random stream of the clock, after those of channels and surroundings.
const CLOCK_STREAM: u32 = 13;

/// The jitter of the sensor's clock, like that of a real sensor at 800 Hz.
const JITTER_NS: f64 = 4_500.0;

/// The steps of that clock.
const CLOCK_STEP_NS: u64 = 1_000;

/// The device times of an emulated sensor.
#[derive(Debug, Clone)]
pub(crate) struct SensorClock {
    random: ChaCha8Rng,
}

impl SensorClock {
    pub(crate) fn new(seed: u64) -> Self {
        Self { random: random_stream(seed, CLOCK_STREAM, NoiseComponent::White) }
    }

    /// The reading of the clock at this time after the start; it never decreases from tick to tick,
    /// in spite of the jitter.
    pub(crate) fn read(&mut self, since_start_ns: u64) -> u64 {
        let jitter_ns = (JITTER_NS * normal(&mut self.random)).clamp(-5.0 * JITTER_NS, 5.0 * JITTER_NS);
        since_start_ns.saturating_add_signed(jitter_ns as i64) / CLOCK_STEP_NS * CLOCK_STEP_NS
    }
}
