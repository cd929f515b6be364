//! All channels in numbers, with the last minutes of each as a line of bars; and one of them in
//! time.

use ratatui::{
    Frame,
    layout::{Constraint, Layout, Rect},
    text::{Line, Span},
    widgets::{Paragraph, Row, Table},
};
use vn100_analysis::BlockValues;
use vn100_protocol::Quantity;
use vn100_report::{
    figure::last_minutes,
    numbers::plain::{fitted, time},
};

use crate::{
    panels::plot::Plot,
    scene::{Scene, framed},
    source::SourceView,
    state::Panel,
    units::ShownUnit,
};

pub(crate) fn draw_statistics(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let source = scene.source;
    let inner = framed(frame, area, scene, Panel::Statistics, "Statistics".into());
    let chosen = scene.state.channel(source);
    // the places of names, units and numbers; what is left belongs to the bars
    let longest = source.result.channels.iter().map(|channel| channel.name.len()).max().unwrap_or(0) as u16;
    let name = longest.clamp(8, if inner.width >= 100 { 24 } else { 11 });
    let widths = if inner.width >= 66 { [name, 6, 11, 10, 9, 9] } else { [name, 5, 10, 9, 8, 8] };
    let fixed = widths.iter().sum::<u16>() + widths.len() as u16;
    let bars = inner.width.saturating_sub(fixed);
    let axes: Vec<(usize, usize)> = (source.groups().iter())
        .flat_map(|group| group.channels.iter().copied().enumerate().collect::<Vec<_>>())
        .map(|(axis, channel)| (channel, axis))
        .collect();
    // what was asked for between the lines is no axis
    let mut polled: Vec<usize> = (axes.len()..source.result.channels.len()).collect();
    polled.sort_by_key(|place| {
        !matches!(source.result.channels[*place].quantity, Quantity::Temperature | Quantity::Pressure)
    });
    let placed: Vec<(usize, usize)> =
        axes.into_iter().chain(polled.into_iter().map(|place| (place, usize::MAX))).collect();
    let rows = placed.into_iter().map(|(place, axis)| {
        let channel = &source.result.channels[place];
        let unit = ShownUnit::of(channel);
        let number = |value: Option<f64>, decimals: usize, column: usize| {
            let text = value.map_or("-".into(), |value| fitted(value * unit.factor, decimals, widths[column].into()));
            Line::raw(text).right_aligned()
        };
        // averages resolve more than one sample
        let finer = unit.decimals + 2;
        let row = Row::new(vec![
            Line::from(Span::styled(channel.name.clone(), scene.theme.axis(axis))),
            Line::raw(scene.theme.spelled(unit.name)),
            number(channel.statistics.mean, finer, 2),
            number(channel.statistics.std, finer, 3),
            number(channel.statistics.min, unit.decimals, 4),
            number(channel.statistics.max, unit.decimals, 5),
            Line::from(Span::styled(source.sparkline(place, usize::from(bars)), scene.theme.axis(axis))),
        ]);
        if Some(place) == chosen { row.style(scene.theme.chosen()) } else { row }
    });
    let header = ["channel", "unit", "mean", "std", "min", "max"]
        .iter()
        .enumerate()
        .map(|(place, name)| if place < 2 { Line::raw(*name) } else { Line::raw(*name).right_aligned() });
    let recent = match bars {
        0..8 => "",
        8..12 => "recent",
        _ => "last minutes",
    };
    let header = header.chain([Line::raw(recent)]);
    let header = Row::new(header).style(scene.theme.faint());
    let widths = widths.into_iter().map(Constraint::Length).chain([Constraint::Length(bars)]);
    frame.render_widget(Table::new(rows, widths).column_spacing(1).header(header), inner);
}

/// Slots of the whole history.
const MOST_SLOTS: usize = 480;

/// The least columns of the signal, with the frame.
pub(crate) const SIGNAL_WIDTH: u16 = 44;

/// The last minutes of the channel that is chosen: the range of its samples, with the smallest and the
/// largest above.
pub(crate) fn draw_signal(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let Scene { source, state, theme, .. } = scene;
    let Some((group, place)) = state.group(source).zip(state.channel(source)) else { return };
    let channel = &source.result.channels[place];
    let ShownUnit { name, factor, decimals } = ShownUnit::of(channel);
    let title = theme.spelled(format!("Signal of {}, {name}", channel.name));
    let inner = framed(frame, area, scene, Panel::Signal, title);
    let [above, chart] = Layout::vertical([Constraint::Length(1), Constraint::Fill(1)]).areas(inner);
    let Some(mut history) = source.result.history(place, usize::from(chart.width), MOST_SLOTS) else { return };
    for BlockValues { min, max, mean, .. } in history.columns.iter_mut().flatten() {
        [*min, *max, *mean] = [*min * factor, *max * factor, *mean * factor];
    }
    let Some(figure) = last_minutes(&channel.name, name, &history) else { return };
    let columns = || history.columns.iter().flatten();
    let (low, high) = columns()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), column| (low.min(column.min), high.max(column.max)));
    let span_s = history.column_s * history.columns.len() as f64;
    let text = format!(" last {}: min {low:.decimals$}, max {high:.decimals$}", time(span_s));
    frame.render_widget(Paragraph::new(Line::styled(text, theme.faint())), above);
    let axis = group.channels.iter().position(|channel| *channel == place).unwrap_or(0);
    Plot { figure: &figure, axes: &[axis], theme }.draw(frame, chart, &[], None);
}

const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

impl SourceView {
    /// The means of the last minutes as bars, between the lowest and the highest of them.
    pub(crate) fn sparkline(&self, channel: usize, columns: usize) -> String {
        let Some(history) = (columns >= 8).then(|| self.result.history(channel, columns, usize::MAX)).flatten() else {
            return String::new();
        };
        let means = history.columns.iter().flatten().map(|column| column.mean);
        let (low, high) =
            means.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), mean| (low.min(mean), high.max(mean)));
        let bar = |column: &Option<BlockValues>| {
            column.map_or(' ', |column| {
                let height = (column.mean - low) / (high - low);
                BARS[if height.is_finite() { (height * 7.0).round() as usize } else { 3 }.min(7)]
            })
        };
        history.columns.iter().map(bar).collect()
    }
}
