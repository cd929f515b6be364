//! All sources in a table: one row each, sorted as chosen, and what is to be known of the chosen
//! one below.

use imu_noise::Term;
use ratatui::{
    Frame,
    layout::{Constraint, Layout, Rect},
    style::Style,
    text::{Line, Span},
    widgets::{Block, Borders, Paragraph},
};
use vn100_analysis::{Severity, sensor_of};
use vn100_protocol::Quantity;
use vn100_report::{
    names::names_of,
    numbers::plain::{clock, digits, grouped},
};

use crate::{
    panels::{
        health::{LEAST_NAME, link_word},
        warnings::shortened,
    },
    scene::Scene,
    sorted_by::{lost, worst_white},
    source::{SourcePhase, SourceView},
    state::ViewState,
    units::{convention, shown_unit},
};

/// Columns of the table, from the left.
struct Columns {
    name: usize,
    state: usize,
    has_samples: bool,
    has_accel: bool,
    /// What is left for a warning.
    finding: usize,
}

const SAMPLES: usize = 11;
const LOST: usize = 7;
const NOISE: usize = 9;

impl Columns {
    fn of(width: usize, sources: &[SourceView]) -> Self {
        let longest = sources.iter().map(|source| source.name.chars().count()).max().unwrap_or(0);
        let (has_samples, has_accel) = (width >= 70, width >= 90);
        let state = if width >= 70 { 14 } else { 10 };
        let fixed = 5 + state + LOST + NOISE + SAMPLES * usize::from(has_samples) + NOISE * usize::from(has_accel) + 1;
        let name = longest.clamp(LEAST_NAME, (width.saturating_sub(fixed) * 2 / 3).max(LEAST_NAME));
        Self { name, state, has_samples, has_accel, finding: width.saturating_sub(fixed + name + 1) }
    }
}

pub(crate) fn draw(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let Scene { state, sources, theme, .. } = scene;
    let order = state.sorted_by.order(sources);
    let frozen = if state.frozen { ", FROZEN, still measuring" } else { "" };
    let block = Block::new().borders(Borders::ALL);
    let inner = block.inner(area);
    let details = details(scene, usize::from(inner.width));
    let [head, table, below] =
        Layout::vertical([Constraint::Length(1), Constraint::Fill(1), Constraint::Length(details.len() as u16 + 1)])
            .areas(inner);
    let rows = usize::from(table.height).max(1);
    let chosen = order.iter().position(|place| *place == state.source).unwrap_or(0);
    // the chosen one stays in sight, as far down as it is
    let first = (chosen + 1).saturating_sub(rows).min(sources.len().saturating_sub(rows));
    let last = (first + rows).min(sources.len());
    let more = match (first, sources.len() - last) {
        (0, 0) => String::new(),
        (above, under) => format!(", rows {}-{last}, {above} above, {under} below", first + 1),
    };
    let title = format!(" {} sources by {}{more}{frozen} ", sources.len(), state.sorted_by.name());
    frame.render_widget(block.title(title), area);
    let columns = Columns::of(usize::from(inner.width), sources);
    frame.render_widget(Line::styled(theme.spelled(header(state, &columns)), theme.faint()), head);
    let lines: Vec<Line<'_>> = order[first..last].iter().map(|place| row(scene, *place, &columns)).collect();
    frame.render_widget(Paragraph::new(lines), table);
    frame.render_widget(Paragraph::new(details), Rect { y: below.y + 1, height: below.height - 1, ..below });
}

/// Names of ports differ at their ends.
fn shortened_before(text: &str, width: usize) -> String {
    let excess = text.chars().count().saturating_sub(width);
    if excess == 0 { text.to_owned() } else { ['…'].into_iter().chain(text.chars().skip(excess + 1)).collect() }
}

fn unit_of(state: &ViewState, quantity: Quantity) -> String {
    sensor_of(quantity).map_or_else(String::new, |sensor| shown_unit(convention(sensor, Term::White, state.units)))
}

fn header(state: &ViewState, columns: &Columns) -> String {
    let mut text = format!("  #  {:<name$} {:<state$}", "source", "state", name = columns.name, state = columns.state);
    if columns.has_samples {
        text += &format!("{:>SAMPLES$}", "samples");
    }
    text += &format!("{:>LOST$}{:>NOISE$}", "lost", "gyro N");
    if columns.has_accel {
        text += &format!("{:>NOISE$}", "accel N");
    }
    let units = [Quantity::AngularRate, Quantity::Acceleration].map(|quantity| unit_of(state, quantity));
    let units = if columns.has_accel { units.join(", ") } else { units[0].clone() };
    text + &shortened(&format!("  {units}, noisiest axis"), columns.finding)
}

