//! The health of a source: where it is, how regularly its lines come, what was lost. In three lines
//! above the panels, with the goals below.

use std::path::Path;

use indicatif::HumanBytes;
use ratatui::{
    Frame,
    layout::Rect,
    style::Style,
    text::{Line, Span},
    widgets::Paragraph,
};
use vn100_analysis::{Plan, RateFrom, Severity, SourceResult};
use vn100_protocol::Quantity;
use vn100_report::{
    health::{self, rate_from_word},
    names::{missing_text, outages, pending_text, rejected_lines},
    numbers::plain::{clock, digits, digits_trimmed, grouped, ppm, time},
    printable, shortened,
};
use vn100_session::{Playback, Speed};

use crate::{
    panels::warnings::in_gaps,
    scene::Scene,
    source::{SourcePhase, SourceView},
    theme::Theme,
};

/// How much is spelled out, the most first: the first that has room is drawn.
const DETAILS: [Detail; 4] = [Detail::All, Detail::Some, Detail::Little, Detail::Least];

/// Columns of a name that say which one it is.
pub(crate) const LEAST_NAME: usize = 8;

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Detail {
    Least,
    Little,
    Some,
    All,
}

pub(crate) fn draw_header(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let (source, width) = (scene.source, usize::from(area.width));
    let mut lines = vec![
        first(scene, width),
        fitting(width, |detail| second(scene.theme, source, detail)),
        fitting(width, |detail| third(scene.theme, source, detail)),
    ];
    lines.extend(goal_lines(scene, area.width));
    frame.render_widget(Paragraph::new(lines), area);
    if let Some(playback) = source.playback {
        let bar = Rect::new(area.x, area.bottom() - 1, area.width, 1);
        draw_progress(frame, bar, scene, playback);
    }
}

