//! The noise parameters of a sensor: value and interval by axis, or why there is none yet.

use imu_noise::{Parameter, Status, Term};
use ratatui::{
    Frame,
    layout::Rect,
    style::Style,
    text::{Line, Span},
    widgets::{Paragraph, Wrap},
};
use vn100_analysis::{ChannelResult, DetectableRrw, LongTauValidity, Onboard, Severity, letter, sensor_of};
use vn100_protocol::Quantity;
use vn100_report::{
    names::{TERMS, names_of, parameter_names, short_verdict},
    numbers::plain::{digits, spread, tau, time, widest_spread},
};

use crate::{
    panels::sheet,
    scene::{Scene, framed},
    source::{ChannelGroup, SourceView},
    state::{Panel, ShownAxes},
    theme::SIGNS,
    units::{convention, shown_unit},
};

const COLUMN: usize = 15;

/// Columns of a label, and of one that has its values beside it.
const LABEL: usize = 9;
const LONG_LABEL: usize = 33;

/// Columns of the label and of three axes, with the frame.
pub(crate) const WIDTH: u16 = (LABEL + 3 * COLUMN) as u16 + 2;

pub(crate) fn draw(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let source = scene.source;
    let Some(group) = scene.state.group(source) else { return };
    let level = 100.0 * source.result.confidence;
    let title = format!("Noise of the {}, {level:.0} % intervals", names_of(group.quantity).short);
    let inner = framed(frame, area, scene, Panel::Parameters, title);
    let beside = usize::from(inner.width) >= LONG_LABEL + 3 * COLUMN;
    let lines = lines(scene, &group, if beside { LONG_LABEL } else { LABEL }, usize::from(inner.width));
    let (mut lines, hidden) = most_needed(lines, usize::from(inner.height));
    if hidden > 0 {
        let shared = area.width < frame.area().width;
        let where_else = if shared { "tab to Noise, then e" } else { "on a larger screen" };
        lines.push(Line::styled(format!(" {hidden} more lines: {where_else}"), scene.theme.warning()));
    }
    frame.render_widget(Paragraph::new(lines).wrap(Wrap { trim: false }), inner);
}

/// What a line of the panel is worth if there is no room for all, the most needed first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Need {
    /// The values of N, B and K.
    Value,
    /// What limits or judges them.
    Judgement,
    /// What explains them.
    Detail,
}

/// The lines that have room, in their order: the least needed go first, of those the last. With the
/// number of those that have none, for which a row is kept.
fn most_needed(lines: Vec<(Need, Line<'static>)>, height: usize) -> (Vec<Line<'static>>, usize) {
    if lines.len() <= height {
        return (lines.into_iter().map(|(_, line)| line).collect(), 0);
    }
    let mut places: Vec<usize> = (0..lines.len()).collect();
    places.sort_by_key(|place| lines[*place].0);
    places.truncate(height.saturating_sub(1));
    let hidden = lines.len() - places.len();
    let kept = lines.into_iter().enumerate().filter(|(place, _)| places.contains(place));
    (kept.map(|(_, (_, line))| line).collect(), hidden)
}

/// N of all axes with its unit, for a screen that has no room for the panel: in one line where
/// that has room, else with the unit above the values, or with a line for each axis.
pub(crate) fn summary(scene: Scene<'_>, group: &ChannelGroup, width: u16) -> Vec<Line<'static>> {
    let Some(sensor) = sensor_of(group.quantity) else { return Vec::new() };
    let theme = scene.theme;
    let unit = convention(sensor, Term::White, scene.state.units);
    let name = Span::styled(" N", Style::new().bold());
    let unit_name = Span::raw(theme.spelled(format!("  {}", shown_unit(unit))));
    let values = |interval: fn(f64, f64, f64) -> String| -> Vec<Span<'static>> {
        let value = |(axis, place): (usize, &usize)| {
            let white =
                scene.source.result.channels[*place].noise.as_ref().and_then(|noise| noise.parameter(Term::White));
            let text = white.map_or("-".to_owned(), |white| match (white.value, white.lower, white.upper) {
                (Some(value), Some(lower), Some(upper)) => {
                    theme.spelled(format!("{} {}", digits(value * unit.factor, 3), interval(value, lower, upper)))
                }
                _ => status(scene.source, white.status).into(),
            });
            let sign = SIGNS.get(axis).unwrap_or(&"●");
            Span::styled(format!("  {sign} {text}"), theme.axis(axis))
        };
        group.channels.iter().enumerate().map(value).collect()
    };
    let together = |values: Vec<Span<'static>>| {
        vec![Line::from_iter([name.clone()].into_iter().chain(values).chain([unit_name.clone()]))]
    };
    let below =
        |values: Vec<Span<'static>>| vec![Line::from_iter([name.clone(), unit_name.clone()]), Line::from_iter(values)];
    let apart = || {
        let head = Line::from_iter([name.clone(), unit_name.clone()]);
        [head].into_iter().chain(values(spread).into_iter().map(Line::from)).collect()
    };
    let forms = [
        together(values(spread)),
        together(values(widest_spread)),
        below(values(spread)),
        below(values(widest_spread)),
    ];
    let has_room = |lines: &Vec<Line<'_>>| lines.iter().all(|line| line.width() <= usize::from(width));
    forms.into_iter().find(has_room).unwrap_or_else(apart)
}

