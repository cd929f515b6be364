//! All sources side by side: how each of them is, in four lines.

use imu_noise::Term;
use ratatui::{
    Frame,
    layout::Rect,
    style::Style,
    text::{Line, Span},
    widgets::{Block, Borders, Paragraph},
};
use vn100_analysis::sensor_of;
use vn100_protocol::Quantity;
use vn100_report::numbers::plain::{digits, grouped, time};

use super::{
    header::{LEAST_NAME, link_word},
    scene::Scene,
    source::{Source, Stage, short_name},
    units::{convention, written},
    warnings::shortened,
};
use crate::remedy_words::remedy_words;

/// Lines of a source, with one below.
const LINES: usize = 5;

pub(crate) fn draw(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let frozen = if scene.state.frozen { ", FROZEN, measuring goes on" } else { "" };
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

fn one(scene: Scene<'_>, place: usize, source: &Source, width: usize) -> Vec<Line<'static>> {
    let theme = scene.theme;
    let (word, style) = link_word(source, theme);
    let (snapshot, timing) = (&source.snapshot, &source.snapshot.timing);
    let chosen = if place == scene.state.source { theme.chosen() } else { Style::new().bold() };
    let measured = snapshot.arrivals.and_then(|arrivals| arrivals.measured_hz);
    let lost = snapshot.link.tally.rejected.total() + timing.missing;
    let health =
        format!("  bad lines {}  missing {}", grouped(snapshot.link.tally.rejected.total()), grouped(timing.missing));
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
    let mut warned: Vec<String> = match &source.stage {
        Stage::Ended(reason) => reason.iter().cloned().collect(),
        Stage::Preparing | Stage::Measuring => Vec::new(),
    };
    warned.extend(source.errors());
    let broken = !warned.is_empty();
    warned.extend(source.warnings.iter().map(|warning| theme.spelled(warning.in_words(remedy_words))));
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
        Line::styled(warned, if broken { theme.bad() } else { theme.warning() }),
        Line::raw(""),
    ]
}

/// N of all axes, with its unit.
fn white_noise(scene: Scene<'_>, source: &Source, quantity: Quantity) -> String {
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
    format!("{} N {} {}", short_name(quantity), values.join(" "), scene.theme.spelled(written(unit)))
}
