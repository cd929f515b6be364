//! What is wrong or may be: what is broken and the warnings, a line each on top and each in full in
//! a panel of their own; below them, in one line, the notices of what every healthy sensor has.

use ratatui::{
    Frame,
    layout::{Constraint, Layout, Rect},
    style::Style,
    text::Line,
    widgets::Paragraph,
};
use vn100_analysis::{Severity, SourceResult, Warning};
use vn100_report::{
    names::{missing_text, rejected_lines},
    numbers::plain::grouped,
};

use crate::{
    scene::{Scene, framed},
    source::SourceView,
    state::Panel,
    theme::Theme,
};
use vn100_report::{remedies::remedy_words, shortened, warnings};

/// The lines at the top of the screen, as far as there is room.
pub(crate) struct TopLines {
    /// The faults, in full.
    faults: Vec<String>,
    /// The warnings, the most severe first.
    warnings: Vec<(String, Style)>,
    notices: Option<String>,
    /// The warnings that have no row are named in the last one.
    most_warnings: usize,
}

const PRESS: &str = " press !";

impl TopLines {
    /// With so many rows for warnings at most.
    pub(crate) fn new(scene: Scene<'_>, width: u16, most_warnings: usize) -> Self {
        let Scene { source, theme, .. } = scene;
        let width = usize::from(width);
        let title = |fault: &crate::faults::LiveFault| theme.spelled(format!("!! {}", fault.title(source.now)));
        let faults = source.faults.all().iter().flat_map(|fault| {
            textwrap::wrap(&title(fault), width).into_iter().map(Into::into).collect::<Vec<String>>()
        });
        let warnings = source.warnings.iter().filter(|warning| warning.severity != Severity::Note);
        let warnings =
            warnings.map(|warning| (theme.spelled(warnings::title(warning)), of_severity(theme, warning.severity)));
        let is_note = |warning: &&Warning| warning.severity == Severity::Note;
        let notices: Vec<&Warning> = source.warnings.iter().filter(is_note).collect();
        Self {
            faults: faults.collect(),
            warnings: warnings.collect(),
            notices: (!notices.is_empty()).then(|| notice_line(&notices, width)).map(|text| theme.spelled(text)),
            most_warnings,
        }
    }

    pub(crate) fn rows(&self) -> u16 {
        let warnings = self.warnings.len().min(self.most_warnings);
        (self.faults.len() + warnings + usize::from(self.notices.is_some())).max(1) as u16
    }

    pub(crate) fn draw(self, frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
        let Scene { source, theme, .. } = scene;
        let width = usize::from(area.width);
        let mut lines: Vec<Line<'_>> = self.faults.into_iter().map(|text| Line::styled(text, theme.error())).collect();
        let mut texts = self.warnings;
        let rows = self.most_warnings;
        let full_rows = if texts.len() > rows { rows.saturating_sub(1) } else { rows };
        let others = texts.split_off(full_rows.min(texts.len()));
        lines.extend(texts.into_iter().map(|(text, style)| {
            let text = format!("! {text}");
            if text.chars().count() <= width {
                return Line::styled(text, style);
            }
            Line::styled(shortened(&text, width.saturating_sub(PRESS.len())) + PRESS, style)
        }));
        if let Some((_, style)) = others.first() {
            let names = names(others.iter().map(|(text, _)| text.as_str()));
            let text = shortened(&format!("! also {names}"), width.saturating_sub(PRESS.len()));
            lines.push(Line::styled(text + PRESS, *style));
        }
        lines.extend(self.notices.map(|text| Line::styled(text, theme.faint())));
        if lines.is_empty() {
            let text = if source.result.timing.samples > 0 { " no warnings" } else { " no warnings yet" };
            lines.push(Line::styled(text, theme.faint()));
        }
        frame.render_widget(Paragraph::new(lines), area);
    }
}

fn notice_line(notices: &[&Warning], width: usize) -> String {
    const KEYS: &str = "   ! reads";
    let names = names(notices.iter().map(|notice| notice.kind.name()));
    shortened(&format!("  note: {names}"), width.saturating_sub(KEYS.len())) + KEYS
}

fn of_severity(theme: Theme, severity: Severity) -> Style {
    match severity {
        Severity::Problem => theme.error(),
        Severity::Caution => theme.warning(),
        Severity::Note => theme.faint(),
    }
}

/// The names before their colons, each once, with how often it is there.
fn names<'a>(texts: impl Iterator<Item = &'a str>) -> String {
    let mut counted: Vec<(&str, usize)> = Vec::new();
    for text in texts {
        let name = text.split_once(':').map_or(text, |(name, _)| name);
        match counted.iter_mut().find(|(known, _)| *known == name) {
            Some((_, count)) => *count += 1,
            None => counted.push((name, 1)),
        }
    }
    let name = |(name, count): (&str, usize)| if count > 1 { format!("{name} ×{count}") } else { name.to_owned() };
    counted.into_iter().map(name).collect::<Vec<_>>().join(", ")
}

