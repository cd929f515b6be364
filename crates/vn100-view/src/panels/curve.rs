//! What the deviation plot shows, in the unit chosen: points, bars, the model through them, and the
//! logarithmic axes around them.

use imu_noise::{Deviation, Term};
use vn100_analysis::{ChannelResult, Point, letter};

use crate::{
    panels::sheet::{self, ModelLine},
    source::{ChannelGroup, SourceView},
    state::{ShownAxes, ViewState},
    units::ShownUnit,
};

/// Places along an octave where the model is drawn.
const MODEL_STEPS: u32 = 4;

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AllanPlot<'a> {
    pub(crate) deviation: Deviation,
    pub(crate) unit: ShownUnit<'a>,
    pub(crate) curves: Vec<AllanCurve>,
    /// Of the data sheet.
    pub(crate) sheet: Option<ModelLine>,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AllanCurve {
    pub(crate) name: String,
    /// Place among the axes of the sensor.
    pub(crate) axis: usize,
    pub(crate) points: Vec<Point>,
    /// The model and its parts; only for an axis that is drawn alone.
    pub(crate) model: Vec<ModelLine>,
    /// Of the reference, where that has the axis.
    pub(crate) reference: Option<ModelLine>,
}

/// The letter of the reference in the plot.
pub(crate) const REFERENCE: &str = "R";

impl<'a> AllanPlot<'a> {
    pub(crate) fn new(state: &ViewState, source: &'a SourceView, group: &ChannelGroup) -> Self {
        let unit = ShownUnit::of(&source.result.channels[group.channels[0]]);
        let factor = unit.factor;
        let deviation = source.result.deviation();
        let axes = group.channels.iter().enumerate();
        let curves = axes.filter(|(axis, _)| state.is_shown(*axis));
        let curves = curves.map(|(axis, place)| {
            let channel = &source.result.channels[*place];
            let points = channel.allan.points.iter().map(|point| point.times(factor)).collect();
            let alone = state.axes != ShownAxes::All;
            let model = if alone { model(source, channel, factor) } else { Vec::new() };
            let reference = source.reference.as_ref().filter(|reference| reference.deviation == deviation);
            let reference = reference.and_then(|reference| reference.curve(channel)).map(|points| ModelLine {
                term: Some(REFERENCE),
                points: points.iter().map(|(tau_s, deviation)| (*tau_s, deviation * factor)).collect(),
            });
            AllanCurve { name: channel.name.clone(), axis, points, model, reference }
        });
        let mut plot = Self { deviation, unit, curves: curves.collect(), sheet: None };
        let mut taus: Vec<f64> = plot.taus().collect();
        taus.sort_by(f64::total_cmp);
        taus.dedup();
        plot.sheet = sheet::line(source, group, &taus, factor);
        plot
    }

    /// Every deviation that must be seen, with the bounds of those that are known well enough; of
    /// the data sheet and the reference what is near them.
    pub(crate) fn deviations(&self) -> Vec<f64> {
        const NEAR: f64 = 3.0;
        let mut all: Vec<f64> = self.measured().collect();
        let least = all.iter().copied().filter(|deviation| *deviation > 0.0).fold(f64::INFINITY, f64::min);
        let most = all.iter().copied().fold(0.0, f64::max);
        let others = self.curves.iter().filter_map(|curve| curve.reference.as_ref()).chain(&self.sheet);
        let others = others.flat_map(|line| &line.points).map(|(_, deviation)| *deviation);
        all.extend(others.filter(|deviation| (least / NEAR..most * NEAR).contains(deviation)));
        all
    }

    fn measured(&self) -> impl Iterator<Item = f64> {
        self.curves.iter().flat_map(|curve| &curve.points).flat_map(|point| {
            let bounds = if point.is_known() { [point.lower, point.upper] } else { [None, None] };
            [point.deviation].into_iter().chain(bounds).flatten()
        })
    }

    /// Those that are no measurement: the models of the curves, and the data sheet.
    pub(crate) fn lines(&self) -> impl Iterator<Item = &ModelLine> {
        self.curves.iter().flat_map(|curve| curve.model.iter().chain(&curve.reference)).chain(&self.sheet)
    }

    /// The points of the curve with the most octaves.
    pub(crate) fn octaves(&self) -> &[Point] {
        self.curves.iter().map(|curve| &curve.points[..]).max_by_key(|points| points.len()).unwrap_or(&[])
    }

    pub(crate) fn taus(&self) -> impl Iterator<Item = f64> {
        self.curves.iter().flat_map(|curve| &curve.points).map(|point| point.tau_s)
    }
}

