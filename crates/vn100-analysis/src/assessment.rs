//! What a snapshot says of the sensor, channel by channel.

mod axis_temperature;
mod mains;
mod noise;
mod onboard;
mod points;
mod rest;
mod rounding;
mod stationarity;
mod stationary;
mod stream;
mod temperature;
mod units;
mod white_budget;

use imu_noise::{
    ChannelCurve, Interval, LevelSearch, Octave, OctaveSum, PowerLaw, RecordShape, counts_to_unit, noise_types,
};
use vn100_protocol::Channel;

pub use axis_temperature::AxisTemperature;
pub use noise::{BEFORE_FILTER_S, ChannelNoise, LongTauValidity, NoGrade};
pub use onboard::{Onboard, WindowFrom};
pub(crate) use rounding::is_rounded_away;
pub use stationarity::Stationarity;
pub(crate) use stationary::{frequency_and_share, have_one_cause};
pub use white_budget::{Aliasing, RateShare, WhiteBudget};

use crate::{
    assessment::{noise::Models, points::KnownEdf},
    in_parallel::{both, in_parallel},
    motion::Motion,
    snapshot::{ChannelSnapshot, Snapshot},
    warning::Warning,
};

/// What a snapshot says of the sensor, at one level of confidence: a function of the snapshot alone. It
/// may be used with a later one: the octaves of a record that has grown a little have nearly the same
/// degrees of freedom.
#[derive(Debug, Clone)]
pub struct Assessment {
    /// Number of samples in the statistics that were assessed.
    pub samples: u64,
    /// Two-sided level of every interval, 0 < p < 1.
    pub confidence: f64,
    /// One per channel, in the order of the layout.
    pub channels: Vec<ChannelAssessment>,
    /// The motion of the sensor; `None` where the record shows the sensor at rest.
    pub motion: Option<Motion>,
    /// Limits of the results, in addition to the warnings of the snapshot.
    pub warnings: Vec<Warning>,
}

/// One channel of an [`Assessment`], in the channel's own unit.
#[derive(Debug, Clone)]
pub struct ChannelAssessment {
    /// One per octave of the snapshot.
    pub octaves: Vec<OctaveAssessment>,
    /// One per point of the snapshot.
    pub points: Vec<OctaveAssessment>,
    /// The noise parameters of a sensor's axis; `None` for angles, temperature and pressure.
    pub noise: Option<ChannelNoise>,
    /// Vibration, disturbances, changes of level; not searched where the sensor was moved.
    pub stationarity: Stationarity,
    /// What the sensor does on board to the white noise of the channel, if it is known.
    pub onboard: Option<Onboard>,
}

/// With fewer degrees of freedom an interval spans more than a factor of ten, and none is given.
pub const LEAST_EDF: f64 = 2.0;

/// What is known of the deviation at one averaging factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OctaveAssessment {
    /// Averaging factor.
    pub m: u64,
    /// Exponent of the spectrum nearest to this noise; `None` with too few blocks.
    pub alpha: Option<i8>,
    /// Degrees of freedom, and confidence limits of a deviation of 1; `None` below [`LEAST_EDF`]. They
    /// follow from the fitted mixture of noises or, where no model fits, from the kind of noise here.
    pub relative: Option<Interval>,
}

impl Assessment {
    /// Assesses a snapshot at the level `confidence`, 0 < p < 1; outside that range there are no
    /// intervals and no parameters. A snapshot without samples has no channels.
    pub fn new(snapshot: &Snapshot, confidence: f64) -> Self {
        let motion = Motion::of(snapshot);
        let curve = |(channel, results)| OctaveVariances::new(channel, results, snapshot.shape_of(results));
        let curves: Vec<_> = snapshot.measured().map(curve).collect();
        let signals = snapshot.channels.iter().filter_map(|results| results.signal.as_ref());
        let (models, levels) =
            both(|| Models::of(snapshot, &curves), || LevelSearch::of(signals.clone().filter(|_| motion.is_none())));
        let known = KnownEdf::new(confidence);
        let mut channels = in_parallel(snapshot.measured().zip(&curves), |((channel, results), curve)| {
            let levels = motion.is_none().then_some(&levels);
            ChannelAssessment::new(channel, results, curve, snapshot, levels, &known, &models)
        });
        for (((_, results), curve), channel) in snapshot.measured().zip(&curves).zip(&mut channels) {
            channel.points = known.points(results, curve, &channel.octaves);
        }
        temperature::add(snapshot, motion.is_some(), confidence, &mut channels);
        noise::withhold_what_poses_as_noise(&mut channels);
        noise::withhold_unproved(&mut channels);
        let mut warnings = stream::warnings(snapshot, &channels, motion.is_some());
        let is_outlying = |(_, _, of): &(_, _, &ChannelAssessment)| of.stationarity.noise.spikes.is_some();
        let outlying: Vec<&Channel> =
            snapshot.assessed(&channels).filter(is_outlying).map(|(channel, ..)| channel).collect();
        warnings.extend(units::warning(snapshot, &outlying, motion.is_some()));
        match &motion {
            Some(motion) => warnings.push(motion.warning()),
            None => {
                warnings.extend(stationary::warnings(snapshot, &channels));
                warnings.extend(temperature::warning(snapshot, &channels));
                warnings.extend(rest::warnings(snapshot));
            }
        }
        Self { samples: snapshot.timing.samples, confidence, channels, motion, warnings }
    }
}

