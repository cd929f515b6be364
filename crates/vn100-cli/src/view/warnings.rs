//! What is wrong or may be: the warnings, a line each on top and each in full in a panel of their
//! own; and, before the first sample, what is being waited for.

use ratatui::{
    Frame,
    layout::{Constraint, Layout, Rect},
    style::Style,
    text::Line,
    widgets::{Block, Borders, Padding, Paragraph, Wrap},
};
use vn100_driver::LinkState;
use vn100_report::{names::rejected_lines, numbers::plain::grouped};

use super::{
    draw::{Scene, framed},
    source::{SourcePhase, SourceView},
    state::Panel,
};
use crate::words::remedy_words;

/// Rows that they take, at most so many: the last one names what has no row, so that none is
/// omitted.
pub(crate) fn rows(source: &SourceView, most: u16) -> u16 {
    ((source.warnings.len() + source.errors().len()).clamp(1, usize::from(most))) as u16
}

/// What is broken first, then the newest; the last row names all that have no row.
pub(crate) fn draw_lines(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    const PRESS: &str = " press !";
    let Scene { source, theme, .. } = scene;
    let mut texts: Vec<(String, Style)> = source.errors().into_iter().map(|text| (text, theme.error())).collect();
    texts.extend(source.warnings.iter().map(|warning| (theme.spelled(warning.title()), theme.warning())));
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
fn lost(source: &SourceView) -> Vec<String> {
    let (timing, link) = (&source.snapshot.timing, &source.snapshot.link);
    let rejected = link.tally.rejected.total();
    let reconnects = link.connects.saturating_sub(1);
    let other = [
        (timing.missing, format!("dropped {} in {} gaps", grouped(timing.missing), grouped(timing.gaps))),
        (reconnects, format!("reconnected {reconnects}")),
        (timing.excluded, format!("excluded {}", grouped(timing.excluded))),
    ];
    let other: Vec<String> = other.into_iter().filter(|(count, _)| *count > 0).map(|(_, text)| text).collect();
    let rejected = (rejected > 0).then(|| format!("rejected {}", rejected_lines(&link.tally)));
    rejected.into_iter().chain((!other.is_empty()).then(|| other.join("  "))).collect()
}

/// All of them by name, and the one chosen in full.
pub(crate) fn draw_panel(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let warnings = &scene.source.warnings;
    let title = match warnings.len() {
        count @ (0 | 1) => format!("Warnings: {count}"),
        count => format!("Warnings: {} of {count}, ↑↓ chooses", scene.state.warning.min(count - 1) + 1),
    };
    let inner = framed(frame, area, scene, Panel::Warnings, title);
    if warnings.is_empty() {
        frame.render_widget(Paragraph::new(" No warning affects this result."), inner);
        return;
    }
    let chosen = scene.state.warning.min(warnings.len() - 1);
    let width = usize::from(inner.width);
    let lost: Vec<_> = lost(scene.source).iter().map(|text| Line::raw(shortened(&format!(" {text}"), width))).collect();
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
        Paragraph::new(scene.theme.spelled(warnings[chosen].in_words(remedy_words))).wrap(Wrap { trim: true }),
        text,
    );
}

pub(crate) fn shortened(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    text.chars().take(width.saturating_sub(1)).chain(['…']).collect()
}

pub(crate) fn draw_waiting(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let source = scene.source;
    let (what, why) = waiting_for(source);
    let tally = &source.snapshot.link.tally;
    let mut lines = vec![Line::raw(what).style(scene.theme.warning()), Line::raw("")];
    lines.extend(why.into_iter().map(|line| Line::raw(format!("- {line}"))));
    lines.push(Line::raw(""));
    lines.push(Line::raw(format!(
        "So far {} bytes, {} valid sentences, {} rejected.",
        grouped(source.snapshot.link.bytes()),
        grouped(tally.valid_sentences()),
        grouped(tally.rejected.total())
    )));
    let block = Block::new()
        .borders(Borders::ALL)
        .border_style(scene.theme.faint())
        .padding(Padding::symmetric(2, 1))
        .title(" No measurement yet ");
    frame.render_widget(Paragraph::new(lines).wrap(Wrap { trim: false }).block(block), area);
}