/// The estimated parts of the noise over the averaging times of the fit, and the whole solution.
fn model(source: &SourceView, channel: &ChannelResult, factor: f64) -> Vec<ModelLine> {
    let Some((noise, quality)) = channel.noise.as_ref().and_then(|noise| Some((noise, noise.fit?))) else {
        return Vec::new();
    };
    let shape = source.result.shape();
    let (first, last) = (quality.tau_min_s / shape.interval_s, quality.tau_max_s / shape.interval_s);
    let steps = ((last / first).log2() * f64::from(MODEL_STEPS)).round().max(0.0) as u32;
    let along = |step: u32| (first * (f64::from(step) / f64::from(MODEL_STEPS)).exp2()).round() as u64;
    let mut factors: Vec<u64> = (0..=steps).map(along).collect();
    factors.dedup();
    let terms = [Term::Quantization, Term::White, Term::BiasInstability, Term::RateRandomWalk, Term::RateRamp];
    let mut lines = Vec::new();
    for term in terms {
        let Some(amplitude) = noise.parameter(term).and_then(|parameter| parameter.value) else { continue };
        let variances: Vec<f64> = factors.iter().map(|m| term.variance(amplitude, *m, &shape)).collect();
        lines
            .push(ModelLine { term: Some(letter(term)), points: line(&factors, &variances, shape.interval_s, factor) });
    }
    let whole = channel.octaves().iter().filter_map(|point| Some((point.tau_s, point.fitted? * factor)));
    lines.push(ModelLine { term: None, points: whole.collect() });
    lines
}

fn line(factors: &[u64], variances: &[f64], interval_s: f64, factor: f64) -> Vec<(f64, f64)> {
    let point = |(m, variance): (&u64, &f64)| (*m as f64 * interval_s, variance.sqrt() * factor);
    factors.iter().zip(variances).map(point).collect()
}

/// A span of a logarithmic axis, as decimal logarithms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LogAxis {
    pub(crate) low: f64,
    pub(crate) high: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GridLine {
    /// Decimal logarithm.
    pub(crate) at: f64,
    pub(crate) label: String,
}

/// Narrower than this an axis says nothing.
const LEAST_SPAN: f64 = 0.6;

impl LogAxis {
    /// As wide as the positive values, with a little room at both ends; `None` without any.
    pub(crate) fn over(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let logs = values.into_iter().filter(|value| value.is_finite() && *value > 0.0).map(f64::log10);
        let (low, high) =
            logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), log| (low.min(log), high.max(log)));
        if low > high {
            return None;
        }
        let middle = f64::midpoint(low, high);
        let half = ((high - low).max(LEAST_SPAN) / 2.0) * 1.06;
        Some(Self { low: middle - half, high: middle + half })
    }

    /// Where a value lies, 0 at the low end, 1 at the high one; `None` outside.
    pub(crate) fn part(self, value: f64) -> Option<f64> {
        let part = (value.log10() - self.low) / (self.high - self.low);
        (0.0..=1.0).contains(&part).then_some(part)
    }

    /// The decades within, every second or third if there are more than `most`; with few decades
    /// twos and fives too.
    pub(crate) fn ticks(self, most: usize) -> Vec<GridLine> {
        let (first, last) = (self.low.ceil() as i32, self.high.floor() as i32);
        let decades = (last - first + 1).max(0) as usize;
        let mut ticks = Vec::new();
        if decades >= 3 || decades > most {
            let apart = decades.div_ceil(most.max(1)).max(1);
            ticks.extend((first..=last).step_by(apart).map(|exponent| tick(1, exponent)));
        } else {
            for exponent in first - 1..=last {
                ticks.extend([1, 2, 5].map(|digit| tick(digit, exponent)));
            }
            ticks.retain(|tick| (self.low..=self.high).contains(&tick.at));
            while ticks.len() > most.max(1) {
                let mut keep = false;
                ticks.retain(|_| {
                    keep = !keep;
                    keep
                });
            }
        }
        ticks
    }
}

fn tick(digit: i32, exponent: i32) -> GridLine {
    let label = match exponent {
        0..=3 => (digit * 10_i32.pow(exponent as u32)).to_string(),
        -2..0 => format!("{:.*}", -exponent as usize, f64::from(digit) * 10_f64.powi(exponent)),
        _ => format!("{digit}e{exponent}"),
    };
    GridLine { at: f64::from(digit).log10() + f64::from(exponent), label }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn labels(low: f64, high: f64, most: usize) -> Vec<String> {
        LogAxis { low: low.log10(), high: high.log10() }.ticks(most).into_iter().map(|tick| tick.label).collect()
    }

    #[test]
    fn the_grid_stands_at_decades() {
        assert_eq!(labels(0.02, 1500.0, 9), ["0.1", "1", "10", "100", "1000"]);
        assert_eq!(labels(0.02, 1500.0, 3), ["0.1", "10", "1000"]);
        assert_eq!(labels(3e-6, 4e-2, 9), ["1e-5", "1e-4", "1e-3", "0.01"]);
        assert_eq!(labels(3e-4, 1.5e-3, 9), ["5e-4", "1e-3"]);
        assert_eq!(labels(0.15, 12.0, 9), ["0.2", "0.5", "1", "2", "5", "10"]);
        assert_eq!(labels(2e4, 3e7, 9), ["1e5", "1e6", "1e7"]);
    }

    #[test]
    fn nothing_positive_has_no_axis() {
        assert_eq!(LogAxis::over([0.0, -1.0, f64::NAN, f64::INFINITY]), None);
    }

    proptest! {
        #[test]
        fn an_axis_holds_all_it_was_made_of(values in prop::collection::vec(1e-12_f64..1e12, 1..30)) {
            let axis = LogAxis::over(values.iter().copied()).unwrap();
            prop_assert!(values.iter().all(|value| axis.part(*value).is_some()));
            for tick in axis.ticks(6) {
                prop_assert!((axis.low..=axis.high).contains(&tick.at));
            }
            prop_assert!(axis.ticks(6).len() <= 6);
        }
    }
}