fn lines(scene: Scene<'_>, group: &ChannelGroup, label_columns: usize, width: usize) -> Vec<(Need, Line<'static>)> {
    let Scene { source, theme, .. } = scene;
    let axes: Vec<&ChannelResult> = group.channels.iter().map(|place| &source.result.channels[*place]).collect();
    let Some(sensor) = sensor_of(group.quantity) else {
        return without_parameters(group.quantity).map(|text| (Need::Value, Line::raw(text))).into();
    };
    let column_style = |axis: usize| match scene.state.axes {
        ShownAxes::One(chosen) if chosen == axis => theme.axis(axis).patch(Style::new().bold()),
        _ => theme.axis(axis),
    };
    let with_cells = |mut spans: Vec<Span<'static>>, cells: Vec<String>| {
        let cells = cells.into_iter().enumerate();
        spans.extend(cells.map(|(axis, cell)| Span::styled(format!("{cell:>COLUMN$}"), column_style(axis))));
        Line::from(spans)
    };
    let row = |label: &str, cells: Vec<String>| {
        with_cells(vec![Span::raw(format!(" {label:<width$}", width = label_columns - 1))], cells)
    };
    let doubts = doubts(source, &axes).into_iter();
    let doubts = doubts.flat_map(|text| wrapped(&theme.spelled(text), width, theme.warning()));
    let mut lines: Vec<(Need, Line<'static>)> = doubts.map(|line| (Need::Judgement, line)).collect();
    lines.push((Need::Value, row("", axes.iter().map(|axis| axis.name.clone()).collect())));
    for term in TERMS.into_iter().filter(|term| *term != Term::RateRamp) {
        let (letter, name) = (letter(term), parameter_names(sensor, term).name);
        let parameters: Vec<Option<Parameter>> =
            axes.iter().map(|axis| axis.noise.as_ref().and_then(|noise| noise.parameter(term))).collect();
        if parameters.iter().all(Option::is_none) {
            continue;
        }
        let need = if term == Term::Quantization { Need::Judgement } else { Need::Value };
        if parameters.iter().flatten().all(|parameter| parameter.status == Status::NotMeasurable) {
            let spans = [
                Span::styled(format!(" {letter}"), Style::new().bold()),
                Span::raw(format!(" {name}: not measurable in this message")),
            ];
            lines.push((need, Line::from_iter(spans)));
            continue;
        }
        let unit = convention(sensor, term, scene.state.units);
        let value = |parameter: &Option<Parameter>| {
            parameter.map_or("-".into(), |parameter| match (parameter.value, parameter.upper) {
                (Some(value), _) => digits(value * unit.factor, 3),
                (None, Some(upper)) => theme.spelled(format!("≤ {}", digits(upper * unit.factor, 3))),
                (None, None) => status(source, parameter.status).into(),
            })
        };
        let interval = |parameter: &Option<Parameter>| {
            parameter
                .and_then(|parameter| Some(theme.spelled(spread(parameter.value?, parameter.lower?, parameter.upper?))))
                .unwrap_or_default()
        };
        let term_name = theme.spelled(format!(" {name}, {}", shown_unit(unit)));
        let beside = term_name.chars().count() + 2 <= label_columns;
        let mut titled = vec![
            Span::styled(format!(" {letter}"), Style::new().bold()),
            Span::raw(format!("{term_name:<width$}", width = label_columns - 2)),
        ];
        if !beside {
            lines.push((need, Line::from(titled)));
            titled = vec![Span::raw(" ".repeat(label_columns))];
        }
        let (values, intervals) = (parameters.iter().map(value), parameters.iter().map(interval));
        let together: Vec<String> = values.clone().zip(intervals.clone()).map(|(v, i)| format!("{v} {i}")).collect();
        if together.iter().all(|cell| cell.trim_end().chars().count() < COLUMN) {
            lines.push((need, with_cells(titled, together.iter().map(|cell| cell.trim_end().to_owned()).collect())));
        } else {
            lines.push((need, with_cells(titled, values.collect())));
            if intervals.clone().any(|interval| !interval.is_empty()) {
                lines.push((need, row("", intervals.collect())));
            }
        }
        if term == Term::White {
            let own = |place: &usize| own_white(source, *place).map(|(value, _)| digits(value * unit.factor, 2));
            let own: Vec<Option<String>> = group.channels.iter().map(own).collect();
            if own.iter().any(Option::is_some) {
                let own = own.into_iter().map(Option::unwrap_or_default).collect();
                lines.push((Need::Detail, row("sensor", own)));
                let factor = group.channels.iter().find_map(|place| own_white(source, *place)).map_or(1.0, |(_, f)| f);
                let within = 100.0 * Onboard::UNCERTAINTY;
                let text = format!(" sensor: its own N, this N ÷ {factor:.2} (±{within:.0} %)");
                lines.push((Need::Detail, Line::styled(theme.spelled(text), theme.faint())));
            }
        }
        if let Some(judged) = sheet::verdicts(source, group, term) {
            let mut spans = vec![Span::raw(format!(" {:<width$}", "verdict", width = label_columns - 1))];
            spans.extend(judged.iter().map(|figure| {
                let (word, style) = figure.map_or(("-".into(), Style::new()), |figure| {
                    (short_verdict(figure), sheet::verdict_style(theme, figure.verdict))
                });
                Span::styled(format!("{word:>COLUMN$}"), style)
            }));
            lines.push((Need::Judgement, Line::from(spans)));
            let texts = sheet::explanation(&judged, unit).into_iter().map(|text| theme.spelled(text));
            let texts = texts.flat_map(|text| wrapped(&text, width, theme.faint()));
            lines.extend(texts.map(|line| (Need::Detail, line)));
        }
        if term == Term::RateRandomWalk {
            let text = seen_later(&axes, unit.factor).map(|text| theme.spelled(format!(" {text}")));
            lines.extend(text.map(|text| (Need::Detail, Line::styled(text, theme.faint()))));
        }
    }
    let quality = |of: fn(&imu_noise::FitQuality) -> String| {
        let cell = |axis: &&ChannelResult| {
            let quality = axis.noise.as_ref().and_then(|noise| noise.fit);
            quality.map_or("-".into(), |quality| of(&quality))
        };
        axes.iter().map(cell).collect::<Vec<_>>()
    };
    let taus = quality(|quality| format!("{} - {}", tau(quality.tau_min_s), tau(quality.tau_max_s)));
    lines.push((Need::Detail, row(&theme.spelled("τ (s)"), taus)));
    let fit = quality(|quality| format!("{} p {}", fit_word(quality.p), digits(quality.p, 2)));
    lines.push((Need::Judgement, row("fit", fit)));
    lines
}