/// What comes next, and why it may not come.
fn waiting_for(source: &SourceView) -> (String, Vec<&str>) {
    let name = &source.name;
    if let (SourcePhase::Measuring, None | Some(LinkState::Up(_)), Some(lines)) =
        (&source.phase, &source.link, source.snapshot.rows_pending())
    {
        return pending(name, lines);
    }
    match (&source.phase, &source.link) {
        (SourcePhase::Preparing, _) => (
            format!("Preparing {name}: creating the recording and changing the settings of the sensor as requested."),
            vec!["A baud scan takes some seconds."],
        ),
        (SourcePhase::Ended(reason), _) => {
            (format!("{name} has ended without a measurement."), reason.iter().map(String::as_str).collect())
        }
        (SourcePhase::Measuring, None) => (
            format!("Reading {name}, waiting for the first measurement."),
            vec!["A stream may begin in the middle of a sentence: the first whole one counts."],
        ),
        (SourcePhase::Measuring, Some(link)) => match link {
            LinkState::Opening if source.origin.kind == Some("tcp") => (
                format!("Opening {name}."),
                vec![
                    "The server may be off, in another network, or behind a firewall.",
                    "It may accept one connection at a time, and have one already.",
                    "It may listen on another port: see its settings.",
                ],
            ),
            LinkState::Opening => (
                format!("Opening {name}."),
                vec![
                    "Another program may have it open.",
                    "You may lack the permission: on Linux, add your user to the group dialout.",
                    "It may have another name now: `vn100 ports` lists them.",
                ],
            ),
            LinkState::Probing { port, baud } => (
                match baud {
                    Some(baud) => format!("Listening on {port} at {baud} baud; scanning all baud rates of the sensor."),
                    None => format!("Connected to {port}; listening for a sensor."),
                },
                vec![
                    "The sensor may be without power, or still starting.",
                    "RX and TX may be swapped, or RS-232 levels connected to a TTL input.",
                    "Its output may be off: the program asks it, unless --listen-only is set.",
                ],
            ),
            LinkState::Up(up) => (
                match up.baud {
                    Some(baud) => {
                        format!("{} is connected at {baud} baud; waiting for the first measurement.", up.port)
                    }
                    None => format!("{} is connected; waiting for the first measurement.", up.port),
                },
                vec![
                    "At low rates a sentence takes up to a second.",
                    "The sensor may send another message: `vn100 configure PORT --set-message VNYMR`.",
                    "Sentences without a checksum are rejected, unless --accept-unchecked is set.",
                ],
            ),
            LinkState::Silent(up) => (
                format!("{} is open, but no data has arrived for several sample intervals.", up.port),
                vec![
                    "The sensor may have lost power.",
                    "Its output may have been switched off: `vn100 configure PORT --set-rate 40`.",
                    "Another program may have changed its baud rate.",
                ],
            ),
            LinkState::Down { was_up, cause, retry_in, .. } => (
                format!(
                    "{}: {cause}. Trying again in {} ms.",
                    if *was_up { "Disconnected" } else { "Not connected yet" },
                    retry_in.as_millis()
                ),
                vec!["It reconnects automatically; the samples so far are kept."],
            ),
            _ => ("Ending.".to_owned(), Vec::new()),
        },
    }
}

fn pending(name: &str, lines: u64) -> (String, Vec<&'static str>) {
    (
        format!(
            "{name} sends data; the sample rate is being measured. Its first {} samples are pending until their arrival times give it.",
            grouped(lines)
        ),
        vec![
            "Without gaps that takes 32 samples, or a second and 5 samples where the sensor reports its rate.",
            "With gaps or on a busy host it takes up to 1024 samples, half a minute at 40 Hz.",
            "None of them is lost: they are measured once the rate is known.",
        ],
    )
}
