//! The deviation over averaging time, both logarithmic: points with their confidence bars, the
//! model, and a cursor that reads one out.

use imu_noise::PowerLaw;
use ratatui::{
    Frame,
    buffer::Buffer,
    layout::{Constraint, Layout, Rect},
    style::Color,
    symbols::Marker,
    text::{Line, Span},
    widgets::{
        Paragraph,
        canvas::{Canvas, Line as Stroke, Points},
    },
};
use vn100_report::{
    health::next_octave,
    names::{deviation_name, names_of},
    numbers::plain::{digits, tau},
};

use crate::{
    panels::{
        chart::{ChartAxes, LABELS, dense, draw_cursor, draw_grid, put},
        curve::{AllanCurve, AllanPlot, LogAxis, REFERENCE},
        parameters,
        sheet::SHEET,
        warnings::shortened,
    },
    scene::{Scene, framed},
    source::SourceView,
    state::Panel,
    theme::{SIGNS, Theme},
};

/// Columns of the name of the reference where room is short.
const SHORT_NAME: usize = 12;

/// Draws it; alone on the screen with a line of what is known of the noise.
pub(crate) fn draw(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, alone: bool) {
    let source = scene.source;
    let Some(group) = scene.state.group(source) else { return };
    let plot = AllanPlot::new(scene.state, source, &group);
    let deviation = deviation_name(plot.deviation);
    let title = format!("{deviation} σ(τ) of the {}, {}", names_of(group.quantity).short, plot.unit.name);
    let title = scene.theme.spelled(title);
    let inner = framed(frame, area, scene, Panel::Allan, title);
    let mut read_out = read_out(scene, &plot, inner.width);
    if alone {
        read_out.extend(parameters::summary(scene, &group));
    }
    let rows = [Constraint::Length(1), Constraint::Fill(1), Constraint::Length(read_out.len() as u16)];
    let [legend, chart, below] = Layout::vertical(rows).areas(inner);
    frame.render_widget(Paragraph::new(legend_line(scene.theme, source, &plot, legend.width)), legend);
    frame.render_widget(Paragraph::new(read_out), below);
    draw_chart(frame, chart, scene, &plot);
}

/// Which sign is which axis, and when the next point comes; in fewer words where room is short.
fn legend_line(theme: Theme, source: &SourceView, plot: &AllanPlot<'_>, width: u16) -> Line<'static> {
    let whole = legend(theme, source, plot, true);
    if whole.width() <= usize::from(width) { whole } else { legend(theme, source, plot, false) }
}

fn legend(theme: Theme, source: &SourceView, plot: &AllanPlot<'_>, whole: bool) -> Line<'static> {
    let mut spans = Vec::new();
    for curve in &plot.curves {
        let sign = SIGNS.get(curve.axis).unwrap_or(&"●");
        // the sensor stands in the title
        let axis = curve.name.rsplit('_').next().filter(|_| !whole).unwrap_or(&curve.name);
        spans.push(Span::styled(format!(" {sign} {axis} "), theme.axis(curve.axis)));
    }
    if plot.curves.iter().any(|curve| !curve.model.is_empty()) {
        let text = if whole { " ┈ model and terms " } else { " ┈ model " };
        spans.push(Span::styled(text, theme.faint()));
    }
    if let Some(reference) = source.reference.as_ref().filter(|_| plot.curves.iter().any(|c| c.reference.is_some())) {
        let name = if whole { reference.name.clone() } else { shortened(&reference.name, SHORT_NAME) };
        spans.push(Span::styled(format!(" {REFERENCE} {name} "), theme.faint()));
    }
    if plot.sheet.is_some() {
        spans.push(Span::styled(format!(" {SHEET} data sheet "), theme.faint()));
    }
    if let Some(next) = next_octave(&source.result).filter(|_| !source.is_over()) {
        let (tau, when) = (tau(next.tau_s), next.when());
        let when = if whole { when } else { when.replace(" without a gap", " gapless") };
        spans.push(Span::styled(theme.spelled(format!(" next: τ {tau} s {when}")), theme.faint()));
    }
    Line::from(spans)
}

/// The values at the cursor; without the kind of noise, then the averages, where room is short.
fn read_out(scene: Scene<'_>, plot: &AllanPlot<'_>, width: u16) -> Vec<Line<'static>> {
    let Some(octave) = scene.state.octave(plot.octaves()) else { return Vec::new() };
    let line = |curve: &AllanCurve| {
        let point = curve.points.get(octave)?;
        let sign = SIGNS.get(curve.axis).unwrap_or(&"●");
        let value = point.deviation.map_or("-".into(), |deviation| digits(deviation, 3));
        let interval = match (point.lower, point.upper) {
            (Some(lower), Some(upper)) => format!("[{}, {}]", digits(lower, 3), digits(upper, 3)),
            _ if point.deviation.is_some() => "no interval: too few averages".into(),
            _ => "no interval yet".into(),
        };
        let edf = point.edf.map_or(String::new(), |edf| format!("  {} averages", digits(edf, 2)));
        let kind = point.alpha.map_or(String::new(), |alpha| format!("  {}", noise_name(alpha)));
        let start = format!(" {sign} τ {:<8} σ {value:<8} {interval}", format!("{} s", tau(point.tau_s)));
        let forms = [format!("{start}{edf}{kind}"), format!("{start}{edf}"), start];
        let lines = forms.map(|text| Line::styled(scene.theme.spelled(text), scene.theme.axis(curve.axis)));
        let [_, _, shortest] = &lines;
        let fitting = lines.iter().find(|line| line.width() <= usize::from(width));
        Some(fitting.unwrap_or(shortest).clone())
    };
    plot.curves.iter().filter_map(line).collect()
}

/// The kind of noise by the exponent of its spectrum.
fn noise_name(alpha: i8) -> &'static str {
    match PowerLaw::nearest(alpha) {
        PowerLaw::WhitePhase => "quantisation or vibration",
        PowerLaw::FlickerPhase => "steep",
        PowerLaw::White => "white",
        PowerLaw::Flicker => "flicker",
        PowerLaw::RandomWalk => "random walk",
    }
}

