//! The data sheet beside what was measured: verdicts, what aliasing does to both, and the line of
//! the sheet in the plot.

use imu_noise::{Claim, Convention, Term, Verdict};
use ratatui::style::Style;
use vn100_analysis::{DatasheetFigure, FigureVerdict};
use vn100_report::{
    names::decided_by,
    numbers::plain::{digits, digits_trimmed},
};

use crate::{
    panels::model_line::ModelLine,
    source::{ChannelGroup, SourceView},
    theme::Theme,
    units::shown_unit,
};

/// The verdicts on a parameter, one for each axis; none if the sheet has no such figure.
pub(crate) fn verdicts<'a>(
    source: &'a SourceView,
    group: &ChannelGroup,
    term: Term,
) -> Option<Vec<Option<&'a FigureVerdict>>> {
    let channels = &source.result.channels;
    let of = |place: &usize| channels.get(*place)?.verdicts().iter().find(|figure| figure.figure.term == term);
    let judged: Vec<_> = group.channels.iter().map(of).collect();
    judged.iter().any(Option::is_some).then_some(judged)
}

/// Green for what meets a limit, red for what does not; the word says the same.
pub(crate) fn verdict_style(theme: Theme, verdict: Option<Verdict>) -> Style {
    match verdict {
        Some(Verdict::Pass) => theme.good(),
        Some(Verdict::Fail) => theme.error(),
        Some(Verdict::Undecided | Verdict::NotComparable) | None => Style::new(),
    }
}

/// What the sheet says, what that is in this stream, and what would decide an open verdict.
pub(crate) fn explanation(judged: &[Option<&FigureVerdict>], unit: Convention) -> Vec<String> {
    let Some(first) = judged.iter().flatten().next() else { return Vec::new() };
    let mut texts = vec![format!(" data sheet: {} {}", claimed(&first.figure, unit), shown_unit(unit))];
    if first.expected != first.figure.claim.ends() && first.verdict != Some(Verdict::NotComparable) {
        let (low, high) = first.expected;
        let [low, high] = [low, high].map(|end| digits(end * unit.factor, 2));
        texts.push(format!(" in this stream {low} to {high}"));
    }
    let open = judged.iter().flatten().find(|figure| figure.decided_by.is_some());
    texts.extend(open.map(|open| format!(" undecided: {} would decide", decided_by(open))));
    texts
}

fn claimed(figure: &DatasheetFigure, unit: Convention) -> String {
    let number = |value: f64| digits_trimmed(value * unit.factor, 3);
    match figure.claim {
        Claim::Limit(limit) => format!("max {}", number(limit)),
        Claim::Typical { from, to, .. } if from == to => format!("typ {}", number(from)),
        Claim::Typical { from, to, .. } => format!("typ {} to {}", number(from), number(to)),
    }
}

/// The letter of the sheet in the plot.
pub(crate) const SHEET: &str = "S";

/// The deviation of a sensor at its data sheet in this stream, over these averaging times: that of
/// the white noise, and the floor of the bias instability where it is higher.
pub(crate) fn line(source: &SourceView, group: &ChannelGroup, taus: &[f64], factor: f64) -> Option<ModelLine> {
    let shape = source.result.shape();
    let figure = |term| {
        let judged = verdicts(source, group, term)?;
        judged.into_iter().flatten().find(|figure| figure.verdict != Some(Verdict::NotComparable))
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
