//! The spectrum of a sensor, which can take the place of the deviation, and the peaks of each axis.

use ratatui::{
    Frame,
    layout::{Constraint, Layout, Rect},
    text::Line,
    widgets::Paragraph,
};
use vn100_analysis::ChannelResult;
use vn100_report::{figure::spectrum, names::names_of, numbers::plain::digits, units::pretty_unit};

use crate::{
    panels::plot::{LEAST_ROWS, Plot},
    scene::{Scene, framed},
    state::Panel,
    theme::SIGNS,
};

/// Draws it in the frame of the panel of curves.
pub(crate) fn draw(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let Scene { source, state, theme, .. } = scene;
    let Some(group) = state.group(source) else { return };
    let (axes, channels) = state.shown(source, &group);
    let Some(first) = channels.first() else { return };
    let name = names_of(group.quantity).short;
    let title = theme.spelled(format!("Spectrum of the {name}, {}/√Hz one-sided", pretty_unit(&first.unit)));
    let inner = framed(frame, area, scene, Panel::Allan, title);
    let room = inner.height.saturating_sub(LEAST_ROWS);
    let peaks = axes.iter().zip(&channels).map(|(axis, channel)| peaks(scene, *axis, channel));
    let peaks: Vec<Line<'_>> = peaks.take(room.into()).collect();
    let [chart, below] = Layout::vertical([Constraint::Fill(1), Constraint::Length(peaks.len() as u16)]).areas(inner);
    frame.render_widget(Paragraph::new(peaks), below);
    match spectrum("axes", name, &channels) {
        Some(figure) => Plot { figure: &figure, axes: &axes, theme }.draw(frame, chart, &[], None),
        None => {
            let why = " The spectrum needs a segment of samples: wait some seconds.";
            frame.render_widget(Paragraph::new(why).style(theme.faint()), chart);
        }
    }
}

/// The strongest peaks of an axis, behind its sign.
fn peaks(scene: Scene<'_>, axis: usize, channel: &ChannelResult) -> Line<'static> {
    let mut lines: Vec<_> = channel.lines().iter().collect();
    lines.sort_by(|a, b| b.share_of_variance.total_cmp(&a.share_of_variance));
    let peak = |line: &&imu_noise::SpectralLine| {
        let (hz, amplitude) = (digits(line.frequency_hz, 3), digits(line.amplitude, 2));
        format!("{hz} Hz, amplitude {amplitude} ({:.0} % of the variance)", 100.0 * line.share_of_variance)
    };
    let text = lines.iter().take(2).map(peak).collect::<Vec<_>>().join("; ");
    let text = if text.is_empty() { "no peaks" } else { &text };
    let sign = SIGNS.get(axis).unwrap_or(&"●");
    Line::styled(scene.theme.spelled(format!(" {sign} {}: {text}", channel.name)), scene.theme.axis(axis))
}