fn draw_chart(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, plot: &AllanPlot<'_>) {
    let (state, theme) = (scene.state, scene.theme);
    let octaves = plot.octaves();
    let (Some(x), Some(octave)) = (LogAxis::over(plot.taus()), state.octave(octaves)) else {
        frame.render_widget(Paragraph::new(" The first point needs two samples.").style(theme.faint()), area);
        return;
    };
    let cursor_tau = octaves[octave].tau_s;
    let Some(y) = LogAxis::over(plot.deviations()) else {
        let text = " No deviation: the values are constant.";
        frame.render_widget(Paragraph::new(text).style(theme.faint()), area);
        return;
    };
    let [body, bottom] = Layout::vertical([Constraint::Fill(1), Constraint::Length(1)]).areas(area);
    let [_, chart] = Layout::horizontal([Constraint::Length(LABELS), Constraint::Fill(1)]).areas(body);
    if chart.width < 10 || chart.height < 4 {
        return;
    }
    let axes = ChartAxes { x, y, chart };
    draw_grid(frame.buffer_mut(), axes, bottom.y, theme, "τ (s)");
    draw_cursor(frame.buffer_mut(), axes, cursor_tau);
    let canvas = Canvas::default().marker(Marker::Braille).x_bounds([x.low, x.high]).y_bounds([y.low, y.high]);
    frame.render_widget(
        canvas.paint(|context| {
            for line in plot.lines() {
                let points: Vec<_> = dense(&line.points).into_iter().filter(|p| axes.within(*p)).collect();
                let of = |curve: &&AllanCurve| curve.reference.as_ref().is_some_and(|own| std::ptr::eq(own, line));
                let axis = plot.curves.iter().find(of).map(|curve| theme.axis(curve.axis));
                context.draw(&Points { coords: &points, color: Theme::colour_of(axis.unwrap_or(theme.faint())) });
            }
            context.layer();
            for (place, curve) in plot.curves.iter().enumerate() {
                let beside = axes.logarithm_of_columns(columns_beside(axes, &plot.curves, place));
                draw_curve(context, axes, curve, beside, Theme::colour_of(theme.axis(curve.axis)));
                context.layer();
            }
        }),
        chart,
    );
    draw_points(frame.buffer_mut(), axes, &plot.curves, theme, cursor_tau);
    draw_letters(frame.buffer_mut(), axes, plot, theme);
}

