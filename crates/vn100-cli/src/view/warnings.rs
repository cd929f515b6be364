//! The warnings: a line each on top, and each in full in a panel of their own.

use ratatui::{
    Frame,
    layout::{Constraint, Layout, Rect},
    style::Style,
    text::Line,
    widgets::{Paragraph, Wrap},
};
use vn100_report::{names::rejected_lines, numbers::plain::grouped};

use super::{
    scene::{Scene, framed},
    source::Source,
    state::Panel,
};
use crate::remedy_words::remedy_words;

/// Rows that they take, at most so many: the last one names what has no row, so that nothing hides
/// behind the newest.
pub(crate) fn rows(source: &Source, most: u16) -> u16 {
    ((source.warnings.len() + source.errors().len()).clamp(1, usize::from(most))) as u16
}

/// What is broken first, then the newest; where there are more than rows, the last row names all
/// the others.
pub(crate) fn draw_lines(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, source: &Source) {
    const PRESS: &str = " press !";
    let theme = scene.theme;
    let mut texts: Vec<(String, Style)> = source.errors().into_iter().map(|text| (text, theme.bad())).collect();
    texts
        .extend(source.warnings.iter().map(|warning| (theme.spelled(warning.in_words(remedy_words)), theme.warning())));
    if texts.is_empty() {
        let samples = source.snapshot.timing.samples > 0;
        let text = if samples { " no warnings" } else { " no warnings yet" };
        frame.render_widget(Paragraph::new(text).style(theme.faint()), area);
        return;
    }
    let (rows, width) = (usize::from(area.height), usize::from(area.width));
    let full_rows = if texts.len() > rows { rows.saturating_sub(1) } else { rows };
    let others = texts.split_off(full_rows.min(texts.len()));
    let mut lines: Vec<Line<'_>> = (texts.into_iter())
        .map(|(text, style)| {
            let text = format!("! {text}");
            if text.chars().count() < width {
                return Line::styled(text, style);
            }
            Line::styled(shortened(&text, width.saturating_sub(PRESS.len() + 1)) + PRESS, style)
        })
        .collect();
    if let Some((_, style)) = others.first() {
        let text = shortened(&format!("! also {}", names(&others)), width.saturating_sub(PRESS.len() + 1));
        lines.push(Line::styled(text + PRESS, *style));
    }
    frame.render_widget(Paragraph::new(lines), area);
}

/// The names before their colons, each once, with how often it is there.
fn names(texts: &[(String, Style)]) -> String {
    let mut counted: Vec<(&str, usize)> = Vec::new();
    for (text, _) in texts {
        let name = text.split_once(':').map_or(text.as_str(), |(name, _)| name);
        match counted.iter_mut().find(|(known, _)| *known == name) {
            Some((_, count)) => *count += 1,
            None => counted.push((name, 1)),
        }
    }
    let name = |(name, count): (&str, usize)| if count > 1 { format!("{name} ×{count}") } else { name.to_owned() };
    counted.into_iter().map(name).collect::<Vec<_>>().join(", ")
}

/// What was lost so far: rejected sentences by kind, dropped samples, reconnects; none that is 0.
fn lost(source: &Source) -> Vec<String> {
    let (timing, link) = (&source.snapshot.timing, &source.snapshot.link);
    let bad = link.tally.rejected.total();
    let reconnects = link.connects.saturating_sub(1);
    let other = [
        (timing.missing, format!("missing {} in {} gaps", grouped(timing.missing), grouped(timing.gaps))),
        (reconnects, format!("reconnected {reconnects}")),
        (timing.excluded, format!("left out {}", grouped(timing.excluded))),
    ];
    let other: Vec<String> = other.into_iter().filter(|(count, _)| *count > 0).map(|(_, text)| text).collect();
    let bad = (bad > 0).then(|| format!("bad lines {}", rejected_lines(&link.tally)));
    bad.into_iter().chain((!other.is_empty()).then(|| other.join("  "))).collect()
}

/// All of them by name, and the one chosen in full.
pub(crate) fn draw_panel(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, source: &Source) {
    let warnings = &source.warnings;
    let title = match warnings.len() {
        count @ (0 | 1) => format!("Warnings: {count}"),
        count => format!("Warnings: {} of {count}, ↑↓ chooses", scene.state.warning.min(count - 1) + 1),
    };
    let block = framed(scene, Panel::Warnings, title);
    let inner = block.inner(area);
    frame.render_widget(block, area);
    if warnings.is_empty() {
        frame.render_widget(Paragraph::new(" Nothing is known that would spoil the result."), inner);
        return;
    }
    let chosen = scene.state.warning.min(warnings.len() - 1);
    let width = usize::from(inner.width);
    let lost: Vec<_> = lost(source).iter().map(|text| Line::raw(shortened(&format!(" {text}"), width))).collect();
    let rows_lost = lost.len() as u16;
    let listed = (warnings.len() as u16).min(inner.height.saturating_sub(rows_lost) / 2);
    let [counts, list, text] =
        Layout::vertical([Constraint::Length(rows_lost), Constraint::Length(listed + 1), Constraint::Fill(1)])
            .areas(inner);
    let first = (chosen + 1).saturating_sub(usize::from(listed));
    let lines: Vec<_> = (warnings.iter().enumerate().skip(first).take(usize::from(listed)))
        .map(|(place, warning)| {
            let channels = warning.channels.join(" ");
            let line = Line::raw(format!(" {} {channels}", warning.kind.name()));
            if place == chosen { line.style(scene.theme.chosen()) } else { line }
        })
        .collect();
    frame.render_widget(Paragraph::new(lost).style(scene.theme.warning()), counts);
    frame.render_widget(Paragraph::new(lines), list);
    frame.render_widget(
        Paragraph::new(scene.theme.spelled(warnings[chosen].text.in_words(remedy_words))).wrap(Wrap { trim: true }),
        text,
    );
}

/// The beginning of a text that is too long.
pub(crate) fn shortened(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    text.chars().take(width.saturating_sub(1)).chain(['…']).collect()
}
