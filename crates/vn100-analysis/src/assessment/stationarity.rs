//! What happened on a channel during the record: disturbances, changes of level and noise.

use imu_noise::{
    ChannelSignal, Disturbance, LevelChange, LevelFindings, LevelSearch, LevelShape, NarrowBand, NoiseChanges,
    SpectralLine,
};
use schemars::JsonSchema;
use serde::Serialize;
use vn100_protocol::{Channel, Quantity};

use crate::snapshot::ChannelSnapshot;

/// What is slower is no vibration but a cycle of the level.
const SLOWEST_VIBRATION_HZ: f64 = 0.1;

/// What happened during the record on one channel, in seconds of data since its first sample, skipped
/// time included.
#[derive(Debug, Clone, Default, PartialEq, JsonSchema, Serialize)]
pub struct Stationarity {
    /// Peaks of the spectrum, in rising frequency.
    #[serde(skip)]
    pub lines: Vec<SpectralLine>,
    /// Short disturbances, in time order.
    pub disturbances: Vec<Disturbance>,
    /// Warm-up, step or cycle of the level; null if none was found.
    pub level_change: Option<LevelChange>,
    /// What is not the same throughout in the noise.
    #[serde(flatten)]
    pub noise: NoiseChanges,
    /// Whether the record is long enough to show a change of the level.
    pub level_searched: bool,
}

impl Stationarity {
    /// Nothing disturbs temperature and pressure. `bands` are those of the channel's spectrum.
    pub(super) fn of(
        channel: &Channel,
        results: &ChannelSnapshot,
        interval_s: f64,
        skipped_s: f64,
        bands: &[NarrowBand],
        search: &LevelSearch,
    ) -> Self {
        let Some(signal) = results.signal.as_ref().filter(|_| !is_ambient(channel)) else {
            return Self::default();
        };
        let mut lines: Vec<SpectralLine> = bands.iter().filter_map(|band| band.line).collect();
        let cycles: Vec<SpectralLine> = lines.extract_if(.., |line| line.frequency_hz < SLOWEST_VIBRATION_HZ).collect();
        let is_attitude = channel.quantity.is_attitude();
        let LevelFindings { change, is_searched } = level(channel, signal, (interval_s, skipped_s), bands, search);
        let change = change.or_else(|| strongest(&cycles).filter(|_| !is_attitude));
        let noise = match is_attitude {
            true => NoiseChanges::default(),
            false => signal.noise_changes(&results.histogram, interval_s),
        };
        let mut found = Self {
            lines,
            disturbances: signal.disturbances(interval_s),
            level_change: change,
            noise,
            level_searched: is_searched,
        };
        let spans = found.disturbances.iter_mut().map(|found| (&mut found.start_s, &mut found.end_s));
        let spans = spans.chain(found.noise.change.iter_mut().map(|found| (&mut found.start_s, &mut found.end_s)));
        let spans = spans.chain(found.noise.frozen.iter_mut().map(|found| (&mut found.start_s, &mut found.end_s)));
        for (start_s, end_s) in spans {
            *start_s += skipped_s;
            *end_s += skipped_s;
        }
        found
    }

    /// Whether one value for long, or one sample far out, spoils all that is computed of the channel in a
    /// record of so many samples.
    pub(super) fn spoils_record(&self, samples: u64, interval_s: f64) -> bool {
        /// White noise is one percent lower, or five percent higher, with as much.
        const FROZEN_SHARE: f64 = 0.02;
        const OUTLIER_SHARE: f64 = 0.1;
        let duration_s = samples as f64 * interval_s;
        self.noise.frozen.is_some_and(|frozen| frozen.duration_s > FROZEN_SHARE * duration_s)
            || self.noise.spikes.is_some_and(|spikes| spikes.sigmas.powi(2) > OUTLIER_SHARE * samples as f64)
    }

    /// Bias instability, random walk and ramp would be fitted to a change of level.
    pub(super) fn level_poses_as_noise(&self) -> bool {
        self.level_change.is_some_and(|change| !change.is_ramp)
    }
}

fn is_ambient(channel: &Channel) -> bool {
    matches!(channel.quantity, Quantity::Temperature | Quantity::Pressure | Quantity::Value)
}

/// What the level of a channel shows that is neither ambient nor a line, in its own unit.
fn level(
    channel: &Channel,
    signal: &ChannelSignal,
    (interval_s, skipped_s): (f64, f64),
    bands: &[NarrowBand],
    search: &LevelSearch,
) -> LevelFindings {
    let block = signal.blocks().first().map_or(1, |block| block.length);
    let LevelFindings { change, is_searched } = search.find(signal, interval_s, channel.decimals);
    let change = change.map(|change| LevelChange { shape: placed(change.shape, channel.scale, skipped_s), ..change });
    // an attitude follows what turns the sensor: nothing in it warms up
    let is_attitude = channel.quantity.is_attitude();
    let line_near = |frequency: f64| bands.iter().find(|band| is_near(band.frequency(), frequency));
    let is_cycle = |frequency: f64, amplitude: f64| {
        let is_folded = |band: &NarrowBand| is_folded((band.frequency(), band.power), amplitude, block);
        // a line as slow as this is the cycle itself
        let is_vibration = |band: &NarrowBand| band.frequency() >= SLOWEST_VIBRATION_HZ * interval_s;
        !is_attitude && !line_near(frequency).is_some_and(is_vibration) && !bands.iter().any(is_folded)
    };
    let change = change.filter(|change| match change.shape {
        LevelShape::Step { .. } => true,
        LevelShape::WarmUp { .. } => !is_attitude,
        LevelShape::Cycle { period_s, amplitude } => is_cycle(interval_s / period_s, amplitude),
    });
    LevelFindings { change, is_searched }
}

