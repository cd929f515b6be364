//! What can take the place of the deviation: the spectrum, the segments of the record, and the
//! means of the segments over temperature.

use ratatui::{
    Frame,
    layout::{Constraint, Layout, Rect},
    style::Style,
    symbols::Marker,
    text::{Line, Span},
    widgets::{
        Paragraph,
        canvas::{Canvas, Line as Stroke, Points},
    },
};
use vn100_protocol::Quantity;
use vn100_report::{
    names::names_of,
    numbers::plain::{digits, time},
    units::ChannelValues,
};

use crate::{
    panels::{
        chart::{ChartAxes, LABELS, draw_grid, put},
        curve::LogAxis,
    },
    scene::{Scene, framed_as},
    source::{ChannelGroup, SourceView},
    state::{Panel, ShownPlot},
    theme::{SIGNS, Theme},
    units::ShownUnit,
};

/// An axis of the sensor that is drawn.
struct Series<'a> {
    axis: usize,
    channel: &'a ChannelValues,
}

fn series<'a>(scene: Scene<'a>, group: &ChannelGroup) -> Vec<Series<'a>> {
    let shown = |(axis, place): (usize, &usize)| {
        scene.state.is_shown(axis).then(|| Series { axis, channel: &scene.source.values[*place] })
    };
    group.channels.iter().enumerate().filter_map(shown).collect()
}

/// Draws the plot in the frame of the panel of curves.
pub(crate) fn draw(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, plot: ShownPlot) {
    let Some(group) = scene.state.group(scene.source) else { return };
    let unit = ShownUnit::of(&scene.source.values[group.channels[0]], scene.state.units);
    let (name, series) = (names_of(group.quantity).short, series(scene, &group));
    let title = match plot {
        ShownPlot::Spectrum => format!("Spectrum of the {name}, {}/√Hz one-sided", unit.name),
        ShownPlot::Segments => format!("Standard deviation of the {name} by segment, {}", unit.name),
        ShownPlot::Temperature => format!("{name} less each axis' mean over temperature, {}", unit.name),
        ShownPlot::Deviation | ShownPlot::OtherDeviation => return,
    };
    let is_chosen = scene.state.plot == plot && scene.state.panel == Panel::Allan;
    let inner = framed_as(frame, area, scene, is_chosen, scene.theme.spelled(title));
    let texts = match plot {
        ShownPlot::Spectrum => spectral_peaks(scene.theme, &series, &unit),
        ShownPlot::Segments => segment_changes(scene.theme, &series, &unit),
        ShownPlot::Temperature => coefficients(scene.theme, &series, &unit),
        ShownPlot::Deviation | ShownPlot::OtherDeviation => Vec::new(),
    };
    let [chart, below] = Layout::vertical([Constraint::Fill(1), Constraint::Length(texts.len() as u16)]).areas(inner);
    frame.render_widget(Paragraph::new(texts), below);
    match plot {
        ShownPlot::Spectrum => draw_spectrum(frame, chart, scene, &series, &unit),
        ShownPlot::Segments => draw_segments(frame, chart, scene, &series, &unit),
        ShownPlot::Temperature => draw_temperature(frame, chart, scene, &series, &unit),
        ShownPlot::Deviation | ShownPlot::OtherDeviation => {}
    }
}

fn nothing(frame: &mut Frame<'_>, area: Rect, theme: Theme, why: &str) {
    frame.render_widget(Paragraph::new(format!(" {why}")).style(theme.faint()), area);
}

