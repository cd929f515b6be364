//! What may spoil the result: a line each on top, and each in full in a panel of their own.

use ratatui::{
    Frame,
    layout::{Constraint, Layout, Rect},
    text::{Line, Span},
    widgets::{Paragraph, Wrap},
};

use super::{
    draw::{Scene, framed},
    source::Source,
    state::Panel,
};

/// One line for each of the gravest; of more than fit, how many more there are.
pub(crate) fn draw_lines(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, source: &Source) {
    let theme = scene.theme;
    let mut texts = Vec::new();
    texts.extend(source.troubles().into_iter().map(|text| (format!("! {text}"), theme.bad())));
    texts.extend(source.warnings.iter().map(|warning| (format!("! {warning}"), theme.warning())));
    let rows = usize::from(area.height);
    let hidden = texts.len().saturating_sub(rows);
    let width = usize::from(area.width);
    let count = texts.len().min(rows);
    let lines: Vec<_> = (texts.into_iter().take(rows).enumerate())
        .map(|(row, (text, style))| {
            let more = match (row + 1 == count, hidden) {
                (true, 1..) => format!(" +{hidden}, press !"),
                _ if text.chars().count() >= width => " press !".into(),
                _ => String::new(),
            };
            Line::from(vec![
                Span::styled(shortened(&text, width.saturating_sub(more.len() + 1)), style),
                Span::styled(more, style),
            ])
        })
        .collect();
    if lines.is_empty() {
        let samples = source.snapshot.timing.samples > 0;
        let text = if samples { " no warnings" } else { " no warnings yet" };
        frame.render_widget(Paragraph::new(text).style(theme.faint()), area);
    } else {
        frame.render_widget(Paragraph::new(lines), area);
    }
}

/// All of them by name, and the one chosen in full.
pub(crate) fn draw_panel(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, source: &Source) {
    let warnings = &source.warnings;
    let block = framed(scene, Panel::Warnings, format!("Warnings: {}", warnings.len()));
    let inner = block.inner(area);
    frame.render_widget(block, area);
    if warnings.is_empty() {
        frame.render_widget(Paragraph::new(" Nothing is known that would spoil the result."), inner);
        return;
    }
    let chosen = scene.state.warning.min(warnings.len() - 1);
    let listed = (warnings.len() as u16).min(inner.height / 2);
    let [list, text] = Layout::vertical([Constraint::Length(listed + 1), Constraint::Fill(1)]).areas(inner);
    let first = (chosen + 1).saturating_sub(usize::from(listed));
    let lines: Vec<_> = (warnings.iter().enumerate().skip(first).take(usize::from(listed)))
        .map(|(place, warning)| {
            let channels = warning.channels.join(" ");
            let line = Line::raw(format!(" {} {channels}", warning.kind.name()));
            if place == chosen { line.style(scene.theme.chosen()) } else { line }
        })
        .collect();
    frame.render_widget(Paragraph::new(lines), list);
    frame.render_widget(Paragraph::new(warnings[chosen].text.as_str()).wrap(Wrap { trim: true }), text);
}

/// The beginning of a text that is too long.
pub(crate) fn shortened(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    text.chars().take(width.saturating_sub(1)).chain(['…']).collect()
}
