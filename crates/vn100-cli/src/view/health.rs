//! The health of a source: where it is, how regularly its lines come, what was lost. In three lines
//! above the panels, and in four for each of several sources side by side.

use imu_noise::Term;
use indicatif::HumanBytes;
use ratatui::{
    Frame,
    layout::Rect,
    style::Style,
    text::{Line, Span},
    widgets::{Block, Borders, Paragraph},
};
use vn100_analysis::{RateFrom, Severity, sensor_of};
use vn100_driver::{LinkState, Up};
use vn100_pipeline::{Playback, Speed};
use vn100_protocol::Quantity;
use vn100_report::{
    names::{names_of, rejected_lines},
    numbers::plain::{clock, digits, digits_trimmed, grouped, ppm, time},
    printable,
};

use super::{
    draw::Scene,
    source::{SourcePhase, SourceView},
    theme::Theme,
    units::{convention, shown_unit},
    warnings::{in_gaps, shortened},
};
use crate::status::link_name;

/// How much is spelled out, the most first: the first that has room is drawn.
const DETAILS: [Detail; 3] = [Detail::All, Detail::Some, Detail::Least];

/// Columns of a name that say which one it is.
pub(crate) const LEAST_NAME: usize = 8;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Detail {
    Least,
    Some,
    All,
}

