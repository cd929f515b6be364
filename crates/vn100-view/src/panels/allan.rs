//! The deviation over averaging time, and a cursor that reads a point out.

use imu_noise::PowerLaw;
use ratatui::{
    Frame,
    layout::{Constraint, Layout, Rect},
    text::{Line, Span},
    widgets::Paragraph,
};
use vn100_analysis::ChannelResult;
use vn100_report::{
    figure::{At, deviations},
    health::next_octave,
    names::{deviation_name, names_of},
    numbers::plain::{digits, tau},
    shortened,
};

use crate::{
    panels::{
        parameters,
        plot::{LEAST_ROWS, Plot},
    },
    scene::{Scene, framed},
    state::Panel,
    theme::SIGNS,
    units::ShownUnit,
};

/// Columns of the name of the reference where room is short.
const SHORT_NAME: usize = 12;

/// Draws it; alone on the screen with a line of what is known of the noise.
pub(crate) fn draw(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, alone: bool) {
    let Scene { source, state, theme, .. } = scene;
    let Some(group) = state.group(source) else { return };
    let (axes, channels) = state.shown(source, &group);
    let Some(first) = channels.first() else { return };
    let unit = ShownUnit::of(first);
    let name = names_of(group.quantity).short;
    let title = format!("{} σ(τ) of the {name}, {}", deviation_name(source.result.settings().deviation), unit.name);
    let inner = framed(frame, area, scene, Panel::Allan, theme.spelled(title));
    let room = inner.height.saturating_sub(LEAST_ROWS);
    let legend = room.min(1);
    let room = usize::from(room - legend);
    let summary = if alone { parameters::summary(scene, &group) } else { None };
    let mut read_out = read_out(scene, &axes, &channels, &unit, inner.width);
    read_out.truncate(room.saturating_sub(summary.iter().len()));
    read_out.extend(summary);
    read_out.truncate(room);
    let rows = [Constraint::Length(legend), Constraint::Fill(1), Constraint::Length(read_out.len() as u16)];
    let [legend, chart, below] = Layout::vertical(rows).areas(inner);
    frame.render_widget(Paragraph::new(legend_line(scene, &axes, &channels, legend.width)), legend);
    frame.render_widget(Paragraph::new(read_out), below);
    let Some(figure) = deviations(&source.result, &channels) else {
        let is_empty = channels.iter().all(|channel| channel.allan.points.is_empty());
        let why =
            if is_empty { " The first point needs two samples." } else { " No deviation: the values are constant." };
        frame.render_widget(Paragraph::new(why).style(theme.faint()), chart);
        return;
    };
    let earlier = |(series, channel): (usize, &&ChannelResult)| {
        let points = source.reference.as_ref()?.curve(channel, source.result.settings().deviation)?;
        let at = |(tau_s, deviation): (f64, f64)| figure.place(tau_s, deviation * unit.factor);
        Some((series, points.into_iter().map(at).collect()))
    };
    let earlier: Vec<(usize, Vec<At>)> = channels.iter().enumerate().filter_map(earlier).collect();
    let octaves = longest(&channels);
    let cursor = state.octave(octaves).map(|octave| octaves[octave].tau_s);
    Plot { figure: &figure, axes: &axes, theme }.draw(frame, chart, &earlier, cursor);
}

/// The points of the curve with the most octaves.
fn longest<'a>(channels: &[&'a ChannelResult]) -> &'a [vn100_analysis::Point] {
    channels.iter().map(|channel| &channel.allan.points[..]).max_by_key(|points| points.len()).unwrap_or(&[])
}

/// Which sign is which axis, and when the next point comes; in fewer words where room is short.
fn legend_line(scene: Scene<'_>, axes: &[usize], channels: &[&ChannelResult], width: u16) -> Line<'static> {
    let whole = legend(scene, axes, channels, true);
    if whole.width() <= usize::from(width) { whole } else { legend(scene, axes, channels, false) }
}

fn legend(scene: Scene<'_>, axes: &[usize], channels: &[&ChannelResult], whole: bool) -> Line<'static> {
    let Scene { source, theme, .. } = scene;
    let mut spans = Vec::new();
    for (axis, channel) in axes.iter().zip(channels) {
        let sign = SIGNS.get(*axis).unwrap_or(&"●");
        // the sensor stands in the title
        let name = channel.name.rsplit('_').next().filter(|_| !whole).unwrap_or(&channel.name);
        spans.push(Span::styled(format!(" {sign} {name} "), theme.axis(*axis)));
    }
    let deviation = source.result.settings().deviation;
    let has_curve = |channel: &&ChannelResult| {
        source.reference.as_ref().is_some_and(|earlier| earlier.curve(channel, deviation).is_some())
    };
    if let Some(reference) = source.reference.as_ref().filter(|_| channels.iter().any(has_curve)) {
        let name = if whole { reference.name.clone() } else { shortened(&reference.name, SHORT_NAME) };
        spans.push(Span::styled(format!(" ┈ {name} "), theme.faint()));
    }
    if let Some(next) = next_octave(&source.result).filter(|_| !source.is_over()) {
        let (tau, when) = (tau(next.tau_s), next.when());
        let when = if whole { when } else { when.replace(" without a gap", " gapless") };
        spans.push(Span::styled(theme.spelled(format!(" next: τ {tau} s {when}")), theme.faint()));
    }
    Line::from(spans)
}

/// The values at the cursor; without the kind of noise, then the averages, where room is short.
fn read_out(
    scene: Scene<'_>,
    axes: &[usize],
    channels: &[&ChannelResult],
    unit: &ShownUnit<'_>,
    width: u16,
) -> Vec<Line<'static>> {
    let Some(octave) = scene.state.octave(longest(channels)) else { return Vec::new() };
    let line = |(axis, channel): (&usize, &&ChannelResult)| {
        let point = channel.allan.points.get(octave)?.times(unit.factor);
        let sign = SIGNS.get(*axis).unwrap_or(&"●");
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
        let lines = forms.map(|text| Line::styled(scene.theme.spelled(text), scene.theme.axis(*axis)));
        let [_, _, shortest] = &lines;
        let fitting = lines.iter().find(|line| line.width() <= usize::from(width));
        Some(fitting.unwrap_or(shortest).clone())
    };
    axes.iter().zip(channels).filter_map(line).collect()
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
