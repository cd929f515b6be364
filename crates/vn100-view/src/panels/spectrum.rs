//! The spectrum of a sensor, which can take the place of the deviation: the curves, and the peaks of
//! each axis.

use ratatui::{
    Frame,
    layout::{Constraint, Layout, Rect},
    symbols::Marker,
    text::Line,
    widgets::{
        Paragraph,
        canvas::{Canvas, Line as Stroke},
    },
};
use vn100_analysis::ChannelResult;
use vn100_report::{names::names_of, numbers::plain::digits};

use crate::{
    panels::{
        chart::{ChartAxes, LABELS, draw_grid},
        curve::LogAxis,
    },
    scene::{Scene, framed},
    source::ChannelGroup,
    state::Panel,
    theme::{SIGNS, Theme},
    units::ShownUnit,
};

/// An axis of the sensor that is drawn.
struct Series<'a> {
    axis: usize,
    channel: &'a ChannelResult,
}

fn series<'a>(scene: Scene<'a>, group: &ChannelGroup) -> Vec<Series<'a>> {
    let shown = |(axis, place): (usize, &usize)| {
        scene.state.is_shown(axis).then(|| Series { axis, channel: &scene.source.result.channels[*place] })
    };
    group.channels.iter().enumerate().filter_map(shown).collect()
}

/// Draws it in the frame of the panel of curves.
pub(crate) fn draw(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let Some(group) = scene.state.group(scene.source) else { return };
    let unit = ShownUnit::of(&scene.source.result.channels[group.channels[0]]);
    let (name, series) = (names_of(group.quantity).short, series(scene, &group));
    let title = scene.theme.spelled(format!("Spectrum of the {name}, {}/√Hz one-sided", unit.name));
    let inner = framed(frame, area, scene, Panel::Allan, title);
    let peaks = spectral_peaks(scene.theme, &series, &unit);
    let [chart, below] = Layout::vertical([Constraint::Fill(1), Constraint::Length(peaks.len() as u16)]).areas(inner);
    frame.render_widget(Paragraph::new(peaks), below);
    draw_spectrum(frame, chart, scene, &series, &unit);
}

/// A line of text for an axis, behind its sign.
fn of_axis(theme: Theme, series: &Series<'_>, text: &str) -> Line<'static> {
    let sign = SIGNS.get(series.axis).unwrap_or(&"●");
    Line::styled(theme.spelled(format!(" {sign} {}: {text}", series.channel.name)), theme.axis(series.axis))
}

fn spectral_peaks(theme: Theme, all: &[Series<'_>], unit: &ShownUnit<'_>) -> Vec<Line<'static>> {
    let of = |series: &Series<'_>| {
        let mut lines: Vec<_> = series.channel.lines().iter().collect();
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

fn draw_spectrum(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, all: &[Series<'_>], unit: &ShownUnit<'_>) {
    let theme = scene.theme;
    let density = |series: &Series<'_>| -> Vec<(f64, f64)> {
        let points = series.channel.spectrum.iter().flat_map(|spectrum| spectrum.points());
        points.map(|(frequency_hz, density)| (frequency_hz, density.sqrt() * unit.factor)).collect()
    };
    let curves: Vec<(usize, Vec<(f64, f64)>)> = all.iter().map(|series| (series.axis, density(series))).collect();
    let points = || curves.iter().flat_map(|(_, points)| points);
    let axes = LogAxis::over(points().map(|(x, _)| *x)).zip(LogAxis::over(points().map(|(_, y)| *y)));
    let Some((x, y)) = axes else {
        let why = " The spectrum needs a segment of samples: wait some seconds.";
        frame.render_widget(Paragraph::new(why).style(theme.faint()), area);
        return;
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