impl ChannelAssessment {
    fn new(
        channel: &Channel,
        results: &ChannelSnapshot,
        curve: &OctaveVariances,
        snapshot: &Snapshot,
        levels: Option<&LevelSearch>,
        known: &KnownEdf,
        models: &Models,
    ) -> Self {
        let onboard = Onboard::of(channel, results, snapshot);
        let signal = results.signal.as_ref();
        let bands =
            signal.map_or_else(Vec::new, |signal| signal.narrow_bands(channel.in_unit(1.0), curve.shape.interval_s));
        let mut stationarity = match levels {
            None => Stationarity::default(),
            Some(levels) => {
                let skipped_s = snapshot.skipped.as_secs_f64();
                Stationarity::of(channel, results, curve.shape.interval_s, skipped_s, &bands, levels)
            }
        };
        let evidence = ChannelCurve {
            bands: &bands,
            signal: signal.map(|signal| (signal, channel.in_unit(1.0))),
            is_averaging_known: onboard
                .is_some_and(|onboard| onboard.window_known() && onboard.own_low_pass().is_none()),
            fourth_cumulant: fourth_cumulant_counts4(results) * channel.in_unit(1.0).powi(4),
            ..ChannelCurve::default()
        };
        let mut noise = ChannelNoise::new(channel, curve, snapshot, onboard, &evidence, known.confidence, models);
        if let Some(noise) = &mut noise {
            noise.rounded_away = rounding::hidden_terms(channel, results);
            if levels.is_none() {
                noise.was_moved();
            }
            if stationarity.spoils_record(curve.shape.samples, curve.shape.interval_s) {
                noise.was_spoiled();
                // they are of the few samples beside those of one value
                (stationarity.lines, stationarity.disturbances) = Default::default();
            }
        }
        let fitted = |octave: &Octave| noise.as_ref().and_then(|noise| noise.fit.edf(octave.m));
        let octaves = assess_octaves(curve, fitted, known);
        Self { octaves, points: Vec::new(), noise, stationarity, onboard }
    }
}

/// What is known of each octave: by its fitted degrees of freedom, else by the kind of noise seen
/// there or last before.
fn assess_octaves(
    OctaveVariances { shape, octaves, variances, .. }: &OctaveVariances,
    fitted: impl Fn(&Octave) -> Option<f64>,
    known: &KnownEdf,
) -> Vec<OctaveAssessment> {
    let mut last_law = None;
    let assess = |(octave, law): (&Octave, Option<PowerLaw>)| {
        last_law = law.or(last_law);
        let relative = match fitted(octave) {
            Some(edf) => known.interval(edf),
            None => last_law.and_then(|law| known.interval(known.of(octave, shape, law)?)),
        };
        OctaveAssessment { m: octave.m, alpha: law.map(PowerLaw::alpha), relative }
    };
    octaves.iter().zip(noise_types(octaves, variances, shape)).map(assess).collect()
}

/// Fourth cumulant of the white noise. Normal noise of any other kind adds none, but one record of
/// slow noise may look as if it did: 0 where white noise is less than half of the variance.
fn fourth_cumulant_counts4(results: &ChannelSnapshot) -> f64 {
    let shortest = results.octaves.first().and_then(OctaveSum::variance_counts2);
    let of = |(variance, white): (f64, f64)| {
        let kurtosis = results.moments.excess_kurtosis().filter(|_| variance <= 2.0 * white)?;
        Some(kurtosis * variance * variance)
    };
    results.moments.variance_counts2().zip(shortest).and_then(of).unwrap_or(0.0)
}

/// The octave variances of one channel, in its own unit.
#[derive(Debug)]
struct OctaveVariances {
    shape: RecordShape,
    octaves: Vec<Octave>,
    /// In the unit squared; no number where the sum is unknown.
    variances: Vec<f64>,
}

impl OctaveVariances {
    fn new(channel: &Channel, results: &ChannelSnapshot, shape: RecordShape) -> Self {
        let variance = |counts2| counts_to_unit(counts2, 2 * channel.decimals) * channel.scale * channel.scale;
        Self {
            shape,
            octaves: results.octaves.iter().map(OctaveSum::octave).collect(),
            variances: (results.octaves.iter()).map(|sum| sum.variance_counts2().map_or(f64::NAN, variance)).collect(),
        }
    }

    fn tau_s(&self, octave: &Octave) -> f64 {
        octave.m as f64 * self.shape.interval_s
    }
}

impl Snapshot {
    /// The same with what `assessments` of this snapshot say of each.
    pub(crate) fn assessed<'a>(
        &'a self,
        assessments: &'a [ChannelAssessment],
    ) -> impl Iterator<Item = (&'a Channel, &'a ChannelSnapshot, &'a ChannelAssessment)> + Clone {
        self.measured().zip(assessments).map(|((channel, results), assessed)| (channel, results, assessed))
    }
}