/// The columns by which the bars and signs of a curve stand beside their averaging time: where there
/// is room between the octaves, those of several axes stand side by side.
fn columns_beside(axes: ChartAxes, curves: &[AllanCurve], place: usize) -> i32 {
    let between = 2_f64.log10() / axes.logarithm_of_columns(1);
    if between > curves.len() as f64 { place as i32 - (curves.len() / 2) as i32 } else { 0 }
}

/// The curve, with its bars beside their averaging times by so much of the logarithm.
fn draw_curve(
    context: &mut ratatui::widgets::canvas::Context<'_>,
    axes: ChartAxes,
    curve: &AllanCurve,
    beside: f64,
    color: Color,
) {
    let logs: Vec<(f64, f64)> = (curve.points.iter())
        .filter_map(|point| Some((point.tau_s.log10(), point.deviation.filter(|d| *d > 0.0)?.log10())))
        .collect();
    for pair in logs.windows(2) {
        context.draw(&Stroke { x1: pair[0].0, y1: pair[0].1, x2: pair[1].0, y2: pair[1].1, color });
    }
    for point in &curve.points {
        if let (Some(lower), Some(upper)) = (point.lower.filter(|lower| *lower > 0.0), point.upper) {
            let (x, [low, high]) = (
                point.tau_s.log10() + beside,
                [lower, upper].map(|bound| bound.log10().clamp(axes.y.low, axes.y.high)),
            );
            context.draw(&Stroke { x1: x, y1: low, x2: x, y2: high, color });
        }
    }
}

/// The signs of the points, over arrows where a bar runs out of the chart. Where curves lie on each
/// other and there is no room side by side, their signs take turns from octave to octave: none of them hides behind the last.
fn draw_points(buffer: &mut Buffer, axes: ChartAxes, curves: &[AllanCurve], theme: Theme, cursor_tau: f64) {
    let octaves = curves.iter().map(|curve| curve.points.len()).max().unwrap_or(0);
    for octave in 0..octaves {
        let turn = |place: usize| (octave + place) % curves.len();
        let here = (0..curves.len()).map(turn).filter_map(|place| {
            let point = curves[place].points.get(octave)?;
            let column = axes.column(point.tau_s)?.checked_add_signed(columns_beside(axes, curves, place) as i16)?;
            Some((&curves[place], point, column))
        });
        for (curve, point, column) in here.clone() {
            if point.upper.is_some_and(|upper| upper.log10() > axes.y.high) {
                put(buffer, column, axes.chart.top(), "↑", theme.axis(curve.axis));
            }
            if point.lower.is_some_and(|lower| lower.log10() < axes.y.low) {
                put(buffer, column, axes.chart.bottom() - 1, "↓", theme.axis(curve.axis));
            }
        }
        for (curve, point, column) in here {
            let Some(row) = point.deviation.and_then(|deviation| axes.row(deviation)) else { continue };
            let style = theme.axis(curve.axis);
            let style = if point.tau_s == cursor_tau { style.patch(theme.chosen()) } else { style };
            put(buffer, column, row, SIGNS.get(curve.axis).unwrap_or(&"●"), style);
        }
    }
}

fn draw_letters(buffer: &mut Buffer, axes: ChartAxes, plot: &AllanPlot<'_>, theme: Theme) {
    for line in plot.lines() {
        let Some(letter) = line.term else { continue };
        // N is read at its left end, the others at their right
        let mut inside = line.points.iter().filter_map(|(t, d)| Some((axes.column(*t)?, axes.row(*d)?)));
        // that of the sheet beside the first point, which it must not hide
        let end = match letter {
            "N" => inside.next_back(),
            SHEET => inside.next().map(|(column, row)| (column + 2, row)),
            REFERENCE => inside.next_back().map(|(column, row)| (column.saturating_sub(1), row)),
            _ => inside.next(),
        };
        if let Some((column, row)) = end.filter(|(column, _)| *column < axes.chart.right()) {
            put(buffer, column, row, letter, theme.chosen());
        }
    }
}