/// What was lost so far: rejected sentences by kind, damaged packets, dropped samples, reconnects;
/// none that is 0.
fn lost(source: &SourceView) -> Vec<String> {
    let SourceResult { timing, link, .. } = &source.result;
    let (rejected, reconnects, damaged) = (link.rejected.total(), link.reconnects, link.damaged_packets);
    let other = [
        (damaged, format!("damaged packets {}", grouped(damaged))),
        (timing.missing_at_least, format!("dropped {}{}", missing_text(timing), in_gaps(timing.gaps))),
        (reconnects, format!("reconnected {reconnects}")),
        (timing.excluded, format!("excluded {}", grouped(timing.excluded))),
    ];
    let other: Vec<String> = other.into_iter().filter(|(count, _)| *count > 0).map(|(_, text)| text).collect();
    let rejected = (rejected > 0).then(|| format!("rejected {}", rejected_lines(link)));
    rejected.into_iter().chain((!other.is_empty()).then(|| other.join("  "))).collect()
}

/// ` in 1 gap`, ` in 2 gaps`.
pub(crate) fn in_gaps(gaps: u64) -> String {
    if gaps == 1 { " in 1 gap".into() } else { format!(" in {} gaps", grouped(gaps)) }
}

/// What is broken or warned of, for the panel: its name, and it in full.
struct Finding {
    name: String,
    text: String,
    severity: &'static str,
    style: Style,
}

fn findings(scene: Scene<'_>) -> Vec<Finding> {
    let Scene { source, theme, .. } = scene;
    let fault = |fault: &crate::faults::LiveFault| Finding {
        name: fault.kind.name().into(),
        text: format!("{}. {}", fault.title(source.now), fault.kind.details()),
        severity: "fault",
        style: theme.error(),
    };
    let warning = |warning: &Warning| Finding {
        name: format!("{} {}", warning.kind.name(), warning.channels.join(" ")),
        text: warnings::in_words(warning, remedy_words),
        severity: warning.severity.name(),
        style: of_severity(theme, warning.severity),
    };
    source.faults.all().iter().map(fault).chain(source.warnings.iter().map(warning)).collect()
}

/// All of them by name, and the one chosen in full.
pub(crate) fn draw_panel(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let findings = findings(scene);
    let title = match findings.len() {
        count @ (0 | 1) => format!("Warnings: {count}"),
        count => format!("Warnings: {} of {count}, ↑↓ chooses", scene.state.warning.min(count - 1) + 1),
    };
    let inner = framed(frame, area, scene, Panel::Warnings, title);
    if findings.is_empty() {
        frame.render_widget(Paragraph::new(" No warning affects this result."), inner);
        return;
    }
    let chosen = scene.state.warning.min(findings.len() - 1);
    let width = usize::from(inner.width);
    let lost: Vec<_> = lost(scene.source).iter().map(|text| Line::raw(shortened(&format!(" {text}"), width))).collect();
    let text = scene.theme.spelled(findings[chosen].text.as_str());
    let mut text: Vec<Line<'_>> =
        textwrap::wrap(&text, width.max(1)).into_iter().map(|line| Line::raw(line.into_owned())).collect();
    // the counts, which stand above as well, and the list give way to the text, but for the one chosen
    let lost_have_room = usize::from(inner.height) >= lost.len() + text.len() + 2;
    let lost = if lost_have_room { lost } else { Vec::new() };
    let rows_lost = lost.len() as u16;
    let rest = inner.height.saturating_sub(rows_lost + 1);
    let listed = (findings.len() as u16).min(rest / 2).min(rest.saturating_sub(text.len() as u16)).max(1);
    let [counts, list, below] =
        Layout::vertical([Constraint::Length(rows_lost), Constraint::Length(listed + 1), Constraint::Fill(1)])
            .areas(inner);
    let first = (chosen + 1).saturating_sub(usize::from(listed));
    let lines: Vec<_> = (findings.iter().enumerate().skip(first).take(usize::from(listed)))
        .map(|(place, finding)| {
            let line = Line::styled(format!(" {:<8} {}", finding.severity, finding.name), finding.style);
            if place == chosen { line.style(finding.style.patch(scene.theme.chosen())) } else { line }
        })
        .collect();
    frame.render_widget(Paragraph::new(lost).style(scene.theme.warning()), counts);
    frame.render_widget(Paragraph::new(lines), list);
    let height = usize::from(below.height);
    if text.len() > height {
        let hidden = text.len() + 1 - height.min(text.len());
        text.truncate(height.saturating_sub(1));
        let shared = area.width < frame.area().width;
        let where_else = if shared { "press e" } else { "on a larger screen" };
        text.push(Line::styled(format!(" {hidden} more lines: {where_else}"), scene.theme.warning()));
    }
    frame.render_widget(Paragraph::new(text), below);
}
