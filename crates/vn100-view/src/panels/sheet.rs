//! Lines of models in the plot, and that of the data sheet.

use imu_noise::{Term, Verdict};

use crate::source::{ChannelGroup, SourceView};

/// A line of a model in the plot.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ModelLine {
    /// Its letter; `None` for the whole.
    pub(crate) term: Option<&'static str>,
    /// Averaging time in seconds and deviation.
    pub(crate) points: Vec<(f64, f64)>,
}

/// The letter of the sheet in the plot.
pub(crate) const SHEET: &str = "S";

/// The deviation of a sensor at its data sheet in this stream, over these averaging times: that of
/// the white noise, and the floor of the bias instability where it is higher.
pub(crate) fn line(source: &SourceView, group: &ChannelGroup, taus: &[f64], factor: f64) -> Option<ModelLine> {
    let shape = source.result.shape();
    let figure = |term| {
        let channels = group.channels.iter().filter_map(|place| source.result.channels.get(*place));
        let mut judged = channels.flat_map(|channel| channel.verdicts());
        judged.find(|judged| judged.figure.term == term && judged.verdict != Some(Verdict::NotComparable))
    };
    let white = figure(Term::White).map(|figure| (figure.expected.0 * figure.expected.1).sqrt())?;
    let bias = figure(Term::BiasInstability).map(|figure| (figure.expected.1, figure.figure.is_minimum));
    let at =
        |tau_s: &f64| {
            let m = (tau_s / shape.interval_s).round().max(1.0) as u64;
            let floor = bias.map_or(0.0, |(bias, is_minimum)| {
                if is_minimum { bias } else { Term::BiasInstability.variance(bias, m, &shape).sqrt() }
            });
            (*tau_s, Term::White.variance(white, m, &shape).sqrt().max(floor) * factor)
        };
    Some(ModelLine { term: Some(SHEET), points: taus.iter().map(at).collect() })
}