fn row(scene: Scene<'_>, place: usize, columns: &Columns) -> Line<'static> {
    let Scene { state, theme, .. } = scene;
    let source = &scene.sources[place];
    let (word, style) = link_word(source, theme);
    let noise = |quantity| {
        let unit = sensor_of(quantity).map(|sensor| convention(sensor, Term::White, state.units));
        let value = worst_white(source, quantity).zip(unit).map(|(value, unit)| digits(value * unit.factor, 2));
        format!("{:>NOISE$}", value.unwrap_or_else(|| "-".into()))
    };
    let chosen = if place == state.source { theme.chosen() } else { Style::new() };
    let name = shortened_before(&source.name, columns.name);
    // its baud rate stands among the details
    let word =
        word.split(|sign: char| sign.is_ascii_digit()).next().unwrap_or_default().trim_end().trim_end_matches(" at");
    let lost = lost(source);
    let mut spans = vec![
        Span::styled(format!(" {:>2}  {name:<width$} ", place + 1, width = columns.name), chosen),
        Span::styled(format!("{:<width$}", shortened(word, columns.state - 1), width = columns.state), style),
    ];
    if columns.has_samples {
        spans.push(Span::raw(format!("{:>SAMPLES$}", grouped(source.snapshot.timing.samples))));
    }
    let warned = if lost > 0 { theme.warning() } else { Style::new() };
    spans.push(Span::styled(format!("{:>LOST$}", grouped(lost)), warned));
    spans.push(Span::raw(noise(Quantity::AngularRate)));
    if columns.has_accel {
        spans.push(Span::raw(noise(Quantity::Acceleration)));
    }
    if let Some((text, style)) = finding(scene, source) {
        spans.push(Span::styled(format!("  {}", shortened(&text, columns.finding.saturating_sub(2))), style));
    }
    Line::from(spans)
}

/// The worst of what is wrong with a source.
fn finding(scene: Scene<'_>, source: &SourceView) -> Option<(String, Style)> {
    let theme = scene.theme;
    if let SourcePhase::Ended(Some(reason)) = &source.phase {
        return Some((format!("!! {reason}"), theme.error()));
    }
    if let Some(fault) = source.faults.all().first() {
        return Some((format!("!! {}", fault.title(source.now)), theme.error()));
    }
    let warning = source.warnings.first().filter(|warning| warning.severity != Severity::Note)?;
    let style = if warning.severity == Severity::Problem { theme.error() } else { theme.warning() };
    Some((theme.spelled(format!("! {}", warning.title())), style))
}

/// The chosen source in some lines.
fn details(scene: Scene<'_>, width: usize) -> Vec<Line<'static>> {
    let (source, theme) = (scene.source, scene.theme);
    let timing = &source.snapshot.timing;
    let measured = source.snapshot.arrivals.and_then(|arrivals| arrivals.measured_hz);
    let measured = measured.map_or(String::new(), |hz| format!(", {hz:.3} Hz measured"));
    let head = format!(
        " {} {} {}: {} samples in {}{measured}",
        scene.state.source + 1,
        source.name,
        link_word(source, theme).0,
        grouped(timing.samples),
        clock(std::time::Duration::try_from_secs_f64(timing.duration_s()).unwrap_or_default()),
    );
    let axes = |quantity: Quantity| {
        let unit = sensor_of(quantity).map(|sensor| convention(sensor, Term::White, scene.state.units))?;
        let axes = source.values.iter().filter(|channel| channel.quantity == quantity);
        let white = axes.filter_map(|channel| channel.noise.as_ref()?.parameter(Term::White));
        let values: Vec<String> =
            white.map(|white| white.value.map_or("-".into(), |value| digits(value * unit.factor, 2))).collect();
        let text = || format!("{} N {} {}", names_of(quantity).short, values.join(" "), shown_unit(unit));
        (!values.is_empty()).then(|| theme.spelled(text()))
    };
    let noise: Vec<String> = [Quantity::AngularRate, Quantity::Acceleration].into_iter().filter_map(axes).collect();
    let goals = if source.goals.is_none() {
        Vec::new()
    } else {
        source.goals.texts(&source.snapshot, &source.assessment, source.now)
    };
    let (text, style) = finding(scene, source).unwrap_or_default();
    let whole: Vec<String> = textwrap::wrap(&format!(" {text}"), width.max(1)).into_iter().map(Into::into).collect();
    let lines = [head, format!(" {}", noise.join("   "))]
        .into_iter()
        .chain(goals.into_iter().map(|goal| format!(" goal: {goal}")));
    let lines = lines.map(|text| Line::raw(shortened(&theme.spelled(text), width)));
    lines.chain(whole.into_iter().take(2).map(|text| Line::styled(text, style))).collect()
}