/// In the unit of the channel, with times since the first sample.
fn placed(shape: LevelShape, scale: f64, skipped_s: f64) -> LevelShape {
    match shape {
        LevelShape::WarmUp { amplitude, time_constant_s, skip_s } => LevelShape::WarmUp {
            amplitude: amplitude * scale,
            time_constant_s,
            skip_s: skip_s.map(|skip_s| skip_s + skipped_s),
        },
        LevelShape::Step { start_s, amplitude } => {
            LevelShape::Step { start_s: start_s + skipped_s, amplitude: amplitude * scale }
        }
        LevelShape::Cycle { period_s, amplitude } => LevelShape::Cycle { period_s, amplitude: amplitude * scale.abs() },
    }
}

/// The cycle of most amplitude that the slow spectra show.
fn strongest(cycles: &[SpectralLine]) -> Option<LevelChange> {
    let strongest = cycles.iter().max_by(|a, b| a.amplitude.total_cmp(&b.amplitude))?;
    let shape = LevelShape::Cycle { period_s: 1.0 / strongest.frequency_hz, amplitude: strongest.amplitude };
    Some(LevelChange { shape, sigmas: strongest.peak_to_floor.sqrt(), is_ramp: false })
}

/// Whether a line and a cycle of these frequencies may be one.
fn is_near(line: f64, cycle: f64) -> bool {
    (line - cycle).abs() * 2.0 < cycle
}

/// Whether a line of this frequency in cycles per sample and of this power makes, folded, a cycle
/// of this amplitude in the means of blocks of so many samples.
fn is_folded((line, power): (f64, f64), amplitude: f64, block: u64) -> bool {
    let phase = std::f64::consts::PI * line;
    let left = (phase * block as f64).sin() / (block as f64 * phase.sin());
    line * block as f64 > 0.5 && (2.0 * power).sqrt() * left.abs() > amplitude / 2.0
}

#[cfg(test)]
mod tests {
    use imu_noise::{Frozen, Spikes};

    use super::*;

    #[test]
    fn a_scale_below_zero_turns_a_level_round_but_not_a_cycle() {
        let (start_s, period_s, time_constant_s, skip_s) = (3.0, 7.0, 5.0, Some(9.0));
        let shapes = |level, cycle| {
            [
                LevelShape::WarmUp { amplitude: level, time_constant_s, skip_s },
                LevelShape::Step { start_s, amplitude: level },
                LevelShape::Cycle { period_s, amplitude: cycle },
            ]
        };
        assert_eq!(shapes(4.0, 4.0).map(|shape| placed(shape, 0.5, 0.0)), shapes(2.0, 2.0));
        assert_eq!(shapes(4.0, 4.0).map(|shape| placed(shape, -0.5, 0.0)), shapes(-2.0, 2.0));
    }

    #[test]
    fn a_frozen_part_or_a_sample_far_out_spoils_a_record() {
        let frozen = |duration_s| {
            let frozen = Some(Frozen { start_s: 3.0, end_s: 3.0 + duration_s, duration_s });
            Stationarity { noise: NoiseChanges { frozen, ..NoiseChanges::default() }, ..Stationarity::default() }
                .spoils_record(10_000, 0.01)
        };
        let outlier = |sigmas| {
            let spikes = Some(Spikes { count: 1, sigmas });
            Stationarity { noise: NoiseChanges { spikes, ..NoiseChanges::default() }, ..Stationarity::default() }
                .spoils_record(10_000, 0.01)
        };
        assert_eq!([frozen(1.0), frozen(3.0), outlier(31.0), outlier(32.0)], [false, true, false, true]);
        assert!(!Stationarity::default().spoils_record(10_000, 0.01));
    }

    #[test]
    fn steps_and_cycles_pose_as_noise_and_a_ramp_does_not() {
        let of = |shape, is_ramp| {
            let found = Stationarity {
                level_change: Some(LevelChange { shape, sigmas: 9.0, is_ramp }),
                ..Stationarity::default()
            };
            found.level_poses_as_noise()
        };
        let warm_up = LevelShape::WarmUp { amplitude: 1.0, time_constant_s: 9.0, skip_s: None };
        assert!(!of(warm_up, true));
        assert!(of(warm_up, false));
        assert!(of(LevelShape::Step { start_s: 1.0, amplitude: 1.0 }, false));
        assert!(!Stationarity::default().level_poses_as_noise());
    }

    #[test]
    fn a_cycle_is_a_line_near_it() {
        for (line, expected) in [(0.0149, true), (0.0151, false), (0.0051, true), (0.0049, false)] {
            assert_eq!(is_near(line, 0.01), expected, "{line}");
        }
    }

    #[test]
    fn a_cycle_is_a_line_that_folds_to_half_of_its_amplitude() {
        for (line, block) in [(0.3, 7_u64), (0.013, 64), (0.4999, 10)] {
            // what the mean of a block leaves of a sine of amplitude 2
            let sum = |part: fn(f64) -> f64| -> f64 {
                (0..block).map(|sample| part(std::f64::consts::TAU * line * sample as f64)).sum()
            };
            let left = 2.0 * sum(f64::cos).hypot(sum(f64::sin)) / block as f64;
            assert!(is_folded((line, 2.0), 1.99 * left, block), "{line}");
            assert!(!is_folded((line, 2.0), 2.01 * left, block), "{line}");
        }
    }
}