/// By the probability that the model leaves as much as it does.
fn fit_word(p: f64) -> &'static str {
    match p {
        0.05.. => "good",
        0.01.. => "doubtful",
        _ => "rejected",
    }
}

fn wrapped(text: &str, width: usize, style: Style) -> Vec<Line<'static>> {
    let options = textwrap::Options::new(width.max(1)).subsequent_indent("   ");
    textwrap::wrap(text, options).into_iter().map(|line| Line::styled(line.into_owned(), style)).collect()
}

fn without_parameters(quantity: Quantity) -> [&'static str; 3] {
    match quantity {
        Quantity::Temperature => [
            " No noise parameters: temperature follows the room",
            " and the sensor's own heating, so no noise model",
            " is fitted. See its deviation and statistics.",
        ],
        Quantity::Pressure => [
            " No noise parameters: pressure follows the weather,",
            " so no noise model is fitted. See its",
            " deviation and statistics.",
        ],
        _ => [
            " No noise parameters: they belong to a sensor's",
            " axes, and the attitude is computed from several.",
            " See its deviation and statistics.",
        ],
    }
}

/// N of the sensor itself in SI units, and its factor in the stream; `None` for 1 or unknown.
fn own_white(source: &SourceView, place: usize) -> Option<(f64, f64)> {
    let factor = source.result.channels.get(place)?.onboard?.window.white_factor();
    let white = source.result.channels[place].noise.as_ref()?.parameter(Term::White)?.value?;
    (factor > 1.0 + Onboard::UNCERTAINTY).then(|| (white / factor, factor))
}

