//! What the deviation plot shows, in the unit chosen: points, bars, and the model through them.

use imu_noise::{Convention, Deviation, Term};
use vn100_analysis::{letter, sensor_of};
use vn100_report::units::{ChannelValues, Point};

use super::{
    source::{Group, Source},
    state::{Axes, State},
    units::{convention, written},
};

/// Places along an octave where the model is drawn.
const MODEL_STEPS: u32 = 4;

/// Curves of one sensor.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Plot {
    pub(crate) unit: String,
    pub(crate) curves: Vec<Curve>,
}

/// The curve of one axis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Curve {
    pub(crate) name: String,
    /// Place among the axes of the sensor.
    pub(crate) axis: usize,
    pub(crate) points: Vec<Point>,
    /// The model and its parts; only for an axis that is drawn alone.
    pub(crate) model: Vec<ModelLine>,
}

/// One line of the model.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ModelLine {
    /// Its letter; `None` for the sum.
    pub(crate) term: Option<&'static str>,
    /// Averaging time in seconds and deviation.
    pub(crate) points: Vec<(f64, f64)>,
}

/// The unit of deviations, where the sensor has some.
fn unit(group: &Group, state: &State) -> Option<Convention> {
    sensor_of(group.quantity).map(|sensor| convention(sensor, Term::BiasInstability, state.units))
}

/// Deviations in the unit chosen, over those in the unit of the channel.
pub(super) fn factor(group: &Group, state: &State) -> f64 {
    unit(group, state).map_or(1.0, |unit| unit.factor)
}

impl Plot {
    /// The curves of the sensor chosen.
    pub(crate) fn new(state: &State, source: &Source, group: &Group) -> Self {
        let unit = unit(group, state);
        let factor = factor(group, state);
        let axes = group.channels.iter().enumerate();
        let curves = axes.filter(|(axis, _)| state.axes == Axes::All || state.axes == Axes::One(*axis));
        let curves = curves.map(|(axis, place)| {
            let channel = &source.values[*place];
            let points = channel.deviations.iter().map(|point| point.times(factor)).collect();
            let alone = state.axes != Axes::All;
            let model = if alone { model(source, channel, factor) } else { Vec::new() };
            Curve { name: channel.name.clone(), axis, points, model }
        });
        let own = || source.values[group.channels[0]].unit.clone();
        Self { unit: unit.map_or_else(own, written), curves: curves.collect() }
    }

    /// Every deviation that must be seen, with the bounds of those that are known well enough.
    pub(crate) fn deviations(&self) -> impl Iterator<Item = f64> {
        self.curves.iter().flat_map(|curve| &curve.points).flat_map(|point| {
            let bounds = if point.is_known() { [point.lower, point.upper] } else { [None, None] };
            [point.deviation].into_iter().chain(bounds).flatten()
        })
    }

    /// Averaging times of all points.
    pub(crate) fn taus(&self) -> impl Iterator<Item = f64> {
        self.curves.iter().flat_map(|curve| &curve.points).map(|point| point.tau_s)
    }
}

/// The parts of the noise that were estimated, over the averaging times they were fitted to, and
/// their sum.
fn model(source: &Source, channel: &ChannelValues, factor: f64) -> Vec<ModelLine> {
    let Some((noise, quality)) = channel.noise.as_ref().and_then(|noise| Some((noise, noise.fit.quality?))) else {
        return Vec::new();
    };
    let shape = source.snapshot.shape();
    let (first, last) = (quality.tau_min_s / shape.interval_s, quality.tau_max_s / shape.interval_s);
    let steps = ((last / first).log2() * f64::from(MODEL_STEPS)).round().max(0.0) as u32;
    let along = |step: u32| (first * (f64::from(step) / f64::from(MODEL_STEPS)).exp2()).round() as u64;
    let mut factors: Vec<u64> = (0..=steps).map(along).collect();
    factors.dedup();
    let terms = [Term::Quantization, Term::White, Term::BiasInstability, Term::RateRandomWalk, Term::RateRamp];
    let mut sum = vec![0.0; factors.len()];
    let mut lines = Vec::new();
    for term in terms {
        // what the fit holds of the stream, whether it is the sensor's or not
        let Some(amplitude) = noise.fit.parameter(term).and_then(|parameter| parameter.value) else { continue };
        let variances: Vec<f64> = factors.iter().map(|m| term.variance(amplitude, *m, &shape)).collect();
        sum.iter_mut().zip(&variances).for_each(|(sum, variance)| *sum += variance);
        lines
            .push(ModelLine { term: Some(letter(term)), points: line(&factors, &variances, shape.interval_s, factor) });
    }
    if lines.len() > 1 {
        lines.push(ModelLine { term: None, points: line(&factors, &sum, shape.interval_s, factor) });
    }
    lines
}

fn line(factors: &[u64], variances: &[f64], interval_s: f64, factor: f64) -> Vec<(f64, f64)> {
    let point = |(m, variance): (&u64, &f64)| (*m as f64 * interval_s, variance.sqrt() * factor);
    factors.iter().zip(variances).map(point).collect()
}

/// The octave that will be observable next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NextOctave {
    pub(crate) tau_s: f64,
    /// Data time until then, in seconds.
    pub(crate) wait_s: f64,
    /// The record is long enough, but a gap has broken every window: the wait begins behind the
    /// last one.
    pub(crate) broken: bool,
}

/// The octave that will be observable next, and how long that takes; `None` before the first
/// sample.
pub(crate) fn next_octave(source: &Source) -> Option<NextOctave> {
    let snapshot = &source.snapshot;
    let longest = snapshot.channels.iter().filter_map(|channel| channel.octaves.last()).map(|octave| octave.m).max();
    let m = longest.map_or(1, |m| 2 * m);
    let windows = match snapshot.deviation {
        Deviation::Allan => 2,
        Deviation::Hadamard => 3,
    };
    let shape = snapshot.shape();
    let needed = m * windows;
    let lacking = needed.saturating_sub(shape.samples);
    let broken = lacking == 0;
    let wait_s = if broken { needed } else { lacking } as f64 * shape.interval_s;
    (snapshot.timing.samples > 0).then_some(NextOctave { tau_s: m as f64 * shape.interval_s, wait_s, broken })
}