/// Draws it; gives the place of the progress bar, empty without one.
pub(crate) fn draw_header(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) -> Rect {
    let (source, width) = (scene.source, usize::from(area.width));
    let mut lines = vec![
        first(scene, width),
        fitting(width, |detail| second(scene.theme, source, detail)),
        fitting(width, |detail| third(scene.theme, source, detail)),
    ];
    if !source.goals.is_none() {
        let goals = scene.theme.spelled(source.goals.texts(source).join("   "));
        lines.push(Line::styled(shortened(&format!(" goal: {goals}"), width), Style::new().bold()));
    }
    frame.render_widget(Paragraph::new(lines), area);
    match source.playback {
        Some(playback) => {
            let bar = Rect::new(area.x, area.bottom() - 1, area.width, 1);
            draw_progress(frame, bar, scene.theme, playback)
        }
        None => Rect::default(),
    }
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

/// The line with the most detail that there is room for, or else with the least.
fn fitting(width: usize, line: impl Fn(Detail) -> Line<'static>) -> Line<'static> {
    DETAILS.into_iter().map(&line).find(|line| line.width() <= width).unwrap_or_else(|| line(Detail::Least))
}

pub(crate) fn link_word(source: &SourceView, theme: Theme) -> (String, Style) {
    let speed = |up: &Up| up.baud.map_or(String::new(), |baud| format!(" {baud} baud"));
    match (&source.phase, &source.link) {
        (SourcePhase::Preparing, _) => ("preparing".into(), theme.warning()),
        (SourcePhase::Ended(Some(_)), _) => ("ENDED".into(), theme.error()),
        (SourcePhase::Ended(None), _) => ("ended".into(), Style::new()),
        (SourcePhase::Measuring, None) => match source.playback {
            // the requested duration
            Some(playback) if playback.at_end && source.progress().is_some_and(|part| part < 1.0) => {
                ("duration reached".into(), Style::new())
            }
            Some(playback) if playback.at_end => ("end of capture".into(), Style::new()),
            Some(playback) if playback.paused => ("paused".into(), theme.warning()),
            _ => ("reading".into(), theme.good()),
        },
        (SourcePhase::Measuring, Some(link)) => match link {
            LinkState::Up(up) => (format!("● up{}", speed(up)), theme.good()),
            LinkState::Silent(up) => (format!("SILENT{}", speed(up)), theme.error()),
            LinkState::Down { was_up: true, .. } => (link_name(link), theme.error()),
            LinkState::Opening | LinkState::Probing { .. } | LinkState::Down { .. } => {
                (link_name(link), theme.warning())
            }
            _ => (link_name(link), Style::new()),
        },
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
        let (word, style) = link_word(source, theme);
        let word = if detail == Detail::Least { word.trim_end_matches(" baud").to_owned() } else { word };
        parts.add(word, style);
        if let Some(layout) = &source.snapshot.layout {
            let nature = match layout.compensated {
                _ if detail == Detail::Least => "",
                Some(true) => "compensated",
                Some(false) => "uncompensated",
                None => "compensation unknown",
            };
            parts.add(format!("{} {nature}", layout.message).trim_end(), Style::new());
        }
        parts.add(format!("elapsed {}", clock(source.elapsed)), Style::new());
        if scene.state.frozen {
            parts.add(" FROZEN, still measuring ", theme.chosen());
        }
        parts.line()
    };
    let room = |detail| width.saturating_sub(line(String::new(), detail).width());
    let detail = DETAILS.into_iter().find(|detail| room(*detail) >= LEAST_NAME).unwrap_or(Detail::Least);
    line(shortened(&source.name, room(detail).max(LEAST_NAME)), detail)
}

fn second(theme: Theme, source: &SourceView, detail: Detail) -> Line<'static> {
    let (snapshot, timing) = (&source.snapshot, &source.snapshot.timing);
    let mut parts = Parts::new();
    match timing.rate_from {
        RateFrom::Assumed if timing.samples == 0 => parts.add("rate unknown", theme.faint()),
        from => {
            let (source, style) = match from {
                RateFrom::Option => (" as given", Style::new()),
                RateFrom::DeviceTime => (" from device time", Style::new()),
                RateFrom::Device => (" as reported", Style::new()),
                RateFrom::Arrival => (" from arrivals", Style::new()),
                RateFrom::Assumed => (" ASSUMED", theme.warning()),
            };
            parts.add(format!("rate {} Hz{source}", digits_trimmed(timing.rate_hz, 6)), style);
        }
    }
    if let Some(change) = snapshot.rate_change {
        parts.add(format!("now {} Hz", digits_trimmed(change.to_hz, 6)), theme.warning());
    }
    let measured = snapshot.arrivals.and_then(|arrivals| arrivals.measured_hz.zip(arrivals.offset_ppm));
    if let Some((hz, offset_ppm)) = measured {
        match detail {
            Detail::All => parts.add(format!("measured {hz:.3} Hz ({})", ppm(offset_ppm)), Style::new()),
            Detail::Some => parts.add(format!("measured {hz:.3} Hz"), Style::new()),
            // the previous rate
            Detail::Least if snapshot.rate_change.is_some() => {}
            Detail::Least => parts.add(format!("clock {}", ppm(offset_ppm)), Style::new()),
        }
    }
    if let Some(arrivals) = snapshot.arrivals.and_then(|arrivals| arrivals.arrivals) {
        let [p50, p99, max] = [arrivals.p50_us, arrivals.p99_us, arrivals.max_us].map(|us| digits(us as f64 / 1e3, 3));
        let word = if detail == Detail::Least { "" } else { "intervals " };
        parts.add(format!("{word}p50 {p50} p99 {p99} max {max} ms"), Style::new());
    }
    if let Some(load) = source.line_load() {
        let style = if load > 0.9 { theme.warning() } else { Style::new() };
        parts.add(format!("load {:.0} %", 100.0 * load), style);
    }
    parts.line()
}

fn third(theme: Theme, source: &SourceView, detail: Detail) -> Line<'static> {
    let (snapshot, timing) = (&source.snapshot, &source.snapshot.timing);
    let mut parts = Parts::new();
    let counted = |count: u64| if count > 0 { theme.warning() } else { Style::new() };
    let time = match detail {
        Detail::Least => String::new(),
        Detail::Some | Detail::All => format!(" in {}", time(timing.duration_s())),
    };
    parts.add(format!("{} samples{time}", grouped(timing.samples)), Style::new());
    let tally = &snapshot.link.tally;
    let rejected = if detail == Detail::Least { grouped(tally.rejected.total()) } else { rejected_lines(tally) };
    parts.add(format!("rejected {rejected}"), counted(tally.rejected.total()));
    let gaps_shown = timing.gaps > 0 && detail == Detail::All;
    let gaps = if gaps_shown { in_gaps(timing.gaps) } else { String::new() };
    parts.add(format!("dropped {}{gaps}", grouped(timing.missing)), counted(timing.missing));
    if timing.excluded > 0 {
        let changed = snapshot.rate_change.is_some();
        let style = if changed { theme.warning() } else { Style::new() };
        parts.add(format!("excluded {}", grouped(timing.excluded)), style);
    }
    let reconnects = snapshot.link.connects.saturating_sub(1);
    if reconnects > 0 {
        let source = if snapshot.outages.times > 0 && detail == Detail::All {
            format!("link {}", snapshot.outages)
        } else {
            format!("reconnected {reconnects}")
        };
        parts.add(source, theme.warning());
    }
    match &source.recording {
        Some(recording) if recording.error.is_some() => parts.add("RECORDING FAILED", theme.error()),
        Some(recording) => {
            let name = recording.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let name = printable(&name);
            let name = if detail == Detail::All { format!("recorded {name}") } else { "rec".into() };
            parts.add(format!("{name} {}", HumanBytes(recording.bytes)), theme.good());
        }
        None if source.playback.is_none() => parts.add("not recorded", theme.faint()),
        None => {}
    }
    let temperature = source.values.iter().find(|channel| channel.quantity == Quantity::Temperature);
    if let Some(mean) = temperature.and_then(|channel| channel.mean).filter(|_| detail != Detail::Least) {
        parts.add(theme.spelled(format!("{mean:.1} °C")), Style::new());
    }
    parts.line()
}

