//! What disturbs a channel.

use imu_noise::{
    Disturbance, LevelChange, LevelFindings, LevelSearch, LevelShape, NarrowBand, NoiseChanges, SpectralLine,
};
use vn100_protocol::{Channel, Quantity};

use crate::snapshot::ChannelSnapshot;

/// What disturbs one channel.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Disturbed {
    /// Lines in its spectrum, in rising frequency.
    pub lines: Vec<SpectralLine>,
    /// In time order, in seconds of data behind those skipped.
    pub disturbances: Vec<Disturbance>,
    /// What is not the same throughout in its noise, likewise; not searched in an attitude.
    pub noise: NoiseChanges,
    /// A warm-up, a step or a cycle of the level.
    pub level_change: Option<LevelChange>,
    /// The step in the middle of the record, in the unit of the channel, that nine of ten such
    /// records would show; `None` for a record of few blocks.
    pub detectable_step: Option<f64>,
}

impl Disturbed {
    /// Nothing disturbs temperature and pressure, and of a foreign series nothing is known that
    /// would. `bands` are those of the channel's spectrum.
    pub(super) fn of(
        channel: &Channel,
        results: &ChannelSnapshot,
        interval_s: f64,
        bands: &[NarrowBand],
        search: &LevelSearch,
    ) -> Self {
        // ambient changes are no disturbances
        let ambient = matches!(channel.quantity, Quantity::Temperature | Quantity::Pressure | Quantity::Value);
        let Some(signal) = results.signal.as_ref().filter(|_| !ambient) else {
            return Self::default();
        };
        let mut lines = signal.spectrum().lines(interval_s, channel.decimals);
        lines.iter_mut().for_each(|line| line.amplitude *= channel.scale.abs());
        let blocks = signal.blocks();
        let level = results.removed_temperature.as_ref().map(|removed| removed.removal.without(&blocks));
        let level = level.as_deref().unwrap_or(&blocks);
        let LevelFindings { change, detectable_step } = search.find_in(level, interval_s, channel.decimals);
        let block = blocks.first().map_or(1, |block| block.length);
        let change = change.map(|change| LevelChange { shape: scaled(change.shape, channel.scale), ..change });
        let is_attitude = channel.quantity.is_attitude();
        let level_change = change.filter(|change| match change.shape {
            LevelShape::Step { .. } => true,
            // an attitude follows what turns the sensor: nothing in it warms up
            LevelShape::WarmUp { .. } => !is_attitude,
            LevelShape::Cycle { period_s, amplitude } => {
                !is_attitude && !bands.iter().any(|band| is_line(band, interval_s / period_s, amplitude, block))
            }
        });
        Self {
            lines,
            disturbances: signal.disturbances(interval_s),
            noise: match is_attitude {
                true => NoiseChanges::default(),
                false => signal.noise_changes(&results.histogram, interval_s),
            },
            level_change,
            detectable_step: detectable_step.map(|step| step * channel.scale.abs()),
        }
    }

    /// The sensor was still warming up.
    pub(super) fn is_warming_up(&self) -> bool {
        self.level_change.is_some_and(|change| matches!(change.shape, LevelShape::WarmUp { .. }))
    }

    /// Bias instability, random walk and ramp would be fitted to a change of level.
    pub(super) fn level_poses_as_noise(&self) -> bool {
        self.level_change.is_some_and(|change| !change.is_ramp)
    }
}

fn scaled(shape: LevelShape, scale: f64) -> LevelShape {
    match shape {
        LevelShape::WarmUp { amplitude, time_constant_s, skip_s } => {
            LevelShape::WarmUp { amplitude: amplitude * scale, time_constant_s, skip_s }
        }
        LevelShape::Step { start_s, amplitude } => LevelShape::Step { start_s, amplitude: amplitude * scale },
        LevelShape::Cycle { period_s, amplitude } => LevelShape::Cycle { period_s, amplitude: amplitude * scale.abs() },
    }
}

/// Whether a cycle in the means of blocks of so many samples, its frequency in cycles per sample,
/// is the line of `band`, itself or folded.
fn is_line(band: &NarrowBand, frequency: f64, amplitude: f64, block: u64) -> bool {
    let phase = std::f64::consts::PI * band.frequency();
    let left = (phase * block as f64).sin() / (block as f64 * phase.sin());
    let is_near = (band.frequency() - frequency).abs() * 2.0 < frequency;
    is_near || (2.0 * band.power).sqrt() * left.abs() > amplitude / 2.0
}