/// A line of text for an axis, behind its sign.
fn of_axis(theme: Theme, series: &Series<'_>, text: &str) -> Line<'static> {
    let sign = SIGNS.get(series.axis).unwrap_or(&"●");
    Line::styled(theme.spelled(format!(" {sign} {}: {text}", series.channel.name)), theme.axis(series.axis))
}

fn spectral_peaks(theme: Theme, all: &[Series<'_>], unit: &ShownUnit) -> Vec<Line<'static>> {
    let of = |series: &Series<'_>| {
        let lines = series.channel.signal.as_ref().map_or(&[][..], |signal| &signal.disturbed.lines);
        let mut lines: Vec<_> = lines.iter().collect();
        lines.sort_by(|a, b| b.share_of_variance.total_cmp(&a.share_of_variance));
        let peak = |line: &&imu_noise::SpectralLine| {
            let (hz, amplitude) = (digits(line.frequency_hz, 3), digits(line.amplitude * unit.factor, 2));
            format!("{hz} Hz, amplitude {amplitude} ({:.0} % of the variance)", 100.0 * line.share_of_variance)
        };
        let text = lines.iter().take(2).map(peak).collect::<Vec<_>>().join("; ");
        of_axis(theme, series, if text.is_empty() { "no peaks" } else { &text })
    };
    all.iter().map(of).collect()
}

fn draw_spectrum(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, all: &[Series<'_>], unit: &ShownUnit) {
    let theme = scene.theme;
    let density = |series: &Series<'_>| -> Vec<(f64, f64)> {
        let density = series.channel.signal.as_ref().and_then(|signal| signal.density.as_ref());
        let points = density.map_or(&[][..], |density| &density.points);
        points.iter().map(|point| (point.frequency_hz, point.density_unit2_hz.sqrt() * unit.factor)).collect()
    };
    let curves: Vec<(usize, Vec<(f64, f64)>)> = all.iter().map(|series| (series.axis, density(series))).collect();
    let points = || curves.iter().flat_map(|(_, points)| points);
    let axes = LogAxis::over(points().map(|(x, _)| *x)).zip(LogAxis::over(points().map(|(_, y)| *y)));
    let Some((x, y)) = axes else {
        return nothing(frame, area, theme, "The spectrum needs a segment of samples: wait some seconds.");
    };
    let [body, bottom] = Layout::vertical([Constraint::Fill(1), Constraint::Length(1)]).areas(area);
    let [_, chart] = Layout::horizontal([Constraint::Length(LABELS), Constraint::Fill(1)]).areas(body);
    if chart.width < 10 || chart.height < 3 {
        return;
    }
    draw_grid(frame.buffer_mut(), ChartAxes { x, y, chart }, bottom.y, theme, "f (Hz)");
    let columns = f64::from(chart.width) * 2.0;
    let canvas = Canvas::default().marker(Marker::Braille).x_bounds([x.low, x.high]).y_bounds([y.low, y.high]);
    frame.render_widget(
        canvas.paint(|context| {
            for (axis, points) in &curves {
                let color = Theme::colour_of(theme.axis(*axis));
                let logs: Vec<(f64, f64)> =
                    points.iter().filter(|(_, y)| *y > 0.0).map(|(x, y)| (x.log10(), y.log10())).collect();
                // the points of one column of dots make one stroke
                let place = |at: f64| ((at - x.low) / (x.high - x.low) * columns) as u32;
                for pair in logs.windows(2) {
                    let [(x1, y1), (x2, y2)] = [pair[0], pair[1]];
                    if place(x1) == place(x2) {
                        context.draw(&Stroke { x1, y1, x2: x1, y2, color });
                    } else {
                        context.draw(&Stroke { x1, y1, x2, y2, color });
                    }
                }
                context.layer();
            }
        }),
        chart,
    );
}

fn segment_changes(theme: Theme, all: &[Series<'_>], unit: &ShownUnit) -> Vec<Line<'static>> {
    let of = |series: &Series<'_>| {
        let deviations: Vec<f64> = segments(series).iter().map(|(_, std)| *std * unit.factor).collect();
        let least = deviations.iter().copied().fold(f64::INFINITY, f64::min);
        let most = deviations.iter().copied().fold(0.0, f64::max);
        let text = match deviations.len() {
            0 => "no segment yet".into(),
            1 => digits(most, 3),
            count => format!("{} to {} in {count} segments", digits(least, 3), digits(most, 3)),
        };
        of_axis(theme, series, &text)
    };
    all.iter().map(of).collect()
}

/// Middle of each segment in seconds, and the standard deviation in it.
fn segments(series: &Series<'_>) -> Vec<(f64, f64)> {
    let blocks = series.channel.signal.as_ref().map_or(&[][..], |signal| &signal.blocks);
    blocks.iter().filter_map(|block| Some((block.start_s + block.duration_s / 2.0, block.std?))).collect()
}

fn draw_segments(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, all: &[Series<'_>], unit: &ShownUnit) {
    let of = |series: &Series<'_>| {
        (series.axis, segments(series).into_iter().map(|(at_s, std)| (at_s, std * unit.factor)).collect())
    };
    let curves: Vec<(usize, Vec<(f64, f64)>)> = all.iter().map(of).collect();
    let chart = LinearChart {
        curves: &curves,
        is_joined: true,
        why_empty: "The segments need some seconds of samples.",
        marks: scene.source.snapshot.marks.iter().map(|mark| mark.at_s).collect(),
    };
    chart.draw(frame, area, scene, time);
}

/// The means of the blocks of temperature, by the start of the block.
fn temperatures(source: &SourceView) -> Vec<(f64, f64)> {
    let channel = source.values.iter().find(|channel| channel.quantity == Quantity::Temperature);
    let signal = channel.and_then(|channel| channel.signal.as_ref());
    signal.map_or_else(Vec::new, |signal| signal.blocks.iter().map(|block| (block.start_s, block.mean)).collect())
}

fn draw_temperature(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, all: &[Series<'_>], unit: &ShownUnit) {
    let temperatures = temperatures(scene.source);
    let of = |series: &Series<'_>| {
        let blocks = series.channel.signal.as_ref().map_or(&[][..], |signal| &signal.blocks);
        // only blocks of the same time belong together
        let pairs = blocks.iter().filter_map(|block| {
            let (_, celsius) = temperatures.iter().find(|(start_s, _)| *start_s == block.start_s)?;
            Some((*celsius, block.mean * unit.factor))
        });
        let pairs: Vec<(f64, f64)> = pairs.collect();
        // biases that differ would make flat lines of all
        let mean = pairs.iter().map(|(_, mean)| mean).sum::<f64>() / pairs.len() as f64;
        (series.axis, pairs.into_iter().map(|(celsius, value)| (celsius, value - mean)).collect())
    };
    let curves: Vec<(usize, Vec<(f64, f64)>)> = all.iter().map(of).collect();
    let why = if temperatures.is_empty() {
        "This message holds no temperature: VNIMU does."
    } else {
        "The means need some seconds of samples."
    };
    let label = |celsius: f64| scene.theme.spelled(format!("{celsius:.2} °C"));
    LinearChart { curves: &curves, is_joined: false, why_empty: why, marks: Vec::new() }
        .draw(frame, area, scene, label);
}

fn coefficients(theme: Theme, all: &[Series<'_>], unit: &ShownUnit) -> Vec<Line<'static>> {
    let of = |series: &Series<'_>| {
        let temperature = series.channel.noise.as_ref().and_then(|noise| noise.temperature.as_ref());
        let text = match temperature.map(|temperature| (&temperature.coefficient, temperature.is_proved)) {
            Some((Ok(found), is_proved)) => {
                let [value, lower, upper] =
                    [found.value, found.lower, found.upper].map(|value| digits(value * unit.factor, 2));
                let proved = if is_proved { "" } else { ", not significant" };
                format!("{value} {}/°C [{lower}, {upper}]{proved}", unit.name)
            }
            Some((Err(_), _)) => "no coefficient: the record does not show one".into(),
            None => "no coefficient".into(),
        };
        of_axis(theme, series, &text)
    };
    all.iter().map(of).collect()
}

/// Points on two linear axes, labelled at their ends.
struct LinearChart<'a> {
    /// The axis of the sensor, and its points.
    curves: &'a [(usize, Vec<(f64, f64)>)],
    /// The points follow each other, with lines between them.
    is_joined: bool,
    why_empty: &'static str,
    /// Places on the horizontal axis that the user marked.
    marks: Vec<f64>,
}

impl LinearChart<'_> {
    fn draw(&self, frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, label: impl Fn(f64) -> String) {
        let (curves, theme) = (self.curves, scene.theme);
        let points = || curves.iter().flat_map(|(_, points)| points);
        let over = |values: &mut dyn Iterator<Item = f64>| {
            let (low, high) =
                values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
            if high > low { (low, high) } else { (low - 0.5, high + 0.5) }
        };
        if points().next().is_none() {
            return nothing(frame, area, theme, self.why_empty);
        }
        let (x_low, x_high) = over(&mut points().map(|(x, _)| *x));
        let (y_low, y_high) = over(&mut points().map(|(_, y)| *y));
        let labels = [y_low, y_high].map(|value| digits(value, 4));
        let width = labels.iter().map(String::len).max().unwrap_or(0) as u16 + 2;
        let [body, bottom] = Layout::vertical([Constraint::Fill(1), Constraint::Length(1)]).areas(area);
        let [left, chart] = Layout::horizontal([Constraint::Length(width), Constraint::Fill(1)]).areas(body);
        if chart.width < 10 || chart.height < 2 {
            return;
        }
        let [low, high] = labels;
        let at = |row: u16| Rect { y: row, height: 1, width: width.saturating_sub(1), ..left };
        for (row, text) in [(chart.bottom() - 1, low), (chart.y, high)] {
            frame.render_widget(Line::styled(text, theme.faint()).right_aligned(), at(row));
            let line = Span::styled("┈".repeat(chart.width.into()), theme.faint());
            frame.render_widget(Line::from(line), Rect { y: row, height: 1, ..chart });
        }
        let scale = Rect { x: chart.x, width: chart.width, ..bottom };
        frame.render_widget(Line::styled(label(x_low), theme.faint()), scale);
        frame.render_widget(Line::styled(label(x_high), theme.faint()).right_aligned(), scale);
        let canvas = Canvas::default().marker(Marker::Braille).x_bounds([x_low, x_high]).y_bounds([y_low, y_high]);
        frame.render_widget(
            canvas.paint(|context| {
                for (axis, points) in curves {
                    let color = Theme::colour_of(theme.axis(*axis));
                    context.draw(&Points { coords: points, color });
                    for pair in points.windows(2).filter(|_| self.is_joined) {
                        let [(x1, y1), (x2, y2)] = [pair[0], pair[1]];
                        context.draw(&Stroke { x1, y1, x2, y2, color });
                    }
                    context.layer();
                }
            }),
            chart,
        );
        let column = |x: f64| chart.x + ((x - x_low) / (x_high - x_low) * f64::from(chart.width - 1)).round() as u16;
        for mark in self.marks.iter().filter(|at| (x_low..=x_high).contains(*at)) {
            for row in chart.top()..chart.bottom() {
                put(frame.buffer_mut(), column(*mark), row, "┊", theme.warning());
            }
            put(frame.buffer_mut(), column(*mark), chart.top(), "m", theme.chosen());
        }
        // which curve is which, without colours, too
        for (axis, points) in curves {
            let Some((x, y)) = points.last() else { continue };
            let row = ((y_high - y) / (y_high - y_low) * f64::from(chart.height - 1)).round() as u16;
            let sign = SIGNS.get(*axis).unwrap_or(&"●");
            let style: Style = theme.axis(*axis);
            put(frame.buffer_mut(), column(*x), chart.y + row, sign, style);
        }
    }
}
