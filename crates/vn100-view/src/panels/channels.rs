//! All channels in numbers, with the last minutes of each as a line of bars; and one of them in
//! time.

use ratatui::{
    Frame,
    layout::{Constraint, Layout, Rect},
    style::Color,
    symbols::Marker,
    text::{Line, Span},
    widgets::{
        Paragraph, Row, Table,
        canvas::{Canvas, Line as Stroke},
    },
};
use vn100_analysis::{ChannelResult, History, HistoryColumn};
use vn100_protocol::Quantity;
use vn100_report::numbers::plain::{fitted, time};

use crate::{
    scene::{Scene, framed},
    source::SourceView,
    state::Panel,
    theme::Theme,
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

pub(crate) fn draw_signal(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let source = scene.source;
    let Some((group, place)) = scene.state.group(source).zip(scene.state.channel(source)) else { return };
    let channel = &source.result.channels[place];
    let unit = ShownUnit::of(channel);
    let title = scene.theme.spelled(format!("Signal of {}, {}", channel.name, unit.name));
    let inner = framed(frame, area, scene, Panel::Signal, title);
    let axis = group.channels.iter().position(|channel| *channel == place).unwrap_or(0);
    let color = Theme::colour_of(scene.theme.axis(axis));
    draw_history(frame, inner, scene, place, &unit, color);
}

/// Columns for the values of a channel at the left of a chart.
fn values_width(channel: &ChannelResult, unit: &ShownUnit<'_>) -> u16 {
    let width =
        |value: Option<f64>| value.map_or(0, |value| format!("{:.*}", unit.decimals, value * unit.factor).len());
    width(channel.statistics.min).max(width(channel.statistics.max)) as u16 + 1
}

fn draw_history(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, place: usize, unit: &ShownUnit<'_>, color: Color) {
    let (source, channel) = (scene.source, &scene.source.result.channels[place]);
    let (decimals, labels) = (unit.decimals, values_width(channel, unit));
    let rows = [Constraint::Length(1), Constraint::Fill(1), Constraint::Length(1)];
    let [title, chart, below] = Layout::vertical(rows).areas(area);
    let chart = Rect { x: chart.x + labels, width: chart.width.saturating_sub(labels), ..chart };
    let dots = usize::from(chart.width) * 2;
    let Some(mut history) = source.history(place, dots, MOST_SLOTS).filter(|history| !history.columns.is_empty())
    else {
        return;
    };
    history.columns.iter_mut().flatten().for_each(|column| {
        (column.min, column.max) = (column.min * unit.factor, column.max * unit.factor);
    });
    let columns = history.columns.iter().flatten();
    let (low, high) = columns
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), column| (low.min(column.min), high.max(column.max)));
    let span_s = history.column_s * history.columns.len() as f64;
    let text = format!(" last {}: min {low:.decimals$}, max {high:.decimals$}", time(span_s));
    frame.render_widget(Paragraph::new(Line::styled(text, scene.theme.faint())), title);
    let (low, high) = if high > low { (low, high) } else { (low - 1.0, high + 1.0) };
    let canvas =
        Canvas::default().marker(Marker::Braille).x_bounds([0.0, (dots.max(2) - 1) as f64]).y_bounds([low, high]);
    // as wide as there are columns for, the latest on the right
    let first = dots.saturating_sub(history.columns.len());
    let label = |value: f64| Line::styled(format!("{value:.decimals$}"), scene.theme.faint()).right_aligned();
    for (row, value) in labelled_rows(chart.height, low, high) {
        let at = Rect::new(area.x, chart.y + row, labels.saturating_sub(1), 1);
        frame.render_widget(label(value), at.intersection(area));
        // a line from the label through the chart: the value is that of its row
        let row = Rect::new(chart.x, chart.y + row, chart.width, 1).intersection(area);
        frame.render_widget(Line::styled("┈".repeat(row.width.into()), scene.theme.faint()), row);
    }
    let past = format!("{} ago", time(span_s));
    // a history that has just begun is shorter than its label
    let most_right = below.right().saturating_sub((past.chars().count() + " now".len()) as u16);
    let begin = Rect { x: (chart.x + (first / 2) as u16).min(most_right), ..below }.intersection(below);
    frame.render_widget(Line::styled(past, scene.theme.faint()), begin);
    frame.render_widget(Line::styled("now", scene.theme.faint()).right_aligned(), below);
    frame.render_widget(
        canvas.paint(|context| {
            for (at, column) in history.columns.iter().enumerate() {
                if let Some(column) = column {
                    let x = (first + at) as f64;
                    context.draw(&Stroke { x1: x, y1: column.min, x2: x, y2: column.max, color });
                }
            }
        }),
        chart,
    );
}

/// Rows of a chart with the values they stand for: the first, the last, and one between them where
/// there is room. A row has four dots, the first row begins with the highest value, and the last
/// row ends with the lowest.
fn labelled_rows(rows: u16, low: f64, high: f64) -> Vec<(u16, f64)> {
    if rows < 5 {
        return [(0, high), (rows.saturating_sub(1), low)].into_iter().take(usize::from(rows)).collect();
    }
    let middle = rows / 2;
    let part = (4.0 * f64::from(middle) + 1.5) / (4.0 * f64::from(rows) - 1.0);
    vec![(0, high), (middle, high - (high - low) * part), (rows - 1, low)]
}

const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

impl SourceView {
    /// The latest `most_slots` in at most `columns`, see [`History`].
    pub(crate) fn history(&self, channel: usize, columns: usize, most_slots: usize) -> Option<History> {
        self.result.history(channel, columns, most_slots)
    }

    /// The means of the last minutes as bars, between the lowest and the highest of them.
    pub(crate) fn sparkline(&self, channel: usize, columns: usize) -> String {
        let Some(history) = (columns >= 8).then(|| self.history(channel, columns, usize::MAX)).flatten() else {
            return String::new();
        };
        let means = history.columns.iter().flatten().map(|column| column.mean);
        let (low, high) =
            means.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), mean| (low.min(mean), high.max(mean)));
        let bar = |column: &Option<HistoryColumn>| {
            column.map_or(' ', |column| {
                let height = (column.mean - low) / (high - low);
                BARS[if height.is_finite() { (height * 7.0).round() as usize } else { 3 }.min(7)]
            })
        };
        history.columns.iter().map(bar).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_label_is_the_value_of_its_row() {
        assert_eq!(labelled_rows(0, 0.0, 1.0), []);
        assert_eq!(labelled_rows(2, 0.0, 1.0), [(0, 1.0), (1, 0.0)]);
        assert_eq!(labelled_rows(5, 0.0, 1.0), [(0, 1.0), (2, 0.5), (4, 0.0)], "as much above as below");
        let [_, (row, value), _] = labelled_rows(6, 0.0, 23.0)[..] else { panic!("no middle") };
        assert_eq!(row, 3);
        assert!((value - 9.5).abs() < 1e-9, "between the second and the third dot of the fourth row: {value}");
    }
}
