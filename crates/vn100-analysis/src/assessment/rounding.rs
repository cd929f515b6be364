//! What the rounding of values hides of their noise.

use imu_noise::{OctaveSum, Term};
use vn100_protocol::Channel;

use crate::snapshot::ChannelSnapshot;

/// Fewer do not show how the values are rounded.
const LEAST_SAMPLES: u64 = 100;

/// Deviation at m = 1 of noise of half a step, in steps, with what rounding adds: √(1/4 + 1/12).
/// That of less noise depends on where between two steps the level lies.
const LEAST_NOISE_STEPS: f64 = 0.577;

/// Whether noise of this deviation from sample to sample is less than half of a step.
pub(crate) fn is_rounded_away(deviation: f64, step: f64) -> bool {
    deviation < LEAST_NOISE_STEPS * step
}

/// The terms whose values would be those of the rounding.
pub(super) fn hidden_terms(channel: &Channel, results: &ChannelSnapshot) -> &'static [Term] {
    const WITHIN_A_STEP: [Term; 3] = [Term::Quantization, Term::White, Term::BiasInstability];
    let shortest = results.octaves.first().and_then(OctaveSum::deviation_counts);
    let is_hidden = |deviation| is_rounded_away(channel.in_unit(deviation), results.step(channel));
    if results.moments.count() < LEAST_SAMPLES || !shortest.is_some_and(is_hidden) {
        return &[];
    }
    let largest = results.octaves.iter().filter_map(OctaveSum::deviation_counts).fold(0.0, f64::max);
    if channel.in_unit(largest) < results.step(channel) { &Term::ALL } else { &WITHIN_A_STEP }
}