/// What the measurement is to reach and how long that takes, on as many lines as it needs.
pub(crate) fn goal_lines(scene: Scene<'_>, width: u16) -> Vec<Line<'static>> {
    let source = scene.source;
    let goals = source.goals.texts(&source.result, source.now);
    if goals.is_empty() {
        return Vec::new();
    }
    let width = usize::from(width);
    let goals: Vec<String> = goals.into_iter().map(|goal| scene.theme.spelled(goal)).collect();
    let together = format!(" goal: {}", goals.join("   "));
    let texts = if together.chars().count() <= width {
        vec![together]
    } else {
        let options = textwrap::Options::new(width.max(1)).initial_indent(" goal: ").subsequent_indent("       ");
        goals.iter().flat_map(|goal| textwrap::wrap(goal, &options)).map(Into::into).collect()
    };
    texts.into_iter().map(|text| Line::styled(text, Style::new().bold())).collect()
}

/// Parts of a line, with room between them.
struct Parts(Vec<Span<'static>>);

impl Parts {
    fn new() -> Self {
        Self(vec![Span::raw(" ")])
    }

    fn add(&mut self, text: impl Into<String>, style: Style) {
        if self.0.len() > 1 {
            self.0.push(Span::raw("  "));
        }
        self.0.push(Span::styled(text.into(), style));
    }

    fn line(self) -> Line<'static> {
        Line::from(self.0)
    }
}

/// The line with the most detail that there is room for, or else with the least, without its last
/// parts: half a number would be another one.
fn fitting(width: usize, line: impl Fn(Detail) -> Line<'static>) -> Line<'static> {
    let fitting = DETAILS.into_iter().map(&line).find(|line| line.width() <= width);
    fitting.unwrap_or_else(|| {
        let mut least = line(Detail::Least);
        while least.width() > width && least.spans.pop().is_some() {}
        least
    })
}

/// What a source does, in a word.
pub(crate) fn state_word(source: &SourceView, theme: Theme) -> (String, Style) {
    let (word, severity) = match &source.phase {
        SourcePhase::Ended(Some(_)) => ("ENDED".into(), Some(Severity::Problem)),
        SourcePhase::Ended(None) => ("ended".into(), Some(Severity::Note)),
        phase => health::state(&source.result.source, *phase == SourcePhase::Preparing),
    };
    match severity {
        None if source.link().is_some() => (format!("● {word}"), theme.good()),
        None => (word, theme.good()),
        Some(Severity::Note) => (word, Style::new()),
        Some(Severity::Caution) => (word, theme.warning()),
        Some(Severity::Problem) => (word, theme.error()),
    }
}

/// The name is cut where room is short: what stands behind it changes, and it does not.
fn first(scene: Scene<'_>, width: usize) -> Line<'static> {
    let Scene { source, theme, .. } = scene;
    let line = |name: String, detail: Detail| {
        let mut parts = Parts::new();
        if scene.sources.len() > 1 {
            parts.add(format!("{}/{}", scene.state.source + 1, scene.sources.len()), theme.chosen());
        }
        parts.add(name, Style::new().bold());
        let (word, style) = state_word(source, theme);
        let word = if detail <= Detail::Little { word.trim_end_matches(" baud").to_owned() } else { word };
        parts.add(word, style);
        if let Some(message) = &source.result.source.message {
            let nature = match source.result.source.compensated {
                _ if detail <= Detail::Little => "",
                Some(true) => "compensated",
                Some(false) => "uncompensated",
                None => "compensation unknown",
            };
            parts.add(format!("{message} {nature}").trim_end(), Style::new());
        }
        parts.add(format!("elapsed {}", clock(source.elapsed)), Style::new());
        parts.line()
    };
    let room = |detail| width.saturating_sub(line(String::new(), detail).width());
    let detail = DETAILS.into_iter().find(|detail| room(*detail) >= LEAST_NAME).unwrap_or(Detail::Least);
    line(shortened(&source.name, room(detail).max(LEAST_NAME)), detail)
}

fn second(theme: Theme, source: &SourceView, detail: Detail) -> Line<'static> {
    let timing = &source.result.timing;
    let mut parts = Parts::new();
    match timing.rate_hz.zip(timing.rate_from) {
        None => parts.add("rate unknown", theme.faint()),
        Some((_, RateFrom::Assumed)) if timing.samples == 0 => parts.add("rate unknown", theme.faint()),
        Some((rate_hz, from)) => {
            let is_assumed = from == RateFrom::Assumed;
            let source = if detail == Detail::Least && !is_assumed { "" } else { rate_from_word(from) };
            let rate = format!("rate {} Hz {source}", digits_trimmed(rate_hz, 6));
            parts.add(rate.trim_end(), if is_assumed { theme.warning() } else { Style::new() });
        }
    }
    if let Some(change) = timing.rate_change {
        parts.add(format!("now {} Hz", digits_trimmed(change.to_hz, 6)), theme.warning());
    }
    let measured = timing.measured_hz.zip(timing.offset_ppm);
    if let Some((hz, offset_ppm)) = measured {
        match detail {
            Detail::All => parts.add(format!("measured {hz:.3} Hz ({})", ppm(offset_ppm)), Style::new()),
            Detail::Some => parts.add(format!("measured {hz:.3} Hz"), Style::new()),
            // the previous rate
            Detail::Little | Detail::Least if timing.rate_change.is_some() => {}
            Detail::Little | Detail::Least => parts.add(format!("clock {}", ppm(offset_ppm)), Style::new()),
        }
    }
    if let Some(arrivals) = timing.arrivals {
        let [median, most, max] =
            [arrivals.p50_us, arrivals.p99_us, arrivals.max_us].map(|us| digits(us as f64 / 1e3, 3));
        let text = match detail {
            Detail::All => format!("intervals median {median}, 99 % within {most}, longest {max} ms"),
            Detail::Some => format!("intervals {median}, longest {max} ms"),
            Detail::Little => format!("every {median}, longest {max} ms"),
            Detail::Least => format!("longest {max} ms"),
        };
        parts.add(text, Style::new());
    }
    if let Some(load) = health::line_load(&source.result) {
        let style = if load > Plan::MOST_LOAD { theme.warning() } else { Style::new() };
        let percent = format!("{:.0} %", 100.0 * load);
        let is_short = detail <= Detail::Little;
        let text = if is_short { format!("baud {percent}") } else { format!("{percent} of the baud rate") };
        parts.add(text, style);
    }
    parts.line()
}

fn third(theme: Theme, source: &SourceView, detail: Detail) -> Line<'static> {
    let SourceResult { timing, link, .. } = &source.result;
    let mut parts = Parts::new();
    let counted = |count: u64| if count > 0 { theme.warning() } else { Style::new() };
    let recorder = source.result.source.recorder.as_ref();
    let has_failed = recorder.is_some_and(|recorder| recorder.error.is_some());
    if has_failed {
        // first: what stands behind it may have no room
        parts.add("RECORDING FAILED", theme.error());
    }
    let time = match detail {
        Detail::Little | Detail::Least => String::new(),
        Detail::Some | Detail::All => format!(" in {}", time(timing.duration_s)),
    };
    parts.add(format!("{} samples{time}", grouped(timing.samples)), Style::new());
    let rejected = if detail <= Detail::Little { grouped(link.rejected.total()) } else { rejected_lines(link) };
    parts.add(format!("rejected {rejected}"), counted(link.rejected.total()));
    if link.damaged_packets > 0 {
        parts.add(format!("damaged packets {}", grouped(link.damaged_packets)), theme.warning());
    }
    let gaps_shown = timing.gaps > 0 && detail == Detail::All;
    let gaps = if gaps_shown { in_gaps(timing.gaps) } else { String::new() };
    let pending = if detail == Detail::Least { String::new() } else { pending_text(timing) };
    let dropped = format!("dropped {}{gaps}{pending}", missing_text(timing));
    parts.add(dropped, counted(timing.missing_at_least));
    if timing.excluded > 0 {
        let changed = timing.rate_change.is_some();
        let style = if changed { theme.warning() } else { Style::new() };
        parts.add(format!("excluded {}", grouped(timing.excluded)), style);
    }
    if link.reconnects > 0 {
        let outages = outages(link).filter(|_| detail == Detail::All);
        let text =
            outages.map_or_else(|| format!("reconnected {}", link.reconnects), |outages| format!("link {outages}"));
        parts.add(text, theme.warning());
    }
    match recorder {
        Some(_) if has_failed => {}
        Some(recorder) => {
            let name = Path::new(&recorder.path).file_name().unwrap_or_default().to_string_lossy();
            let name = if detail == Detail::All { format!("recorded {}", printable(&name)) } else { "rec".into() };
            parts.add(name, theme.good());
            parts.0.push(Span::styled(format!(" {}", HumanBytes(recorder.bytes)), theme.good()));
        }
        None if source.playback.is_none() => parts.add("not recorded", theme.faint()),
        None => {}
    }
    let temperature = source.result.channels.iter().find(|channel| channel.quantity == Quantity::Temperature);
    if let Some(mean) = temperature.and_then(|channel| channel.statistics.mean).filter(|_| detail > Detail::Little) {
        parts.add(theme.spelled(format!("{mean:.1} °C")), Style::new());
    }
    parts.line()
}

fn draw_progress(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, playback: Playback) {
    let theme = scene.theme;
    let speed = match playback.speed {
        Speed::Times(times) => format!("{times}x"),
        Speed::Max => "max".to_owned(),
    };
    let state = match (playback.at_end, playback.paused) {
        (true, _) => format!("end, {speed}"),
        (false, true) => format!("|| paused, {speed}"),
        (false, false) => format!("▶ {speed}"),
    };
    let part = playback.total.map(|total| (playback.samples as f64 / total.max(1) as f64).min(1.0));
    let percent = part.map_or("  ?".into(), |part| format!("{:3.0}", 100.0 * part));
    let text = format!(" {state:<9}{percent} % ");
    let width = text.chars().count() as u16;
    let bar = Rect::new(area.x + width, area.y, area.width.saturating_sub(width + 1), 1);
    let filled = (part.unwrap_or(0.0) * f64::from(bar.width)).round() as usize;
    let line = Line::from(vec![
        Span::raw(text),
        Span::styled("━".repeat(filled), theme.good()),
        Span::styled("┈".repeat(usize::from(bar.width).saturating_sub(filled)), theme.faint()),
    ]);
    frame.render_widget(Paragraph::new(line), area);
}
