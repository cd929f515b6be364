//! The facts of a record that the conclusions of a report rest on.

use crate::{
    Record,
    names::sentence,
    units::{ChannelValues, SignalValues},
};
use vn100_analysis::noise::{FitQuality, LevelShape, NoiseChanges, Parameter, Sensor, Status, Term, Verdict};
use vn100_analysis::protocol::BINARY;
use vn100_analysis::{
    FigureVerdict, LongTauValidity, Motion, Onboard, Outages, SENSORS, Timing, WarningKind, sensor_name,
};

#[derive(Debug, Clone)]
pub(crate) struct Findings {
    /// Of the VN-100's; `None` where another sensor's data came.
    pub(crate) message: Option<String>,
    pub(crate) compensated: Option<bool>,
    pub(crate) timing: Timing,
    /// Of the measured rate from the nominal one.
    pub(crate) offset_ppm: Option<f64>,
    pub(crate) outages: Outages,
    pub(crate) has_stamps: bool,
    pub(crate) has_registers: bool,
    pub(crate) has_conditions: bool,
    pub(crate) datasheet: Option<String>,
    pub(crate) sensors: Vec<SensorFindings>,
    /// The sensor was moved.
    pub(crate) motion: Option<Motion>,
    pub(crate) warnings: Vec<WarningKind>,
}

#[derive(Debug, Clone)]
pub(crate) struct SensorFindings {
    pub(crate) sensor: Sensor,
    /// In the middle of a sentence.
    pub(crate) name: &'static str,
    pub(crate) long_taus: LongTauValidity,
    pub(crate) onboard: Option<Onboard>,
    pub(crate) axes: Vec<AxisFindings>,
}

#[derive(Debug, Clone)]
pub(crate) struct AxisFindings {
    pub(crate) name: String,
    pub(crate) unit: String,
    /// Its sample rate.
    pub(crate) rate_hz: f64,
    pub(crate) white: Option<Parameter>,
    /// N by the graphical method, in SI units; it includes every other term of the curve.
    pub(crate) white_by_rule: Option<f64>,
    pub(crate) bias_instability: Option<Parameter>,
    pub(crate) random_walk: Option<Parameter>,
    pub(crate) quality: Option<FitQuality>,
    /// Shortest averaging time of the curve in seconds.
    pub(crate) first_tau_s: Option<f64>,
    /// Longest averaging time with a usable interval, in seconds.
    pub(crate) known_to_s: Option<f64>,
    /// What shakes it: frequency in hertz, share in the short-term variance; the strongest first.
    pub(crate) lines: Vec<(f64, f64)>,
    pub(crate) disturbances: usize,
    pub(crate) steps: bool,
    pub(crate) cycles: bool,
    /// The noise changes, comes in bursts, freezes or has spikes.
    pub(crate) noise_changes: bool,
    /// The factor of the noise from the middle on that would have shown.
    pub(crate) detectable_factor: Option<f64>,
    /// What to exclude at the start, in seconds of data.
    pub(crate) warm_up_s: Option<f64>,
    pub(crate) std: Option<f64>,
    pub(crate) has_temperature_coefficient: bool,
    /// Of the figures of the data sheet, each with what was compared, in words.
    pub(crate) verdicts: Vec<(Term, Verdict, String)>,
}

/// Of the axes of one sensor that with the largest estimate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Largest<'a> {
    axis: &'a AxisFindings,
    pub(crate) value: f64,
    /// Whether it is known that no other axis is worse.
    is_worst: bool,
}

impl Largest<'_> {
    /// `gyro_y, the worst axis`, or that there may be a worse one.
    pub(crate) fn named(&self) -> String {
        let name = &self.axis.name;
        match self.is_worst {
            true => format!("{name}, the worst axis"),
            false => format!("{name}, the largest estimate; an axis that is not estimated may be worse"),
        }
    }
}

/// Of the axes of one sensor that with the largest upper end of its interval, or bound.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Worst<'a> {
    pub(crate) axis: &'a AxisFindings,
    /// Whether every axis has one.
    is_worst: bool,
}

impl Worst<'_> {
    /// `gyro_y, the worst axis`, or that there may be a worse one.
    pub(crate) fn named(&self) -> String {
        format!("{}, the worst {}axis", self.axis.name, if self.is_worst { "" } else { "known " })
    }
}

impl SensorFindings {
    /// By a parameter; `None` if no axis has an estimate.
    pub(crate) fn largest(&self, of: impl Fn(&AxisFindings) -> Option<Parameter>) -> Option<Largest<'_>> {
        let estimate = |axis| of(axis).filter(|found| found.status == Status::Estimated).and_then(|found| found.value);
        let known = self.axes.iter().filter_map(|axis| Some((axis, estimate(axis)?)));
        let (axis, value) = known.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let most = |axis| of(axis).and_then(|found| found.value.or(found.upper));
        let is_worst = self.axes.iter().all(|axis| most(axis).is_some_and(|most| most <= value));
        Some(Largest { axis, value, is_worst })
    }

    /// By a parameter; `None` if no axis is known from above.
    pub(crate) fn worst(&self, of: impl Fn(&AxisFindings) -> Option<Parameter>) -> Option<Worst<'_>> {
        let bounded = |axis| of(axis).and_then(|found| Some((axis, found.upper?)));
        let known = self.axes.iter().filter_map(bounded);
        let (axis, _) = known.max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(Worst { axis, is_worst: self.axes.iter().all(|axis| bounded(axis).is_some()) })
    }
}

