//! What disturbs one channel, as in the JSON document.

use serde::Serialize;
use vn100_analysis::Disturbed;
use vn100_analysis::noise::{Disturbance, Frozen, LevelChange, LevelShape, NoiseChange, Spikes};

/// What happened in the middle of the record, in seconds of data since its first sample, those
/// skipped included.
#[derive(Debug, Serialize)]
pub(super) struct StationarityDocument {
    disturbances: Vec<DisturbanceDocument>,
    level_change: Option<LevelChangeDocument>,
    noise_change: Option<NoiseChangeDocument>,
    /// Variance of the noise from block to block over that of even noise.
    bursts: Option<f64>,
    frozen: Option<FrozenDocument>,
    spikes: Option<SpikesDocument>,
    /// The smallest changes in the middle of the record that nine of ten such records show.
    detectable: Detectable,
}

#[derive(Debug, Serialize)]
struct DisturbanceDocument {
    start_s: f64,
    end_s: f64,
    sigmas: f64,
}

#[derive(Debug, Serialize)]
struct LevelChangeDocument {
    shape: &'static str,
    amplitude: f64,
    /// Of a step.
    start_s: Option<f64>,
    /// Of a warm-up.
    time_constant_s: Option<f64>,
    /// The skip that leaves it out.
    skip_s: Option<f64>,
    /// Of a cycle.
    period_s: Option<f64>,
    sigmas: f64,
}

#[derive(Debug, Serialize)]
struct NoiseChangeDocument {
    start_s: f64,
    end_s: f64,
    /// Standard deviation over that of the rest.
    factor: f64,
    sigmas: f64,
}

#[derive(Debug, Serialize)]
struct FrozenDocument {
    start_s: f64,
    end_s: f64,
    duration_s: f64,
}

#[derive(Debug, Serialize)]
struct SpikesDocument {
    count: u64,
    sigmas: f64,
}

#[derive(Debug, Serialize)]
struct Detectable {
    noise_factor: Option<f64>,
    step: Option<f64>,
}

impl StationarityDocument {
    pub(super) fn new(disturbed: &Disturbed, skipped_s: f64) -> Self {
        let noise = &disturbed.noise;
        let disturbances = disturbed.disturbances.iter().map(|&Disturbance { start_s, end_s, sigmas }| {
            DisturbanceDocument { start_s: skipped_s + start_s, end_s: skipped_s + end_s, sigmas }
        });
        Self {
            disturbances: disturbances.collect(),
            level_change: disturbed.level_change.map(|change| LevelChangeDocument::new(change, skipped_s)),
            noise_change: noise.change.map(|NoiseChange { start_s, end_s, factor, sigmas }| NoiseChangeDocument {
                start_s: skipped_s + start_s,
                end_s: skipped_s + end_s,
                factor,
                sigmas,
            }),
            bursts: noise.bursts,
            frozen: noise.frozen.map(|Frozen { start_s, end_s, duration_s }| FrozenDocument {
                start_s: skipped_s + start_s,
                end_s: skipped_s + end_s,
                duration_s,
            }),
            spikes: noise.spikes.map(|Spikes { count, sigmas }| SpikesDocument { count, sigmas }),
            detectable: Detectable { noise_factor: noise.detectable_factor, step: disturbed.detectable_step },
        }
    }
}

impl LevelChangeDocument {
    fn new(change: LevelChange, skipped_s: f64) -> Self {
        let named = |shape, amplitude| Self {
            shape,
            amplitude,
            start_s: None,
            time_constant_s: None,
            skip_s: None,
            period_s: None,
            sigmas: change.sigmas,
        };
        match change.shape {
            LevelShape::WarmUp { amplitude, time_constant_s, skip_s } => Self {
                time_constant_s: Some(time_constant_s),
                skip_s: skip_s.map(|skip_s| skipped_s + skip_s),
                ..named("warm-up", amplitude)
            },
            LevelShape::Step { start_s, amplitude } => {
                Self { start_s: Some(skipped_s + start_s), ..named("step", amplitude) }
            }
            LevelShape::Cycle { period_s, amplitude } => Self { period_s: Some(period_s), ..named("cycle", amplitude) },
        }
    }
}