fn seen_later(axes: &[&ChannelResult], factor: f64) -> Option<String> {
    let later = axes.iter().filter_map(|axis| axis.noise.as_ref()?.rate_random_walk_seen_later);
    let least = later.map(|later| later.at_least).reduce(f64::max)?;
    Some(format!("K ≥ {} detectable with {} more", digits(least * factor, 2), time(DetectableRrw::MORE_S)))
}

/// Why the numbers are not, or not quite, those of the sensor.
fn doubts(source: &SourceView, axes: &[&ChannelResult]) -> Vec<String> {
    let mut doubts = Vec::new();
    if source.result.motion.is_some() {
        doubts.push("! the sensor was moved: this is its motion, not its noise".to_owned());
    }
    let long_taus = axes.first().and_then(|axis| axis.noise.as_ref()).map(|noise| noise.long_taus);
    match long_taus {
        Some(LongTauValidity::Compensated) => {
            doubts.push("! bias-compensated message: B and K not measurable; use VNIMU".to_owned());
        }
        Some(LongTauValidity::LooksCompensated) => {
            doubts.push("! a filter removes the bias: B and K not measurable".to_owned());
        }
        Some(LongTauValidity::Surroundings) => {
            doubts.push("! at long τ the ambient field dominates: only N is the sensor's".to_owned());
        }
        Some(LongTauValidity::Sensor | LongTauValidity::Motion) | None => {}
    }
    // what concerns these axes, or all; in full among the warnings
    let concerns = |names: &[String]| names.is_empty() || axes.iter().any(|axis| names.contains(&axis.name));
    let mut kinds: Vec<&str> = (source.warnings.iter())
        .filter(|warning| concerns(&warning.channels) && warning.severity != Severity::Note)
        .map(|warning| warning.kind.name())
        .collect();
    kinds.dedup();
    if !kinds.is_empty() {
        doubts.push(format!("! affected by: {}", kinds.join(", ")));
    }
    doubts
}

/// While a measurement is shorter than this, what cannot be observed may appear with the next octave.
const EARLY_S: f64 = 60.0;

fn status(source: &SourceView, status: Status) -> &'static str {
    match status {
        Status::Estimated | Status::Bounded => "-",
        Status::NotObservable if !source.is_over() && source.result.timing.duration_s < EARLY_S => "not yet",
        Status::NotObservable => "not observable",
        Status::NotMeasurable => "not measurable",
        Status::Moved => "sensor moved",
        Status::ModelRejected => "model rejected",
    }
}
