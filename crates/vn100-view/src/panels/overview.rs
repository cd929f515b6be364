//! All sources in a list, one row each.

use imu_noise::{Sensor, Term};
use ratatui::{
    Frame,
    layout::{Constraint, Layout, Rect},
    style::Style,
    text::{Line, Span},
    widgets::{Block, Borders, Paragraph},
};
use vn100_analysis::{Severity, SourceResult, sensor_of};
use vn100_protocol::Quantity;
use vn100_report::{
    numbers::plain::{digits, grouped},
    shortened,
    units::parameter_unit,
};

use crate::{
    panels::health::{LEAST_NAME, state_word},
    scene::Scene,
    source::{SourcePhase, SourceView},
};

/// Columns of the list, from the left.
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
    let block = Block::new().borders(Borders::ALL);
    let inner = block.inner(area);
    let [head, list] = Layout::vertical([Constraint::Length(1), Constraint::Fill(1)]).areas(inner);
    let rows = usize::from(list.height).max(1);
    // the chosen one stays in sight, as far down as it is
    let first = (state.source + 1).saturating_sub(rows).min(sources.len().saturating_sub(rows));
    let last = (first + rows).min(sources.len());
    let more = match (first, sources.len() - last) {
        (0, 0) => String::new(),
        (above, under) => format!(", rows {}-{last}, {above} above, {under} below", first + 1),
    };
    let title = format!(" {} sources{more} ", sources.len());
    frame.render_widget(block.title(title), area);
    let columns = Columns::of(usize::from(inner.width), sources);
    frame.render_widget(Line::styled(theme.spelled(header(&columns)), theme.faint()), head);
    let lines: Vec<Line<'_>> = (first..last).map(|place| row(scene, place, &columns)).collect();
    frame.render_widget(Paragraph::new(lines), list);
}

/// Names of ports differ at their ends.
fn shortened_before(text: &str, width: usize) -> String {
    let excess = text.chars().count().saturating_sub(width);
    if excess == 0 { text.to_owned() } else { ['…'].into_iter().chain(text.chars().skip(excess + 1)).collect() }
}

fn header(columns: &Columns) -> String {
    let mut text = format!("  #  {:<name$} {:<state$}", "source", "state", name = columns.name, state = columns.state);
    if columns.has_samples {
        text += &format!("{:>SAMPLES$}", "samples");
    }
    text += &format!("{:>LOST$}{:>NOISE$}", "lost", "gyro N");
    if columns.has_accel {
        text += &format!("{:>NOISE$}", "accel N");
    }
    let units = [Sensor::Gyroscope, Sensor::Accelerometer].map(|sensor| parameter_unit(sensor, Term::White).0);
    let units = if columns.has_accel { units.join(", ") } else { units[0].to_owned() };
    text + &shortened(&format!("  {units}, noisiest axis"), columns.finding)
}

fn row(scene: Scene<'_>, place: usize, columns: &Columns) -> Line<'static> {
    let Scene { state, theme, .. } = scene;
    let source = &scene.sources[place];
    let (word, style) = state_word(source, theme);
    let noise = |quantity| {
        let unit = sensor_of(quantity).map(|sensor| parameter_unit(sensor, Term::White));
        let value = worst_white(source, quantity).zip(unit).map(|(value, (_, factor))| digits(value * factor, 2));
        format!("{:>NOISE$}", value.unwrap_or_else(|| "-".into()))
    };
    let chosen = if place == state.source { theme.chosen() } else { Style::new() };
    let name = shortened_before(&source.name, columns.name);
    // its baud rate stands in its head
    let word =
        word.split(|sign: char| sign.is_ascii_digit()).next().unwrap_or_default().trim_end().trim_end_matches(" at");
    let lost = lost(source);
    let mut spans = vec![
        Span::styled(format!(" {:>2}  {name:<width$} ", place + 1, width = columns.name), chosen),
        Span::styled(format!("{:<width$}", shortened(word, columns.state - 1), width = columns.state), style),
    ];
    if columns.has_samples {
        spans.push(Span::raw(format!("{:>SAMPLES$}", grouped(source.result.timing.samples))));
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
    Some((theme.spelled(format!("! {}", vn100_report::warnings::title(warning))), style))
}

fn lost(source: &SourceView) -> u64 {
    let SourceResult { timing, link, .. } = &source.result;
    link.rejected.total() + link.damaged_packets + timing.missing_at_least
}

/// N of the noisiest axis, in SI units.
fn worst_white(source: &SourceView, quantity: Quantity) -> Option<f64> {
    let axes = source.result.channels.iter().filter(|channel| channel.quantity == quantity);
    axes.filter_map(|channel| channel.noise.as_ref()?.parameter(Term::White)?.value).reduce(f64::max)
}
