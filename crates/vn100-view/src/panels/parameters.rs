//! The noise parameters of a sensor as the summary has them: axes side by side, the data sheet and
//! the verdict below them.

use ratatui::{
    Frame,
    layout::Rect,
    style::Style,
    text::{Line, Span},
    widgets::Paragraph,
};
use vn100_analysis::Severity;
use vn100_protocol::Quantity;
use vn100_report::{
    names::names_of,
    remedies::remedy_words,
    summary::{ParameterRow, Summary, VerdictWord},
};

use crate::{
    scene::{Scene, framed},
    source::{ChannelGroup, SourceView},
    state::Panel,
    theme::{SIGNS, Theme},
};

/// Columns of a label with its unit, and of the value of an axis.
const LABEL: usize = 19;
const COLUMN: usize = 13;

/// Columns of the label and of three axes, with the frame.
pub(crate) const WIDTH: u16 = (LABEL + 3 * COLUMN) as u16 + 2;

pub(crate) fn draw(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let source = scene.source;
    let Some(group) = scene.state.group(source) else { return };
    let level = 100.0 * source.result.confidence;
    let title = format!("Noise of the {}, {level:.0} % intervals", names_of(group.quantity).short);
    let inner = framed(frame, area, scene, Panel::Parameters, title);
    let lines = lines(scene, &group, usize::from(inner.width));
    let (mut lines, hidden) = most_needed(lines, usize::from(inner.height));
    if hidden > 0 {
        let shared = area.width < frame.area().width;
        let where_else = if shared { "tab to Noise, then e" } else { "on a larger screen" };
        lines.push(Line::styled(format!(" {hidden} more lines: {where_else}"), scene.theme.warning()));
    }
    frame.render_widget(Paragraph::new(lines), inner);
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

/// The summary with the tables of a sensor alone; none for what has no noise parameters.
fn summary_of(source: &SourceView, quantity: Quantity) -> Summary {
    let mut summary = Summary::new(&source.result, remedy_words);
    summary.sensors.retain(|table| table.title == names_of(quantity).title);
    summary
}

/// N of all axes with its unit, for a screen that has no room for the panel.
pub(crate) fn summary(scene: Scene<'_>, group: &ChannelGroup) -> Option<Line<'static>> {
    let theme = scene.theme;
    let summary = summary_of(scene.source, group.quantity);
    let row = summary.sensors.first()?.rows.first()?;
    let mut spans = vec![Span::styled(" N", Style::new().bold())];
    spans.extend(row.cells.iter().enumerate().map(|(axis, cell)| {
        let sign = if row.cells.len() > 1 { SIGNS.get(axis).unwrap_or(&"●") } else { &"" };
        Span::styled(format!("  {sign} {}", theme.spelled(cell.as_str())), theme.axis(axis))
    }));
    spans.push(Span::raw(theme.spelled(format!("  {}", row.unit))));
    Some(Line::from(spans))
}

fn lines(scene: Scene<'_>, group: &ChannelGroup, width: usize) -> Vec<(Need, Line<'static>)> {
    let Scene { source, theme, .. } = scene;
    let summary = summary_of(source, group.quantity);
    let text = |need, text: &str, style| {
        let options = textwrap::Options::new(width.max(1)).initial_indent(" ").subsequent_indent("   ");
        let spelled = theme.spelled(text);
        let parts = textwrap::wrap(&spelled, options).into_iter();
        parts.map(|part| (need, Line::styled(part.into_owned(), style))).collect::<Vec<_>>()
    };
    if summary.sensors.is_empty() {
        let why = match &source.result.motion {
            Some(_) => "The sensor was moved: what its deviation shows is the motion, not its noise.",
            None => {
                "No noise model is fitted to what belongs to no axis of a sensor: see its deviation and statistics."
            }
        };
        return text(Need::Value, why, Style::new());
    }
    let affected = affected_by(source, group);
    let mut lines = if affected.is_empty() { Vec::new() } else { text(Need::Judgement, &affected, theme.warning()) };
    for table in &summary.sensors {
        let mut spans = vec![Span::raw(" ".repeat(LABEL))];
        spans.extend(table.axes.iter().enumerate().map(|(axis, name)| cell(scene, axis, name)));
        lines.push((Need::Value, Line::from(spans)));
        let mut unit = "";
        for row in &table.rows {
            let need = if row.is_detail { Need::Detail } else { Need::Value };
            unit = if row.unit.is_empty() { unit } else { row.unit };
            if !row.cells.is_empty() {
                lines.push((need, values(scene, row, table.axes.len())));
            }
            if let Some((figure, VerdictWord { word, is_failed })) = &row.figure {
                let judged = format!("   data sheet: {figure} {unit}: {word}");
                lines.extend(text(Need::Judgement, &judged, judgement(theme, word, *is_failed)));
            }
        }
        for note in table.notes.iter().filter_map(|place| summary.notes.get(*place)) {
            lines.extend(text(Need::Detail, note, theme.faint()));
        }
    }
    if matches!(group.quantity, Quantity::AngularRate | Quantity::Acceleration) {
        let drift = summary.drift.iter().map(|line| format!("drift: {line}"));
        let of_sensor = drift.skip(usize::from(group.quantity == Quantity::Acceleration)).take(1);
        lines.extend(of_sensor.flat_map(|line| text(Need::Detail, &line, theme.faint())));
    }
    lines
}

/// Green for what meets a limit, red for what does not; the word says the same.
fn judgement(theme: Theme, word: &str, is_failed: bool) -> Style {
    match word.starts_with("pass") {
        _ if is_failed => theme.error(),
        true => theme.good(),
        false => Style::new(),
    }
}

fn values(scene: Scene<'_>, row: &ParameterRow, axes: usize) -> Line<'static> {
    let theme = scene.theme;
    let label = theme.spelled(format!(" {} {}", row.short_label, row.unit));
    let style = if row.is_detail { theme.faint() } else { Style::new().bold() };
    let mut spans = vec![Span::styled(format!("{label:<LABEL$}"), style)];
    match &row.cells[..] {
        // one text for all axes
        [only] if axes > 1 => spans.push(Span::raw(format!(" {only}"))),
        cells => {
            spans.extend(cells.iter().enumerate().map(|(axis, text)| cell(scene, axis, &theme.spelled(text.as_str()))))
        }
    }
    Line::from(spans)
}

fn cell(scene: Scene<'_>, axis: usize, text: &str) -> Span<'static> {
    let style = scene.theme.axis(axis);
    let style = if scene.state.axis == Some(axis) { style.patch(Style::new().bold()) } else { style };
    Span::styled(format!("{text:>COLUMN$}"), style)
}

/// The warnings that concern these axes, or all; in full they stand in a panel of their own.
fn affected_by(source: &SourceView, group: &ChannelGroup) -> String {
    let names: Vec<&str> = group.channels.iter().map(|place| source.result.channels[*place].name.as_str()).collect();
    let concerns = |of: &[String]| of.is_empty() || of.iter().any(|name| names.contains(&name.as_str()));
    let mut kinds: Vec<&str> = (source.warnings.iter())
        .filter(|warning| concerns(&warning.channels) && warning.severity != Severity::Note)
        .map(|warning| warning.kind.name())
        .collect();
    kinds.dedup();
    if kinds.is_empty() { String::new() } else { format!("! affected by: {}", kinds.join(", ")) }
}