fn draw_progress(frame: &mut Frame<'_>, area: Rect, theme: Theme, playback: Playback) -> Rect {
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
    bar
}

/// Lines of a source, with one below.
const LINES: usize = 5;

pub(crate) fn draw_overview(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let frozen = if scene.state.frozen { ", FROZEN, still measuring" } else { "" };
    let block = Block::new().borders(Borders::ALL).title(format!(" {} sources{frozen} ", scene.sources.len()));
    let inner = block.inner(area);
    frame.render_widget(block, area);
    let room = usize::from(inner.height) / LINES;
    let first = (scene.state.source + 1).saturating_sub(room.max(1));
    let lines: Vec<Line<'_>> = (scene.sources.iter().enumerate().skip(first).take(room.max(1)))
        .flat_map(|(place, source)| one(scene, place, source, usize::from(inner.width)))
        .collect();
    frame.render_widget(Paragraph::new(lines), inner);
}

fn one(scene: Scene<'_>, place: usize, source: &SourceView, width: usize) -> Vec<Line<'static>> {
    let theme = scene.theme;
    let (word, style) = link_word(source, theme);
    let (snapshot, timing) = (&source.snapshot, &source.snapshot.timing);
    let chosen = if place == scene.state.source { theme.chosen() } else { Style::new().bold() };
    let measured = snapshot.arrivals.and_then(|arrivals| arrivals.measured_hz);
    let lost = snapshot.link.tally.rejected.total() + timing.missing;
    let health =
        format!("  rejected {}  dropped {}", grouped(snapshot.link.tally.rejected.total()), grouped(timing.missing));
    let head = |name: &str| {
        Line::from(vec![
            Span::styled(format!(" {} {name} ", place + 1), chosen),
            Span::raw(" "),
            Span::styled(word.clone(), style),
            Span::styled(health.clone(), if lost > 0 { theme.warning() } else { Style::new() }),
        ])
    };
    // what stands behind the name changes, and it does not
    let beside = head("").width();
    let head = head(&shortened(&source.name, width.saturating_sub(beside).max(LEAST_NAME)));
    let counts = format!("   {} samples in {}", grouped(timing.samples), time(timing.duration_s()));
    let counts = counts + &measured.map_or(String::new(), |hz| format!("  {hz:.3} Hz measured"));
    let noise = [Quantity::AngularRate, Quantity::Acceleration].map(|quantity| white_noise(scene, source, quantity));
    let mut warned: Vec<String> = match &source.phase {
        SourcePhase::Ended(reason) => reason.iter().cloned().collect(),
        SourcePhase::Preparing | SourcePhase::Measuring => Vec::new(),
    };
    warned.extend(source.faults.all().iter().map(|fault| fault.title(source.now)));
    let broken = !warned.is_empty();
    let warnings = source.warnings.iter().filter(|warning| warning.severity != Severity::Note);
    warned.extend(warnings.map(|warning| theme.spelled(warning.title())));
    let more = warned.len().saturating_sub(1);
    let warned = warned.into_iter().next();
    let more = if more > 0 { format!(" +{more} more") } else { String::new() };
    let warned = warned.map_or(String::new(), |text| {
        format!("{}{more}", shortened(&format!("   ! {text}"), width.saturating_sub(more.len())))
    });
    vec![
        head,
        Line::raw(counts),
        Line::raw(format!("   {}", noise.join("   "))),
        Line::styled(warned, if broken { theme.error() } else { theme.warning() }),
        Line::raw(""),
    ]
}

fn white_noise(scene: Scene<'_>, source: &SourceView, quantity: Quantity) -> String {
    let Some(unit) = sensor_of(quantity).map(|sensor| convention(sensor, Term::White, scene.state.units)) else {
        return String::new();
    };
    let axes = source.values.iter().filter(|channel| channel.quantity == quantity);
    let values: Vec<String> = axes
        .filter_map(|channel| channel.noise.as_ref()?.parameter(Term::White))
        .map(|white| white.value.map_or("-".into(), |value| digits(value * unit.factor, 2)))
        .collect();
    if values.is_empty() {
        return String::new();
    }
    format!("{} N {} {}", names_of(quantity).short, values.join(" "), scene.theme.spelled(shown_unit(unit)))
}
