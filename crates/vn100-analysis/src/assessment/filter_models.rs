//! Models of the noise for those who design filters.

use imu_noise::{GaussMarkovFit, NoiseModel, OverBound, Terms, over_bound};
use vn100_protocol::Channel;

use super::{ChannelAssessment, Curve, noise::LongTauValidity};
use crate::snapshot::{ChannelSnapshot, Snapshot};

/// With fewer degrees of freedom the upper bound of an octave says nothing.
const LEAST_EDF: f64 = 2.0;

/// Noise models of one axis for a filter, in the unit of its channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilterModels {
    /// White noise and a first-order Gauss-Markov process; `None` where long averaging times do not
    /// show the sensor, and where the model cannot be fitted.
    pub gauss_markov: Option<GaussMarkovFit>,
    /// The smallest white noise and random walk that together lie above the upper bounds of all
    /// octaves with two degrees of freedom or more.
    pub over_bound: Option<OverBound>,
}

impl FilterModels {
    /// For each channel of `snapshot`, `None` for what is no axis of a sensor; `assessed` is of the
    /// same snapshot at the level `confidence`. Takes some tenths of a second per axis.
    #[must_use]
    pub fn of(snapshot: &Snapshot, assessed: &[ChannelAssessment], confidence: f64) -> Vec<Option<Self>> {
        (snapshot.measured().zip(assessed))
            .map(|((channel, results), assessed)| Self::of_channel(channel, results, assessed, snapshot, confidence))
            .collect()
    }

    fn of_channel(
        channel: &Channel,
        results: &ChannelSnapshot,
        assessed: &ChannelAssessment,
        snapshot: &Snapshot,
        confidence: f64,
    ) -> Option<Self> {
        let noise = assessed.noise.as_ref()?;
        let curve = Curve::new(channel, results, snapshot.shape());
        let gauss_markov = (noise.long_taus == LongTauValidity::Sensor).then(|| {
            // octaves that vibration disturbs are not part of the fit
            let first = noise.fit.quality.map_or(0.0, |quality| quality.tau_min_s);
            let skip = curve.octaves.iter().take_while(|octave| curve.tau_s(octave) < first).count();
            let model = NoiseModel::new(&curve.octaves[skip..], &curve.shape, Terms::WHITE, noise.window);
            model.fit_gauss_markov(&curve.variances[skip..], confidence)
        });
        let (tau_s, bounds): (Vec<f64>, Vec<f64>) = (curve.octaves.iter().zip(&curve.variances).zip(&assessed.octaves))
            .filter_map(|((octave, variance), assessed)| {
                let relative = assessed.relative.filter(|relative| relative.edf >= LEAST_EDF)?;
                Some((curve.tau_s(octave), variance.sqrt() * relative.upper))
            })
            .unzip();
        Some(Self { gauss_markov: gauss_markov.flatten(), over_bound: over_bound(&tau_s, &bounds) })
    }
}