impl Findings {
    pub(crate) fn of(record: &Record<'_>) -> Self {
        let snapshot = &record.measured.snapshot;
        let message = snapshot.layout.as_ref().map(|layout| layout.message.to_string());
        Self {
            message: message.filter(|message| message.starts_with("VN") || message == BINARY),
            compensated: snapshot.layout.as_ref().and_then(|layout| layout.compensated),
            timing: snapshot.timing,
            offset_ppm: snapshot.arrivals.and_then(|arrivals| arrivals.offset_ppm),
            datasheet: record.measured.verdicts.as_ref().map(|verdicts| verdicts.datasheet.clone()),
            outages: snapshot.outages,
            has_stamps: snapshot.arrivals.is_some(),
            has_registers: !snapshot.registers.is_empty(),
            has_conditions: record.measured.facts.meta.is_some(),
            sensors: sensors(record),
            motion: record.measured.assessment.motion.clone(),
            warnings: record.measured.warnings().into_iter().map(|warning| warning.kind).collect(),
        }
    }

    pub(crate) fn warns(&self, kind: WarningKind) -> bool {
        self.warnings.contains(&kind)
    }

    pub(crate) fn sensor(&self, sensor: Sensor) -> Option<&SensorFindings> {
        self.sensors.iter().find(|found| found.sensor == sensor)
    }

    pub(crate) fn axes(&self) -> impl Iterator<Item = &AxisFindings> {
        self.sensors.iter().flat_map(|sensor| &sensor.axes)
    }
}

impl AxisFindings {
    /// The value of N where it is estimated.
    pub(crate) fn white_value(&self) -> Option<f64> {
        self.white.filter(|white| white.status == Status::Estimated)?.value
    }
}

fn sensors(record: &Record<'_>) -> Vec<SensorFindings> {
    let of = |(quantity, sensor)| {
        let assessed = record.channels.iter().zip(&record.measured.assessment.channels);
        let axes: Vec<_> = assessed.filter(|(channel, _)| channel.quantity == quantity).collect();
        let (first, assessed) = axes.first()?;
        Some(SensorFindings {
            sensor,
            name: sensor_name(sensor),
            long_taus: first.noise.as_ref()?.long_taus,
            onboard: assessed.onboard,
            axes: axes.iter().map(|(channel, _)| axis(record, channel)).collect(),
        })
    };
    SENSORS.into_iter().filter_map(of).collect()
}

fn axis(record: &Record<'_>, channel: &ChannelValues) -> AxisFindings {
    let parameter = |term| channel.noise.as_ref().and_then(|noise| noise.parameter(term));
    let known = channel.octaves.iter().filter(|point| point.is_known());
    let disturbed = channel.signal.as_ref().map(|signal| &signal.disturbed);
    let change = disturbed.and_then(|disturbed| disturbed.level_change);
    let noise_changes = disturbed.map(|disturbed| &disturbed.noise);
    let sensor = channel.noise.as_ref().map(|noise| noise.sensor);
    let temperature = channel.noise.as_ref().and_then(|noise| noise.temperature.as_ref());
    let said = |verdict: &FigureVerdict| Some((verdict.figure.term, verdict.verdict, sentence(sensor?, verdict)));
    AxisFindings {
        name: channel.name.clone(),
        unit: channel.unit.clone(),
        rate_hz: channel.rate_hz,
        white: parameter(Term::White),
        white_by_rule: channel.noise.as_ref().and_then(|noise| Some(noise.classical.white.ok()?.value)),
        bias_instability: parameter(Term::BiasInstability),
        random_walk: parameter(Term::RateRandomWalk),
        quality: channel.noise.as_ref().and_then(|noise| noise.fit.quality),
        first_tau_s: channel.octaves.first().map(|point| point.tau_s),
        known_to_s: known.map(|point| point.tau_s).reduce(f64::max),
        lines: channel.signal.as_ref().map_or_else(Vec::new, SignalValues::vibrations),
        disturbances: disturbed.map_or(0, |disturbed| disturbed.disturbances.len()),
        steps: change.is_some_and(|change| matches!(change.shape, LevelShape::Step { .. })),
        cycles: change.is_some_and(|change| matches!(change.shape, LevelShape::Cycle { .. })),
        noise_changes: noise_changes.is_some_and(NoiseChanges::any),
        detectable_factor: noise_changes.and_then(|changes| changes.detectable_factor),
        warm_up_s: change.and_then(|change| match change.shape {
            LevelShape::WarmUp { skip_s, .. } => skip_s,
            LevelShape::Step { .. } | LevelShape::Cycle { .. } => None,
        }),
        std: channel.std,
        has_temperature_coefficient: temperature.is_some_and(|temperature| temperature.coefficient.is_ok()),
        verdicts: record.verdicts(channel).iter().filter_map(said).collect(),
    }
}
