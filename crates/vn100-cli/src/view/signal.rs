//! One channel in time and by value: the last minutes, and how often which value came beside the normal curve of the same spread.

use ratatui::{
    Frame,
    layout::{Constraint, Layout, Rect},
    symbols::Marker,
    text::Line,
    widgets::{
        Paragraph,
        canvas::{Canvas, Line as Stroke, Points},
    },
};

use super::{
    draw::{Scene, framed},
    format::{digits, time},
    source::{Group, Source},
    state::Panel,
    theme::Theme,
};
use crate::units::ChannelValues;

/// Slots of the whole strip, halved by each step of the zoom.
const MOST_SLOTS: usize = 480;

pub(crate) fn draw(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, source: &Source) {
    let Some((group, place)) = scene.state.group(source).zip(scene.state.channel(source)) else { return };
    let channel = &source.values[place];
    let block = framed(scene, Panel::Signal, format!("Signal of {}, {}", channel.name, channel.unit));
    let inner = block.inner(area);
    frame.render_widget(block, area);
    let wide = inner.width >= 100;
    let parts = [Constraint::Fill(1), Constraint::Fill(1)];
    let [strip, histogram] = if wide { Layout::horizontal(parts) } else { Layout::vertical(parts) }.areas(inner);
    let color = Theme::colour_of(scene.theme.axis(axis(&group, place)));
    draw_strip(frame, strip, scene, source, place, color);
    draw_histogram(frame, histogram, scene, channel, color);
}

fn axis(group: &Group, place: usize) -> usize {
    group.channels.iter().position(|channel| *channel == place).unwrap_or(0)
}

fn draw_strip(
    frame: &mut Frame<'_>,
    area: Rect,
    scene: Scene<'_>,
    source: &Source,
    place: usize,
    color: ratatui::style::Color,
) {
    let [title, chart] = Layout::vertical([Constraint::Length(1), Constraint::Fill(1)]).areas(area);
    let dots = usize::from(chart.width) * 2;
    let slots = MOST_SLOTS >> scene.state.strip_zoom;
    let Some(strip) = source.strip(place, dots, slots).filter(|strip| !strip.columns.is_empty()) else { return };
    let columns = strip.columns.iter().flatten();
    let (low, high) = columns
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), column| (low.min(column.min), high.max(column.max)));
    let decimals = source.values[place].decimals;
    let span_s = strip.column_s * strip.columns.len() as f64;
    let text = format!(" last {}: {low:.decimals$} to {high:.decimals$}", time(span_s));
    frame.render_widget(Paragraph::new(Line::styled(text, scene.theme.faint())), title);
    let (low, high) = if high > low { (low, high) } else { (low - 1.0, high + 1.0) };
    let canvas =
        Canvas::default().marker(Marker::Braille).x_bounds([0.0, (dots.max(2) - 1) as f64]).y_bounds([low, high]);
    // as wide as there are columns for, the latest on the right
    let first = dots.saturating_sub(strip.columns.len());
    frame.render_widget(
        canvas.paint(|context| {
            for (at, column) in strip.columns.iter().enumerate() {
                if let Some(column) = column {
                    let x = (first + at) as f64;
                    context.draw(&Stroke { x1: x, y1: column.min, x2: x, y2: column.max, color });
                }
            }
        }),
        chart,
    );
}

fn draw_histogram(
    frame: &mut Frame<'_>,
    area: Rect,
    scene: Scene<'_>,
    channel: &ChannelValues,
    color: ratatui::style::Color,
) {
    let [title, chart] = Layout::vertical([Constraint::Length(1), Constraint::Fill(1)]).areas(area);
    let Some(bars) = &channel.bars else { return };
    let shape = match (channel.skewness, channel.excess_kurtosis) {
        (Some(skewness), Some(kurtosis)) => {
            format!(", skewness {}, excess kurtosis {}", digits(skewness, 2), digits(kurtosis, 2))
        }
        _ => String::new(),
    };
    let text = format!(" by value; dots: the normal curve{shape}");
    frame.render_widget(Paragraph::new(Line::styled(text, scene.theme.faint())), title);
    let end = bars.first + bars.width * bars.counts.len() as f64;
    let total: u64 = bars.counts.iter().sum();
    let normal = |x: f64| {
        let (mean, std) = (channel.mean?, channel.std.filter(|std| *std > 0.0)?);
        let density = (-0.5 * ((x - mean) / std).powi(2)).exp() / (std * std::f64::consts::TAU.sqrt());
        Some((x, density * bars.width * total as f64))
    };
    let steps = u32::from(chart.width) * 2;
    let curve: Vec<(f64, f64)> = (0..steps)
        .filter_map(|step| normal(bars.first + (end - bars.first) * f64::from(step) / f64::from(steps)))
        .collect();
    let highest = bars.counts.iter().copied().max().unwrap_or(1).max(1) as f64;
    let top = curve.iter().map(|(_, y)| *y).fold(highest, f64::max);
    let columns = u32::from(chart.width).max(1);
    frame.render_widget(
        Canvas::default().marker(Marker::Block).x_bounds([bars.first, end]).y_bounds([0.0, top]).paint(|context| {
            for column in 0..columns {
                let x = bars.first + (end - bars.first) * (f64::from(column) + 0.5) / f64::from(columns);
                let place = ((x - bars.first) / bars.width) as usize;
                let count = bars.counts.get(place).copied().unwrap_or(0);
                if count > 0 {
                    context.draw(&Stroke { x1: x, y1: 0.0, x2: x, y2: count as f64, color });
                }
            }
        }),
        chart,
    );
    frame.render_widget(
        Canvas::default().marker(Marker::Braille).x_bounds([bars.first, end]).y_bounds([0.0, top]).paint(|context| {
            context.draw(&Points { coords: &curve, color: ratatui::style::Color::Reset });
        }),
        chart,
    );
}
