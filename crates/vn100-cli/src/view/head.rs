//! The health of a source in three lines: where it is, how regularly its lines come, what was lost.

use indicatif::HumanBytes;
use ratatui::{
    Frame,
    layout::Rect,
    style::Style,
    text::{Line, Span},
    widgets::Paragraph,
};
use vn100_driver::{LinkState, Up};
use vn100_pipeline::RateFrom;
use vn100_protocol::Quantity;

use super::{
    draw::Scene,
    format::{clock, digits, grouped, time},
    source::{Playback, Source, Stage},
    theme::Theme,
};
use crate::{exit::printable, pace::Speed, text::bad_lines};

/// Columns from which on everything is spelled out.
const WIDE: u16 = 110;

/// Draws it; gives the place of the progress bar, empty without one.
pub(crate) fn draw(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, source: &Source) -> Rect {
    let wide = area.width >= WIDE;
    let lines = vec![first(scene, source), second(scene.theme, source, wide), third(scene.theme, source, wide)];
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

/// A word for the link, and whether it is well.
pub(crate) fn link_word(source: &Source, theme: Theme) -> (String, Style) {
    let speed = |up: &Up| up.baud.map_or(String::new(), |baud| format!(" {baud} baud"));
    match (&source.stage, &source.link) {
        (Stage::Preparing, _) => ("preparing".into(), theme.warning()),
        (Stage::Ended(Some(_)), _) => ("ENDED".into(), theme.bad()),
        (Stage::Ended(None), _) => ("ended".into(), Style::new()),
        (Stage::Measuring, None) => ("reading".into(), theme.good()),
        (Stage::Measuring, Some(link)) => match link {
            LinkState::Opening => ("opening".into(), theme.warning()),
            LinkState::Probing { baud: Some(baud), .. } => (format!("listening at {baud} baud"), theme.warning()),
            LinkState::Probing { baud: None, .. } => ("listening".into(), theme.warning()),
            LinkState::Up(up) => (format!("● up{}", speed(up)), theme.good()),
            LinkState::Silent(up) => (format!("SILENT{}", speed(up)), theme.bad()),
            LinkState::Down { .. } => ("LOST".into(), theme.bad()),
            _ => ("ending".into(), Style::new()),
        },
    }
}

fn first(scene: Scene<'_>, source: &Source) -> Line<'static> {
    let theme = scene.theme;
    let mut parts = Parts::new();
    if scene.sources.len() > 1 {
        parts.add(format!("{}/{}", scene.state.source + 1, scene.sources.len()), theme.chosen());
    }
    parts.add(source.name.clone(), Style::new().bold());
    let (word, style) = link_word(source, theme);
    parts.add(word, style);
    if let Some(layout) = &source.snapshot.layout {
        let nature = if layout.compensated { "compensated" } else { "uncompensated" };
        parts.add(format!("{} {nature}", layout.message), Style::new());
    }
    parts.add(format!("elapsed {}", clock(source.elapsed)), Style::new());
    if scene.state.frozen {
        parts.add(" FROZEN, measuring goes on ", theme.chosen());
    }
    parts.line()
}

fn second(theme: Theme, source: &Source, wide: bool) -> Line<'static> {
    let (snapshot, timing) = (&source.snapshot, &source.snapshot.timing);
    let mut parts = Parts::new();
    let told = match timing.rate_from {
        RateFrom::Option => " as asked",
        RateFrom::Device => " set",
        RateFrom::Arrival => " by arrival",
        RateFrom::Assumed => " ASSUMED",
    };
    let style =
        if timing.rate_from == RateFrom::Assumed && timing.samples > 0 { theme.warning() } else { Style::new() };
    parts.add(format!("rate {} Hz{told}", digits_trimmed(timing.rate_hz)), style);
    if let Some((hz, ppm)) = snapshot.arrivals.and_then(|arrivals| arrivals.measured_hz.zip(arrivals.offset_ppm)) {
        let measured = if wide { format!("measured {hz:.3} ({ppm:+.0} ppm)") } else { format!("clock {ppm:+.0} ppm") };
        parts.add(measured, Style::new());
    }
    if let Some(arrivals) = snapshot.arrivals.and_then(|arrivals| arrivals.arrivals) {
        let [p50, p99, max] = [arrivals.p50_us, arrivals.p99_us, arrivals.max_us].map(|us| digits(us as f64 / 1e3, 3));
        let intervals = if wide {
            format!("intervals p50 {p50} p99 {p99} max {max} ms")
        } else {
            format!("intervals p99 {p99} max {max} ms")
        };
        parts.add(intervals, Style::new());
    }
    if let Some(load) = source.line_load() {
        let style = if load > 0.9 { theme.warning() } else { Style::new() };
        parts.add(format!("line {:.0} %", 100.0 * load), style);
    }
    parts.line()
}

fn third(theme: Theme, source: &Source, wide: bool) -> Line<'static> {
    let (snapshot, timing) = (&source.snapshot, &source.snapshot.timing);
    let mut parts = Parts::new();
    let counted = |count: u64| if count > 0 { theme.warning() } else { Style::new() };
    parts.add(format!("{} samples in {}", grouped(timing.samples), time(timing.duration_s())), Style::new());
    let tally = &snapshot.link.tally;
    let bad = if wide { bad_lines(tally) } else { grouped(tally.bad.total()) };
    parts.add(format!("bad lines {bad}"), counted(tally.bad.total()));
    let gaps = if timing.gaps > 0 && wide { format!(" in {} gaps", grouped(timing.gaps)) } else { String::new() };
    parts.add(format!("missing {}{gaps}", grouped(timing.missing)), counted(timing.missing));
    match &source.recording {
        Some(recording) if recording.error.is_some() => parts.add("RECORDING FAILED", theme.bad()),
        Some(recording) => {
            let name = recording.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let name = printable(&name);
            let name = if wide { format!("recorded {name}") } else { "rec".into() };
            parts.add(format!("{name} {}", HumanBytes(recording.bytes)), theme.good());
        }
        None if source.playback.is_none() => parts.add("not recorded", theme.faint()),
        None => {}
    }
    let reconnects = snapshot.link.connects.saturating_sub(1);
    if reconnects > 0 {
        parts.add(format!("reconnected {reconnects}"), theme.warning());
    }
    let temperature = source.values.iter().find(|channel| channel.quantity == Quantity::Temperature);
    if let Some(mean) = temperature.and_then(|channel| channel.mean) {
        parts.add(format!("{mean:.1} °C"), Style::new());
    }
    if timing.left_out > 0 {
        parts.add(format!("left out {}", grouped(timing.left_out)), Style::new());
    }
    parts.line()
}

fn digits_trimmed(value: f64) -> String {
    let text = digits(value, 6);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A bar as wide as the capture, as far as it was replayed.
fn draw_progress(frame: &mut Frame<'_>, area: Rect, theme: Theme, playback: Playback) -> Rect {
    let position = playback.position;
    let speed = match position.speed {
        _ if position.at_end => "end".to_owned(),
        _ if position.paused => "paused".to_owned(),
        Speed::Times(times) => format!("{times}x"),
        Speed::Max => "max".to_owned(),
    };
    let part = playback.total.map(|total| (position.rows as f64 / total.max(1) as f64).min(1.0));
    let percent = part.map_or("  ?".into(), |part| format!("{:3.0}", 100.0 * part));
    let text = format!(" ▶ {speed:<7}{percent} % ");
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
